//! Tests of the answers on runs of a known law.

use granum_core::observer::{Flow, NoObserver, Observer, Progress};
use granum_core::{Column, Table};

use super::{Source, Worth, WorthPlan, measure, properties};
use crate::dataset::{Dataset, RunStates};
use crate::error::LearnError;
use crate::surrogate::{Cascade, SurrogateMethods};

/// The stress ratio follows a fabric that a friction and a hidden variable of the run decide; `noise` is a sensor that tells nothing.
fn dataset(first: u32, count: u32) -> Dataset {
    let part = |k: u32, factor: f64| (f64::from(k) * factor).fract();
    let run = |k: u32| {
        let friction = 0.2 + 0.6 * part(k, 0.618_033_988_75);
        let hidden = 0.3 * (part(k, 0.754_877_666_2) - 0.5);
        let x: Vec<f64> = (0..25).map(|i| f64::from(i) / 24.0).collect();
        let fabric: Vec<f64> = x.iter().map(|x| (friction + hidden) * x / (0.2 + x)).collect();
        let ratio = fabric.iter().zip(&x).map(|(fabric, x)| 1.5 * fabric + 0.1 * x).collect();
        let noise = x.iter().map(|x| part(k, 0.569_840_291) + 0.1 * (40.0 * x).sin()).collect();
        let columns = vec![
            Column::new("axial_strain", "", x),
            Column::new("deviator_fabric", "", fabric),
            Column::new("noise", "", noise),
            Column::new("stress_ratio", "", ratio),
        ];
        let run = RunStates::new(&format!("run-{k}"), Table::new(columns).unwrap()).unwrap();
        let run = run.with_parameter("friction", "", friction).unwrap();
        let run = run.with_parameter("twice", "", friction).unwrap();
        let run = run.with_parameter("preparation.seed", "", f64::from(k)).unwrap();
        run.with_word("stage.1.path", "drained-triaxial").unwrap()
    };
    Dataset::new((first..first + count).map(run).collect()).unwrap()
}

fn plan(training: &Dataset) -> WorthPlan {
    let mut plan = WorthPlan::new("axial_strain", training);
    plan.outputs = vec!["stress_ratio".into()];
    plan.sensors = vec!["deviator_fabric".into(), "noise".into()];
    plan.methods = vec!["ridge".into()];
    plan
}

/// A cascade with fewer searches for parameters, to save time.
fn methods() -> SurrogateMethods {
    let mut cascade = Cascade::default();
    (cascade.first.starts, cascade.first.components) = (1, 2);
    SurrogateMethods::standard().replaced_by(cascade)
}

fn error(worth: &Worth, output: &str, name: &str) -> f64 {
    let own = worth.answers.iter().find(|own| own.output == output && own.knowledge.name == name);
    own.unwrap_or_else(|| panic!("{name}: {:?}", worth.answers)).error.relative
}

#[test]
fn a_sensor_that_tells_is_worth_more_than_one_that_does_not() {
    let (training, unseen) = (dataset(1, 24), dataset(41, 12));
    assert_eq!(properties(&training), ["friction"]);
    let mut plan = plan(&training);
    plan.counts = vec![12, 24];
    let worth = measure(&training, &unseen, &plan, &methods(), &mut NoObserver).unwrap();
    let of = |name: &str| error(&worth, "stress_ratio", name);
    let alone = of("strain alone");
    assert!(
        alone > 0.15 && of("strain + deviator_fabric") < 0.3 * alone,
        "{alone} {}",
        of("strain + deviator_fabric")
    );
    assert!(of("strain + noise") > 0.8 * alone, "{}", of("strain + noise"));
    assert!(of("strain + all sensors of another run") > alone);
    assert!(of("strain + all sensors, permuted") > 2.0 * of("strain + all sensors"));
    // Friction tells a part, the sensor the rest.
    assert!((0.2..0.8).contains(&(of("properties") / alone)), "{}", of("properties"));
    assert!(of("properties + all sensors") < 0.3 * alone);
    let cascade = of("cascade: properties, sensors predicted from them");
    assert!((cascade / of("properties") - 1.0).abs() < 0.5, "{cascade} {}", of("properties"));
    // Micro from macro: the fabric from the stress ratio.
    assert!(
        error(&worth, "deviator_fabric", "strain + stress_ratio")
            < 0.3 * error(&worth, "deviator_fabric", "strain alone")
    );
    assert!(error(&worth, "noise", "strain + stress_ratio") > 0.8 * error(&worth, "noise", "strain alone"));
    // One table of the most runs, and one by their number.
    assert_eq!(worth.paths(), ["drained-triaxial"]);
    let table = worth.table("drained-triaxial", &plan.outputs);
    assert_eq!(table[0].0, "strain alone");
    assert_eq!(table[0].1[0].unwrap().training_runs, 24);
    let (counts, rows) = worth.by_runs("drained-triaxial", "stress_ratio");
    assert_eq!((counts, rows.len()), (vec![12, 24], table.len()));
    assert!(rows.iter().all(|(_, own)| own.iter().all(Option::is_some)));
    let last = worth.answers.iter().rfind(|own| own.knowledge.source == Source::Predicted).unwrap();
    assert_eq!((last.method.as_str(), last.error.runs), ("cascade", 12));
    assert!(last.coverage.is_some_and(|share| share > 0.6), "{last:?}");
}

#[test]
fn answers_do_not_depend_on_threads_and_can_be_stopped() {
    struct Stop;
    impl Observer for Stop {
        fn progress(&mut self, _: &Progress) -> Flow {
            Flow::Stop
        }
    }
    let (training, unseen) = (dataset(1, 8), dataset(9, 3));
    let (mut plan, methods) = (plan(&training), methods());
    plan.methods.push("nearest-run".into());
    let with = |threads| {
        let plan = WorthPlan { threads, ..plan.clone() };
        measure(&training, &unseen, &plan, &methods, &mut NoObserver).unwrap().answers
    };
    assert_eq!(with(1), with(3));
    let stopped = measure(&training, &unseen, &plan, &methods, &mut Stop);
    assert!(matches!(stopped, Err(LearnError::Stopped { .. })));
}

#[test]
fn plans_that_runs_cannot_answer_are_refused() {
    let (training, unseen) = (dataset(1, 8), dataset(9, 3));
    let methods = methods();
    let refusal = |change: &dyn Fn(&mut WorthPlan)| {
        let mut plan = plan(&training);
        change(&mut plan);
        measure(&training, &unseen, &plan, &methods, &mut NoObserver).unwrap_err().to_string()
    };
    assert!(
        refusal(&|plan| plan.counts = vec![9])
            .contains("9 is no number of training runs; it must be from 5 to 8")
    );
    assert!(refusal(&|plan| plan.properties.push("noise".into())).contains("noise is not constant in run-1"));
    assert!(refusal(&|plan| plan.sensors.push("fabric".into())).contains("there is no column fabric"));
    assert!(refusal(&|plan| plan.methods = vec!["rigde".into()]).contains("did you mean ridge?"));
    assert!(
        refusal(&|plan| plan.sensors.push("stress_ratio".into())).contains("both an output and a sensor")
    );
    assert!(refusal(&|plan| plan.outputs.clear()).contains("at least one output"));
}
