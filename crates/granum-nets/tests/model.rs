//! Models: training, prediction, saving and loading.

use std::path::PathBuf;

use granum_nets::trainer::{LevenbergMarquardt, NoObserver, Trainer, Traingdx};
use granum_nets::{Data, Model, ModelColumn, ModelDefinition, ModelError};
use proptest::prelude::*;

fn definition() -> ModelDefinition {
    ModelDefinition {
        inputs: vec![
            ModelColumn::new("deviator_strain", "1"),
            ModelColumn::new("mean_stress", "Pa"),
            ModelColumn::new("constant", "m"),
        ],
        output: ModelColumn::new("stress_ratio", "1"),
        quantities: Vec::new(),
        shares: Vec::new(),
        hidden: vec![8, 7],
        seed: 11,
    }
}

fn truth(strain: f64, stress: f64) -> f64 {
    0.7 * (1.0 - (-20.0 * strain).exp()) * (1.0 + stress / 1e5)
}

/// Deterministic noise of standard deviation one (sum of twelve uniform numbers).
fn noise(k: usize) -> f64 {
    let mut h = k as u64 ^ 0x9e37_79b9_7f4a_7c15;
    let mut sum = -6.0;
    for _ in 0..12 {
        h = h.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (h >> 11) as f64 / 9_007_199_254_740_992.0;
    }
    sum
}

fn data(rows: usize) -> Data {
    let mut inputs = Vec::new();
    let mut targets = Vec::new();
    for r in 0..rows {
        let (strain, stress) = (0.3 * (r % 30) as f64 / 29.0, 2e4 + 1e4 * (r as f64 * 0.61).sin());
        inputs.extend([strain, stress, 1e-4]);
        targets.push(truth(strain, stress) + 0.01 * noise(r));
    }
    Data::new(inputs, 3, targets).unwrap()
}

fn model() -> Model {
    Model::fit(&definition(), &data(120), &LevenbergMarquardt::default(), &mut NoObserver).unwrap().0
}

/// A temporary folder, which is removed when it is dropped.
struct Folder(PathBuf);
impl Folder {
    fn new(name: &str) -> Folder {
        let path = std::env::temp_dir().join(format!("granum-nets-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&path).unwrap();
        Folder(path)
    }
}
impl Drop for Folder {
    fn drop(&mut self) {
        let _ = std::fs::remove_dir_all(&self.0);
    }
}

#[test]
fn a_model_predicts_in_the_units_of_its_columns() {
    let model = model();
    for (strain, stress) in [(0.05, 2e4), (0.1, 1.5e4), (0.29, 2.9e4)] {
        let prediction = model.predict(&[strain, stress, 1e-4]).unwrap();
        assert!((prediction.value - truth(strain, stress)).abs() < 0.01, "{prediction:?}");
        let deviation = prediction.standard_deviation.unwrap();
        assert!(deviation > 0.008 && deviation < 0.02, "{deviation}");
        assert!(prediction.outside.is_empty());
    }
    let fit = model.training_fit();
    assert!(fit.rms_error < 0.011 && (fit.noise.unwrap() / 0.01 - 1.0).abs() < 0.25, "{fit:?}");
    assert_eq!((model.provenance().rows, model.provenance().seed), (120, 11));
    assert_eq!(model.provenance().dataset_hash, data(120).hash());
}

#[test]
fn the_uncertainty_covers_new_observations() {
    let model = model();
    let fresh: Vec<(f64, f64, f64)> = (0..2000)
        .map(|k| {
            let (strain, stress) =
                (0.3 * ((k as f64 * 0.618_034) % 1.0), 2e4 + 0.99e4 * (k as f64 * 1.3).sin());
            (strain, stress, truth(strain, stress) + 0.01 * noise(k + 5000))
        })
        .collect();
    let inside = fresh.iter().filter(|(strain, stress, seen)| {
        let p = model.predict(&[*strain, *stress, 1e-4]).unwrap();
        (p.value - seen).abs() < 1.96 * p.standard_deviation.unwrap()
    });
    let coverage = inside.count() as f64 / fresh.len() as f64;
    assert!(
        coverage > 0.9 && coverage < 0.99,
        "{coverage} of the observations lie within 1.96 standard deviations"
    );
    let far = model.predict(&[0.6, 6e4, 1e-4]).unwrap();
    let near = model.predict(&[0.15, 2e4, 1e-4]).unwrap();
    assert!(far.standard_deviation.unwrap() > 3.0 * near.standard_deviation.unwrap());
}

#[test]
fn rows_outside_the_range_are_flagged() {
    let model = model();
    let outside = |row: &[f64]| model.predict(row).unwrap().outside;
    assert_eq!(outside(&[0.31, 2e4, 1e-4]), ["deviator_strain"]);
    assert_eq!(outside(&[-1e-9, 1e3, 2e-4]), ["deviator_strain", "mean_stress", "constant"]);
    assert!(outside(&[0.3, 2e4, 1e-4]).is_empty());
    let batch = model.predict_batch(&[0.3, 2e4, 1e-4, 0.31, 2e4, 1e-4]).unwrap();
    assert_eq!(batch.outside, [false, true]);
}

#[test]
fn rows_that_are_none_are_refused() {
    let model = model();
    let message = |row: &[f64]| model.predict(row).unwrap_err().to_string();
    assert_eq!(
        message(&[0.1]),
        "a row for this model has 3 inputs (deviator_strain, mean_stress, constant), not 1"
    );
    assert_eq!(message(&[0.1, f64::NAN, 0.0]), "row 0, input mean_stress: NaN is not a finite number");
    assert!(model.predict_batch(&[0.1; 4]).is_err());
    assert!(model.predict_batch(&[]).unwrap().values.is_empty());
    let wrong = ModelDefinition { inputs: vec![ModelColumn::new("x", "1")], ..definition() };
    assert!(matches!(
        Model::fit(&wrong, &data(20), &LevenbergMarquardt::default(), &mut NoObserver),
        Err(ModelError::Columns(_))
    ));
}

#[test]
fn one_row_and_a_batch_give_the_same_bits() {
    let model = model();
    let rows: Vec<f64> = (0..100).flat_map(|k| [0.003 * k as f64, 2e4 + 50.0 * k as f64, 1e-4]).collect();
    let batch = model.predict_batch(&rows).unwrap();
    let deviations = model.standard_deviations(&rows).unwrap().unwrap();
    for (k, row) in rows.chunks(3).enumerate() {
        let one = model.predict(row).unwrap();
        assert_eq!(one.value.to_bits(), batch.values[k].to_bits());
        assert_eq!(one.standard_deviation.unwrap().to_bits(), deviations[k].to_bits());
    }
}

#[test]
fn a_saved_model_comes_back_whole() {
    let folder = Folder::new("round-trip");
    for trainer in
        [&LevenbergMarquardt::default() as &dyn Trainer, &Traingdx { epochs: 50, ..Default::default() }]
    {
        let (model, _) = Model::fit(&definition(), &data(120), trainer, &mut NoObserver).unwrap();
        let path = folder.0.join("model.json");
        model.save(&path).unwrap();
        let loaded = Model::load(&path).unwrap();
        assert_eq!(loaded.network(), model.network());
        assert_eq!(loaded.inputs(), model.inputs());
        assert_eq!(loaded.output(), model.output());
        assert_eq!(loaded.input_scalers(), model.input_scalers());
        assert_eq!(loaded.output_scaler(), model.output_scaler());
        assert_eq!(loaded.provenance(), model.provenance());
        assert_eq!(loaded.training_fit(), model.training_fit());
        assert_eq!(loaded.to_json(), model.to_json());
        let row = [0.123, 2.2e4, 1e-4];
        assert_eq!(loaded.predict(&row).unwrap(), model.predict(&row).unwrap());
        assert_eq!(loaded.predict(&row).unwrap().standard_deviation.is_some(), trainer.name() != "traingdx");
    }
    let names: Vec<_> = std::fs::read_dir(&folder.0).unwrap().map(|e| e.unwrap().file_name()).collect();
    assert_eq!(names, ["model.json"], "nothing else is left behind");
}

/// A model that was stored in another file gives bit-identical predictions.
#[test]
fn a_model_comes_back_from_a_value() {
    let model = model();
    let text = serde_json::to_string(&model.to_value().unwrap()).unwrap();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(Model::from_value(&value, "f").unwrap().to_json(), model.to_json());
    let forged = |pointer: &str, to: serde_json::Value| {
        let mut value = value.clone();
        *value.pointer_mut(pointer).unwrap() = to;
        Model::from_value(&value, "f").unwrap_err().to_string()
    };
    assert!(forged("/version", 9.into()).contains("found format \"granum model\" version 9"));
    assert!(forged("/layers/0/neurons", 7.into()).contains("takes 8 inputs, but the layer before gives 7"));
}

/// The squares of the standard deviations by cause add up to that of the total, which is the value without causes.
#[test]
fn standard_deviations_are_split_by_cause() {
    let rows: Vec<f64> = (0..20).flat_map(|k| [0.02 * k as f64, 2e4, 1e-4]).collect();
    let alone = model();
    let blocks = |count: usize| (0..120).map(|k| k * count / 120).collect();
    let data = data(120).with_blocks(blocks(4)).unwrap().with_spread_column(0).unwrap();
    let (several, _) =
        Model::fit(&definition(), &data, &LevenbergMarquardt::default(), &mut NoObserver).unwrap();
    for model in [alone, several] {
        let totals = model.standard_deviations(&rows).unwrap().unwrap();
        let split = model.deviations_of(&rows, 1).unwrap().unwrap();
        // Many rows, and one that is beyond all numbers when it is scaled.
        let mut many: Vec<f64> = (0..700).flat_map(|k| [0.001 * k as f64, 2e4, 1e-4]).collect();
        many[3 * 350 + 1] = f64::MAX;
        for points in [1, 7] {
            let (together, deviations) = model.predict_batch_with_deviations(&many, points).unwrap();
            assert_eq!(together, model.predict_batch(&many).unwrap());
            assert_eq!(deviations, model.deviations_of(&many, points).unwrap());
        }
        assert!(model.predict_batch_with_deviations(&many, 3).is_err());
        for (total, split) in totals.iter().zip(&split) {
            assert_eq!(*total, split.total);
            let squares = split.noise.powi(2) + split.weights.powi(2) + split.blocks.powi(2);
            assert!((squares.sqrt() / total - 1.0).abs() < 1e-12, "{split:?}");
            assert!(split.noise > 0.0 && split.weights > 0.0);
            assert!(model.blocks().is_some() || split.blocks == 0.0);
        }
        // Outside the training rows the weights are less certain, whereas the noise is the same.
        assert!(split[19].weights > 2.0 * split[5].weights);
    }
}

#[test]
fn damaged_files_are_told_apart() {
    let text = model().to_json();
    let message = |text: &str| Model::from_json(text, "f.json").unwrap_err().to_string();
    assert!(message(&text[..text.len() / 2]).contains("truncated"));
    assert!(message("").contains("truncated"));
    assert!(message(&text[..text.rfind(",\n  \"checksum\"").unwrap()]).contains("truncated"));
    assert!(message("{}").contains("\"format\" should be \"granum model\""));
    assert!(message("strain,stress\n1,2\n").contains("not a model file"));
    let newer = text.replacen("\"version\": 3", "\"version\": 4", 1);
    assert!(message(&newer).contains("written by a newer granum (format version 4, this program reads 3)"));
    let altered = text.replacen("\"seed\": 11", "\"seed\": 12", 1);
    assert!(message(&altered).starts_with("f.json: the checksum does not match"));
    let error = Model::load(&std::env::temp_dir().join("granum-there-is-no-such-model.json")).unwrap_err();
    assert!(error.to_string().contains("granum-there-is-no-such-model.json"));
    let folder = Folder::new("unwritable");
    assert!(model().save(&folder.0.join("none").join("model.json")).is_err());
    std::fs::write(folder.0.join("bytes"), [0xff, 0xfe, 0x00]).unwrap();
    assert!(Model::load(&folder.0.join("bytes")).unwrap_err().to_string().contains("not UTF-8"));
}

/// Updates the checksum of a modified text, as somebody would do who edits a file deliberately.
fn sealed(text: &str) -> String {
    let at = text.rfind(",\n  \"checksum\": \"").unwrap();
    let sum = if text.contains("\"version\": 3") {
        granum_core::digest::sha256(&text.as_bytes()[..at])
    } else {
        // Files of versions 1 and 2 have the hash of Fowler, Noll and Vo (1a).
        let fold = |h: u64, b: u8| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3);
        format!("{:016x}", text[..at].bytes().fold(0xcbf2_9ce4_8422_2325u64, fold))
    };
    format!("{},\n  \"checksum\": \"{sum}\"\n}}\n", &text[..at])
}

#[test]
fn forged_files_are_refused_without_harm() {
    let text = model().to_json();
    assert!(Model::from_json(&sealed(&text), "f").is_ok());
    // Files of version 2, which have a shorter checksum, can be read.
    let second = sealed(&text.replacen("\"version\": 3", "\"version\": 2", 1));
    assert_eq!(Model::from_json(&second, "f").unwrap().to_json(), text);
    assert!(Model::from_json(&second.replacen("\"seed\": 11", "\"seed\": 12", 1), "f").is_err());
    // Files of version 1 contain no intervals, but can still be used for predictions.
    let old = text.replacen("\"version\": 3", "\"version\": 1", 1);
    let from = old.find(",\n    \"answer_range\"").unwrap();
    let to = old[from..].find("\n  },\n  \"layers\"").unwrap() + from;
    let old = Model::from_json(&sealed(&format!("{}{}", &old[..from], &old[to..])), "f").unwrap();
    assert_eq!((old.blocks(), old.is_constant(), old.training_fit().answer_range), (None, false, None));
    let forged = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        Model::from_json(&sealed(&text.replacen(from, to, 1)), "f").unwrap_err().to_string()
    };
    assert!(forged("\"neurons\": 8", "\"neurons\": 4000000000").contains("but the layer before gives"));
    assert!(
        forged("\"neurons\": 8", "\"neurons\": 9").contains("takes 8 inputs, but the layer before gives 9")
    );
    assert!(
        forged("\"inputs\": 3", "\"inputs\": 4").contains("takes 4 inputs, but the layer before gives 3")
    );
    assert!(forged("\"activation\": \"tanh\"", "\"activation\": \"relu\"").contains("relu"));
    assert!(forged("\"maximum\": 0.3", "\"maximum\": -1").contains("column deviator_strain"));
    assert!(forged("\"weights\": [", "\"weights\": [1.0, ").contains("weights"));
    assert!(forged("\"seed\": 11", "\"seed\": 11, \"extra\": 1").contains("extra"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]
    #[test]
    fn any_altered_byte_is_noticed(at in any::<prop::sample::Index>(), flip in 1u8..=255) {
        use std::sync::OnceLock;
        static TEXT: OnceLock<String> = OnceLock::new();
        let mut bytes = TEXT.get_or_init(|| model().to_json()).clone().into_bytes();
        let at = at.index(bytes.len());
        bytes[at] ^= flip;
        // The newline after the closing brace is the only byte that may change.
        if let Ok(text) = String::from_utf8(bytes) && at + 1 < text.len() {
            prop_assert!(Model::from_json(&text, "f").is_err(), "byte {at}");
        }
    }
}
