//! Which parts of an [`Assembly`](crate::Assembly) are known: data of another program rarely have all of them.

/// A part of an [`Assembly`](crate::Assembly) that data may have or lack.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Part {
    /// Edges of the periodic cell.
    Cell,
    /// Positions of the grains.
    Positions,
    /// Radii of the grains.
    Radii,
    /// Masses of the grains.
    Masses,
    /// Fluctuating velocities of the grains.
    Velocities,
    /// Angular velocities of the grains.
    Spins,
    /// Resultant contact force on each grain.
    ResultantForces,
    /// Which grains touch: the pairs, with branch and normal.
    Contacts,
    /// Overlap of each contact.
    Overlaps,
    /// Elastic normal force of each contact.
    NormalForces,
    /// Elastic tangential force of each contact.
    TangentialForces,
    /// Which contacts slide.
    Sliding,
    /// Elastic energy of each contact.
    ContactEnergies,
    /// Strain of the cell since the start.
    Strain,
    /// Velocity gradient of the cell.
    StrainRate,
    /// Time since the start.
    Time,
    /// Mean stress that the boundary is driven to.
    TargetMeanStress,
    /// Work of the boundary and losses since the start.
    EnergyBalance,
    /// Liquid in films on grains and in bridges.
    Liquid,
    /// Bonds that hold and that ruptured.
    Bonds,
}

impl Part {
    /// Every part.
    pub const ALL: [Part; 20] = [
        Part::Cell,
        Part::Positions,
        Part::Radii,
        Part::Masses,
        Part::Velocities,
        Part::Spins,
        Part::ResultantForces,
        Part::Contacts,
        Part::Overlaps,
        Part::NormalForces,
        Part::TangentialForces,
        Part::Sliding,
        Part::ContactEnergies,
        Part::Strain,
        Part::StrainRate,
        Part::Time,
        Part::TargetMeanStress,
        Part::EnergyBalance,
        Part::Liquid,
        Part::Bonds,
    ];

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Part::Cell => "cell",
            Part::Positions => "positions",
            Part::Radii => "radii",
            Part::Masses => "masses",
            Part::Velocities => "velocities",
            Part::Spins => "spins",
            Part::ResultantForces => "resultant forces on grains",
            Part::Contacts => "contacts",
            Part::Overlaps => "overlaps",
            Part::NormalForces => "normal forces",
            Part::TangentialForces => "tangential forces",
            Part::Sliding => "sliding contacts",
            Part::ContactEnergies => "energies of contacts",
            Part::Strain => "strain",
            Part::StrainRate => "strain rate",
            Part::Time => "time",
            Part::TargetMeanStress => "target mean stress",
            Part::EnergyBalance => "energy balance",
            Part::Liquid => "liquid in films and bridges",
            Part::Bonds => "bonds",
        }
    }
}

/// A set of [`Part`]s.
///
/// ```
/// use granum_core::{Part, Parts};
///
/// let packing = Parts::new(&[Part::Cell, Part::Positions, Part::Radii]);
/// assert!(packing.has(Part::Radii));
/// assert_eq!(packing.missing(&[Part::Radii, Part::Contacts]), [Part::Contacts]);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Parts(u32);

impl Parts {
    /// Every part, as granum's own runs have them.
    pub fn all() -> Parts {
        Parts::new(&Part::ALL)
    }

    /// These parts.
    pub fn new(parts: &[Part]) -> Parts {
        parts.iter().fold(Parts::default(), |set, part| set.with(*part))
    }

    /// The same set and one part more.
    pub fn with(self, part: Part) -> Parts {
        Parts(self.0 | 1 << part as u32)
    }

    /// True if the part is in the set.
    pub fn has(self, part: Part) -> bool {
        self.0 & 1 << part as u32 != 0
    }

    /// Those of the wanted parts that are not in the set.
    pub fn missing(self, wanted: &[Part]) -> Vec<Part> {
        wanted.iter().copied().filter(|part| !self.has(*part)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_part_stands_for_itself_alone() {
        for part in Part::ALL {
            let set = Parts::default().with(part);
            let found: Vec<Part> = Part::ALL.into_iter().filter(|other| set.has(*other)).collect();
            assert_eq!(found, [part]);
            assert!(Parts::all().has(part) && !part.name().is_empty());
        }
    }
}
