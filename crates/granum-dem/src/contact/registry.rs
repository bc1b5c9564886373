//! The laws that names in files refer to. To add one to granum, add its file and its line here.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{PoisonError, RwLock};

use serde::de::{Deserialize, Deserializer, Error};

use super::description::{Description, Parameter};
use super::kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
use super::limits::MOST_PARAMETERS;

/// granum's normal laws.
pub(super) const NORMAL: &[NormalKind] = &[
    NormalKind::HERTZ,
    NormalKind::JKR,
    NormalKind::HOOKE,
    NormalKind::DMT,
    NormalKind::JKR_DMT,
    NormalKind::ROUGH_HERTZ,
    NormalKind::LUDING,
];
/// granum's tangential laws.
pub(super) const TANGENTIAL: &[TangentialKind] =
    &[TangentialKind::MINDLIN_DERESIEWICZ, TangentialKind::NO_SLIP, TangentialKind::PEELING];
/// granum's moment laws.
pub(super) const ROLLING: &[RollingKind] = &[
    RollingKind::NONE,
    RollingKind::ELASTIC_PLASTIC,
    RollingKind::ELASTIC_PLASTIC_TWISTING,
    RollingKind::SPRING_DASHPOT_SLIDER,
];
/// granum's additional adhesion laws.
pub(super) const ADHESION: &[AdhesionKind] = &[
    AdhesionKind::NONE,
    AdhesionKind::CAPILLARY_BRIDGE,
    AdhesionKind::CAPILLARY_BRIDGE_FILMS,
    AdhesionKind::VAN_DER_WAALS,
];

/// A law that cannot be registered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RegisterError {
    /// Its name already belongs to another law.
    #[error("there is already a {what} {name:?}: give the new one another name")]
    NameTaken {
        /// The kind of law.
        what: &'static str,
        /// The name.
        name: &'static str,
    },
    /// A parameter of another law has the same key and another meaning.
    #[error("contact.{key} is already a parameter of another law: give the new one another key")]
    KeyTaken {
        /// The key.
        key: &'static str,
    },
    /// All laws together would have more than [`MOST_PARAMETERS`] parameters.
    #[error("all laws together can have at most {MOST_PARAMETERS} parameters")]
    TooMany,
}

/// Rejects parameters whose keys are taken, and more than [`MOST_PARAMETERS`] parameters.
fn check_parameters(new: &Description) -> Result<(), RegisterError> {
    let known = parameters();
    let taken = |p: &&Parameter| known.iter().any(|k| k.key == p.key && **k != **p);
    if let Some(parameter) = new.parameters.iter().find(taken) {
        return Err(RegisterError::KeyTaken { key: parameter.key });
    }
    let fresh = new.parameters.iter().filter(|p| known.iter().all(|k| k.key != p.key)).count();
    if known.len() + fresh > MOST_PARAMETERS { Err(RegisterError::TooMany) } else { Ok(()) }
}

/// How many laws were registered.
static REGISTERED: AtomicUsize = AtomicUsize::new(0);

/// Number of laws that the caller has registered so far: a list made from the registries is up to date as long as this number does
/// not change.
pub fn registered() -> usize {
    REGISTERED.load(Ordering::Acquire)
}

macro_rules! list {
    ($list:ident, $kind:ident, $what:literal, $own:ident, $all:ident, $register:ident, $named:ident) => {
        static $own: RwLock<Vec<$kind>> = RwLock::new(Vec::new());

        #[doc = concat!("Every ", $what, " with a name: granum's own, then those of [`", stringify!($register), "`].")]
        pub fn $all() -> Vec<$kind> {
            let own = $own.read().unwrap_or_else(PoisonError::into_inner);
            $list.iter().chain(own.iter()).copied().collect()
        }

        #[doc = concat!("Registers a ", $what, " of the caller for use in case files and checkpoints. To use it in a")]
        /// simulation this is not needed.
        ///
        /// # Errors
        /// If the name or the key of a parameter is taken, or there is no room for the parameters.
        pub fn $register(law: $kind) -> Result<(), RegisterError> {
            match $named(law.name()) {
                Some(known) if known == law => return Ok(()),
                Some(_) => return Err(RegisterError::NameTaken { what: $what, name: law.name() }),
                None => check_parameters(law.law().description())?,
            }
            $own.write().unwrap_or_else(PoisonError::into_inner).push(law);
            REGISTERED.fetch_add(1, Ordering::Release);
            Ok(())
        }

        #[doc = concat!("The ", $what, " with this name.")]
        pub fn $named(name: &str) -> Option<$kind> {
            $all().into_iter().find(|law| law.name() == name)
        }

        impl<'d> Deserialize<'d> for $kind {
            fn deserialize<D: Deserializer<'d>>(from: D) -> Result<$kind, D::Error> {
                let name = String::deserialize(from)?;
                $named(&name).ok_or_else(|| {
                    let known: Vec<_> = $all().iter().map($kind::name).collect();
                    D::Error::custom(format!(
                        concat!("there is no ", $what, " {:?}; there are: {}"),
                        name,
                        known.join(", ")
                    ))
                })
            }
        }
    };
}
list!(NORMAL, NormalKind, "normal law", OWN_NORMAL, normal_laws, register_normal, normal_named);
list!(
    TANGENTIAL,
    TangentialKind,
    "tangential law",
    OWN_TANGENTIAL,
    tangential_laws,
    register_tangential,
    tangential_named
);
list!(ROLLING, RollingKind, "law of moments", OWN_ROLLING, rolling_laws, register_rolling, rolling_named);
list!(
    ADHESION,
    AdhesionKind,
    "law of adhesion",
    OWN_ADHESION,
    adhesion_laws,
    register_adhesion,
    adhesion_named
);

/// The descriptions of all laws that a name can refer to.
fn descriptions() -> Vec<&'static Description> {
    let normal = normal_laws().into_iter().map(|law| law.law().description());
    let tangential = tangential_laws().into_iter().map(|law| law.law().description());
    let rolling = rolling_laws().into_iter().map(|law| law.law().description());
    let adhesion = adhesion_laws().into_iter().map(|law| law.law().description());
    normal.chain(tangential).chain(rolling).chain(adhesion).collect()
}

/// The parameters of all laws that names can refer to, each key once.
pub fn parameters() -> Vec<&'static Parameter> {
    let mut all: Vec<&'static Parameter> = Vec::new();
    for parameter in descriptions().into_iter().flat_map(|d| d.parameters) {
        if all.iter().all(|known| known.key != parameter.key) {
            all.push(parameter);
        }
    }
    all
}

/// The laws that have a parameter, as a condition: "with rolling = \"elastic-plastic\"".
pub fn laws_with(parameter: &Parameter) -> String {
    let has = |d: &Description| d.parameters.iter().any(|known| known.key == parameter.key);
    let mut names = Vec::new();
    let mut list = |slot: &str, d: &Description| {
        if has(d) {
            names.push(format!("{slot} = {:?}", d.name));
        }
    };
    normal_laws().iter().for_each(|law| list("normal", law.law().description()));
    tangential_laws().iter().for_each(|law| list("tangential", law.law().description()));
    rolling_laws().iter().for_each(|law| list("rolling", law.law().description()));
    adhesion_laws().iter().for_each(|law| list("adhesion", law.law().description()));
    format!("with {}", names.join(" or "))
}
