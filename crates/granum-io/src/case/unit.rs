//! The dimensions of units.

use granum_core::quantity::Dimension;

/// The dimension for the unit of a parameter or measure.
pub(super) fn dimension(unit: &str) -> Dimension {
    match unit {
        "Pa" => Dimension::STRESS,
        "Pa/s" => Dimension::STRESS_RATE,
        "s" => Dimension::TIME,
        "1/s" => Dimension::RATE,
        _ => Dimension::NUMBER,
    }
}
