//! Elementary functions composed of operations that give the same bits on every machine.

use granum_dem::contact::law::elementary::arctan;
use granum_simd::{Isa, Kernel, LANES, Lanes, dispatch, exp};

/// Natural logarithm of a positive finite number; relative error below 1e-14.
pub(crate) fn ln(x: f64) -> f64 {
    let exponent = ((x.to_bits() >> 52) as i64 - 1023) as f64;
    let mut y = (exponent + 0.5) * std::f64::consts::LN_2;
    // Halley's method for e^y = x: each iteration cubes the error, which is at most 0.35 at the start.
    for _ in 0..4 {
        let e: f64 = exp(y);
        y += 2.0 * (x - e) / (x + e);
    }
    y
}

/// Intervals of the rule of integration, and its points in whole groups of lanes.
const INTERVALS: usize = 256;
const POINTS: usize = (INTERVALS + 1).next_multiple_of(LANES);

/// Replaces numbers by their exponentials, eight at once: a processor without a fused multiplication takes a hundred times as
/// long for them one by one, with the same bits.
struct Exponentials<'a>(&'a mut [f64; POINTS]);

impl Kernel for Exponentials<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for eight in self.0.as_chunks_mut::<LANES>().0 {
            exp(L::load(eight)).store(eight);
        }
    }
}

/// Mills ratio of the normal distribution, `R(x) = integral_0^inf exp(-u^2/2 - x u) du` for x >= 0, by Boole's
/// rule; relative error below 1e-9 for x < 20.
pub(crate) fn mills_ratio(x: f64) -> f64 {
    // Beyond this point the integrand is below e^-40 of its value at 0.
    let end = (x * x + 80.0).sqrt() - x;
    let h = end / INTERVALS as f64;
    let mut values = [0.0; POINTS];
    for (k, value) in values.iter_mut().enumerate().take(INTERVALS + 1) {
        let u = k as f64 * h;
        *value = -u * (0.5 * u + x);
    }
    dispatch(Isa::detect(), Exponentials(&mut values));
    let mut sum = 0.0;
    for (k, value) in values.iter().enumerate().take(INTERVALS + 1) {
        let weight = if k == 0 || k == INTERVALS { 7.0 } else { [14.0, 32.0, 12.0, 32.0][k % 4] };
        sum += weight * value;
    }
    sum * h * (2.0 / 45.0)
}

/// Arc sine in degrees; 90 and -90 beyond 1 and -1.
pub(crate) fn asin_degrees(x: f64) -> f64 {
    if x.abs() >= 1.0 {
        return 90.0 * x.signum();
    }
    arctan(x / ((1.0 - x) * (1.0 + x)).sqrt()) * (180.0 / std::f64::consts::PI)
}

/// Arc cosine in degrees; 0 and 180 beyond 1 and -1.
pub(crate) fn acos_degrees(x: f64) -> f64 {
    90.0 - asin_degrees(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logarithm_agrees_with_the_system() {
        for x in [1e-300, 1e-9, 0.3, 0.5, 1.0 - 1e-12, 1.0, 1.5, 2.0, 31.0, 1e12, 1e300f64] {
            assert!((ln(x) - x.ln()).abs() <= 1e-14 * x.ln().abs().max(1.0), "{x}: {} {}", ln(x), x.ln());
        }
    }

    #[test]
    fn exponentials_of_eight_have_the_bits_of_one() {
        let arguments: [f64; POINTS] = std::array::from_fn(|k| -0.17 * k as f64 + 1e-3);
        for isa in Isa::ALL {
            let mut values = arguments;
            dispatch(isa, Exponentials(&mut values));
            assert!(
                values.iter().zip(arguments).all(|(value, x)| value.to_bits() == exp::<f64>(x).to_bits())
            );
        }
    }

    #[test]
    fn mills_ratio_at_known_points() {
        // R(0) = sqrt(pi/2); R(1) = 0.6556795424187985 and R(3) = 0.3045902987101033 (Mills 1926, with more digits).
        for (x, exact) in [
            (0.0, (0.5 * std::f64::consts::PI).sqrt()),
            (1.0, 0.655_679_542_418_798_5),
            (3.0, 0.304_590_298_710_103_3),
        ] {
            assert!((mills_ratio(x) / exact - 1.0).abs() < 1e-9, "{x}: {}", mills_ratio(x));
        }
    }

    #[test]
    fn inverse_functions_of_angles_agree_with_the_system() {
        for k in -400..=400 {
            let x = f64::from(k) / 400.0;
            assert!((asin_degrees(x) - x.asin().to_degrees()).abs() < 2e-13, "{x}: {}", asin_degrees(x));
            assert!((acos_degrees(x) - x.acos().to_degrees()).abs() < 2e-13, "{x}");
        }
        assert_eq!((asin_degrees(1.5), acos_degrees(-1.5)), (90.0, 180.0));
    }
}
