//! Radial distribution function g(r): the density of centres at a distance r from a centre, over the mean density.
//!
//! The sensor counts the distances r of pairs of centres, in mean diameters, in bins of 0.05 up to 5, images included. With the
//! counts n_b over all observations of a state, N grains, the volume V of the cell in cubed mean diameters (the column
//! `cell_volume_in_diameters`, and N beside it as `grains`) it is `g_b = 2 n_b V / (observations N^2 (4/3) pi (r_2^3 - r_1^3))`,
//! which [`radial_distribution`] computes; it tends to 1 far away, in a cell whose smallest height is more than twice the
//! distance (Allen and Tildesley 1987). Pairs farther apart are not counted.

use granum_core::assembly::Vector;
use granum_core::{Assembly, Part};
use granum_dem::config::Recording;

use crate::neighbours::Neighbours;
use crate::ratio::{mean, ratio};
use crate::{Bins, Histogram, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Width of a bin, and the largest distance, in mean diameters.
const WIDTH: f64 = 0.05;
const FARTHEST: f64 = 5.0;

/// The sensor.
pub struct RadialDistribution;

impl Sensor for RadialDistribution {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "radial_distribution",
            "distances of pairs of centres, for the radial distribution function",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new(
                "cell_volume_in_diameters",
                "1",
                "volume of the cell over the cubed mean diameter",
            ),
            SensorColumn::new("grains", "1", "number N of grains"),
        ])
        .needing(&[Part::Cell, Part::Positions, Part::Radii])
    }

    fn histograms(&self, _: &Recording) -> Vec<Bins> {
        vec![Bins::new("distances", "distance", "1").width(WIDTH).range(0.0, FARTHEST)]
    }

    fn reach(&self, assembly: &Assembly) -> f64 {
        let radii: f64 = assembly.bodies.iter().map(|grain| grain.equivalent_radius).sum();
        FARTHEST * 2.0 * mean(radii, assembly.bodies.len())
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let grains = &observation.assembly.bodies;
        let diameter = 2.0 * mean(grains.iter().map(|grain| grain.equivalent_radius).sum(), grains.len());
        values.push(ratio(observation.volume, diameter * diameter * diameter));
        values.push(grains.len() as f64);
        let Some(histogram) = values.histogram(0) else { return };
        let positions: Vec<Vector> = grains.iter().map(|grain| grain.position).collect();
        let reach = FARTHEST * diameter;
        let Some(neighbours) = Neighbours::new(&observation.assembly.cell, &positions, reach) else { return };
        let per_width = 1.0 / (diameter * histogram.bin_width);
        for i in 0..positions.len() {
            // Each pair is found from both grains and counted once, and so are two opposite images of the grain itself.
            neighbours.each_of(i, |j, branch, distance| {
                if j > i || (j == i && is_upper(&branch)) {
                    histogram.add_in_widths(distance * per_width);
                }
            });
        }
    }
}

/// True for one of two opposite vectors.
fn is_upper(v: &Vector) -> bool {
    v.iter().find(|x| **x != 0.0).is_some_and(|x| *x > 0.0)
}

/// The radial distribution function from the counted distances of a state: the middle of each bin in mean diameters, and g.
/// `cell_volume` is in cubed mean diameters; all g are 0 without grains or observations.
///
/// ```
/// use granum_sensors::Histogram;
/// use granum_sensors::radial_distribution::radial_distribution;
///
/// // A hundred grains without order in a volume of 1000: the number of pairs at distances from 2 to 3 for g = 1.
/// let mut distances = Histogram::new(1.0, 0.0, 4.0);
/// distances.counts[2] = (0.5 * 100.0 * 100.0 / 1000.0 * 4.0 / 3.0 * std::f64::consts::PI * 19.0) as u64;
/// let g = radial_distribution(&distances, 1.0, 100.0, 1000.0);
/// assert_eq!(g[2].0, 2.5);
/// assert!((g[2].1 - 1.0).abs() < 0.003);
/// ```
pub fn radial_distribution(
    distances: &Histogram,
    observations: f64,
    grains: f64,
    cell_volume: f64,
) -> Vec<(f64, f64)> {
    let at = |bin: usize| {
        let [low, high] = distances.edges(bin);
        let shell = 4.0 / 3.0 * std::f64::consts::PI * (high * high * high - low * low * low);
        let expected = 0.5 * observations * grains * grains / cell_volume * shell;
        (distances.centre(bin), ratio(distances.counts[bin] as f64, expected))
    };
    (0..distances.bins()).map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    fn counted(assembly: &Assembly) -> (Vec<f64>, Histogram) {
        let mut histograms = [RadialDistribution.histograms(&Recording::default())[0].empty()];
        let mut row = Vec::new();
        RadialDistribution.measure(
            &Observation::new(assembly),
            &mut Memory::new(),
            &mut Values::new(&mut row, &mut histograms),
        );
        let [histogram] = histograms;
        (row, histogram)
    }

    /// Shells of the face-centred cubic lattice: 12, 6, 24, 12, 24 at the roots of 1 to 5 nearest distances; half of them a
    /// grain are pairs. In a cell of one cube the distances reach far across its edges.
    #[test]
    fn shells_of_a_face_centred_lattice() {
        for n in [1, 4] {
            // A little strained, so that no shell lies on the edge of a bin.
            let assembly = lattice::face_centred_cubic(n, 1.0, 0.01, 0.0);
            let (row, histogram) = counted(&assembly);
            let grains = assembly.bodies.len() as f64;
            assert_eq!(row[1], grains);
            for (shell, pairs) in [(1.0f64, 6.0), (2.0, 3.0), (3.0, 12.0), (4.0, 6.0), (5.0, 12.0)] {
                let bin = (0.99 * shell.sqrt() / WIDTH).floor() as usize;
                assert_eq!(histogram.counts[bin] as f64, pairs * grains, "{n} {shell}");
            }
            assert_eq!(histogram.counts[..19].iter().sum::<u64>(), 0);
        }
    }

    /// Points without order have g = 1 at every distance.
    #[test]
    fn points_without_order_have_one_everywhere() {
        let mut assembly = lattice::random_contacts(3000, 12);
        assembly.bodies.iter_mut().for_each(|grain| grain.equivalent_radius = 0.04);
        let (row, histogram) = counted(&assembly);
        for (r, g) in
            radial_distribution(&histogram, 1.0, row[1], row[0]).into_iter().filter(|(r, _)| *r > 1.0)
        {
            assert!((g - 1.0).abs() < 0.06, "{r} {g}");
        }
    }
}
