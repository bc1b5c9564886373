//! Runs over the curves of laboratory tests: deviator stress, volumetric strain and void ratio against axial strain.

use granum_dem::loading::Stage;
use granum_io::LaboratoryTest;
use granum_run::strength::as_laboratory;
use granum_sensors::Record;

use super::figure::palette::INK;
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

/// The values of a test over its axial strains.
type Values = fn(&LaboratoryTest) -> &[f64];

/// Draws runs as lines over tests as open marks; without tests, runs over each other.
pub fn figure(runs: &[ComparedRun], tests: &[&LaboratoryTest]) -> (Figure, String) {
    let curves: [(&str, Axis, Values); 3] = [
        ("deviator stress", Axis::new("Deviator stress *q*").unit("Pa").including(0.0), |test| {
            &test.deviator_stress
        }),
        ("volumetric strain", Axis::new("Volumetric strain *ε*_{v}"), |test| &test.volumetric_strain),
        ("void ratio", Axis::new("Void ratio *e*"), |test| &test.void_ratio),
    ];
    let mut panels = Vec::new();
    let mut names = Vec::new();
    for (what, axis, of) in curves {
        let points = |test: &LaboratoryTest| -> Vec<[f64; 2]> {
            test.axial_strain.iter().zip(of(test)).map(|(x, y)| [*x, *y]).collect()
        };
        let has = |test: &LaboratoryTest| !of(test).is_empty();
        let drawn = if tests.is_empty() {
            runs.iter().any(|run| has(&run.curves))
        } else {
            tests.iter().any(|test| has(test))
        };
        if !drawn {
            continue;
        }
        let mut plot = Plot::new(Axis::new("Axial strain *ε*_{1}"), axis);
        for (k, test) in tests.iter().enumerate() {
            // About forty markers per curve can be distinguished.
            let every = points(test).len().div_ceil(40).max(1);
            let marks = points(test).into_iter().step_by(every).collect();
            let name = if test.name.is_empty() { "laboratory" } else { &literal(&test.name) };
            plot = plot.with(Layer::points(marks, SHAPES[k % SHAPES.len()], INK).named(name));
        }
        for (k, run) in runs.iter().enumerate() {
            let line = Layer::stroked(points(&run.curves), stroke(k));
            plot = plot.with(line.named(&literal(&run.name)));
        }
        panels.push(Panel::plot(plot));
        names.push(what);
    }
    let whose = if tests.is_empty() { "runs" } else { "runs (lines) and laboratory tests (marks)" };
    let caption = format!(
        "{} against axial strain: {whose}. Engineering strains, compression positive.",
        names.join(", ")
    );
    (Figure::new(&caption, panels.len().clamp(1, 2), panels), caption)
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
    fn what_a_test_lacks_is_not_compared() {
        let run = ComparedRun { name: "run".into(), curves: test(1e5), ..Default::default() };
        let lacking = LaboratoryTest { deviator_stress: Vec::new(), void_ratio: Vec::new(), ..test(1e5) };
        let found = errors(&run, &lacking);
        assert_eq!((found.deviator_stress, found.peak, found.void_ratio), (None, None, None));
        let (figure, caption) = figure(&[run], &[&lacking]);
        assert_eq!(figure.panels.len(), 1);
        assert!(caption.starts_with("volumetric strain against"));
        assert!(figure.to_svg().contains("T1"));
    }
}
