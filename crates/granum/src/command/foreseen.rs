//! The checks that runs will not pass, told before they are run.

use std::collections::BTreeMap;

use granum_campaign::Campaign;
use granum_campaign::acceptance::is_accepted;
use granum_campaign::journal::FailedCheck;
use granum_io::Case;
use granum_run::engine::{ForeseenFailure, foreseen_failures};
use granum_run::queue::{Queue, RunKind};
use serde_json::{Value, json};

use crate::context::Context;
use crate::failure::Failure;

/// Number of runs that are named in a message.
const MOST_NAMED: usize = 6;

/// Runs by name with the checks that they will not pass.
pub struct Foreseen {
    runs: usize,
    failures: Vec<(String, ForeseenFailure)>,
}

/// Tells what the test of a case will not pass. With `--json` nothing is printed before a run has ended, when its checks tell.
pub fn tell_one(context: &Context, case: &Case) {
    if context.json {
        return;
    }
    for failure in foreseen_failures(case) {
        context.warn(&failure.sentence());
    }
}

impl Foreseen {
    fn from_cases(cases: impl Iterator<Item = (String, Case)>) -> Foreseen {
        let mut foreseen = Foreseen { runs: 0, failures: Vec::new() };
        for (name, case) in cases {
            foreseen.runs += 1;
            foreseen
                .failures
                .extend(foreseen_failures(&case).into_iter().map(|failure| (name.clone(), failure)));
        }
        foreseen
    }

    /// Those of the tests of a queue.
    pub fn of_queue(queue: &Queue) -> Foreseen {
        let tests = queue.runs().iter().filter(|run| run.kind == RunKind::Test);
        Foreseen::from_cases(tests.map(|run| (run.name.clone(), run.case.clone())))
    }

    /// Those of the runs of a campaign which its plan does not accept all the same.
    pub fn of_campaign(campaign: &Campaign) -> Result<Foreseen, Failure> {
        let cases: Result<Vec<(String, Case)>, Failure> =
            campaign.runs().iter().map(|run| Ok((run.name.clone(), campaign.case_of(run)?))).collect();
        let (mut foreseen, accept) = (Foreseen::from_cases(cases?.into_iter()), campaign.accept());
        foreseen.failures.retain(|(_, failure)| {
            let flag =
                FailedCheck { name: failure.check.into(), value: Some(failure.value), limit: failure.limit };
            !is_accepted(&[flag], &accept)
        });
        Ok(foreseen)
    }

    /// Warns of them, each check once; `left_out` says what becomes of runs that do not pass.
    pub fn tell(&self, context: &Context, left_out: &str) {
        let mut by_check: BTreeMap<(&str, bool), Vec<&(String, ForeseenFailure)>> = BTreeMap::new();
        for failure in &self.failures {
            by_check.entry((failure.1.check, !failure.1.is_certain)).or_default().push(failure);
        }
        for ((check, is_estimate), failures) in by_check {
            let values = failures.iter().map(|(_, failure)| failure.value);
            let [low, high] =
                values.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)]);
            let Some((_, first)) = failures.first() else { continue };
            let will = if is_estimate { "are not expected to pass" } else { "will not pass" };
            let value =
                if high > 1.001 * low { format!("{low:.3e} to {high:.3e}") } else { format!("{high:.3e}") };
            context.warn(&format!(
                "{} of {} runs {will} their check of {}: about {value} where at most {:.3e} is accepted; {}{left_out}: {}",
                failures.len(),
                self.runs,
                check.replace('_', " "),
                first.limit,
                first.advice,
                named(&failures)
            ));
        }
    }

    /// As JSON, a list.
    pub fn as_json(&self) -> Value {
        let one = |(run, failure): &(String, ForeseenFailure)| {
            json!({
                "run": run,
                "check": failure.check,
                "value": failure.value,
                "limit": failure.limit,
                "certain": failure.is_certain,
                "advice": failure.advice,
            })
        };
        json!(self.failures.iter().map(one).collect::<Vec<_>>())
    }
}

fn named(failures: &[&(String, ForeseenFailure)]) -> String {
    let names =
        failures.iter().take(MOST_NAMED).map(|(name, _)| name.as_str()).collect::<Vec<_>>().join(", ");
    match failures.len().saturating_sub(MOST_NAMED) {
        0 => names,
        more => format!("{names} and {more} more"),
    }
}
