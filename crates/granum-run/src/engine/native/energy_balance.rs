//! The energy balance of a test.

use granum_core::assembly::Assembly;
use serde::{Deserialize, Serialize};

/// Kinetic and elastic energy of an assembly, J.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct StoredEnergy {
    kinetic: f64,
    elastic_normal: f64,
}

impl StoredEnergy {
    pub(super) fn from_assembly(assembly: &Assembly) -> StoredEnergy {
        StoredEnergy {
            kinetic: assembly.kinetic_energy(),
            elastic_normal: assembly.contacts.iter().map(|c| c.normal_energy).sum::<f64>()
                + attraction_energy(assembly)
                + assembly.bonds.iter().map(|bond| bond.energy).sum::<f64>(),
        }
    }
}

/// Energy of attraction at contacts and between grains that do not touch, J.
fn attraction_energy(assembly: &Assembly) -> f64 {
    assembly.contacts.iter().chain(&assembly.apart).map(|pair| pair.attraction_energy).sum()
}

/// Relative gap of the energy balance: the work of the boundary is compared with the sum of the stored energy and of the
/// losses by friction, damping and adhesion.
pub(super) fn energy_gap(before: &StoredEnergy, end: &Assembly) -> f64 {
    let after = StoredEnergy::from_assembly(end);
    let e = &end.energy;
    let stored = after.kinetic - before.kinetic + after.elastic_normal - before.elastic_normal;
    // The work of the tangential forces includes their elastic energy, which need not be separated here.
    // What a law stores in a channel is accounted for like what it dissipates.
    let accounted = e.accounted(stored);
    // If hardly any work is done, as in a cell at rest, the gap is compared with the stored energy.
    let measure = e.boundary_work.abs().max(HARDLY_ANY * before.elastic_normal.abs());
    if measure == 0.0 { 0.0 } else { ((e.boundary_work - accounted) / measure).abs() }
}

/// Ratio of the boundary work to the elastic energy before the test below which the work counts as hardly any.
const HARDLY_ANY: f64 = 1e-3;
