//! Which finished runs are part of the data set: those that passed every check, and those that the plan accepts all the same.

use crate::journal::FailedCheck;
use crate::plan::Condition;

/// True if every check that a run did not pass is met by a condition of the plan on the same name, `largest_overlap < 0.05`. A run that
/// passed all is accepted.
///
/// ```
/// use granum_campaign::acceptance::is_accepted;
/// use granum_campaign::journal::FailedCheck;
/// use granum_campaign::plan::Condition;
///
/// let flags = [FailedCheck { name: "largest_overlap".into(), value: Some(0.03), limit: 0.02 }];
/// assert!(!is_accepted(&flags, &[]));
/// assert!(is_accepted(&flags, &[Condition::parse("largest_overlap < 0.05")?]));
/// # Ok::<(), String>(())
/// ```
pub fn is_accepted(flags: &[FailedCheck], accept: &[Condition]) -> bool {
    let value = |name: &str| flags.iter().find(|flag| flag.name == name).and_then(|flag| flag.value);
    flags.iter().all(|flag| {
        let mut on_it =
            accept.iter().filter(|condition| condition.names().any(|name| name == flag.name)).peekable();
        on_it.peek().is_some() && on_it.all(|condition| condition.holds(&value) == Ok(true))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_failed_check_needs_a_condition_that_holds() {
        let flag = |name: &str, value| FailedCheck { name: name.into(), value, limit: 0.0 };
        let accept: Vec<Condition> =
            ["a < 1", "b < 1", "b > 0.5"].iter().map(|text| Condition::parse(text).unwrap()).collect();
        assert!(is_accepted(&[], &[]));
        assert!(is_accepted(&[flag("a", Some(0.5))], &accept));
        assert!(!is_accepted(&[flag("a", Some(0.5)), flag("c", Some(0.5))], &accept));
        assert!(!is_accepted(&[flag("b", Some(0.2))], &accept));
        assert!(is_accepted(&[flag("b", Some(0.7))], &accept));
        // What is no number is never accepted.
        assert!(!is_accepted(&[flag("a", None)], &accept));
    }
}
