//! Checks that a run will not pass, told from its case before it is run.
//!
//! - `inertial_number`: a stage strains its sample at an inertial number that is taken at the mean stress at its start, and the number
//!   falls with the root of the mean stress while that grows. Its mean over the recorded states is estimated by how the stage is
//!   driven; where even the largest growth that is possible leaves it above the limit, it is certain.
//! - `time_step_fraction`: a time step that is chosen beyond the limit of stability.
//! - `largest_overlap`: a contact under the mean stress p carries about `p d^2`, and the largest one several times as much.

use granum_dem::config::MOST_CONTACTS;
use granum_dem::loading::{Constraint, Drive, Measure, Speed, Stage, Until};
use granum_io::Case;

use super::flags::{LARGEST_INERTIAL_NUMBER, LARGEST_OVERLAP};
use crate::strength::symmetry;

/// A check that a run of a case is not expected to pass.
#[derive(Clone, Debug, PartialEq)]
pub struct ForeseenFailure {
    /// The check, as in [`CHECKS`](super::CHECKS).
    pub check: &'static str,
    /// The value that is expected.
    pub value: f64,
    /// The largest acceptable value.
    pub limit: f64,
    /// True if the case leaves no other outcome; else the value is an estimate.
    pub is_certain: bool,
    /// What to change.
    pub advice: String,
}

impl ForeseenFailure {
    /// A sentence for the user.
    pub fn sentence(&self) -> String {
        let ForeseenFailure { value, limit, advice, .. } = self;
        let will = if self.is_certain { "will not pass" } else { "is not expected to pass" };
        let name = self.check.replace('_', " ");
        format!(
            "this case {will} its check of {name}: about {value:.3e} where at most {limit:.3e} is accepted; {advice}"
        )
    }
}

/// The checks that a test of a case will not pass, or is not expected to.
///
/// ```
/// use granum_io::Case;
/// use granum_run::engine::foreseen_failures;
///
/// let at = |number: f64| {
///     let text = format!("[[stage]]\npath = 'constant-p'\ninertial_number = {number}\n");
///     Ok::<_, granum_io::Error>(foreseen_failures(&Case::parse(&text, "case.toml")?))
/// };
/// assert!(at(1e-3)?.is_empty());
/// assert!(at(1e-2)?[0].is_certain && at(1e-2)?[0].check == "inertial_number");
/// # Ok::<(), granum_io::Error>(())
/// ```
pub fn foreseen_failures(case: &Case) -> Vec<ForeseenFailure> {
    [inertial_number(case), time_step(case), overlap(case)].into_iter().flatten().collect()
}

/// How an inertial number changes over a stage: its mean over the states and its least value, relative to that at the start.
struct Change {
    mean: f64,
    least: f64,
}

/// Mean of the inertial number of a compression with lateral stresses that are held, relative to that at its start: q/p of about 1.1
/// raises p by three fifths.
const OF_COMPRESSION: f64 = 0.8;
/// Least value of the same: p grows to 2.5 times its value at most, as q/p of 1.8 would raise it.
const LEAST_OF_COMPRESSION: f64 = 0.63;
/// Mean of it in extension, in which p falls.
const OF_EXTENSION: f64 = 1.15;

fn change(stage: &Stage, mean_stress: f64) -> Change {
    let control = &stage.control;
    let holds_p = |c: &Constraint| {
        c.stress[..3] == [c.stress[0]; 3]
            && c.stress[0] != 0.0
            && c.strain == [0.0; 6]
            && c.target.rate == 0.0
            && c.target.ramp.is_none()
    };
    if control.constraints.iter().flatten().any(holds_p) {
        return Change { mean: 1.0, least: 1.0 };
    }
    if symmetry::is_oedometric(stage) {
        return of_compression_to(end_stress(stage).map(|end| end / mean_stress));
    }
    let is_constant =
        |drive: Drive| matches!(drive, Drive::Stress(target) if target.rate == 0.0 && target.ramp.is_none());
    let [axial, y, z, ..] = control.components;
    match axial {
        Drive::Rate(rate) if is_constant(y) && is_constant(z) && rate > 0.0 => {
            Change { mean: OF_COMPRESSION, least: LEAST_OF_COMPRESSION }
        }
        Drive::Rate(_) if is_constant(y) && is_constant(z) => Change { mean: OF_EXTENSION, least: 1.0 },
        // The mean stress may grow to any value.
        _ => Change { mean: 1.0, least: 0.0 },
    }
}

/// Of a compression to a multiple of the stress along the line of compression, on which strain grows with the logarithm of stress.
fn of_compression_to(ratio: Option<f64>) -> Change {
    let Some(ratio) = ratio.filter(|ratio| *ratio > 0.0 && (ratio - 1.0).abs() > 1e-6) else {
        return Change { mean: 1.0, least: 0.0 };
    };
    let root = ratio.sqrt();
    let mean = 2.0 * (1.0 - 1.0 / root) / libm::log(ratio);
    Change { mean, least: (1.0 / root).min(1.0) }
}

/// The axial stress at which a stage ends.
fn end_stress(stage: &Stage) -> Option<f64> {
    stage.until.iter().find_map(|until| match until {
        Until::Reaches { measure: Measure::Stress(0), value } => Some(*value),
        _ => None,
    })
}

/// The mean stress to which a stage brings its sample, if it holds all three normal stresses.
fn rest_stress(stage: &Stage) -> Option<f64> {
    let value = |drive: &Drive| match drive {
        Drive::Stress(target) => target.value,
        _ => None,
    };
    let values: Option<Vec<f64>> = stage.control.components[..3].iter().map(value).collect();
    values.map(|values| values.iter().sum::<f64>() / 3.0)
}

/// Strain of unloading over that of loading by the same ratio of stresses.
const UNLOADING: f64 = 0.1;

/// Number of the states that a stage records, as far as it is known; one where it is not. Of one-dimensional compression, whose strain is not
/// known, it is relative to that by a factor of e.
fn states(stage: &Stage, mean_stress: f64) -> f64 {
    use granum_dem::config::Spacing;
    if symmetry::is_oedometric(stage)
        && let Some(end) = end_stress(stage)
    {
        let strain = libm::log(end / mean_stress);
        return if strain > 0.0 { strain } else { -UNLOADING * strain };
    }
    let strain = stage.until.iter().find_map(|until| match until {
        Until::Reaches {
            measure: Measure::Strain(_) | Measure::ArcLength | Measure::AxialDeviatorStrain,
            value,
        } => Some(value.abs()),
        _ => None,
    });
    match (&stage.record.spacing, strain) {
        (Spacing::Equal, _) => stage.record.states as f64,
        (Spacing::Every(interval), Some(strain)) => (strain / interval).max(1.0),
        _ => 1.0,
    }
}

fn inertial_number(case: &Case) -> Option<ForeseenFailure> {
    let test = case.test_definition();
    let mut mean_stress = test.mean_stress(case.preparation.mean_stress);
    let [mut sum, mut least, mut count] = [0.0, f64::INFINITY, 0.0];
    for stage in test.stages.iter().filter(|stage| !stage.is_mark()) {
        if stage.settling {
            mean_stress = rest_stress(stage).unwrap_or(mean_stress);
            continue;
        }
        // Without stress there is no inertial number, which is then not judged either.
        let has_stress = mean_stress > 0.0;
        if !has_stress || !symmetry::is_driven(stage) || stage.record == Default::default() {
            continue;
        }
        let number = number_of(case, stage, mean_stress)?;
        let Change { mean, least: lowest } = change(stage, mean_stress);
        let weight = states(stage, mean_stress);
        sum += weight * number * mean;
        least = least.min(number * lowest);
        count += weight;
        mean_stress = end_stress(stage).unwrap_or(mean_stress);
    }
    let value = sum / count;
    (value > LARGEST_INERTIAL_NUMBER).then(|| ForeseenFailure {
        check: "inertial_number",
        value,
        limit: LARGEST_INERTIAL_NUMBER,
        is_certain: least > LARGEST_INERTIAL_NUMBER,
        advice: format!("lower {}", test.speed_key),
    })
}

/// The inertial number of the fastest strain rate of a stage at a mean stress.
fn number_of(case: &Case, stage: &Stage, mean_stress: f64) -> Option<f64> {
    let fastest = stage.control.components.iter().fold(0.0f64, |most, drive| match drive {
        Drive::Rate(multiple) => most.max(multiple.abs()),
        _ => most,
    });
    // Where stresses drive the cell, its speed is that of the stage at most.
    let fastest = if fastest > 0.0 { fastest } else { 1.0 };
    let components = &case.grains.mixture.components;
    let material = components.first().map_or(&case.grains.material, |component| &component.material);
    match stage.control.speed {
        Speed::InertialNumber { number, at } => {
            Some(number * fastest * (at.unwrap_or(mean_stress) / mean_stress).sqrt())
        }
        Speed::StrainRate(rate) => {
            let density = material.density * stage.density_scaling;
            Some(rate * fastest * case.grains.mean_diameter().ok()? * (density / mean_stress).sqrt())
        }
    }
}

fn time_step(case: &Case) -> Option<ForeseenFailure> {
    let limit = case.properties().contact.stable_fraction(MOST_CONTACTS);
    let value = case.numerics.time_step_factor;
    // A strong damping shortens the step, so that the factor does not tell.
    let tells = case.contact.damping <= 0.1;
    (tells && value > limit * (1.0 + 1e-9)).then(|| ForeseenFailure {
        check: "time_step_fraction",
        value,
        limit,
        is_certain: true,
        advice: "lower numerics.time_step_factor".into(),
    })
}

/// The largest contact of a sample overlaps by about so many times as much as one that carries `p d^2`, at least.
const LARGEST_OVER_MEAN: f64 = 2.0;

fn overlap(case: &Case) -> Option<ForeseenFailure> {
    let diameter = case.grains.mean_diameter().ok()?;
    let test = case.test_definition();
    let of_stages = test.stages.iter().flat_map(|stage| {
        let at_rest = rest_stress(stage).into_iter();
        // Of an oedometer the lateral stresses are at least a quarter of the axial one.
        at_rest.chain(end_stress(stage).map(|axial| 0.5 * axial))
    });
    let stress = of_stages.fold(case.preparation.mean_stress, f64::max);
    let properties = case.properties();
    let most = properties.stress_at_overlap(diameter, LARGEST_OVERLAP).ok()?;
    let likely = properties.stress_at_overlap(diameter, LARGEST_OVERLAP / LARGEST_OVER_MEAN).ok()?;
    (stress > likely).then(|| ForeseenFailure {
        check: "largest_overlap",
        // Overlaps grow with the stress, faster than its root and slower than itself.
        value: LARGEST_OVERLAP * (stress / likely).sqrt(),
        limit: LARGEST_OVERLAP,
        is_certain: stress > most,
        advice: "lower the stress or raise Young's modulus".into(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn foreseen(text: &str) -> Vec<ForeseenFailure> {
        let grains = "contact.normal = 'hertz'\ngrains.material.interface_energy = 0\n";
        foreseen_failures(&Case::parse(&format!("{grains}{text}"), "case.toml").unwrap())
    }

    fn of_speed(path: &str, number: f64, more: &str) -> Vec<ForeseenFailure> {
        foreseen(&format!("[[stage]]\npath = '{path}'\ninertial_number = {number}\n{more}"))
    }

    #[test]
    fn usual_tests_pass() {
        assert_eq!(foreseen_failures(&Case::default()), []);
        for path in
            ["constant-p", "drained-triaxial", "undrained-triaxial", "simple-shear", "plane-strain", "cyclic"]
        {
            assert_eq!(of_speed(path, 1e-3, ""), [], "{path}");
        }
    }

    #[test]
    fn a_speed_that_was_asked_for_is_judged_by_how_the_stress_grows() {
        let [failure] = &of_speed("drained-triaxial", 2e-3, "")[..] else { panic!("none is foreseen") };
        assert!(failure.is_certain && (failure.value - 1.6e-3).abs() < 1e-12, "{failure:?}");
        assert!(
            failure.sentence().contains("will not pass its check of inertial number"),
            "{}",
            failure.sentence()
        );
        // A little too fast may pass, and an undrained sample may become stronger without a bound.
        assert_eq!(of_speed("drained-triaxial", 1.2e-3, ""), []);
        let undrained = of_speed("undrained-triaxial", 1e-2, "");
        assert!(!undrained[0].is_certain && undrained[0].sentence().contains("is not expected to pass"));
        // From 2 kPa to 200 kPa the number falls to a tenth: its mean over the logarithm of the stress is 0.39 of that at the start.
        let powder =
            of_speed("oedometer", 1e-2, "axial_stress = '200 kPa'\n\n[preparation]\nmean_stress = '2 kPa'\n");
        assert!((powder[0].value / 1e-2 - 0.3909).abs() < 1e-3 && !powder[0].is_certain, "{powder:?}");
        let slow =
            of_speed("oedometer", 2e-3, "axial_stress = '200 kPa'\n\n[preparation]\nmean_stress = '2 kPa'\n");
        assert_eq!(slow, []);
    }

    #[test]
    fn a_time_step_and_a_stress_that_are_too_large_are_foreseen() {
        let failures = foreseen("numerics.time_step_factor = 0.9\n");
        assert!(failures[0].check == "time_step_fraction" && failures[0].is_certain, "{failures:?}");
        let soft = |modulus: &str| {
            foreseen(&format!(
                "grains.material.youngs_modulus = '{modulus}'\npreparation.mean_stress = '100 kPa'\n"
            ))
        };
        assert_eq!(soft("1 GPa"), []);
        let failures = soft("60 MPa");
        assert!(failures[0].check == "largest_overlap" && failures[0].is_certain, "{failures:?}");
        assert!(!soft("200 MPa").is_empty() && !soft("200 MPa")[0].is_certain, "{:?}", soft("200 MPa"));
    }
}
