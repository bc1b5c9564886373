//! A self-organising map of states: a sheet of cells, each with a typical state, neighbours alike. Every state belongs to the cell that is nearest to
//! it, so that the sheet shows at a glance which states there are, which go together, and what is rare.
//!
//! The map is made in batches: in each step a cell becomes the mean of all states, weighted by how near their cells are on the sheet,
//! `exp(-d^2 / 2 s^2)`, and the width `s` shrinks from half of the sheet to less than a cell. It begins in the plane of the first two principal
//! components, so that the same states give the same map. Columns count alike: they are scaled to a standard deviation of one.
//!
//! Source: Kohonen, Self-Organizing Maps, third edition (2001), sections 3.6 and 3.7.

use granum_core::observer::Observer;
use serde::{Deserialize, Serialize};

use super::turn::Turn;
use crate::dataset::Dataset;
use crate::error::{LearnError, Result};
use crate::study::thinned;
use granum_nets::eigenvectors;

/// Number of steps.
const STEPS: usize = 40;
/// Width of the neighbourhood at the end, in cells.
const LAST_WIDTH: f64 = 0.5;
/// Fewest and most cells along an edge.
const EDGES: [usize; 2] = [2, 100];

/// The sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct MapOptions {
    /// The columns of a state; the name of a histogram stands for all of its bins.
    pub columns: Vec<String>,
    /// Number of cells across and up.
    pub cells: [usize; 2],
    /// Most states from which it is made.
    pub most_states: usize,
}

/// The map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StateMap {
    /// Names and units of the columns.
    pub columns: Vec<(String, String)>,
    /// Number of cells across and up; cells are counted row by row.
    pub cells: [usize; 2],
    /// For each cell the value of each column.
    pub values: Vec<Vec<f64>>,
    /// Number of states that belong to each cell.
    pub states: Vec<usize>,
    /// The mean distance of each cell from its neighbours, in standard deviations of a column: high between groups of states.
    pub distances: Vec<f64>,
    /// Root mean square distance of the states from their cells, over that from the mean of all states.
    pub error: f64,
    /// Share of the states whose second nearest cell is no neighbour of the nearest one: how often the sheet is folded.
    pub folded: f64,
}

impl StateMap {
    /// The map of the states of runs.
    ///
    /// # Errors
    /// If a column does not exist or all columns are constant, the sheet is too small or too large, there are fewer states than cells along an edge,
    /// or the observer stops.
    pub fn new(dataset: &Dataset, options: &MapOptions, observer: &mut dyn Observer) -> Result<StateMap> {
        let [across, up] = options.cells;
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        if [across, up].iter().any(|edge| !(EDGES[0]..=EDGES[1]).contains(edge)) {
            return bad(format!(
                "a map of {across} x {up} cells is not possible; its edges have {} to {} cells",
                EDGES[0], EDGES[1]
            ));
        }
        let dataset = thinned(dataset, options.most_states);
        let names = dataset.expand(&options.columns)?;
        let raw = dataset.values(&names)?;
        let scales: Vec<[f64; 2]> =
            (0..names.len()).map(|k| mean_and_deviation(&raw, k, names.len())).collect();
        let count = dataset.rows();
        if count < across.max(up) || scales.iter().all(|[_, deviation]| *deviation == 0.0) {
            return bad("the states are too few, or all alike".into());
        }
        let scaled = |(k, value): (usize, &f64)| {
            let [mean, deviation] = scales[k % names.len()];
            if deviation > 0.0 { (value - mean) / deviation } else { 0.0 }
        };
        let rows: Vec<f64> = raw.iter().enumerate().map(scaled).collect();
        let mut sheet = Sheet::new(&rows, names.len(), options.cells);
        let mut turn = Turn::new(STEPS, observer);
        for step in 0..STEPS {
            turn.next("map")?;
            let first = 0.5 * across.max(up) as f64;
            let part = step as f64 / (STEPS - 1) as f64;
            sheet.step(&rows, first * libm::pow(LAST_WIDTH / first, part));
        }
        let columns = names.iter().map(|name| Ok((name.clone(), dataset.variable(name)?.unit)));
        let columns = columns.collect::<Result<Vec<_>>>()?;
        let back = |cell: usize| -> Vec<f64> {
            sheet
                .cell(cell)
                .iter()
                .zip(&scales)
                .map(|(value, [mean, deviation])| mean + deviation * value)
                .collect()
        };
        let mut map = StateMap {
            columns,
            cells: options.cells,
            values: (0..across * up).map(back).collect(),
            states: vec![0; across * up],
            distances: (0..across * up).map(|cell| sheet.distance(cell)).collect(),
            error: 0.0,
            folded: 0.0,
        };
        let (mut left, mut folded) = (0.0, 0usize);
        for row in rows.chunks_exact(names.len()) {
            let [(nearest, square), (second, _)] = sheet.nearest(row);
            map.states[nearest] += 1;
            left += square;
            folded += usize::from(sheet.apart(nearest, second) > 2.0);
        }
        let total: f64 = rows.iter().map(|value| value * value).sum();
        map.error = (left / total).sqrt();
        map.folded = folded as f64 / count as f64;
        Ok(map)
    }
}

/// Mean and standard deviation of a column of rows.
fn mean_and_deviation(rows: &[f64], column: usize, columns: usize) -> [f64; 2] {
    let own = || rows.iter().skip(column).step_by(columns);
    let count = (rows.len() / columns).max(1) as f64;
    let mean = own().sum::<f64>() / count;
    let variance = own().map(|value| (value - mean) * (value - mean)).sum::<f64>() / count;
    [mean, if variance > 1e-24 * (1.0 + mean * mean) { variance.sqrt() } else { 0.0 }]
}

/// The cells while they are learned, in scaled columns.
struct Sheet {
    cells: [usize; 2],
    columns: usize,
    values: Vec<f64>,
}

impl Sheet {
    /// In the plane of the first two principal components of rows, two standard deviations to either side.
    fn new(rows: &[f64], columns: usize, cells: [usize; 2]) -> Sheet {
        let mut matrix = vec![0.0; columns * columns];
        for row in rows.chunks_exact(columns) {
            for i in 0..columns {
                for j in 0..columns {
                    matrix[i * columns + j] += row[i] * row[j] * columns as f64 / rows.len() as f64;
                }
            }
        }
        let (variances, vectors) = eigenvectors(matrix, columns);
        let mut order: Vec<usize> = (0..columns).collect();
        order.sort_by(|a, b| variances[*b].total_cmp(&variances[*a]));
        let along = |place: usize, k: usize, edge: usize| {
            let share = 4.0 * place as f64 / (edge - 1) as f64 - 2.0;
            order.get(k).map_or(0.0, |own| share * variances[*own].max(0.0).sqrt())
        };
        let mut values = Vec::with_capacity(cells[0] * cells[1] * columns);
        for cell in 0..cells[0] * cells[1] {
            let (x, y) = (along(cell % cells[0], 0, cells[0]), along(cell / cells[0], 1, cells[1]));
            let direction = |i: usize, k: usize| order.get(k).map_or(0.0, |own| vectors[i * columns + own]);
            values.extend((0..columns).map(|i| x * direction(i, 0) + y * direction(i, 1)));
        }
        Sheet { cells, columns, values }
    }

    fn cell(&self, cell: usize) -> &[f64] {
        &self.values[cell * self.columns..(cell + 1) * self.columns]
    }

    /// The two nearest cells with the squares of their distances.
    fn nearest(&self, row: &[f64]) -> [(usize, f64); 2] {
        let mut best = [(0, f64::INFINITY); 2];
        for (cell, values) in self.values.chunks_exact(self.columns).enumerate() {
            let square = values.iter().zip(row).map(|(a, b)| (a - b) * (a - b)).sum::<f64>();
            if square < best[0].1 {
                best = [(cell, square), best[0]];
            } else if square < best[1].1 {
                best[1] = (cell, square);
            }
        }
        best
    }

    /// The square of the distance of two cells on the sheet.
    fn apart(&self, a: usize, b: usize) -> f64 {
        let place = |cell: usize| [(cell % self.cells[0]) as f64, (cell / self.cells[0]) as f64];
        let ([x, y], [u, v]) = (place(a), place(b));
        (x - u) * (x - u) + (y - v) * (y - v)
    }

    /// A step with a width of the neighbourhood.
    fn step(&mut self, rows: &[f64], width: f64) {
        let count = self.cells[0] * self.cells[1];
        let (mut sums, mut members) = (vec![0.0; count * self.columns], vec![0.0; count]);
        for row in rows.chunks_exact(self.columns) {
            let [(nearest, _), _] = self.nearest(row);
            members[nearest] += 1.0;
            let sum = &mut sums[nearest * self.columns..(nearest + 1) * self.columns];
            sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += value);
        }
        for cell in 0..count {
            let (mut weight, mut mean) = (0.0, vec![0.0; self.columns]);
            for other in (0..count).filter(|other| members[*other] > 0.0) {
                let near = libm::exp(-self.apart(cell, other) / (2.0 * width * width));
                weight += near * members[other];
                let own = &sums[other * self.columns..(other + 1) * self.columns];
                mean.iter_mut().zip(own).for_each(|(mean, sum)| *mean += near * sum);
            }
            // A cell whose surroundings have no state stays as it is.
            if weight > 1e-12 {
                let slot = &mut self.values[cell * self.columns..(cell + 1) * self.columns];
                slot.iter_mut().zip(&mean).for_each(|(value, mean)| *value = mean / weight);
            }
        }
    }

    /// The mean distance of a cell from those beside, above and below it.
    fn distance(&self, cell: usize) -> f64 {
        let beside: Vec<usize> =
            (0..self.cells[0] * self.cells[1]).filter(|other| self.apart(cell, *other) == 1.0).collect();
        let distance = |other: &usize| {
            let each = self.cell(cell).iter().zip(self.cell(*other));
            each.map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt()
        };
        beside.iter().map(distance).sum::<f64>() / beside.len() as f64
    }
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};

    use super::*;
    use crate::dataset::RunStates;

    fn dataset(rows: &[[f64; 3]]) -> Dataset {
        let column = |k: usize, name: &str| Column::new(name, "", rows.iter().map(|row| row[k]).collect());
        let table = Table::new(vec![column(0, "a"), column(1, "b"), column(2, "c")]).unwrap();
        Dataset::new(vec![RunStates::new("run", table).unwrap()]).unwrap()
    }

    fn options(cells: [usize; 2]) -> MapOptions {
        MapOptions { columns: ["a", "b", "c"].map(String::from).to_vec(), cells, most_states: 10_000 }
    }

    /// States on a bent sheet: neighbours on the map are neighbours there, and every state is near its cell.
    #[test]
    fn a_sheet_is_laid_over_states() {
        let row = |k: u32| {
            let (a, b) = (f64::from(k % 20) / 19.0, f64::from(k / 20) / 19.0);
            [2.0 * a, b, (a - 0.5) * (a - 0.5)]
        };
        let rows: Vec<[f64; 3]> = (0..400).map(row).collect();
        let map = StateMap::new(&dataset(&rows), &options([8, 8]), &mut NoObserver).unwrap();
        assert!(map.error < 0.2 && map.folded < 0.05, "{} {}", map.error, map.folded);
        assert_eq!(map.states.iter().sum::<usize>(), 400);
        // The longest direction, in which a and b count alike, runs one way along a row or a column of cells.
        let steps = |step: usize, column: usize| {
            let cells = (0..8).map(|k| map.values[k * step][column]).collect::<Vec<_>>();
            cells.windows(2).all(|pair| pair[0] < pair[1]) || cells.windows(2).all(|pair| pair[0] > pair[1])
        };
        assert!((steps(1, 0) && steps(8, 1)) || (steps(8, 0) && steps(1, 1)), "{:?}", map.values);
        assert_eq!(StateMap::new(&dataset(&rows), &options([8, 8]), &mut NoObserver).unwrap(), map);
    }

    /// Two groups are kept apart by a ridge of distances without states.
    #[test]
    fn groups_are_divided_by_distances() {
        let row = |k: u32| {
            let noise = f64::from(k * 37 % 101) / 101.0;
            let at = if k.is_multiple_of(2) { 0.0 } else { 10.0 };
            [at + noise, at - 0.5 * noise, at + f64::from(k * 61 % 97) / 97.0]
        };
        let rows: Vec<[f64; 3]> = (0..200).map(row).collect();
        let map = StateMap::new(&dataset(&rows), &options([10, 2]), &mut NoObserver).unwrap();
        let most = (0..10).max_by(|a, b| map.distances[*a].total_cmp(&map.distances[*b])).unwrap();
        assert!((2..8).contains(&most), "{:?}", map.distances);
        let error =
            StateMap::new(&dataset(&rows), &options([1, 2]), &mut NoObserver).unwrap_err().to_string();
        assert!(error.contains("2 to 100 cells"), "{error}");
        let alike = dataset(&[[1.0; 3]; 20]);
        assert!(StateMap::new(&alike, &options([2, 2]), &mut NoObserver).is_err());
    }
}
