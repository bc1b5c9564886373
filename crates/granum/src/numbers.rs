//! Numbers in messages.

pub use granum_report::numbers::rounded;

/// A value and its limit, each with so many digits that different numbers are printed as different numbers: a limit of 1.05e-3 is not
/// 1.0e-3, and a value that is beyond its limit does not look equal to it.
pub fn apart(value: f64, limit: f64) -> [String; 2] {
    let shown = |digits: usize| [value, limit].map(|number| rounded(number, digits));
    (3..=17).map(shown).find(|[a, b]| a != b || value == limit).unwrap_or_else(|| shown(17))
}

/// A value that is outside a range, and the range, with so many digits that the value is printed outside.
pub fn apart_from_range(value: f64, range: [f64; 2]) -> [String; 3] {
    let shown = |digits: usize| [value, range[0], range[1]].map(|number| rounded(number, digits));
    let differ = |[value, low, high]: &[String; 3]| value != low && value != high;
    (4..=17).map(shown).find(differ).unwrap_or_else(|| shown(17))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_few_digits_and_stay_apart() {
        assert_eq!(rounded(0.37080054892873954, 4), "0.3708");
        assert_eq!(rounded(0.3, 4), "0.3");
        assert_eq!(rounded(-0.0, 4), "0");
        assert_eq!(rounded(1.05e-7, 4), "1.05e-7");
        assert_eq!(apart(2e-3, 1.05e-3), ["0.002", "0.00105"]);
        assert_eq!(apart(1.0500001e-3, 1.05e-3), ["0.0010500001", "0.00105"]);
        assert_eq!(apart(f64::NAN, 0.1), ["nan", "0.1"]);
        assert_eq!(apart(0.1, 0.1), ["0.1", "0.1"]);
        assert_eq!(apart_from_range(0.37080054892873954, [0.01, 0.25]), ["0.3708", "0.01", "0.25"]);
        assert_eq!(apart_from_range(0.250001, [0.01, 0.25]), ["0.250001", "0.01", "0.25"]);
    }
}
