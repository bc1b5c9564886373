//! Which values a quantity can have: no share of contacts is negative, and none is larger than one.

use super::prediction::Prediction;

/// Numbers of contacts per grain, and other columns that are not negative.
const NOT_NEGATIVE: [&str; 10] = [
    "coordination_number",
    "mechanical_coordination_number",
    "compressive_coordination_number",
    "backbone_coordination_number",
    "contacts",
    "inertial_number",
    "unbalanced_force",
    "largest_overlap",
    "arc_length",
    "kinetic_mean_stress",
];
/// Shares.
const SHARES: [&str; 8] = [
    "strong_fraction",
    "tensile_fraction",
    "rattler_fraction",
    "solid_fraction",
    "sliding_fraction",
    "strong_sliding_fraction",
    "principal_deviator_fabric",
    "rolling_fraction",
];
/// The column of a histogram's bin, before its centre.
const DENSITY: &str = "probability_density_";
/// Components of the fabric tensor that are means of squares of directions.
const FABRIC: [&str; 3] = ["fabric_11", "fabric_22", "fabric_33"];

/// The range of the values that a column can have: shares are from 0 to 1, densities and numbers of contacts not negative, the second moment of forces over their
/// mean is at least 1. What is not known, and what has a sign (stresses, strains, and the deviator of fabric, which is that of an axis), is from minus infinity to infinity.
///
/// ```
/// use granum_learn::surrogate::possible_values;
///
/// assert_eq!(possible_values("sliding_fraction"), [0.0, 1.0]);
/// assert_eq!(possible_values("probability_density_0.125"), [0.0, f64::INFINITY]);
/// assert_eq!(possible_values("deviator_fabric"), [f64::NEG_INFINITY, f64::INFINITY]);
/// ```
pub fn possible_values(column: &str) -> [f64; 2] {
    if SHARES.contains(&column) || FABRIC.contains(&column) {
        return [0.0, 1.0];
    }
    let is_density = column.split_once(DENSITY).is_some_and(|(_, centre)| centre.parse::<f64>().is_ok());
    if is_density || NOT_NEGATIVE.contains(&column) {
        return [0.0, f64::INFINITY];
    }
    if column == "mean_square_force" {
        return [1.0, f64::INFINITY];
    }
    [f64::NEG_INFINITY, f64::INFINITY]
}

/// Cuts the intervals of predictions to the values that their outputs can have.
pub(crate) fn cut_to_possible(
    predictions: Vec<Prediction>,
    possible: impl Fn(usize) -> [f64; 2],
) -> Vec<Prediction> {
    let outputs = predictions.first().map_or(0, |prediction| prediction.values.len());
    let possible: Vec<[f64; 2]> = (0..outputs).map(possible).collect();
    let cut = |prediction: Prediction| {
        let values = prediction.values.into_iter().zip(&possible).map(|(own, possible)| own.cut(*possible));
        Prediction { values: values.collect(), ..prediction }
    };
    predictions.into_iter().map(cut).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn components_of_fabric_are_shares_only_on_the_diagonal() {
        let plain = [f64::NEG_INFINITY, f64::INFINITY];
        assert_eq!((possible_values("fabric_33"), possible_values("fabric_23")), ([0.0, 1.0], plain));
        assert_eq!(possible_values("contact_area_probability_density_0.05"), [0.0, f64::INFINITY]);
        assert_eq!(possible_values("probability_density_of_something"), plain);
    }
}
