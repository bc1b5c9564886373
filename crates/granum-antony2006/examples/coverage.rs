//! Coverage of the 90 % intervals of the networks on states of unseen runs.
//!
//! ```text
//! cargo run --release -p granum-antony2006 --example coverage -- --runs run-1 run-2 run-3 run-4 --judge run-5 run-6 [--form histogram]
//! ```
//!
//! prints one line per mapping: the share of states (or of bins of states if P(f) is the output) within the intervals, for
//! each sub-model and for all, and the mean width of the intervals over the range of the output.

use std::error::Error;

use granum_antony2006::evaluation::networks;
use granum_antony2006::{PaperData, PaperDataOptions, PaperOptions};
use granum_learn::networks::{Form, SubModelNetworks};
use granum_learn::study::NoStudyObserver;
use granum_learn::surrogate::RunInputs;
use granum_learn::{Dataset, NamedRecord, Surrogate};
use granum_sensors::Record;

const LEVEL: f64 = 0.9;

fn main() -> Result<(), Box<dyn Error>> {
    let (mut training, mut judging, mut form, mut key) = (Vec::new(), Vec::new(), Form::Point, String::new());
    for word in std::env::args().skip(1) {
        match (key.as_str(), word.as_str()) {
            (_, "--runs" | "--judge" | "--form") => key = word,
            ("--runs", _) => training.push(word),
            ("--judge", _) => judging.push(word),
            ("--form", "histogram") => form = Form::Histogram,
            ("--form", "point") => form = Form::Point,
            _ => {
                return Err(format!("{word}: write --runs A B ... --judge C D ... [--form histogram]").into());
            }
        }
    }
    let (training, judging) = (read(&training)?, read(&judging)?);
    let data = PaperData::from_records(&named(&training), &named(&judging), &PaperDataOptions::default())?;
    let options = PaperOptions { form, ..PaperOptions::default() };
    let study = options.train(&data, &NoStudyObserver)?;
    println!("{} training runs, {} judging runs", training.len(), judging.len());
    for fit in &study.fits {
        let counts = coverage(networks(&study, &fit.name)?, &data.parts.unseen)?;
        let all = counts.iter().fold((0, 0, 0.0), |a, c| (a.0 + c.0, a.1 + c.1, a.2 + c.2));
        let percent = |c: &Count| format!("{:5.1}", 100.0 * c.0 as f64 / c.1 as f64);
        let each: Vec<String> = counts.iter().map(percent).collect();
        let width = all.2 / all.1 as f64;
        println!("{} {} | {} | width {width:.4}", fit.name, each.join(" "), percent(&all));
    }
    Ok(())
}

/// For one sub-model: the number of values within the interval, the number of values, and the sum of the widths.
type Count = (usize, usize, f64);

fn coverage(networks: &SubModelNetworks, states: &Dataset) -> Result<Vec<Count>, Box<dyn Error>> {
    let mapping = networks.mapping();
    let columns = Surrogate::columns(networks);
    let mut counts = vec![(0, 0, 0.0); mapping.sub_models.len()];
    let inputs = RunInputs::from_dataset(states, columns)?;
    let exact = states.values(&columns.output_names())?;
    let predictions = networks.predict(&inputs, LEVEL)?;
    for ((row, exact), prediction) in
        inputs.rows().zip(exact.chunks_exact(columns.outputs.len())).zip(&predictions)
    {
        let (sub_model, inside) = mapping.sub_model_at(mapping.coordinate_of(row));
        for (value, estimate) in exact.iter().zip(&prediction.values) {
            let (true, Some(interval)) = (inside, &estimate.interval) else { continue };
            counts[sub_model].0 += usize::from(interval.lower <= *value && *value <= interval.upper);
            counts[sub_model].1 += 1;
            counts[sub_model].2 += interval.upper - interval.lower;
        }
    }
    Ok(counts)
}

fn read(folders: &[String]) -> Result<Vec<(String, Record)>, Box<dyn Error>> {
    let open = |folder: &String| -> Result<(String, Record), Box<dyn Error>> {
        Ok((folder.clone(), granum_run::record::read_record(&granum_io::Run::at(folder)?)?))
    };
    folders.iter().map(open).collect()
}

fn named(runs: &[(String, Record)]) -> Vec<NamedRecord<'_>> {
    runs.iter().map(|(name, record)| NamedRecord { name, seed: 0, record }).collect()
}
