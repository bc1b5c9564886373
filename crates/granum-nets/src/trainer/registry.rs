//! The registry of trainers. A new trainer needs a file in this folder and a line in [`ALL`].

use granum_simd::Isa;

use super::{SharedTrainer, TrainingError, levenberg_marquardt, traingdx};

/// An entry of the registry: a name, and the function that creates the trainer from options.
#[derive(Clone, Copy, Debug)]
pub struct TrainerKind {
    /// Its name in commands and records.
    pub name: &'static str,
    /// A short description.
    pub help: &'static str,
    /// Creates the trainer.
    pub make: fn(&Options) -> SharedTrainer,
}

/// The trainers of this crate, starting with the default.
pub const ALL: [&TrainerKind; 2] = [&levenberg_marquardt::KIND, &traingdx::KIND];

/// The names that [`by_name`] accepts, starting with the default.
pub const NAMES: [&str; ALL.len()] = {
    let mut names = [""; ALL.len()];
    let mut k = 0;
    while k < names.len() {
        names[k] = ALL[k].name;
        k += 1;
    }
    names
};

/// Options of a trainer. A field that is `None` has the value of the trainer.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Options {
    /// Largest number of epochs.
    pub epochs: Option<u64>,
    /// Training ends when the mean squared error (scaled units) is at or below this.
    pub goal: Option<f64>,
    /// Training ends when the Euclidean norm of the gradient of the trainer's objective is at or below this.
    pub minimum_gradient: Option<f64>,
    /// Training with validation rows ends when their error has not fallen for so many accepted steps in a row.
    pub maximum_failures: Option<u64>,
    /// Initial ratio of Bayesian regularisation, see [`super::LevenbergMarquardt::first_ratio`].
    pub first_ratio: Option<f64>,
    /// The instruction set; by default the widest that the processor supports. Results do not depend on it.
    pub isa: Option<Isa>,
}

/// The trainer of the given name, see [`NAMES`].
///
/// ```
/// use granum_nets::trainer::{self, Options};
///
/// let options = Options { epochs: Some(200), ..Options::default() };
/// assert_eq!(trainer::by_name("traingdx", &options)?.name(), "traingdx");
/// let error = trainer::by_name("adam", &options).unwrap_err();
/// assert_eq!(error.to_string(), "there is no trainer \"adam\"; known are levenberg-marquardt, traingdx");
/// # Ok::<(), granum_nets::trainer::TrainingError>(())
/// ```
///
/// # Errors
/// If there is no such trainer, or an option is out of bounds.
pub fn by_name(name: &str, options: &Options) -> Result<SharedTrainer, TrainingError> {
    check("goal", options.goal)?;
    check("first_ratio", options.first_ratio)?;
    check("minimum_gradient", options.minimum_gradient)?;
    let kind = ALL.iter().find(|kind| kind.name == name);
    kind.map(|kind| (kind.make)(options)).ok_or_else(|| TrainingError::UnknownTrainer(name.to_string()))
}

fn check(name: &'static str, value: Option<f64>) -> Result<(), TrainingError> {
    match value {
        Some(value) if !(value >= 0.0 && value.is_finite()) => {
            Err(TrainingError::Option { name, value, expected: "a number that is zero or positive" })
        }
        _ => Ok(()),
    }
}
