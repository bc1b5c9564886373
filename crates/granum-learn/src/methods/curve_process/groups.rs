//! What the processes see of the inputs: dimensionless groups where physics gives them, and numbers of order one.
//!
//! - A stress and Young's modulus are their ratio, since the stiffness of a sample of elastic grains depends on it alone.
//! - The friction with which a sample was made is its ratio to the friction of the material, and so is the rolling friction.
//! - A coefficient of friction is its logarithm or, if it comes close to zero, its square root: its effect is largest where there is
//!   little of it. So is an aspect ratio, less that of a sphere. Any other positive group that varies by more than a factor of ten is its
//!   logarithm, if the runs are spread more evenly so.
//! - Everything is shifted and scaled to a mean of zero and a standard deviation of one over the training runs.

use serde::{Deserialize, Serialize};

use crate::curve::{is_logarithmic, range};
use crate::onnx::{OnnxGraph, Value};

/// Ratio beyond which a coefficient of friction comes close to zero.
const CLOSE_TO_ZERO: f64 = 50.0;
/// The end of the names of coefficients of friction.
const FRICTION: &str = "friction";
/// The end of the names of aspect ratios, and that of a sphere.
const ASPECT_RATIO: (&str, f64) = ("aspect_ratio", 1.0);
/// The beginning of the names of the inputs that are divided by another, and that other.
const RATIOS: [(&str, &str); 2] = [
    ("preparation.friction", "grains.material.friction"),
    ("preparation.rolling_friction", "contact.rolling_friction"),
];
/// The modulus by which stresses are divided.
const MODULUS: &str = "grains.material.youngs_modulus";
const STRESS_UNIT: &str = "Pa";

/// How the values of a group are spread.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum Spread {
    Linear,
    SquareRoot,
    Logarithmic,
}

impl Spread {
    /// That of a value whose effect is largest where there is little of it.
    fn of_small_amounts(values: &[f64]) -> Spread {
        match range(values.iter().copied()) {
            [least, most] if least > 0.0 && most < CLOSE_TO_ZERO * least => Spread::Logarithmic,
            [least, _] if least >= 0.0 => Spread::SquareRoot,
            _ => Spread::Linear,
        }
    }

    fn from_values(values: &[f64]) -> Spread {
        if is_logarithmic(values) { Spread::Logarithmic } else { Spread::Linear }
    }
}

/// A group: an input, its ratio to another one or what it is above a number, spread and scaled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in crate::methods) struct Group {
    input: usize,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    over: Option<usize>,
    /// What is subtracted. Surrogates of before have none, and keep their bits.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    above: Option<f64>,
    spread: Spread,
    mean: f64,
    deviation: f64,
}

impl Group {
    fn raw(&self, inputs: &[f64]) -> f64 {
        let value = match self.over {
            // Without any friction there is no ratio, and none of it matters.
            Some(other) if inputs[other] == 0.0 => 0.0,
            Some(other) => inputs[self.input] / inputs[other],
            None => inputs[self.input] - self.above.unwrap_or_default(),
        };
        match self.spread {
            Spread::Linear => value,
            Spread::SquareRoot => value.max(0.0).sqrt(),
            Spread::Logarithmic => libm::log(value.max(f64::MIN_POSITIVE)),
        }
    }

    /// The values in a graph, for a table of the inputs of runs: a column.
    pub fn onnx(&self, graph: &mut OnnxGraph, inputs: &Value) -> Value {
        let own = graph.columns(inputs, &[self.input]);
        let value = match self.over {
            Some(other) => {
                let [zero, one] = [0.0, 1.0].map(|value| graph.number(value));
                let other = graph.columns(inputs, &[other]);
                let is_nothing = graph.apply("Equal", &[&other, &zero]);
                let divisor = graph.apply("Where", &[&is_nothing, &one, &other]);
                let ratio = graph.apply("Div", &[&own, &divisor]);
                graph.apply("Where", &[&is_nothing, &zero, &ratio])
            }
            None => match self.above {
                Some(above) => {
                    let above = graph.number(above);
                    graph.apply("Sub", &[&own, &above])
                }
                None => own,
            },
        };
        let spread = match self.spread {
            Spread::Linear => value,
            Spread::SquareRoot => {
                let zero = graph.number(0.0);
                let value = graph.apply("Max", &[&value, &zero]);
                graph.apply("Sqrt", &[&value])
            }
            Spread::Logarithmic => {
                let least = graph.number(f64::MIN_POSITIVE);
                let value = graph.apply("Max", &[&value, &least]);
                graph.apply("Log", &[&value])
            }
        };
        graph.scaled(&spread, &[self.mean], &[1.0 / self.deviation], &[0.0])
    }

    /// The number of its input.
    pub fn input(&self) -> usize {
        self.input
    }

    /// The value for the inputs of a run.
    pub fn value(&self, inputs: &[f64]) -> f64 {
        (self.raw(inputs) - self.mean) / self.deviation
    }

    /// True if it can be that of so many inputs.
    pub fn is_sound(&self, inputs: usize) -> bool {
        self.input < inputs
            && self.over.is_none_or(|other| other < inputs)
            && self.above.is_none_or(f64::is_finite)
            && self.mean.is_finite()
            && self.deviation > 0.0
            && self.deviation.is_finite()
    }
}

/// The groups of inputs, given by name and unit, that vary over the training runs.
pub(in crate::methods) fn groups_of(names: &[String], units: &[String], runs: &[&[f64]]) -> Vec<Group> {
    let place = |name: &str| names.iter().position(|known| known == name);
    let modulus = place(MODULUS);
    let has_stress = units.iter().enumerate().any(|(k, unit)| unit == STRESS_UNIT && Some(k) != modulus);
    let over = |k: usize| match RATIOS.iter().find(|(name, _)| *name == names[k]) {
        Some((_, other)) => place(other),
        None if units[k] == STRESS_UNIT && Some(k) != modulus => modulus,
        None => None,
    };
    let group = |input: usize| {
        let above = names[input].ends_with(ASPECT_RATIO.0).then_some(ASPECT_RATIO.1);
        let plain =
            Group { input, over: over(input), above, spread: Spread::Linear, mean: 0.0, deviation: 1.0 };
        let values = |group: &Group| -> Vec<f64> { runs.iter().map(|run| group.raw(run)).collect() };
        let all = values(&plain);
        let spread = match plain.over {
            None if names[input].ends_with(FRICTION) || above.is_some() => Spread::of_small_amounts(&all),
            _ => Spread::from_values(&all),
        };
        let spread = Group { spread, ..plain };
        let all = values(&spread);
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let deviation = (all.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / all.len() as f64).sqrt();
        (deviation > 1e-12 * (1.0 + mean.abs())).then_some(Group { mean, deviation, ..spread })
    };
    (0..names.len()).filter(|k| !(has_stress && Some(*k) == modulus)).filter_map(group).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_those_of_physics() {
        let names = ["grains.material.friction", MODULUS, "preparation.mean_stress", "preparation.friction"];
        let names: Vec<String> = [&names[..], &["grains.spread", "sample.void_ratio"]]
            .concat()
            .iter()
            .map(|n| n.to_string())
            .collect();
        let units: Vec<String> = ["", "Pa", "Pa", "", "", ""].map(String::from).to_vec();
        let runs = [
            [0.1, 2e9, 20e3, 0.05, 0.0, 0.6],
            [0.8, 2e9, 800e3, 0.4, 0.4, 0.7],
            [0.4, 2e10, 800e3, 0.1, 0.2, 0.6],
        ];
        let runs: Vec<&[f64]> = runs.iter().map(|run| &run[..]).collect();
        let groups = groups_of(&names, &units, &runs);
        // Friction, stress over stiffness, ratio of the frictions, spread, void ratio; the modulus itself has no effect.
        assert_eq!(groups.iter().map(|group| group.input).collect::<Vec<_>>(), [0, 2, 3, 4, 5]);
        let spreads: Vec<Spread> = groups.iter().map(|group| group.spread).collect();
        let (root, linear, log) = (Spread::SquareRoot, Spread::Linear, Spread::Logarithmic);
        assert_eq!(spreads, [log, log, linear, linear, linear]);
        assert_eq!(Spread::of_small_amounts(&[0.001, 0.2, 0.5]), root);
        // The same ratio of stress and stiffness is the same number.
        let at = |stress: f64, modulus: f64| groups[1].value(&[0.4, modulus, stress, 0.1, 0.2, 0.6]);
        assert!((at(1e5, 1e9) - at(2e5, 2e9)).abs() < 1e-12);
        assert_eq!(
            groups[2].value(&[0.1, 2e9, 1e5, 0.05, 0.0, 0.6]),
            groups[2].value(&[0.8, 2e9, 1e5, 0.4, 0.0, 0.6])
        );
        // An input that is the same in all runs is left out.
        let same: Vec<&[f64]> = vec![runs[0]; 3];
        assert!(groups_of(&names, &units, &same).is_empty());
    }
    /// What matters of an aspect ratio is how far it is from that of a sphere.
    #[test]
    fn an_aspect_ratio_counts_from_that_of_a_sphere() {
        let names = ["grains.shape.aspect_ratio".to_string()];
        let group = |ratios: [f64; 3]| {
            let runs = ratios.map(|ratio| [ratio]);
            let runs: Vec<&[f64]> = runs.iter().map(|run| &run[..]).collect();
            groups_of(&names, &[String::new()], &runs).remove(0)
        };
        let long = group([1.05, 1.5, 2.4]);
        assert_eq!(long.spread, Spread::Logarithmic);
        // From 1.1 to 1.2 as far as from 1.4 to 1.8: twice the excess.
        let step = |from: f64, to: f64| long.value(&[to]) - long.value(&[from]);
        assert!((step(1.1, 1.2) - step(1.4, 1.8)).abs() < 1e-12);
        // With spheres among them no logarithm is taken, and a sphere has a value.
        let with_spheres = group([1.0, 1.5, 2.4]);
        assert_eq!(with_spheres.spread, Spread::SquareRoot);
        assert!(with_spheres.value(&[1.0]).is_finite());
    }
}
