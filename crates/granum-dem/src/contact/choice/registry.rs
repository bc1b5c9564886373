//! The laws that names in files refer to: granum's own, and those that a program adds with [`Laws::with`].

use granum_core::RegistrationError;
use serde::de::{Deserialize, Deserializer, Error};

use super::kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
use crate::bond::law::kind::BondKind;
use crate::contact::law::description::{LawDescription, LawParameter};
use crate::contact::law::energy_channel::{EnergyChannel, TAKEN_KEYS};
use crate::contact::law::limits::MOST_PARAMETERS;

/// granum's normal laws.
pub(super) const NORMAL: &[NormalKind] = NormalKind::OWN;
/// granum's tangential laws.
pub(super) const TANGENTIAL: &[TangentialKind] = TangentialKind::OWN;
/// granum's moment laws.
pub(super) const ROLLING: &[RollingKind] = RollingKind::OWN;
/// granum's additional adhesion laws.
pub(super) const ADHESION: &[AdhesionKind] = AdhesionKind::OWN;

/// A law of any kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Law {
    /// A normal law.
    Normal(NormalKind),
    /// A tangential law.
    Tangential(TangentialKind),
    /// A law of moments.
    Rolling(RollingKind),
    /// A law of adhesion.
    Adhesion(AdhesionKind),
}

impl Law {
    /// Its name, parameters and help.
    pub fn description(&self) -> &'static LawDescription {
        match self {
            Law::Normal(law) => law.law().description(),
            Law::Tangential(law) => law.law().description(),
            Law::Rolling(law) => law.law().description(),
            Law::Adhesion(law) => law.law().description(),
        }
    }

    /// Its energy channels.
    pub fn channels(&self) -> &'static [EnergyChannel] {
        match self {
            Law::Normal(law) => law.law().channels(),
            Law::Tangential(law) => law.law().channels(),
            Law::Rolling(law) => law.law().channels(),
            Law::Adhesion(law) => law.law().channels(),
        }
    }

    /// What it is, in messages.
    pub fn what(&self) -> &'static str {
        match self {
            Law::Normal(_) => "normal law",
            Law::Tangential(_) => "tangential law",
            Law::Rolling(_) => "law of moments",
            Law::Adhesion(_) => "law of adhesion",
        }
    }

    /// Its key in the section `[contact]` of a case file.
    pub fn slot(&self) -> &'static str {
        match self {
            Law::Normal(_) => "normal",
            Law::Tangential(_) => "tangential",
            Law::Rolling(_) => "rolling",
            Law::Adhesion(_) => "adhesion",
        }
    }
}

/// The contact laws of a program, by their names in files: those of granum, and those that the program adds.
///
/// ```
/// use granum_dem::contact::choice::registry::Laws;
/// use granum_dem::config::NormalKind;
///
/// let laws = Laws::standard();
/// assert_eq!(laws.normal_named("hertz"), Some(NormalKind::HERTZ));
/// // A law that is there already is no harm.
/// assert_eq!(laws.clone().with(NormalKind::HERTZ), Ok(laws));
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Laws {
    normal: Vec<NormalKind>,
    tangential: Vec<TangentialKind>,
    rolling: Vec<RollingKind>,
    adhesion: Vec<AdhesionKind>,
    bonds: Vec<BondKind>,
}

impl Default for Laws {
    fn default() -> Laws {
        Laws::standard()
    }
}

impl Laws {
    /// The laws of granum.
    pub fn standard() -> Laws {
        Laws {
            normal: NORMAL.to_vec(),
            tangential: TANGENTIAL.to_vec(),
            rolling: ROLLING.to_vec(),
            adhesion: ADHESION.to_vec(),
            bonds: BondKind::OWN.to_vec(),
        }
    }

    /// Every law of bonds, granum's own first.
    pub fn bonds(&self) -> &[BondKind] {
        &self.bonds
    }

    /// The law of bonds with this name.
    pub fn bond_named(&self, name: &str) -> Option<BondKind> {
        self.bonds.iter().copied().find(|law| law.name() == name)
    }

    /// Adds a law of bonds for use in case files and checkpoints.
    ///
    /// # Errors
    /// If the name is taken.
    pub fn with_bond(mut self, law: BondKind) -> Result<Laws, RegistrationError> {
        let names = self.bonds.iter().map(BondKind::name);
        RegistrationError::check_name("law of bonds", law.name(), names)?;
        self.bonds.push(law);
        Ok(self)
    }

    /// Adds a law for use in case files and checkpoints. To use it in a simulation this is not needed.
    ///
    /// # Errors
    /// If the name or the key of a parameter or of an energy channel is taken, or there is no room for the parameters.
    pub fn with(mut self, law: impl Into<Law>) -> Result<Laws, RegistrationError> {
        let law = law.into();
        let all = self.all();
        let of_its_kind = || all.iter().filter(|known| known.slot() == law.slot());
        if of_its_kind().any(|known| *known == law) {
            return Ok(self);
        }
        let names = of_its_kind().map(|known| known.description().name);
        RegistrationError::check_name(law.what(), law.description().name, names)?;
        self.check_parameters(&law)?;
        self.check_channels(&law)?;
        match law {
            Law::Normal(law) => self.normal.push(law),
            Law::Tangential(law) => self.tangential.push(law),
            Law::Rolling(law) => self.rolling.push(law),
            Law::Adhesion(law) => self.adhesion.push(law),
        }
        Ok(self)
    }

    /// All laws: normal laws, tangential laws, laws of moments, laws of adhesion.
    pub fn all(&self) -> Vec<Law> {
        let normal = self.normal.iter().copied().map(Law::Normal);
        let tangential = self.tangential.iter().copied().map(Law::Tangential);
        let rolling = self.rolling.iter().copied().map(Law::Rolling);
        let adhesion = self.adhesion.iter().copied().map(Law::Adhesion);
        normal.chain(tangential).chain(rolling).chain(adhesion).collect()
    }

    /// The parameters of all laws, each key once.
    pub fn parameters(&self) -> Vec<&'static LawParameter> {
        let mut all: Vec<&'static LawParameter> = Vec::new();
        for parameter in self.all().iter().flat_map(|law| law.description().parameters) {
            if all.iter().all(|known| known.key != parameter.key) {
                all.push(parameter);
            }
        }
        all
    }

    /// The energy channels of all laws, each key once.
    pub fn channels(&self) -> Vec<&'static EnergyChannel> {
        let mut all: Vec<&'static EnergyChannel> = Vec::new();
        for channel in self.all().iter().flat_map(|law| law.channels()) {
            if all.iter().all(|known| known.key != channel.key) {
                all.push(channel);
            }
        }
        all
    }

    /// The laws that have a parameter, as a condition: "with rolling = \"elastic-plastic\"".
    pub fn laws_with(&self, parameter: &LawParameter) -> String {
        let has = |law: &Law| law.description().parameters.iter().any(|known| known.key == parameter.key);
        let named = |law: Law| format!("{} = {:?}", law.slot(), law.description().name);
        let names: Vec<String> = self.all().into_iter().filter(has).map(named).collect();
        format!("with {}", names.join(" or "))
    }

    /// Rejects energy channels whose keys are taken or malformed.
    fn check_channels(&self, law: &Law) -> Result<(), RegistrationError> {
        let (what, name) = (law.what(), law.description().name);
        let (known, new) = (self.channels(), law.channels());
        for (k, channel) in new.iter().enumerate() {
            let (key, part) = (channel.key, "energy channel");
            if !channel.has_good_key() {
                let reason = "must be words in lower case joined by underscores, of which the last is \"loss\" where energy is \
                              dissipated, or \"energy\" where it is stored";
                return Err(RegistrationError::Key {
                    what,
                    name: name.into(),
                    part,
                    key: key.into(),
                    reason,
                });
            }
            let another = |other: &&EnergyChannel| other.key == key && **other != *channel;
            let twice = new[..k].iter().any(|other| other.key == key);
            let is_taken = twice || TAKEN_KEYS.contains(&key) || known.iter().any(another);
            RegistrationError::check_key(what, name, part, key, is_taken)?;
        }
        Ok(())
    }

    /// Rejects parameters whose keys are taken, and more than [`MOST_PARAMETERS`] parameters.
    fn check_parameters(&self, law: &Law) -> Result<(), RegistrationError> {
        let (what, new) = (law.what(), law.description());
        let known = self.parameters();
        for parameter in new.parameters {
            let is_taken = known.iter().any(|k| k.key == parameter.key && **k != *parameter);
            RegistrationError::check_key(what, new.name, "parameter", parameter.key, is_taken)?;
        }
        let fresh = new.parameters.iter().filter(|p| known.iter().all(|k| k.key != p.key)).count();
        if known.len() + fresh <= MOST_PARAMETERS {
            return Ok(());
        }
        let reason = format!("all laws together can have at most {MOST_PARAMETERS} parameters");
        Err(RegistrationError::Declaration { what, name: new.name.into(), reason })
    }
}

macro_rules! list {
    ($list:ident, $variant:ident, $kind:ident, $what:literal, $field:ident, $named:ident) => {
        impl From<$kind> for Law {
            fn from(law: $kind) -> Law {
                Law::$variant(law)
            }
        }

        impl Laws {
            #[doc = concat!("Every ", $what, ", granum's own first.")]
            pub fn $field(&self) -> &[$kind] {
                &self.$field
            }

            #[doc = concat!("The ", $what, " with this name.")]
            pub fn $named(&self, name: &str) -> Option<$kind> {
                self.$field.iter().copied().find(|law| law.name() == name)
            }
        }

        /// By its name: one of granum's own laws.
        impl<'d> Deserialize<'d> for $kind {
            fn deserialize<D: Deserializer<'d>>(from: D) -> Result<$kind, D::Error> {
                let name = String::deserialize(from)?;
                let found = $list.iter().copied().find(|law| law.name() == name);
                found.ok_or_else(|| D::Error::custom(unknown($what, &name, $list.iter().map($kind::name))))
            }
        }
    };
}
list!(NORMAL, Normal, NormalKind, "normal law", normal, normal_named);
list!(TANGENTIAL, Tangential, TangentialKind, "tangential law", tangential, tangential_named);
list!(ROLLING, Rolling, RollingKind, "law of moments", rolling, rolling_named);
list!(ADHESION, Adhesion, AdhesionKind, "law of adhesion", adhesion, adhesion_named);

/// The message about a name that is not among the known ones.
pub(crate) fn unknown<'n>(what: &str, name: &str, known: impl Iterator<Item = &'n str>) -> String {
    format!("there is no {what} {name:?}; there are: {}", known.collect::<Vec<_>>().join(", "))
}
