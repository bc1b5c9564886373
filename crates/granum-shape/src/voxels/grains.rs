//! The grains of a stack, each of them a body of voxels.

use std::path::Path;

use super::stack::LabelledStack;
use crate::cover::grid::Grid;
use crate::mesh::fault;
use crate::shape_error::ShapeError;

/// A grain of fewer voxels is left out: its shape is that of its voxels.
const FEWEST: usize = 50;

/// What is known of a label.
struct Label {
    label: u32,
    count: usize,
    low: [usize; 3],
    high: [usize; 3],
}

/// The grains of a stack in the order of their labels, with the spacings of voxels along x, y and z. Grains that touch the border of the stack, which may
/// continue beyond it, and those of few voxels are left out, as the notices tell.
///
/// # Errors
/// The key `file`: without a grain that can be used, or if a label has several separate parts.
pub(crate) fn grains(
    stack: &LabelledStack,
    step: [f64; 3],
    path: &Path,
    notices: &mut Vec<String>,
) -> Result<Vec<(u32, Grid)>, ShapeError> {
    let all = labels(stack);
    if all.is_empty() {
        return Err(fault(path, "has no labels: all voxels are 0, the background"));
    }
    let at_border = |l: &Label| (0..3).any(|a| l.low[a] == 0 || l.high[a] + 1 == stack.size[a]);
    let (cut, whole): (Vec<&Label>, Vec<&Label>) = all.iter().partition(|l| at_border(l));
    let (small, used): (Vec<&Label>, Vec<&Label>) = whole.into_iter().partition(|l| l.count < FEWEST);
    let mut left_out = |which: &[&Label], why: &str| {
        if !which.is_empty() {
            let names: Vec<String> = which.iter().take(10).map(|l| l.label.to_string()).collect();
            let more = if which.len() > 10 { ", ..." } else { "" };
            let message =
                format!("{} labels are left out, which {why}: {}{more}", which.len(), names.join(", "));
            notices.push(format!("{:?}: {message}", path.display().to_string()));
        }
    };
    left_out(&cut, "touch the border of the stack");
    left_out(&small, &format!("have fewer than {FEWEST} voxels"));
    if used.is_empty() {
        let largest = all.iter().map(|l| l.count).max().unwrap_or(0);
        let message = format!(
            "has no grain that can be used: of {} labels {} touch the border of the stack and {} have fewer than {FEWEST} voxels (the largest has \
             {largest})",
            all.len(),
            cut.len(),
            small.len()
        );
        return Err(fault(path, message));
    }
    used.into_iter().map(|label| Ok((label.label, grain(stack, label, step, path)?))).collect()
}

/// The voxels of a label, with a rim of empty ones.
fn grain(stack: &LabelledStack, label: &Label, step: [f64; 3], path: &Path) -> Result<Grid, ShapeError> {
    let size: [usize; 3] = std::array::from_fn(|a| label.high[a] - label.low[a] + 3);
    let first = std::array::from_fn(|a| step[a] * (label.low[a] as f64 - 1.0));
    let mut inside = vec![false; size.iter().product()];
    for z in 1..size[2] - 1 {
        for y in 1..size[1] - 1 {
            let [x0, y0, z0] = [label.low[0], label.low[1] + y - 1, label.low[2] + z - 1];
            let from = x0 + stack.size[0] * (y0 + stack.size[1] * z0);
            let row = size[0] * (y + size[1] * z);
            for x in 1..size[0] - 1 {
                inside[row + x] = stack.labels[from + x - 1] == label.label;
            }
        }
    }
    let grid = Grid { size, step, first, inside };
    let parts = parts(&grid);
    if parts > 1 {
        let message = format!(
            "has the label {} in {parts} separate parts; each grain needs a label of its own (label the connected parts of the image, and \
             remove specks)",
            label.label
        );
        return Err(fault(path, message));
    }
    Ok(grid)
}

/// The labels but the background in rising order.
fn labels(stack: &LabelledStack) -> Vec<Label> {
    let [nx, ny, _] = stack.size;
    let mut known: std::collections::BTreeMap<u32, Label> = std::collections::BTreeMap::new();
    if nx == 0 {
        return Vec::new();
    }
    for (row, labels) in stack.labels.chunks_exact(nx).enumerate() {
        let mut x = 0;
        // Voxels of one label that follow each other in a row are counted at once.
        for run in labels.chunk_by(|a, b| a == b) {
            let (low, high) = ([x, row % ny, row / ny], [x + run.len() - 1, row % ny, row / ny]);
            x += run.len();
            if run[0] == 0 {
                continue;
            }
            let label = known.entry(run[0]).or_insert(Label { label: run[0], count: 0, low, high });
            label.count += run.len();
            label.low = std::array::from_fn(|a| label.low[a].min(low[a]));
            label.high = std::array::from_fn(|a| label.high[a].max(high[a]));
        }
    }
    known.into_values().collect()
}

/// Number of connected parts of a body; voxels that share a corner are connected.
fn parts(grid: &Grid) -> usize {
    let [nx, ny, _] = grid.size;
    let mut open = grid.inside.clone();
    let mut count = 0;
    let mut edge = Vec::new();
    for start in 0..open.len() {
        if !open[start] {
            continue;
        }
        count += 1;
        open[start] = false;
        edge.push(start);
        while let Some(k) = edge.pop() {
            // The rim is empty, so that all neighbours exist.
            for d in 0..27 {
                let near = k + d % 3 + nx * (d / 3 % 3 + ny * (d / 9)) - (1 + nx * (1 + ny));
                if open[near] {
                    open[near] = false;
                    edge.push(near);
                }
            }
        }
    }
    count
}
