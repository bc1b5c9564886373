//! Principal components of curves: the directions in which they differ most, with each point weighted by the part of the coordinate
//! that it stands for.

use crate::regression::cholesky::Cholesky;
use crate::regression::independent::{independent_rotation, projected};
use granum_nets::eigenvectors;

/// Components with less than this share of the variance are left out.
const LEAST_SHARE: f64 = 1e-7;

/// The mean of curves and their components.
pub(super) struct Components {
    pub mean: Vec<f64>,
    /// Each with a value at each point.
    pub components: Vec<Vec<f64>>,
    /// The weights of the curves, for each component.
    pub weights: Vec<Vec<f64>>,
    /// Variance of the curves at each point that the components do not contain.
    pub rest: Vec<f64>,
}

impl Components {
    /// The components of curves, at most `most`.
    pub fn new(curves: &[Vec<f64>], shares: &[f64], most: usize) -> Components {
        let (count, points) = (curves.len() as f64, shares.len());
        let mean: Vec<f64> =
            (0..points).map(|k| curves.iter().map(|curve| curve[k]).sum::<f64>() / count).collect();
        let roots: Vec<f64> = shares.iter().map(|share| share.sqrt()).collect();
        let scaled: Vec<Vec<f64>> = curves
            .iter()
            .map(|curve| (0..points).map(|k| (curve[k] - mean[k]) * roots[k]).collect())
            .collect();
        let directions = directions(&scaled, most.min(curves.len().saturating_sub(1)), LEAST_SHARE);
        let weight = |direction: &Vec<f64>, curve: &Vec<f64>| -> f64 {
            direction.iter().zip(curve).map(|(a, b)| a * b).sum()
        };
        let weights: Vec<Vec<f64>> = directions
            .iter()
            .map(|direction| scaled.iter().map(|curve| weight(direction, curve)).collect())
            .collect();
        let components: Vec<Vec<f64>> =
            directions.iter().map(|d| d.iter().zip(&roots).map(|(d, root)| d / root).collect()).collect();
        let left = |i: usize, k: usize| {
            let sum: f64 =
                components.iter().zip(&weights).map(|(component, weights)| weights[i] * component[k]).sum();
            curves[i][k] - mean[k] - sum
        };
        let rest = (0..points).map(|k| (0..curves.len()).map(|i| left(i, k).powi(2)).sum::<f64>() / count);
        Components { rest: rest.collect(), mean, components, weights }
    }

    /// The weights of other curves, for each component: those with which the components are nearest to a curve.
    pub fn weights_of(&self, curves: &[Vec<f64>], shares: &[f64]) -> Option<Vec<Vec<f64>>> {
        let product = |a: &[f64], b: &dyn Fn(usize) -> f64| -> f64 {
            a.iter().zip(shares).enumerate().map(|(k, (a, share))| a * share * b(k)).sum()
        };
        let each = self.components.iter();
        let products: Vec<f64> =
            each.flat_map(|a| self.components.iter().map(|b| product(a, &|k| b[k]))).collect();
        let factor = Cholesky::new(self.components.len(), &products)?;
        let of_curve = |curve: &Vec<f64>| -> Vec<f64> {
            let each = self.components.iter();
            factor.solve(&each.map(|a| product(a, &|k| curve[k] - self.mean[k])).collect::<Vec<f64>>())
        };
        let of_curves: Vec<Vec<f64>> = curves.iter().map(of_curve).collect();
        let of_component = |j: usize| of_curves.iter().map(|weights| weights[j]).collect();
        Some((0..self.components.len()).map(of_component).collect())
    }

    /// The same curves with components in the same directions, turned until their weights are independent of each other.
    pub fn independent(self) -> Components {
        let deviation = |weights: &Vec<f64>| {
            (weights.iter().map(|w| w * w).sum::<f64>() / weights.len().max(1) as f64).sqrt()
        };
        let deviations: Vec<f64> = self.weights.iter().map(deviation).collect();
        let scaled: Vec<Vec<f64>> = self
            .weights
            .iter()
            .zip(&deviations)
            .map(|(weights, deviation)| weights.iter().map(|weight| weight / deviation).collect())
            .collect();
        let shapes: Vec<Vec<f64>> = self
            .components
            .iter()
            .zip(&deviations)
            .map(|(component, deviation)| component.iter().map(|value| value * deviation).collect())
            .collect();
        let rotation = independent_rotation(&scaled);
        let turned = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
            rotation.chunks(columns.len().max(1)).map(|direction| projected(columns, direction)).collect()
        };
        Components { components: turned(&shapes), weights: turned(&scaled), ..self }
    }
}

/// The orthogonal directions of length one in which vectors differ most from zero, at most `most`, each with at least the given share of
/// their mean square.
pub(super) fn directions(vectors: &[Vec<f64>], most: usize, least_share: f64) -> Vec<Vec<f64>> {
    let size = vectors.first().map_or(0, Vec::len);
    let mut matrix = vec![0.0; size * size];
    for i in 0..size {
        for j in 0..=i {
            let sum = vectors.iter().map(|vector| vector[i] * vector[j]).sum::<f64>() / vectors.len() as f64;
            (matrix[i * size + j], matrix[j * size + i]) = (sum, sum);
        }
    }
    let total: f64 = (0..size).map(|k| matrix[k * size + k]).sum();
    let (values, found) = eigenvectors(matrix, size);
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|a, b| values[*b].total_cmp(&values[*a]));
    order.retain(|k| values[*k] > least_share * total);
    order.truncate(most);
    order.into_iter().map(|k| (0..size).map(|i| found[i * size + k]).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Curves that consist of two shapes have two components, which give them back.
    #[test]
    fn curves_of_two_shapes_are_given_back_by_two_components() {
        let shape = |a: f64, b: f64| -> Vec<f64> {
            (0..9).map(f64::from).map(|x| 1.0 + a * x + b * (x - 4.0) * (x - 4.0)).collect()
        };
        let curves = [shape(0.1, 0.2), shape(-0.3, 0.1), shape(0.5, -0.2), shape(0.0, 0.4), shape(0.2, 0.0)];
        let shares = [0.05, 0.1, 0.1, 0.15, 0.2, 0.15, 0.1, 0.1, 0.05];
        let found = Components::new(&curves, &shares, 8);
        assert_eq!(found.components.len(), 2);
        assert!(found.rest.iter().all(|rest| *rest < 1e-24), "{:?}", found.rest);
        for (i, curve) in curves.iter().enumerate() {
            let back = |k: usize| {
                found.mean[k] + (0..2).map(|j| found.weights[j][i] * found.components[j][k]).sum::<f64>()
            };
            assert!((0..9).all(|k| (back(k) - curve[k]).abs() < 1e-12));
        }
        // Turned ones give them back as well.
        let turned = Components::new(&curves, &shares, 8).independent();
        assert_ne!(turned.weights, found.weights);
        for (i, curve) in curves.iter().enumerate() {
            let back = |k: usize| {
                turned.mean[k] + (0..2).map(|j| turned.weights[j][i] * turned.components[j][k]).sum::<f64>()
            };
            assert!((0..9).all(|k| (back(k) - curve[k]).abs() < 1e-9));
        }
        for found in [&turned, &Components::new(&curves, &shares, 8)] {
            let again = found.weights_of(&curves, &shares).unwrap();
            let each = again.iter().flatten().zip(found.weights.iter().flatten());
            assert!(each.into_iter().all(|(a, b)| (a - b).abs() < 1e-9), "{again:?} {:?}", found.weights);
        }
        // With one component the rest is what it lacks.
        let one = Components::new(&curves, &shares, 1);
        assert!(one.rest.iter().sum::<f64>() > 1e-6);
        assert!(Components::new(&[vec![1.0; 9], vec![1.0; 9]], &shares, 8).components.is_empty());
    }
}
