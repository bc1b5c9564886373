//! `granum calibrate`: which properties of the grains explain laboratory tests, and how surely.

mod calibration;
mod coverage;
mod earlier_results;
mod explains;
mod infer;
mod next;
mod posterior_files;
mod prediction;
mod repeated;
mod results;
mod rounds;
mod simulate;

use std::path::{Path, PathBuf};

use clap::Args;
use granum_calibration::file::{CalibrationFile, Method, PredictedTests, WHY_PREDICTIONS};
use granum_calibration::posterior::confirmation::{Confirmed, MOST_OUTSIDE, share_outside};
use granum_calibration::questions::telling::WhatTestsTell;
use granum_calibration::simulations::emulator::Emulator;
use granum_calibration::simulations::known::KnownRun;
use granum_calibration::simulations::same_readings::{check_different, known_by_another_name};
use granum_calibration::simulations::simulation::{CaseNumbers, parameters};
use granum_calibration::simulations::target::{named_twice, predicted, targets, understood};
use granum_io::shell::ShowPath;
use granum_io::{LaboratoryTest, OutputFolder, read_laboratory};

use super::campaign::CarryOutFlags;
use super::laboratory_flags::{LaboratoryFlags, doubts};
use crate::context::Context;
use crate::failure::Failure;
use calibration::Calibration;
use earlier_results::OF_POSTERIOR;
use infer::Found;
use results::Told;
use simulate::Runs;

/// The copy of the file in the folder, by which the folder is known to be that of a calibration.
const COPY: &str = "material.toml";

/// Calibrate: find which properties of the grains explain laboratory tests, and how surely.
///
/// The file is like the plan of a campaign: a base case, `[set]` and `[[variable]]`, with a prior for each variable that is free, and the table
/// `[calibration]` that says what is compared (`granum init --list` names ready ones). Simulations of the tests at their own densities and
/// stresses are carried out as a campaign in the folder; a surrogate learns from them; what the tests can tell is said before anything is
/// inferred; chains draw from the posterior; simulations at such draws confirm it. The same command goes on after any interruption and
/// uses what is finished.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum init --calibration karlsruhe-sand\n  granum calibrate karlsruhe-sand.toml \
                  data/lab/karlsruhe-fine-sand-drained.csv --out calibrated\n  granum campaign calibrated/draws.toml --dry-run"
)]
pub struct Calibrate {
    /// The file of the calibration.
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// The laboratory's files, as those of `granum compare`.
    #[arg(required = true, num_args = 1.., value_name = "LAB.csv")]
    laboratory: Vec<PathBuf>,
    /// Folder of the calibration; by default the name of the file without its ending.
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// A test to use in place of those that the file names; can be repeated.
    #[arg(long, value_name = "NAME")]
    test: Vec<String>,
    /// A test to predict from the calibration on the others, in place of those that the file names; can be repeated. `others` stands for all
    /// tests that are not calibrated on.
    #[arg(long, value_name = "NAME")]
    predict: Vec<String>,
    /// Learn from the runs of this campaign or data set, in place of a design of simulations: several calibrations share them; can be
    /// repeated. What varies over them is what the file sets, or has the base case's value.
    #[arg(long, value_name = "DIR")]
    runs: Vec<PathBuf>,
    /// Do not calibrate, but leave each test out in turn, and predict it from a calibration on the others. Nothing but the design is
    /// simulated.
    #[arg(long, conflicts_with_all = ["each_alone", "coverage", "predict"])]
    leave_one_out: bool,
    /// Do not calibrate, but calibrate on each test alone, which shows how parameters wander. Nothing but the design is simulated.
    #[arg(long, conflicts_with_all = ["coverage", "predict"])]
    each_alone: bool,
    /// Do not calibrate, but count how often intervals of 90 % hold the parameters of N simulations in place of the tests.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=10_000))]
    coverage: Option<u64>,
    #[command(flatten)]
    reading: LaboratoryFlags,
    #[command(flatten)]
    carry_out: CarryOutFlags,
}

impl Calibrate {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let mut file = CalibrationFile::read(&self.file, context.reading())?;
        if let Some((option, why)) =
            self.without_surrogate().filter(|_| file.calibration.method == Method::Dem)
        {
            return Err(Failure::new(format!(
                "{option} needs a surrogate, since {why}; write method = \"surrogate\" in {}",
                self.file.shown()
            )));
        }
        self.refuse_named_twice()?;
        if !self.test.is_empty() {
            file.calibration.tests.clone_from(&self.test);
        }
        match self.predict.as_slice() {
            [] => {}
            [word] if word == PredictedTests::OTHERS => file.calibration.predict = PredictedTests::Others,
            names => file.calibration.predict = PredictedTests::Named(names.to_vec()),
        }
        if self.leave_one_out || self.each_alone {
            file.calibration.predict = PredictedTests::Named(Vec::new());
        }
        let tests = self.tests(context)?;
        let mut all = targets(&file, &tests)?;
        let count = all.len();
        all.extend(predicted(&file, &tests, &all)?);
        let (targets, predicted) = all.split_at(count);
        known_by_another_name(targets, predicted).iter().for_each(|line| context.warn(line));
        let used: Vec<&LaboratoryTest> = all.iter().map(|target| &target.laboratory).collect();
        doubts(&used).iter().for_each(|doubt| context.warn(doubt));
        understood(&file, targets).iter().for_each(|line| context.note(line));
        understood(&file, predicted).iter().for_each(|line| context.note(&format!("to predict: {line}")));
        if let Some(own) = file.free.iter().find(|free| free.own).filter(|_| self.leave_one_out) {
            return Err(Failure::new(format!(
                "--leave-one-out predicts a test from the others, and {} is own to each test (own = true), so that the others do not tell its value in \
                 the test that is left out; let all tests share it, or give it by an expression of what the tests have",
                own.name
            )));
        }
        if !self.each_alone {
            check_different(targets)?;
        }
        let name = || PathBuf::from(self.file.file_stem().unwrap_or(self.file.as_os_str()));
        let out = self.out.clone().unwrap_or_else(name);
        let _folder = self.folder(&out, &file)?;
        let parameters = parameters(&file, targets);
        let calibration = Calibration {
            context,
            file: &file,
            all: &all,
            targets,
            laboratory: &tests,
            parameters,
            out,
            earlier: &self.runs,
            flags: &self.carry_out,
        };
        if self.leave_one_out {
            return calibration.leave_one_out();
        }
        if self.each_alone {
            return calibration.each_alone();
        }
        if let Some(count) = self.coverage {
            return calibration.coverage(count as usize);
        }
        match file.calibration.method {
            Method::Surrogate => calibration.by_surrogate(),
            Method::Dem => calibration.by_simulations(),
        }
    }

    /// A test that counts twice makes the posterior narrower than its readings allow.
    fn refuse_named_twice(&self) -> Result<(), Failure> {
        for (option, names) in [("--test", &self.test), ("--predict", &self.predict)] {
            if let Some(name) = named_twice(names) {
                return Err(Failure::new(format!(
                    "{option} {name} is given twice; name each test once: one that counts twice makes the posterior narrower than its readings allow"
                )));
            }
        }
        Ok(())
    }

    /// An option that was given and that only a surrogate has, and why.
    fn without_surrogate(&self) -> Option<(&'static str, &'static str)> {
        let repeated = "it repeats the inference on other targets, and each inference by simulations alone needs rounds of its own";
        let given = [
            (!self.runs.is_empty(), "--runs", "rounds of simulations choose their own points"),
            (!self.predict.is_empty(), "--predict", WHY_PREDICTIONS),
            (self.leave_one_out, "--leave-one-out", repeated),
            (self.each_alone, "--each-alone", repeated),
            (self.coverage.is_some(), "--coverage", repeated),
        ];
        given.iter().find(|(is_given, ..)| *is_given).map(|(_, option, why)| (*option, *why))
    }

    /// The tests of all files; one without a name has that of its file.
    fn tests(&self, context: &Context) -> Result<Vec<LaboratoryTest>, Failure> {
        let _alone = context.nothing_written(Some("reading the tests"));
        let conventions = self.reading.conventions()?;
        let mut all = Vec::new();
        for path in &self.laboratory {
            for mut test in read_laboratory(path, &conventions)? {
                if test.name.is_empty() {
                    test.name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
                }
                all.push(test);
            }
        }
        Ok(all)
    }

    /// The folder, which is new or that of a calibration.
    fn folder(&self, out: &Path, file: &CalibrationFile) -> Result<OutputFolder, Failure> {
        let copy = out.join(COPY);
        if !OutputFolder::is_free(out) && !copy.is_file() {
            return Err(Failure::new(format!(
                "{}: the folder holds something else than a calibration; give another one with --out",
                out.shown()
            )));
        }
        let folder = OutputFolder::open_or_create(out)?;
        results::write(&copy, file.plan.text())?;
        Ok(folder)
    }
}

impl Calibration<'_> {
    /// By a surrogate of the simulations, which is refined where simulations at draws from the posterior differ from it.
    fn by_surrogate(&self) -> Result<(), Failure> {
        let table = &self.file.calibration;
        let (numbers, mut known) = self.known()?;
        let mut round = 1;
        loop {
            let emulator = self.emulator(numbers.clone(), &known)?;
            self.check_reach(&emulator, &known, &OF_POSTERIOR)?;
            let telling = self.telling(&emulator)?;
            let next_test = self.next_test(&emulator)?;
            let found =
                self.infer(&emulator).map_err(|failure| self.without_results(failure, &OF_POSTERIOR))?;
            self.save_posterior(&found)?;
            let next_run = self.next_run(&found, &emulator)?;
            let (confirmed, runs) = self.confirm(round, &found, Some(&emulator))?;
            let beyond = emulator.for_targets(self.all).beyond_simulations(&found.outcome.mean())?;
            let outside = share_outside(&confirmed);
            if let Some(outside) = outside {
                self.context.note(&format!(
                    "confirmation {round}: {:.0} % of the curves of {} simulations at draws from the posterior leave the intervals of 90 % of \
                     the surrogate",
                    100.0 * outside,
                    runs.simulated.len()
                ));
            }
            if outside.is_none_or(|outside| outside <= MOST_OUTSIDE) || round >= table.rounds {
                let mut remarks = beyond;
                match outside {
                    None if table.confirm == 0 => remarks.push(
                        "nothing is confirmed by simulations (confirm = 0): all curves are those of the surrogate".into(),
                    ),
                    None => remarks.push(
                        "nothing is confirmed, since none of the simulations at draws from the posterior is used: all curves are those of the \
                         surrogate"
                            .into(),
                    ),
                    Some(outside) if outside > MOST_OUTSIDE => remarks.push(format!(
                        "the surrogate is not confirmed after {round} rounds: {:.0} % of the curves of simulations leave its intervals of \
                         90 %; plan more runs, or allow more rounds",
                        100.0 * outside
                    )),
                    Some(_) => {}
                }
                results::put(emulator.to_json()?, &self.out.join("surrogate.json"))?;
                let told = Told { emulator, telling, next_test, next_run };
                return self.finish(&found, Some(&told), &confirmed, &runs.simulated, remarks);
            }
            self.context.note("the simulations are added to those from which the surrogate learns, and the inference is repeated");
            known.extend(self.as_known(&numbers, &runs.simulated)?);
            round += 1;
        }
    }

    fn emulator(&self, numbers: CaseNumbers, known: &[KnownRun]) -> Result<Emulator<'_>, Failure> {
        let mut show = infer::Show::new(self.context, "surrogate");
        let threads = super::hardware::processors();
        let emulator = Emulator::fit(self.file, self.targets, numbers, known, threads, &mut show);
        let emulator = emulator.map_err(|error| self.stopped(error))?;
        let errors: Vec<String> = emulator
            .left_out_errors(known)
            .iter()
            .map(|error| {
                let over = match (error.quantity.is_stress(), self.file.calibration.stress_scale) {
                    (false, _) => "",
                    (true, None) => " of the mean stress at the start",
                    (true, Some(_)) => " of the stress_scale",
                };
                format!(
                    "{} {:.3}{over} (scatter of all runs {:.3})",
                    error.quantity.word().replace('_', " "),
                    error.error,
                    error.scatter
                )
            })
            .collect();
        show.end(format!(
            "learned from {} runs; error over runs left out: {}",
            known.len(),
            errors.join(", ")
        ));
        Ok(emulator)
    }

    fn telling(&self, emulator: &Emulator) -> Result<WhatTestsTell, Failure> {
        let curves = granum_calibration::simulations::target::all_curves(self.targets);
        let threads = super::hardware::processors();
        let seed = self.file.calibration.seed;
        let telling = WhatTestsTell::new(&self.parameters, &curves, emulator, seed, threads)?;
        telling.lines().iter().for_each(|line| self.context.note(line));
        telling.warnings().iter().for_each(|line| self.context.warn(line));
        let figure = granum_report::calibration::telling_figure(&telling);
        results::put(figure.to_svg(), &self.out.join("what-tests-tell.svg"))?;
        Ok(telling)
    }

    fn confirm(
        &self,
        round: usize,
        found: &Found,
        emulator: Option<&Emulator>,
    ) -> Result<(Vec<Confirmed>, Runs), Failure> {
        let draws = found.outcome.spread(self.file.calibration.confirm);
        if draws.is_empty() {
            return Ok((Vec::new(), Runs { simulated: Vec::new() }));
        }
        let simulations =
            granum_calibration::posterior::confirmation::simulations(self.file, self.all.len(), &draws);
        let runs = self.simulate(&format!("confirmation-{round}"), 1000 + round, &simulations)?;
        for one in &runs.simulated {
            granum_calibration::simulations::emulator::check(self.file, &one.name, &one.curves)?;
        }
        let confirmed = granum_calibration::posterior::confirmation::confirm(
            self.file,
            self.all,
            &runs.simulated,
            &draws,
            emulator.map(|emulator| emulator.for_targets(self.all)).as_ref(),
        )?;
        Ok((confirmed, runs))
    }
}
