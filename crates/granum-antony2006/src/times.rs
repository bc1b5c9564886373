//! `seconds.json` of a reproduction: the times that `summary.json` and the report leave out, since they depend on the computer
//! and on interruptions. All other files of a reproduction have the same bytes on every computer.

use std::path::Path;

use granum_io::sealed::{unseal, write_sealed};
use serde::{Deserialize, Serialize};

use crate::summary::{PaperSummary, SpeedSummary};
use granum_learn::Result;
use granum_learn::networks::TIMES_FILE;

/// The content of the file; its keys are those that earlier versions wrote into `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SummaryTimes {
    /// Times of the DEM runs.
    pub dem: DemTimes,
    /// Computing time of the networks compared with DEM.
    pub speed: SpeedSummary,
}

/// Times of the DEM runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DemTimes {
    /// The runs in the order of the summary.
    pub runs: Vec<RunTime>,
}

/// The time of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunTime {
    /// `training` or `unseen`.
    pub role: String,
    /// Seed of the sample.
    pub seed: u64,
    /// Wall time of preparation and shear, s.
    pub wall_seconds: f64,
}

impl SummaryTimes {
    /// The times that a summary holds in memory.
    pub fn from_summary(summary: &PaperSummary) -> SummaryTimes {
        let runs = summary.dem.runs.iter().map(|run| RunTime {
            role: run.role.clone(),
            seed: run.seed,
            wall_seconds: run.wall_seconds,
        });
        SummaryTimes { dem: DemTimes { runs: runs.collect() }, speed: summary.speed.clone() }
    }

    /// Writes the file to the folder of a reproduction.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        Ok(write_sealed(&folder.join(TIMES_FILE), self)?)
    }

    /// Reads the file; `None` if it is missing or damaged, since no result depends on times.
    pub fn read(folder: &Path) -> Option<SummaryTimes> {
        let path = folder.join(TIMES_FILE);
        let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT).ok()?;
        serde_json::from_str(&unseal(&path, &text).ok()?.text).ok()
    }

    /// Adds the times to a summary that was read from its file.
    pub fn add_to(self, summary: &mut PaperSummary) {
        summary.speed = self.speed;
        for run in &mut summary.dem.runs {
            let own = self.dem.runs.iter().find(|time| time.role == run.role && time.seed == run.seed);
            run.wall_seconds = own.map_or(run.wall_seconds, |time| time.wall_seconds);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::summary::RunSummary;

    #[test]
    fn times_are_kept_beside_the_summary_and_come_back() {
        let run = RunSummary { role: "unseen".into(), seed: 12, wall_seconds: 2.5, grain_steps: 1e9 };
        let speed = SpeedSummary { dem_seconds: 2.0, factor: 9e3, states: 40, ..SpeedSummary::default() };
        let mut whole = PaperSummary { speed, ..PaperSummary::default() };
        whole.dem.runs.push(run);
        let text = serde_json::to_string(&whole).unwrap();
        assert!(!text.contains("seconds") && !text.contains("factor"), "{text}");
        let folder = tempfile::tempdir().unwrap();
        SummaryTimes::from_summary(&whole).write(folder.path()).unwrap();
        let mut back: PaperSummary = serde_json::from_str(&text).unwrap();
        SummaryTimes::read(folder.path()).unwrap().add_to(&mut back);
        assert_eq!(back, whole);
        std::fs::write(folder.path().join(TIMES_FILE), "{}").unwrap();
        assert_eq!(SummaryTimes::read(folder.path()), None);
        // Earlier versions wrote times into the summary.
        let old = r#"{"role": "unseen", "seed": 12, "wall_seconds": 2.5, "grain_steps": 1e9}"#;
        assert_eq!(serde_json::from_str::<RunSummary>(old).unwrap().wall_seconds, 2.5);
    }
}
