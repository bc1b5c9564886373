//! Independent components: the rotation of uncorrelated columns that makes them as far from normal, and so as independent, as possible.
//!
//! FastICA with the contrast `ln cosh` and symmetric orthogonalisation:
//!
//! ```text
//! W <- <tanh(W z) z^T> - diag<1 - tanh^2(W z)> W,   W <- (W W^T)^(-1/2) W
//! ```
//!
//! Source: Hyvarinen, Fast and robust fixed-point algorithms for independent component analysis, IEEE Transactions on Neural Networks 10
//! (1999), 626 to 634.

use granum_nets::eigenvectors;

/// Most steps.
const STEPS: usize = 400;
/// The search ends when no direction turns by more than this.
const TOLERANCE: f64 = 1e-9;

/// The rotation `W`, row-major, by which columns of uncorrelated values with a mean of zero and a mean square of one become independent ones
/// `s = W z`; each of `columns` has the values of one. It depends on the columns alone, to the bit.
pub fn independent_rotation(columns: &[Vec<f64>]) -> Vec<f64> {
    let (size, count) = (columns.len(), columns.first().map_or(0, Vec::len).max(1) as f64);
    let mut rotation = vec![0.0; size * size];
    (0..size).for_each(|k| rotation[k * size + k] = 1.0);
    for _ in 0..STEPS {
        let mut next = vec![0.0; size * size];
        for i in 0..size {
            let along = projected(columns, &rotation[i * size..(i + 1) * size]);
            let bent: Vec<f64> = along.iter().map(|s| libm::tanh(*s)).collect();
            let slope = bent.iter().map(|t| 1.0 - t * t).sum::<f64>() / count;
            for j in 0..size {
                let mean = bent.iter().zip(&columns[j]).map(|(t, z)| t * z).sum::<f64>() / count;
                next[i * size + j] = mean - slope * rotation[i * size + j];
            }
        }
        let next = orthogonal(&next, size);
        // A direction may change its sign from step to step.
        let turned = (0..size).map(|i| {
            let dot: f64 = (0..size).map(|j| next[i * size + j] * rotation[i * size + j]).sum();
            (dot.abs() - 1.0).abs()
        });
        let turned = turned.fold(0.0, f64::max);
        rotation = next;
        if turned < TOLERANCE {
            break;
        }
    }
    rotation
}

/// The values of a direction.
pub fn projected(columns: &[Vec<f64>], direction: &[f64]) -> Vec<f64> {
    let count = columns.first().map_or(0, Vec::len);
    (0..count).map(|k| columns.iter().zip(direction).map(|(column, w)| w * column[k]).sum()).collect()
}

/// `(M M^T)^(-1/2) M`: the orthogonal matrix nearest to M.
fn orthogonal(matrix: &[f64], size: usize) -> Vec<f64> {
    let product = |a: &[f64], b: &dyn Fn(usize, usize) -> f64| -> Vec<f64> {
        let entry = |i: usize, j: usize| (0..size).map(|k| a[i * size + k] * b(k, j)).sum();
        (0..size * size).map(|n| entry(n / size, n % size)).collect()
    };
    let square = product(matrix, &|k, j| matrix[j * size + k]);
    let (values, vectors) = eigenvectors(square, size);
    let scale = values.iter().fold(0.0, |most: f64, value| most.max(*value));
    let root = |i: usize, j: usize| -> f64 {
        let term = |k: usize| {
            vectors[i * size + k] * vectors[j * size + k] / values[k].max(1e-300 + 1e-15 * scale).sqrt()
        };
        (0..size).map(term).sum()
    };
    let root: Vec<f64> = (0..size * size).map(|n| root(n / size, n % size)).collect();
    product(&root, &|k, j| matrix[k * size + j])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two independent sources, a saw tooth and a square wave, are found again after they were mixed by a rotation.
    #[test]
    fn mixed_sources_are_found_again() {
        let count = 400;
        let saw: Vec<f64> = (0..count).map(|k| (f64::from(k % 20) - 9.5) / 33.25f64.sqrt()).collect();
        let wave: Vec<f64> = (0..count).map(|k| if (k / 40) % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let (sine, cosine) = (0.6f64, 0.8f64);
        let mix =
            |a: f64, b: f64| -> Vec<f64> { saw.iter().zip(&wave).map(|(s, w)| a * s + b * w).collect() };
        let columns = [mix(cosine, sine), mix(-sine, cosine)];
        let rotation = independent_rotation(&columns);
        let found: Vec<Vec<f64>> = rotation.chunks(2).map(|row| projected(&columns, row)).collect();
        let alike =
            |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>().abs() / f64::from(count);
        let best = |source: &[f64]| found.iter().map(|own| alike(own, source)).fold(0.0, f64::max);
        assert!(best(&saw) > 0.99 && best(&wave) > 0.99, "{rotation:?}");
        // It is a rotation.
        let dot: f64 = rotation[0] * rotation[2] + rotation[1] * rotation[3];
        assert!(dot.abs() < 1e-9 && (rotation[0].hypot(rotation[1]) - 1.0).abs() < 1e-9);
        assert!(independent_rotation(&[]).is_empty());
    }
}
