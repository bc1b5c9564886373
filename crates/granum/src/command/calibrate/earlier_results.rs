//! The results of an earlier call in the folder of a call that ends without a posterior.

use std::io::ErrorKind;

use granum_io::Error;
use granum_io::shell::ShowPath;

use super::calibration::Calibration;
use crate::failure::Failure;

/// The folder that takes them.
const EARLIER: &str = "earlier";

/// What a calibration writes of a posterior.
pub const OF_POSTERIOR: [&str; 15] = [
    "posterior.csv",
    "posterior.parquet",
    "posterior.svg",
    "posterior-mean.toml",
    "draws.parquet",
    "draws.toml",
    "inference_data.json",
    "what-tests-tell.svg",
    "next-test.csv",
    "curves.svg",
    "predictions.csv",
    "prediction-errors.csv",
    "surrogate.json",
    "calibration.json",
    "report.html",
];

impl Calibration<'_> {
    /// Moves results of an earlier call out of the way of a failure that leaves none, so that they do not look like those of this call. One that
    /// was interrupted goes on, and replaces them in the end.
    pub fn without_results(&self, failure: Failure, results: &[&str]) -> Failure {
        if failure.is_interruption() {
            return failure;
        }
        match self.set_aside(results) {
            Ok(()) => failure,
            Err(error) => Failure::new(format!("{}; {}", failure.message(), error.message())),
        }
    }

    fn set_aside(&self, results: &[&str]) -> Result<(), Failure> {
        let earlier = self.out.join(EARLIER);
        let mut is_any = false;
        for name in results {
            let path = self.out.join(name);
            if !path.is_file() {
                continue;
            }
            match std::fs::create_dir(&earlier) {
                Err(error) if error.kind() != ErrorKind::AlreadyExists => {
                    return Err(Error::file("create the folder", &earlier)(error).into());
                }
                _ => {}
            }
            std::fs::rename(&path, earlier.join(name)).map_err(Error::file("set aside", &path))?;
            is_any = true;
        }
        if is_any {
            self.context.warn(&format!(
                "the results of an earlier call in {} are not those of this one; they are now in {}",
                self.out.shown(),
                earlier.shown()
            ));
        }
        Ok(())
    }
}
