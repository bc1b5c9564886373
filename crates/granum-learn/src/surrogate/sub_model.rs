//! A sub-model: the range of the coordinate in which a network predicts, and its size.

use serde::{Deserialize, Serialize};

/// The network for a range of the coordinate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SubModel {
    /// The range; its end belongs to the next sub-model, if there is one.
    pub range: [f64; 2],
    /// Numbers of neurons of the hidden layers.
    pub hidden: Vec<usize>,
    /// Number of epochs, for a trainer without a stopping rule of its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub epochs: Option<u64>,
}

impl SubModel {
    /// A sub-model with hidden layers of the given sizes.
    pub fn new(range: [f64; 2], hidden: impl Into<Vec<usize>>) -> SubModel {
        SubModel { range, hidden: hidden.into(), epochs: None }
    }

    /// Sub-models from `start` to `end` that meet at the given values of the coordinate, with hidden layers of the same sizes.
    ///
    /// ```
    /// use granum_learn::networks::{SubModel, sub_model_at};
    ///
    /// let three = SubModel::divided([0.0, 0.3], &[0.05, 0.2], &[10, 10]);
    /// assert_eq!(three[1].range, [0.05, 0.2]);
    /// assert_eq!(sub_model_at(&three, 0.2), (2, true));
    /// ```
    pub fn divided([start, end]: [f64; 2], at: &[f64], hidden: &[usize]) -> Vec<SubModel> {
        let ends: Vec<f64> = std::iter::once(start).chain(at.iter().copied()).chain([end]).collect();
        ends.windows(2).map(|range| SubModel::new([range[0], range[1]], hidden)).collect()
    }
}

/// The number of the sub-model for a value of the coordinate, from 0, and whether its range contains the value; if no range
/// does, it is the nearest sub-model.
pub fn sub_model_at(sub_models: &[SubModel], x: f64) -> (usize, bool) {
    let last = sub_models.len().saturating_sub(1);
    let holds = |k: usize| {
        let [low, high] = sub_models[k].range;
        x >= low && (x < high || (k == last && x <= high))
    };
    if let Some(k) = (0..sub_models.len()).find(|&k| holds(k)) {
        return (k, true);
    }
    let distance = |k: usize| {
        let [low, high] = sub_models[k].range;
        (low - x).max(x - high)
    };
    let nearest = (0..sub_models.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
    (nearest.unwrap_or(0), false)
}

/// True if a value of the coordinate is in the range of a sub-model, or of the one with the given number, or if there are no
/// sub-models.
pub fn is_within(sub_models: &[SubModel], x: f64, wanted: Option<usize>) -> bool {
    let (found, inside) = sub_model_at(sub_models, x);
    sub_models.is_empty() || (inside && wanted.is_none_or(|wanted| wanted == found))
}
