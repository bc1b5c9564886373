//! Time of predictions of many rows, with which `benches/python/predict.py` compares that of the same predictions from Python:
//! `predict_rows SURROGATE ROWS`, where ROWS is a table (CSV or Parquet) with the inputs as columns.
//!
//! Prints a line for the means and one for predictions with intervals of 90 %: seconds, and the bits of all means, one combined with the other by
//! exclusive or, which show that both predict the same.

use std::hint::black_box;
use std::process::ExitCode;
use std::time::Instant;

use granum_learn::SurrogateMethods;
use granum_learn::surrogate::RunInputs;

fn main() -> ExitCode {
    let words: Vec<String> = std::env::args().skip(1).collect();
    match measure(&words) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}

fn measure(words: &[String]) -> Result<(), Box<dyn std::error::Error>> {
    let [surrogate, rows] = words else { return Err("usage: predict_rows SURROGATE ROWS".into()) };
    let surrogate = SurrogateMethods::standard().load(surrogate.as_ref())?;
    let names = surrogate.columns().input_names();
    let table = granum_io::formats::read_table(rows)?;
    let columns = names.iter().map(|name| table.column(name)).collect::<Result<Vec<&[f64]>, _>>()?;
    let rows: Vec<f64> =
        (0..table.rows()).flat_map(|row| columns.iter().map(move |column| column[row])).collect();

    let begin = Instant::now();
    let inputs = RunInputs::new(rows.clone(), names.len(), vec![1; table.rows()])?;
    let means = black_box(surrogate.means(&inputs)?);
    let seconds = begin.elapsed().as_secs_f64();
    println!("means {seconds} {}", means.iter().flatten().fold(0, |bits, mean| bits ^ mean.to_bits()));

    let begin = Instant::now();
    let inputs = RunInputs::new(rows, names.len(), vec![1; table.rows()])?;
    let found = black_box(surrogate.predict(&inputs, 0.9)?);
    let seconds = begin.elapsed().as_secs_f64();
    let bits = found.iter().flat_map(|one| &one.values).fold(0, |bits, value| bits ^ value.mean.to_bits());
    println!("intervals {seconds} {bits}");
    Ok(())
}
