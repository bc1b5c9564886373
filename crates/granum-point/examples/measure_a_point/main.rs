//! Measures what a user of a material point must know of a small cell; the tables of the chapter "granum in finite elements" are its
//! output.
//!
//! ```sh
//! cargo run --release -p granum-point --example measure_a_point -- [parts|growth|objectivity|stiffness|size|drained|surrogate]
//! ```

mod cuts;
mod drained;
mod growth;
mod objectivity;
mod sand;
mod stiffness;
mod surrogate;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let is_asked = |name: &str| names.is_empty() || names.iter().any(|asked| asked == name);
    if is_asked("parts") {
        cuts::table()?;
    }
    if is_asked("growth") {
        growth::table()?;
    }
    if is_asked("objectivity") {
        objectivity::table()?;
    }
    if is_asked("stiffness") {
        stiffness::table()?;
    }
    if is_asked("drained") {
        drained::table()?;
    }
    if is_asked("surrogate") {
        surrogate::table()?;
    }
    if is_asked("size") {
        sand::scatter()?;
    }
    Ok(())
}
