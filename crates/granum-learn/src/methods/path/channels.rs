//! What a path of strain is to a network: increments with their length and direction, start values, and measured quantities as tensors and scalars.

use serde::{Deserialize, Serialize};

use super::growth::{PathPlace, PathPlaces, norm};
use super::rotation::{COMPONENTS, parts, whole};
use super::tensor_channel::{TensorChannel, moments, offset_of, six};
use crate::error::{LearnError, Result};
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::spec::Columns;

/// The columns of strain, in the order of the components of a tensor; the last three are angles, twice the components.
pub(crate) const STRAINS: [&str; 6] = [
    "axial_strain",
    "lateral_strain_2",
    "lateral_strain_3",
    "shear_strain_yz",
    "shear_strain_zx",
    "shear_strain_xy",
];
const VOLUME: &str = "volumetric_strain";
/// The ends of the names of the columns of a tensor, in the same order.
pub(crate) const SUFFIXES: [&str; 6] = ["11", "22", "33", "23", "13", "12"];
/// The mean length of an increment, in the units of networks.
pub(super) const MEAN_LENGTH: f64 = 0.1;
/// A mean part of a tensor that varies by less than this share of itself is taken as constant.
const CONSTANT: f64 = 0.02;
/// Shorter increments, in units of the mean, are none.
pub(super) const LEAST: f64 = 1e-9;

/// The division of inputs and outputs into increments, start values, tensors and scalars, with their scales.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Channels {
    /// Places of the six strains among the inputs, if all are there: the path.
    pub(super) strain: Option<[usize; 6]>,
    /// True if the volume is prescribed: it is not an output.
    has_volume: bool,
    /// Other inputs that vary along a run, with the root mean square of their increments.
    varying: Vec<(usize, f64)>,
    /// Mean norm of an increment.
    length: f64,
    /// Inputs that are constant in a run and no first values of outputs, and the first values of those that vary, with mean and deviation.
    pub(super) start: Vec<(usize, [f64; 2])>,
    pub(super) tensors: Vec<TensorChannel>,
    pub(super) scalars: Vec<ScalarChannel>,
}

/// Where a scalar comes from.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Source {
    /// An output.
    Output(usize),
    /// A third of the trace of a tensor.
    MeanOf(usize),
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScalarChannel {
    pub source: Source,
    /// Input with its value before the first row.
    pub start: Option<usize>,
    /// Mean and deviation.
    pub scale: [f64; 2],
    /// The value before the first row where no input has it.
    pub first: f64,
}

/// Numbers of values of a network.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Widths {
    /// Components of the direction of an increment that turn with the axes: 5, or 0 without strain tensors.
    pub direction: usize,
    /// Further components of an increment.
    pub further: usize,
    /// Measured tensors and scalars.
    pub tensors: usize,
    pub scalars: usize,
    /// Start scalars; the first are the measured ones.
    pub start_scalars: usize,
}

impl Widths {
    /// Length, direction and further components.
    pub fn increment(&self) -> usize {
        1 + self.direction + self.further
    }

    pub fn outputs(&self) -> usize {
        COMPONENTS * self.tensors + self.scalars
    }

    pub fn starts(&self) -> usize {
        COMPONENTS * self.tensors + self.start_scalars
    }
}

/// The places of the six components `PREFIX_11` ... among names.
fn tensor(names: &[String], prefix: &str) -> Option<[usize; 6]> {
    let place = |suffix: &str| names.iter().position(|name| *name == format!("{prefix}_{suffix}"));
    let all: Vec<usize> = SUFFIXES.iter().filter_map(|suffix| place(suffix)).collect();
    all.try_into().ok()
}

impl Channels {
    /// For the rows of training runs.
    ///
    /// # Errors
    /// If nothing varies along a run, so that there is no path.
    pub fn fit(columns: &Columns, inputs: &RunInputs, targets: &[f64]) -> Result<Channels> {
        let (names, outputs) = (columns.input_names(), columns.output_names());
        let strains: Vec<usize> =
            STRAINS.iter().filter_map(|name| names.iter().position(|known| known == name)).collect();
        let strain: Option<[usize; 6]> = strains.try_into().ok();
        let has_volume = strain.is_some() && !outputs.iter().any(|name| name == VOLUME);
        let mut taken: Vec<usize> = strain.iter().flatten().copied().collect();
        let mut tensors = Vec::new();
        let mut in_tensors = Vec::new();
        for prefix in outputs.iter().filter_map(|name| name.strip_suffix("_11")) {
            if let Some(places) = tensor(&outputs, prefix).filter(|_| strain.is_some()) {
                let start = tensor(&names, &format!("sample.{prefix}"));
                taken.extend(start.iter().flatten());
                in_tensors.extend(places);
                tensors.push(TensorChannel { outputs: places, start, scale: 1.0, mean: None, offset: None });
            }
        }
        let rows = || targets.chunks_exact(outputs.len());
        let mut scalars = Vec::new();
        for place in (0..outputs.len()).filter(|place| !in_tensors.contains(place)) {
            let start = names.iter().position(|name| *name == format!("sample.{}", outputs[place]));
            taken.extend(start);
            let scale = moments(rows().map(|row| row[place]));
            scalars.push(ScalarChannel { source: Source::Output(place), start, scale, first: 0.0 });
        }
        for (number, channel) in tensors.iter_mut().enumerate() {
            let tensors = rows().map(|row| six(row, &channel.outputs));
            channel.offset = offset_of(tensors.clone().map(|tensor| parts(tensor).1));
            let squares =
                tensors.clone().map(|tensor| channel.deviator(tensor).iter().map(|c| c * c).sum::<f64>());
            let mean_square = squares.sum::<f64>() / (COMPONENTS * rows().count()) as f64;
            let scale = moments(tensors.map(|tensor| channel.mean_part(tensor)));
            channel.scale = if mean_square > 0.0 { mean_square.sqrt() } else { 1.0 };
            if channel.offset.is_none() && scale[1] < CONSTANT * scale[0].abs() {
                channel.mean = Some(scale[0]);
            } else {
                scalars.push(ScalarChannel {
                    source: Source::MeanOf(number),
                    start: None,
                    scale,
                    first: 0.0,
                });
            }
        }
        let mut found = Channels {
            strain,
            has_volume,
            varying: Vec::new(),
            length: 1.0,
            start: Vec::new(),
            tensors,
            scalars,
        };
        found.first_values(inputs, targets, outputs.len());
        found.increments_and_starts(inputs, &taken)?;
        Ok(found)
    }

    /// Where no input has the value of a scalar before the first row, it is the mean of the first values: zero for a strain.
    fn first_values(&mut self, inputs: &RunInputs, targets: &[f64], outputs: usize) {
        let mut firsts = Vec::new();
        let mut row = 0;
        for length in inputs.lengths() {
            firsts.push(&targets[row * outputs..(row + 1) * outputs]);
            row += length;
        }
        for k in 0..self.scalars.len() {
            let values = firsts.iter().map(|row| self.value(&self.scalars[k].source, row));
            let mean = values.sum::<f64>() / firsts.len().max(1) as f64;
            let is_strain = match self.scalars[k].source {
                Source::Output(_) => self.strain.is_some() && mean.abs() < 0.1 * self.scalars[k].scale[1],
                Source::MeanOf(_) => false,
            };
            self.scalars[k].first = if is_strain { 0.0 } else { mean };
        }
    }

    fn value(&self, source: &Source, row: &[f64]) -> f64 {
        match source {
            Source::Output(place) => row[*place],
            Source::MeanOf(number) => {
                let channel = &self.tensors[*number];
                channel.mean_part(six(row, &channel.outputs))
            }
        }
    }

    /// The scalar of a channel before the first row of a run, before it is scaled.
    fn first_value(&self, channel: &ScalarChannel, row: &[f64]) -> f64 {
        match (channel.start, self.sample_of_mean(channel)) {
            (Some(place), _) => row[place],
            (None, Some((tensor, places))) => tensor.mean_part(six(row, &places)),
            (None, None) => channel.first,
        }
    }

    /// The tensor of which a scalar is the mean part, and the inputs with its components before the first row, if the mean part varies by much.
    pub(super) fn sample_of_mean(&self, channel: &ScalarChannel) -> Option<(&TensorChannel, [usize; 6])> {
        let Source::MeanOf(number) = channel.source else { return None };
        let tensor = &self.tensors[number];
        tensor.offset.and(tensor.start).map(|places| (tensor, places))
    }

    fn increments_and_starts(&mut self, inputs: &RunInputs, taken: &[usize]) -> Result<()> {
        let columns = inputs.columns();
        for place in (0..columns).filter(|place| !taken.contains(place)) {
            let varies = |run: &[f64]| run.chunks_exact(columns).any(|row| row[place] != run[place]);
            if inputs.runs().any(varies) {
                let (mut sum, mut count) = (0.0, 0);
                for run in inputs.runs() {
                    for pair in run.chunks_exact(columns).collect::<Vec<_>>().windows(2) {
                        let change = pair[1][place] - pair[0][place];
                        sum += change * change;
                        count += 1;
                    }
                }
                self.varying.push((place, (sum / f64::from(count.max(1))).sqrt()));
            }
            let scale = moments(inputs.runs().map(|run| run[place]).collect::<Vec<_>>().into_iter());
            self.start.push((place, scale));
        }
        if self.strain.is_none() && self.varying.is_empty() {
            let reason = "no input varies along a run, so that there is no path";
            return Err(LearnError::Dataset(reason.into()));
        }
        let mut lengths = Vec::new();
        for run in inputs.runs() {
            self.each_increment(run, columns, |increment| lengths.push(norm(&increment)));
        }
        let moved: Vec<f64> = lengths.into_iter().filter(|length| *length > 0.0).collect();
        if !moved.is_empty() {
            self.length = moved.iter().sum::<f64>() / moved.len() as f64;
        }
        Ok(())
    }

    /// The increments that lead to the rows of a run. Strains count from the sample; what else varies has no increment to the first row.
    fn each_increment(&self, run: &[f64], columns: usize, mut visit: impl FnMut(Vec<f64>)) {
        let mut before: Option<&[f64]> = None;
        for row in run.chunks_exact(columns) {
            visit(self.increment(before, row));
            before = Some(row);
        }
    }

    /// The increment that leads to a row from the one before.
    pub fn increment(&self, before: Option<&[f64]>, row: &[f64]) -> Vec<f64> {
        let mut increment = Vec::new();
        if let Some(places) = &self.strain {
            let strain = |row: &[f64]| {
                let [xx, yy, zz, yz, zx, xy] = six(row, places);
                parts([xx, yy, zz, 0.5 * yz, 0.5 * zx, 0.5 * xy])
            };
            let ((now, volume), (last, last_volume)) =
                (strain(row), before.map_or(([0.0; COMPONENTS], 0.0), strain));
            increment.extend((0..COMPONENTS).map(|c| now[c] - last[c]));
            if self.has_volume {
                increment.push(3f64.sqrt() * (volume - last_volume));
            }
        }
        for (place, scale) in &self.varying {
            increment.push(before.map_or(0.0, |before| (row[*place] - before[*place]) / scale));
        }
        increment
    }

    pub fn widths(&self) -> Widths {
        let direction = if self.strain.is_some() { COMPONENTS } else { 0 };
        Widths {
            direction,
            further: usize::from(self.has_volume) + self.varying.len(),
            tensors: self.tensors.len(),
            scalars: self.scalars.len(),
            start_scalars: self.scalars.len() + self.start.len(),
        }
    }

    /// For each row the length of the increment that leads to it and its direction, of norm one.
    pub fn increments(&self, inputs: &RunInputs) -> Vec<f64> {
        let mut values = Vec::new();
        for run in inputs.runs() {
            self.each_increment(run, inputs.columns(), |increment| values.extend(self.scaled(increment)));
        }
        values
    }

    /// The length of an increment and its direction.
    pub fn scaled(&self, increment: Vec<f64>) -> Vec<f64> {
        let length = norm(&increment) / self.length;
        let moves = length > LEAST;
        let mut values = vec![if moves { MEAN_LENGTH * length } else { 0.0 }];
        let part = |c: f64| if moves { c / (length * self.length) } else { 0.0 };
        values.extend(increment.into_iter().map(part));
        values
    }

    /// How far the path of each run is at each row: its length, and the largest distance from its start so far; in units of strain where it is one.
    pub fn path(&self, inputs: &RunInputs) -> PathPlaces {
        let mut places = PathPlaces { samples: self.samples(inputs), ..PathPlaces::default() };
        for (number, run) in inputs.runs().enumerate() {
            let mut place = PathPlace::default();
            self.each_increment(run, inputs.columns(), |increment| {
                place.advance(&increment);
                places.run.push(number);
                places.length.push(place.length);
                places.farthest.push(place.farthest);
            });
        }
        places
    }

    /// The values that describe the sample of each run, without directions: the scalars among its start values.
    pub fn samples(&self, inputs: &RunInputs) -> Vec<Vec<f64>> {
        let widths = self.widths();
        let scalars = |starts: &[f64]| starts[COMPONENTS * widths.tensors..].to_vec();
        self.starts(inputs).chunks_exact(widths.starts().max(1)).map(scalars).collect()
    }

    /// The start values of each run: tensors, the first component of each, then the second and so on; measured scalars; others.
    pub fn starts(&self, inputs: &RunInputs) -> Vec<f64> {
        let mut values = Vec::new();
        for run in inputs.runs() {
            let row = &run[..inputs.columns()];
            let deviator = |channel: &TensorChannel| match &channel.start {
                Some(places) => channel.deviator(six(row, places)),
                None => [0.0; COMPONENTS],
            };
            let deviators: Vec<_> = self.tensors.iter().map(deviator).collect();
            values.extend((0..COMPONENTS).flat_map(|c| deviators.iter().map(move |own| own[c])));
            let scalar = |channel: &ScalarChannel| {
                (self.first_value(channel, row) - channel.scale[0]) / channel.scale[1]
            };
            values.extend(self.scalars.iter().map(scalar));
            values
                .extend(self.start.iter().map(|(place, [mean, deviation])| (row[*place] - mean) / deviation));
        }
        values
    }

    /// Rows of outputs as tensors and scalars in the units of networks.
    pub fn measured(&self, rows: &[f64], outputs: usize) -> Vec<f64> {
        let mut values = Vec::new();
        for row in rows.chunks_exact(outputs) {
            let deviator = |channel: &TensorChannel| channel.deviator(six(row, &channel.outputs));
            let deviators: Vec<_> = self.tensors.iter().map(deviator).collect();
            values.extend((0..COMPONENTS).flat_map(|c| deviators.iter().map(move |own| own[c])));
            let scalar = |channel: &ScalarChannel| {
                (self.value(&channel.source, row) - channel.scale[0]) / channel.scale[1]
            };
            values.extend(self.scalars.iter().map(scalar));
        }
        values
    }

    /// The opposite of [`Channels::measured`].
    pub fn outputs(&self, values: &[f64], outputs: usize) -> Vec<f64> {
        let width = self.widths().outputs();
        let mut rows = Vec::new();
        for own in values.chunks_exact(width) {
            let mut row = vec![0.0; outputs];
            let constant = |channel: &TensorChannel| [channel.mean.unwrap_or(0.0), 1.0];
            let mut means: Vec<[f64; 2]> = self.tensors.iter().map(constant).collect();
            let scalars = &own[COMPONENTS * self.tensors.len()..];
            for (channel, value) in self.scalars.iter().zip(scalars) {
                let value = channel.scale[0] + channel.scale[1] * value;
                match channel.source {
                    Source::Output(place) => row[place] = value,
                    Source::MeanOf(number) => means[number] = self.tensors[number].mean_and_unit(value),
                }
            }
            for (number, channel) in self.tensors.iter().enumerate() {
                let [mean, unit] = means[number];
                let c = std::array::from_fn(|c| channel.scale * own[c * self.tensors.len() + number] * unit);
                for (place, value) in channel.outputs.iter().zip(whole(c, mean)) {
                    row[*place] = value;
                }
            }
            rows.extend(row);
        }
        rows
    }

    /// By what the errors of each output of a row are divided before they are compared with those of other rows: for the components of a tensor whose mean part varies
    /// by much, that mean part of the row; for all else one.
    pub fn units(&self, row: &[f64]) -> Vec<f64> {
        let mut units = vec![1.0; row.len()];
        for channel in &self.tensors {
            let unit = channel.unit(six(row, &channel.outputs));
            channel.outputs.iter().for_each(|place| units[*place] = unit);
        }
        units
    }

    /// Mean norm of an increment.
    pub fn mean_length(&self) -> f64 {
        self.length
    }

    /// True if it can be that of so many inputs and outputs, read from a file.
    pub fn is_whole(&self, inputs: usize, outputs: usize) -> bool {
        let own = self.strain.iter().flatten().chain(self.varying.iter().map(|(place, _)| place));
        let starts = self.start.iter().map(|(place, _)| place);
        let of_tensors = self.tensors.iter().flat_map(|channel| channel.start.iter().flatten());
        let of_scalars = self.scalars.iter().flat_map(|channel| &channel.start);
        let mut of_outputs: Vec<usize> = self.tensors.iter().flat_map(|channel| channel.outputs).collect();
        let sources = self.scalars.iter().filter_map(|channel| match channel.source {
            Source::Output(place) => Some(place),
            Source::MeanOf(_) => None,
        });
        of_outputs.extend(sources);
        of_outputs.sort_unstable();
        let means = self.scalars.iter().all(|channel| match channel.source {
            Source::Output(_) => true,
            Source::MeanOf(number) => number < self.tensors.len(),
        });
        own.chain(starts).chain(of_tensors).chain(of_scalars).all(|place| *place < inputs)
            && of_outputs == (0..outputs).collect::<Vec<_>>()
            && means
            && (self.strain.is_some() || !self.has_volume)
            && self.length > 0.0
    }
}

#[cfg(test)]
mod tests {
    use granum_core::{Column, Table};

    use super::*;
    use crate::dataset::{Dataset, RunStates};
    use crate::surrogate::spec::FitSpec;

    fn dataset() -> Dataset {
        let wave = |phase: f64| (0..6).map(|k| (0.7 * f64::from(k) + phase).sin()).collect::<Vec<f64>>();
        let mut columns: Vec<Column> = STRAINS
            .iter()
            .enumerate()
            .map(|(k, name)| {
                Column::new(*name, "", (0..6).map(|row| 1e-3 * f64::from(row * (k as i32 - 2))).collect())
            })
            .collect();
        columns.extend(
            SUFFIXES
                .iter()
                .enumerate()
                .map(|(k, suffix)| Column::new(format!("stress_{suffix}"), "Pa", wave(k as f64))),
        );
        columns.push(Column::new("volumetric_strain", "", wave(0.1)));
        let run = RunStates::new("run", Table::new(columns).unwrap()).unwrap();
        Dataset::new(vec![run.with_parameter("sample.void_ratio", "", 0.7).unwrap()]).unwrap()
    }

    #[test]
    fn strains_and_tensors_are_found_and_come_back() {
        let dataset = dataset();
        let stresses = SUFFIXES.map(|suffix| format!("stress_{suffix}"));
        let inputs = STRAINS.map(String::from).into_iter().chain(["sample.void_ratio".into()]);
        let spec = FitSpec::new(inputs, stresses.into_iter().chain([VOLUME.to_string()]));
        let columns = spec.columns(&dataset).unwrap();
        let inputs = RunInputs::from_dataset(&dataset, &columns).unwrap();
        let targets = dataset.values(&columns.output_names()).unwrap();
        let channels = Channels::fit(&columns, &inputs, &targets).unwrap();
        // The mean stress varies and is a scalar; the volume is an output and no part of the increment.
        let expected = Widths { direction: 5, further: 0, tensors: 1, scalars: 2, start_scalars: 3 };
        assert_eq!(channels.widths(), expected);
        let measured = channels.measured(&targets, 7);
        assert_eq!(measured.len(), 6 * expected.outputs());
        let back = channels.outputs(&measured, 7);
        assert!(back.iter().zip(&targets).all(|(ours, exact)| (ours - exact).abs() < 1e-13));
        // All increments but the first have the same length and a direction of norm one.
        let increments = channels.increments(&inputs);
        assert_eq!(increments[..6], [0.0; 6]);
        for row in increments.chunks(6).skip(1) {
            assert!((row[0] - 0.1).abs() < 1e-12 && (norm(&row[1..]) - 1.0).abs() < 1e-12, "{row:?}");
        }
        let without_strain = Channels { strain: None, has_volume: true, ..channels.clone() };
        assert!(!without_strain.is_whole(7, 7));
        assert!(channels.is_whole(7, 7) && !channels.is_whole(6, 7) && !channels.is_whole(7, 8));
        // Where the volume is no output, it is prescribed.
        let spec = FitSpec::new(STRAINS, SUFFIXES.map(|suffix| format!("stress_{suffix}")));
        let columns = spec.columns(&dataset).unwrap();
        let inputs = RunInputs::from_dataset(&dataset, &columns).unwrap();
        let targets = dataset.values(&columns.output_names()).unwrap();
        assert_eq!(Channels::fit(&columns, &inputs, &targets).unwrap().widths().further, 1);
    }
}
