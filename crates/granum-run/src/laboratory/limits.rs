//! The densest and the loosest state of the grains of a case, each by a stated procedure.
//!
//! There is no state of grains that is the densest or the loosest by itself, as there is none in a soil laboratory: standards state
//! procedures. The ones used here, both at the mean stress of the preparation and with the relaxation of every sample:
//!
//! - **densest** (e_min): compression without friction, without resistance to rolling and without adhesion, then
//!   [`CYCLES`] cycles of axial strain of ± [`CYCLE_STRAIN`] at constant mean stress, still without friction;
//! - **loosest** (e_max): compression with the friction [`LOOSE_FRICTION`], the rolling friction [`LOOSE_ROLLING`] (or that of the
//!   contact law if it is larger), and an interface energy [`LOOSE_ADHESION`] times p d, which holds a contact with about
//!   five times the force p d² ("moist tamping"); at the end adhesion is taken away, the grains get their own friction and
//!   resistance to rolling, and the sample comes to rest under its mean stress. (Laws without JKR adhesion are compressed
//!   without it.)

use granum_dem::config::{AdhesionKind, NormalKind};
use granum_dem::observer::Observer;
use granum_io::{Case, RunRecord};

use super::{Laboratory, LaboratoryError};

/// Cycles of the densest state.
pub const CYCLES: u64 = 20;
/// Their amplitude of axial strain.
pub const CYCLE_STRAIN: f64 = 0.01;
/// Friction while the loosest state is compressed.
pub const LOOSE_FRICTION: f64 = 2.0;
/// Its smallest coefficient of rolling friction.
pub const LOOSE_ROLLING: f64 = 1.0;
/// Its interface energy over p d.
pub const LOOSE_ADHESION: f64 = 4.0;

/// The void ratios between which the grains of a case can be, by the procedures of this module.
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Limits {
    /// Void ratio e_min of the densest state.
    pub densest_void_ratio: f64,
    /// Void ratio e_max of the loosest state.
    pub loosest_void_ratio: f64,
    /// Records of the two samples, the densest first.
    pub records: [RunRecord; 2],
}

/// The case of the densest state.
pub fn densest(case: &Case) -> Case {
    let mut case = prepared(case);
    let p = &mut case.preparation;
    (p.friction, p.rolling_friction, p.interface_energy) = (Some(0.0), Some(0.0), 0.0);
    (p.cycles, p.cycle_strain) = (CYCLES, CYCLE_STRAIN);
    case
}

/// The case of the loosest state.
pub fn loosest(case: &Case) -> Case {
    let mut case = prepared(case);
    let diameter = case.grains.mean_diameter().unwrap_or(case.grains.diameter);
    let own = case.contact.parameters.given("rolling_friction").unwrap_or(0.0);
    let sticky = matches!(case.contact.normal, normal if normal == NormalKind::HERTZ || normal == NormalKind::JKR)
        && case.contact.adhesion == AdhesionKind::NONE;
    let p = &mut case.preparation;
    (p.friction, p.rolling_friction, p.cycles) = (Some(LOOSE_FRICTION), Some(own.max(LOOSE_ROLLING)), 0);
    // A case file can have no more than 100 J/m2.
    p.interface_energy = if sticky { (LOOSE_ADHESION * p.mean_stress * diameter).min(100.0) } else { 0.0 };
    case
}

/// The case without a target of density.
fn prepared(case: &Case) -> Case {
    let mut case = case.clone();
    let p = &mut case.preparation;
    (p.solid_fraction, p.void_ratio, p.relative_density) = (None, None, None);
    case
}

impl Laboratory {
    /// Finds the void ratios between which the grains of a case can be, by preparing a sample of each kind.
    ///
    /// # Errors
    /// [`LaboratoryError`] if a sample cannot be prepared, or the observer stops it.
    pub fn limits(&self, case: &Case, observer: &mut dyn Observer) -> Result<Limits, LaboratoryError> {
        let sample = |case: Case, observer: &mut dyn Observer| {
            case.check()?;
            self.sample(&case, observer)
        };
        let dense = sample(densest(case), observer)?;
        let loose = sample(loosest(case), observer)?;
        let void_ratio = |solid_fraction: f64| 1.0 / solid_fraction - 1.0;
        Ok(Limits {
            densest_void_ratio: void_ratio(dense.simulation.state().solid_fraction()),
            loosest_void_ratio: void_ratio(loose.simulation.state().solid_fraction()),
            records: [dense.about, loose.about],
        })
    }
}
