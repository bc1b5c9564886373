//! The measures of a test of a laboratory, by the definitions that runs have: its curves become a record of the same kind, from which
//! [`super::of_test`] computes them.

use std::collections::BTreeMap;

use granum_core::{Column, Table};
use granum_dem::loading::Stage;
use granum_dem::loading::preset::{self, Given};
use granum_io::LaboratoryTest;
use granum_sensors::Record;

use super::measures::of_test;

/// Volumetric strain below which a test was not drained.
const NO_VOLUME: f64 = 1e-9;

/// Logarithmic strain, from a strain over the initial length.
fn logarithmic(strain: f64) -> f64 {
    -libm::log1p(-strain)
}

/// The measures of a triaxial test of a laboratory ([`super::MEASURES`]), as far as its curves have them. Strains become logarithmic ones,
/// as those of runs are. A test without a volumetric strain has no dilatancy, and one whose volumetric strain is zero is undrained.
pub fn of_laboratory(test: &LaboratoryTest) -> BTreeMap<String, f64> {
    let rows = test.axial_strain.len();
    let has = |values: &[f64]| values.len() == rows && rows > 0;
    if !has(&test.deviator_stress) {
        return BTreeMap::new();
    }
    // Without a mean stress a constant lateral stress stands in for that of the test; what depends on it is left out below.
    let has_mean_stress = has(&test.mean_stress);
    let mean_stress: Vec<f64> = match has_mean_stress {
        true => test.mean_stress.clone(),
        false => {
            let largest = test.deviator_stress.iter().fold(1.0f64, |most, q| most.max(q.abs()));
            test.deviator_stress.iter().map(|q| largest + q / 3.0).collect()
        }
    };
    let has_volume = has(&test.volumetric_strain);
    let undrained = has_volume && test.volumetric_strain.iter().all(|strain| strain.abs() <= NO_VOLUME);
    let axial: Vec<f64> = test.axial_strain.iter().copied().map(logarithmic).collect();
    let volume: Vec<f64> = match has_volume {
        true => test.volumetric_strain.iter().copied().map(logarithmic).collect(),
        false => vec![0.0; rows],
    };
    let lateral: Vec<f64> = axial.iter().zip(&volume).map(|(axial, volume)| 0.5 * (volume - axial)).collect();
    let stress = |share: f64| -> Vec<f64> {
        mean_stress.iter().zip(&test.deviator_stress).map(|(p, q)| p + share * q).collect()
    };
    let mut columns = vec![
        Column::new("stage", "", vec![1.0; rows]),
        Column::new("axial_strain", "", axial),
        Column::new("lateral_strain_2", "", lateral.clone()),
        Column::new("lateral_strain_3", "", lateral),
        Column::new("volumetric_strain", "", volume),
        Column::new("stress_11", "Pa", stress(2.0 / 3.0)),
        Column::new("stress_22", "Pa", stress(-1.0 / 3.0)),
        Column::new("stress_33", "Pa", stress(-1.0 / 3.0)),
        Column::new("mean_stress", "Pa", mean_stress.clone()),
    ];
    if has(&test.void_ratio) {
        let solid = test.void_ratio.iter().map(|void_ratio| 1.0 / (1.0 + void_ratio)).collect();
        columns.push(Column::new("solid_fraction", "", solid));
    }
    let Ok(series) = Table::new(columns) else { return BTreeMap::new() };
    let mut measures = of_test(&Record { series, ..Record::default() }, &stages(undrained), &[]);
    if !has_volume {
        measures.remove("largest_dilatancy_angle");
        measures.remove("at_critical_state");
    }
    if !has_mean_stress {
        measures.retain(|name, _| WITHOUT_MEAN_STRESS.iter().any(|prefix| name.starts_with(prefix)));
    }
    measures
}

/// The beginnings of the names of measures that need no mean stress.
const WITHOUT_MEAN_STRESS: [&str; 2] = ["largest_dilatancy_angle", "secant_modulus"];

/// The stages of a triaxial test.
fn stages(undrained: bool) -> Vec<Stage> {
    let path = if undrained { "undrained-triaxial" } else { "drained-triaxial" };
    preset::named(path).map_or(Vec::new(), |path| path.expand(&Given::new()))
}

#[cfg(test)]
mod tests {
    use super::super::test_records::{drained_stages, triaxial};
    use super::super::{as_laboratory, of_test};
    use super::*;

    /// The curves of a run, written as a laboratory gives them, have the measures of the run.
    #[test]
    fn a_run_and_its_curves_have_one_strength() {
        let rows = (0..=150).map(|k| {
            let x = 0.002 * f64::from(k);
            let q = if x < 0.06 { 200.0 * x / 0.06 } else { 150.0 + 50.0 * libm::exp(-(x - 0.06) / 0.05) };
            [x, -0.65 * x, 100.0 + q / 3.0, q]
        });
        let record = triaxial(rows, 0.6);
        let of_run = of_test(&record, &drained_stages(), &[]);
        let of_curves = of_laboratory(&as_laboratory("run", &record, &drained_stages()));
        for name in [
            "peak_friction_angle",
            "critical_friction_angle",
            "largest_dilatancy_angle",
            "secant_modulus_50",
            "critical_void_ratio",
            "peak_stress_ratio",
        ] {
            let [run, curves] = [&of_run, &of_curves].map(|measures| measures[name]);
            assert!((run / curves - 1.0).abs() < 1e-9, "{name}: {run} {curves}");
        }
    }

    #[test]
    fn what_a_laboratory_did_not_measure_has_no_measure() {
        let strain: Vec<f64> = (0..=100).map(|k| 0.002 * f64::from(k)).collect();
        let q: Vec<f64> = strain.iter().map(|x| 2e5 * (x / 0.05).min(1.0)).collect();
        let test = LaboratoryTest {
            deviator_stress: q.clone(),
            mean_stress: q.iter().map(|q| 1e5 + q / 3.0).collect(),
            axial_strain: strain.clone(),
            ..LaboratoryTest::default()
        };
        let measures = of_laboratory(&test);
        assert!((measures["peak_friction_angle"] - 30.0).abs() < 1e-9, "{measures:?}");
        assert!(
            !measures.contains_key("largest_dilatancy_angle")
                && !measures.contains_key("critical_void_ratio")
        );
        let without = LaboratoryTest { mean_stress: Vec::new(), ..test.clone() };
        // Stiffness needs no mean stress, strength does.
        let names: Vec<String> = of_laboratory(&without).into_keys().collect();
        assert!(names.iter().all(|name| name.starts_with("secant_modulus")), "{names:?}");
        let undrained = LaboratoryTest { volumetric_strain: vec![0.0; strain.len()], ..test };
        assert!(of_laboratory(&undrained).contains_key("undrained_secant_modulus_50"));
    }
}
