//! Tests of all kinds of surrogates, including a user-defined one.

use granum_core::observer::{NoObserver, Observer};
use granum_core::{Column, Table};
use granum_nets::trainer::Adam;

use super::*;
use crate::dataset::{Dataset, RunStates, Split};
use crate::error::Result;
use crate::surrogate::*;
use crate::synthetic::{Law, dataset_of, parts, records, spec_of};
use crate::{SurrogateScores, compare, score_surrogate};

/// A user-defined method: it predicts the outputs of the nearest training row, with the inputs scaled by their ranges.
struct Nearest;

struct FittedNearest {
    columns: Columns,
    ranges: Vec<[f64; 2]>,
    rows: Vec<(Vec<f64>, Vec<f64>)>,
}

impl SurrogateMethod for Nearest {
    fn name(&self) -> &str {
        "nearest"
    }
    fn help(&self) -> &str {
        "the outputs of the nearest training row"
    }
    fn fit(&self, dataset: &Dataset, spec: &FitSpec, _: &mut dyn Observer) -> Result<Box<dyn Surrogate>> {
        let columns = spec.columns(dataset)?;
        let (inputs, outputs) = (columns.input_names(), columns.output_names());
        let (x, y) = (dataset.values(&inputs)?, dataset.values(&outputs)?);
        let rows: Vec<(Vec<f64>, Vec<f64>)> = x
            .chunks(inputs.len())
            .zip(y.chunks(outputs.len()))
            .map(|(x, y)| (x.to_vec(), y.to_vec()))
            .collect();
        let range = |k: usize| {
            let values = rows.iter().map(|(x, _)| x[k]);
            [values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max)]
        };
        let ranges = (0..inputs.len()).map(range).collect();
        Ok(Box::new(FittedNearest { columns, ranges, rows }))
    }
    fn load(&self, columns: Columns, content: &Content) -> Result<Box<dyn Surrogate>> {
        let (ranges, rows) = content.read()?;
        Ok(Box::new(FittedNearest { columns, ranges, rows }))
    }
}

impl Surrogate for FittedNearest {
    fn method(&self) -> &str {
        "nearest"
    }
    fn columns(&self) -> &Columns {
        &self.columns
    }
    fn evaluate(&self, inputs: &RunInputs, _level: f64) -> Result<Vec<Prediction>> {
        let distance = |a: &[f64], b: &[f64]| -> f64 {
            let each = a.iter().zip(b).zip(&self.ranges);
            each.map(|((a, b), [low, high])| ((a - b) / (high - low).max(1e-300)).powi(2)).sum()
        };
        let predict = |row: &[f64]| {
            let nearest = self.rows.iter().min_by(|a, b| distance(&a.0, row).total_cmp(&distance(&b.0, row)));
            let outputs = nearest.map_or(&[][..], |(_, outputs)| outputs);
            let estimates = outputs.iter().map(|mean| Estimate::new(*mean)).collect();
            Prediction::new(estimates).with_outside(outside_of(&self.columns, &self.ranges, row))
        };
        Ok(inputs.rows().map(predict).collect())
    }
    fn content(&self) -> Result<Content> {
        Content::new(&(&self.ranges, &self.rows))
    }
}

/// Ridge regression and a user-defined surrogate are scored by one function.
#[test]
fn any_surrogates_are_compared_by_the_same_scores() {
    let dataset = dataset_of(&records(Law::Hidden, 4));
    let parts = parts(&dataset);
    let methods = SurrogateMethods::standard().with(Nearest).unwrap();
    let asked = ["ridge", "nearest"].map(|name| methods.by_name(name).unwrap());
    let scores = compare(&parts, &spec_of(&dataset, "F3"), &asked, 0.9, &mut NoObserver).unwrap();
    let [ridge, nearest] = &scores[..] else { panic!() };
    // For a training row, the nearest row is the row itself.
    assert_eq!((nearest.training.rmse, nearest.coverage), (0.0, None));
    assert!(nearest.unseen.relative_rmse > 1.2 * ridge.unseen.relative_rmse, "{:?}", nearest.unseen);
    assert_eq!((nearest.unseen.states, nearest.unseen_outside > 0), (120, true));
    assert!(ridge.coverage.is_some_and(|share| share > 0.7), "{:?}", ridge.coverage);
    // A surrogate that was fitted elsewhere can be scored as well.
    assert_eq!(score_surrogate(ridge.surrogate.as_ref(), &parts.unseen).unwrap(), ridge.unseen);
}

fn fitted(scores: &SurrogateScores) -> &dyn Surrogate {
    scores.surrogate.as_ref()
}

#[test]
fn every_surrogate_comes_back_from_its_file_with_the_same_bits() {
    let dataset = dataset_of(&records(Law::Plain, 3));
    let parts = parts(&dataset);
    let small = FeedForward { hidden: vec![3], ..FeedForward::default() };
    let trainer = Adam { epochs: 5, ..Adam::default() }.into();
    let recurrent = Recurrent { hidden: 3, trainer, ..Recurrent::default() };
    let methods = SurrogateMethods::standard().replaced_by(small).replaced_by(recurrent);
    let methods = methods.with(Nearest).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let spec = spec_of(&dataset, "F2");
    // What is not constant in a run is no input of whole curves.
    let curves = FitSpec { inputs: vec!["deviator_strain".into()], ..spec.clone() };
    for name in methods.names() {
        let scores = compare(
            &parts,
            if ["gaussian-process", "nearest-run", "cascade"].contains(&name) { &curves } else { &spec },
            &[methods.by_name(name).unwrap()],
            0.9,
            &mut NoObserver,
        )
        .unwrap();
        let path = folder.path().join(format!("{name}.json"));
        save(&path, fitted(&scores[0])).unwrap();
        let loaded = methods.load(&path).unwrap();
        assert_eq!((loaded.method(), loaded.columns()), (name, fitted(&scores[0]).columns()));
        let rows = parts.unseen.values(&loaded.columns().input_names()).unwrap();
        let predictions = loaded.predict_rows(&rows, 0.8).unwrap();
        assert_eq!(predictions, fitted(&scores[0]).predict_rows(&rows, 0.8).unwrap(), "{name}");
        assert_eq!(predictions[0].values.len(), 14);
        // Means alone, which are computed without intervals where that is less work.
        let width = loaded.columns().inputs.len();
        let mean_of = |prediction: &Prediction| prediction.values.iter().map(|own| own.mean).collect();
        let expected: Vec<Vec<f64>> = predictions.iter().map(mean_of).collect();
        let means = |rows: &[f64], width: usize| {
            loaded
                .means(&RunInputs::separate(rows.to_vec(), width).unwrap())
                .map_err(|error| error.to_string())
        };
        assert_eq!(means(&rows, width).unwrap(), expected, "{name}");
        assert_eq!(means(&[], width).unwrap(), Vec::<Vec<f64>>::new(), "{name}");
        let (mut holed, unknown) = (rows[..2 * width].to_vec(), "not a finite number");
        holed[width] = f64::NAN;
        assert!(means(&holed, width).unwrap_err().contains(unknown), "{name}");
        assert!(means(&rows[..width + 1], width + 1).unwrap_err().contains("a row has"), "{name}");

        let text = std::fs::read_to_string(&path).unwrap();
        let message = |text: &str| methods.from_json(text, "s.json").err().unwrap().to_string();
        assert!(
            message(&text.replacen("deviator_strain", "deviator_strais", 1))
                .starts_with("s.json: the SHA-256 does not match")
        );
        assert!(message(&text[..text.len() / 2]).contains("truncated"));
        let newer = text.replacen("\"version\": 1", "\"version\": 2", 1);
        assert_eq!(message(&newer), "s.json: it has version 2, this program reads version 1");
        // The digest is valid, but the content is that of another method.
        let alien = text.replacen("\"content\": {", "\"content\": {\"alien\": 1, ", 1);
        let alien = sealed(&alien.replacen("\"content\": [", "\"content\": [\"alien\", ", 1));
        let place = text.find("\"content\"").unwrap();
        assert!(alien.contains("alien"), "{name}: {:.60}", &text[place..]);
        let refusal = message(&alien);
        assert!(refusal.contains("the content is not that of a surrogate of this method"), "{refusal}");
    }
}

/// Updates the digest of a modified text, as somebody would do who edits a file deliberately.
pub(super) fn sealed(text: &str) -> String {
    let at = text.rfind(",\n  \"sha256\": \"").unwrap();
    format!(
        "{},\n  \"sha256\": \"{}\"\n}}\n",
        &text[..at],
        granum_core::digest::sha256(&text.as_bytes()[..at])
    )
}

#[test]
fn files_that_are_no_surrogates_are_refused_with_what_they_are() {
    let dataset = dataset_of(&records(Law::Plain, 3));
    let methods = SurrogateMethods::standard().with(Nearest).unwrap();
    let spec = FitSpec::new(["deviator_strain"], ["stress_ratio"]);
    let nearest = methods.by_name("nearest").unwrap().fit(&dataset, &spec, &mut NoObserver).unwrap();
    let standard = SurrogateMethods::standard();
    let message = |text: &str| standard.from_json(text, "s.json").err().unwrap().to_string();
    let unknown = message(&to_json(nearest.as_ref()).unwrap());
    assert!(
        unknown.contains("no surrogate method `nearest`") && unknown.contains("must be registered"),
        "{unknown}"
    );
    assert!(message("{\"format\": \"granum model\", \"version\": 2}").contains("a single network"));
    assert!(message("{\"format\": \"granum study\", \"version\": 2}").contains("the file of a study"));
    assert!(message("{}").contains("\"format\" should be \"granum surrogate\", found none"));
    assert!(message("x,y\n1,2\n").contains("not a surrogate file"));

    let ridge = standard.by_name("ridge").unwrap().fit(&dataset, &spec, &mut NoObserver).unwrap();
    let text = to_json(ridge.as_ref()).unwrap();
    let forged = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        message(&sealed(&text.replacen(from, to, 1)))
    };
    assert!(
        forged("\"factor\": [", "\"factor\": [1.0, ")
            .contains("its coefficients are not those of its columns")
    );
    assert!(forged("\"noise_variance\": ", "\"noise_variance\": -").contains("its coefficients are not"));
    assert!(forged("\"ranges\": [[", "\"ranges\": [[0.0, 1.0], [").contains("its coefficients are not"));
    // A file that predictions nothing, sealed again.
    let mut value: serde_json::Value = serde_json::from_str(&text).unwrap();
    value["columns"]["outputs"] = serde_json::json!([]);
    value.as_object_mut().unwrap().remove("sha256");
    let body = granum_core::json::readable(&value).unwrap();
    let body = body.strip_suffix("\n}").unwrap();
    let empty = sealed(&format!("{body},\n  \"sha256\": \"\"\n}}\n"));
    assert_eq!(message(&empty), "s.json: it has no inputs or no outputs");
    let missing = standard.load(std::path::Path::new("/nowhere/s.json")).err().unwrap().to_string();
    assert!(missing.contains("/nowhere/s.json"), "{missing}");
}

/// Runs with `y = x + offset of the run + noise` along x.
fn offset_runs(count: u32, first: u32, offset: f64, noise: f64) -> Dataset {
    let mut state = u64::from(first) + 1;
    let mut normal = move || -> f64 {
        let mut sum = -6.0;
        for _ in 0..12 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            sum += (state >> 11) as f64 / 9_007_199_254_740_992.0;
        }
        sum
    };
    let mut run = |k: u32| {
        let own = offset * normal();
        let x: Vec<f64> = (0..40).map(|i| f64::from(i) / 39.0).collect();
        let y = x.iter().map(|x| x + own + noise * normal()).collect();
        let table = Table::new(vec![Column::new("x", "m", x), Column::new("y", "m", y)]).unwrap();
        RunStates::new(&format!("run-{}", first + k), table).unwrap()
    };
    Dataset::new((0..count).map(&mut run).collect()).unwrap()
}

/// The intervals of both methods have the required coverage on new runs, and report their causes.
#[test]
fn intervals_hold_new_runs_and_name_their_causes() {
    let spec = FitSpec::new(["x"], ["y"]).with_coordinate("x");
    for name in ["ridge", "feed-forward"] {
        let method = FeedForward { hidden: vec![4], ..FeedForward::default() };
        let methods = SurrogateMethods::standard().replaced_by(method);
        let method = methods.by_name(name).unwrap();
        let (mut held, mut all, mut runs) = (0, 0, 0.0);
        for trial in 0..10 {
            let fitted =
                method.fit(&offset_runs(6, 100 * trial, 0.05, 0.01), &spec, &mut NoObserver).unwrap();
            let new = offset_runs(30, 100 * trial + 50, 0.05, 0.01);
            let predictions = fitted.predict_rows(&new.values(&["x"]).unwrap(), 0.9).unwrap();
            for (prediction, exact) in predictions.iter().zip(new.column("y").unwrap()) {
                let interval = prediction.values[0].interval.as_ref().unwrap();
                all += 1;
                held += usize::from(interval.lower <= exact && exact <= interval.upper);
                let of =
                    |wanted| interval.causes.iter().find(|(cause, _)| *cause == wanted).map_or(0.0, |c| c.1);
                runs += of(Cause::Runs);
            }
        }
        let share = f64::from(held as u32) / f64::from(all);
        assert!((0.82..0.98).contains(&share), "{name}: {share}");
        let mean = runs / f64::from(all);
        assert!((0.02..0.08).contains(&mean), "{name}: runs differ by 0.05, found {mean}");
        // Without a scatter between runs this cause is absent.
        let fitted = method.fit(&offset_runs(6, 7, 0.0, 0.01), &spec, &mut NoObserver).unwrap();
        let prediction = &fitted.predict_rows(&[0.5], 0.9).unwrap()[0];
        let causes = &prediction.values[0].interval.as_ref().unwrap().causes;
        let small = causes.iter().all(|(cause, s)| *cause != Cause::Runs || *s < 0.006);
        assert!(small, "{name}: {causes:?}");
    }
}

#[test]
fn wrong_questions_are_refused() {
    let dataset = offset_runs(3, 1, 0.05, 0.01);
    let ridge = RidgeRegression::default();
    let fitted = ridge.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver).unwrap();
    let message = |rows: &[f64], level: f64| fitted.predict_rows(rows, level).unwrap_err().to_string();
    assert_eq!(message(&[f64::NAN], 0.9), "ridge: row 1: x is NaN, not a finite number");
    assert_eq!(message(&[1.0], 1.0), "ridge: the level of an interval must be between 0 and 1, not 1");
    assert!(fitted.predict_rows(&[], 0.9).unwrap().is_empty());
    let message = |spec: FitSpec| ridge.fit(&dataset, &spec, &mut NoObserver).err().unwrap().to_string();
    assert!(message(FitSpec::new(["x"], ["x"])).contains("x is both an input and an output"));
    assert!(message(FitSpec::new(["x", "x"], ["y"])).contains("x is named twice among the inputs"));
    assert!(message(FitSpec::new(["x"], ["z"])).contains("there is no column z"));
    assert!(message(FitSpec::new(Vec::<String>::new(), ["y"])).contains("no input column"));
    assert!(
        message(FitSpec::new(["x"], ["y"]).with_coordinate("state")).contains("must be one of the inputs: x")
    );
    let wrong = RidgeRegression { penalty: 0.0, ..RidgeRegression::default() };
    let text = wrong.fit(&dataset, &FitSpec::new(["x"], ["y"]), &mut NoObserver).err().unwrap().to_string();
    assert!(text.contains("must be a positive number, not 0"));
    // A common score of outputs with different units would be meaningless.
    let parts = dataset.split(&Split::default()).unwrap();
    let text = compare(&parts, &FitSpec::new(["x"], ["y", "state"]), &[&ridge], 0.9, &mut NoObserver)
        .err()
        .unwrap()
        .to_string();
    assert!(text.contains("y (m) and state (no unit) have different units"), "{text}");

    /// A surrogate that returns no predictions.
    struct Mute(Columns);
    impl Surrogate for Mute {
        fn method(&self) -> &str {
            "mute"
        }
        fn columns(&self) -> &Columns {
            &self.0
        }
        fn evaluate(&self, _: &RunInputs, _: f64) -> Result<Vec<Prediction>> {
            Ok(Vec::new())
        }
        fn content(&self) -> Result<Content> {
            Content::new(&0)
        }
    }
    let mute = Mute(fitted.columns().clone());
    let text = mute.predict_rows(&[1.0, 2.0], 0.9).unwrap_err().to_string();
    assert_eq!(text, "mute: it did not return 2 rows with 1 values each");
    let means = mute.means(&RunInputs::separate(vec![1.0, 2.0], 1).unwrap());
    assert_eq!(means.unwrap_err().to_string(), text);
}

/// Results are bit-identical for any number of threads, and do not depend on other outputs of the same fit.
#[test]
fn threads_change_no_bit() {
    let dataset = dataset_of(&records(Law::Plain, 2));
    let method = FeedForward { hidden: vec![3], ..FeedForward::default() };
    let text = |threads: usize| {
        let spec =
            FitSpec::new(["deviator_strain"], ["stress_ratio", "deviator_fabric"]).with_threads(threads);
        to_json(method.fit(&dataset, &spec, &mut NoObserver).unwrap().as_ref()).unwrap()
    };
    assert_eq!(text(1), text(3));
    // All bins of a histogram are one quantity among the inputs.
    let spec = FitSpec::new(["deviator_strain", "probability_density"], ["stress_ratio"]);
    let fitted = method.fit(&dataset, &spec, &mut NoObserver).unwrap();
    assert_eq!(fitted.columns().inputs.len(), 1 + dataset.runs()[0].groups()[0].centres.len());
    assert!(fitted.predict_rows(&dataset.values(&fitted.columns().input_names()).unwrap(), 0.9).is_ok());
}

/// The target is the sum of a spline and a multiple of a deviation that no spline can represent. The squares of the
/// inputs of this coefficient sum to n, so that the penalty of 0.05 n reduces it by the factor 1 / 1.05.
#[test]
fn the_coefficient_of_ridge_regression_is_that_by_hand() {
    let x: Vec<f64> = (1..=240).map(|k| 0.3 * f64::from(k) / 240.0).collect();
    let shown: Vec<f64> = (1..=240).map(|k| if (k / 2) % 2 == 0 { 0.01 } else { -0.01 }).collect();
    let s = x.iter().zip(&shown).map(|(x, shown)| 0.1 + x + shown).collect();
    let y = x.iter().zip(&shown).map(|(x, shown)| 0.5 + 2.0 * x + 3.0 * shown).collect();
    let columns =
        [("x", x), ("s", s), ("y", y)].map(|(name, values)| granum_core::Column::new(name, "", values));
    let run = RunStates::new("run", granum_core::Table::new(columns.into()).unwrap()).unwrap();
    let dataset = Dataset::new(vec![run]).unwrap();
    let fit = |inputs: &[&str]| {
        let spec = FitSpec::new(inputs.iter().copied(), ["y"]).with_coordinate("x");
        RidgeRegression::default().fit(&dataset, &spec, &mut NoObserver).unwrap()
    };
    let mean =
        |surrogate: &dyn Surrogate, row: &[f64]| surrogate.predict_rows(row, 0.9).unwrap()[0].values[0].mean;
    let ridge = fit(&["x", "s"]);
    let gain = mean(ridge.as_ref(), &[0.1, 0.215]) - mean(ridge.as_ref(), &[0.1, 0.21]);
    assert!((gain - 0.005 * 3.0 / 1.05).abs() < 1e-6, "{gain}");
    // The regression on the coordinate alone predicts the curve.
    assert!((mean(fit(&["x"]).as_ref(), &[0.1]) - 0.7).abs() < 2e-3);
}
