//! The one place where a law's name meets its type. To add a law: its file, its kind in [`crate::config`], its
//! line here.

use crate::config::{Contact, NormalKind, TangentialKind};

use super::hertz::Hertz;
use super::jkr::Jkr;
use super::mindlin_deresiewicz::MindlinDeresiewicz;
use super::no_slip::NoSlip;
use super::peeling::Peeling;
use super::{NormalLaw, TangentialLaw};

/// Every pair of laws that can be used together.
pub const ALL: [(NormalKind, TangentialKind); 5] = [
    (NormalKind::Hertz, TangentialKind::MindlinDeresiewicz),
    (NormalKind::Hertz, TangentialKind::NoSlip),
    (NormalKind::Jkr, TangentialKind::MindlinDeresiewicz),
    (NormalKind::Jkr, TangentialKind::NoSlip),
    (NormalKind::Jkr, TangentialKind::Peeling),
];

/// Something to be done with a pair of laws, compiled for each pair.
pub trait LawVisitor {
    /// What it returns.
    type Output;
    /// Does it with the normal law `N` and the tangential law `T`.
    fn visit<N: NormalLaw, T: TangentialLaw>(self) -> Self::Output;
}

/// Runs the visitor with the laws of these names.
pub fn with_law<V: LawVisitor>(normal: NormalKind, tangential: TangentialKind, visitor: V) -> V::Output {
    match normal {
        NormalKind::Hertz => with_tangential::<V, Hertz>(tangential, visitor),
        NormalKind::Jkr => with_tangential::<V, Jkr>(tangential, visitor),
    }
}

fn with_tangential<V: LawVisitor, N: NormalLaw>(tangential: TangentialKind, visitor: V) -> V::Output {
    match tangential {
        TangentialKind::MindlinDeresiewicz => visitor.visit::<N, MindlinDeresiewicz>(),
        TangentialKind::NoSlip => visitor.visit::<N, NoSlip>(),
        TangentialKind::Peeling => visitor.visit::<N, Peeling>(),
    }
}

/// A pair of laws that cannot be used together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LawError {
    /// Peeling needs an adhesive normal law.
    #[error(
        "tangential law `peeling` describes adhesive contacts and needs the normal law `jkr`, not `hertz`"
    )]
    PeelingWithoutAdhesion,
}

/// Refuses laws that do not go together.
pub fn check(contact: &Contact) -> Result<(), LawError> {
    match (contact.normal, contact.tangential) {
        (NormalKind::Hertz, TangentialKind::Peeling) => Err(LawError::PeelingWithoutAdhesion),
        _ => Ok(()),
    }
}
