//! What a laboratory reports of a triaxial test, from its curves alone, so that it is the same for a test and for a run.

use granum_core::{Column, Table, TableError};
use granum_io::LaboratoryTest;
use granum_sensors::dilatancy::dilatancy_angle as of_increment;
use granum_sensors::friction_angle::friction_angle as mobilised;

/// Share of the axial strain, at its end, over which residual values are means.
const RESIDUAL: f64 = 0.1;
/// Axial strain over which the dilatancy angle is taken.
const WINDOW: f64 = 0.02;
/// Axial strain before which elastic strains would be mistaken for dilatancy.
const DILATANCY_FROM: f64 = 0.005;
/// Axial strains of the secant moduli.
pub const SECANTS: [f64; 4] = [0.001, 0.005, 0.01, 0.02];

/// Strength, dilatancy and stiffness of a triaxial compression test as a laboratory reports them; not finite where the curves do not say.
#[derive(Clone, Debug, PartialEq)]
pub struct LaboratorySummary {
    /// Name of the test or the run.
    pub name: String,
    /// Effective mean stress at the start, Pa.
    pub mean_stress: f64,
    /// Void ratio at the start.
    pub void_ratio: f64,
    /// Largest deviator stress, Pa.
    pub peak: f64,
    /// Axial strain at the largest deviator stress.
    pub peak_strain: f64,
    /// Largest friction angle, degrees: `sin phi = (s1 - s3) / (s1 + s3)` with the principal effective stresses.
    pub peak_friction_angle: f64,
    /// Mean deviator stress over the last tenth of the axial strain, Pa.
    pub residual: f64,
    /// Friction angle of the residual stresses, degrees.
    pub residual_friction_angle: f64,
    /// Largest dilatancy angle over 2 % of axial strain, degrees: `sin psi = D / (2 + D)` with `D = -d eps_v / d eps_1` (Schanz and Vermeer 1996).
    pub dilatancy_angle: f64,
    /// Secant modulus at half of the largest deviator stress, Pa.
    pub e50: f64,
    /// Secant moduli at the axial strains [`SECANTS`], Pa.
    pub secant: [f64; SECANTS.len()],
}

impl LaboratorySummary {
    /// From the curves up to an axial strain.
    pub fn new(test: &LaboratoryTest, up_to: f64) -> LaboratorySummary {
        let count = test.axial_strain.iter().take_while(|x| **x <= up_to * (1.0 + 1e-9)).count();
        let strain = &test.axial_strain[..count];
        let curve = |values: &[f64]| if values.len() < count { Vec::new() } else { values[..count].to_vec() };
        let [q, p, volume] =
            [&test.deviator_stress, &test.mean_stress, &test.volumetric_strain].map(|v| curve(v));
        let highest = (0..q.len()).max_by(|a, b| q[*a].total_cmp(&q[*b]));
        let angles: Vec<f64> = q.iter().zip(&p).map(|(q, p)| friction_angle(*q, *p)).collect();
        let last = strain.last().copied().unwrap_or(f64::NAN);
        let late = |values: &[f64]| {
            let own: Vec<f64> = values
                .iter()
                .zip(strain)
                .filter(|(_, x)| **x >= last * (1.0 - RESIDUAL))
                .map(|(y, _)| *y)
                .collect();
            own.iter().sum::<f64>() / own.len() as f64
        };
        let first = q.first().copied().unwrap_or(f64::NAN);
        let secant = |x: f64| (at(x, strain, &q) - first) / x;
        let half = highest.and_then(|peak| {
            let half = first + 0.5 * (q[peak] - first);
            let k = (1..=peak).find(|k| q[*k] >= half)?;
            let share = (half - q[k - 1]) / (q[k] - q[k - 1]);
            let x = strain[k - 1] + share * (strain[k] - strain[k - 1]);
            Some((half - first) / x)
        });
        LaboratorySummary {
            name: test.name.clone(),
            mean_stress: p.first().copied().unwrap_or(f64::NAN),
            void_ratio: test.void_ratio.first().copied().unwrap_or(f64::NAN),
            peak: highest.map_or(f64::NAN, |k| q[k]),
            peak_strain: highest.map_or(f64::NAN, |k| strain[k]),
            peak_friction_angle: angles.iter().copied().filter(|x| x.is_finite()).fold(f64::NAN, f64::max),
            residual: late(&q),
            residual_friction_angle: friction_angle(late(&q), late(&p)),
            dilatancy_angle: dilatancy_angle(strain, &volume),
            e50: half.unwrap_or(f64::NAN),
            secant: SECANTS.map(secant),
        }
    }
}

/// The friction angle in triaxial compression, degrees, from deviator and mean stress.
fn friction_angle(q: f64, p: f64) -> f64 {
    let (axial, lateral) = (p + 2.0 * q / 3.0, p - q / 3.0);
    if p > 0.0 { mobilised(&[[axial, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]]) } else { f64::NAN }
}

/// The largest dilatancy angle over [`WINDOW`], degrees.
fn dilatancy_angle(strain: &[f64], volume: &[f64]) -> f64 {
    let mut largest = f64::NAN;
    for (from, start) in strain.iter().enumerate().filter(|(_, x)| **x >= DILATANCY_FROM) {
        let Some(to) = (from + 1..volume.len()).find(|to| strain[*to] >= start + WINDOW * (1.0 - 1e-9))
        else {
            break;
        };
        let axial = strain[to] - start;
        let lateral = 0.5 * (volume[to] - volume[from] - axial);
        largest = largest.max(of_increment(&[[axial, 0.0, 0.0], [0.0, lateral, 0.0], [0.0, 0.0, lateral]]));
    }
    largest
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
        column("peak_deviator_stress", "Pa", &|one| one.peak),
        column("peak_axial_strain", "", &|one| one.peak_strain),
        column("peak_friction_angle", "deg", &|one| one.peak_friction_angle),
        column("residual_deviator_stress", "Pa", &|one| one.residual),
        column("residual_friction_angle", "deg", &|one| one.residual_friction_angle),
        column("dilatancy_angle", "deg", &|one| one.dilatancy_angle),
        column("e50", "Pa", &|one| one.e50),
    ];
    for (k, strain) in SECANTS.iter().enumerate() {
        let name = format!("secant_modulus_at_{}_percent", 100.0 * strain).replace('.', "_");
        columns.push(column(&name, "Pa", &|one| one.secant[k]));
    }
    Table::new(columns)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A test at 100 kPa of lateral stress whose q rises to 200 kPa at 5 % and falls to 150 kPa, and which dilates by half of its axial strain.
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
        let found = LaboratorySummary::new(&test(), 0.2);
        assert!((found.peak - 2e5).abs() < 1e-6 && (found.peak_strain - 0.05).abs() < 1e-12);
        // s1 = 300 kPa, s3 = 100 kPa: sin phi = 1/2.
        assert!((found.peak_friction_angle - 30.0).abs() < 1e-9, "{found:?}");
        // s1 = 250 kPa: sin phi = 150 / 350.
        assert!((found.residual_friction_angle - (150.0f64 / 350.0).asin().to_degrees()).abs() < 1e-9);
        // D = 1/2: sin psi = 0.2.
        assert!((found.dilatancy_angle - 0.2f64.asin().to_degrees()).abs() < 1e-6);
        assert!((found.e50 / 4e6 - 1.0).abs() < 1e-9);
        assert!(found.secant.iter().all(|modulus| (modulus / 4e6 - 1.0).abs() < 1e-9));
        // Up to 10 %: residual values are those of the last tenth of it.
        assert!(LaboratorySummary::new(&test(), 0.1).residual > 1.5e5);
        let table = summary_table(&[found]).unwrap();
        assert_eq!(table.values("peak_deviator_stress").unwrap().len(), 1);
        assert!(table.values("secant_modulus_at_0_1_percent").is_some());
    }

    #[test]
    fn what_curves_do_not_say_is_not_a_number() {
        let lacking = LaboratoryTest { deviator_stress: Vec::new(), volumetric_strain: Vec::new(), ..test() };
        let found = LaboratorySummary::new(&lacking, 0.2);
        assert!(found.peak.is_nan() && found.dilatancy_angle.is_nan() && found.e50.is_nan());
        assert!(LaboratorySummary::new(&test(), 0.0).residual_friction_angle.abs() < 1e-9);
    }
}
