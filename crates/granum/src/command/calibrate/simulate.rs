//! The simulations of a calibration, as campaigns in its folder.

use std::path::PathBuf;

use granum_calibration::simulations::known::{EarlierRuns, KnownRun};
use granum_calibration::simulations::simulation::{
    CaseNumbers, DesignPoint, Simulated, plan, planned, simulated,
};
use granum_calibration::simulations::unvaried::check_varied;
use granum_campaign::data_set::{DATA_SET, DataSet};
use granum_campaign::plan::FixedKey;
use granum_io::OutputFolder;
use granum_io::case::SEED;
use granum_io::shell::{ShowPath, quoted_path};

use super::calibration::Calibration;
use crate::command::campaign::carry_out_for;
use crate::failure::{Failure, Interrupted};

/// Folder of the campaigns.
const RUNS: &str = "runs";
/// Seeds of samples that a campaign may have before those of the next one begin.
const SEEDS: u64 = 1_000_000;

/// The runs of a campaign.
pub struct Runs {
    /// Those that finished and passed their checks.
    pub simulated: Vec<Simulated>,
}

impl Calibration<'_> {
    /// The simulations from which the surrogate learns, with what decides one: those of the earlier campaign, or of the design, which are
    /// carried out as far as they are not finished.
    pub fn known(&self) -> Result<(CaseNumbers, Vec<KnownRun>), Failure> {
        let design = granum_calibration::simulations::simulation::design(self.file, self.targets.len());
        if self.earlier.is_empty() {
            let numbers = CaseNumbers::new(self.file);
            let Runs { simulated } = self.simulate("design", 0, &design)?;
            let known = self.as_known(&numbers, &simulated)?;
            return Ok((numbers, known));
        }
        let mut runs = Vec::new();
        for folder in self.earlier {
            let Some(data_set) = DataSet::meant_by(folder)? else {
                let message =
                    "is neither a campaign nor a data set, whose runs could take the place of the design";
                return Err(Failure::new(format!("--runs {}: {message}", folder.shown())));
            };
            let own = DataSet::read(&data_set, self.context.reading())?.each_run()?;
            let count = own.len();
            self.context
                .note(&format!("{count} simulations of {} take the place of the design", folder.shown()));
            runs.extend(own);
        }
        // The case of the first simulation that would be carried out says what those of this file have.
        let first = planned(&plan(self.file, self.all, &design[..1]))?.runs.swap_remove(0).case;
        let EarlierRuns { numbers, runs, remarks } = EarlierRuns::new(self.file, &first, runs)?;
        let unvaried = check_varied(self.file, self.targets, &numbers, &runs)?;
        remarks.iter().chain(&unvaried).for_each(|remark| self.context.warn(remark));
        Ok((numbers, runs))
    }

    /// Simulations of this calibration as the surrogate learns from them.
    pub fn as_known(&self, numbers: &CaseNumbers, simulated: &[Simulated]) -> Result<Vec<KnownRun>, Failure> {
        let known = simulated.iter().map(|one| KnownRun::from_simulated(numbers, self.all, one));
        Ok(known.collect::<Result<_, _>>()?)
    }

    /// Simulates the tests, each with a sample of its own, as a campaign of this name; what is finished is used again.
    pub fn simulate(&self, name: &str, number: usize, simulations: &[DesignPoint]) -> Result<Runs, Failure> {
        self.simulate_samples(name, number, simulations, 1)
    }

    /// As [`Calibration::simulate`], with so many samples of each simulation, that differ in their seed alone.
    pub fn simulate_samples(
        &self,
        name: &str,
        number: usize,
        simulations: &[DesignPoint],
        samples: usize,
    ) -> Result<Runs, Failure> {
        let runs = self.out.join(RUNS);
        let folder: PathBuf = runs.join(name);
        let _runs = OutputFolder::open_or_create(&runs)?;
        let mut plan = plan(self.file, self.all, simulations);
        plan.design.replicates = samples;
        let simulations: Vec<DesignPoint> =
            simulations.iter().flat_map(|one| std::iter::repeat_n(one.clone(), samples)).collect();
        if number > 0 {
            // Samples of other seeds than those of the campaigns before.
            let first = plan.case.preparation.seed.wrapping_add(SEEDS * number as u64);
            plan.fixed.push(FixedKey { key: SEED.into(), text: first.to_string(), span: 0..0 });
        }
        let planned = planned(&plan)?;
        self.context.note(&format!("{name}: {} simulations in {}", simulations.len(), folder.shown()));
        let (campaign, summary) = carry_out_for(self.context, self.flags, &plan, &planned, &folder)?;
        if summary.stopped {
            let left = format!(
                "{} in {}; continue with the same command",
                summary.progress.line(),
                quoted_path(campaign.folder())
            );
            return Err(Interrupted { left }.into());
        }
        for (run, why) in &summary.failed {
            self.context.warn(&format!("{name}: the run {run} failed: {why}"));
        }
        let data_set = folder.join(DATA_SET);
        let each = match DataSet::is_in(&data_set) {
            true => DataSet::read(&data_set, self.context.reading())?.each_run()?,
            false => Vec::new(),
        };
        let (simulated, missing) = simulated(&simulations, &planned, each);
        if missing > 0 {
            self.context.warn(&format!(
                "{name}: {missing} of {} simulations are not used, since they failed or did not pass their checks (`granum campaign status {}` \
                 names the reasons; accept in the file states limits up to which they are used)",
                simulations.len(),
                quoted_path(&folder)
            ));
        }
        Ok(Runs { simulated })
    }
}
