//! Elementary functions for the constants that laws prepare once for a pair. They consist of sums, products, quotients and square
//! roots only, so that every machine computes the same bits. (Functions that are used in every step are in `granum_simd`.)

use granum_simd::Real;

/// `arctan x`, exact to a few units in the last place.
pub fn arctan(x: f64) -> f64 {
    arctan_of(x)
}

/// The same for one number or for lanes.
#[inline(always)]
pub fn arctan_of<R: Real>(x: R) -> R {
    let one = R::splat(1.0);
    // Halving the angle three times reduces the argument to at most tan(pi/16).
    let mut t = x;
    for _ in 0..3 {
        t = t / (one + (one + t * t).sqrt());
    }
    let square = t * t;
    let mut sum = R::zero();
    for k in (0..16).rev() {
        let term = R::splat(1.0 / f64::from(2 * k + 1));
        sum = term - square * sum;
    }
    R::splat(8.0) * t * sum
}

/// `cos x` for an angle from 0 to pi, rad.
pub fn cosine(x: f64) -> f64 {
    // 1 - 2 sin^2(x/2), and the sine by its series.
    let half = 0.5 * x;
    let square = half * half;
    let mut sum = 1.0;
    for k in (1..14).rev() {
        let k = f64::from(k);
        sum = 1.0 - square / (2.0 * k * (2.0 * k + 1.0)) * sum;
    }
    let sine = half * sum;
    1.0 - 2.0 * sine * sine
}

/// The angle from 0 to pi, rad, of a cosine.
pub fn arc_cosine(cosine: f64) -> f64 {
    if cosine <= -1.0 {
        return std::f64::consts::PI;
    }
    2.0 * arctan(((1.0 - cosine).max(0.0) / (1.0 + cosine)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_are_those_of_the_standard_library() {
        for k in 0..=2000 {
            let x = f64::from(k) * 0.01;
            for x in [x, -x] {
                assert!((arctan(x) - x.atan()).abs() < 1e-15, "arctan {x}: {} {}", arctan(x), x.atan());
            }
            let angle = f64::from(k) * std::f64::consts::PI / 2000.0;
            assert!((cosine(angle) - angle.cos()).abs() < 1e-15, "cos {angle}");
            assert!((arc_cosine(angle.cos()) - angle).abs() < 1e-7, "arccos of cos {angle}");
        }
        assert!((arctan(1e100) - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
        assert_eq!([arctan(0.0), cosine(0.0), arc_cosine(1.0)], [0.0, 1.0, 0.0]);
    }
}
