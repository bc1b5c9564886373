//! Samples that several tests share are prepared once.

use std::collections::BTreeMap;
use std::path::Path;

use granum_io::Case;

use granum_io::run::RunKind;

use super::queued_run::QueuedRun;
use crate::task::source::Source;

/// Number of digits of the preparation digest in the name of a sample.
const DIGITS: usize = 12;

/// Adds a run for every sample that several tests would prepare themselves, in a folder inside `folder` that is named after the
/// preparation digest, and lets these tests take their sample from it. The results are the same.
pub(super) fn share(mut runs: Vec<QueuedRun>, folder: &Path) -> Vec<QueuedRun> {
    let mut alike: BTreeMap<String, Vec<usize>> = BTreeMap::new();
    for (k, run) in runs.iter().enumerate() {
        if run.kind == RunKind::Test && run.source == Source::Case {
            alike.entry(run.case.preparation_digest()).or_default().push(k);
        }
    }
    let mut samples = Vec::new();
    // In the order of the tests, so that the queue does not depend on digests.
    let mut groups: Vec<(String, Vec<usize>)> =
        alike.into_iter().filter(|(_, tests)| tests.len() > 1).collect();
    groups.sort_by_key(|(_, tests)| tests[0]);
    for (_, tests) in groups {
        let sample = runs[tests[0]].its_sample(folder);
        for test in tests {
            runs[test].source = Source::Folder(sample.folder.clone());
            runs[test].after = Some(sample.name.clone());
        }
        samples.push(sample);
    }
    samples.extend(runs);
    samples
}

/// The name of the folder of a sample, from the digest of its preparation.
pub fn sample_name(digest: &str) -> &str {
    &digest[..DIGITS.min(digest.len())]
}

impl QueuedRun {
    /// The preparation of the sample of this test as a run of its own, in a folder inside `samples` that is named after the digest of
    /// the preparation: the same for all tests that can share it, whatever they test.
    pub fn its_sample(&self, samples: &Path) -> QueuedRun {
        let digest = self.case.preparation_digest();
        let name = sample_name(&digest);
        QueuedRun::sample(format!("sample {name}"), of_sample(&self.case), Source::Case, samples.join(name))
    }
}

/// The case of a sample without the test, so that it is the same whichever tests the sample serves.
fn of_sample(case: &Case) -> Case {
    let standard = Case::default();
    Case { test: standard.test, recording: standard.recording, ..case.clone() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn test(name: &str, friction: &str, strain: &str) -> QueuedRun {
        let mut case = Case::default();
        case.set("grains.material.friction", friction).unwrap();
        case.set("shear.deviator_strain", strain).unwrap();
        QueuedRun::test(name, case, Source::Case, name)
    }

    #[test]
    fn tests_of_one_preparation_share_their_sample() {
        let runs = vec![test("a", "0.2", "0.1"), test("b", "0.4", "0.1"), test("c", "0.2", "0.2")];
        let shared = share(runs.clone(), Path::new("samples"));
        assert_eq!(shared.len(), 4);
        let sample = &shared[0];
        assert_eq!(sample.kind, RunKind::Sample);
        assert_eq!(sample.case.preparation_digest(), runs[0].case.preparation_digest());
        for (k, after) in [(1, Some(&sample.name)), (2, None), (3, Some(&sample.name))] {
            assert_eq!(shared[k].after.as_ref(), after);
        }
        assert_eq!(shared[1].source, Source::Folder(sample.folder.clone()));
        assert_eq!(shared[2].source, Source::Case);
        // The sample is the same whichever test comes first.
        let turned: Vec<QueuedRun> = runs.into_iter().rev().collect();
        assert_eq!(share(turned, Path::new("samples"))[0], *sample);
    }
}
