//! The data of the study: runs with the columns of the paper, and their split.
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

use granum_learn::curve::increases;
use granum_learn::dataset::{ColumnGroup, Dataset, NamedRecord, RunStates, Split, SplitParts, record_error};
use granum_learn::networks::MappingBins;
use granum_learn::{LearnError, Result};
use granum_nets::Data;

use crate::mapping::PaperQuantity;

/// Options of the data.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperDataOptions {
    /// Of this number of successive states one is used for training, and the others are held out.
    pub stride: usize,
    /// Lower edge of the first bin of f that is learned.
    pub smallest_force: f64,
    /// Upper edge of the last bin of f that is learned.
    pub largest_force: f64,
}

impl Default for PaperDataOptions {
    fn default() -> Self {
        PaperDataOptions { stride: 2, smallest_force: 0.0, largest_force: 3.5 }
    }
}

/// A data set with the columns of the paper, and its split.
#[derive(Clone, Debug, PartialEq)]
pub struct PaperData {
    /// All runs, those for training first.
    pub dataset: Dataset,
    /// The split into training, held-out and unseen states.
    pub split: Split,
    /// Its parts.
    pub parts: SplitParts,
    /// The bins of f that are learned.
    pub bins: MappingBins,
}

impl PaperData {
    /// The data of records.
    ///
    /// # Errors
    /// As [`PaperData::new`].
    pub fn from_records(
        training: &[NamedRecord],
        unseen: &[NamedRecord],
        options: &PaperDataOptions,
    ) -> Result<PaperData> {
        let columns = |records: &[NamedRecord]| -> Result<Vec<RunStates>> {
            records.iter().map(RunStates::from_record).collect()
        };
        PaperData::new(columns(training)?, columns(unseen)?, options)
    }

    /// The data of runs, which must have different names.
    ///
    /// # Errors
    /// If there is no training run, a column is missing, a value is not finite, the strains do not increase, a test has several
    /// stages, or the histograms have different bins or none in the given range.
    pub fn new(
        training: Vec<RunStates>,
        unseen: Vec<RunStates>,
        options: &PaperDataOptions,
    ) -> Result<PaperData> {
        let first =
            training.first().ok_or_else(|| LearnError::Dataset("there is no training run".to_owned()))?;
        let bins = learned_bins(first, options)?;
        training.iter().chain(&unseen).try_for_each(|run| check_run(run, &bins))?;
        let names: Vec<String> = unseen.iter().map(|run| run.name().to_owned()).collect();
        let split = Split::default().first_state(1).stride(options.stride).unseen(names);
        let dataset = Dataset::new(training.into_iter().chain(unseen).collect())?;
        let parts = dataset.split(&split)?;
        Ok(PaperData { dataset, split, parts, bins })
    }

    /// A hash of all values that are learned and of the split.
    ///
    /// # Errors
    /// [`LearnError::Dataset`] if there are no states.
    pub fn hash(&self) -> Result<String> {
        let columns: Vec<String> =
            QUANTITIES.iter().flat_map(|quantity| quantity.columns(&self.bins)).collect();
        let (mut rows, mut parts) = (Vec::new(), Vec::new());
        for (k, part) in
            [&self.parts.training, &self.parts.held_out, &self.parts.unseen].into_iter().enumerate()
        {
            if part.rows() > 0 {
                rows.extend(part.values(&columns)?);
                parts.extend(std::iter::repeat_n(k as f64, part.rows()));
            }
        }
        rows.extend([self.bins.width, self.split.stride as f64, 0.0]);
        rows.extend(&self.bins.centres);
        parts.push(3.0);
        let data = Data::new(rows, columns.len(), parts);
        data.map(|data| data.hash()).map_err(|error| LearnError::Dataset(error.to_string()))
    }
}

/// The quantities of the mappings.
const QUANTITIES: [PaperQuantity; 4] = [
    PaperQuantity::DeviatorStrain,
    PaperQuantity::StressRatio,
    PaperQuantity::DeviatorFabric,
    PaperQuantity::ForceDistribution,
];

/// The bins of f in a run that lie in the range of the options.
///
/// # Errors
/// If the run has no histogram of forces, or none of its bins is in the range.
pub fn learned_bins(run: &RunStates, options: &PaperDataOptions) -> Result<MappingBins> {
    let histogram = histogram(run)?;
    let slack = 1e-6 * histogram.bin_width;
    let half = 0.5 * histogram.bin_width;
    let (low, high) = (options.smallest_force, options.largest_force);
    let wanted = |f: &f64| f - half >= low - slack && f + half <= high + slack;
    let centres: Vec<f64> = histogram.centres.iter().copied().filter(wanted).collect();
    if centres.is_empty() {
        let reason = format!("its histogram has no bin of f between {low} and {high}");
        return Err(record_error(run.name(), reason));
    }
    Ok(MappingBins { binned: histogram.binned.clone(), width: histogram.bin_width, centres })
}

fn histogram(run: &RunStates) -> Result<&ColumnGroup> {
    let none = || record_error(run.name(), "it has no state with a histogram of contact forces");
    run.group(PaperQuantity::ForceDistribution.column()).ok_or_else(none)
}

/// Refuses a run that is no test of the paper: with several stages, without a column, with other bins of f, with a value that is
/// not finite, or with a deviator strain that does not increase.
///
/// # Errors
/// If it is none; the message gives the state and the reason.
pub fn check_run(run: &RunStates, bins: &MappingBins) -> Result<()> {
    if run.column("stage")?.iter().any(|stage| *stage > 1.0) {
        let reason = "it is a test of several stages; the study of Antony, Zhou and Wang learns from tests of one stage, in \
                      which the deviator strain increases";
        return Err(record_error(run.name(), reason));
    }
    let numbers =
        QUANTITIES[..3].iter().map(|quantity| run.column(quantity.column())).collect::<Result<Vec<_>>>()?;
    let histogram = histogram(run)?;
    let has = |f: &f64| histogram.centres.iter().any(|centre| (f - centre).abs() < 1e-6 * bins.width);
    if !bins.centres.iter().all(has) || (histogram.bin_width - bins.width).abs() > 1e-9 * bins.width {
        let reason = "its histogram does not have the bins of f that the networks learn";
        return Err(record_error(run.name(), format!("{reason}; record with bins of width {}", bins.width)));
    }
    let densities = PaperQuantity::ForceDistribution.columns(bins);
    let densities = densities.iter().map(|name| run.column(name)).collect::<Result<Vec<_>>>()?;
    for k in 0..run.rows() {
        if numbers.iter().chain(&densities).any(|column| !column[k].is_finite()) {
            let reason = format!("state {k} contains a value that is not a finite number");
            return Err(record_error(run.name(), reason));
        }
    }
    // State 0 is not learned.
    let states = run.column("state")?;
    let first = usize::from(states.first() == Some(&0.0));
    let strains = &numbers[0][first.min(numbers[0].len())..];
    if increases(strains) {
        return Ok(());
    }
    let k = strains.windows(2).position(|pair| pair[1] <= pair[0]).unwrap_or(0) + 1;
    let reason = "the deviator strain must increase from state to state";
    Err(record_error(run.name(), format!("state {}: {reason}, but is {} here", k + first, strains[k])))
}

#[cfg(test)]
mod tests {
    use granum_sensors::Record;

    use super::*;
    use crate::synthetic::{Law, record};

    fn named<'a>(name: &'a str, record: &'a Record) -> NamedRecord<'a> {
        NamedRecord { name, seed: 1, record }
    }

    #[test]
    fn the_papers_recording_gives_about_840_rows_and_a_clean_split() {
        let training = record(Law::Plain, 1, 120);
        let unseen = record(Law::Plain, 2, 120);
        let named = ([named("training", &training)], [named("unseen", &unseen)]);
        let data = PaperData::from_records(&named.0, &named.1, &PaperDataOptions::default()).unwrap();
        assert_eq!(data.bins.centres.len(), 14);
        assert_eq!((data.bins.centres[0], data.bins.centres[13]), (0.125, 3.375));
        let SplitParts { training, held_out, unseen, .. } = &data.parts;
        assert_eq!((training.rows(), held_out.rows(), unseen.rows()), (60, 60, 120));
        // In point form each bin of a state is a row.
        assert_eq!(training.rows() * data.bins.centres.len(), 840);
        let trained = training.column("deviator_strain").unwrap();
        assert!((trained[0] - 0.0025).abs() < 1e-12 && (trained[59] - 0.2975).abs() < 1e-12);
        let held_out = held_out.column("deviator_strain").unwrap();
        assert!(held_out.iter().all(|strain| !trained.contains(strain)));
        assert!(held_out[..59].iter().all(|strain| trained[0] < *strain && *strain < trained[59]));
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
            let options = PaperDataOptions { stride, ..Default::default() };
            PaperData::from_records(&[named("run", record)], &[], &options).unwrap().hash().unwrap()
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
            let options = PaperDataOptions::default();
            PaperData::from_records(&[named("training", &training)], &[named("other", &broken)], &options)
                .unwrap_err()
                .to_string()
        };
        let text = message(&|record| drop(record.series.remove("deviator_fabric")));
        assert_eq!(text, "record `other`: there is no column deviator_fabric; did you mean deviator_strain?");
        let text = message(&|record| record.histograms[0].states[4].bin_width = 0.2);
        assert!(
            text.starts_with("record `other`: ")
                && text.contains("state 4: its histogram does not have the bins")
        );
        let text = message(&|record| {
            change(record, "deviator_strain", |values| values[9] = values[3]);
        });
        assert!(text.contains("state 9: the deviator strain must increase"), "{text}");
        let text = message(&|record| {
            change(record, "stress_ratio", |values| values[2] = f64::NAN);
        });
        assert!(text.contains("state 2 contains a value that is not a finite number"), "{text}");
        let text = PaperData::from_records(&[], &[], &PaperDataOptions::default()).unwrap_err().to_string();
        assert_eq!(text, "data set: there is no training run");
        let text = PaperData::from_records(
            &[named("training", &training)],
            &[],
            &PaperDataOptions { stride: 0, ..Default::default() },
        );
        assert!(text.unwrap_err().to_string().contains("must be 1 or more, not 0"));
    }
}
