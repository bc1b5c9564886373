//! Tests of the networks of a mapping as a surrogate among others.

use granum_core::observer::NoObserver;
use granum_learn::compare;
use granum_learn::dataset::NamedRecord;
use granum_learn::networks::networks_of;
use granum_learn::study::NoStudyObserver;
use granum_learn::surrogate::{Cause, Content, FitSpec, SurrogateMethod, SurrogateMethods, save, to_json};

use crate::mapping::paper_mapping;
use crate::synthetic::{Law, dataset_of, parts, records, spec_of};
use crate::{Evaluation, MappingMethod, PaperData, PaperDataOptions, PaperOptions};

/// The networks of a mapping and ridge regression, scored as any surrogate, have exactly the same scores as in the study of the paper.
#[test]
fn networks_and_ridge_have_the_scores_of_the_study_as_any_surrogate() {
    let records = records(Law::Hidden, 4);
    let dataset = dataset_of(&records);
    let parts = parts(&dataset);
    let mapping = paper_mapping("F3").unwrap().with_neurons(4);
    let methods = SurrogateMethods::standard().replaced_by(MappingMethod::new(mapping.clone()));
    let asked = ["antony2006", "ridge"].map(|name| methods.by_name(name).unwrap());
    let scores = compare(&parts, &spec_of(&dataset, "F3"), &asked, 0.9, &mut NoObserver).unwrap();

    let names = ["a", "b", "c", "d"];
    let named: Vec<NamedRecord> =
        records.iter().zip(names).map(|(record, name)| NamedRecord { name, seed: 0, record }).collect();
    let data = PaperData::from_records(&named[..2], &named[2..], &PaperDataOptions::default()).unwrap();
    let options = PaperOptions { mappings: vec![mapping], ..Default::default() };
    let study = options.train(&data, &NoStudyObserver).unwrap();
    let evaluation = &Evaluation::of_study(&study, &data).unwrap()[0];
    for (scored, known) in scores.iter().zip([&evaluation.network, &evaluation.ridge]) {
        let name = &scored.method;
        assert_eq!(scored.training, known.training, "{name}");
        assert_eq!(scored.held_out, known.held_out, "{name}");
        assert_eq!(scored.unseen, known.unseen, "{name}");
    }
    for known in &scores {
        assert!(known.coverage.is_some_and(|share| share > 0.7), "{} {:?}", known.method, known.coverage);
    }
}

#[test]
fn a_mapping_comes_back_from_its_file_with_the_same_bits() {
    let dataset = dataset_of(&records(Law::Plain, 3));
    let parts = parts(&dataset);
    let method = MappingMethod::new(paper_mapping("F2").unwrap().with_neurons(3));
    let fitted = method.fit(&parts.training, &spec_of(&dataset, "F2"), &mut NoObserver).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("F2.json");
    save(&path, fitted.as_ref()).unwrap();
    let methods = SurrogateMethods::standard().replaced_by(MappingMethod::default());
    let loaded = methods.load(&path).unwrap();
    assert_eq!((loaded.method(), loaded.columns()), ("antony2006", fitted.columns()));
    let rows = parts.unseen.values(&loaded.columns().input_names()).unwrap();
    let predictions = loaded.predict_rows(&rows, 0.8).unwrap();
    assert_eq!(predictions, fitted.predict_rows(&rows, 0.8).unwrap());
    assert_eq!(predictions[0].values.len(), 14);
    let alien = MappingMethod::default().load(loaded.columns().clone(), &Content::new(&["alien"]).unwrap());
    let refusal = alien.err().unwrap().to_string();
    assert!(refusal.contains("the content is not that of a surrogate of this method"), "{refusal}");
    // Without the method its files are refused.
    let text = to_json(fitted.as_ref()).unwrap();
    let unknown = SurrogateMethods::standard().from_json(&text, "F2.json").err().unwrap().to_string();
    assert!(unknown.contains("no surrogate method `antony2006`"), "{unknown}");

    // The content that earlier versions wrote.
    let networks = networks_of(fitted.as_ref()).unwrap();
    let values: Vec<serde_json::Value> =
        networks.networks().iter().map(|model| model.to_value().unwrap()).collect();
    let sub_models = networks.mapping().sub_models.iter().map(|sub_model| {
        serde_json::json!({ "strain_range": sub_model.range, "hidden": sub_model.hidden, "epochs": sub_model.epochs })
    });
    let old = serde_json::json!({
        "mapping": {
            "name": "F2",
            "inputs": ["deviator_strain", "stress_ratio"],
            "output": "force_distribution",
            "sub_models": sub_models.collect::<Vec<_>>(),
        },
        "form": "point",
        "forces": networks.mapping().output_centres(),
        "networks": values,
    });
    let old = Content::new(&old).unwrap();
    let read = MappingMethod::default().load(fitted.columns().clone(), &old).unwrap();
    assert_eq!(read.predict_rows(&rows, 0.8).unwrap(), predictions);
}

/// As a surrogate, a mapping predicts all bins of a distribution at once, with the values of the networks of the study.
#[test]
fn a_mapping_as_a_surrogate_answers_as_the_networks_of_the_study() {
    let records = records(Law::Plain, 3);
    let dataset = dataset_of(&records);
    let parts = parts(&dataset);
    let mapping = paper_mapping("F2").unwrap().with_neurons(3);
    let fitted = MappingMethod::new(mapping.clone())
        .fit(&parts.training, &spec_of(&dataset, "F2"), &mut NoObserver)
        .unwrap();
    let rows = parts.unseen.values(&["deviator_strain", "stress_ratio"]).unwrap();
    let predictions = fitted.predict_rows(&rows, 0.9).unwrap();

    let names = ["a", "b", "c"];
    let named: Vec<NamedRecord> =
        records.iter().zip(names).map(|(record, name)| NamedRecord { name, seed: 0, record }).collect();
    let data = PaperData::from_records(&named[..1], &named[1..], &PaperDataOptions::default()).unwrap();
    let options = PaperOptions { mappings: vec![mapping], ..Default::default() };
    let study = options.train(&data, &NoStudyObserver).unwrap();
    let networks = crate::evaluation::networks(&study, "F2").unwrap();
    let alone = networks.predict_states(&rows).unwrap();
    assert_eq!(predictions.len(), alone.len());
    for (prediction, alone) in predictions.iter().zip(&alone) {
        let means: Vec<f64> = prediction.values.iter().map(|value| value.mean).collect();
        assert_eq!(means, alone.values);
        for value in &prediction.values {
            let own = value.interval.as_ref().unwrap();
            assert!(own.lower < value.mean && value.mean < own.upper);
            // With a single run, the difference between runs is unknown.
            assert!(own.causes.iter().map(|(cause, _)| *cause).eq([Cause::Noise, Cause::Parameters]));
        }
    }
    let message = |spec: FitSpec| {
        MappingMethod::default().fit(&dataset, &spec, &mut NoObserver).err().unwrap().to_string()
    };
    let text = message(FitSpec::new(["deviator_strain"], ["stress_ratio"]));
    assert!(
        text.contains("no mapping goes from (deviator_strain) to (stress_ratio); there are: q/p = F1("),
        "{text}"
    );
}
