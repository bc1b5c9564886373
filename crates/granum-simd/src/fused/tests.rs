//! The exact routine and its integers against the instruction of the processor, and against what is known of single cases.

use proptest::prelude::*;

use super::exact::by_integers;
use super::*;

/// The ways to compute that this machine has.
type Way = fn(f64, f64, f64) -> f64;

fn instruction(factor: f64, other: f64, term: f64) -> Option<f64> {
    #[cfg(target_arch = "x86_64")]
    if is_x86_feature_detected!("fma") {
        // SAFETY: the processor has just been found to have the instruction.
        return Some(unsafe { hardware(factor, other, term) });
    }
    #[cfg(target_arch = "aarch64")]
    return Some(hardware(factor, other, term));
    #[cfg(not(target_arch = "aarch64"))]
    None
}

const WAYS: [(&str, Way); 3] = [("dispatch", mul_add), ("exact", exact), ("integers", by_integers)];

/// Every way gives the bits of the instruction; without one they give the bits of each other. NaN are equal.
fn check(a: f64, b: f64, c: f64) {
    let expected = instruction(a, b, c).unwrap_or_else(|| by_integers(a, b, c));
    for (name, way) in WAYS {
        let value = way(a, b, c);
        let same = value.to_bits() == expected.to_bits() || (value.is_nan() && expected.is_nan());
        assert!(same, "{name}: {a:e} * {b:e} + {c:e} = {value:e}, not {expected:e}");
    }
}

/// splitmix64 (Steele, Lea and Flood 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// A whole number from `-spread` to `spread`.
    fn whole(&mut self, spread: i32) -> i32 {
        (self.next() % (2 * spread as u64 + 1)) as i32 - spread
    }

    /// Any sign and fraction, with a binary exponent from `-spread` to `spread`.
    fn number(&mut self, spread: i32) -> f64 {
        let exponent = (self.whole(spread) + 1023) as u64;
        f64::from_bits((self.next() & 0x800f_ffff_ffff_ffff) | (exponent << 52))
    }

    /// The same with few significant bits, so that products are exact or end in ties.
    fn short(&mut self, spread: i32) -> f64 {
        let bits = self.next() % 53;
        f64::from_bits(self.number(spread).to_bits() & !((1 << (52 - bits)) - 1))
    }

    /// Some places of the last bit away.
    fn beside(&mut self, value: f64) -> f64 {
        f64::from_bits(value.to_bits().wrapping_add_signed(i64::from(self.whole(4))))
    }
}

const ROUNDS: u32 = 60_000;

#[test]
fn numbers_of_all_sizes() {
    let mut random = Random(1);
    for _ in 0..ROUNDS {
        check(random.number(30), random.number(30), random.number(60));
        check(random.number(500), random.number(500), random.number(1000));
        check(random.short(20), random.short(20), random.short(60));
        check(f64::from_bits(random.next()), f64::from_bits(random.next()), f64::from_bits(random.next()));
    }
}

/// The term takes away all of the product but what its rounding lost, or a few places more.
#[test]
fn sums_that_cancel() {
    let mut random = Random(2);
    for spread in [1, 100, 480, 511] {
        for _ in 0..ROUNDS {
            let (a, b) = (random.number(spread), random.number(spread));
            check(a, b, -(a * b));
            let term = random.beside(-(a * b));
            check(a, b, term);
        }
    }
}

/// The product is near half of the last place of the term, and the other way round, or exactly there.
#[test]
fn results_near_ties() {
    let mut random = Random(3);
    for _ in 0..ROUNDS {
        let term = random.number(5);
        let half = (term - f64::from_bits(term.to_bits() ^ 1)).abs() * 0.5;
        let a = random.number(3);
        let b = f64::from(random.whole(5)) * half / a;
        check(a, random.beside(b), term);
        // An exact tie, and one that a tail far below decides.
        let (a, b) = (random.short(1), random.short(1) * 2f64.powi(-53 + random.whole(3)));
        check(a, b, random.short(2));
        let (a, b) = (random.number(1), random.number(1));
        let tail = a * b * 2f64.powi(-53 - random.whole(40).abs()) * f64::from(random.whole(4));
        check(a, b, tail);
        check(a, b, -(a * b) * (1.0 + f64::from(random.whole(4)) * 2f64.powi(-53 - random.whole(20).abs())));
    }
}

/// Results among the subnormal numbers and at their edges, below the smallest, and beyond the largest.
#[test]
fn underflow_and_overflow() {
    let mut random = Random(4);
    let tiny = |random: &mut Random| f64::from_bits(random.next() >> (12 + random.next() % 50));
    for _ in 0..ROUNDS {
        let exponent = random.whole(520);
        let scaled =
            |value: f64, exponent: i32| value * 2f64.powi(exponent / 2) * 2f64.powi(exponent - exponent / 2);
        let (a, b) = (random.number(2), random.short(2));
        let term = tiny(&mut random);
        for below in [-1022, -1074, -1050, -1130, -970, -961] {
            let (first, second) = (scaled(a, exponent), scaled(b, below + random.whole(3) - exponent));
            check(first, second, term);
            check(first, second, -term);
            check(first, second, 0.0);
            check(first, second, f64::from_bits(1));
            check(first, second, scaled(random.short(2), -1022 + random.whole(60)));
        }
        for above in [1022, 1023, 1024] {
            let (first, second) = (scaled(a, exponent), scaled(b, above - exponent));
            check(first, second, scaled(random.number(1), 1022));
            let term = random.beside(-(first * second).clamp(f64::MIN, f64::MAX));
            check(first, second, term);
        }
        let (small, smaller) = (tiny(&mut random), tiny(&mut random));
        check(small, random.number(1000), smaller);
        check(small, smaller, random.number(60));
    }
}

#[test]
fn zeros_infinities_and_what_is_no_number() {
    let least = f64::from_bits(1);
    let special = [
        0.0,
        1.0,
        1.5,
        least,
        3.0 * least,
        f64::MIN_POSITIVE,
        f64::EPSILON,
        f64::MAX,
        f64::INFINITY,
        f64::NAN,
    ];
    let signed: Vec<f64> = special.iter().flat_map(|x| [*x, -x]).collect();
    for a in &signed {
        for b in &signed {
            for c in &signed {
                check(*a, *b, *c);
            }
        }
    }
}

/// What is known without another implementation: values on paper, among them those that round twice in extended precision.
#[test]
fn known_results() {
    let (eps, least) = (f64::EPSILON, f64::from_bits(1));
    let cases = [
        (1.0 + eps, 1.0 + eps, -(1.0 + 2.0 * eps), eps * eps),
        // 1 + eps/2 - eps^2/4 is below a tie, and 1 + eps/2 + eps^2/2 is above it; in 64 bits both are ties.
        (0.5 * (1.0 - eps / 2.0), eps, 1.0, 1.0),
        (0.5 * (1.0 + eps), eps, 1.0, 1.0 + eps),
        (0.5, eps, 1.0, 1.0),
        (1.5, eps, 1.0, 1.0 + 2.0 * eps),
        (f64::MAX, 2.0, f64::MIN, f64::MAX),
        (f64::MAX, 2.0, 0.0, f64::INFINITY),
        (0.5, least, 0.0, 0.0),
        (0.5, 3.0 * least, 0.0, 2.0 * least),
        (0.5, least, least, 2.0 * least),
        (-0.5, least, 0.0, -0.0),
        (1e-200, -1e-200, 0.0, -0.0),
        (1e-200, 1e-200, -0.0, 0.0),
        (2.0, 3.0, -6.0, 0.0),
        (-0.0, 1.0, -0.0, -0.0),
        (-0.0, 1.0, 0.0, 0.0),
        (1e300, 1e300, f64::NEG_INFINITY, f64::NEG_INFINITY),
    ];
    for (a, b, c, expected) in cases {
        for (name, way) in WAYS {
            let value = way(a, b, c);
            assert_eq!(value.to_bits(), expected.to_bits(), "{name}: {a:e} * {b:e} + {c:e} = {value:e}");
        }
        check(a, b, c);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(20_000))]

    #[test]
    fn any_bits(a: u64, b: u64, c: u64) {
        check(f64::from_bits(a), f64::from_bits(b), f64::from_bits(c));
    }

    /// Exponents of a product and a term that are close to each other, and significands with long rows of zeros and ones.
    #[test]
    fn rows_of_equal_bits(
        significands in prop::array::uniform3(0u64..1 << 52),
        widths in prop::array::uniform3(0u32..53),
        ones in prop::array::uniform3(any::<bool>()),
        exponents in (-500i32..500, -500i32..500, -120i32..120),
        negative: bool,
    ) {
        let [a, b, c] = std::array::from_fn(|k| {
            let low = (1u64 << widths[k]) - 1;
            f64::from_bits(1023 << 52 | if ones[k] { significands[k] | low } else { significands[k] & !low })
        });
        let (first, second) = (a * 2f64.powi(exponents.0), b * 2f64.powi(exponents.1));
        let place = (exponents.0 + exponents.1 + exponents.2).clamp(-1000, 1000);
        let term = c * 2f64.powi(place);
        check(first, second, if negative { -term } else { term });
    }
}
