//! How far the numbers of a file are rounded.

use granum_core::assembly::Vector;

/// Digits of the numbers of a text file that says no more, as those of LAMMPS by default.
const FEWEST_DIGITS: usize = 6;
/// Digits by which a number of 64 bits is known to its last bit.
const MOST_DIGITS: usize = 17;
/// Digits of a number of 32 bits.
const SINGLE_PRECISION: usize = 7;
/// So many numbers say how many digits all have.
const SAMPLE: usize = 1000;

/// Largest error of the distance of two of these places, m, by the rounding of their numbers, of which the number of digits is seen.
pub(super) fn of_places(places: impl Iterator<Item = Vector> + Clone) -> f64 {
    let largest = places.clone().flatten().fold(0.0f64, |largest, x| largest.max(x.abs()));
    let numbers: Vec<f64> = places.flatten().filter(|x| *x != 0.0).take(SAMPLE).collect();
    let digits = if numbers.iter().all(|x| f64::from(*x as f32) == *x) {
        SINGLE_PRECISION
    } else {
        let has = |digits: usize| numbers.iter().all(|x| with_digits(*x, digits) == *x);
        (FEWEST_DIGITS..MOST_DIGITS).find(|digits| has(*digits)).unwrap_or(MOST_DIGITS)
    };
    // Half a unit of the last digit for each of the three components of both places is 1.7 units at most.
    2.0 * libm::pow(10.0, 1.0 - digits as f64) * largest
}

fn with_digits(value: f64, digits: usize) -> f64 {
    format!("{value:.*e}", digits - 1).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_those_of_the_numbers() {
        let of = |x: f64| of_places([[x, 1.0, 2.0], [10.0, 0.0, -3.0]].into_iter());
        assert!((of(1.23457) - 2e-4).abs() < 1e-16);
        assert!((of(1.234_567_8) - 2e-6).abs() < 1e-18);
        assert!((of(f64::from(1.234_567_8f32)) - 2e-5).abs() < 1e-17);
        assert!(of(1.0 / 3.0) < 3e-14);
    }
}
