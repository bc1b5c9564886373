//! The registry of trainers. A new trainer needs a file in this folder and a line in [`ALL`].

use super::adam;
use super::kind::TrainerKind;
use super::lbfgs;
use super::levenberg_marquardt::{self, LevenbergMarquardt};
use super::options::Options;
use super::trainer_trait::SharedTrainer;
use super::traingdx;
use crate::training_error::TrainingError;

/// The trainers of this crate, starting with the default.
pub const ALL: [&TrainerKind; 4] = [&levenberg_marquardt::KIND, &traingdx::KIND, &adam::KIND, &lbfgs::KIND];

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

impl Default for SharedTrainer {
    /// Levenberg-Marquardt with Bayesian regularisation.
    fn default() -> SharedTrainer {
        LevenbergMarquardt::default().into()
    }
}

/// The trainer of the given name, see [`NAMES`].
///
/// ```
/// use granum_nets::trainer::{self, Options};
///
/// let options = Options { epochs: Some(200), ..Options::default() };
/// assert_eq!(trainer::by_name("traingdx", &options)?.name(), "traingdx");
/// let error = trainer::by_name("adem", &options).unwrap_err();
/// assert_eq!(error.to_string(), "there is no trainer \"adem\"; there are: levenberg-marquardt, traingdx, adam, l-bfgs");
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
    kind.map(|kind| (kind.make)(options))
        .ok_or_else(|| TrainingError::UnknownTrainer { name: name.to_string(), known: NAMES.join(", ") })
}

fn check(name: &'static str, value: Option<f64>) -> Result<(), TrainingError> {
    match value {
        Some(value) if !(value >= 0.0 && value.is_finite()) => {
            Err(TrainingError::Option { name, value, expected: "a number that is zero or positive" })
        }
        _ => Ok(()),
    }
}
