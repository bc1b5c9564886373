//! Non-affine displacement: the displacement of grains relative to the uniform strain of the cell, from one observation to the next.
//!
//! With the reduced position `s = H^-1 x` of a grain in the cell, which an affine motion does not change, its non-affine
//! displacement is `u = H ds`, `ds` to the nearest image; its root mean square over the grains is divided by the mean diameter.
//! The mean displacement of all grains is subtracted. A second column gives the strain between the two observations: if grains
//! diffuse, `<u^2>` is proportional to it; in a steady flow `<u^2>` is proportional to its square.
//!
//! A grain must move by less than half of the cell between two observations.

use granum_core::Part;
use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};

use crate::ratio::{mean, ratio};
use crate::{Averaging, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct NonaffineDisplacement;

impl Sensor for NonaffineDisplacement {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "nonaffine_displacement",
            "motion of the grains relative to the uniform strain of the cell",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new(
                "nonaffine_displacement",
                "1",
                "root mean square non-affine displacement since the last observation, over the mean diameter",
            )
            .averaged(Averaging::RootMeanSquare),
            SensorColumn::new(
                "nonaffine_strain_step",
                "1",
                "arc length of strain since the last observation; 0 at the first",
            ),
        ])
        .needing(&[Part::Cell, Part::Positions, Part::Radii, Part::Strain])
        .remembering()
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let (cell, grains) = (&assembly.cell, &assembly.bodies);
        let regular = determinant(cell) != 0.0;
        let inverse = if regular { invert(cell) } else { [[0.0; 3]; 3] };
        let places: Vec<Vector> = grains.iter().map(|grain| apply(&inverse, grain.position)).collect();
        // The last number is the arc length, those before it are the reduced positions.
        let step = match memory.split_last() {
            Some((arc_length, before)) if before.len() == 3 * places.len() && regular => {
                let diameter =
                    2.0 * mean(grains.iter().map(|grain| grain.equivalent_radius).sum(), grains.len());
                let displacement = root_mean_square(cell, before, &places);
                [ratio(displacement, diameter), assembly.arc_length - arc_length]
            }
            _ => [0.0; 2],
        };
        values.extend(step);
        memory.clear();
        memory.extend(places.iter().flatten());
        memory.push(assembly.arc_length);
    }
}

/// Root mean square of the non-affine displacements, m.
fn root_mean_square(cell: &Matrix, before: &[f64], places: &[Vector]) -> f64 {
    let moved: Vec<Vector> = (before.chunks_exact(3).zip(places))
        .map(|(before, now)| {
            let step = std::array::from_fn(|a| {
                let step = now[a] - before[a];
                step - libm::round(step)
            });
            apply(cell, step)
        })
        .collect();
    let drift: Vector = std::array::from_fn(|a| mean(moved.iter().map(|u| u[a]).sum(), moved.len()));
    let square = |u: &Vector| (0..3).map(|a| (u[a] - drift[a]) * (u[a] - drift[a])).sum::<f64>();
    mean(moved.iter().map(square).sum::<f64>() + 0.0, moved.len()).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use granum_core::Assembly;

    fn observe(memory: &mut Memory, assembly: &Assembly) -> [f64; 2] {
        let mut row = Vec::new();
        NonaffineDisplacement.measure(
            &Observation::new(assembly),
            memory,
            &mut Values::new(&mut row, &mut []),
        );
        [row[0], row[1]]
    }

    /// The assembly deformed with its cell.
    fn deformed(assembly: &Assembly, gradient: &Matrix, arc_length: f64) -> Assembly {
        let map = |x: Vector| apply(gradient, x);
        let mut out = assembly.clone();
        for column in 0..3 {
            let edge = map(std::array::from_fn(|row| assembly.cell[row][column]));
            (0..3).for_each(|row| out.cell[row][column] = edge[row]);
        }
        out.bodies.iter_mut().for_each(|grain| grain.position = map(grain.position));
        out.arc_length = arc_length;
        out
    }

    #[test]
    fn an_affine_motion_is_none_and_a_jump_is_measured_across_the_edge_of_the_cell() {
        let first = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let mut memory = Memory::new();
        assert_eq!(observe(&mut memory, &first), [0.0, 0.0]);
        let mut second = deformed(&first, &[[0.9, 0.2, 0.0], [0.0, 1.05, 0.0], [0.0, 0.1, 1.0]], 0.1);
        let [affine, step] = observe(&mut memory, &second);
        assert!(affine < 1e-12 && (step - 0.1).abs() < 1e-15, "{affine} {step}");

        // Two grains move towards each other by a quarter of a diameter, one of them out of the cell and in at the other side.
        let edge: f64 = second.cell[0][0];
        second.arc_length = 0.4;
        second.bodies[0].position[0] += edge - 0.25e-4;
        second.bodies[1].position[0] += 0.25e-4;
        let [jump, step] = observe(&mut memory, &second);
        let exact = 0.25 * (2.0 / 27.0f64).sqrt();
        assert!((jump / exact - 1.0).abs() < 1e-9 && (step - 0.3).abs() < 1e-15, "{jump} {exact}");
    }

    #[test]
    fn another_number_of_grains_begins_anew() {
        let mut memory = Memory::new();
        observe(&mut memory, &lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4));
        assert_eq!(observe(&mut memory, &lattice::face_centred_cubic(3, 1e-4, 1e-4, 1e-4)), [0.0, 0.0]);
    }
}
