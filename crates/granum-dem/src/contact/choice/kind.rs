//! The choice of a law as a value that can be copied and compared, made from one of granum's laws or from a law of the caller.

use std::fmt;
use std::hash::{Hash, Hasher};

use crate::contact::law::{AdhesionLaw, MomentLaw, NormalLaw, TangentialLaw};
use crate::contact::slot::slot_traits::{AdhesionSlot, MomentSlot, NormalSlot, TangentialSlot};
use crate::contact::{adhesion, normal, rolling, tangential};

/// A law behind a pointer. A law of granum is reached through a variable of this crate: its code is then compiled here and not once more
/// in every crate that names the law.
enum Held<S: ?Sized + 'static> {
    Own(&'static &'static S),
    Given(&'static S),
}

impl<S: ?Sized> Held<S> {
    fn law(&self) -> &'static S {
        match self {
            Held::Own(law) => law,
            Held::Given(law) => law,
        }
    }
}

impl<S: ?Sized> Clone for Held<S> {
    fn clone(&self) -> Held<S> {
        *self
    }
}

impl<S: ?Sized> Copy for Held<S> {}

/// The choice of a law as a value that can be copied and compared; the name identifies it in files. To add a law to granum, add its
/// file, and its line to the list of its kind.
macro_rules! kind {
    ($kind:ident, $slot:ident, $law:ident, $what:literal, $($name:ident = $type:path,)*) => {
        #[doc = concat!("A choice of ", $what, ", identified in files by its name.")]
        #[derive(Clone, Copy)]
        pub struct $kind(Held<dyn $slot>);

        impl $kind {
            $(
                #[doc = concat!("[`", stringify!($type), "`].")]
                pub const $name: $kind = {
                    static LAW: &dyn $slot = &$type;
                    $kind(Held::Own(&LAW))
                };
            )*

            /// Those that come with granum.
            pub(super) const OWN: &'static [$kind] = &[$($kind::$name),*];

            #[doc = concat!("The choice of a ", $what, ", which may be defined by the caller.")]
            pub const fn new(law: &'static impl $law) -> $kind {
                $kind(Held::Given(law))
            }

            /// The chosen law.
            pub fn law(&self) -> &'static dyn $slot {
                self.0.law()
            }

            /// Its name in case files, e.g. `hertz`.
            pub fn name(&self) -> &'static str {
                self.law().description().name
            }

            /// Its name in reports.
            pub fn label(&self) -> &'static str {
                self.law().description().label
            }
        }

        impl PartialEq for $kind {
            fn eq(&self, other: &$kind) -> bool {
                self.law().id() == other.law().id() && self.name() == other.name()
            }
        }
        impl Eq for $kind {}
        impl Hash for $kind {
            fn hash<H: Hasher>(&self, state: &mut H) {
                self.name().hash(state);
            }
        }
        impl fmt::Debug for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
        impl fmt::Display for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }
        impl serde::Serialize for $kind {
            fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
                to.serialize_str(self.name())
            }
        }
    };
}

kind! {
    NormalKind, NormalSlot, NormalLaw, "normal law",
    HERTZ = normal::Hertz,
    JKR = normal::Jkr,
    HOOKE = normal::Hooke,
    DMT = normal::Dmt,
    JKR_DMT = normal::JkrDmt,
    ROUGH_HERTZ = normal::RoughHertz,
    LUDING = normal::Luding,
}
kind! {
    TangentialKind, TangentialSlot, TangentialLaw, "tangential law",
    MINDLIN_DERESIEWICZ = tangential::MindlinDeresiewicz,
    NO_SLIP = tangential::NoSlip,
    PEELING = tangential::Peeling,
}
kind! {
    RollingKind, MomentSlot, MomentLaw, "law of contact moments",
    NONE = rolling::NoMoments,
    ELASTIC_PLASTIC = rolling::ElasticPlasticRolling,
    ELASTIC_PLASTIC_TWISTING = rolling::ElasticPlasticTwisting,
    SPRING_DASHPOT_SLIDER = rolling::SpringDashpotSlider,
}
kind! {
    AdhesionKind, AdhesionSlot, AdhesionLaw, "law of additional adhesion",
    NONE = adhesion::NoAdhesion,
    CAPILLARY_BRIDGE = adhesion::CapillaryBridge,
    CAPILLARY_BRIDGE_FILMS = adhesion::CapillaryBridgeFilms,
    VAN_DER_WAALS = adhesion::VanDerWaals,
}
