//! Runs over the curves of laboratory tests: deviator stress, volumetric strain and void ratio against axial strain.

use granum_core::{Column, Table, TableError};
use granum_dem::loading::Stage;
use granum_io::LaboratoryTest;
use granum_run::strength::as_laboratory;
use granum_sensors::Record;

use super::figure::palette::{INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, SHAPES, literal};
use super::overlay::stroke;
use super::strength::Measures;

/// The curves of a run in the measures of the laboratory: engineering strains, compression positive.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ComparedRun {
    /// Name of the run.
    pub name: String,
    /// The curves.
    pub curves: LaboratoryTest,
    /// The measures of the test, for a table beside them.
    pub measures: Measures,
}

impl ComparedRun {
    /// The curves of the test proper of a record with these stages; strains count from its start.
    pub fn from_record(name: &str, record: &Record, stages: &[Stage]) -> ComparedRun {
        let curves = as_laboratory(name, record, stages);
        ComparedRun { name: name.to_owned(), curves, measures: Measures::new() }
    }
}

/// The errors of a run against a test, over the axial strains that both have.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Errors {
    /// Largest axial strain that both have.
    pub up_to: f64,
    /// Root mean square error of q over the largest q of the test; `None` if the test has none.
    pub deviator_stress: Option<f64>,
    /// Largest q of the run over that of the test, minus one.
    pub peak: Option<f64>,
    /// Root mean square error of the volumetric strain.
    pub volumetric_strain: Option<f64>,
    /// Root mean square error of the void ratio.
    pub void_ratio: Option<f64>,
}

/// The value of a curve at x, by linear interpolation; `None` beyond its ends.
fn at(x: f64, xs: &[f64], ys: &[f64]) -> Option<f64> {
    let place = xs.windows(2).position(|pair| pair[0] <= x && x <= pair[1])?;
    let [a, b] = [xs[place], xs[place + 1]];
    let share = if b > a { (x - a) / (b - a) } else { 0.0 };
    Some(ys.get(place)? + share * (ys.get(place + 1)? - ys.get(place)?))
}

/// Compares a run with a test at the axial strains of the test.
pub fn errors(run: &ComparedRun, test: &LaboratoryTest) -> Errors {
    let strains = &run.curves.axial_strain;
    let common = |x: &&f64| at(**x, strains, strains).is_some();
    let up_to = test.axial_strain.iter().filter(common).fold(0.0, |most: f64, x| most.max(*x));
    let rms = |own: &[f64], other: &[f64]| -> Option<f64> {
        let pairs = test.axial_strain.iter().zip(other).filter_map(|(x, y)| Some(at(*x, strains, own)? - y));
        let (sum, count) = pairs.fold((0.0, 0), |(sum, count), error| (sum + error * error, count + 1));
        (count > 0).then(|| (sum / f64::from(count)).sqrt())
    };
    let largest = |values: &[f64], xs: &[f64]| {
        values
            .iter()
            .zip(xs)
            .filter(|(_, x)| **x <= up_to)
            .fold(0.0, |most: f64, (value, _)| most.max(*value))
    };
    let run_curves = &run.curves;
    let peak = largest(&test.deviator_stress, &test.axial_strain);
    let own_peak = largest(&run_curves.deviator_stress, strains);
    let has_peak = peak > 0.0;
    Errors {
        up_to,
        deviator_stress: rms(&run_curves.deviator_stress, &test.deviator_stress)
            .filter(|_| has_peak)
            .map(|e| e / peak),
        peak: has_peak.then(|| own_peak / peak - 1.0),
        volumetric_strain: rms(&run_curves.volumetric_strain, &test.volumetric_strain),
        void_ratio: rms(&run_curves.void_ratio, &test.void_ratio),
    }
}

/// The differences of runs from the tests with which they are compared, at the axial strains of the tests: a row for each reading that both have,
/// with the run, the test, the axial strain and what the run has more of deviator stress, volumetric strain and void ratio (not finite where one
/// of them has none).
///
/// # Errors
/// If the columns do not make a table.
pub fn residuals(pairs: &[(&ComparedRun, &LaboratoryTest)]) -> Result<Table, TableError> {
    let (mut runs, mut tests) = (Vec::new(), Vec::new());
    let mut numbers: [Vec<f64>; 4] = Default::default();
    for (run, test) in pairs {
        let strains = &run.curves.axial_strain;
        for (k, x) in test.axial_strain.iter().enumerate() {
            if at(*x, strains, strains).is_none() {
                continue;
            }
            let more = |own: &[f64], other: &[f64]| {
                at(*x, strains, own).zip(other.get(k)).map_or(f64::NAN, |(own, other)| own - other)
            };
            runs.push(run.name.clone());
            tests.push(test.name.clone());
            let row = [
                *x,
                more(&run.curves.deviator_stress, &test.deviator_stress),
                more(&run.curves.volumetric_strain, &test.volumetric_strain),
                more(&run.curves.void_ratio, &test.void_ratio),
            ];
            numbers.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
        }
    }
    let names =
        [("axial_strain", ""), ("deviator_stress", "Pa"), ("volumetric_strain", ""), ("void_ratio", "")];
    let mut columns = vec![Column::of_words("run", runs), Column::of_words("test", tests)];
    columns.extend(names.iter().zip(numbers).map(|((name, unit), values)| Column::new(*name, *unit, values)));
    Table::new(columns)
}

/// The values of a test over its axial strains.
type Values = fn(&LaboratoryTest) -> &[f64];

/// Draws runs as lines over tests as open marks; without tests, runs over each other. Runs that are repetitions of one another (`groups` has their
/// places) are drawn as a band from the smallest to the largest of them, with their mean. Below, the differences of the runs from the
/// tests with which they are compared.
pub fn figure(
    runs: &[ComparedRun],
    tests: &[LaboratoryTest],
    compared: &[(&ComparedRun, &LaboratoryTest)],
    groups: &[Vec<usize>],
) -> (Figure, String) {
    let curves: [(&str, Axis, Values); 3] = [
        ("deviator stress", Axis::new("Deviator stress *q*").unit("Pa").including(0.0), |test| {
            &test.deviator_stress
        }),
        ("volumetric strain", Axis::new("Volumetric strain *ε*_{v}"), |test| &test.volumetric_strain),
        ("void ratio", Axis::new("Void ratio *e*"), |test| &test.void_ratio),
    ];
    let strain_axis = || Axis::new("Axial strain *ε*_{1}");
    let (mut panels, mut names) = (Vec::new(), Vec::new());
    for (what, axis, of) in curves {
        let points = |test: &LaboratoryTest| -> Vec<[f64; 2]> {
            test.axial_strain.iter().zip(of(test)).map(|(x, y)| [*x, *y]).collect()
        };
        let has = |test: &LaboratoryTest| !of(test).is_empty();
        let drawn = match tests.is_empty() {
            true => runs.iter().any(|run| has(&run.curves)),
            false => tests.iter().any(has),
        };
        if !drawn {
            continue;
        }
        let mut plot = Plot::new(strain_axis(), axis);
        for (k, test) in tests.iter().enumerate() {
            // About forty markers per curve can be distinguished.
            let every = points(test).len().div_ceil(40).max(1);
            let marks = points(test).into_iter().step_by(every).collect();
            let name = if test.name.is_empty() { "laboratory" } else { &literal(&test.name) };
            plot = plot.with(Layer::points(marks, SHAPES[k % SHAPES.len()], INK).named(name));
        }
        for (k, run) in runs.iter().enumerate() {
            match groups.iter().find(|group| group.len() > 1 && group.contains(&k)) {
                Some(group) if group[0] == k => {
                    let own: Vec<&LaboratoryTest> =
                        group.iter().filter_map(|k| runs.get(*k)).map(|run| &run.curves).collect();
                    let band = band(&own, of);
                    let mean = band.iter().map(|[x, _, _, mean]| [*x, *mean]).collect();
                    let ends = band.iter().map(|[x, low, high, _]| [*x, *low, *high]).collect();
                    let repetitions = match own.len() - 1 {
                        1 => "1 repetition".to_string(),
                        more => format!("{more} repetitions"),
                    };
                    let name = format!("{} and {repetitions}", literal(&run.name));
                    plot = plot.with(Layer::area(ends, color(k), 0.25));
                    plot = plot.with(Layer::stroked(mean, stroke(k)).named(&name));
                }
                Some(_) => {}
                None => {
                    let line = Layer::stroked(points(&run.curves), stroke(k));
                    plot = plot.with(line.named(&literal(&run.name)));
                }
            }
        }
        panels.push(Panel::plot(plot));
        names.push(what);
    }
    let differences: [(Axis, Values); 2] = [
        (Axis::new("Run minus test, *q*").unit("Pa").including(0.0), |test| &test.deviator_stress),
        (Axis::new("Run minus test, *ε*_{v}").including(0.0), |test| &test.volumetric_strain),
    ];
    for (axis, of) in differences.into_iter().filter(|_| !tests.is_empty()) {
        let mut plot = Plot::new(strain_axis(), axis);
        for (run, test) in compared {
            let difference =
                |(x, y): (&f64, &f64)| Some([*x, at(*x, &run.curves.axial_strain, of(&run.curves))? - y]);
            let line: Vec<[f64; 2]> = test.axial_strain.iter().zip(of(test)).filter_map(difference).collect();
            let place = runs.iter().position(|other| std::ptr::eq(other, *run)).unwrap_or(0);
            if !line.is_empty() {
                plot = plot.with(Layer::stroked(line, stroke(place)));
            }
        }
        if !plot.is_empty() {
            panels.push(Panel::plot(plot));
        }
    }
    let whose = if tests.is_empty() { "runs" } else { "runs (lines) and laboratory tests (marks)" };
    let below = if tests.is_empty() { "" } else { " Last, the differences of the runs from the tests." };
    let caption = format!(
        "{} against axial strain: {whose}. Engineering strains, compression positive.{below}",
        names.join(", ")
    );
    (Figure::new(&caption, panels.len().clamp(1, 2), panels), caption)
}

/// The smallest, the largest and the mean value of curves at the strains of the first one that all of them reach: strain, low, high, mean.
fn band(curves: &[&LaboratoryTest], of: Values) -> Vec<[f64; 4]> {
    let Some(first) = curves.first() else { return Vec::new() };
    let row = |x: &f64| {
        let values: Option<Vec<f64>> =
            curves.iter().map(|curve| at(*x, &curve.axial_strain, of(curve))).collect();
        let values = values?;
        let [low, high] = granum_learn::curve::range(values.iter().copied());
        Some([*x, low, high, values.iter().sum::<f64>() / values.len() as f64])
    };
    first.axial_strain.iter().filter_map(row).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(q: f64) -> LaboratoryTest {
        let strain: Vec<f64> = (0..21).map(|k| 0.01 * f64::from(k)).collect();
        LaboratoryTest {
            name: "T1".into(),
            deviator_stress: strain.iter().map(|x| q * (x / 0.2)).collect(),
            volumetric_strain: strain.iter().map(|x| -0.1 * x).collect(),
            void_ratio: strain.iter().map(|x| 0.7 + x).collect(),
            axial_strain: strain,
            ..LaboratoryTest::default()
        }
    }

    #[test]
    fn errors_are_those_between_the_curves() {
        let run = ComparedRun { name: "run".into(), curves: test(110e3), ..Default::default() };
        let found = errors(&run, &test(100e3));
        assert!((found.up_to - 0.2).abs() < 1e-12);
        assert!((found.peak.unwrap() - 0.1).abs() < 1e-9);
        // The error grows as the strain: its root mean square is that of k/20 for k = 0 to 20.
        let square = (0..21).map(|k| (f64::from(k) / 20.0).powi(2)).sum::<f64>() / 21.0;
        assert!((found.deviator_stress.unwrap() - 0.1 * square.sqrt()).abs() < 1e-9);
        assert_eq!((found.volumetric_strain, found.void_ratio), (Some(0.0), Some(0.0)));
        let shorter =
            LaboratoryTest { axial_strain: run.curves.axial_strain[..11].to_vec(), ..run.curves.clone() };
        let found =
            errors(&ComparedRun { name: "run".into(), curves: shorter, ..Default::default() }, &test(100e3));
        assert!((found.up_to - 0.1).abs() < 1e-12);
    }

    #[test]
    fn residuals_are_at_the_readings_that_both_have() {
        let mut run = ComparedRun { name: "run".into(), curves: test(110e3), ..Default::default() };
        run.curves.axial_strain.truncate(11);
        let other = LaboratoryTest { void_ratio: Vec::new(), ..test(100e3) };
        let table = residuals(&[(&run, &other)]).unwrap();
        assert_eq!(table.rows(), 11);
        let more = table.values("deviator_stress").unwrap();
        assert!((more[10] - 5e3).abs() < 1e-6, "{more:?}");
        assert!(table.values("void_ratio").unwrap().iter().all(|value| value.is_nan()));
    }

    #[test]
    fn repetitions_are_a_band() {
        let (low, high) = (test(90e3), test(110e3));
        let found = band(&[&low, &high], |test| &test.deviator_stress);
        assert_eq!(found.len(), 21);
        let [x, low, high, mean] = found[20];
        assert!((x - 0.2).abs() < 1e-12 && (low - 90e3).abs() < 1e-6 && (high - 110e3).abs() < 1e-6);
        assert!((mean - 100e3).abs() < 1e-6);
        let runs = [test(90e3), test(110e3)].map(|curves| ComparedRun {
            name: "r".into(),
            curves,
            ..Default::default()
        });
        let drawn = figure(&runs, &[], &[], &[vec![0, 1]]).0.to_svg();
        assert!(drawn.contains("r and 1 repetition<"), "{drawn}");
    }

    #[test]
    fn what_a_test_lacks_is_not_compared() {
        let run = ComparedRun { name: "run".into(), curves: test(1e5), ..Default::default() };
        let lacking = LaboratoryTest { deviator_stress: Vec::new(), void_ratio: Vec::new(), ..test(1e5) };
        let found = errors(&run, &lacking);
        assert_eq!((found.deviator_stress, found.peak, found.void_ratio), (None, None, None));
        let (runs, tests) = ([run], [lacking]);
        let (figure, caption) = figure(&runs, &tests, &[(&runs[0], &tests[0])], &[]);
        // The volumetric strain, and its difference.
        assert_eq!(figure.panels.len(), 2);
        assert!(caption.starts_with("volumetric strain against"));
        assert!(figure.to_svg().contains("T1"));
    }
}
