//! How many steps a case takes, estimated before it is run, so that a case of a thousand times the usual work is noticed before and not
//! after a night.
//!
//! A step takes `dt = f sqrt(m / k)` for a contact of the smallest grains that carries `p d^2`, and an inertial number I strains the
//! sample at `I sqrt(p / rho) / d`. The compaction from the loose initial state is a strain of about 0.3; a stage of a test goes to the
//! strain at which it ends. Stages that end elsewhere are not counted, nor the trials of a search for a density.

use granum_dem::contact::PairProperties;
use granum_dem::loading::{Drive, Measure, Speed, Stage, Until};
use granum_io::Case;

/// Strain of a compaction.
const COMPACTION: f64 = 0.3;
/// A number of steps that is so many times the usual one is a reason for a warning.
const MANY_TIMES: f64 = 100.0;

/// Estimates of the steps of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RunEstimate {
    /// Steps of one trial of the preparation.
    pub preparation: f64,
    /// Steps of the test.
    pub test: f64,
}

/// What follows from the grains, their laws and a stress.
struct Scales {
    time_step: f64,
    /// Strain rate at an inertial number of one, 1/s.
    rate: f64,
}

impl Scales {
    fn at_stress(case: &Case, mean_stress: f64) -> Option<Scales> {
        let [smallest, _] = case.grains.size_range().ok()?;
        let diameter = case.grains.mean_diameter().ok()?;
        let components = &case.grains.mixture.components;
        let material = components.first().map_or(&case.grains.material, |component| &component.material);
        let side = (material, 0.5 * smallest);
        let pair = PairProperties::new(side, side, case.contact.damping);
        let [_, stiffness] = case.contact.stiffness_under(&pair, mean_stress * diameter * diameter);
        // The mass of one of two equal grains.
        let time_step = case.numerics.time_step_factor * (2.0 * pair.effective_mass / stiffness).sqrt();
        let rate = (mean_stress / material.density).sqrt() / diameter;
        let is_usable = time_step > 0.0 && time_step.is_finite() && rate > 0.0;
        is_usable.then_some(Scales { time_step, rate })
    }

    fn steps(&self, strain: f64, rate: f64) -> f64 {
        strain / (rate * self.time_step)
    }
}

/// Estimates the steps of a case; `None` where it cannot be done.
pub fn estimate(case: &Case) -> Option<RunEstimate> {
    let p = &case.preparation;
    let compacted = Scales::at_stress(case, p.compaction_stress.unwrap_or(p.mean_stress))?;
    let preparation = compacted.steps(COMPACTION, p.inertial_number * compacted.rate);
    let test = case.test_definition();
    let tested = Scales::at_stress(case, test.mean_stress(p.mean_stress))?;
    let test = test.stages.iter().map(|stage| stage_steps(stage, &tested)).sum();
    Some(RunEstimate { preparation, test })
}

/// Steps of a stage that ends at a strain; none for others.
fn stage_steps(stage: &Stage, scales: &Scales) -> f64 {
    let rate = match stage.control.speed {
        Speed::InertialNumber { number, .. } => number * scales.rate,
        Speed::StrainRate(rate) => rate * stage.density_scaling.sqrt(),
    };
    let fastest = stage.control.components.iter().fold(0.0f64, |most, drive| match drive {
        Drive::Rate(multiple) => most.max(multiple.abs()),
        _ => most,
    });
    let strain = stage.until.iter().find_map(|until| match until {
        Until::Reaches { measure, value } if is_strain(*measure) => Some(value.abs()),
        _ => None,
    });
    match strain {
        Some(strain) if fastest > 0.0 && rate > 0.0 => scales.steps(strain, rate * fastest),
        _ => 0.0,
    }
}

fn is_strain(measure: Measure) -> bool {
    matches!(
        measure,
        Measure::ArcLength
            | Measure::Strain(_)
            | Measure::AxialDeviatorStrain
            | Measure::VolumetricStrain
            | Measure::DeviatoricStrain
    )
}

/// A sentence for the user if a case takes a hundred times the steps of a new case file or more.
pub(crate) fn warning(case: &Case, prepares: bool, tests: bool) -> Option<String> {
    let (own, usual) = (estimate(case)?, estimate(&Case::default())?);
    let parts = [
        (prepares, "compaction of its sample", own.preparation, usual.preparation),
        (tests, "test", own.test, usual.test),
    ];
    let long = parts.into_iter().filter(|(is_made, _, own, usual)| *is_made && *own >= MANY_TIMES * usual);
    let long: Vec<String> = long
        .map(|(_, name, own, usual)| {
            format!(
                "the {name} takes about {own:.1e} steps, {:.0} times those of a new case file",
                own / usual
            )
        })
        .collect();
    if long.is_empty() {
        return None;
    }
    Some(format!(
        "{}: the smaller the stress against the stiffness of the grains, or the inertial number, the more; a larger inertial number or \
         softer grains need fewer",
        long.join("; ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(text: &str) -> Case {
        Case::parse(text, "case").unwrap()
    }

    #[test]
    fn a_new_case_is_usual_and_a_thousandth_of_a_pascal_is_not() {
        let usual = estimate(&Case::default()).unwrap();
        assert!(usual.preparation > 1e4 && usual.preparation < 1e6, "{usual:?}");
        assert!(usual.test > 1e5 && usual.test < 1e7, "{usual:?}");
        assert_eq!(warning(&Case::default(), true, true), None);
        let soft = case("preparation.mean_stress = '0.001 Pa'\ngrains.count = 50");
        let text = warning(&soft, true, true).unwrap();
        assert!(
            text.contains("the compaction of its sample takes about") && text.contains("the test takes"),
            "{text}"
        );
        assert_eq!(warning(&soft, false, false), None);
        // A slow test of an ordinary sample.
        let slow = case("shear.inertial_number = 1e-6");
        let text = warning(&slow, true, true).unwrap();
        assert!(text.starts_with("the test takes") && text.contains(" 364 times"), "{text}");
    }

    /// A preset's stages: the steps are those of its strain.
    #[test]
    fn stages_count_up_to_the_strain_at_which_they_end() {
        let of = |strain: f64| {
            let stage = format!(
                "[[stage]]\npath = 'drained-triaxial'\naxial_strain = {strain}\ninertial_number = 1e-3\n"
            );
            estimate(&case(&stage)).unwrap().test
        };
        assert!((of(0.2) / of(0.1) - 2.0).abs() < 1e-9 && of(0.1) > 1e4, "{}", of(0.1));
    }
}
