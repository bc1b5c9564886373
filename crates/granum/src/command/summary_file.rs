//! Files of a finished reproduction: its summary, and the page with its computing times.

use std::io::Write;
use std::path::Path;

use granum_antony2006::reproduction::{SPEED_FILE, SUMMARY_FILE};
use granum_antony2006::times::SummaryTimes;
use granum_antony2006::{PaperSummary, StudyReport, speed_page};
use granum_io::atomic::write_atomically;
use granum_io::sealed::unseal;
use granum_io::shell::ShowPath;

use crate::failure::Failure;

/// Reads the summary of a finished reproduction.
pub fn read_summary(folder: &Path) -> Result<PaperSummary, Failure> {
    let path = folder.join(SUMMARY_FILE);
    let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
        .map_err(granum_io::Error::file("read", &path))?;
    let text = unseal(&path, &text)?.text;
    let mut summary: PaperSummary = serde_json::from_str(&text).map_err(|error| {
        Failure::new(format!("{}: this is not a summary of a study ({error})", path.shown()))
    })?;
    if let Some(times) = SummaryTimes::read(folder) {
        times.add_to(&mut summary);
    }
    Ok(summary)
}

/// Writes the page with the computing times of a study, which the report leaves out, since all of the report is the same on
/// every computer. A study whose times are unknown has no such page.
pub fn write_speed_page(folder: &Path, study: &StudyReport) -> Result<(), Failure> {
    if let Some(page) = speed_page(study) {
        write_atomically(&folder.join(SPEED_FILE), |file| file.write_all(page.html.as_bytes()))?;
    }
    Ok(())
}
