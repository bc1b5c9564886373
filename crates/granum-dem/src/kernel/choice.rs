//! The choice of the contact stage for a set of laws.
//!
//! Common sets are compiled into one loop, for equal grains and for unequal ones; all others use one loop that calls each
//! law through its slot.

use std::marker::PhantomData;
use std::ops::Range;

use granum_simd::{dispatch, dispatch_or};

use super::contacts::ContactStage;
use super::laws::{AnyLaws, InLoop, StageLaws};
use super::source::{Alike, AlikeOrByBatch, ByBatch, ConstantSource};
use super::views::Views;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::kind::{NormalKind, RollingKind, TangentialKind};
use crate::contact::normal::{Hertz, Jkr};
use crate::contact::rolling::{ElasticPlasticRolling, SpringDashpotSlider};
use crate::contact::tangential::{MindlinDeresiewicz, NoSlip, Peeling};

/// The contact stage over a range of blocks.
pub(crate) type ContactStageFunction = fn(&Views, Range<usize>);

/// The contact stages of a set: for equal grains and for unequal ones.
#[derive(Clone, Copy)]
pub(crate) struct ContactStages {
    pub(crate) alike: ContactStageFunction,
    pub(crate) by_batch: ContactStageFunction,
}

/// The stage of laws that are compiled into the loop. On a processor without vector instructions the loop over slots is used
/// instead, which gives the same bits: compiled scalar loops would be most of the code, and would hardly ever run.
fn stage<S: StageLaws, C: ConstantSource>(views: &Views, blocks: Range<usize>) {
    let kernel = ContactStage { views, blocks, laws: PhantomData::<(S, C)> };
    dispatch_or(views.isa, kernel, |kernel| slots(views, kernel.blocks));
}

/// The stage that calls laws through their slots. Sets without moments have a faster loop of their own, except on a processor
/// without vector instructions and in unit tests, for the reason given at [`ContactStages::for_laws`].
fn slots(views: &Views, blocks: Range<usize>) {
    if cfg!(test) || views.laws.rolling.law().acts() {
        slots_with_moments(views, blocks);
    } else {
        let kernel = ContactStage { views, blocks, laws: PhantomData::<(AnyLaws<false>, AlikeOrByBatch)> };
        dispatch_or(views.isa, kernel, |kernel| slots_with_moments(views, kernel.blocks));
    }
}

/// The stage that calls laws through their slots and works with every set.
fn slots_with_moments(views: &Views, blocks: Range<usize>) {
    let laws = PhantomData::<(AnyLaws<true>, AlikeOrByBatch)>;
    dispatch(views.isa, ContactStage { views, blocks, laws });
}

fn compiled<S: StageLaws>() -> ContactStages {
    ContactStages { alike: stage::<S, Alike>, by_batch: stage::<S, ByBatch> }
}

impl ContactStages {
    /// The stages of a given set. In the unit tests of this crate all laws are called through their slots, which gives the same
    /// bits: compiling the other loops again would take most of the time that building these tests takes. The tests in the
    /// folder `tests` run all loops.
    pub(crate) fn for_laws(laws: &ContactModel) -> ContactStages {
        if cfg!(test) {
            return ContactStages::any();
        }
        const HERTZ: NormalKind = NormalKind::HERTZ;
        const JKR: NormalKind = NormalKind::JKR;
        const CURVES: TangentialKind = TangentialKind::MINDLIN_DERESIEWICZ;
        const NO_SLIP: TangentialKind = TangentialKind::NO_SLIP;
        type Choice = (NormalKind, TangentialKind, fn() -> ContactStages);
        let sets: [Choice; 5] = [
            (HERTZ, CURVES, compiled::<InLoop<false, Hertz, MindlinDeresiewicz>>),
            (HERTZ, NO_SLIP, compiled::<InLoop<false, Hertz, NoSlip>>),
            (JKR, CURVES, compiled::<InLoop<false, Jkr, MindlinDeresiewicz>>),
            (JKR, NO_SLIP, compiled::<InLoop<false, Jkr, NoSlip>>),
            (JKR, TangentialKind::PEELING, compiled::<InLoop<false, Jkr, Peeling>>),
        ];
        let known = sets.iter().find(|(n, t, _)| *n == laws.normal && *t == laws.tangential);
        match known {
            Some((_, _, stages)) if laws.has_contact_only() => stages(),
            _ if laws.normal == HERTZ && laws.tangential == NO_SLIP && rolls(laws) => {
                // For equal grains only: each loop costs time to compile.
                type Growing = InLoop<true, Hertz, NoSlip, ElasticPlasticRolling>;
                type Constant = InLoop<true, Hertz, NoSlip, SpringDashpotSlider>;
                let constant = laws.rolling == RollingKind::SPRING_DASHPOT_SLIDER;
                let alike: ContactStageFunction =
                    if constant { stage::<Constant, Alike> } else { stage::<Growing, Alike> };
                ContactStages { alike, by_batch: slots }
            }
            _ => ContactStages::any(),
        }
    }

    /// The stages that work with any set.
    pub(crate) fn any() -> ContactStages {
        ContactStages { alike: slots, by_batch: slots }
    }
}

/// True for a set whose only law in addition to the contact laws is the resistance to rolling.
fn rolls(laws: &ContactModel) -> bool {
    let compiled = [RollingKind::ELASTIC_PLASTIC, RollingKind::SPRING_DASHPOT_SLIDER];
    compiled.contains(&laws.rolling) && !laws.adhesion.law().acts()
}
