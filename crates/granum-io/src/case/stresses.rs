//! Stresses that would press the grains into each other: the theory of small contacts holds for none of them, and a packing that is
//! compressed so far is no longer one of spheres.
//!
//! A contact under the mean stress p carries about `p d^2`. A case whose stresses would let such a contact overlap by more than
//! `numerics.largest_overlap` is refused. For elastic spheres (Hertz) and the usual tenth of a diameter this is a stress of about 0.012
//! times Young's modulus.

use granum_core::quantity::format_number;
use granum_dem::loading::{Constraint, Drive, Measure, Ramp, Stage, Target, Until};

use super::case_stage::CaseStage;
use super::definition::Case;

/// What is wrong with the mean stress of the sample.
pub(super) fn of_sample(case: &Case) -> Option<String> {
    too_much(case, "preparation.mean_stress", case.preparation.mean_stress)
}

/// What is wrong with the mean stress of its compaction.
pub(super) fn of_compaction(case: &Case) -> Option<String> {
    too_much(case, "preparation.compaction_stress", case.preparation.compaction_stress?)
}

/// What is wrong with the mean stress of the section `[shear]`.
pub(super) fn of_shear(case: &Case) -> Option<String> {
    too_much(case, "shear.mean_stress", case.test.shear()?.mean_stress?)
}

/// What is wrong with the stresses of the stages of the preparation.
pub(super) fn of_preparation_stages(case: &Case) -> Option<String> {
    of_list(case, "preparation.stage", &case.sample_stages())
}

/// What is wrong with the stresses of the stages of the test.
pub(super) fn of_stages(case: &Case) -> Option<String> {
    let stages: Vec<Stage> = case.test.tables().iter().flat_map(CaseStage::stages).collect();
    of_list(case, "stage", &stages)
}

fn of_list(case: &Case, heading: &str, stages: &[Stage]) -> Option<String> {
    let largest = |stage: &Stage| stresses(stage).into_iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let worst = stages.iter().max_by(|a, b| largest(a).total_cmp(&largest(b)))?;
    too_much(case, &format!("a stress of [[{heading}]] ({})", worst.name), largest(worst))
}

/// The stresses, Pa, that a stage prescribes or ends at.
fn stresses(stage: &Stage) -> Vec<f64> {
    let mut found = Vec::new();
    for drive in &stage.control.components {
        if let Drive::Stress(target) = drive {
            found.extend(values(target));
        }
    }
    for Constraint { strain, stress, target, .. } in stage.control.constraints.iter().flatten() {
        // Several stresses of this mean magnitude at least have the prescribed sum.
        let weight: f64 = stress.iter().map(|weight| weight.abs()).sum();
        if weight > 0.0 && strain.iter().all(|weight| *weight == 0.0) {
            found.extend(values(target).map(|value| value / weight));
        }
    }
    for until in &stage.until {
        if let Until::Reaches { measure: Measure::Stress(_) | Measure::MeanStress, value } = until {
            found.push(*value);
        }
    }
    found
}

fn values(target: &Target) -> impl Iterator<Item = f64> {
    let end = target.ramp.map(|ramp| match ramp {
        Ramp::To(value) => value,
        Ramp::By(change) => change,
    });
    target.value.into_iter().chain(end)
}

/// The message if a stress, Pa, would press the grains into each other.
fn too_much(case: &Case, name: &str, stress: f64) -> Option<String> {
    let limit = case.numerics.overlap_limit();
    let diameter = case.grains.mean_diameter().ok()?;
    let most = case.properties().stress_at_overlap(diameter, limit).ok()?;
    if stress <= most {
        return None;
    }
    let rounded =
        |value: f64| format!("{value:.2e}").parse().map_or_else(|_| value.to_string(), format_number);
    Some(format!(
        "{name} = {} Pa would press the grains into each other: a contact that carries p d^2 overlaps by more than {} of a diameter above \
         {} Pa ({} of Young's modulus); lower the stress, raise the stiffness of the grains, or allow more by numerics.largest_overlap",
        format_number(stress),
        format_number(limit),
        rounded(most),
        rounded(most / softest(case))
    ))
}

/// Young's modulus of the softest material, Pa.
fn softest(case: &Case) -> f64 {
    let components = &case.grains.mixture.components;
    let moduli = components.iter().map(|component| component.material.youngs_modulus);
    moduli.reduce(f64::min).unwrap_or(case.grains.material.youngs_modulus)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Case::parse(text, "case.toml").err().map_or_else(String::new, |error| error.to_string())
    }

    #[test]
    fn stresses_beyond_the_stiffness_are_refused_with_their_line() {
        let soft = "contact.normal = 'hertz'\ngrains.material.interface_energy = 0\ngrains.material.youngs_modulus = '0.3 GPa'\n";
        let found = message(&format!("{soft}preparation.mean_stress = '100 GPa'\n"));
        assert!(found.starts_with("case.toml:4:"), "{found}");
        assert!(found.contains("preparation.mean_stress = 1e11 Pa would press the grains"), "{found}");
        assert!(found.contains("of Young's modulus") && found.contains("largest_overlap"), "{found}");
        // A stage, and the parameter of a path.
        let stage = "[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.1\nlateral_stress = '5 GPa'\n";
        let found = message(&format!("{soft}{stage}"));
        assert!(found.contains("a stress of [[stage]]") && found.contains("5e9 Pa"), "{found}");
        let found = message(&format!("{soft}shear.mean_stress = '5 GPa'\n"));
        assert!(found.contains("shear.mean_stress = 5e9 Pa"), "{found}");
    }

    /// Confining stresses of 4e-4 of the modulus, as of soft sand, are far from the bound, which is that of Hertz:
    /// (3 (1 - nu^2) p / E)^(2/3) = 0.1.
    #[test]
    fn the_bound_is_that_of_hertz_and_can_be_raised() {
        let text = |stress: f64, more: &str| {
            format!(
                "contact.normal = 'hertz'\ngrains.material.interface_energy = 0\npreparation.mean_stress = '{stress} Pa'\n{more}"
            )
        };
        let most = 70e9 * 0.1f64.powf(1.5) / (3.0 * (1.0 - 0.09));
        assert_eq!(message(&text(4e-4 * 70e9, "")), "");
        assert_eq!(message(&text(0.999 * most, "")), "");
        assert!(message(&text(1.001 * most, "")).contains("would press"));
        assert_eq!(message(&text(2.0 * most, "numerics.largest_overlap = 0.2\n")), "");
        assert!(message(&text(0.1 * most, "numerics.largest_overlap = 0.6\n")).contains("largest_overlap"));
    }

    #[test]
    fn the_limit_of_overlaps_changes_the_digest_only_where_it_is_set() {
        let (usual, raised) =
            (Case::default(), Case::parse("numerics.largest_overlap = 0.2", "case").unwrap());
        assert_eq!(
            Case::parse("numerics.largest_overlap = 'usual'", "case").unwrap().digest(),
            usual.digest()
        );
        assert!(
            raised.digest() != usual.digest() && raised.preparation_digest() != usual.preparation_digest()
        );
        assert!(raised.test_stages().iter().all(|stage| stage.largest_overlap == 0.2));
    }
}
