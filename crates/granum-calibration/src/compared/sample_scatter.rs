//! Scatter of samples about their material: what the curves of several samples of the same parameters differ by.
//!
//! Samples of the same grains that differ in their seed alone have curves that scatter, and a single one may fit a measured curve by
//! chance. With the curves `y` of n samples at each of several points of the parameters, the covariance of a sample is pooled over the points,
//! `S = sum (y - mean)(y - mean)^T / sum (n - 1)`. The sample of the laboratory is taken as one more, so that the mean of n samples misses it
//! with the covariance `S (1 + 1 / n)`, which also holds what the errors of different quantities of one sample have in common.

use crate::compared::curve::PredictedCurve;

/// The covariance of the curves of a sample about those of its material, of all compared quantities of a test one after another.
#[derive(Clone, Debug, PartialEq)]
pub struct SampleScatter {
    covariance: Vec<f64>,
    count: usize,
}

impl SampleScatter {
    /// From the curves of the samples of each point; `None` if no point has two samples.
    pub fn pooled(points: &[Vec<Vec<f64>>]) -> Option<SampleScatter> {
        let count = points.iter().flatten().map(Vec::len).next()?;
        let degrees: usize = points.iter().map(|samples| samples.len().saturating_sub(1)).sum();
        if degrees == 0 {
            return None;
        }
        let mut covariance = vec![0.0; count * count];
        for samples in points {
            let mean = mean(samples);
            for sample in samples {
                let apart: Vec<f64> = sample.iter().zip(&mean).map(|(y, mean)| y - mean).collect();
                for (i, row) in covariance.chunks_exact_mut(count).enumerate() {
                    for (sum, other) in row.iter_mut().zip(&apart) {
                        *sum += apart[i] * other / degrees as f64;
                    }
                }
            }
        }
        Some(SampleScatter { covariance, count })
    }

    /// The rows and columns of two curves, which begin at these places and have these lengths, times a factor.
    fn block(&self, rows: (usize, usize), columns: (usize, usize), factor: f64) -> Vec<f64> {
        let row =
            |i: usize| &self.covariance[i * self.count + columns.0..i * self.count + columns.0 + columns.1];
        (rows.0..rows.0 + rows.1).flat_map(|i| row(i).iter().map(|value| factor * value)).collect()
    }
}

/// The mean of several samples; empty without one.
fn mean(samples: &[Vec<f64>]) -> Vec<f64> {
    let Some(first) = samples.first() else { return Vec::new() };
    let of_place = |k: usize| samples.iter().map(|sample| sample[k]).sum::<f64>() / samples.len() as f64;
    (0..first.len()).map(of_place).collect()
}

/// Adds the curves of a test, predicted by the mean of samples, to those of the tests before; `lengths` are those of its curves. Without a
/// scatter the prediction has no error.
pub fn push_predicted(
    predicted: &mut Vec<PredictedCurve>,
    samples: &[Vec<f64>],
    lengths: &[usize],
    scatter: Option<&SampleScatter>,
) {
    let (mean, before) = (mean(samples), predicted.len());
    let factor = 1.0 + 1.0 / samples.len() as f64;
    let mut places: Vec<(usize, usize)> = Vec::new();
    let mut start = 0;
    for length in lengths {
        let place = (start, *length);
        let across = |(k, other): (usize, &(usize, usize))| {
            scatter.map(|scatter| (before + k, scatter.block(place, *other, factor)))
        };
        predicted.push(PredictedCurve {
            mean: mean[start..start + length].to_vec(),
            covariance: scatter.map(|scatter| scatter.block(place, place, factor)).unwrap_or_default(),
            across: places.iter().enumerate().filter_map(across).collect(),
        });
        places.push(place);
        start += length;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Golden: two points of two samples each, by hand; a point with one sample tells nothing of the scatter.
    #[test]
    fn scatter_is_pooled_over_points() {
        let points = vec![
            vec![vec![1.0, 10.0, 5.0], vec![3.0, 14.0, 5.0]],
            vec![vec![0.0, 0.0, 1.0], vec![0.0, 2.0, 3.0]],
            vec![vec![100.0, 0.0, 0.0]],
        ];
        let scatter = SampleScatter::pooled(&points).unwrap();
        assert_eq!(scatter.covariance, [1.0, 2.0, 0.0, 2.0, 5.0, 1.0, 0.0, 1.0, 1.0]);
        let mut predicted = vec![PredictedCurve::default()];
        push_predicted(&mut predicted, &points[0], &[1, 2], Some(&scatter));
        assert_eq!((&predicted[1].mean, &predicted[1].covariance), (&vec![2.0], &vec![1.5]));
        assert_eq!(predicted[2].mean, [12.0, 5.0]);
        assert_eq!(predicted[2].covariance, [7.5, 1.5, 1.5, 1.5]);
        assert_eq!(predicted[2].across, [(1, vec![3.0, 0.0])]);
        assert_eq!(SampleScatter::pooled(&points[2..]), None);
        assert_eq!(SampleScatter::pooled(&[]), None);
    }

    #[test]
    fn without_a_scatter_a_prediction_has_no_error() {
        let mut predicted = Vec::new();
        push_predicted(&mut predicted, &[vec![1.0, 2.0]], &[1, 1], None);
        assert!(predicted.iter().all(|curve| curve.covariance.is_empty() && curve.across.is_empty()));
    }
}
