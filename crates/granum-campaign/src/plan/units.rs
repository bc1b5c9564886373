//! The units of the keys of a case.

use granum_core::quantity::{Dimension, parse_quantity};

/// The dimensions that keys usually have.
const USUAL: [Dimension; 13] = [
    Dimension::NUMBER,
    Dimension::STRESS,
    Dimension::LENGTH,
    Dimension::MASS,
    Dimension::TIME,
    Dimension::RATE,
    Dimension::VELOCITY,
    Dimension::FORCE,
    Dimension::STRESS_RATE,
    Dimension::DENSITY,
    Dimension::ENERGY,
    Dimension::SURFACE_ENERGY,
    Dimension::ANGLE,
];
/// Largest power of a base unit in the search for a dimension.
const LARGEST_POWER: i8 = 4;

/// All dimensions that are tried, the usual ones first.
fn dimensions() -> impl Iterator<Item = Dimension> {
    let powers = -LARGEST_POWER..=LARGEST_POWER;
    let others = powers.clone().flat_map(move |mass| {
        let powers = powers.clone();
        powers.clone().flat_map(move |length| {
            powers.clone().map(move |time| Dimension::of_powers([mass, length, time]))
        })
    });
    USUAL.into_iter().chain(others)
}

/// The dimension of a unit.
fn of_unit(unit: &str) -> Option<Dimension> {
    let one = format!("1 {unit}");
    dimensions().find(|dimension| parse_quantity(&one, *dimension).is_ok())
}

/// A quantity in SI units for a key with this SI unit.
///
/// # Errors
/// A sentence that says what is wrong.
pub(super) fn quantity(text: &str, unit: &str) -> Result<f64, String> {
    parse_quantity(text, of_unit(unit).unwrap_or(Dimension::NUMBER))
}

/// A quantity of any dimension in SI units.
pub(super) fn any_quantity(text: &str) -> Option<f64> {
    dimensions().find_map(|dimension| parse_quantity(text, dimension).ok())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_are_read_by_the_unit_of_their_key() {
        assert_eq!(quantity("50 kPa", "Pa"), Ok(5e4));
        assert_eq!(quantity("0.5", ""), Ok(0.5));
        assert!(quantity("50 kPa", "").unwrap_err().contains("is a stress"));
        // Every field of a case has a unit that is found again.
        for field in granum_io::Case::default().fields().iter() {
            assert!(of_unit(&field.si_unit()).is_some(), "{}", field.path());
        }
    }
}
