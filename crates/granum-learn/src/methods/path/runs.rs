//! Whole runs as networks see them.

use granum_nets::{Data, DataError, Sequences};

use super::cell::CellSizes;
use super::channels::Widths;
use super::rotation::Rotation;

/// Whole runs in the units of networks.
#[derive(Clone)]
pub(super) struct PathRuns {
    pub widths: Widths,
    pub increments: Vec<f64>,
    pub starts: Vec<f64>,
    pub targets: Vec<f64>,
    pub lengths: Vec<usize>,
}

impl PathRuns {
    /// Some of the runs.
    pub fn chosen(&self, keep: impl Fn(usize) -> bool) -> PathRuns {
        let (width, starts, outputs) = (self.widths.increment(), self.widths.starts(), self.widths.outputs());
        let (mut increments, mut targets) = (Vec::new(), Vec::new());
        let (mut of_starts, mut lengths) = (Vec::new(), Vec::new());
        let mut row = 0;
        for (run, length) in self.lengths.iter().enumerate() {
            if keep(run) {
                increments.extend(&self.increments[row * width..(row + length) * width]);
                targets.extend(&self.targets[row * outputs..(row + length) * outputs]);
                of_starts.extend(&self.starts[run * starts..(run + 1) * starts]);
                lengths.push(*length);
            }
            row += length;
        }
        PathRuns { widths: self.widths, increments, starts: of_starts, targets, lengths }
    }

    /// The same runs in other axes: the next rotation for each.
    pub fn turned(&self, mut rotation: impl FnMut() -> Rotation) -> PathRuns {
        let Widths { tensors, direction, .. } = self.widths;
        let (width, starts, outputs) = (self.widths.increment(), self.widths.starts(), self.widths.outputs());
        let (mut increments, mut targets) = (self.increments.clone(), self.targets.clone());
        let mut of_starts = self.starts.clone();
        let mut row = 0;
        for (run, length) in self.lengths.iter().enumerate() {
            let rotation = rotation();
            for own in increments[row * width..(row + length) * width].chunks_exact_mut(width) {
                rotation.turn(own, 1, usize::from(direction > 0));
            }
            if !targets.is_empty() {
                for own in targets[row * outputs..(row + length) * outputs].chunks_exact_mut(outputs) {
                    rotation.turn(own, 0, tensors);
                }
            }
            rotation.turn(&mut of_starts[run * starts..(run + 1) * starts], 0, tensors);
            row += length;
        }
        PathRuns {
            widths: self.widths,
            increments,
            starts: of_starts,
            targets,
            lengths: self.lengths.clone(),
        }
    }

    pub fn append(&mut self, others: PathRuns) {
        self.increments.extend(others.increments);
        self.starts.extend(others.starts);
        self.targets.extend(others.targets);
        self.lengths.extend(others.lengths);
    }

    /// The sequences with their start values.
    pub fn sequences(&self) -> std::result::Result<Sequences, DataError> {
        Sequences::new(self.lengths.clone())?.with_starts(self.starts.clone(), self.widths.starts())
    }

    pub fn data(self, sizes: &CellSizes) -> std::result::Result<Data, DataError> {
        let inputs = sizes.inputs(&self.widths, &self.increments, &self.lengths);
        let rows: usize = self.lengths.iter().sum();
        let columns = inputs.len() / rows.max(1);
        let sequences = self.sequences()?;
        Data::with_target_columns(inputs, columns, self.targets, self.widths.outputs())?
            .with_sequences(sequences)
    }
}
