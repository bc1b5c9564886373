//! A fused multiply-add of single numbers that needs no instruction for it.
#![cfg_attr(
    any(target_arch = "aarch64", granum_relaxed),
    allow(dead_code, reason = "every processor of these targets has the instruction")
)]

/// `factor * other + term`, rounded once, on any processor.
///
/// Far from underflow and overflow the product and its error, and the sum of three numbers that is left, are computed with
/// roundings whose errors are known exactly, and the last but one of them rounds to odd, so that the last one decides as if
/// it were the only one: S. Boldo and G. Melquiond, Emulation of a FMA and correctly rounded sums: proved algorithms using
/// rounding to odd, IEEE Transactions on Computers 57 (2008) 462. Elsewhere, integers are summed ([`by_integers`]).
#[inline(never)]
pub(crate) fn exact(factor: f64, other: f64, term: f64) -> f64 {
    // Magnitudes from 2^-480 to 2^480, and of the term from 2^-900 to 2^1000: no error of a product or sum is lost, and a result so
    // small that it has fewer bits is exact.
    let within = |value: f64, least: u64, most: u64| (least..most).contains(&(value.to_bits() >> 52 & 0x7ff));
    if !(within(factor, 543, 1503) && within(other, 543, 1503) && within(term, 123, 2023)) {
        return by_integers(factor, other, term);
    }
    let (product, rest) = two_product(factor, other);
    if rest == 0.0 {
        return product + term;
    }
    let (high, low) = two_sum(term, rest);
    let (sum, middle) = two_sum(product, high);
    sum + sum_to_odd(middle, low)
}

/// The sum of two numbers and the error of its rounding (Knuth).
#[inline(always)]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_part = sum - a;
    (sum, (a - (sum - b_part)) + (b - b_part))
}

/// The product of two numbers and the error of its rounding (Dekker).
#[inline(always)]
fn two_product(a: f64, b: f64) -> (f64, f64) {
    /// Two parts of at most 26 bits, the second with a sign (Veltkamp).
    #[inline(always)]
    fn split(x: f64) -> (f64, f64) {
        let scaled = 134_217_729.0 * x;
        let high = scaled - (scaled - x);
        (high, x - high)
    }
    let product = a * b;
    let ((a_high, a_low), (b_high, b_low)) = (split(a), split(b));
    (product, a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low))
}

/// The sum of two numbers; if it is not exact, the neighbour of the exact sum whose last bit is one.
#[inline(always)]
fn sum_to_odd(a: f64, b: f64) -> f64 {
    let (sum, error) = two_sum(a, b);
    let bits = sum.to_bits();
    if error == 0.0 || bits & 1 == 1 {
        return sum;
    }
    // Towards the exact sum: to a larger magnitude if the error has the sign of the sum.
    let larger = (error > 0.0) == (sum > 0.0);
    f64::from_bits(if larger { bits + 1 } else { bits - 1 })
}

/// A number that is not zero: `magnitude * 2^exponent`, the highest bit of the magnitude at [`TOP`].
struct Wide {
    negative: bool,
    magnitude: u128,
    exponent: i32,
}

/// Place of the highest bit of a [`Wide`]: a sum of two has a bit more, and at least 20 bits below the 106 of a product are zero.
const TOP: i32 = 125;

impl Wide {
    fn new(negative: bool, magnitude: u128, exponent: i32) -> Wide {
        let shift = TOP - (127 - magnitude.leading_zeros() as i32);
        Wide { negative, magnitude: magnitude << shift, exponent: exponent - shift }
    }
}

/// Sign, integral significand and exponent of a finite number.
fn parts(value: f64) -> (bool, u64, i32) {
    let bits = value.to_bits();
    let (field, fraction) = ((bits >> 52 & 0x7ff) as i32, bits & ((1 << 52) - 1));
    let significand = if field == 0 { fraction } else { fraction | 1 << 52 };
    (value.is_sign_negative(), significand, field.max(1) - 1075)
}

/// `factor * other + term`, rounded once, for all numbers, zeros, infinities and NaN.
#[cold]
#[inline(never)]
pub(super) fn by_integers(factor: f64, other: f64, term: f64) -> f64 {
    if !factor.is_finite() || !other.is_finite() || factor == 0.0 || other == 0.0 {
        // Infinite, NaN, or an exact product.
        return factor * other + term;
    }
    if !term.is_finite() {
        return term + term;
    }
    let ((a_negative, a, a_exponent), (b_negative, b, b_exponent)) = (parts(factor), parts(other));
    let product = Wide::new(a_negative != b_negative, u128::from(a) * u128::from(b), a_exponent + b_exponent);
    if term == 0.0 {
        return rounded(product.negative, product.magnitude, product.exponent);
    }
    let (c_negative, c, c_exponent) = parts(term);
    let term = Wide::new(c_negative, u128::from(c), c_exponent);
    let (larger, smaller) = if (product.exponent, product.magnitude) > (term.exponent, term.magnitude) {
        (product, term)
    } else {
        (term, product)
    };
    // Bits that the smaller one loses are remembered in its last bit: they are lost only where it is less than 2^-20 of the larger one,
    // so that the place where the result is rounded is far above.
    let distance = larger.exponent - smaller.exponent;
    let shifted = if distance > TOP { 0 } else { smaller.magnitude >> distance };
    let lost = distance > TOP || shifted << distance != smaller.magnitude;
    let shifted = shifted | u128::from(lost);
    let same = larger.negative == smaller.negative;
    let sum = if same { larger.magnitude + shifted } else { larger.magnitude - shifted };
    if sum == 0 { 0.0 } else { rounded(larger.negative, sum, larger.exponent) }
}

/// The number nearest to `magnitude * 2^exponent`, where a magnitude is below 2^127 and not zero; ties go to an even significand.
fn rounded(negative: bool, magnitude: u128, exponent: i32) -> f64 {
    let highest = 127 - magnitude.leading_zeros() as i32 + exponent;
    // Exponent of the last bit that the result has.
    let last = (highest - 52).max(-1074);
    let drop = last - exponent;
    let significand = if drop <= 0 {
        magnitude << -drop
    } else if drop > 127 {
        0
    } else {
        let (whole, rest, half) = (magnitude >> drop, magnitude & ((1 << drop) - 1), 1 << (drop - 1));
        whole + u128::from(rest > half || (rest == half && whole & 1 == 1))
    };
    // The highest bit of the significand counts in the exponent, also where rounding has made one bit more; subnormal numbers have none.
    let bits = (((last + 1074) as u64) << 52) + significand as u64;
    f64::from_bits(bits.min(f64::INFINITY.to_bits()) | u64::from(negative) << 63)
}
