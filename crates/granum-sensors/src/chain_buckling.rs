//! Buckling of force chains (Tordesillas 2007): the fraction of the segments of three grains, in the chains of a state, whose
//! angle at the middle grain has decreased by more than 2 degrees after 1 % of strain, so that each arm has rotated by more than
//! 1 degree on average.
//!
//! The chains are those of [`crate::force_chains`]; strain is arc length. The chains of one observation are followed until an
//! observation at least 1 % later, whose chains are followed then; in between, the value of the last interval is reported.

use granum_core::Part;
use granum_core::assembly::{Assembly, Vector};
use granum_core::geometry::{apply, determinant, invert};

use crate::force_chains::Chains;
use crate::numerics::acos_degrees;
use crate::ratio::{mean, ratio};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Smallest decrease of the angle of a segment that counts as buckling, degrees.
const BEND: f64 = 2.0;
/// Strain over which segments are followed.
const INTERVAL: f64 = 0.01;

/// The sensor.
pub struct ChainBuckling;

impl Sensor for ChainBuckling {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("chain_buckling", "segments of force chains that bend within 1 % of strain (Tordesillas 2007)").speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new(
                    "buckling_fraction",
                    "1",
                    "segments of three grains that bent by more than 2 degrees over all, in the last 1 % of strain",
                ),
                SensorColumn::new("chain_segments", "1", "segments of three grains of the chains that are followed"),
            ])
            .needing(&[
                Part::Cell,
                Part::Positions,
                Part::Radii,
                Part::Contacts,
                Part::NormalForces,
                Part::TangentialForces,
                Part::Strain,
            ])
            .remembering()
    }

    fn measure(&self, observation: &Observation, memory: &mut Memory, values: &mut Values) {
        // The arc length at which the segments were found, the fraction in the previous interval, the number of segments, then
        // the segments.
        let arc_length = observation.assembly.arc_length;
        if let [start, share, count, ..] = memory[..]
            && arc_length < start + (1.0 - 1e-9) * INTERVAL
        {
            values.extend([share, count]);
            return;
        }
        let share = memory.get(3..).map_or(0.0, |segments| bent(observation.assembly, segments));
        memory.clear();
        memory.extend([arc_length, share, 0.0]);
        for chain in Chains::from_observation(observation).chains {
            for grains in chain.windows(3) {
                if let Some(angle) = inner_angle(observation.assembly, [grains[0], grains[1], grains[2]]) {
                    memory.extend(grains.iter().map(|&grain| grain as f64));
                    memory.push(angle);
                }
            }
        }
        let count = ((memory.len() - 3) / 4) as f64;
        memory[2] = count;
        values.extend([share, count]);
    }
}

/// The fraction of segments that have buckled.
fn bent(assembly: &Assembly, segments: &[f64]) -> f64 {
    let (mut bent, mut count) = (0, 0);
    for segment in segments.chunks_exact(4) {
        let grains = [segment[0] as usize, segment[1] as usize, segment[2] as usize];
        let Some(angle) = inner_angle(assembly, grains) else { continue };
        count += 1;
        bent += usize::from(segment[3] - angle > BEND);
    }
    mean(bent as f64, count)
}

/// Angle at the middle one of three grains, in degrees: 180 in a straight row. `None` for grains that do not exist or a cell
/// without a volume.
fn inner_angle(assembly: &Assembly, [first, middle, last]: [usize; 3]) -> Option<f64> {
    let cell = &assembly.cell;
    if determinant(cell) == 0.0 {
        return None;
    }
    let inverse = invert(cell);
    let centre = |grain: usize| assembly.bodies.get(grain).map(|grain| grain.position);
    let middle = centre(middle)?;
    let arm = |end: Vector| -> Vector {
        let place = apply(&inverse, std::array::from_fn(|a| end[a] - middle[a]));
        apply(cell, place.map(|s| s - libm::round(s)))
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
        let mut arc_length = 0.0;
        let mut observe = |offset: f64, wraps: bool| {
            let mut assembly = grains_at(&row(offset), |_, _| 1.0);
            assembly.arc_length = arc_length;
            arc_length += 0.01;
            if wraps {
                assembly
                    .bodies
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

    #[test]
    fn segments_are_followed_over_a_stretch_of_strain() {
        let mut memory = Memory::new();
        let mut observe = |offset: f64, arc_length: f64| {
            let mut places: Vec<Vector> = (0..3).map(|k| [1.0 + 2.0 * f64::from(k), 50.0, 0.0]).collect();
            places[1][1] += offset;
            places.extend((0..4).map(|k| [20.0 + 5.0 * f64::from(k), 20.0, 0.0]));
            let assembly = Assembly { arc_length, ..grains_at(&places, |_, _| 1.0) };
            let mut values = Vec::new();
            ChainBuckling.measure(
                &Observation::new(&assembly),
                &mut memory,
                &mut Values::new(&mut values, &mut []),
            );
            values[0]
        };
        // 0.02 more at each observation: 1.1 degrees each, 2.3 together.
        assert_eq!([observe(0.0, 0.1), observe(0.02, 0.105), observe(0.04, 0.11)], [0.0, 0.0, 1.0]);
        // The value is reported until the end of the next interval, in which no segment buckles.
        assert_eq!([observe(0.04, 0.115), observe(0.04, 0.12)], [1.0, 0.0]);
    }
}
