//! Words and shares in sentences.

/// A list of words: `a`, `a and b`, `a, b and c`.
///
/// ```
/// assert_eq!(granum_core::words::listed(&["q/p", "phi_d", "P(f)"]), "q/p, phi_d and P(f)");
/// ```
pub fn listed<S: AsRef<str>>(words: &[S]) -> String {
    match words {
        [] => String::new(),
        [one] => one.as_ref().to_owned(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}

/// A number with so many decimals. What rounds to zero has no sign.
///
/// ```
/// assert_eq!([1.26, -0.04, -0.0].map(|value| granum_core::words::fixed(value, 1)), ["1.3", "0.0", "0.0"]);
/// ```
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(size) if size.chars().all(|c| c == '0' || c == '.') => size.to_owned(),
        _ => text,
    }
}

/// The same of a change, with its sign: `+0.12`, `-0.12`, and `+0.00` where it rounds to zero.
pub fn signed(value: f64, decimals: usize) -> String {
    let text = fixed(value, decimals);
    if text.starts_with('-') || value.is_nan() { text } else { format!("+{text}") }
}

/// A share in per cent with so many decimals: `12.3 %`. What rounds to zero has no sign.
pub fn percent(share: f64, decimals: usize) -> String {
    format!("{} %", fixed(100.0 * share, decimals))
}

/// A share in per cent with two decimals: `12.34 %`.
pub fn percentage(share: f64) -> String {
    percent(share, 2)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_shares_read_well() {
        let words = ["a", "b", "c"];
        assert_eq!([listed(&words[..0]), listed(&words[..1]), listed(&words[..2])], ["", "a", "a and b"]);
        assert_eq!(listed(&words.map(String::from)), "a, b and c");
        assert_eq!(percentage(0.02034), "2.03 %");
    }

    #[test]
    fn what_rounds_to_zero_has_no_sign() {
        assert_eq!([-0.0, -4e-5, -6e-5, 6e-5].map(percentage), ["0.00 %", "0.00 %", "-0.01 %", "0.01 %"]);
        assert_eq!([-0.004, 0.004, -0.06].map(|share| percent(share, 0)), ["0 %", "0 %", "-6 %"]);
        assert_eq!([-0.004, 0.004, -0.006, 0.1].map(|x| signed(x, 2)), ["+0.00", "+0.00", "-0.01", "+0.10"]);
        assert_eq!([f64::NAN, f64::NEG_INFINITY].map(|x| signed(x, 2)), ["NaN", "-inf"]);
    }
}
