//! D2min (Falk and Langer 1998): the deviation of the motion of a grain's neighbours from the best-fitting uniform strain, from one
//! observation to the next.
//!
//! With the branches r from a grain to its neighbours (centres nearer than 1.5 times the largest diameter at the first of the two
//! observations, images included) `X = sum r(t) r(t_0)^T`, `Y = sum r(t_0) r(t_0)^T`, `F = X Y^-1`,
//! `D2 = sum |r(t) - F r(t_0)|^2` over the number of neighbours and the squared mean diameter. It is zero in a uniform strain of
//! the cell and small where the strain varies slowly in space, so that it measures local rearrangements. Grains with fewer than
//! four neighbours, or with neighbours in one plane, are excluded.
//!
//! The mean over the grains grows with the strain between the observations. The participation ratio `<D2>^2 / <D2^2>` is 1
//! if D2 is the same for all grains, and small if few grains rearrange.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert, multiply};
use granum_core::{Assembly, Part};

use crate::neighbours::Neighbours;
use crate::ratio::{mean, ratio};
use crate::tensor::add_dyad;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Largest distance of a neighbour, in largest diameters.
const REACH: f64 = 1.5;

/// The sensor.
pub struct D2Min;

impl Sensor for D2Min {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("d2min", "local rearrangement that is no strain, between two observations")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new(
                    "d2min",
                    "1",
                    "mean D2min a neighbour since the last observation, over the squared mean diameter",
                ),
                SensorColumn::new(
                    "d2min_participation",
                    "1",
                    "<D2>^2 / <D2^2>: share of the grains that rearrange",
                ),
            ])
            .needing(&[Part::Cell, Part::Positions, Part::Radii])
            .remembering()
    }

    fn reach(&self, assembly: &Assembly) -> f64 {
        REACH
            * assembly
                .bodies
                .iter()
                .fold(0.0, |largest: f64, grain| largest.max(2.0 * grain.equivalent_radius))
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        let (cell, grains) = (&observation.assembly.cell, &observation.assembly.bodies);
        let now: Vec<Vector> = grains.iter().map(|grain| grain.position).collect();
        let diameter = 2.0 * mean(grains.iter().map(|grain| grain.equivalent_radius).sum(), grains.len());
        let largest =
            grains.iter().fold(0.0, |largest: f64, grain| largest.max(2.0 * grain.equivalent_radius));
        let found = match memory.len() == 9 + 3 * now.len() {
            true => {
                let old_cell = std::array::from_fn(|i| std::array::from_fn(|j| memory[3 * i + j]));
                let before: Vec<Vector> = memory[9..].chunks_exact(3).map(|x| [x[0], x[1], x[2]]).collect();
                rearrangements([&old_cell, cell], [&before, &now], REACH * largest)
            }
            false => Vec::new(),
        };
        let of = |power: i32| {
            mean(
                found.iter().map(|d2| granum_simd::integer_power(*d2, power)).sum::<f64>() + 0.0,
                found.len(),
            )
        };
        values.extend([ratio(of(1), diameter * diameter), ratio(of(1) * of(1), of(2))]);
        memory.clear();
        memory.extend(cell.iter().flatten());
        memory.extend(now.iter().flatten());
    }
}

/// D2min of each grain that has enough neighbours, by neighbour, m2.
fn rearrangements(cells: [&Matrix; 2], centres: [&[Vector]; 2], reach: f64) -> Vec<f64> {
    let is_regular = determinant(cells[1]) != 0.0;
    let Some(neighbours) = Neighbours::new(cells[0], centres[0], reach).filter(|_| is_regular) else {
        return Vec::new();
    };
    let (back, inverse) = (invert(cells[0]), invert(cells[1]));
    let places: Vec<Vector> = centres[1].iter().map(|x| apply(&inverse, *x)).collect();
    let mut found = Vec::new();
    let mut branches: Vec<[Vector; 2]> = Vec::new();
    for i in 0..places.len() {
        branches.clear();
        neighbours.each_of(i, |j, before, _| {
            // The present image is the one nearest to the branch that follows the strain of the cell.
            let carried = apply(&back, before);
            let place = std::array::from_fn(|k| {
                let step = places[j][k] - places[i][k] - carried[k];
                carried[k] + (step - libm::round(step))
            });
            branches.push([before, apply(cells[1], place)]);
        });
        found.extend(misfit(&branches));
    }
    found
}

/// D2min by neighbour of one grain; `None` if the branches do not determine a strain.
fn misfit(branches: &[[Vector; 2]]) -> Option<f64> {
    let (mut x, mut y) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
    for [before, now] in branches {
        add_dyad(&mut x, 1.0, now, before);
        add_dyad(&mut y, 1.0, before, before);
    }
    let size = y[0][0] + y[1][1] + y[2][2];
    if branches.len() < 4 || determinant(&y) <= 1e-6 * size * size * size {
        return None;
    }
    let gradient = multiply(&x, &invert(&y));
    let square = |[before, now]: &[Vector; 2]| {
        let fitted = apply(&gradient, *before);
        (0..3).map(|a| (now[a] - fitted[a]) * (now[a] - fitted[a])).sum::<f64>()
    };
    Some(mean(branches.iter().map(square).sum(), branches.len()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;

    fn observe(memory: &mut Memory, assembly: &Assembly) -> [f64; 2] {
        let mut row = Vec::new();
        D2Min.measure(&Observation::new(assembly), memory, &mut Values::new(&mut row, &mut []));
        [row[0], row[1]]
    }

    #[test]
    fn a_strain_of_the_cell_and_a_slow_wave_are_no_rearrangement() {
        let first = lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4);
        let mut memory = Memory::new();
        assert_eq!(observe(&mut memory, &first), [0.0, 0.0]);
        let gradient = [[0.9, 0.2, 0.0], [0.0, 1.05, 0.0], [0.0, 0.1, 1.0]];
        let mut second = first.clone();
        second.cell = multiply(&gradient, &first.cell);
        second.bodies.iter_mut().for_each(|grain| grain.position = apply(&gradient, grain.position));
        assert!(observe(&mut memory, &second)[0] < 1e-24);
        // All grains move along, some of them out of the cell and in at the other side.
        let mut third = second.clone();
        let edge: Vector = std::array::from_fn(|a| second.cell[a][0]);
        for (k, grain) in third.bodies.iter_mut().enumerate() {
            grain.position =
                std::array::from_fn(|a| grain.position[a] + 0.3e-4 - if k % 3 == 0 { edge[a] } else { 0.0 });
        }
        assert!(observe(&mut memory, &third)[0] < 1e-20);
    }

    /// One grain of a simple cubic lattice moves by u. It has 18 neighbours (6 at d, 12 at sqrt(2) d), all of whose branches
    /// change by -u: by symmetry F = 1 and D2 = u^2. For each of the neighbours one branch changes by u.
    #[test]
    fn one_grain_that_moves_is_felt_by_its_neighbours() {
        let first = lattice::simple_cubic(5, 1.0, 0.0, 0.0);
        let mut second = first.clone();
        let u = 1e-3;
        second.bodies[7].position[0] += u;
        let mut memory = Memory::new();
        observe(&mut memory, &first);
        let [found, participation] = observe(&mut memory, &second);
        // Y = 10 for 18 neighbours: 2 of the 6 and 8 of the 12 have a part along each axis. A neighbour at b has X - Y = u b^T,
        // F - 1 = u b^T / 10, and so a misfit of u^2 (1 - b.b / 10) over 18.
        let [at_one, at_root_two] = [1.0, 2.0].map(|square| u * u * (1.0 - square / 10.0) / 18.0);
        let exact = (u * u + 6.0 * at_one + 12.0 * at_root_two) / 125.0;
        assert!((found / exact - 1.0).abs() < 1e-6, "{found} {exact}");
        let squares = (u.powi(4) + 6.0 * at_one * at_one + 12.0 * at_root_two * at_root_two) / 125.0;
        assert!((participation / (exact * exact / squares) - 1.0).abs() < 1e-6);
    }
}
