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

/// A share in per cent with two decimals: `12.34 %`.
pub fn percentage(share: f64) -> String {
    format!("{:.2} %", 100.0 * share)
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
}
