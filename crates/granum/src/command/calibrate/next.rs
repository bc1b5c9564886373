//! Which further test and which further simulation would tell most.

use granum_calibration::questions::candidate_tests::{new_tests, unused_tests};
use granum_calibration::questions::next_run::NextRun;
use granum_calibration::questions::next_test::NextTest;
use granum_calibration::simulations::emulator::Emulator;
use granum_io::write_table;

use super::calibration::Calibration;
use super::infer::Found;
use crate::failure::Failure;

/// What further tests would leave of the priors.
const FILE: &str = "next-test.csv";

impl Calibration<'_> {
    /// Names the tests that would tell most beside the targets, and writes the table of all that could be added.
    pub fn next_test(&self, emulator: &Emulator) -> Result<NextTest, Failure> {
        let mut candidates = unused_tests(self.file, emulator, self.laboratory, self.targets)?;
        candidates.extend(new_tests(self.file, emulator, self.laboratory, self.targets)?);
        let found = NextTest::new(self.file, emulator, self.targets, candidates)?;
        found.lines().iter().for_each(|line| self.context.note(line));
        write_table(self.out.join(FILE), &found.table()?)?;
        Ok(found)
    }

    /// Names the simulation that would reduce the error of the surrogate at the posterior most.
    pub fn next_run(&self, found: &Found, emulator: &Emulator) -> Result<Option<NextRun>, Failure> {
        let threads = crate::command::hardware::processors();
        let next = NextRun::new(self.file, emulator, self.targets, &found.outcome, threads)?;
        if let Some(next) = &next {
            self.context.note(&next.line());
        }
        Ok(next)
    }
}
