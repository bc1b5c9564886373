//! Quotients that are zero where nothing is divided by nothing.

/// `sum / count`, and 0 if the count is 0.
pub(crate) fn mean(sum: f64, count: usize) -> f64 {
    if count == 0 { 0.0 } else { sum / count as f64 }
}

/// `part / whole`, and 0 if the whole is 0.
pub(crate) fn ratio(part: f64, whole: f64) -> f64 {
    if whole == 0.0 { 0.0 } else { part / whole }
}
