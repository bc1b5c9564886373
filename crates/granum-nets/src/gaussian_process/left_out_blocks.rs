//! Rows as predicted without a whole block of rows, with unchanged parameters.
//!
//! With the inverse `G = A^-1` of the covariance of all targets `y`, the rows of a block B have, given all other rows, the mean and covariance
//!
//! ```text
//! y_B - (G_BB)^-1 (G y)_B,      (G_BB)^-1
//! ```
//!
//! (Rasmussen and Williams 2006, section 5.4.2, for blocks), so that no process is fitted again.

use granum_simd::{Isa, LANES, Row8};

use super::evidence::Factorised;
use super::process::{GaussianProcess, ProcessPrediction};
use crate::linear_algebra::symmetric::{Cholesky, Symmetric};

/// A process from which blocks of rows are left out in turn.
#[derive(Clone, Debug)]
pub struct LeftOutBlocks<'a> {
    process: &'a GaussianProcess,
    /// Row-major.
    inverse: Vec<f64>,
    count: usize,
}

impl GaussianProcess {
    /// Prepares blocks of rows to be left out.
    pub fn left_out_blocks(&self) -> LeftOutBlocks<'_> {
        LeftOutBlocks { process: self, inverse: self.inverse(), count: self.targets() }
    }
}

impl LeftOutBlocks<'_> {
    /// The rows of a block, given by their numbers, as predicted from all others; `targets` are those of all rows. `None` if the block has a
    /// row twice or one that does not exist, or what remains cannot be inverted.
    pub fn without(&self, targets: &[f64], block: &[usize]) -> Option<Vec<ProcessPrediction>> {
        let mut distinct = block.to_vec();
        distinct.sort_unstable();
        distinct.dedup();
        let exist = distinct.len() == block.len() && block.iter().all(|row| *row < self.count);
        if targets.len() != self.count || !exist {
            return None;
        }
        let (isa, size) = (Isa::detect(), block.len());
        let mut matrix = Symmetric::new(size);
        for k in 0..matrix.blocks * LANES {
            for s in k..matrix.blocks * LANES {
                let value = match (block.get(k), block.get(s)) {
                    (Some(row), Some(column)) => self.inverse[row * self.count + column],
                    _ => f64::from(u8::from(k == s)),
                };
                matrix.values[k * matrix.stride + s / LANES].0[s % LANES] = value;
            }
        }
        let mut factor = Cholesky::new(isa, size);
        if !factor.factorise(&matrix, 0.0) {
            return None;
        }
        let (solved, deviation) = self.process.solved();
        let mut shift = vec![Row8::default(); matrix.blocks];
        for (k, row) in block.iter().enumerate() {
            shift[k / LANES].0[k % LANES] = solved[*row];
        }
        factor.solve(&mut shift);
        let variances = Factorised::diagonal(&factor.inverse(), size);
        let noise = self.process.noise();
        let of_row = |((row, shift), variance): ((&usize, &f64), &f64)| ProcessPrediction {
            mean: targets[*row] - deviation * shift,
            variance: (deviation * deviation * variance - noise).max(0.0),
            noise,
        };
        Some(block.iter().zip(Row8::numbers(&shift)).zip(&variances).map(of_row).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::process::FitOptions;
    use super::super::rows::Rows;
    use super::*;

    fn process() -> (Vec<f64>, Vec<f64>, GaussianProcess) {
        let x: Vec<f64> = (0..40).map(|k| f64::from(k * 17 % 40) / 10.0 - 2.0).collect();
        let y: Vec<f64> =
            x.iter().enumerate().map(|(k, x)| x.sin() + 0.05 * (k as f64 * 2.3).cos()).collect();
        let rows = Rows::new(x.clone(), 1).unwrap();
        let process = GaussianProcess::fit(rows.into(), &y, &FitOptions::default()).unwrap();
        (x, y, process)
    }

    #[test]
    fn a_block_of_one_row_is_that_row_left_out() {
        let (_, y, process) = process();
        let (blocks, single) = (process.left_out_blocks(), process.left_out(&y));
        for row in [0, 7, 39] {
            let found = blocks.without(&y, &[row]).unwrap()[0];
            assert!((found.mean - single[row].mean).abs() < 1e-9, "{found:?} {:?}", single[row]);
            let same = process.predictions_left_out(&y)[row];
            assert!((same.mean, same.noise) == (single[row].mean, found.noise), "{found:?} {same:?}");
            assert!((same.variance - found.variance).abs() < 1e-9 * single[row].variance);
            let variance = found.variance + found.noise;
            assert!((variance - single[row].variance).abs() < 1e-9 * single[row].variance);
        }
    }

    #[test]
    fn a_block_is_what_a_process_of_the_other_rows_predicts() {
        let (x, y, process) = process();
        let (block, others): (Vec<usize>, Vec<usize>) = (0..x.len()).partition(|row| x[*row] > 0.9);
        let rows = Rows::new(others.iter().map(|row| x[*row]).collect(), 1).unwrap();
        // Targets are scaled by their own mean and deviation; these are those of all of them.
        let known: Vec<f64> = others.iter().map(|row| y[*row]).collect();
        let found = process.left_out_blocks().without(&y, &block).unwrap();
        let alone =
            GaussianProcess::with_scale(rows.into(), &known, process.parameters().to_vec(), process.scale())
                .unwrap();
        for (row, found) in block.iter().zip(&found) {
            let predicted = alone.predict(&[x[*row]]);
            assert!((predicted.mean - found.mean).abs() < 1e-6, "{predicted:?} {found:?}");
            assert_eq!(predicted.noise, found.noise);
            assert!(
                (predicted.variance - found.variance).abs() < 1e-5 * found.noise,
                "{predicted:?} {found:?}"
            );
        }
        assert!(block.len() > 8 && found.iter().any(|own| own.variance > 3.0 * process.noise()));
    }

    #[test]
    fn rows_that_do_not_exist_are_refused() {
        let (_, y, process) = process();
        assert!(process.left_out_blocks().without(&y, &[40]).is_none());
        assert!(process.left_out_blocks().without(&y[1..], &[3]).is_none());
        assert!(process.left_out_blocks().without(&y, &[3, 3]).is_none());
    }
}
