//! Elementary functions composed of correctly rounded operations only, so that every machine gives the same bits.

use crate::lanes::Real;

/// Cube root of a number that is zero or positive, relative error below 1e-15.
///
/// Two division-free iterations of fourth order for `x^(-1/3)`, then one multiplication by `x` and the square.
#[inline(always)]
pub fn cbrt<R: Real>(x: R) -> R {
    let mut r = x.reciprocal_cbrt_guess();
    for _ in 0..2 {
        let h = (-(x * r)).mul_add(r * r, R::splat(1.0));
        let series = h.mul_add(R::splat(14.0 / 81.0), R::splat(2.0 / 9.0)).mul_add(h, R::splat(1.0 / 3.0));
        r = (r * h).mul_add(series, r);
    }
    x * (r * r)
}

/// Exponential function, relative error below 3e-16 for |x| < 700; saturates outside.
#[inline(always)]
pub fn exp<R: Real>(x: R) -> R {
    // 1.5 * 2^52: adding and subtracting it rounds to the nearest integer.
    let magic = R::splat(6_755_399_441_055_744.0);
    let x = x.max(R::splat(-708.0)).min(R::splat(709.0));
    let k = x.mul_add(R::splat(std::f64::consts::LOG2_E), magic) - magic;
    let r = k.mul_add(R::splat(-0.693_147_180_369_123_8), x);
    let r = k.mul_add(R::splat(-1.908_214_929_270_587_7e-10), r);
    const COEFFICIENTS: [f64; 12] = [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
    ];
    let mut p = R::splat(COEFFICIENTS[0]);
    for c in &COEFFICIENTS[1..] {
        p = p.mul_add(r, R::splat(*c));
    }
    p.mul_add(r, R::splat(1.0)) * k.exp2_integer()
}

/// A positive number between 2^-255 and 2^255 to the power of an exponent, relative error below 1e-15 times `1 + |exponent ln x|`.
///
/// The logarithm is that of the number itself or of its reciprocal, whichever is below one, scaled by powers of two into
/// `[1/sqrt 2, sqrt 2)`, where `ln m = 2 artanh((m - 1)/(m + 1))` is a short series.
#[inline(always)]
pub fn power<R: Real>(x: R, exponent: R) -> R {
    let one = R::splat(1.0);
    let large = x.gt(one);
    let mut m = R::select(large, one / x, x);
    let mut twos = R::zero();
    // Powers of two with their exponents.
    const STEPS: [[f64; 2]; 8] = [
        [128.0, 340_282_366_920_938_463_463_374_607_431_768_211_456.0],
        [64.0, 18_446_744_073_709_551_616.0],
        [32.0, 4_294_967_296.0],
        [16.0, 65_536.0],
        [8.0, 256.0],
        [4.0, 16.0],
        [2.0, 4.0],
        [1.0, 2.0],
    ];
    for [exponent, factor] in &STEPS {
        let raised = m * R::splat(*factor);
        let small = raised.le(one);
        m = R::select(small, raised, m);
        twos = R::select(small, twos - R::splat(*exponent), twos);
    }
    let low = m.lt(R::splat(std::f64::consts::FRAC_1_SQRT_2));
    m = R::select(low, m + m, m);
    twos = R::select(low, twos - one, twos);
    let s = (m - one) / (m + one);
    let square = s * s;
    let mut series = R::zero();
    for k in (0..11).rev() {
        series = series.mul_add(square, R::splat(2.0 / f64::from(2 * k + 1)));
    }
    let logarithm = twos.mul_add(R::splat(std::f64::consts::LN_2), s * series);
    let signed = R::select(large, -logarithm, logarithm);
    exp(signed * exponent)
}

/// A number to a whole power, by repeated squaring in a fixed order: `f64::powi` leaves the order to the compiler and its library.
///
/// ```
/// assert_eq!(granum_simd::integer_power(2.0, -3), 0.125);
/// ```
pub fn integer_power(x: f64, exponent: i32) -> f64 {
    let (mut power, mut square) = (1.0, x);
    let mut rest = exponent.unsigned_abs();
    while rest > 0 {
        if rest & 1 == 1 {
            power *= square;
        }
        square *= square;
        rest >>= 1;
    }
    if exponent < 0 { 1.0 / power } else { power }
}

/// Hyperbolic tangent as in equation (1) of Antony, Zhou and Wang (2006), absolute error below 5e-16.
///
/// `1 - 2 / (exp(2x) + 1)` with a separate exponential: `2x = k ln 2 + 2t`, and a minimax polynomial of degree ten for
/// `exp(2t)` with a relative error of 3e-16 (Remez exchange, constant term fixed at one), whose effect on the result is
/// halved by the quotient.
#[inline(always)]
pub fn tanh<R: Real>(x: R) -> R {
    let magic = R::splat(6_755_399_441_055_744.0);
    let x = x.max(R::splat(-20.0)).min(R::splat(20.0));
    let k = x.mul_add(R::splat(2.0 * std::f64::consts::LOG2_E), magic) - magic;
    // Half of ln 2 in two parts; the first ends with 21 zero bits, so that its product with k is exact.
    let t = k.mul_add(R::splat(-0.346_573_590_184_561_9), x);
    let t = k.mul_add(R::splat(-9.541_074_646_352_939e-11), t);
    const COEFFICIENTS: [f64; 10] = [
        2.844_607_097_647_676e-4,
        1.415_429_002_154_695e-3,
        6.349_085_687_464_249_6e-3,
        2.539_668_210_847_438_3e-2,
        8.888_889_124_001_523e-2,
        2.666_666_686_676_508e-1,
        6.666_666_666_494_938e-1,
        1.333_333_333_321_923,
        2.000_000_000_000_033_3,
        2.000_000_000_000_018,
    ];
    let mut p = R::splat(COEFFICIENTS[0]);
    for c in &COEFFICIENTS[1..] {
        p = p.mul_add(t, R::splat(*c));
    }
    let e = p.mul_add(t, R::splat(1.0)) * k.exp2_integer();
    R::splat(1.0) - R::splat(2.0) / (e + R::splat(1.0))
}

/// Logistic function `1 / (1 + exp(-x))`, equation (2) of Antony, Zhou and Wang (2006).
#[inline(always)]
pub fn sigmoid<R: Real>(x: R) -> R {
    R::splat(1.0) / (exp(-x) + R::splat(1.0))
}
