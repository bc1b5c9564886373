//! The picture of a self-organising map of states: a panel for each column, one for the number of states in each cell, and one for the distances of
//! cells from their neighbours.

use granum_learn::examine::StateMap;

use super::figure::palette::sequential;
use super::figure::{Axis, Figure, Layer, Legend, Panel, Plot, Shape, literal};

/// Number of colours.
const COLOURS: usize = 24;
/// Panels in a row.
const IN_A_ROW: usize = 3;
/// Width of a panel without its axes, and what axes and title take of its height, px.
const INSIDE: [f64; 2] = [200.0, 74.0];

/// The picture as SVG.
pub fn state_map(map: &StateMap) -> String {
    let [across, up] = map.cells;
    let mut panels = Vec::new();
    for (k, (name, unit)) in map.columns.iter().enumerate() {
        let values: Vec<f64> = map.values.iter().map(|cell| cell[k]).collect();
        let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
        panels.push(panel(map, &name.replace('_', " "), &unit, &values));
    }
    let states: Vec<f64> = map.states.iter().map(|count| *count as f64).collect();
    panels.push(panel(map, "states in a cell", "", &states));
    panels.push(panel(map, "distance from neighbours", "", &map.distances));
    let count: usize = map.states.iter().sum();
    let description = format!("Self-organising map of {count} states on {across} x {up} cells; dark is high");
    let height = INSIDE[0] * up as f64 / across as f64 + INSIDE[1];
    Figure::new(&description, IN_A_ROW, panels)
        .sized(720.0, height.clamp(110.0, 400.0))
        .legend(Legend::Hidden)
        .to_svg()
}

/// The cells coloured by a value, from pale (the least) to dark (the most).
fn panel(map: &StateMap, title: &str, unit: &str, values: &[f64]) -> Panel {
    let least = values.iter().copied().fold(f64::INFINITY, f64::min);
    let most = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let [across, up] = map.cells;
    let colour = |value: f64| {
        let share = if most > least { (value - least) / (most - least) } else { 0.0 };
        ((share * COLOURS as f64) as usize).min(COLOURS - 1)
    };
    let layer = |k: usize| {
        let own = (0..across * up).filter(|cell| colour(values[*cell]) == k);
        let points = own.map(|cell| [(cell % across) as f64 + 1.0, (cell / across) as f64 + 1.0]).collect();
        // A square of a radius r has edges of 1.76 r; cells touch.
        let radius = INSIDE[0] / across as f64 / 1.7;
        Layer::dots(points, Shape::Square, radius, &sequential((k as f64 + 0.5) / COLOURS as f64, 0.0))
    };
    let axis = |label: &str, cells: usize| Axis::new(label).between(0.5, cells as f64 + 0.5);
    let range = format!("pale {}, dark {}{unit}", short(least), short(most));
    let plot = Plot::new(axis(&range, across), axis("", up)).with_all((0..COLOURS).map(layer));
    Panel::plot(plot).titled(&literal(title))
}

/// A number with three significant digits.
fn short(value: f64) -> String {
    let exponent = format!("{value:.2e}").split_once('e').and_then(|(_, power)| power.parse::<i32>().ok());
    let digits = exponent.map_or(0, |power| (2 - power).clamp(0, 6) as usize);
    if value == 0.0 { "0".into() } else { format!("{value:.digits$}") }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each panel names its column and its range, and the same map has the same bytes.
    #[test]
    fn panels_name_columns_and_ranges() {
        let map = StateMap {
            columns: vec![("stress_ratio".into(), String::new()), ("mean_stress".into(), "Pa".into())],
            cells: [3, 2],
            values: (0..6).map(|k| vec![0.1 * f64::from(k), 1e4]).collect(),
            states: vec![4, 0, 1, 1, 2, 7],
            distances: vec![0.2; 6],
            error: 0.1,
            folded: 0.0,
        };
        let svg = state_map(&map);
        for text in [
            "stress ratio<",
            "pale 0, dark 0.500",
            "pale 10000, dark 10000 Pa",
            "states in a cell<",
            "15 states on 3 x 2",
        ] {
            assert!(svg.contains(text), "{text}");
        }
        assert_eq!(short(123.456), "123");
        assert_eq!(svg, state_map(&map));
    }
}
