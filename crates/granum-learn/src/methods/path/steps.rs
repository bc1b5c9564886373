//! Networks with a state along a path whose rows come one after the other.

use std::collections::VecDeque;
use std::sync::Arc;

use granum_nets::{Differentiable, Isa, MOST_SEQUENCES, Stepper};

use super::fitted::FittedPath;
use super::growth::{PathPlace, PathPlaces};
use super::rotation::Rotation;
use super::runs::PathRuns;
use crate::error::Result;
use crate::surrogate::prediction::Prediction;
use crate::surrogate::run_inputs::RunInputs;
use crate::surrogate::run_memory::RunMemory;
use crate::surrogate::run_steps::RunSteps;

/// The networks with their states, in each of the rotations, and how far the path is.
pub(super) struct PathSteps {
    fitted: Arc<FittedPath>,
    /// The factors of intervals for each output, if there are intervals.
    factors: Option<Vec<f64>>,
    /// `None` leaves the axes as they are.
    rotations: Vec<Option<Rotation>>,
    /// `None` before a row was predicted.
    run: Option<Run>,
    /// Those of the last question for several rows.
    ahead: Option<Ahead>,
}

/// What is kept of the rows before the next one.
struct Run {
    /// For each network its states in all rotations.
    steppers: Vec<Box<dyn Stepper>>,
    /// The values that describe the sample, and how large errors are for it.
    sample: Vec<f64>,
    sizes: Vec<Vec<f64>>,
    /// The row before; `None` before the first one.
    before: Option<Vec<f64>>,
    place: PathPlace,
    /// The last increments with their directions, as many as a network sees.
    increments: VecDeque<Vec<f64>>,
    /// The row that was predicted last, with its increment and place.
    next: Option<(Vec<f64>, Vec<f64>, PathPlace)>,
}

/// Networks that advance several possible next rows at once, so many that the registers of a processor are full.
struct Ahead {
    rows: usize,
    steppers: Vec<Box<dyn Stepper>>,
}

impl PathSteps {
    pub fn new(fitted: Arc<FittedPath>, level: f64) -> PathSteps {
        let factors = fitted.errors.as_ref().map(|errors| errors.factors(level));
        let rotations = fitted.rotations();
        PathSteps { fitted, factors, rotations, run: None, ahead: None }
    }

    /// The states before the first row of a run.
    fn begin(&self, row: &[f64]) -> Result<Run> {
        let channels = &self.fitted.channels;
        let first = RunInputs::new(row.to_vec(), row.len(), vec![1])?;
        let runs = self.runs(Vec::new(), channels.starts(&first), 0);
        let starts: Vec<f64> = self.turned(&runs).into_iter().flat_map(|runs| runs.starts).collect();
        let sample = channels.samples(&first).concat();
        Ok(Run {
            steppers: self.steppers(&starts, 1)?,
            sizes: self.error_sizes(&sample),
            sample,
            before: None,
            place: PathPlace::default(),
            increments: VecDeque::new(),
            next: None,
        })
    }

    /// The networks with their states before the first row of some runs, from the start values in all rotations.
    fn steppers(&self, starts: &[f64], runs: usize) -> Result<Vec<Box<dyn Stepper>>> {
        let stepper = |network: &dyn Differentiable| {
            let stepper = network.stepper(Isa::detect(), runs * self.rotations.len(), starts);
            stepper.map_err(|error| self.fitted.failed(error))
        };
        self.fitted.networks.iter().map(|network| stepper(network.as_ref())).collect()
    }

    /// How large errors are for a sample.
    fn error_sizes(&self, sample: &[f64]) -> Vec<Vec<f64>> {
        let errors = self.fitted.errors.as_ref();
        errors.map_or(Vec::new(), |errors| errors.sizes(&[sample.to_vec()]))
    }

    /// The run that goes on from a memory: the row before, the place on the path, the sample, the last increments, and the state of each network.
    /// `known` is any run, whose networks save making others, and whose sizes of errors are those of the same sample.
    fn resumed(&self, parts: &[Vec<f64>], known: Option<Run>) -> Result<Run> {
        let fitted = &self.fitted;
        let (widths, columns) = (fitted.channels.widths(), fitted.columns.inputs.len());
        let wrong = |what: &str| fitted.failed(format!("this is not a memory of it: {what}"));
        let Some(([before, place, sample, increments], states)) = parts.split_first_chunk::<4>() else {
            return Err(wrong("parts are missing"));
        };
        if !parts[..4].iter().flatten().all(|value| value.is_finite()) {
            return Err(wrong("a number is not finite"));
        }
        let width = widths.increment();
        let kept = increments.len() / width;
        let is_whole = before.len() == columns
            && sample.len() == widths.start_scalars
            && increments.len() == kept * width
            && kept < fitted.sizes.increments_seen()
            && states.len() == fitted.networks.len()
            && states.iter().all(|state| !state.is_empty());
        let place = PathPlace::from_numbers(place, width - 1);
        let Some(place) = place.filter(|_| is_whole) else {
            return Err(wrong("it has other numbers of values"));
        };
        // The start values count for the states before the first row alone, which are replaced.
        let (mut steppers, sizes) = match known {
            Some(run) if run.sample == *sample => (run.steppers, run.sizes),
            Some(run) => (run.steppers, self.error_sizes(sample)),
            None => {
                let starts = vec![0.0; self.rotations.len() * widths.starts()];
                (self.steppers(&starts, 1)?, self.error_sizes(sample))
            }
        };
        for (stepper, state) in steppers.iter_mut().zip(states) {
            stepper.set_state(state).map_err(|error| fitted.failed(error))?;
        }
        Ok(Run {
            steppers,
            sizes,
            sample: sample.clone(),
            before: Some(before.clone()),
            place,
            increments: increments.chunks_exact(width).map(<[f64]>::to_vec).collect(),
            next: None,
        })
    }

    /// One run of some increments.
    fn runs(&self, increments: Vec<f64>, starts: Vec<f64>, length: usize) -> PathRuns {
        let widths = self.fitted.channels.widths();
        PathRuns { widths, increments, starts, targets: Vec::new(), lengths: vec![length] }
    }

    /// The run in each of the rotations.
    fn turned(&self, runs: &PathRuns) -> Vec<PathRuns> {
        let turn = |rotation: &Option<Rotation>| match rotation {
            Some(rotation) => runs.turned(|| rotation.clone()),
            None => runs.clone(),
        };
        self.rotations.iter().map(turn).collect()
    }

    /// The inputs of the networks for the last of the increments, in each of the rotations.
    fn inputs(&self, increments: &[f64], count: usize) -> Vec<f64> {
        let widths = self.fitted.channels.widths();
        if self.rotations == [None] && count == 1 {
            return self.fitted.sizes.inputs(&widths, increments, &[1]);
        }
        let starts = vec![0.0; widths.starts()];
        let runs = self.runs(increments.to_vec(), starts, count);
        let of_last = |runs: PathRuns| {
            let rows = self.fitted.sizes.inputs(&widths, &runs.increments, &runs.lengths);
            rows[rows.len() / count * (count - 1)..].to_vec()
        };
        self.turned(&runs).into_iter().flat_map(of_last).collect()
    }

    /// What each network predicts, as the mean over the rotations, in the units of the outputs: the inputs of some rows in all rotations, one after the other.
    fn outputs(
        &self,
        steppers: &mut [Box<dyn Stepper>],
        inputs: &[f64],
        rows: usize,
    ) -> Result<Vec<Vec<f64>>> {
        let (channels, outputs) = (&self.fitted.channels, self.fitted.columns.outputs.len());
        let widths = channels.widths();
        let mut found = Vec::with_capacity(steppers.len());
        let of_row = self.rotations.len() * widths.outputs();
        let mut values = vec![0.0; rows * of_row];
        for stepper in steppers {
            stepper.predict(inputs, &mut values).map_err(|error| self.fitted.failed(error))?;
            let mut sums = vec![0.0; rows * widths.outputs()];
            for (sum, values) in sums.chunks_exact_mut(widths.outputs()).zip(values.chunks_exact_mut(of_row))
            {
                for (rotation, own) in self.rotations.iter().zip(values.chunks_exact_mut(widths.outputs())) {
                    if let Some(rotation) = rotation {
                        rotation.inverse().turn(own, 0, widths.tensors);
                    }
                    sum.iter_mut().zip(own).for_each(|(sum, value)| *sum += *value);
                }
                sum.iter_mut().for_each(|sum| *sum /= self.rotations.len() as f64);
            }
            found.push(channels.outputs(&sums, outputs));
        }
        Ok(found)
    }

    /// The inputs of the networks for a row after those of a run, in each of the rotations.
    fn inputs_of(&self, run: &Run, row: &[f64]) -> Vec<f64> {
        let channels = &self.fitted.channels;
        let scaled = channels.scaled(channels.increment(run.before.as_deref(), row));
        let increments: Vec<f64> = run.increments.iter().flatten().chain(&scaled).copied().collect();
        self.inputs(&increments, run.increments.len() + 1)
    }

    /// Networks that advance so many rows at once: those of the last question, if there were as many.
    fn ahead_for(&mut self, rows: usize) -> Result<Ahead> {
        match self.ahead.take().filter(|ahead| ahead.rows == rows) {
            Some(ahead) => Ok(ahead),
            None => {
                let starts = self.fitted.channels.widths().starts();
                let starts = vec![0.0; rows * self.rotations.len() * starts];
                Ok(Ahead { rows, steppers: self.steppers(&starts, rows)? })
            }
        }
    }

    /// The means for several rows after those of a run, of which none is accepted.
    fn means_after(&self, run: &Run, rows: &[Vec<f64>], ahead: &mut Ahead) -> Result<Vec<Vec<f64>>> {
        for (stepper, own) in ahead.steppers.iter_mut().zip(&run.steppers) {
            let states = own.state().repeat(rows.len());
            stepper.set_state(&states).map_err(|error| self.fitted.failed(error))?;
        }
        let inputs: Vec<f64> = rows.iter().flat_map(|row| self.inputs_of(run, row)).collect();
        let networks = self.outputs(&mut ahead.steppers, &inputs, rows.len())?;
        let outputs = self.fitted.columns.outputs.len();
        let count = networks.len() as f64;
        let mean = |place: usize| networks.iter().map(|values| values[place]).sum::<f64>() / count;
        let of_row = |row: usize| (0..outputs).map(|output| mean(row * outputs + output)).collect();
        Ok((0..rows.len()).map(of_row).collect())
    }

    fn next_row(&self, run: &mut Run, row: &[f64]) -> Result<Prediction> {
        let channels = &self.fitted.channels;
        let increment = channels.increment(run.before.as_deref(), row);
        let mut place = run.place.clone();
        place.advance(&increment);
        let scaled = channels.scaled(increment);
        let increments: Vec<f64> = run.increments.iter().flatten().chain(&scaled).copied().collect();
        let inputs = self.inputs(&increments, run.increments.len() + 1);
        let networks = self.outputs(&mut run.steppers, &inputs, 1)?;
        let path = PathPlaces {
            length: vec![place.length],
            farthest: vec![place.farthest],
            run: vec![0],
            samples: vec![run.sample.clone()],
        };
        let known = self.factors.as_ref().map(|factors| (factors.as_slice(), run.sizes.as_slice()));
        run.next = Some((row.to_vec(), scaled, place));
        Ok(self.fitted.prediction(&networks, &path, known, (0, row)))
    }
}

impl RunSteps for PathSteps {
    fn predict(&mut self, row: &[f64]) -> Result<Prediction> {
        let mut run = match self.run.take() {
            Some(run) if run.before.is_some() => run,
            // The first row of a run tells of its sample.
            _ => self.begin(row)?,
        };
        let prediction = self.next_row(&mut run, row);
        self.run = Some(run);
        prediction
    }

    fn means_of(&mut self, rows: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
        let Some(run) = self.run.take().filter(|run| run.before.is_some() && !rows.is_empty()) else {
            // Each is the first row of a run, and tells of its own sample.
            let means = |row: &Vec<f64>| -> Result<Vec<f64>> {
                Ok(self.predict(row)?.values.iter().map(|estimate| estimate.mean).collect())
            };
            let means = rows.iter().map(means).collect();
            self.run = None;
            return means;
        };
        let at_once = (MOST_SEQUENCES / self.rotations.len()).max(1);
        let means = rows.chunks(at_once).map(|rows| {
            let mut ahead = self.ahead_for(rows.len())?;
            let means = self.means_after(&run, rows, &mut ahead);
            self.ahead = Some(ahead);
            means
        });
        let means = means.collect::<Result<Vec<_>>>().map(|means| means.concat());
        self.run = Some(Run { next: None, ..run });
        means
    }

    fn accept(&mut self) {
        let seen = self.fitted.sizes.increments_seen();
        let Some(run) = &mut self.run else { return };
        let Some((row, increment, place)) = run.next.take() else { return };
        run.steppers.iter_mut().for_each(|stepper| stepper.accept());
        (run.before, run.place) = (Some(row), place);
        run.increments.push_back(increment);
        while run.increments.len() >= seen {
            run.increments.pop_front();
        }
    }

    fn restart(&mut self) {
        self.run = None;
    }

    fn memory(&self) -> RunMemory {
        let Some(run) = &self.run else { return RunMemory::default() };
        let Some(before) = &run.before else { return RunMemory::default() };
        let increments = run.increments.iter().flatten().copied().collect();
        let parts = [before.clone(), run.place.numbers(), run.sample.clone(), increments];
        let states = run.steppers.iter().map(|stepper| stepper.state());
        RunMemory::new(parts.into_iter().chain(states).collect())
    }

    fn resume(&mut self, memory: &RunMemory) -> Result<()> {
        let known = self.run.take();
        if !memory.is_start() {
            self.run = Some(self.resumed(memory.parts(), known)?);
        }
        Ok(())
    }
}
