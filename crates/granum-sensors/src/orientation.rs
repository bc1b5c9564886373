//! Orientation of grains that are no spheres: the directions of their long and of their short axes.
//!
//! The long axis u is that of the least moment of inertia, the short axis w that of the largest. `<u_i u_j>` and `<w_i w_j>`, the means over the
//! grains that have such an axis, have the trace 1 (the "orientation" or "particle fabric" of Oda 1972). Deviator along axis 1,
//! `<u u>_1 - <u u>_3` with axes 2 and 3 averaged, as of the [contacts](crate::fabric): 1 where all axes lie along axis 1, 0 for
//! isotropic ones, -1/2 where all are normal to axis 1. The mean angle between the lines u and axis 1, from 0 to 90 degrees, is 57.3 degrees (one
//! radian) for isotropic axes; 90 degrees less it is the mean inclination to the plane normal to axis 1, which is horizontal where
//! axis 1 is the vertical.
//!
//! A grain whose two smaller moments are equal (to 1e-6 of the largest), such as a flat one of revolution, has no single long axis, and one
//! whose two larger moments are equal, such as a dimer or a capsule, no single short axis; spheres have neither. Such grains are left
//! out, and the share of the others is recorded; without any the values are 0.

use granum_core::assembly::Matrix;

use crate::numerics::acos_degrees;
use crate::principal_axes::{Axis, direction};
use crate::ratio::{mean, ratio};
use crate::tensor::{add_dyad, deviator, scaled};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct Orientation;

impl Sensor for Orientation {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("orientation", "directions of the long and the short axes of the grains")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new("long_axis_11", "1", "component 11 of <u u>, u the long axis of a grain"),
                SensorColumn::new("long_axis_22", "1", "component 22"),
                SensorColumn::new("long_axis_33", "1", "component 33"),
                SensorColumn::new("long_axis_12", "1", "component 12"),
                SensorColumn::new("long_axis_13", "1", "component 13"),
                SensorColumn::new("long_axis_23", "1", "component 23"),
                SensorColumn::new("deviator_long_axis", "1", "<u u>_1 - <u u>_3, axes 2 and 3 averaged"),
                SensorColumn::new(
                    "long_axis_angle",
                    "deg",
                    "mean angle of the long axis to axis 1; 57.3 if isotropic",
                ),
                SensorColumn::new(
                    "long_axis_fraction",
                    "1",
                    "grains with a single long axis over all grains",
                ),
                SensorColumn::new("short_axis_11", "1", "component 11 of <w w>, w the short axis of a grain"),
                SensorColumn::new("short_axis_22", "1", "component 22"),
                SensorColumn::new("short_axis_33", "1", "component 33"),
                SensorColumn::new("short_axis_12", "1", "component 12"),
                SensorColumn::new("short_axis_13", "1", "component 13"),
                SensorColumn::new("short_axis_23", "1", "component 23"),
                SensorColumn::new("deviator_short_axis", "1", "<w w>_1 - <w w>_3, axes 2 and 3 averaged"),
                SensorColumn::new(
                    "short_axis_fraction",
                    "1",
                    "grains with a single short axis over all grains",
                ),
            ])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let [long, short] = [Axis::Long, Axis::Short].map(|axis| Axes::from_observation(observation, axis));
        values.extend(long.components());
        values.extend([deviator(&long.tensor), long.angle, long.fraction]);
        values.extend(short.components());
        values.extend([deviator(&short.tensor), short.fraction]);
    }
}

/// The directions of one axis of the grains.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Axes {
    /// `<u u>` over the grains that have the axis.
    pub tensor: Matrix,
    /// Mean angle to axis 1, degrees.
    pub angle: f64,
    /// Grains that have the axis over all grains.
    pub fraction: f64,
}

impl Axes {
    /// Measures the directions; all zero where no grain has the axis.
    pub fn from_observation(observation: &Observation, axis: Axis) -> Axes {
        let assembly = observation.assembly;
        let (mut sum, mut angles, mut count) = ([[0.0; 3]; 3], 0.0, 0);
        for u in assembly.bodies.iter().filter_map(|body| direction(assembly, body, axis)) {
            add_dyad(&mut sum, 1.0, &u, &u);
            angles += acos_degrees(u[0].abs());
            count += 1;
        }
        Axes {
            tensor: scaled(&sum, ratio(1.0, count as f64)),
            angle: mean(angles, count),
            fraction: mean(count as f64, assembly.bodies.len()),
        }
    }

    /// The components 11, 22, 33, 12, 13 and 23.
    fn components(&self) -> [f64; 6] {
        let [[a, d, e], [_, b, f], [_, _, c]] = self.tensor;
        [a, b, c, d, e, f]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clumps::{self, Clump};
    use crate::sensor::measured;
    use granum_core::assembly::Assembly;
    use granum_core::rotation::about;

    /// Dimers along x, x and y, and two spheres.
    #[test]
    fn dimers_have_a_long_axis_and_no_short_one() {
        let row = measured(&Orientation, &clumps::few());
        let third = 1.0 / 3.0;
        let exact = [2.0 * third, third, 0.0, 0.0, 0.0, 0.0, 0.5, 30.0, 0.6];
        assert!(row.iter().zip(exact).all(|(value, exact)| (value - exact).abs() < 1e-12), "{row:?}");
        assert_eq!(row[9..], [0.0; 8]);
    }

    /// A grain with three different axes, the long one along y and the short one along z of the body, turned about z by 30 degrees.
    #[test]
    fn a_grain_of_three_axes_has_both() {
        let mut assembly = Assembly::default();
        let orientation = about(&[0.0, 0.0, 1.0], std::f64::consts::FRAC_PI_6);
        let (inertia, centres) = ([0.2, 0.1, 0.3], &[[0.0; 3]]);
        clumps::push(&mut assembly, &Clump { position: [0.0; 3], orientation, inertia, centres });
        let row = measured(&Orientation, &assembly);
        // The long axis is (-1/2, sqrt(3)/2, 0): 60 degrees from axis 1 as a line.
        let exact = [0.25, 0.75, 0.0, -(3f64.sqrt()) / 4.0, 0.0, 0.0, -0.125, 60.0, 1.0];
        let short = [0.0, 0.0, 1.0, 0.0, 0.0, 0.0, -0.5, 1.0];
        for (value, exact) in row.iter().zip(exact.into_iter().chain(short)) {
            assert!((value - exact).abs() < 1e-12, "{row:?}");
        }
    }

    /// Axes along a spiral of evenly spread points of the sphere are isotropic.
    #[test]
    fn isotropic_axes_lie_at_a_radian_from_an_axis() {
        let mut assembly = Assembly::default();
        for k in 0..2000 {
            let cosine = 1.0 - (k as f64 + 0.5) / 1000.0;
            let turn = 2.399963229728653 * k as f64;
            // From the long axis x of the body to the direction with this cosine to x.
            let orientation = about(&[0.0, turn.cos(), turn.sin()], cosine.acos());
            let (inertia, centres) = ([0.1, 0.35, 0.35], &[[0.0; 3]]);
            clumps::push(&mut assembly, &Clump { position: [0.0; 3], orientation, inertia, centres });
        }
        let axes = Axes::from_observation(&Observation::new(&assembly), Axis::Long);
        assert!((axes.angle - 1f64.to_degrees()).abs() < 0.01, "{}", axes.angle);
        assert!(deviator(&axes.tensor).abs() < 1e-3 && axes.fraction == 1.0);
    }
}
