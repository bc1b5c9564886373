//! Buckling of force chains (Tordesillas 2007): the share of the segments of three grains of the chains of one observation whose
//! angle at the middle grain has become smaller by more than 2 degrees at the next: each arm by more than 1 degree on average.
//!
//! The chains are those of [`crate::force_chains`]. The share grows with the strain between the observations.

use granum_core::Part;
use granum_core::assembly::{Assembly, Vector};
use granum_core::geometry::{apply, determinant, invert};

use crate::force_chains::Chains;
use crate::numerics::acos_degrees;
use crate::observation::{mean, ratio};
use crate::{Description, Memory, Observation, Sensor, SensorColumn, Values};

/// Least bend, degrees.
const BEND: f64 = 2.0;

/// The sensor.
pub struct ChainBuckling;

impl Sensor for ChainBuckling {
    fn description(&self) -> Description {
        Description::new(
            "chain_buckling",
            "segments of force chains that bend between two observations (Tordesillas 2007)",
        )
        .columns([
            SensorColumn::new(
                "buckling_fraction",
                "1",
                "segments of three grains that bent by more than 2 degrees over all of the last observation",
            ),
            SensorColumn::new("chain_segments", "1", "segments of three grains of the present chains"),
        ])
        .needing(&[
            Part::Cell,
            Part::Positions,
            Part::Radii,
            Part::Contacts,
            Part::NormalForces,
            Part::TangentialForces,
        ])
        .remembering()
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let (mut bent, mut count) = (0, 0);
        for segment in memory.chunks_exact(4) {
            let grains = [segment[0] as usize, segment[1] as usize, segment[2] as usize];
            let Some(angle) = inner_angle(assembly, grains) else { continue };
            count += 1;
            bent += usize::from(segment[3] - angle > BEND);
        }
        memory.clear();
        for chain in Chains::of(observation).chains {
            for grains in chain.windows(3) {
                if let Some(angle) = inner_angle(assembly, [grains[0], grains[1], grains[2]]) {
                    memory.extend(grains.iter().map(|&grain| grain as f64));
                    memory.push(angle);
                }
            }
        }
        values.extend([mean(bent as f64, count), (memory.len() / 4) as f64]);
    }
}

/// Angle at the middle one of three grains, in degrees: 180 in a straight row. `None` for grains that do not exist or a cell
/// without a volume.
fn inner_angle(assembly: &Assembly, [first, middle, last]: [usize; 3]) -> Option<f64> {
    let cell = &assembly.cell;
    if determinant(cell) == 0.0 {
        return None;
    }
    let inverse = invert(cell);
    let centre = |grain: usize| assembly.grains.get(grain).map(|grain| grain.position);
    let middle = centre(middle)?;
    let arm = |end: Vector| -> Vector {
        let place = apply(&inverse, std::array::from_fn(|a| end[a] - middle[a]));
        apply(cell, place.map(|s| s - s.round()))
    };
    let (a, b) = (arm(centre(first)?), arm(centre(last)?));
    let dot = |a: &Vector, b: &Vector| (0..3).map(|k| a[k] * b[k]).sum::<f64>();
    Some(acos_degrees(ratio(dot(&a, &b), (dot(&a, &a) * dot(&b, &b)).sqrt())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::force_chains::tests::grains_at;

    #[test]
    fn a_row_that_bends_in_the_middle_buckles_there() {
        let row = |offset: f64| -> Vec<Vector> {
            let mut places: Vec<Vector> = (0..5).map(|k| [1.0 + 2.0 * f64::from(k), 99.9, 0.0]).collect();
            places[2][1] += offset;
            // Grains that bear nothing keep the mean of the stress low.
            places.extend((0..4).map(|k| [20.0 + 5.0 * f64::from(k), 50.0, 0.0]));
            places
        };
        let mut memory = Memory::new();
        let mut observe = |offset: f64, wraps: bool| {
            let mut assembly = grains_at(&row(offset), |_, _| 1.0);
            if wraps {
                assembly
                    .grains
                    .iter_mut()
                    .filter(|grain| grain.position[1] > 100.0)
                    .for_each(|grain| grain.position[1] -= 100.0);
            }
            let mut values = Vec::new();
            ChainBuckling.measure(
                &Observation::new(&assembly),
                &mut memory,
                &mut Values::new(&mut values, &mut []),
            );
            values
        };
        assert_eq!(observe(0.0, false), [0.0, 3.0]);
        // The middle grain by 0.03: its own angle falls by 1.7 degrees, those of its neighbours by half of that.
        assert_eq!(observe(0.03, false), [0.0, 3.0]);
        // By 0.15 more, across the edge of the cell: 8.6 degrees and half of that.
        assert_eq!(observe(0.18, true), [1.0, 3.0]);
        // And back: straightening is no buckling.
        assert_eq!(observe(0.0, false), [0.0, 3.0]);
        // By 0.05: only the angle in the middle falls by more than 2 degrees, 2.9.
        assert!((observe(0.05, false)[0] - 1.0 / 3.0).abs() < 1e-15);
    }
}
