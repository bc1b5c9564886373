//! What a laboratory reports of a triaxial test, beside each other for tests and runs. Its strength is that of [`granum_run::strength`], so that a
//! measure has one definition wherever it is named; deviator stresses and secant moduli are of the curves.

use granum_core::{Column, Table, TableError};
use granum_io::LaboratoryTest;
use granum_run::strength::{MEASURES, late_mean, of_laboratory};

use super::strength::Measures;

/// Axial strains of the secant moduli.
pub const SECANTS: [f64; 4] = [0.001, 0.005, 0.01, 0.02];

/// The measures of [`MEASURES`] that a laboratory reports.
const REPORTED: [&str; 9] = [
    "peak_friction_angle",
    "critical_friction_angle",
    "cohesive",
    "largest_dilatancy_angle",
    "critical_void_ratio",
    "secant_modulus_50",
    "secant_modulus_50_at_least",
    "undrained_secant_modulus_50",
    "undrained_secant_modulus_50_at_least",
];

/// Strength, dilatancy and stiffness of a triaxial compression test as a laboratory reports them; not finite where the curves do not say.
#[derive(Clone, Debug, PartialEq)]
pub struct LaboratorySummary {
    /// Name of the test or the run.
    pub name: String,
    /// Effective mean stress at the start, Pa.
    pub mean_stress: f64,
    /// Void ratio at the start.
    pub void_ratio: f64,
    /// Largest axial strain, over the initial length.
    pub largest_axial_strain: f64,
    /// Largest deviator stress, Pa.
    pub peak: f64,
    /// Axial strain at the largest deviator stress, over the initial length.
    pub peak_strain: f64,
    /// Mean deviator stress over the last quarter of the axial strain, Pa.
    pub late: f64,
    /// Secant moduli at the axial strains [`SECANTS`], Pa.
    pub secant: [f64; SECANTS.len()],
    /// The measures of its strength, by name.
    pub measures: Measures,
}

impl LaboratorySummary {
    /// Of a test of a laboratory.
    pub fn of_test(test: &LaboratoryTest) -> LaboratorySummary {
        LaboratorySummary::of_curves(test, of_laboratory(test))
    }

    /// Of curves whose measures are known, as those of a run are.
    pub fn of_curves(test: &LaboratoryTest, measures: Measures) -> LaboratorySummary {
        let strain = &test.axial_strain;
        let q: &[f64] = if test.deviator_stress.len() == strain.len() { &test.deviator_stress } else { &[] };
        let highest = (0..q.len()).max_by(|a, b| q[*a].total_cmp(&q[*b]));
        let first = |values: &[f64]| values.first().copied().unwrap_or(f64::NAN);
        let secant = |x: f64| (at(x, strain, q) - first(q)) / x;
        LaboratorySummary {
            name: test.name.clone(),
            mean_stress: first(&test.mean_stress),
            void_ratio: first(&test.void_ratio),
            largest_axial_strain: strain.iter().copied().fold(f64::NAN, f64::max),
            peak: highest.map_or(f64::NAN, |k| q[k]),
            peak_strain: highest.map_or(f64::NAN, |k| strain[k]),
            late: late_mean(strain, q).unwrap_or(f64::NAN),
            secant: SECANTS.map(secant),
            measures,
        }
    }
}

/// The value at x, by linear interpolation; not finite beyond the ends.
fn at(x: f64, xs: &[f64], ys: &[f64]) -> f64 {
    let place = xs.windows(2).position(|pair| pair[0] <= x && x <= pair[1]);
    let Some(k) = place.filter(|k| k + 1 < ys.len()) else { return f64::NAN };
    ys[k] + (x - xs[k]) / (xs[k + 1] - xs[k]).max(1e-300) * (ys[k + 1] - ys[k])
}

/// A row for each test and run, in SI units and degrees.
///
/// # Errors
/// If the columns do not make a table.
pub fn summary_table(all: &[LaboratorySummary]) -> Result<Table, TableError> {
    let column = |name: &str, unit: &str, value: &dyn Fn(&LaboratorySummary) -> f64| {
        Column::new(name, unit, all.iter().map(value).collect())
    };
    let mut columns = vec![
        Column::of_words("curve", all.iter().map(|one| one.name.clone())),
        column("mean_stress", "Pa", &|one| one.mean_stress),
        column("void_ratio", "", &|one| one.void_ratio),
        column("largest_axial_strain", "", &|one| one.largest_axial_strain),
        column("peak_deviator_stress", "Pa", &|one| one.peak),
        column("axial_strain_at_peak_deviator_stress", "", &|one| one.peak_strain),
        column("late_deviator_stress", "Pa", &|one| one.late),
    ];
    let reported = MEASURES.iter().filter(|measure| REPORTED.contains(&measure.name));
    for measure in reported.filter(|measure| all.iter().any(|one| one.measures.contains_key(measure.name))) {
        let unit = if measure.unit == "1" { "" } else { measure.unit };
        columns.push(column(measure.name, unit, &|one| {
            one.measures.get(measure.name).copied().unwrap_or(f64::NAN)
        }));
    }
    for (k, strain) in SECANTS.iter().enumerate() {
        let name = format!("secant_modulus_at_{}_percent", 100.0 * strain).replace('.', "_");
        columns.push(column(&name, "Pa", &|one| one.secant[k]));
    }
    Table::new(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A test at 100 kPa of lateral stress whose q rises to 200 kPa at 5 % and falls to 150 kPa at 10 %, and which dilates by half of its axial
    /// strain.
    fn test() -> LaboratoryTest {
        let strain: Vec<f64> = (0..=200).map(|k| 0.001 * f64::from(k)).collect();
        let q = |x: f64| {
            if x <= 0.05 {
                4e6 * x
            } else if x <= 0.1 {
                2e5 - 1e6 * (x - 0.05)
            } else {
                1.5e5
            }
        };
        LaboratoryTest {
            name: "T".into(),
            deviator_stress: strain.iter().map(|x| q(*x)).collect(),
            mean_stress: strain.iter().map(|x| 1e5 + q(*x) / 3.0).collect(),
            volumetric_strain: strain.iter().map(|x| -0.5 * x).collect(),
            void_ratio: vec![0.7; strain.len()],
            axial_strain: strain,
            ..LaboratoryTest::default()
        }
    }

    #[test]
    fn a_summary_by_hand() {
        let summary = LaboratorySummary::of_test(&test());
        assert!((summary.peak - 2e5).abs() < 1e-6 && (summary.peak_strain - 0.05).abs() < 1e-12);
        assert!((summary.late - 1.5e5).abs() < 1e-6 && (summary.largest_axial_strain - 0.2).abs() < 1e-12);
        // s1 = 300 kPa, s3 = 100 kPa: sin phi = 1/2.
        assert!((summary.measures["peak_friction_angle"] - 30.0).abs() < 1e-9, "{summary:?}");
        // s1 = 250 kPa: sin phi = 150 / 350.
        let late = (150.0f64 / 350.0).asin().to_degrees();
        assert!((summary.measures["critical_friction_angle"] - late).abs() < 1e-9, "{summary:?}");
        // D = 1/2: sin psi = 0.2, of logarithmic strains a little less at large strain.
        assert!(
            (summary.measures["largest_dilatancy_angle"] - 0.2f64.asin().to_degrees()).abs() < 0.2,
            "{summary:?}"
        );
        // The logarithmic strain of 2.5 % is 2.53 %.
        assert!((summary.measures["secant_modulus_50"] / 4e6 - 0.9875).abs() < 2e-3, "{summary:?}");
        assert!(summary.secant.iter().all(|modulus| (modulus / 4e6 - 1.0).abs() < 1e-9));
        let table = summary_table(&[summary]).unwrap();
        assert_eq!(table.values("peak_deviator_stress").unwrap().len(), 1);
        assert!(table.values("secant_modulus_at_0_1_percent").is_some());
        assert!(table.values("peak_friction_angle").is_some() && table.values("cohesive").is_none());
    }

    #[test]
    fn what_curves_do_not_say_is_not_a_number() {
        let lacking = LaboratoryTest { deviator_stress: Vec::new(), volumetric_strain: Vec::new(), ..test() };
        let summary = LaboratorySummary::of_test(&lacking);
        assert!(summary.peak.is_nan() && summary.late.is_nan() && summary.measures.is_empty());
    }
}
