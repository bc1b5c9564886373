//! Ticks at round numbers, and labels with as few digits as possible.

/// One tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Position in data coordinates.
    pub value: f64,
    /// Marked-up label; `None` for a minor tick.
    pub label: Option<String>,
}

/// The number nearest to a power of ten.
pub fn power_of_ten(exponent: i32) -> f64 {
    // Repeated multiplication rounds, and so do powers of some libraries.
    format!("1e{exponent}").parse().unwrap_or(f64::NAN)
}

/// Step of a linear axis: 1, 2 or 5 times a power of ten, with about `target` steps over a span.
pub fn nice_step(span: f64, target: f64) -> f64 {
    if !(span.is_finite() && span > 0.0 && target > 0.0) {
        return 1.0;
    }
    let rough = span / target;
    let power = power_of_ten(libm::log10(rough).floor() as i32);
    let mantissa = rough / power;
    let nice = if mantissa < 1.5 {
        1.0
    } else if mantissa < 3.5 {
        2.0
    } else if mantissa < 7.5 {
        5.0
    } else {
        10.0
    };
    nice * power
}

/// Number of minor steps in a major step.
fn minor_steps(step: f64) -> i64 {
    let mantissa = step / power_of_ten((libm::log10(step) + 1e-9).floor() as i32);
    if (mantissa - 2.0).abs() < 0.1 { 4 } else { 5 }
}

/// Number of decimals that the labels of a linear axis need.
fn decimals(step: f64) -> usize {
    (-(libm::log10(step) + 1e-9).floor()).clamp(0.0, 12.0) as usize
}

/// Major and minor ticks of a linear axis from `low` to `high`.
pub fn linear(low: f64, high: f64, target: f64) -> Vec<Tick> {
    let step = nice_step(high - low, target);
    let parts = minor_steps(step);
    let minor = step / parts as f64;
    let (first, last) = ((low / minor - 1e-6).ceil(), (high / minor + 1e-6).floor());
    if !(first.is_finite() && last.is_finite()) || last - first > 1000.0 {
        return Vec::new();
    }
    (first as i64..=last as i64)
        .map(|k| {
            let major = k.rem_euclid(parts) == 0;
            let value = k as f64 * minor;
            Tick {
                value,
                label: major.then(|| if k == 0 { "0".to_owned() } else { fixed(value, decimals(step)) }),
            }
        })
        .collect()
}

/// Major ticks at powers of ten and minor ticks between them, from `low` to `high` (both positive). On axes of up to about
/// two decades, 2 and 5 are labelled as well; on axes of many decades only some powers are labelled.
pub fn logarithmic(low: f64, high: f64, target: f64) -> Vec<Tick> {
    if !(low > 0.0 && high > low && high.is_finite()) {
        return Vec::new();
    }
    let decades = libm::log10(high / low);
    let stride = (decades / target.max(1.0)).ceil().max(1.0) as i32;
    let mut ticks = Vec::new();
    let (first, last) = (libm::log10(low).floor() as i32, libm::log10(high).ceil() as i32);
    for exponent in first..=last {
        for digit in 1..10 {
            let value = digit as f64 * power_of_ten(exponent);
            if !(low * (1.0 - 1e-9)..=high * (1.0 + 1e-9)).contains(&value) || (digit > 1 && stride > 1) {
                continue;
            }
            let label = if digit == 1 && exponent.rem_euclid(stride) == 0 {
                Some(if decades < 2.5 && (-4..4).contains(&exponent) {
                    fixed(value, (-exponent).max(0) as usize)
                } else {
                    label_of_power(exponent)
                })
            } else if decades < 2.2 && (digit == 2 || digit == 5) {
                Some(small_power(digit, exponent))
            } else {
                None
            };
            ticks.push(Tick { value, label });
        }
    }
    ticks
}

fn label_of_power(exponent: i32) -> String {
    match exponent {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        _ => format!("10^{{{}}}", fixed(exponent as f64, 0)),
    }
}

fn small_power(digit: i32, exponent: i32) -> String {
    if (-4..4).contains(&exponent) {
        fixed(digit as f64 * power_of_ten(exponent), (-exponent).max(0) as usize)
    } else {
        format!("{digit} × {}", label_of_power(exponent))
    }
}

/// A number with a fixed number of decimals and a typographic minus sign; never `−0`.
pub fn fixed(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.chars().all(|c| c == '0' || c == '.') => rest.to_owned(),
        Some(rest) => format!("−{rest}"),
        None => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn labels(ticks: &[Tick]) -> Vec<String> {
        ticks.iter().filter_map(|tick| tick.label.clone()).collect()
    }

    #[test]
    fn linear_ticks_are_round() {
        assert_eq!(labels(&linear(0.0, 0.3, 6.0)), ["0", "0.05", "0.10", "0.15", "0.20", "0.25", "0.30"]);
        assert_eq!(labels(&linear(-1.0, 1.0, 4.0)), ["−1.0", "−0.5", "0", "0.5", "1.0"]);
        assert_eq!(labels(&linear(0.0, 20000.0, 4.0)), ["0", "5000", "10000", "15000", "20000"]);
        assert_eq!(linear(0.0, 1.0, 5.0).len(), 21);
    }

    #[test]
    fn logarithmic_ticks_are_powers() {
        assert_eq!(labels(&logarithmic(1e-3, 1.0, 5.0)), ["10^{−3}", "10^{−2}", "10^{−1}", "1"]);
        assert_eq!(labels(&logarithmic(0.1, 1.0, 5.0)), ["0.1", "0.2", "0.5", "1"]);
        assert!(labels(&logarithmic(1e-30, 1e30, 6.0)).len() < 9);
    }

    #[test]
    fn hostile_ranges_give_no_ticks_and_no_panic() {
        for (low, high) in [(f64::NAN, 1.0), (0.0, f64::INFINITY), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)] {
            assert!(linear(low, high, 5.0).len() < 10);
            assert!(logarithmic(low, high, 5.0).is_empty());
        }
        assert!(linear(1e300, 1.0000000001e300, 5.0).len() < 1000);
    }

    proptest! {
        #[test]
        fn there_are_some_ticks_but_not_too_many(low in -1e6..1e6f64, exponent in -6.0..6.0f64) {
            let high = low + 10f64.powf(exponent).max(1e-9 * low.abs());
            let count = linear(low, high, 5.0).iter().filter(|tick| tick.label.is_some()).count();
            prop_assert!((2..=9).contains(&count), "{count} on {low}..{high}");
        }
    }
}
