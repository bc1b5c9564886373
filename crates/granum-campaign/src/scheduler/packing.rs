//! How runs are packed into the elements of a job, so that an element takes a stated time.

use std::collections::{BTreeMap, BTreeSet};

use granum_run::queue::QueuedRun;

/// How full an element is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Filling {
    /// So many runs.
    Runs(usize),
    /// As many runs as are expected to take so many seconds, with the seconds of a unit of expected work.
    Seconds {
        /// The time of an element.
        of_element: f64,
        /// Seconds of a unit of work.
        of_work: f64,
    },
}

/// The elements of a campaign.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Packing {
    /// Samples that tests of several elements need, which must be finished before these begin.
    pub(super) samples: Vec<Vec<String>>,
    /// Tests.
    pub(super) tests: Vec<Vec<String>>,
}

/// Packs tests, with the samples that are still to be prepared. Tests of one sample follow each other, the longest first, so that most
/// samples are needed by one element only, which prepares them itself.
pub(super) fn pack(tests: &[QueuedRun], samples: &BTreeMap<String, QueuedRun>, filling: Filling) -> Packing {
    let sample_of = |run: &QueuedRun| run.after.clone().filter(|name| samples.contains_key(name));
    let mut longest: BTreeMap<String, f64> = BTreeMap::new();
    for run in tests {
        if let Some(name) = sample_of(run) {
            let held = longest.entry(name).or_default();
            *held = held.max(run.expected_work());
        }
    }
    let place = |run: &QueuedRun| match sample_of(run) {
        Some(name) => (longest[&name], name),
        None => (run.expected_work(), String::new()),
    };
    let mut ordered: Vec<(&QueuedRun, (f64, String))> = tests.iter().map(|run| (run, place(run))).collect();
    ordered.sort_by(|(a, (work_a, name_a)), (b, (work_b, name_b))| {
        let own = || b.expected_work().total_cmp(&a.expected_work());
        work_b.total_cmp(work_a).then_with(|| name_a.cmp(name_b)).then_with(own)
    });
    let mut packed = Fill::new(filling);
    let mut prepared = BTreeSet::new();
    for (run, _) in &ordered {
        let sample = sample_of(run).filter(|name| prepared.insert(name.clone()));
        let work = sample.map_or(0.0, |name| samples[&name].expected_work());
        packed.add(run.name.clone(), work + run.expected_work());
    }
    let of_run: BTreeMap<&str, &QueuedRun> = tests.iter().map(|run| (run.name.as_str(), run)).collect();
    let mut needed: BTreeMap<String, usize> = BTreeMap::new();
    for element in &packed.elements {
        let of_element: BTreeSet<String> =
            element.iter().filter_map(|name| sample_of(of_run[name.as_str()])).collect();
        of_element.into_iter().for_each(|name| *needed.entry(name).or_default() += 1);
    }
    let mut before = Fill::new(filling);
    let several = needed.into_iter().filter(|(_, elements)| *elements > 1);
    several.for_each(|(name, _)| before.add(name.clone(), samples[&name].expected_work()));
    Packing { samples: before.elements, tests: packed.elements }
}

/// Elements that are filled one after the other.
struct Fill {
    filling: Filling,
    elements: Vec<Vec<String>>,
    /// Expected seconds of the last element.
    seconds: f64,
}

impl Fill {
    fn new(filling: Filling) -> Fill {
        Fill { filling, elements: Vec::new(), seconds: 0.0 }
    }

    fn add(&mut self, name: String, work: f64) {
        let (seconds, fits) = match (self.filling, self.elements.last()) {
            (Filling::Runs(count), last) => (0.0, last.is_some_and(|last| last.len() < count)),
            (Filling::Seconds { of_element, of_work }, last) => {
                let seconds = work * of_work;
                (seconds, last.is_some() && self.seconds + seconds <= of_element)
            }
        };
        match self.elements.last_mut().filter(|_| fits) {
            Some(last) => {
                last.push(name);
                self.seconds += seconds;
            }
            None => {
                self.elements.push(vec![name]);
                self.seconds = seconds;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use granum_io::Case;
    use granum_run::laboratory::Source;

    use super::*;

    fn run(name: &str, strain: &str, after: Option<&str>) -> QueuedRun {
        let mut case = Case::default();
        case.set("shear.deviator_strain", strain).unwrap();
        let source = if after.is_some() { Source::Folder("s".into()) } else { Source::Case };
        QueuedRun { after: after.map(str::to_string), ..QueuedRun::test(name, case, source, name) }
    }

    fn sample(name: &str) -> (String, QueuedRun) {
        (name.into(), QueuedRun::sample(name, Case::default(), Source::Case, name))
    }

    #[test]
    fn so_many_runs_an_element_the_longest_first() {
        let runs: Vec<QueuedRun> = [("a", "0.1"), ("b", "0.3"), ("c", "0.2"), ("d", "0.4"), ("e", "0.5")]
            .map(|(name, strain)| run(name, strain, None))
            .into();
        let packed = pack(&runs, &BTreeMap::new(), Filling::Runs(2));
        assert_eq!(packed.tests, [vec!["e", "d"], vec!["b", "c"], vec!["a"]]);
        assert!(packed.samples.is_empty());
    }

    #[test]
    fn an_element_takes_the_stated_time_and_a_run_that_is_longer_has_one_of_its_own() {
        let runs: Vec<QueuedRun> = ["0.2", "0.2", "0.2", "0.2", "2"]
            .iter()
            .enumerate()
            .map(|(k, strain)| run(&k.to_string(), strain, None))
            .collect();
        let of_work = 100.0 / runs[0].expected_work();
        let packed = pack(&runs, &BTreeMap::new(), Filling::Seconds { of_element: 250.0, of_work });
        assert_eq!(packed.tests, [vec!["4"], vec!["0", "1"], vec!["2", "3"]]);
    }

    /// A sample that one element needs is prepared there; one that several need comes before them.
    #[test]
    fn samples_that_several_elements_need_come_first() {
        let samples = BTreeMap::from([sample("sample 1"), sample("sample 2")]);
        let runs = [
            run("a", "0.3", Some("sample 1")),
            run("b", "0.4", Some("sample 2")),
            run("c", "0.3", Some("sample 1")),
            run("d", "0.3", Some("sample 1")),
            run("e", "0.1", Some("sample 2")),
            run("f", "0.5", Some("sample 3 that is finished")),
        ];
        let packed = pack(&runs, &samples, Filling::Runs(3));
        assert_eq!(packed.tests, [vec!["f", "b", "e"], vec!["a", "c", "d"]]);
        assert!(packed.samples.is_empty());
        let packed = pack(&runs, &samples, Filling::Runs(2));
        assert_eq!(packed.tests, [vec!["f", "b"], vec!["e", "a"], vec!["c", "d"]]);
        assert_eq!(packed.samples, [vec!["sample 1", "sample 2"]]);
    }
}
