//! Ensembles of networks from different seeds: their mean, and their scatter as a further estimate of the uncertainty.

use granum_core::observer::{Observer, SharedObserver};
use granum_core::parallel;

use crate::model::model_definition::ModelDefinition;
use crate::model::model_error::ModelError;
use crate::model::prediction::{BatchPrediction, Deviation, NetworkPrediction};
use crate::model::trained::Model;
use crate::table::data::Data;
use crate::trainer::report::TrainingReport;
use crate::trainer::trainer_trait::Trainer;
use crate::training_error::TerminationReason;

/// Number of rows that all members answer before the next ones, so that they stay in the first-level cache.
const CHUNK: usize = 256;

/// Models of one definition with different seeds.
///
/// ```
/// use granum_nets::trainer::{LevenbergMarquardt, NoObserver};
/// use granum_nets::{ModelColumn, Data, Ensemble, ModelDefinition};
///
/// let x: Vec<f64> = (0..20).map(|k| k as f64 / 19.0).collect();
/// let y = x.iter().map(|x| (3.0 * x).sin()).collect();
/// let definition = ModelDefinition::new(vec![ModelColumn::new("x", "1")], ModelColumn::new("y", "1"), vec![4]);
/// let (data, trainer) = (Data::new(x, 1, y)?, LevenbergMarquardt::default());
/// let (ensemble, _) = Ensemble::fit(&definition, &data, &trainer, &[1, 2, 3], 1, &mut NoObserver)?;
/// let [inside, outside] = [0.5, 2.0].map(|x| ensemble.predict(&[x]).unwrap());
/// assert!(inside.standard_deviation < outside.standard_deviation);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Ensemble {
    members: Vec<Model>,
}

impl Ensemble {
    /// Trains one model for each seed on up to `threads` threads. The members are in the order of the seeds, and the
    /// result does not depend on the number of threads. The observer hears of every epoch of each member, which is the part
    /// `seed 1` for a seed of 1. If it requests a stop, the members that are not complete keep their current weights, and
    /// their reports say that they were stopped.
    ///
    /// # Errors
    /// As [`Model::fit`], for the first seed that fails, and if there is no seed.
    pub fn fit(
        definition: &ModelDefinition,
        data: &Data,
        trainer: &dyn Trainer,
        seeds: &[u64],
        threads: usize,
        observer: &mut dyn Observer,
    ) -> Result<(Ensemble, Vec<TrainingReport>), ModelError> {
        let shared = SharedObserver::new(observer);
        let fitted = parallel::map(seeds.len(), threads.max(1), |k| {
            let definition = ModelDefinition { seed: seeds[k], ..definition.clone() };
            let mut part = shared.part(format!("seed {}", seeds[k]));
            let (model, report) = Model::fit(&definition, data, trainer, &mut part)?;
            if report.termination != TerminationReason::Stopped {
                part.completed();
            }
            Ok::<_, ModelError>((model, report))
        })?;
        let (members, reports) = fitted.into_iter().unzip();
        Ok((Ensemble::from_models(members)?, reports))
    }

    /// An ensemble of given models.
    ///
    /// # Errors
    /// If there are no models, or if their columns differ.
    pub fn from_models(members: Vec<Model>) -> Result<Ensemble, ModelError> {
        let Some(first) = members.first() else {
            return Err(ModelError::Columns("an ensemble needs at least one model (one seed)".into()));
        };
        let alike = |m: &Model| (m.inputs(), m.output()) == (first.inputs(), first.output());
        if !members.iter().all(alike) {
            return Err(ModelError::Columns("the models of an ensemble need the same columns".into()));
        }
        Ok(Ensemble { members })
    }

    /// The models of the ensemble.
    pub fn members(&self) -> &[Model] {
        &self.members
    }

    /// Mean prediction of the members. The variance is that of a mixture: the variance between the members plus the mean
    /// of their own variances. For a single member without an estimate of its uncertainty there is none.
    ///
    /// # Errors
    /// As [`Model::predict`].
    pub fn predict(&self, row: &[f64]) -> Result<NetworkPrediction, ModelError> {
        let predictions = self.members.iter().map(|m| m.predict(row)).collect::<Result<Vec<_>, _>>()?;
        let count = predictions.len() as f64;
        let value = predictions.iter().map(|p| p.value).sum::<f64>() / count;
        let between = predictions.iter().map(|p| (p.value - value) * (p.value - value)).sum::<f64>();
        let within: Option<f64> = predictions.iter().map(|p| p.standard_deviation.map(|d| d * d)).sum();
        let variance = match (within.map(|w| w / count), predictions.len()) {
            (within, 1) => within,
            (within, _) => Some(between / (count - 1.0) + within.unwrap_or(0.0)),
        };
        let outside = self.members[0].outside(row);
        Ok(NetworkPrediction { value, standard_deviation: variance.map(f64::sqrt), outside })
    }

    /// Mean prediction of the members for many rows (a flat array in row-major order).
    ///
    /// # Errors
    /// As [`Model::predict_batch`].
    pub fn predict_batch(&self, rows: &[f64]) -> Result<BatchPrediction, ModelError> {
        let mut mean = self.members[0].predict_batch(rows)?;
        for member in &self.members[1..] {
            let values = member.predict_batch(rows)?.values;
            mean.values.iter_mut().zip(values).for_each(|(m, v)| *m += v);
        }
        mean.values.iter_mut().for_each(|m| *m /= self.members.len() as f64);
        Ok(mean)
    }

    /// Mean prediction of the members for many rows, with standard deviations of observations around it that need no more than the
    /// predictions of the members: the uncertainty of the weights is the scatter between the members,
    ///
    /// ```text
    /// s^2(x) = c^2(x) (noise + sum_m (y_m(x) - y(x))^2 / (M - 1))
    /// ```
    ///
    /// with the mean of the members' noise of the targets and of their factors c from left-out blocks. `None` in the place of deviations for a
    /// single member or members trained without Bayesian regularisation. Source: Lakshminarayanan, Pritzel and Blundell, Simple and scalable
    /// predictive uncertainty estimation using deep ensembles, Advances in Neural Information Processing Systems 30 (2017).
    ///
    /// # Errors
    /// As [`Model::predict_batch`].
    pub fn predict_batch_with_deviations(
        &self,
        rows: &[f64],
    ) -> Result<(BatchPrediction, Option<Vec<Deviation>>), ModelError> {
        let first = &self.members[0];
        first.check_rows(rows)?;
        let count = self.members.len() as f64;
        let noise: Option<f64> = self.members.iter().map(Model::noise_variance).sum();
        let noise = noise.map(|noise| noise / count).filter(|_| self.members.len() > 1);
        let columns = first.inputs().len();
        let mut values = vec![0.0; rows.len() / columns];
        let mut deviations = Vec::with_capacity(if noise.is_some() { values.len() } else { 0 });
        let (mut own, mut sums) = ([0.0; CHUNK], [[0.0; 2]; CHUNK]);
        for (rows, values) in rows.chunks(CHUNK * columns).zip(values.chunks_mut(CHUNK)) {
            let (own, sums) = (&mut own[..values.len()], &mut sums[..values.len()]);
            first.values_of(rows, values);
            sums.fill([0.0; 2]);
            // About the first member, so that the difference of large squares loses no digits.
            for member in &self.members[1..] {
                member.values_of(rows, own);
                for (([sum, squares], own), first) in sums.iter_mut().zip(&*own).zip(&*values) {
                    let apart = own - first;
                    *sum += apart;
                    *squares += apart * apart;
                }
            }
            for (value, [sum, _]) in values.iter_mut().zip(&*sums) {
                *value += sum / count;
            }
            let Some(noise) = noise else { continue };
            let mut factors = first.factors(rows, 1);
            for member in &self.members[1..] {
                factors.iter_mut().zip(member.factors(rows, 1)).for_each(|(sum, own)| *sum += own);
            }
            deviations.extend(sums.iter().zip(&factors).map(|([sum, squares], factor)| {
                let between = (squares - sum * sum / count).max(0.0) / (count - 1.0);
                Deviation::new(noise + between, noise, factor / count, 1.0)
            }));
        }
        let predicted = BatchPrediction { values, outside: first.outside_of(rows) };
        Ok((predicted, noise.map(|_| deviations)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::model_definition::ModelColumn;
    use crate::trainer::LevenbergMarquardt;
    use granum_core::observer::{Event, Flow, NoObserver, Progress};

    fn definition() -> ModelDefinition {
        ModelDefinition {
            inputs: vec![ModelColumn::new("x", "1")],
            output: ModelColumn::new("y", "Pa"),
            quantities: Vec::new(),
            shares: Vec::new(),
            hidden: vec![6, 5],
            seed: 0,
        }
    }

    fn data() -> Data {
        let x: Vec<f64> = (0..40).map(|k| k as f64 / 39.0).collect();
        let y = x
            .iter()
            .enumerate()
            .map(|(k, x)| 1e3 * ((4.0 * x).sin() + 0.05 * (k as f64 * 7.7).sin()))
            .collect();
        Data::new(x, 1, y).unwrap()
    }

    #[test]
    fn the_number_of_threads_changes_no_bit() {
        let trainer = LevenbergMarquardt { epochs: 30, ..Default::default() };
        let one = Ensemble::fit(&definition(), &data(), &trainer, &[1, 2, 3], 1, &mut NoObserver).unwrap().0;
        let three =
            Ensemble::fit(&definition(), &data(), &trainer, &[1, 2, 3], 3, &mut NoObserver).unwrap().0;
        for (a, b) in one.members().iter().zip(three.members()) {
            assert_eq!(a.network().weights(), b.network().weights());
        }
        assert_eq!(one.predict(&[0.3]).unwrap(), three.predict(&[0.3]).unwrap());
    }

    #[test]
    fn mean_and_scatter() {
        let trainer = LevenbergMarquardt::default();
        let (ensemble, reports) =
            Ensemble::fit(&definition(), &data(), &trainer, &[1, 2, 3, 4], 2, &mut NoObserver).unwrap();
        assert_eq!(reports.len(), 4);
        let inside = ensemble.predict(&[0.5]).unwrap();
        let outside = ensemble.predict(&[1.5]).unwrap();
        assert!((inside.value - 1e3 * 2f64.sin()).abs() < 60.0, "{inside:?}");
        assert!(inside.outside.is_empty() && outside.outside == ["x"]);
        assert!(outside.standard_deviation > inside.standard_deviation);
        let batch = ensemble.predict_batch(&[0.5, 1.5]).unwrap();
        assert!((batch.values[0] - inside.value).abs() < 1e-9 && batch.outside == [false, true]);
        assert!(Ensemble::fit(&definition(), &data(), &trainer, &[], 2, &mut NoObserver).is_err());
    }

    /// Stops in an epoch of a member.
    struct StopsAt {
        part: &'static str,
        epoch: u64,
        completed: Vec<String>,
    }

    impl Observer for StopsAt {
        fn progress(&mut self, progress: &Progress) -> Flow {
            let reached = progress.part.as_deref() == Some(self.part) && progress.done == self.epoch;
            if reached { Flow::Stop } else { Flow::Continue }
        }
        fn event(&mut self, event: &Event) {
            if let Event::PartCompleted { part } = event {
                self.completed.push(part.clone());
            }
        }
    }

    #[test]
    fn an_observer_hears_the_members_and_stops_them() {
        let trainer = LevenbergMarquardt { epochs: 5, ..Default::default() };
        let mut observer = StopsAt { part: "seed 8", epoch: 3, completed: Vec::new() };
        let (ensemble, reports) =
            Ensemble::fit(&definition(), &data(), &trainer, &[7, 8, 9], 1, &mut observer).unwrap();
        assert_eq!(observer.completed, ["seed 7"]);
        assert_eq!(reports.iter().map(|report| report.epochs).collect::<Vec<_>>(), [5, 3, 1]);
        let stopped = |report: &TrainingReport| report.termination == TerminationReason::Stopped;
        assert_eq!(reports.iter().map(stopped).collect::<Vec<_>>(), [false, true, true]);
        assert_eq!(ensemble.members().len(), 3);
    }

    #[test]
    fn deviations_of_many_rows_are_noise_and_the_scatter_of_the_members() {
        let trainer = LevenbergMarquardt::default();
        let ensemble =
            Ensemble::fit(&definition(), &data(), &trainer, &[1, 2, 3, 4], 1, &mut NoObserver).unwrap().0;
        let rows = [0.1, 0.5, 1.6];
        let (mean, deviations) = ensemble.predict_batch_with_deviations(&rows).unwrap();
        let deviations = deviations.unwrap();
        for (k, x) in rows.iter().enumerate() {
            let values: Vec<f64> = ensemble.members().iter().map(|m| m.value(&[*x]).unwrap()).collect();
            let average = values.iter().sum::<f64>() / 4.0;
            let between = values.iter().map(|y| (y - average).powi(2)).sum::<f64>() / 3.0;
            assert!((mean.values[k] - average).abs() < 1e-9 * average.abs());
            assert!((deviations[k].weights.powi(2) / between - 1.0).abs() < 1e-6, "{:?}", deviations[k]);
            let total = deviations[k].noise.powi(2) + between;
            assert!((deviations[k].total.powi(2) / total - 1.0).abs() < 1e-6, "{:?}", deviations[k]);
        }
        // Noise of 5 % of the amplitude; beyond the rows the members disagree.
        assert!((30.0..60.0).contains(&deviations[1].noise), "{:?}", deviations[1]);
        assert!(deviations[2].weights > 3.0 * deviations[1].weights, "{deviations:?}");
        let one = Ensemble::from_models(ensemble.members()[..1].to_vec()).unwrap();
        assert!(one.predict_batch_with_deviations(&rows).unwrap().1.is_none());
    }
}
