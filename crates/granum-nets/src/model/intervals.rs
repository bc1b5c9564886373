//! The errors for new blocks of observations (runs of other samples), estimated by leaving out each training block in turn.
//!
//! The Laplace approximation treats the training rows as independent. Rows of one run share the deviation of that run from
//! other runs, so that the standard deviations hold for further rows of the same runs, but not for a new run. The difference
//! is estimated from the errors `e_k` that each run would have if it had not been used for training: over the training
//! observations of a segment
//!
//! ```text
//! c^2 = sum of e_k^2 / sum of s_k^2
//! ```
//!
//! where `s_k` are the standard deviations of the Laplace approximation, and `c s(x)` is the standard deviation for a new
//! run.

use serde::{Deserialize, Serialize};

use crate::table::data::Data;

/// Number of segments, which have nearly equal numbers of observations.
const SEGMENTS: usize = 3;

/// Factors on the standard deviations of the Laplace approximation, as a function of one input.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Intervals {
    /// Number of blocks that were left out one by one.
    pub blocks: usize,
    /// Degrees of freedom of the factors: the number of independent errors from which each is estimated.
    pub degrees_of_freedom: f64,
    /// The input on which the factors depend; `None` for a single factor.
    pub input: Option<String>,
    /// Values of that input, in increasing order.
    pub at: Vec<f64>,
    /// The factor at each of these values; linear between them and constant beyond.
    pub factors: Vec<f64>,
}

impl Intervals {
    /// Estimates the factors from the errors of left-out blocks and the standard deviations of the Laplace approximation,
    /// one per observation; `None` if they do not give valid factors.
    pub(crate) fn new(data: &Data, names: &[&str], errors: &[f64], deviations: &[f64]) -> Option<Intervals> {
        let width = data.input_columns() * data.points();
        let place = |k: usize| data.spread_column.map_or(0.0, |column| data.inputs()[k * width + column]);
        let usable = |k: &usize| errors[*k].is_finite() && deviations[*k].is_finite() && deviations[*k] > 0.0;
        let mut order: Vec<usize> = (0..errors.len()).filter(usable).collect();
        order.sort_by(|a, b| place(*a).total_cmp(&place(*b)));
        let (mut at, mut factors) = (Vec::new(), Vec::new());
        for group in groups(&order, place) {
            let count = group.len() as f64;
            let squares = |values: &[f64]| group.iter().map(|&k| values[k] * values[k]).sum::<f64>();
            let factor = (squares(errors) / squares(deviations)).sqrt();
            if !(factor > 0.0 && factor.is_finite()) {
                return None;
            }
            at.push(group.iter().map(|&k| place(k)).sum::<f64>() / count);
            factors.push(factor);
        }
        // The mean of all blocks is estimated from the same data, which removes the degrees of freedom of one block.
        let blocks = data.block_count();
        let independent = data.observations() * (1.0 - 1.0 / blocks.max(2) as f64);
        let intervals = Intervals {
            blocks,
            degrees_of_freedom: (independent / factors.len() as f64).max(1.0),
            input: data.spread_column.map(|column| names[column].to_string()),
            at,
            factors,
        };
        intervals.check(names).is_ok().then_some(intervals)
    }

    /// The factor at a value of the input.
    pub fn factor(&self, place: f64) -> f64 {
        let after = self.at.partition_point(|at| *at <= place);
        if after == 0 || after == self.at.len() {
            return self.factors[after.saturating_sub(1)];
        }
        let share = (place - self.at[after - 1]) / (self.at[after] - self.at[after - 1]);
        self.factors[after - 1] + share * (self.factors[after] - self.factors[after - 1])
    }

    /// Refuses invalid factors for a model with these inputs.
    pub(crate) fn check(&self, names: &[&str]) -> Result<(), String> {
        let rising = self.at.windows(2).all(|pair| pair[0] < pair[1]);
        let finite = self.at.iter().all(|at| at.is_finite());
        let positive = |value: &f64| *value > 0.0 && value.is_finite();
        let known = self.input.as_ref().is_none_or(|input| names.contains(&input.as_str()));
        let shape = !self.at.is_empty() && self.at.len() == self.factors.len();
        let factors = self.factors.iter().all(positive) && positive(&self.degrees_of_freedom);
        if rising && finite && known && shape && factors {
            return Ok(());
        }
        Err("the intervals need increasing values of an input of the model, as many positive factors, and positive \
             degrees of freedom"
            .into())
    }
}

/// Groups of observations in the order of the input: one group for each value, or segments if there are too many values.
fn groups(order: &[usize], place: impl Fn(usize) -> f64) -> Vec<Vec<usize>> {
    let values: Vec<Vec<usize>> =
        order.chunk_by(|&a, &b| place(a) == place(b)).map(<[usize]>::to_vec).collect();
    // Few values with many observations each are the bins of a distribution, which all states have in common, in contrast to
    // strains, at which there is only one observation in each run.
    if values.len() * values.len() <= order.len() {
        return values;
    }
    let mut segments = vec![Vec::new(); SEGMENTS];
    let mut before = 0;
    for value in values {
        // Observations with equal values stay in one segment, so that the values of the segments increase strictly.
        let segment = before * SEGMENTS / order.len();
        before += value.len();
        segments[segment].extend(value);
    }
    segments.retain(|segment| !segment.is_empty());
    segments
}

#[cfg(test)]
mod tests {
    use granum_simd::Isa;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::{Rng, SeedableRng};

    use super::*;
    use crate::trainer::{LevenbergMarquardt, NoObserver};
    use crate::{Model, ModelColumn, ModelDefinition};

    fn table(points: usize) -> Data {
        // There are two bins, each with the errors of four observations.
        let inputs = (0..8 * points).flat_map(|k| [0.1 * (k / points) as f64, ((k / points) % 2) as f64]);
        let data =
            Data::new(inputs.collect(), 2, vec![0.0; 8 * points]).unwrap().with_points(points).unwrap();
        data.with_blocks(vec![0, 0, 0, 0, 7, 7, 7, 7]).unwrap().with_spread_column(1).unwrap()
    }

    #[test]
    fn factors_are_the_left_out_errors_over_the_deviations() {
        for points in [1, 3] {
            let errors = [0.2, 3.0, -0.2, -3.0, 0.2, 3.0, 0.2, -3.0];
            let found = Intervals::new(&table(points), &["strain", "force"], &errors, &[0.1; 8]).unwrap();
            assert_eq!((found.blocks, found.input.as_deref()), (2, Some("force")));
            assert_eq!(found.at, [0.0, 1.0]);
            assert!((found.factors[0] - 2.0).abs() < 1e-12 && (found.factors[1] - 30.0).abs() < 1e-12);
            assert_eq!(found.degrees_of_freedom, 2.0);
            for (place, factor) in [(-1.0, 2.0), (0.0, 2.0), (0.5, 16.0), (1.0, 30.0), (9.0, 30.0)] {
                assert!((found.factor(place) - factor).abs() < 1e-12, "{place}");
            }
        }
        let data = Data::new(vec![0.0; 16], 2, vec![0.0; 8]).unwrap();
        assert!(data.clone().with_blocks(vec![0; 7]).is_err() && data.clone().with_spread_column(2).is_err());
        assert_eq!(data.block_count(), 0);
        assert_eq!(Intervals::new(&table(1), &["strain", "force"], &[0.0; 8], &[0.1; 8]), None);
    }

    #[test]
    fn strains_are_put_into_stretches() {
        let strains: Vec<f64> = (0..60).map(|k| (k % 30) as f64).collect();
        let data = Data::new(strains, 1, vec![0.0; 60]).unwrap();
        let blocks = (0..60).map(|k| k / 30).collect();
        let data = data.with_blocks(blocks).unwrap().with_spread_column(0).unwrap();
        let found = Intervals::new(&data, &["strain"], &[1.0; 60], &[1.0; 60]).unwrap();
        assert_eq!((found.at, found.factors), (vec![4.5, 14.5, 24.5], vec![1.0; 3]));
        assert_eq!(found.degrees_of_freedom, 10.0);
    }

    #[test]
    fn damaged_tables_are_refused() {
        let good = Intervals {
            blocks: 2,
            degrees_of_freedom: 3.0,
            input: Some("x".into()),
            at: vec![0.0, 1.0],
            factors: vec![1.0, 2.0],
        };
        assert!(good.check(&["x"]).is_ok() && good.check(&["y"]).is_err());
        for broken in [
            Intervals { at: vec![1.0, 1.0], ..good.clone() },
            Intervals { at: vec![], factors: vec![], ..good.clone() },
            Intervals { factors: vec![1.0], ..good.clone() },
            Intervals { factors: vec![1.0, 0.0], ..good.clone() },
            Intervals { degrees_of_freedom: f64::NAN, ..good.clone() },
        ] {
            assert!(broken.check(&["x"]).is_err(), "{broken:?}");
        }
    }

    /// Runs along a common curve, each with its own offset in each third of the range.
    fn runs(seed: u64, count: usize) -> Data {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal =
            || -> f64 { (0..12).map(|_| random.next_u32() as f64 / f64::from(u32::MAX)).sum::<f64>() - 6.0 };
        let (mut x, mut y, mut blocks) = (Vec::new(), Vec::new(), Vec::new());
        for run in 0..count {
            for segment in 0..6 {
                let offset = 0.05 * normal();
                for k in 0..5 {
                    let place = (segment * 5 + k) as f64 / 30.0;
                    x.push(place);
                    y.push(1.0 - (-4.0 * place).exp() + offset + 0.005 * normal());
                    blocks.push(run);
                }
            }
        }
        let observations = 6.0 * count as f64;
        let data = Data::new(x, 1, y).unwrap().with_observations(observations).unwrap();
        data.with_blocks(blocks).unwrap().with_spread_column(0).unwrap()
    }

    fn fit(data: &Data, isa: Isa) -> Model {
        let definition = ModelDefinition {
            inputs: vec![ModelColumn::new("x", "1")],
            output: ModelColumn::new("y", "1"),
            quantities: Vec::new(),
            shares: Vec::new(),
            hidden: vec![6, 6],
            seed: 3,
        };
        let trainer = LevenbergMarquardt { isa, ..LevenbergMarquardt::default() };
        Model::fit(&definition, data, &trainer, &mut NoObserver).unwrap().0
    }

    #[test]
    fn intervals_hold_nine_tenths_of_new_runs_where_runs_scatter() {
        let (mut held, mut all, mut narrow) = (0, 0, 0);
        for seed in 0..12 {
            let model = fit(&runs(seed, 4), Isa::detect());
            assert_eq!(model.blocks(), Some(4));
            let unseen = runs(1000 + seed, 40);
            let values = model.predict_batch(unseen.inputs()).unwrap().values;
            let deviations = model.standard_deviations(unseen.inputs()).unwrap().unwrap();
            let quantile = model.quantile(0.9);
            for (k, target) in unseen.targets().iter().enumerate() {
                all += 1;
                held += usize::from((values[k] - target).abs() <= quantile * deviations[k]);
                narrow += usize::from((values[k] - target).abs() <= 1.2 * deviations[k]);
            }
        }
        let share = held as f64 / all as f64;
        assert!((0.85..0.95).contains(&share), "{share}");
        assert!((narrow as f64) < 0.85 * all as f64, "no wider than needed");
    }

    #[test]
    fn one_run_says_nothing_of_the_scatter_between_runs() {
        let model = fit(&runs(1, 1), Isa::detect());
        assert_eq!((model.blocks(), model.training_fit().intervals.clone()), (None, None));
        assert!((model.quantile(0.9) - 1.645).abs() < 2e-3);
        assert!(!model.is_constant());
    }

    #[test]
    fn files_keep_the_intervals_and_every_instruction_set_gives_the_same() {
        let data = runs(2, 3);
        let reference = fit(&data, Isa::Portable);
        let text = reference.to_json();
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            assert_eq!(fit(&data, isa).to_json(), text, "{}", isa.name());
        }
        let loaded = Model::from_json(&text, "model").unwrap();
        assert_eq!(loaded.training_fit(), reference.training_fit());
        let asked = [0.1, 0.5, 1.2];
        assert_eq!(
            loaded.standard_deviations(&asked).unwrap(),
            reference.standard_deviations(&asked).unwrap()
        );
        assert!(text.contains("\"degrees_of_freedom\"") && text.contains("\"version\": 3"));
    }

    #[test]
    fn a_constant_is_called_one() {
        let data = Data::new((0..20).map(f64::from).collect(), 1, vec![2.0; 20]).unwrap();
        let model = fit(&data, Isa::detect());
        assert!(model.is_constant());
    }
}
