//! What a campaign remembers of a job: which runs each of its elements has, and how its scheduler calls it.
//!
//! The record is written before the job is submitted and once more with the name that the scheduler gave. If the process is killed in
//! between, the scheduler is asked for a job with the name of the record.

use std::path::{Path, PathBuf};
use std::time::SystemTime;

use granum_core::digest::sha256;
use granum_io::sealed::{unseal_strictly, write_sealed};
use granum_io::{Error, Result};
use serde::{Deserialize, Serialize};

/// Folder of the jobs of a campaign.
pub const JOBS: &str = "jobs";
/// A larger file is no record of a job.
const LARGEST: u64 = 1 << 28;
/// Layout of the file.
const FORMAT: u32 = 1;

/// A job of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct JobRecord {
    format: u32,
    /// Its number in the campaign.
    pub number: usize,
    /// Name of its scheduler.
    pub scheduler: String,
    /// Its name, which no other job has.
    pub name: String,
    /// How the scheduler calls it; `None` until that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub id: Option<String>,
    /// The runs of each element.
    pub elements: Vec<Vec<String>>,
    /// True if all of its elements are over, and what they did is in the journal of the campaign.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub closed: bool,
}

impl JobRecord {
    /// A new job, with the number after those that the folder has.
    ///
    /// # Errors
    /// If the record of another job cannot be read.
    pub fn new(campaign: &Path, scheduler: &str, elements: Vec<Vec<String>>) -> Result<JobRecord> {
        let number = JobRecord::all_in(campaign)?.last().map_or(0, |last| last.number) + 1;
        // The time and the process tell apart jobs of the same number, also those of other campaigns.
        let since = SystemTime::now().duration_since(SystemTime::UNIX_EPOCH).unwrap_or_default();
        let unique = format!("{} {number} {} {}", campaign.display(), std::process::id(), since.as_nanos());
        let name = format!("granum-{}", &sha256(unique.as_bytes())[..12]);
        Ok(JobRecord {
            format: FORMAT,
            number,
            scheduler: scheduler.into(),
            name,
            id: None,
            elements,
            closed: false,
        })
    }

    /// The jobs of a campaign, by their numbers.
    ///
    /// # Errors
    /// If a record cannot be read or is damaged.
    pub fn all_in(campaign: &Path) -> Result<Vec<JobRecord>> {
        let entries = std::fs::read_dir(campaign.join(JOBS)).into_iter().flatten().flatten();
        let number = |name: std::ffi::OsString| name.to_str()?.strip_suffix(".json")?.parse::<usize>().ok();
        let mut numbers: Vec<usize> = entries.filter_map(|entry| number(entry.file_name())).collect();
        numbers.sort_unstable();
        numbers.into_iter().map(|number| JobRecord::read(campaign, number)).collect()
    }

    /// The jobs of a campaign that are not closed.
    ///
    /// # Errors
    /// As [`JobRecord::all_in`].
    pub fn open_in(campaign: &Path) -> Result<Vec<JobRecord>> {
        Ok(JobRecord::all_in(campaign)?.into_iter().filter(|record| !record.closed).collect())
    }

    /// Reads the job of a number.
    ///
    /// # Errors
    /// If its record cannot be read or is damaged.
    pub fn read(campaign: &Path, number: usize) -> Result<JobRecord> {
        let path = file(campaign, number, ".json");
        let text = granum_core::input::read_text(&path, LARGEST).map_err(Error::file("read", &path))?;
        let damaged =
            |why: String| Error::content(&path, format!("is no record of a job or is damaged: {why}"));
        let record: JobRecord = serde_json::from_str(&unseal_strictly(&path, &text)?)
            .map_err(|error| damaged(error.to_string()))?;
        if record.format != FORMAT || record.number != number {
            return Err(damaged(format!("it has format {} and number {}", record.format, record.number)));
        }
        // It becomes a word of a command.
        if record
            .id
            .as_ref()
            .is_some_and(|id| id.is_empty() || !id.chars().all(|c| c.is_ascii_alphanumeric()))
        {
            return Err(damaged(
                "the name that its scheduler gave has other signs than letters and digits".into(),
            ));
        }
        Ok(record)
    }

    /// Writes the record.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self, campaign: &Path) -> Result<()> {
        let folder = campaign.join(JOBS);
        std::fs::create_dir_all(&folder).map_err(Error::file("create the folder", &folder))?;
        write_sealed(&file(campaign, self.number, ".json"), self)
    }

    /// The script of the job.
    pub fn script(&self, campaign: &Path) -> PathBuf {
        file(campaign, self.number, ".sh")
    }

    /// Removes the record and all files of the job.
    pub fn remove(&self, campaign: &Path) {
        self.remove_files(campaign);
        // A file that cannot be removed does no harm: the job is over.
        let _ = std::fs::remove_file(file(campaign, self.number, ".json"));
    }

    /// Removes the files of the job but its record: script, journals and what its elements said.
    pub fn remove_files(&self, campaign: &Path) {
        let elements = 0..self.elements.len();
        let of_elements = elements
            .flat_map(|k| [element_journal(campaign, self.number, k), element_log(campaign, self.number, k)]);
        for path in of_elements.chain([self.script(campaign)]) {
            let _ = std::fs::remove_file(path);
        }
    }
}

fn file(campaign: &Path, number: usize, ending: &str) -> PathBuf {
    campaign.join(JOBS).join(format!("{number:04}{ending}"))
}

/// The journal of an element of a job, which that element alone writes.
pub fn element_journal(campaign: &Path, number: usize, element: usize) -> PathBuf {
    file(campaign, number, &format!("-{element}.jsonl"))
}

/// What an element of a job said.
pub(super) fn element_log(campaign: &Path, number: usize, element: usize) -> PathBuf {
    file(campaign, number, &format!("-{element}.log"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_are_numbered_and_read_back() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        assert_eq!(JobRecord::all_in(folder).unwrap(), []);
        let one =
            JobRecord::new(folder, "slurm", vec![vec!["a".into()], vec!["b".into(), "c".into()]]).unwrap();
        one.write(folder).unwrap();
        let two = JobRecord { closed: true, ..JobRecord::new(folder, "slurm", Vec::new()).unwrap() };
        two.write(folder).unwrap();
        assert_eq!((one.number, two.number), (1, 2));
        assert_ne!(one.name, two.name);
        assert_eq!(JobRecord::all_in(folder).unwrap(), [one.clone(), two]);
        assert_eq!(JobRecord::open_in(folder).unwrap(), std::slice::from_ref(&one));
        one.remove(folder);
        assert_eq!(JobRecord::new(folder, "slurm", Vec::new()).unwrap().number, 3);
        let path = folder.join("jobs/0002.json");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("slurm", "slrum")).unwrap();
        let error = JobRecord::all_in(folder).unwrap_err().to_string();
        assert!(error.contains("0002.json") && error.contains("changed or damaged"), "{error}");
    }
}
