//! A campaign: the runs of a plan in a folder.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use granum_core::input::read_text;
use granum_io::case::Vocabulary;
use granum_io::sealed::{unseal_strictly, write_sealed};
use granum_io::shell::ShowPath;
use granum_io::{Case, Error, Reading, Result, Run, RunStatus};
use granum_run::Laboratory;
use granum_run::engine::LammpsStart;
use granum_run::laboratory::Source;
use granum_run::queue::{QueuedRun, sample_name};
use granum_sensors::Sensors;

use crate::campaign_file::{CampaignFile, CampaignRun, FORMAT, VariableRecord};
use crate::journal::{JOURNAL, JournalEvent, LineWriter, last_events};
use crate::plan::{Condition, Keep, Plan, PlannedRuns, apply_settings};
use crate::rows::{RowFiles, StoredHead};

/// The file of a campaign in its folder.
pub const CAMPAIGN_FILE: &str = "campaign.json";
/// Folder of the runs.
pub const RUNS: &str = "tests";
/// Folder of the samples that several runs share.
pub const SAMPLES: &str = "samples";
/// A larger file is something else.
const LARGEST: u64 = 1 << 31;

/// The runs of a plan in a folder, with all that determines them: the base case and what each run sets. The folders of the runs are
/// the truth about what has been computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Campaign {
    folder: PathBuf,
    file: CampaignFile,
    base: Case,
}

/// What differs between the runs of a changed plan and those that a folder has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PlanDifference {
    /// Number of runs that are in both.
    pub kept: usize,
    /// Number of runs that are new.
    pub added: usize,
    /// Names of the runs that are no longer planned.
    pub dropped: Vec<String>,
}

impl PlanDifference {
    /// True if both have the same runs.
    pub fn is_none(&self) -> bool {
        self.added == 0 && self.dropped.is_empty()
    }
}

/// True if a folder holds a finished run or sample.
pub(crate) fn holds_finished(folder: &Path) -> bool {
    let record = Run::at(folder).and_then(|run| run.record());
    record.is_ok_and(|record| record.status == RunStatus::Finished)
}

impl Campaign {
    /// The campaign of a plan in a folder. Nothing is written.
    pub fn new(folder: &Path, plan: &Plan, planned: &PlannedRuns, version: &str) -> Campaign {
        let variables = plan.variables.iter().map(|variable| VariableRecord {
            name: variable.name.clone(),
            unit: variable.unit.clone(),
            keys: variable.keys.iter().map(|key| key.value.clone()).collect(),
            logarithmic: variable.is_logarithmic(),
        });
        let mut alike: BTreeMap<String, usize> = BTreeMap::new();
        let samples: Vec<String> = planned.runs.iter().map(|run| run.case.preparation_digest()).collect();
        samples.iter().for_each(|digest| *alike.entry(digest.clone()).or_default() += 1);
        let runs = planned.runs.iter().zip(&samples).map(|(run, sample)| {
            let shares_sample = alike.get(sample).is_some_and(|count| *count > 1);
            CampaignRun {
                name: run.name.clone(),
                values: run.values.iter().map(|(_, value)| value.clone()).collect(),
                settings: run.settings.clone(),
                case_digest: run.case.digest(),
                shares_sample,
                sample: if shares_sample { sample_name(sample).to_string() } else { String::new() },
            }
        });
        let file = CampaignFile {
            format: FORMAT,
            granum_version: version.to_string(),
            plan: plan.text().to_string(),
            case: plan.case.resolved_toml(),
            variables: variables.collect(),
            accept: plan.accept.iter().map(|condition| condition.value.text().to_string()).collect(),
            keep: plan.keep,
            engine: plan.engine.clone(),
            lammps: plan.lammps.clone(),
            runs: runs.collect(),
            no_longer_planned: Vec::new(),
        };
        Campaign { folder: folder.to_path_buf(), file, base: plan.case.clone() }
    }

    /// Reads the campaign of a folder, whose cases can name these laws, paths and sensors; `None` if it has none.
    ///
    /// # Errors
    /// If the file cannot be read, is damaged or of a newer version.
    pub fn read(folder: &Path, vocabulary: &Vocabulary) -> Result<Option<Campaign>> {
        let path = folder.join(CAMPAIGN_FILE);
        if path.symlink_metadata().is_ok() && !path.is_file() {
            let message =
                "is not a regular file, so that it is not known what the folder is; put the file back";
            return Err(Error::content(&path, message));
        }
        if !path.is_file() {
            return Ok(None);
        }
        let text = read_text(&path, LARGEST).map_err(Error::file("read", &path))?;
        let text = unseal_strictly(&path, &text)?;
        let damaged = |why: String| Error::content(&path, format!("is no campaign or is damaged: {why}"));
        let file: CampaignFile = serde_json::from_str(&text).map_err(|error| damaged(error.to_string()))?;
        if file.format != FORMAT {
            return Err(damaged(format!("its format is {}, and this version reads {FORMAT}", file.format)));
        }
        let is_name = |name: &String| !name.is_empty() && name.chars().all(|c| c.is_ascii_hexdigit());
        let names = file.runs.iter().map(|run| &run.name).chain(&file.no_longer_planned);
        if let Some(name) = names.into_iter().find(|name| !is_name(name)) {
            return Err(damaged(format!("{name:?} is not the name of a run")));
        }
        if let Some(run) = file.runs.iter().find(|run| run.values.len() != file.variables.len()) {
            return Err(damaged(format!("the run {} has not the values of all variables", run.name)));
        }
        let reading = Reading::recorded().with_vocabulary(vocabulary);
        let base = Case::parse_as(&file.case, &format!("{} (base case)", path.shown()), reading)?;
        Ok(Some(Campaign { folder: folder.to_path_buf(), file, base }))
    }

    /// The laws, paths and sensors that its cases can name.
    pub fn vocabulary(&self) -> &Vocabulary {
        &self.base.vocabulary
    }

    /// Writes the file of the campaign under a temporary name and renames it.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn write(&self) -> Result<()> {
        write_sealed(&self.folder.join(CAMPAIGN_FILE), &self.file)
    }

    /// A laboratory with the engine that carries out the tests of this campaign. It has a thread for each run that goes on at once:
    /// fewer than there are processors, where a run needs several.
    pub fn laboratory(&self, laboratory: &Laboratory) -> Laboratory {
        let mut laboratory = laboratory.clone();
        if !self.file.engine.is_empty() {
            laboratory.engine.clone_from(&self.file.engine);
        }
        if let Some(lammps) = self.file.lammps.engine() {
            laboratory.registry.engines = laboratory.registry.engines.replaced_by(lammps);
        }
        let threads = &mut laboratory.resources.hardware.threads;
        *threads = (*threads / self.processors_of_a_run()).max(1);
        laboratory
    }

    /// The engine that carries out the tests; empty for granum's own.
    pub fn engine(&self) -> &str {
        &self.file.engine
    }

    /// Number of processors that a test needs.
    pub fn processors_of_a_run(&self) -> usize {
        self.file.lammps.processors()
    }

    /// How LAMMPS is started, if it is the engine.
    pub fn lammps(&self) -> &LammpsStart {
        &self.file.lammps
    }

    /// The same campaign, for which LAMMPS is started in another way.
    pub fn with_lammps(mut self, start: LammpsStart) -> Campaign {
        self.file.lammps = start;
        self
    }

    /// The folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Version of granum that planned the runs.
    pub fn version(&self) -> &str {
        &self.file.granum_version
    }

    /// The text of the plan.
    pub fn plan_text(&self) -> &str {
        &self.file.plan
    }

    /// The variables.
    pub fn variables(&self) -> &[VariableRecord] {
        &self.file.variables
    }

    /// The runs in the order of the plan.
    pub fn runs(&self) -> &[CampaignRun] {
        &self.file.runs
    }

    /// The names of runs of earlier plans whose folders are still there.
    pub fn no_longer_planned(&self) -> &[String] {
        &self.file.no_longer_planned
    }

    /// The folder of a run of this or an earlier plan.
    pub fn folder_of(&self, name: &str) -> PathBuf {
        self.folder.join(RUNS).join(name)
    }

    /// The conditions under which a run that did not pass a check is taken all the same.
    pub fn accept(&self) -> Vec<Condition> {
        // They were read before they were written.
        self.file.accept.iter().filter_map(|text| Condition::parse(text).ok()).collect()
    }

    /// What stays of finished runs.
    pub fn keep(&self) -> Keep {
        self.file.keep
    }

    /// The base case, from which the cases of the runs are made.
    pub fn base(&self) -> &Case {
        &self.base
    }

    /// Compares the runs with those of the campaign that the folder had.
    pub fn difference(&self, earlier: &Campaign) -> PlanDifference {
        let now: BTreeSet<&str> = self.runs().iter().map(|run| run.name.as_str()).collect();
        let before: BTreeSet<&str> = earlier.runs().iter().map(|run| run.name.as_str()).collect();
        let dropped = earlier.runs().iter().filter(|run| !now.contains(run.name.as_str()));
        PlanDifference {
            kept: now.intersection(&before).count(),
            added: now.difference(&before).count(),
            dropped: dropped.map(|run| run.name.clone()).collect(),
        }
    }

    /// The same campaign, which knows the folders of an earlier one that its plan no longer has.
    pub fn after(mut self, earlier: &Campaign) -> Campaign {
        let now: BTreeSet<&str> = self.file.runs.iter().map(|run| run.name.as_str()).collect();
        let before = earlier.file.runs.iter().map(|run| &run.name).chain(&earlier.file.no_longer_planned);
        let dropped: BTreeSet<&String> = before.filter(|name| !now.contains(name.as_str())).collect();
        let dropped = dropped.into_iter().filter(|name| earlier.folder_of(name).exists());
        let dropped = dropped.cloned().collect();
        self.file.no_longer_planned = dropped;
        self
    }

    /// The same campaign without the runs of earlier plans, whose folders have been removed.
    pub fn forgetting_earlier(mut self) -> Campaign {
        self.file.no_longer_planned.clear();
        self
    }

    /// The same runs in another folder, where none shares its sample.
    pub(crate) fn elsewhere(&self, folder: &Path) -> Campaign {
        let mut campaign = Campaign { folder: folder.to_path_buf(), ..self.clone() };
        campaign.file.runs.iter_mut().for_each(|run| run.shares_sample = false);
        campaign
    }

    /// The rows that stand for the folders of runs: none, if the folders are kept.
    ///
    /// # Errors
    /// If they cannot be read.
    pub fn rows_kept(&self) -> Result<RowFiles> {
        match self.keep() {
            Keep::Dataset => RowFiles::read(&self.folder),
            Keep::Folders => Ok(RowFiles::default()),
        }
    }

    /// Adds events to the journal that other processes noted, unless it ends with the same ones. A run that is finished stays so.
    ///
    /// # Errors
    /// If the journal cannot be written.
    pub(crate) fn take_up(&self, events: BTreeMap<String, JournalEvent>) -> Result<()> {
        let known = last_events(&self.folder);
        let is_new = |(name, event): &(String, JournalEvent)| {
            known.get(name) != Some(event) && !matches!(known.get(name), Some(JournalEvent::Finished { .. }))
        };
        let path = self.folder.join(JOURNAL);
        let mut journal = LineWriter::open(&path)?;
        for (name, event) in events.into_iter().filter(is_new) {
            journal.note(&name, event).map_err(Error::file("write", &path))?;
        }
        Ok(())
    }

    /// Seconds for each unit of expected work, by the median of the runs that are finished; `None` if none is.
    ///
    /// # Errors
    /// As [`Campaign::queued`].
    pub fn pace(&self) -> Result<Option<f64>> {
        let known = last_events(&self.folder);
        let mut paces = Vec::new();
        for run in self.runs() {
            if let Some(JournalEvent::Finished { seconds, .. }) = known.get(&run.name) {
                paces.push(seconds / self.queued_run(run)?.expected_work());
            }
        }
        paces.retain(|pace| pace.is_finite() && *pace > 0.0);
        paces.sort_by(f64::total_cmp);
        Ok(paces.get(paces.len() / 2).copied())
    }

    /// True if a run is finished: its rows have been taken in, or its folder holds it.
    pub(crate) fn is_finished(&self, run: &CampaignRun, rows: &RowFiles) -> bool {
        let record = || Run::at(self.folder_of(&run.name)).and_then(|run| run.record());
        self.has_rows(rows, run)
            || record().is_ok_and(|record| {
                record.status == RunStatus::Finished && record.case_digest == run.case_digest
            })
    }

    /// Adds to the journal what the folders of the runs tell and the journal does not: what other processes did than a coordinator here.
    /// Returns how many runs were added.
    ///
    /// # Errors
    /// If the record of a run cannot be read, or the journal cannot be written.
    pub fn collect(&self) -> Result<usize> {
        let known = last_events(&self.folder);
        let rows = self.rows_kept()?;
        let path = self.folder.join(JOURNAL);
        let mut journal = LineWriter::open(&path)?;
        let mut added = 0;
        let is_open =
            |run: &&CampaignRun| !matches!(known.get(&run.name), Some(JournalEvent::Finished { .. }));
        for run in self.runs().iter().filter(is_open) {
            let folder = self.folder_of(&run.name);
            if let Some(head) = rows.head(&run.name).filter(|_| self.has_rows(&rows, run)) {
                journal.note(&run.name, head.event.clone()).map_err(Error::file("write", &path))?;
                added += 1;
                continue;
            }
            if !folder.join("run.json").is_file() {
                continue;
            }
            let record = Run::at(&folder)?.record()?;
            if record.status == RunStatus::Finished && record.case_digest == run.case_digest {
                journal
                    .note(&run.name, JournalEvent::finished(&record))
                    .map_err(Error::file("write", &path))?;
                added += 1;
            }
        }
        Ok(added)
    }

    /// The run of a name as it is executed: its case, its sample and its folder. The name of a shared sample, which begins with
    /// `sample `, gives the preparation of it.
    ///
    /// # Errors
    /// If there is no such run, or its case cannot be made any more.
    pub fn queued(&self, name: &str) -> Result<QueuedRun> {
        let missing = || {
            Error::content(
                &self.folder.join(CAMPAIGN_FILE),
                format!("has no run or sample of the name {name:?}"),
            )
        };
        if let Some(digits) = name.strip_prefix("sample ") {
            let is_it =
                |run: &&CampaignRun| run.shares_sample && (run.sample.is_empty() || run.sample == digits);
            for run in self.runs().iter().filter(is_it) {
                let test = self.queued_run(run)?;
                let sample = test.its_sample(&self.folder.join(SAMPLES));
                if sample.name.strip_prefix("sample ") == Some(digits) {
                    return Ok(sample);
                }
            }
            return Err(missing());
        }
        self.queued_run(self.runs().iter().find(|run| run.name == name).ok_or_else(missing)?)
    }

    /// All runs as they are executed, the shared samples before the tests.
    ///
    /// # Errors
    /// As [`Campaign::queued`].
    pub fn all_queued(&self) -> Result<Vec<QueuedRun>> {
        let tests = self.runs().iter().map(|run| self.queued_run(run)).collect::<Result<Vec<_>>>()?;
        let mut seen = BTreeSet::new();
        let mut all = Vec::new();
        for test in tests.iter().filter(|test| test.after.is_some()) {
            if seen.insert(test.after.clone()) {
                all.push(test.its_sample(&self.folder.join(SAMPLES)));
            }
        }
        all.extend(tests);
        Ok(all)
    }

    /// The case of a run.
    ///
    /// # Errors
    /// If it cannot be made any more as it was planned.
    pub fn case_of(&self, run: &CampaignRun) -> Result<Case> {
        let case = apply_settings(&self.base, &run.settings)?;
        if case.digest() != run.case_digest {
            let message = format!(
                "the case of the run {} is not the one that was planned: a file that it names was changed, or another version of \
                 granum planned it; give the plan again",
                run.name
            );
            return Err(Error::content(&self.folder.join(CAMPAIGN_FILE), message));
        }
        Ok(case)
    }

    /// True if the rows of a run have been taken in, with the case and the version that are planned.
    pub fn has_rows(&self, rows: &RowFiles, run: &CampaignRun) -> bool {
        let is_it =
            |head: &StoredHead| head.case_digest == run.case_digest && head.granum_version == self.version();
        rows.head(&run.name).is_some_and(is_it)
    }

    /// The folders of shared samples of which no run is needed any more, given which runs are, as far as they are there.
    pub(crate) fn samples_not_needed(&self, needed: &[bool]) -> Vec<PathBuf> {
        let mut samples: BTreeMap<&str, bool> = BTreeMap::new();
        for (run, needed) in self.runs().iter().zip(needed).filter(|(run, _)| !run.sample.is_empty()) {
            *samples.entry(&run.sample).or_default() |= *needed;
        }
        let gone = samples.into_iter().filter(|(_, needed)| !needed);
        gone.map(|(name, _)| self.folder.join(SAMPLES).join(name)).filter(|folder| folder.is_dir()).collect()
    }

    /// Refuses a link in the place of a folder of the campaign: what is written there would end up elsewhere.
    pub(crate) fn refuse_link(&self, name: &str) -> Result<()> {
        let path = self.folder.join(name);
        match path.symlink_metadata().is_ok_and(|kind| kind.is_symlink()) {
            true => Err(Error::content(&path, "is a symbolic link; replace it by a folder or remove it")),
            false => Ok(()),
        }
    }

    /// The sensors by whose columns measures get their units.
    pub(crate) fn sensors(&self) -> &Sensors {
        self.base.vocabulary.sensors()
    }

    fn queued_run(&self, run: &CampaignRun) -> Result<QueuedRun> {
        let case = self.case_of(run)?;
        let values = self.variables().iter().zip(&run.values);
        let values = values.map(|(variable, value)| (variable.name.clone(), value.to_string())).collect();
        let queued = QueuedRun::test(&run.name, case, Source::Case, self.folder_of(&run.name));
        let queued = QueuedRun { values, ..queued };
        if !run.shares_sample {
            return Ok(queued);
        }
        let sample = queued.its_sample(&self.folder.join(SAMPLES));
        Ok(QueuedRun { source: Source::Folder(sample.folder), after: Some(sample.name), ..queued })
    }
}
