//! The state of the recorder of a test, which is written beside each restart file.

use std::io::Write;

use granum_dem::loading::StageEnd;
use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::run::StageEndRecord;
use granum_sensors::{Recorder, SavedRecorder, Sensors};
use serde::{Deserialize, Serialize};

use super::events::Instant;
use super::place::Place;
use crate::task::laboratory_error::LaboratoryError;

/// How far a test has been read, and what was recorded.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct Progress<R = Recorder> {
    /// Number of bytes of the events that have been read.
    pub(super) read: u64,
    /// One recorder for each stage that has begun.
    pub(super) recorders: Vec<R>,
    /// Values of the measure from which the states of each stage are counted.
    pub(super) origins: Vec<f64>,
    /// The ends of the stages that are over.
    pub(super) ends: Vec<StageEnd>,
    /// The states at these ends; those of earlier versions have none.
    #[serde(default)]
    pub(super) stage_ends: Vec<StageEndRecord>,
    /// Values of the measure at which snapshots are still due.
    pub(super) snapshots: Vec<f64>,
    /// The instant at which the present stage began, and the last row.
    pub(super) began: Option<Instant>,
    pub(super) last: Option<Instant>,
    /// Steps before the test, in which the sample came to rest.
    pub(super) steps_before: u64,
    /// Number of instants at which the mean stress of the contacts was compared with that of LAMMPS, and the sum of the squares of the
    /// differences over the mean stress.
    pub(super) compared: u64,
    pub(super) differences: f64,
    /// Largest `dt sqrt(k_t / m)` of a contact.
    pub(super) time_step_fraction: f64,
}

impl Progress {
    /// That of a test that has not begun, with the values at which snapshots are due.
    pub(super) fn new(snapshots: Vec<f64>) -> Progress {
        Progress {
            read: 0,
            recorders: Vec::new(),
            origins: Vec::new(),
            ends: Vec::new(),
            stage_ends: Vec::new(),
            snapshots,
            began: None,
            last: None,
            steps_before: 0,
            compared: 0,
            differences: 0.0,
            time_step_fraction: 0.0,
        }
    }

    /// Writes it beside the restart file of a step.
    pub(super) fn write(&self, place: &Place, step: u64) -> Result<(), LaboratoryError> {
        let path = place.progress(step);
        let text = serde_json::to_string(self).map_err(|error| Error::content(&path, error.to_string()))?;
        Ok(write_atomically(&path, |file| file.write_all(text.as_bytes()))?)
    }

    /// Reads that of a step.
    pub(super) fn read(place: &Place, step: u64, sensors: &Sensors) -> Result<Progress, LaboratoryError> {
        let path = place.progress(step);
        let text = std::fs::read_to_string(&path).map_err(Error::file("read", &path))?;
        let saved: Progress<SavedRecorder> = serde_json::from_str(&text)
            .map_err(|error| Error::content(&path, format!("cannot be read ({error})")))?;
        let recorders = saved.recorders.into_iter().map(|recorder| recorder.with_sensors(sensors));
        Ok(Progress {
            recorders: recorders.collect::<Result<_, _>>()?,
            read: saved.read,
            origins: saved.origins,
            ends: saved.ends,
            stage_ends: saved.stage_ends,
            snapshots: saved.snapshots,
            began: saved.began,
            last: saved.last,
            steps_before: saved.steps_before,
            compared: saved.compared,
            differences: saved.differences,
            time_step_fraction: saved.time_step_fraction,
        })
    }
}
