//! What a further run would tell, before it is made: by how much it would reduce the variance of predicted curves.

use granum_nets::gaussian_process::{FurtherRow, GaussianProcess};

use super::fitted::FittedCurves;
use crate::curve::interpolated;
use crate::error::Result;

/// A run that could be made, for [`FittedCurves::reduced_variance`].
pub struct FurtherRun {
    /// For each curve and component.
    rows: Vec<Vec<FurtherRow>>,
}

impl FittedCurves {
    /// A run that could be made, from its inputs beside the coordinate in their order.
    ///
    /// # Errors
    /// If there are other inputs.
    pub fn further_run(&self, inputs: &[f64]) -> Result<FurtherRun> {
        let row = self.row(inputs)?;
        let of_curve = |processes: &Vec<GaussianProcess>| {
            processes.iter().map(|process| process.further(&row)).collect()
        };
        Ok(FurtherRun { rows: self.processes.iter().map(of_curve).collect() })
    }

    /// The part of the variance of [`FittedCurves::correlated_curve`] at each value of the coordinate that more runs would reduce:
    /// `f^2 sum_j s_j^2 v_j(a)^2` with the variances `s_j^2` of the means of the processes alone; for an output that is
    /// learned by its square root times `4 m(a)^2` with the mean m of the root, to first order.
    ///
    /// # Errors
    /// As [`FittedCurves::correlated_curve`].
    pub fn reducible_variance(&self, inputs: &[f64], output: usize, at: &[f64]) -> Result<Vec<f64>> {
        let row = self.row(inputs)?;
        self.along(&row, output, at, |component| self.processes[output][component].predict(&row).variance)
    }

    /// By how much a further run would reduce the [reducible variance](FittedCurves::reducible_variance), whatever it turned out to give.
    ///
    /// # Errors
    /// As [`FittedCurves::correlated_curve`].
    pub fn reduced_variance(
        &self,
        inputs: &[f64],
        output: usize,
        at: &[f64],
        further: &FurtherRun,
    ) -> Result<Vec<f64>> {
        let row = self.row(inputs)?;
        self.along(&row, output, at, |component| {
            let own = further.rows.get(output).and_then(|rows| rows.get(component));
            own.map_or(0.0, |further| self.processes[output][component].reduction(&row, further))
        })
    }

    /// The variance at each value of the coordinate, from that of the weight of each component.
    fn along(
        &self,
        row: &[f64],
        output: usize,
        at: &[f64],
        variance: impl Fn(usize) -> f64,
    ) -> Result<Vec<f64>> {
        let (kept, factor) = self.normal_output(output)?;
        let points = &self.kept.points;
        let (mut sum, mut root) = (vec![0.0; at.len()], Vec::new());
        if kept.root {
            root = at.iter().map(|x| interpolated(*x, points, &kept.mean)).collect();
        }
        for (j, component) in kept.components.iter().enumerate() {
            let own = factor * factor * variance(j);
            for (sum, x) in sum.iter_mut().zip(at) {
                let value = interpolated(*x, points, component);
                *sum += own * value * value;
            }
            let weight = if kept.root { self.processes[output][j].predict(row).mean } else { 0.0 };
            for (root, x) in root.iter_mut().zip(at) {
                *root += weight * interpolated(*x, points, component);
            }
        }
        // To first order the variance of a square is that of its root times the square of the slope.
        sum.iter_mut().zip(&root).for_each(|(sum, root)| *sum *= 4.0 * root * root);
        Ok(sum)
    }
}
