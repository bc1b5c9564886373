//! Rows for training from records, and the split of the data.
//!
//! Of the states of a training run, the first and then every n-th (n is the stride) are used for training, and those in
//! between are held out. With the default recording (a state every 0.0025 of deviator strain) and a stride of 2, the 60
//! training states are at 0.0025, 0.0075, ..., 0.2975, with the last one at the end of the tables of the paper. All
//! held-out states except the very last lie between training states. Unseen runs, which have other seeds, are used neither
//! for training nor for the choice of any setting.
//!
//! State 0, the sample before it is strained, is recorded but not learned: with stiff grains the elastic rise of q/p is
//! complete after a strain of about 1e-3, between state 0 and state 1, so that the record contains no information on it.
//!
//! Of the force histogram, 14 bins of width 0.25 are learned, f = 0 to 3.5. With 60 training states this gives the about 840
//! rows of the paper. Larger forces (a few contacts in a thousand) and negative ones (adhesive contacts) are recorded but
//! not learned.

use granum_nets::Data;
use serde::{Deserialize, Serialize};

use crate::mapping::{Form, Mapping, Quantity};
use granum_learn::dataset::{ColumnGroup, Dataset, NamedRecord, RunStates, record_error};
use granum_learn::{LearnError, Result};

/// Options of a data set.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyDataOptions {
    /// Of this number of successive states one is used for training, and the others are held out.
    pub stride: usize,
    /// Lower edge of the first bin of f that is learned.
    pub smallest_force: f64,
    /// Upper edge of the last bin of f that is learned.
    pub largest_force: f64,
}

impl Default for StudyDataOptions {
    fn default() -> Self {
        StudyDataOptions { stride: 2, smallest_force: 0.0, largest_force: 3.5 }
    }
}

/// One recorded state of a test with the quantities of the mappings.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct State {
    /// Deviator strain.
    pub strain: f64,
    /// Stress ratio q/p.
    pub stress_ratio: f64,
    /// Deviator fabric phi_d.
    pub deviator_fabric: f64,
    /// Probability density of f in each learned bin.
    pub densities: Vec<f64>,
}

impl State {
    /// The value or values of a quantity.
    pub fn values(&self, quantity: Quantity) -> &[f64] {
        match quantity {
            Quantity::DeviatorStrain => std::slice::from_ref(&self.strain),
            Quantity::StressRatio => std::slice::from_ref(&self.stress_ratio),
            Quantity::DeviatorFabric => std::slice::from_ref(&self.deviator_fabric),
            Quantity::ForceDistribution => &self.densities,
        }
    }

    /// Linear interpolation between two states: `a` for a weight of 0, `b` for a weight of 1.
    pub fn between(a: &State, b: &State, weight: f64) -> State {
        let mix = |x: f64, y: f64| x + weight * (y - x);
        State {
            strain: mix(a.strain, b.strain),
            stress_ratio: mix(a.stress_ratio, b.stress_ratio),
            deviator_fabric: mix(a.deviator_fabric, b.deviator_fabric),
            densities: a.densities.iter().zip(&b.densities).map(|(&x, &y)| mix(x, y)).collect(),
        }
    }
}

/// The states of one run in the order of increasing strain.
#[derive(Clone, Debug, PartialEq)]
pub struct Run {
    /// Name of the run.
    pub name: String,
    /// Seed of the sample.
    pub seed: u64,
    /// The states.
    pub states: Vec<State>,
    /// Number of each state in the record.
    pub numbers: Vec<u64>,
}

impl Run {
    /// The states of a record except state 0, with the densities in the bins of f with the given centres and width.
    ///
    /// # Errors
    /// If a column is missing, a value is not finite, the strains do not increase, or a histogram lacks one of the bins.
    pub fn new(record: &NamedRecord, forces: &[f64], bin_width: f64) -> Result<Run> {
        Run::of(&RunStates::from_record(record)?, forces, bin_width)
    }

    /// As [`Run::new`], from the columns of a run.
    ///
    /// # Errors
    /// As [`Run::new`].
    pub fn of(run: &RunStates, forces: &[f64], bin_width: f64) -> Result<Run> {
        read_run(run, forces, bin_width)
    }

    /// The state at a strain by linear interpolation between recorded states; outside their range the first or last state.
    pub fn at(&self, strain: f64) -> Option<State> {
        state_at(&self.states, strain)
    }
}

/// The state at a strain by linear interpolation between states of increasing strain; outside their range the first or last
/// state.
pub(crate) fn state_at(states: &[State], strain: f64) -> Option<State> {
    let after = states.partition_point(|state| state.strain < strain);
    if after == 0 {
        return states.first().cloned();
    }
    let (a, Some(b)) = (&states[after - 1], states.get(after)) else {
        return states.last().cloned();
    };
    Some(State::between(a, b, (strain - a.strain) / (b.strain - a.strain)))
}

/// States for training and evaluation, all with the same bins of f.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyData {
    /// Centres of the learned bins of f.
    pub forces: Vec<f64>,
    /// Width of a bin.
    pub bin_width: f64,
    /// Runs whose states are used for training or held out.
    pub training_runs: Vec<Run>,
    /// Runs that are used neither for training nor for selection.
    pub unseen_runs: Vec<Run>,
    /// Of this number of successive states one is used for training.
    pub stride: usize,
}

impl StudyData {
    /// Creates a data set from records.
    ///
    /// # Errors
    /// If there is no training record, a column is missing, a value is not finite, the strains do not increase, or the
    /// histograms have different bins or none in the given range.
    pub fn new(training: &[NamedRecord], unseen: &[NamedRecord], options: &StudyDataOptions) -> Result<Self> {
        let columns = |records: &[NamedRecord]| -> Result<Vec<RunStates>> {
            records.iter().map(RunStates::from_record).collect()
        };
        StudyData::of(&columns(training)?, &columns(unseen)?, options)
    }

    /// Creates the data from the columns of runs, which are selected by name.
    ///
    /// # Errors
    /// As [`StudyData::new`].
    pub fn of(training: &[RunStates], unseen: &[RunStates], options: &StudyDataOptions) -> Result<Self> {
        let first =
            training.first().ok_or_else(|| LearnError::Dataset("there is no training run".to_owned()))?;
        if options.stride == 0 {
            return Err(LearnError::Dataset(
                "the stride of training states must be 1 or more, not 0".to_owned(),
            ));
        }
        let (forces, bin_width) = learned_bins(first, options)?;
        let runs = |runs: &[RunStates]| -> Result<Vec<Run>> {
            runs.iter().map(|run| read_run(run, &forces, bin_width)).collect()
        };
        let (training_runs, unseen_runs) = (runs(training)?, runs(unseen)?);
        Ok(StudyData { training_runs, unseen_runs, forces, bin_width, stride: options.stride })
    }

    /// Uses all states of a data set for training, as in the fit of a surrogate.
    ///
    /// # Errors
    /// As [`StudyData::new`].
    pub fn all_training(dataset: &Dataset) -> Result<Self> {
        StudyData::of(dataset.runs(), &[], &StudyDataOptions { stride: 1, ..Default::default() })
    }

    /// True if the state of the given number in the record of a training run is used for training.
    pub fn trains(&self, number: u64) -> bool {
        number % self.stride as u64 == 1 % self.stride as u64
    }

    /// The training states of each run.
    pub fn training_by_run(&self) -> Vec<Vec<&State>> {
        let of = |run: &'_ Run| -> Vec<usize> {
            (0..run.states.len()).filter(|&k| self.trains(run.numbers[k])).collect()
        };
        self.training_runs.iter().map(|run| of(run).into_iter().map(|k| &run.states[k]).collect()).collect()
    }

    fn part(&self, trains: bool) -> Vec<&State> {
        self.training_runs
            .iter()
            .flat_map(|run| run.states.iter().zip(&run.numbers))
            .filter(|&(_, &number)| self.trains(number) == trains)
            .map(|(state, _)| state)
            .collect()
    }

    /// The training states of all runs.
    pub fn training(&self) -> Vec<&State> {
        self.part(true)
    }

    /// The held-out states of the training runs.
    pub fn held_out(&self) -> Vec<&State> {
        self.part(false)
    }

    /// The states of the unseen runs.
    pub fn unseen(&self) -> Vec<&State> {
        self.unseen_runs.iter().flat_map(|run| &run.states).collect()
    }

    /// A hash of all values and of the split.
    ///
    /// # Errors
    /// [`LearnError::Dataset`] if there are no states.
    pub fn hash(&self) -> Result<String> {
        let mut rows = Vec::new();
        let mut parts = Vec::new();
        for (part, states) in [self.training(), self.held_out(), self.unseen()].into_iter().enumerate() {
            for state in states {
                rows.extend([state.strain, state.stress_ratio, state.deviator_fabric]);
                rows.extend(&state.densities);
                parts.push(part as f64);
            }
        }
        rows.extend([self.bin_width, self.stride as f64, 0.0]);
        rows.extend(&self.forces);
        parts.push(3.0);
        let data = Data::new(rows, 3 + self.forces.len(), parts);
        data.map(|data| data.hash()).map_err(|error| LearnError::Dataset(error.to_string()))
    }
}

/// Inputs and targets of a network in physical units.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rows {
    /// Inputs in row-major order.
    pub inputs: Vec<f64>,
    /// Number of inputs in a row.
    pub input_columns: usize,
    /// One target per row.
    pub targets: Vec<f64>,
}

impl Rows {
    /// The rows of a mapping for given states.
    pub fn new<'a>(
        mapping: &Mapping,
        form: Form,
        forces: &[f64],
        states: impl IntoIterator<Item = &'a State>,
    ) -> Self {
        let input_columns = mapping.network_inputs(form, forces).len();
        let mut rows = Rows { input_columns, ..Default::default() };
        for state in states {
            rows.push_state(mapping, form, forces, state);
        }
        rows
    }

    fn push_state(&mut self, mapping: &Mapping, form: Form, forces: &[f64], state: &State) {
        let targets = state.values(mapping.output);
        let rows = if mapping.has_point_rows(form) { forces.len() } else { 1 };
        for row in 0..rows {
            for &input in &mapping.inputs {
                if input == Quantity::ForceDistribution && form == Form::Point {
                    self.inputs.extend([forces[row], state.densities[row]]);
                } else {
                    self.inputs.extend(state.values(input));
                }
            }
            if mapping.output == Quantity::ForceDistribution {
                self.inputs.push(forces[row]);
                self.targets.push(targets[row]);
            } else {
                self.targets.extend(targets);
            }
        }
    }

    /// Number of rows.
    pub fn count(&self) -> usize {
        self.targets.len()
    }
}

/// The bins of a run that lie in the given range.
fn learned_bins(run: &RunStates, options: &StudyDataOptions) -> Result<(Vec<f64>, f64)> {
    let histogram = histogram(run)?;
    let slack = 1e-6 * histogram.bin_width;
    let half = 0.5 * histogram.bin_width;
    let (low, high) = (options.smallest_force, options.largest_force);
    let wanted = |f: &f64| f - half >= low - slack && f + half <= high + slack;
    let forces: Vec<f64> = histogram.centres.iter().copied().filter(wanted).collect();
    if forces.is_empty() {
        let reason = format!("its histogram has no bin of f between {low} and {high}");
        return Err(record_error(run.name(), reason));
    }
    Ok((forces, histogram.bin_width))
}

fn histogram(run: &RunStates) -> Result<&ColumnGroup> {
    let none = || record_error(run.name(), "it has no state with a histogram of contact forces");
    run.group(Quantity::ForceDistribution.column()).ok_or_else(none)
}

/// The columns of the learned bins of f, in order.
fn densities(run: &RunStates, forces: &[f64], bin_width: f64) -> Result<Vec<Vec<f64>>> {
    let histogram = histogram(run)?;
    let near = |force: &f64| {
        histogram.centres.iter().find(|centre| (force - **centre).abs() < 1e-6 * bin_width).copied()
    };
    let centres: Option<Vec<f64>> = forces.iter().map(near).collect();
    match centres {
        Some(centres) if (histogram.bin_width - bin_width).abs() <= 1e-9 * bin_width => {
            centres.iter().map(|centre| run.column(&histogram.column(*centre))).collect()
        }
        _ => {
            let reason = "its histogram does not have the bins of f that the networks learn";
            Err(record_error(run.name(), format!("{reason}; record with bins of width {bin_width}")))
        }
    }
}

fn read_run(run: &RunStates, forces: &[f64], bin_width: f64) -> Result<Run> {
    if run.column("stage")?.iter().any(|stage| *stage > 1.0) {
        let reason = "it is a test of several stages; the study of Antony, Zhou and Wang learns from tests of one stage, in \
                      which the deviator strain increases";
        return Err(record_error(run.name(), reason));
    }
    let numbers = run.column("state")?;
    let [strains, ratios, fabrics] =
        [Quantity::DeviatorStrain, Quantity::StressRatio, Quantity::DeviatorFabric]
            .map(|q| run.column(q.column()));
    let (strains, ratios, fabrics) = (strains?, ratios?, fabrics?);
    let densities = densities(run, forces, bin_width)?;
    let mut states: Vec<State> = Vec::with_capacity(numbers.len());
    for k in 0..numbers.len() {
        let state = State {
            strain: strains[k],
            stress_ratio: ratios[k],
            deviator_fabric: fabrics[k],
            densities: densities.iter().map(|column| column[k]).collect(),
        };
        let values = [state.strain, state.stress_ratio, state.deviator_fabric];
        if values.iter().chain(&state.densities).any(|value| !value.is_finite()) {
            let reason = format!("state {k} contains a value that is not a finite number");
            return Err(record_error(run.name(), reason));
        }
        if numbers[k] == 0.0 {
            continue;
        }
        if states.last().is_some_and(|before| before.strain >= state.strain) {
            let reason = "the deviator strain must increase from state to state";
            let message = format!("state {k}: {reason}, but is {} here", state.strain);
            return Err(record_error(run.name(), message));
        }
        states.push(state);
    }
    let numbers = numbers.iter().filter(|&&number| number != 0.0).map(|&number| number as u64).collect();
    let seed = run.parameter(granum_io::case::SEED).unwrap_or(0.0) as u64;
    Ok(Run { name: run.name().to_owned(), seed, states, numbers })
}

#[cfg(test)]
mod tests {
    use granum_sensors::Record;

    use super::*;
    use crate::mapping::paper_mapping;
    use crate::synthetic::{Law, record};

    fn named(record: &Record) -> NamedRecord<'_> {
        NamedRecord { name: "training", seed: 1, record }
    }

    #[test]
    fn the_papers_recording_gives_about_840_rows_and_a_clean_split() {
        let training = record(Law::Plain, 1, 120);
        let unseen = record(Law::Plain, 2, 120);
        let dataset =
            StudyData::new(&[named(&training)], &[named(&unseen)], &StudyDataOptions::default()).unwrap();
        assert_eq!(dataset.forces.len(), 14);
        assert_eq!((dataset.forces[0], dataset.forces[13]), (0.125, 3.375));
        assert_eq!(dataset.training().len(), 60);
        assert_eq!(dataset.held_out().len(), 60);
        assert_eq!(dataset.unseen().len(), 120);
        let f1 = paper_mapping("F1").unwrap();
        let rows = Rows::new(&f1, Form::Point, &dataset.forces, dataset.training());
        assert_eq!((rows.count(), rows.input_columns), (840, 3));
        let spacing = dataset.training()[1].strain - dataset.training()[0].strain;
        assert!(spacing < 0.0051, "{spacing}");
        let trained: Vec<f64> = dataset.training().iter().map(|state| state.strain).collect();
        assert!((trained[0] - 0.0025).abs() < 1e-12 && (trained[59] - 0.2975).abs() < 1e-12);
        let held_out = dataset.held_out();
        assert!(held_out.iter().all(|state| !trained.contains(&state.strain)));
        assert!(held_out[..59].iter().all(|state| trained[0] < state.strain && state.strain < trained[59]));
    }

    #[test]
    fn rows_carry_what_the_mapping_reads() {
        let training = record(Law::Plain, 1, 20);
        let dataset = StudyData::new(&[named(&training)], &[], &StudyDataOptions::default()).unwrap();
        let state = dataset.training()[3];
        let f3 = Rows::new(&paper_mapping("F3").unwrap(), Form::Point, &dataset.forces, [state]);
        let bin = 5;
        let row = &f3.inputs[bin * 4..][..4];
        assert_eq!(row, [state.strain, state.deviator_fabric, dataset.forces[bin], state.densities[bin]]);
        assert_eq!(f3.targets, vec![state.stress_ratio; 14]);
        let f2 = Rows::new(&paper_mapping("F2").unwrap(), Form::Point, &dataset.forces, [state]);
        assert_eq!(&f2.inputs[bin * 3..][..3], [state.strain, state.stress_ratio, dataset.forces[bin]]);
        assert_eq!(f2.targets, state.densities);
        let f6 = Rows::new(&paper_mapping("F6").unwrap(), Form::Histogram, &dataset.forces, [state]);
        assert_eq!((f6.count(), f6.input_columns), (1, 15));
        let f4 = Rows::new(&paper_mapping("F4").unwrap(), Form::Histogram, &dataset.forces, [state]);
        assert_eq!((f4.count(), f4.input_columns), (14, 3));
        assert_eq!(f4.targets, state.densities);
        let alone =
            Rows::new(&paper_mapping("F1").unwrap().strain_only(), Form::Point, &dataset.forces, [state]);
        assert_eq!((alone.count(), alone.inputs), (1, vec![state.strain]));
    }

    fn change(record: &mut Record, name: &str, change: impl Fn(&mut [f64])) {
        let mut values = record.series.column(name).unwrap().to_vec();
        change(&mut values);
        record.series.set(granum_core::Column::new(name, "", values)).unwrap();
    }

    #[test]
    fn the_hash_sees_every_number_and_the_split() {
        let training = record(Law::Plain, 1, 20);
        let hash = |record: &Record, stride: usize| {
            let options = StudyDataOptions { stride, ..Default::default() };
            StudyData::new(&[named(record)], &[], &options).unwrap().hash().unwrap()
        };
        assert_eq!(hash(&training, 2), hash(&training, 2));
        assert_ne!(hash(&training, 2), hash(&training, 3));
        let mut other = training.clone();
        change(&mut other, "stress_ratio", |values| values[7] = f64::from_bits(values[7].to_bits() + 1));
        assert_ne!(hash(&training, 2), hash(&other, 2));
    }

    #[test]
    fn unusable_records_are_refused_with_their_name_and_reason() {
        let training = record(Law::Plain, 1, 20);
        let message = |change: &dyn Fn(&mut Record)| {
            let mut broken = training.clone();
            change(&mut broken);
            let options = StudyDataOptions::default();
            StudyData::new(
                &[named(&training)],
                &[NamedRecord { name: "other", seed: 2, record: &broken }],
                &options,
            )
            .unwrap_err()
            .to_string()
        };
        let text = message(&|record| drop(record.series.remove("deviator_fabric")));
        assert_eq!(text, "record `other`: there is no column deviator_fabric; did you mean deviator_strain?");
        let text = message(&|record| record.histograms[0].states[4].bin_width = 0.2);
        assert!(
            text.starts_with(
                "record `other`: histogram forces: state 4: its histogram does not have the bins"
            ),
            "{text}"
        );
        let text = message(&|record| {
            change(record, "deviator_strain", |values| values[9] = values[3]);
        });
        assert!(text.contains("state 9: the deviator strain must increase"), "{text}");
        let text = message(&|record| {
            change(record, "stress_ratio", |values| values[2] = f64::NAN);
        });
        assert!(text.contains("state 2 contains a value that is not a finite number"), "{text}");
        let text = StudyData::new(&[], &[], &StudyDataOptions::default()).unwrap_err().to_string();
        assert_eq!(text, "data set: there is no training run");
    }

    #[test]
    fn a_run_is_linear_between_its_states() {
        let training = record(Law::Plain, 1, 20);
        let dataset = StudyData::new(&[named(&training)], &[], &StudyDataOptions::default()).unwrap();
        let run = &dataset.training_runs[0];
        let (a, b) = (&run.states[4], &run.states[5]);
        let middle = run.at(0.5 * (a.strain + b.strain)).unwrap();
        assert!((middle.stress_ratio - 0.5 * (a.stress_ratio + b.stress_ratio)).abs() < 1e-12);
        assert_eq!(run.at(-1.0).as_ref(), run.states.first());
        assert_eq!(run.at(9.0).as_ref(), run.states.last());
    }
}
