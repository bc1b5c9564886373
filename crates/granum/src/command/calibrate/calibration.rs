//! What all steps of a calibration know.

use std::path::PathBuf;

use granum_calibration::file::CalibrationFile;
use granum_calibration::likelihood::FreeParameter;
use granum_calibration::target::Target;

use crate::command::campaign::CarryOutFlags;
use crate::context::Context;

/// What all steps know.
pub struct Calibration<'a> {
    pub context: &'a Context,
    pub file: &'a CalibrationFile,
    pub targets: &'a [Target],
    pub parameters: Vec<FreeParameter>,
    pub out: PathBuf,
    pub flags: &'a CarryOutFlags,
}
