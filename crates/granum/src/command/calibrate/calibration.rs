//! What all steps of a calibration know.

use std::path::PathBuf;

use granum_calibration::file::CalibrationFile;
use granum_calibration::inference::likelihood::FreeParameter;
use granum_calibration::simulations::target::TargetTest;
use granum_io::LaboratoryTest;

use crate::command::campaign::CarryOutFlags;
use crate::context::Context;

/// What all steps know.
pub struct Calibration<'a> {
    pub context: &'a Context,
    pub file: &'a CalibrationFile,
    /// The tests that are calibrated on, then those that are predicted.
    pub all: &'a [TargetTest],
    /// The tests that are calibrated on.
    pub targets: &'a [TargetTest],
    /// All tests of the laboratory's files.
    pub laboratory: &'a [LaboratoryTest],
    pub parameters: Vec<FreeParameter>,
    pub out: PathBuf,
    /// Folders of earlier campaigns whose runs take the place of the design; none for a design.
    pub earlier: &'a [PathBuf],
    pub flags: &'a CarryOutFlags,
}
