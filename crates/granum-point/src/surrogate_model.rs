//! A surrogate with memory as the material of a point: six components of strain in, six of stress out.
//!
//! Its rows are the logarithmic strain since the start, in axes that rotate with the sample, and what describes the sample. The first row is that without strain.
//! Each further part of an increment is a row, whose prediction follows from the memory of the state before it.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

use granum_core::digest::Digest;
use granum_core::geometry::Matrix;
use granum_dem::servo::{PLACES, strain_component};
use granum_learn::surrogate::{Prediction, PredictionStream, RunMemory, Surrogate, to_json};

use crate::error::PointError;
use crate::path_so_far::{STRAINS, STRESSES};
use crate::straining::AveragedStress;
use crate::surrogate_state::SurrogateState;

const VOLUME: &str = "volumetric_strain";
const VOID_RATIO: &str = "sample.void_ratio";
/// Level of the intervals, whose standard deviations alone are used.
const LEVEL: f64 = 0.9;

/// A surrogate and what it is to a material point.
pub(crate) struct SurrogateModel {
    surrogate: Arc<dyn Surrogate>,
    /// The row without strain.
    row: Vec<f64>,
    /// Places of the strains among the inputs, and of the stresses among the outputs.
    strains: [usize; 6],
    stresses: [usize; 6],
    outputs: Arc<[String]>,
    void_ratio: Option<f64>,
    /// Streams that nobody uses at present: any of them goes on from any memory.
    streams: Mutex<Vec<PredictionStream<'static>>>,
}

/// A state of the surrogate with its stress.
pub(crate) type Step = (SurrogateState, AveragedStress);

fn refused(surrogate: &dyn Surrogate, reason: String) -> PointError {
    PointError::NoMaterial { method: surrogate.method().to_string(), reason }
}

/// The places of names among columns.
fn places(names: [&str; 6], columns: &[String]) -> Result<[usize; 6], String> {
    let mut found = [0; 6];
    for (place, name) in found.iter_mut().zip(names) {
        *place = columns.iter().position(|column| column == name).ok_or(name)?;
    }
    Ok(found)
}

impl SurrogateModel {
    /// A surrogate with the values of its inputs that are no strains.
    ///
    /// # Errors
    /// [`PointError::NoMaterial`] if it is not one from six strains and its sample to six stresses with a memory.
    pub(crate) fn new(
        surrogate: Arc<dyn Surrogate>,
        sample: &BTreeMap<String, f64>,
    ) -> Result<SurrogateModel, PointError> {
        let wrong = |reason: String| refused(surrogate.as_ref(), reason);
        let columns = surrogate.columns();
        let (inputs, outputs) = (columns.input_names(), columns.output_names());
        if !surrogate.has_memory() {
            return Err(wrong(
                "it has no memory: its stress would depend on the strain and not on the path".into(),
            ));
        }
        let strains =
            places(STRAINS, &inputs).map_err(|name| wrong(format!("{name} is not among its inputs")))?;
        let stresses =
            places(STRESSES, &outputs).map_err(|name| wrong(format!("{name} is not among its outputs")))?;
        if outputs.iter().any(|name| name == VOLUME) {
            let reason = "volumetric_strain is an output: it predicts the volume of a sample whose mean stress is held, and a point prescribes the volume";
            return Err(wrong(reason.into()));
        }
        let mut row = vec![0.0; inputs.len()];
        for (place, name) in inputs.iter().enumerate().filter(|(place, _)| !strains.contains(place)) {
            let given = sample.get(name).copied().filter(|value| value.is_finite());
            row[place] =
                given.ok_or_else(|| wrong(format!("its input {name} needs a finite value of the sample")))?;
        }
        if let Some(name) =
            sample.keys().find(|name| !inputs.contains(name) || STRAINS.contains(&name.as_str()))
        {
            return Err(wrong(format!("{name} is no input that describes its sample")));
        }
        let void_ratio = sample.get(VOID_RATIO).copied();
        let (outputs, streams) = (outputs.into(), Mutex::new(Vec::new()));
        Ok(SurrogateModel { surrogate, row, strains, stresses, outputs, void_ratio, streams })
    }

    /// Takes everything that determines a result into a digest.
    ///
    /// # Errors
    /// [`PointError::Surrogate`] if the surrogate cannot be written.
    pub(crate) fn digest(&self, digest: &mut Digest) -> Result<(), PointError> {
        digest.text("surrogate");
        digest.bytes(to_json(self.surrogate.as_ref())?.as_bytes());
        digest.numbers(&self.row);
        Ok(())
    }

    /// The state without strain.
    ///
    /// # Errors
    /// [`PointError::Surrogate`].
    pub(crate) fn start(&self) -> Result<Step, PointError> {
        self.with_stream(|stream| self.step(stream, &RunMemory::default(), [0.0; 6]))
    }

    /// The state after a strain, in the axes of the sample.
    ///
    /// # Errors
    /// [`PointError::Surrogate`] if it has no finite answer, or the state is that of another surrogate.
    pub(crate) fn strained(&self, from: &SurrogateState, strain: &Matrix) -> Result<Step, PointError> {
        self.with_stream(|stream| {
            let total = std::array::from_fn(|k| from.strain[k] + strain_component(strain, k));
            self.step(stream, &from.memory, total)
        })
    }

    /// The stresses after each of several strains from a state, in the axes of the sample: to the bits of [`SurrogateModel::strained`], but at once.
    ///
    /// # Errors
    /// As [`SurrogateModel::strained`].
    pub(crate) fn stresses(
        &self,
        from: &SurrogateState,
        strains: &[Matrix],
    ) -> Result<Vec<Matrix>, PointError> {
        let row = |strain: &Matrix| {
            let mut row = self.row.clone();
            for (k, place) in self.strains.iter().enumerate() {
                row[*place] = from.strain[k] + strain_component(strain, k);
            }
            row
        };
        let rows: Vec<Vec<f64>> = strains.iter().map(row).collect();
        let means = self.with_stream(|stream| {
            stream.resume(&from.memory)?;
            Ok(stream.means_of(&rows)?)
        })?;
        let stress = |means: Vec<f64>| {
            let mut stress = [[0.0; 3]; 3];
            for ([r, c], place) in PLACES.into_iter().zip(self.stresses) {
                (stress[r][c], stress[c][r]) = (means[place], means[place]);
            }
            stress
        };
        Ok(means.into_iter().map(stress).collect())
    }

    /// Answers with a stream that nobody else uses meanwhile.
    fn with_stream<T>(
        &self,
        answer: impl FnOnce(&mut PredictionStream<'static>) -> Result<T, PointError>,
    ) -> Result<T, PointError> {
        let idle = self.streams.lock().unwrap_or_else(PoisonError::into_inner).pop();
        let mut stream = match idle {
            Some(stream) => stream,
            None => PredictionStream::of_shared(Arc::clone(&self.surrogate), LEVEL)?,
        };
        let answered = answer(&mut stream);
        self.streams.lock().unwrap_or_else(PoisonError::into_inner).push(stream);
        answered
    }

    fn step(
        &self,
        stream: &mut PredictionStream<'static>,
        memory: &RunMemory,
        strain: [f64; 6],
    ) -> Result<Step, PointError> {
        let mut row = self.row.clone();
        self.strains.iter().zip(strain).for_each(|(place, strain)| row[*place] = strain);
        stream.resume(memory)?;
        let prediction = stream.next_state(&row)?;
        let stress = self.stress(&prediction);
        let Prediction { values, outside, .. } = prediction;
        let state = SurrogateState {
            memory: stream.memory(),
            strain,
            void_ratio: self.void_ratio,
            outputs: Arc::clone(&self.outputs),
            values: values.iter().map(|estimate| estimate.mean).collect(),
            outside,
        };
        Ok((state, stress))
    }

    /// Stress and its standard deviation by components; the latter is zero where the surrogate does not know it.
    fn stress(&self, prediction: &Prediction) -> AveragedStress {
        let (mut mean, mut deviation) = ([[0.0; 3]; 3], [[0.0; 3]; 3]);
        for ([r, c], place) in PLACES.into_iter().zip(self.stresses) {
            let Some(estimate) = prediction.values.get(place) else { continue };
            let own = estimate.interval.as_ref().map_or(0.0, |interval| interval.standard_deviation());
            (mean[r][c], mean[c][r]) = (estimate.mean, estimate.mean);
            (deviation[r][c], deviation[c][r]) = (own, own);
        }
        AveragedStress { mean, deviation }
    }
}
