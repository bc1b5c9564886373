//! Distribution of the overlaps of contacts in compression: their mean over the sum of the radii, and the histogram of each
//! overlap over the mean one.
//!
//! With equal grains and Hertz's law `f` is proportional to `(alpha / <alpha>)^(3/2)`, so that P(overlap) corresponds to the
//! distribution of forces for codes or experiments that provide positions and radii only.

use granum_core::Part;
use granum_core::assembly::Contact;
use granum_dem::config::Recording;

use crate::force_distribution::{BIN_WIDTH, LARGEST_FORCE, bins_of};
use crate::ratio::{mean, ratio};
use crate::{Bins, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct OverlapDistribution;

impl Sensor for OverlapDistribution {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "overlap_distribution",
            "distribution of the overlaps of contacts in compression",
        )
        .speaking_of(Subject::Contacts)
        .columns([SensorColumn::new(
            "mean_overlap",
            "1",
            "mean alpha / (R_i + R_j) of the contacts with alpha > 0",
        )])
        .parameters([BIN_WIDTH, LARGEST_FORCE])
        .needing(&[Part::Radii, Part::Contacts, Part::Overlaps])
    }

    fn histograms(&self, recording: &Recording) -> Vec<Bins> {
        let [width, largest] = bins_of(recording);
        vec![Bins::new("overlaps", "overlap", "1").width(width).range(0.0, largest)]
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let pieces = &observation.assembly.pieces;
        let pressed = || observation.assembly.contacts.iter().filter(|contact| contact.approach > 0.0);
        let relative = |contact: &Contact| {
            let radii = pieces.get(contact.i)?.radius + pieces.get(contact.j)?.radius;
            Some(ratio(contact.approach, radii))
        };
        let count = pressed().count();
        values.push(mean(pressed().filter_map(relative).sum::<f64>() + 0.0, count));
        let mean_overlap = mean(pressed().map(|contact| contact.approach).sum(), count);
        values.count(0, pressed().map(|contact| contact.approach / mean_overlap));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::measured;
    use crate::{Histogram, lattice};
    use granum_core::Assembly;

    fn counted(assembly: &Assembly) -> Histogram {
        let sensor = OverlapDistribution;
        let mut histograms = [sensor.histograms(&Recording::default())[0].empty()];
        let mut values = Vec::new();
        sensor.measure(
            &Observation::new(assembly),
            &mut Memory::new(),
            &mut Values::new(&mut values, &mut histograms),
        );
        let [histogram] = histograms;
        histogram
    }

    #[test]
    fn overlaps_are_counted_in_units_of_their_mean() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-3, 2e-4);
        assert!((measured(&OverlapDistribution, &assembly)[0] / 1e-3 - 1.0).abs() < 1e-9);
        for (k, contact) in assembly.contacts.iter_mut().enumerate() {
            // A third of the contacts is separated, and a third has three times the overlap of the last third: the mean is twice the
            // smaller overlap.
            contact.approach = [-1e-9, 1e-9, 3e-9][k % 3];
        }
        let histogram = counted(&assembly);
        assert_eq!(histogram.total(), 54, "contacts that are stretched apart have no overlap");
        assert_eq!((histogram.counts[2], histogram.counts[6]), (27, 27), "at 0.5 and 1.5 of the mean");
    }

    #[test]
    fn without_overlaps_nothing_is_counted() {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-3, 2e-4);
        assembly.contacts.iter_mut().for_each(|contact| contact.approach = 0.0);
        assert_eq!((measured(&OverlapDistribution, &assembly)[0], counted(&assembly).total()), (0.0, 0));
    }
}
