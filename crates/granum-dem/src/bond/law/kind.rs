//! The choice of a law of bonds as a value that can be copied and compared.

use std::fmt;

use super::additive::AdditiveBond;
use super::beam::BeamBond;
use super::bond_law::BondLaw;
use super::parallel::ParallelBond;

/// A law of bonds, identified in files by its name.
#[derive(Clone, Copy)]
pub struct BondKind(&'static dyn BondLaw);

impl BondKind {
    /// [`ParallelBond`].
    pub const PARALLEL: BondKind = BondKind(&ParallelBond);
    /// [`BeamBond`].
    pub const BEAM: BondKind = BondKind(&BeamBond);
    /// [`AdditiveBond`].
    pub const ADDITIVE: BondKind = BondKind(&AdditiveBond);

    /// Those that come with granum.
    pub const OWN: &'static [BondKind] = &[BondKind::PARALLEL, BondKind::BEAM, BondKind::ADDITIVE];

    /// The choice of a law that may be defined by the caller.
    pub const fn new(law: &'static dyn BondLaw) -> BondKind {
        BondKind(law)
    }

    /// The chosen law.
    pub fn law(&self) -> &'static dyn BondLaw {
        self.0
    }

    /// Its name in case files, e.g. `parallel`.
    pub fn name(&self) -> &'static str {
        self.0.description().name
    }

    /// Its name in reports.
    pub fn label(&self) -> &'static str {
        self.0.description().label
    }
}

impl PartialEq for BondKind {
    fn eq(&self, other: &BondKind) -> bool {
        self.name() == other.name()
    }
}
impl Eq for BondKind {}

impl fmt::Debug for BondKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}
impl fmt::Display for BondKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl serde::Serialize for BondKind {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}

/// By its name: one of granum's own laws.
impl<'d> serde::Deserialize<'d> for BondKind {
    fn deserialize<D: serde::Deserializer<'d>>(from: D) -> Result<BondKind, D::Error> {
        let name = String::deserialize(from)?;
        let known = || BondKind::OWN.iter().map(BondKind::name);
        let found = BondKind::OWN.iter().find(|law| law.name() == name).copied();
        found.ok_or_else(|| {
            let known = known().collect::<Vec<_>>().join(", ");
            serde::de::Error::custom(format!("there is no law of bonds {name:?}; there are: {known}"))
        })
    }
}
