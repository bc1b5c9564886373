//! Readable formatting of numbers.

use granum_core::quantity::format_number;
use granum_learn::student_t::PairedTest;

use super::figure::ticks::{fixed, power_of_ten};

/// A number with at most so many significant digits, without zeros at its end; zero has no sign.
pub fn rounded(value: f64, digits: usize) -> String {
    let text = format!("{value:.*e}", digits.saturating_sub(1));
    text.parse::<f64>().map_or(text, |value| format_number(value + 0.0))
}

/// Narrow no-break space between groups of digits and before units.
const THIN: char = '\u{202f}';

/// A number with `digits` significant digits, marked up for [`super::figure::Rich`]; with a power of ten if it is below a
/// thousandth or has more than six digits before the decimal point.
pub fn significant(value: f64, digits: usize) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = digits.max(1) as i32;
    // The exponent is determined after rounding: 0.0999 with two digits is 0.10.
    let scientific = format!("{:.*e}", digits as usize - 1, value);
    let exponent: i32 = scientific.split('e').nth(1).and_then(|text| text.parse().ok()).unwrap_or(0);
    if (-3..6).contains(&exponent) {
        let decimals = (digits - 1 - exponent).max(0) as usize;
        return grouped(&fixed(value, decimals));
    }
    let mantissa = scientific.split('e').next().unwrap_or("0").replace('-', "−");
    format!("{mantissa} × 10^{{{}}}", fixed(exponent as f64, 0))
}

/// A fraction as a percentage on a page, with two significant digits and at most two decimals.
pub fn percent(share: f64) -> String {
    if !share.is_finite() {
        return "–".to_owned();
    }
    let value = 100.0 * share;
    if value != 0.0 && value.abs() < 0.0095 {
        return format!("{}{THIN}%", significant(value, 1));
    }
    let decimals = match value.abs() {
        v if v >= 9.95 => 0,
        v if v >= 0.995 => 1,
        _ => 2,
    };
    format!("{}{THIN}%", fixed(value, decimals))
}

/// A mean difference in percentage points with its standard error, marked if the test finds it above zero.
pub fn points(test: Option<PairedTest>) -> String {
    let Some(test) = test.filter(|test| test.mean.is_finite()) else { return "–".to_owned() };
    let error = test.standard_error.map_or(String::new(), |error| format!(" ± {}", fixed(100.0 * error, 2)));
    let mark = if test.above_zero == Some(true) { " †" } else { "" };
    format!("{}{error}{mark}", fixed(100.0 * test.mean, 2))
}

/// An integer with groups of three digits.
pub fn whole(value: f64) -> String {
    if value.is_finite() { grouped(&fixed(value, 0)) } else { "–".to_owned() }
}

/// A factor: one decimal below ten, rounded to two digits above.
pub fn factor(value: f64) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if value.abs() < 9.95 {
        return fixed(value, 1);
    }
    let power = power_of_ten(libm::log10(value.abs()).floor() as i32 - 1);
    whole((value / power).round() * power)
}

/// A time in a suitable unit.
pub fn duration(seconds: f64) -> String {
    if !seconds.is_finite() {
        return "–".to_owned();
    }
    let at = |value: f64, unit: &str| format!("{}{THIN}{unit}", significant(value, 3));
    match seconds {
        s if s < 1e-6 => at(1e9 * s, "ns"),
        s if s < 1e-3 => at(1e6 * s, "μs"),
        s if s < 1.0 => at(1e3 * s, "ms"),
        s if s < 120.0 => at(s, "s"),
        s if s < 7200.0 => format!("{}{THIN}min {:02}{THIN}s", (s / 60.0).floor(), (s % 60.0).floor()),
        s => format!("{}{THIN}h {:02}{THIN}min", whole((s / 3600.0).floor()), (s % 3600.0 / 60.0).floor()),
    }
}

/// A quantity with an SI prefix: `20 kPa`, `0.1 mm`; a number without a unit has none.
pub fn quantity(value: f64, unit: &str) -> String {
    if !value.is_finite() {
        return "–".to_owned();
    }
    if unit.is_empty() {
        return trimmed(value);
    }
    let prefixes = [(1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "μ"), (1e-9, "n")];
    let largest = 1.0 + 1e-9;
    let (factor, prefix) = prefixes
        .into_iter()
        .find(|(factor, _)| value.abs() * largest >= *factor)
        .unwrap_or(if value == 0.0 { (1.0, "") } else { (1e-9, "n") });
    format!("{}{THIN}{prefix}{unit}", trimmed(value / factor))
}

/// A number with at most four significant digits and without trailing zeros.
pub fn trimmed(value: f64) -> String {
    let text = significant(value, 4);
    if !text.contains('.') || text.contains('×') {
        return text;
    }
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

fn grouped(text: &str) -> String {
    let (head, tail) = text.split_once('.').map_or((text, ""), |(head, tail)| (head, tail));
    let digits = head.chars().filter(char::is_ascii_digit).count();
    let mut out = String::new();
    let mut left = digits;
    for c in head.chars() {
        out.push(c);
        if c.is_ascii_digit() {
            left -= 1;
            if left > 0 && left.is_multiple_of(3) && digits > 4 {
                out.push(THIN);
            }
        }
    }
    if !tail.is_empty() {
        out.push('.');
        out.push_str(tail);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!(significant(0.61234, 3), "0.612");
        assert_eq!(significant(0.0999, 2), "0.10");
        assert_eq!(significant(-2.5e-7, 2), "−2.5 × 10^{−7}");
        assert_eq!(significant(123456.0, 3), "123\u{202f}456");
        assert_eq!(significant(f64::NAN, 3), "–");
        assert_eq!(percent(0.01234), "1.2\u{202f}%");
        assert_eq!(percent(1.6e-7), "2 × 10^{−5}\u{202f}%");
        assert_eq!(percent(0.0), "0.00\u{202f}%");
        assert_eq!(percent(0.5), "50\u{202f}%");
        assert_eq!(whole(150000.0), "150\u{202f}000");
        assert_eq!(whole(5000.0), "5000");
        assert_eq!(factor(123456.0), "120\u{202f}000");
        assert_eq!(factor(7.26), "7.3");
    }

    #[test]
    fn quantities_and_times_take_a_suitable_unit() {
        assert_eq!(quantity(20e3, "Pa"), "20\u{202f}kPa");
        assert_eq!(quantity(1e-4, "m"), "100\u{202f}μm");
        assert_eq!(quantity(70e9, "Pa"), "70\u{202f}GPa");
        assert_eq!(quantity(0.6, "J/m"), "600\u{202f}mJ/m");
        assert_eq!(quantity(0.3514, ""), "0.3514");
        assert_eq!(quantity(1500.0, ""), "1500");
        assert_eq!(duration(272.0), "4\u{202f}min 32\u{202f}s");
        assert_eq!(duration(0.0021), "2.10\u{202f}ms");
        assert_eq!(duration(7300.0), "2\u{202f}h 01\u{202f}min");
    }

    #[test]
    fn differences_carry_their_error_and_test() {
        assert_eq!(points(PairedTest::new(&[0.01, 0.02, 0.03])), "2.00 ± 0.58 †");
        assert_eq!(points(PairedTest::new(&[-0.01])), "−1.00");
        assert_eq!(points(None), "–");
    }
}
