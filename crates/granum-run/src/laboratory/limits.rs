//! The densest and the loosest state of the grains of a case, each by a stated procedure.
//!
//! The densest and the loosest state of grains depend on the procedure by which they are prepared; standards for soil laboratories
//! therefore prescribe procedures. Those used here, both at the mean stress of the preparation and with the relaxation of every
//! sample:
//!
//! - **densest** (e_min): compression without friction, without resistance to rolling and without adhesion, then
//!   [`CYCLES`] cycles of axial strain of ± [`CYCLE_STRAIN`] at constant mean stress, still without friction;
//! - **loosest** (e_max): compression from a dispersed state with the grains' own friction and resistance to rolling, without
//!   adhesion other than that of their contact law, at [`LOOSE_STRESS`] times the mean stress, to which the sample is then brought.
//!
//! They are the ends of the line of procedures along which a target density is sought ([`granum_dem::preparation`]).
//!
//! Looser states exist as long as attraction, or more friction than the grains' own, supports them; when that is removed they
//! collapse to denser states than the above (measured in the book).

use granum_dem::observer::SimulationObserver;
use granum_io::run::{RunKind, RunStatus};
use granum_io::{Case, RunRecord};

use super::{Laboratory, LaboratoryError, RunResult, Source};

/// Number of cycles of the densest state.
pub const CYCLES: u64 = 20;
/// Their amplitude of axial strain.
pub const CYCLE_STRAIN: f64 = 0.01;
/// Mean stress of the compaction of the loosest state, relative to that of the preparation.
pub const LOOSE_STRESS: f64 = 1e-2;
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
    let friction = case.grains.mean_friction();
    let attraction = case.grains.material.interface_energy;
    let p = &mut case.preparation;
    (p.friction, p.rolling_friction, p.cycles) = (Some(friction), None, 0);
    p.compaction_stress = Some(LOOSE_STRESS * p.mean_stress);
    // With an adhesive normal law the adhesion acts from the start.
    p.interface_energy = if case.contact.normal.law().traits().adhesive { attraction } else { 0.0 };
    case
}

/// The case without a target of density.
fn prepared(case: &Case) -> Case {
    let mut case = case.clone();
    let p = &mut case.preparation;
    (p.solid_fraction, p.void_ratio, p.relative_density, p.compaction_stress) = (None, None, None, None);
    // The limits are defined by their procedures alone.
    case.preparation_stages.clear();
    case
}

impl Laboratory {
    /// Finds the void ratios between which the grains of a case can be, by preparing a sample of each kind.
    ///
    /// # Errors
    /// [`LaboratoryError`] if a sample cannot be prepared, or the observer stops it.
    pub fn limits(
        &self,
        case: &Case,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Limits, LaboratoryError> {
        let sample = |case: Case, observer: &mut dyn SimulationObserver| {
            case.check()?;
            let sample = self.plan(RunKind::Sample, &case, &Source::Case, observer)?.in_memory(observer)?;
            match sample.about.status {
                RunStatus::Interrupted => Err(LaboratoryError::Stopped { phase: sample.about.phase }),
                _ => Ok(sample),
            }
        };
        let dense = sample(densest(case), observer)?;
        let loose = sample(loosest(case), observer)?;
        let void_ratio = |sample: &RunResult| -> Result<f64, LaboratoryError> {
            Ok(1.0 / sample.simulation()?.state().solid_fraction() - 1.0)
        };
        Ok(Limits {
            densest_void_ratio: void_ratio(&dense)?,
            loosest_void_ratio: void_ratio(&loose)?,
            records: [dense.about, loose.about],
        })
    }
}

#[cfg(test)]
mod tests {
    use granum_dem::observer::NoObserver;

    use super::*;

    /// The two limits enclose the void ratios that the search for a friction can reach, and a sample has the relative density
    /// that was specified.
    #[test]
    fn a_relative_density_lies_between_the_limits() {
        let text = "grains.count = 200\ngrains.material.youngs_modulus = '5 GPa'\ngrains.material.friction = 0.5\ncontact.normal = 'hertz'\n\
                    contact.tangential = 'no-slip'\npreparation.mean_stress = '100 kPa'\npreparation.unbalanced_force = 1e-2\n\
                    preparation.inertial_number = 5e-3";
        let mut case = Case::parse(text, "case").unwrap();
        let laboratory = Laboratory::here();
        let limits = laboratory.limits(&case, &mut NoObserver).unwrap();
        let (dense, loose) = (limits.densest_void_ratio, limits.loosest_void_ratio);
        assert!(dense > 0.45 && dense < 0.6 && loose > dense + 0.08 && loose < 0.85, "{dense} {loose}");
        case.set("preparation.densest_void_ratio", &dense.to_string()).unwrap();
        case.set("preparation.loosest_void_ratio", &loose.to_string()).unwrap();
        let tolerance = case.preparation.solid_fraction_tolerance * 1.7f64.powi(2) / (loose - dense);
        for wanted in [0.0, 0.5, 1.0] {
            case.set("preparation.relative_density", &wanted.to_string()).unwrap();
            let sample = laboratory.plan(RunKind::Sample, &case, &Source::Case, &mut NoObserver).unwrap();
            let sample = sample.in_memory(&mut NoObserver).unwrap();
            let density = sample.about.measures["relative_density"];
            assert!((density - wanted).abs() <= 1.1 * tolerance, "{density} {wanted} {tolerance}");
        }
    }
}
