//! The inputs of a prediction from the command line, and what is said of them.

use granum_core::names::nearest;
use granum_learn::surrogate::Outside;

use super::trained_range::short;
use crate::failure::Failure;

/// Nominal coverage of the intervals for states of unseen runs.
pub(super) const LEVEL: f64 = 0.9;

/// The row that `--set` flags give, in the order of the inputs; `needs` says what these are.
pub(super) fn row(
    names: &[String],
    flags: &[String],
    needs: &dyn Fn() -> String,
) -> Result<Vec<f64>, Failure> {
    let mut row = vec![None; names.len()];
    for flag in flags {
        let (name, text) = flag
            .split_once('=')
            .ok_or_else(|| Failure::new(format!("--set {flag}: write it as INPUT=VALUE\n{}", needs())))?;
        let k = names.iter().position(|known| known == name.trim()).ok_or_else(|| {
            let near = nearest(name.trim(), names.iter().map(String::as_str));
            let hint = near.map_or(String::new(), |near| format!("; did you mean {near}?"));
            Failure::new(format!("--set {flag}: there is no such input{hint}\n{}", needs()))
        })?;
        let value =
            text.trim().parse::<f64>().ok().filter(|value| value.is_finite()).ok_or_else(|| {
                Failure::new(format!("--set {flag}: {:?} is not a finite number", text.trim()))
            })?;
        if row[k].replace(value).is_some() {
            return Err(Failure::new(format!("--set {flag}: {} is given twice", names[k])));
        }
    }
    let missing: Vec<&str> =
        names.iter().zip(&row).filter(|(_, v)| v.is_none()).map(|(name, _)| name.as_str()).collect();
    if !missing.is_empty() {
        let example = missing.first().map_or(String::new(), |name| format!(" (e.g. --set {name}=VALUE)"));
        return Err(Failure::new(format!("missing: {}{example}\n{}", missing.join(", "), needs())));
    }
    Ok(row.into_iter().flatten().collect())
}

/// A sentence on the inputs that lie outside the trained range.
pub(super) fn outside_text(outside: &[Outside]) -> Option<String> {
    let each = outside.iter().map(|outside| {
        let [low, high] = outside.range;
        format!("{} = {} (trained from {} to {})", outside.name, outside.value, short(low), short(high))
    });
    let all = each.collect::<Vec<_>>().join(", ");
    (!all.is_empty()).then(|| format!("OUTSIDE the trained range: {all}; do not trust this answer."))
}
