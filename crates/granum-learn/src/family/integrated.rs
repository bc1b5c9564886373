//! Answers where properties of the grains are not known: the mean over what they can be.
//!
//! Points fill the ranges of the unknown properties evenly (those of logarithms where the runs are spread more evenly so), by a scrambled Sobol
//! sequence. At each of them, what else is not known is drawn from the values that are typical there. A point counts by the probability that its
//! sands have of what is given beside: a dense sample is rarely one of high friction. With the normal distributions of the points, of weights `w_k`
//! and distribution functions `F_k`, the mean is `sum w_k m_k`, and the ends of an interval are the quantiles of `sum w_k F_k`.

use granum_nets::normal::{quantile, share_below};

use super::model::FamilyModel;
use super::prediction::{FamilyCurve, FamilyPrediction, InputSource, Plain, UsedInput};
use super::typical::TypicalValue;
use crate::curve::is_logarithmic;
use crate::error::Result;

/// Points of the ranges.
const NODES: u32 = 64;
/// Seed of the sequence.
const SEED: u32 = 1;
/// Halvings in which a quantile is found: to a millionth of the widest interval.
const HALVINGS: usize = 22;
/// Values are drawn between the quantiles of this share and of one less this share.
const LEAST_SHARE: f64 = 0.01;
/// Share of the weight beyond which what is said of points is said of the answer.
const MOST: f64 = 0.5;

/// A point of the ranges: the values of all inputs, and its weight.
struct Node {
    values: Vec<f64>,
    weight: f64,
}

impl FamilyModel {
    /// The answer where a property of the grains is not given.
    pub(super) fn integrated(&self, given: &[Option<f64>], level: f64) -> Result<FamilyPrediction> {
        let nodes = self.nodes(given);
        let plain: Vec<Plain> =
            nodes.iter().map(|node| self.plain(&node.values, level)).collect::<Result<_>>()?;
        let columns = &self.surrogate.columns().outputs;
        let points = self.points()?.to_vec();
        let mixture = |output: usize, point: usize| Mixture {
            parts: nodes
                .iter()
                .zip(&plain)
                .map(|(node, plain)| {
                    let [mean, lower, upper] = &plain.curves[output];
                    Part { weight: node.weight, mean: mean[point], lower: lower[point], upper: upper[point] }
                })
                .collect(),
            level,
        };
        let curve = |output: usize| {
            let mixtures: Vec<Mixture> = (0..points.len()).map(|point| mixture(output, point)).collect();
            FamilyCurve {
                column: columns[output].name.clone(),
                mean: mixtures.iter().map(Mixture::mean).collect(),
                lower: mixtures.iter().map(|mixture| mixture.quantile(0.5 * (1.0 - level))).collect(),
                upper: mixtures.iter().map(|mixture| mixture.quantile(0.5 * (1.0 + level))).collect(),
                from_inputs: mixtures.iter().map(Mixture::variance_of_means).collect(),
            }
        };
        let ranges = self.ranges();
        let input = |(k, about): (usize, &super::FamilyInput)| {
            let mean: f64 = nodes.iter().map(|node| node.weight * node.values[k]).sum();
            let square: f64 = nodes.iter().map(|node| node.weight * (node.values[k] - mean).powi(2)).sum();
            let source = match given[k] {
                Some(_) => InputSource::Given,
                None if about.is_required => InputSource::Integrated(ranges[k]),
                None => InputSource::Typical(TypicalValue { mean, deviation: square.sqrt() }),
            };
            UsedInput { name: about.name.into(), value: given[k].unwrap_or(mean), source }
        };
        let inputs: Vec<UsedInput> = self.definition.inputs.iter().enumerate().map(input).collect();
        let values: Vec<f64> = inputs.iter().map(|input| input.value).collect();
        let unseen = nodes.iter().zip(&plain).filter(|(_, plain)| plain.combination.is_some());
        let is_unseen = unseen.clone().map(|(node, _)| node.weight).sum::<f64>() > MOST;
        let combination = unseen.map(|(_, plain)| plain.combination.clone()).next().flatten();
        Ok(FamilyPrediction {
            outside: self.outside(&values),
            combination: combination.filter(|_| is_unseen),
            inputs,
            curves: (0..columns.len()).map(curve).collect(),
            points,
            level,
        })
    }

    /// The points, whose weights have the sum 1.
    fn nodes(&self, given: &[Option<f64>]) -> Vec<Node> {
        let ranges = self.ranges();
        // A range whose limit is zero has no logarithm there, however the runs are spread.
        let logarithmic: Vec<bool> = (0..given.len())
            .map(|input| ranges[input][0] > 0.0 && is_logarithmic(&self.values_of(input)))
            .collect();
        let inputs = self.definition.inputs;
        let node = |number: u32| {
            let share = |input: usize| f64::from(sobol_burley::sample(number, input as u32, SEED));
            let mut values: Vec<f64> = given.iter().map(|value| value.unwrap_or(f64::NAN)).collect();
            let mut values_so_far: Vec<(usize, f64)> = Vec::new();
            for input in (0..given.len()).filter(|k| inputs[*k].is_required) {
                let [low, high] = ranges[input];
                values[input] = given[input].unwrap_or_else(|| match logarithmic[input] {
                    true => low * libm::exp(share(input) * libm::log(high / low)),
                    false => low + share(input) * (high - low),
                });
                values_so_far.push((input, values[input]));
            }
            // What is given of the sample has a density at each point.
            let mut weight = 1.0;
            for input in (0..given.len()).filter(|k| !inputs[*k].is_required) {
                let Some(value) = given[input] else { continue };
                let typical = self.typical.value(&self.rows, input, &values_so_far);
                if typical.deviation > 0.0 {
                    // One that lies outside of the runs is as far from all of them.
                    let [low, high] = ranges[input];
                    let apart = (value.clamp(low, high) - typical.mean.clamp(low, high)) / typical.deviation;
                    weight *= libm::exp(-0.5 * apart * apart) / typical.deviation;
                }
                values_so_far.push((input, value));
            }
            for input in (0..given.len()).filter(|k| !inputs[*k].is_required && given[*k].is_none()) {
                let [low, high] = ranges[input];
                let typical = self.typical.value(&self.rows, input, &values_so_far);
                let share = share(input).clamp(LEAST_SHARE, 1.0 - LEAST_SHARE);
                let drawn = typical.mean + typical.deviation * quantile(share);
                values[input] = drawn.clamp(low, high);
                values_so_far.push((input, values[input]));
            }
            Node { values, weight }
        };
        let mut nodes: Vec<Node> = (0..NODES).map(node).collect();
        let sum: f64 = nodes.iter().map(|node| node.weight).sum();
        // Where the given sample fits no point, all are as good.
        let even = 1.0 / f64::from(NODES);
        nodes.iter_mut().for_each(|node| node.weight = if sum > 0.0 { node.weight / sum } else { even });
        nodes
    }
}

/// What a point predicts.
struct Part {
    weight: f64,
    mean: f64,
    lower: f64,
    upper: f64,
}

/// The predictions of all points together.
struct Mixture {
    parts: Vec<Part>,
    level: f64,
}

impl Mixture {
    fn mean(&self) -> f64 {
        self.parts.iter().map(|part| part.weight * part.mean).sum()
    }

    fn variance_of_means(&self) -> f64 {
        let mean = self.mean();
        self.parts.iter().map(|part| part.weight * (part.mean - mean).powi(2)).sum()
    }

    /// The share of the predictions below a value.
    fn below(&self, value: f64, quantile: f64) -> f64 {
        let of_part = |part: &Part| {
            let apart = value - part.mean;
            let half = if apart < 0.0 { part.mean - part.lower } else { part.upper - part.mean };
            if half <= 0.0 {
                return part.weight * f64::from(u8::from(apart >= 0.0));
            }
            part.weight * share_below(quantile * apart / half)
        };
        self.parts.iter().map(of_part).sum()
    }

    /// The value below which a share of the predictions lies.
    fn quantile(&self, share: f64) -> f64 {
        let end = |part: &Part| if share < 0.5 { part.lower } else { part.upper };
        let mut low = self.parts.iter().map(end).fold(f64::INFINITY, f64::min);
        let mut high = self.parts.iter().map(end).fold(f64::NEG_INFINITY, f64::max);
        if !(low.is_finite() && high.is_finite()) {
            return f64::NAN;
        }
        let quantile = quantile(0.5 * (1.0 + self.level));
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.below(middle, quantile) < share { low = middle } else { high = middle }
        }
        0.5 * (low + high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Golden: two distributions far apart have their outer ends, and half of the weight between them; one alone has its own.
    #[test]
    fn quantiles_are_those_of_the_mixture() {
        let part = |weight: f64, mean: f64| Part { weight, mean, lower: mean - 1.0, upper: mean + 1.0 };
        let alone = Mixture { parts: vec![part(1.0, 3.0)], level: 0.9 };
        assert!((alone.quantile(0.05) - 2.0).abs() < 1e-6 && (alone.quantile(0.95) - 4.0).abs() < 1e-6);
        let two = Mixture { parts: vec![part(0.5, 0.0), part(0.5, 100.0)], level: 0.9 };
        assert_eq!((two.mean(), two.variance_of_means()), (50.0, 2500.0));
        // A tenth of the lower distribution lies below its quantile of 10 %: 1.2816 / 1.6449 of the half width.
        assert!((two.quantile(0.05) + 1.281_552 / 1.644_854).abs() < 1e-4, "{}", two.quantile(0.05));
        assert!((two.quantile(0.95) - 100.0 - 1.281_552 / 1.644_854).abs() < 1e-4);
    }

    /// The interval of one distribution alone is its own at every level, also far out.
    #[test]
    fn one_distribution_keeps_its_interval_at_every_level() {
        for level in [0.5, 0.9, 0.99, 0.9999] {
            // A second one of next to no weight is wider, so that the ends are looked for.
            let parts = [(1.0, 1.0), (1e-12, 10.0)].map(|(weight, half)| Part {
                weight,
                mean: 3.0,
                lower: 3.0 - half,
                upper: 3.0 + half,
            });
            let mixture = Mixture { parts: parts.into(), level };
            let ends = [0.5 * (1.0 - level), 0.5 * (1.0 + level)].map(|share| mixture.quantile(share));
            assert!((ends[0] - 2.0).abs() < 1e-4 && (ends[1] - 4.0).abs() < 1e-4, "{level}: {ends:?}");
        }
    }
}
