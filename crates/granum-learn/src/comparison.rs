//! Comparison of surrogates of any kind by the same scores.

use granum_core::clock::Instant;
use granum_core::observer::Observer;

use crate::dataset::{Dataset, SplitParts};
use crate::error::{LearnError, Result};
use crate::pooled_error::PooledError;
use crate::score::{Score, Scorer};
use crate::surrogate::{Columns, FitSpec, Prediction, RunInputs, Surrogate, SurrogateMethod};

/// A fitted surrogate with its scores on the parts of a data set.
#[non_exhaustive]
pub struct SurrogateScores {
    /// Name of its method.
    pub method: String,
    /// The surrogate.
    pub surrogate: Box<dyn Surrogate>,
    /// Score on the training rows.
    pub training: Score,
    /// Score on the held-out rows of the same runs; without rows for a method with memory, which is fitted to all states of
    /// the training runs.
    pub held_out: Score,
    /// Score on unseen runs.
    pub unseen: Score,
    /// The share of the values of unseen runs that lie within their intervals; `None` without intervals or unseen runs.
    pub coverage: Option<f64>,
    /// Number of rows of unseen runs with an input outside the trained range.
    pub unseen_outside: usize,
    /// Wall time of the fit, s.
    pub seconds: f64,
}

/// Fits every method to the training part and scores the result on all parts, with intervals of the given level. The
/// scores do not depend on the order of the methods. The observer follows the fits, and can stop them.
///
/// The documentation of [this crate](crate) contains an example.
///
/// # Errors
/// If the outputs have different units, so that there is no common score, and as [`SurrogateMethod::fit`] and
/// [`Surrogate::predict`].
pub fn compare(
    parts: &SplitParts,
    spec: &FitSpec,
    methods: &[&dyn SurrogateMethod],
    level: f64,
    observer: &mut dyn Observer,
) -> Result<Vec<SurrogateScores>> {
    check_units(&spec.columns(&parts.training)?)?;
    methods.iter().map(|method| compare_one(parts, spec, *method, level, observer)).collect()
}

fn compare_one(
    parts: &SplitParts,
    spec: &FitSpec,
    method: &dyn SurrogateMethod,
    level: f64,
    observer: &mut dyn Observer,
) -> Result<SurrogateScores> {
    let clock = Instant::now();
    let training = if method.has_memory() { &parts.training_runs } else { &parts.training };
    let surrogate = method.fit(training, spec, observer)?;
    let seconds = clock.elapsed().as_secs_f64();
    let judge = |part: &Dataset| judged(surrogate.as_ref(), part, level, &spec.scored_states(part)?);
    let unseen = judge(&parts.unseen)?;
    Ok(SurrogateScores {
        method: method.name().to_owned(),
        training: judge(training)?.score,
        held_out: if method.has_memory() { Score::default() } else { judge(&parts.held_out)?.score },
        unseen: unseen.score,
        coverage: unseen.coverage,
        unseen_outside: unseen.outside,
        seconds,
        surrogate,
    })
}

/// Scores any surrogate, however it was obtained, on all rows of a data set; all scores are 0 if there are no rows.
///
/// # Errors
/// If a column of the surrogate is missing, and as [`Surrogate::predict`].
pub fn score_surrogate(surrogate: &dyn Surrogate, dataset: &Dataset) -> Result<Score> {
    score_where(surrogate, dataset, &vec![true; dataset.rows()])
}

/// Scores the states of a data set for which `scored` is true; all scores are 0 if there are none.
///
/// # Errors
/// As [`score_surrogate`].
pub fn score_where(surrogate: &dyn Surrogate, dataset: &Dataset, scored: &[bool]) -> Result<Score> {
    if dataset.rows() == 0 {
        return Ok(Score::default());
    }
    let columns = surrogate.columns();
    check_units(columns)?;
    surrogate.check(dataset)?;
    let exact = dataset.values(&columns.output_names())?;
    let means = surrogate.means(&RunInputs::from_dataset(dataset, columns)?)?;
    let mut scorer = Scorer::default();
    let states = exact.chunks_exact(columns.outputs.len()).zip(&means).zip(scored);
    states.filter(|(_, scored)| **scored).for_each(|((exact, means), _)| scorer.add(exact, means));
    Ok(scorer.score())
}

/// The predictions of a surrogate for a data set, judged.
pub(crate) struct Judged {
    pub score: Score,
    /// The score of each output.
    pub outputs: Vec<Score>,
    pub coverage: Option<f64>,
    pub outside: usize,
    /// The error with its standard error over the runs.
    pub pooled: PooledError,
}

/// Scores the states for which `scored` is true; all states count as inside or outside the trained range.
pub(crate) fn judged(
    surrogate: &dyn Surrogate,
    dataset: &Dataset,
    level: f64,
    scored: &[bool],
) -> Result<Judged> {
    let columns = surrogate.columns();
    if dataset.rows() == 0 {
        let outputs = vec![Score::default(); columns.outputs.len()];
        return Ok(Judged {
            score: Score::default(),
            outputs,
            coverage: None,
            outside: 0,
            pooled: PooledError::default(),
        });
    }
    check_units(columns)?;
    surrogate.check(dataset)?;
    let exact = dataset.values(&columns.output_names())?;
    let predictions = surrogate.predict(&RunInputs::from_dataset(dataset, columns)?, level)?;
    let mut scorer = Scorer::default();
    let mut each = vec![Scorer::default(); columns.outputs.len()];
    let (mut held, mut intervals) = (0, 0);
    let mut by_run = vec![[0.0; 2]; dataset.runs().len()];
    let states =
        exact.chunks_exact(columns.outputs.len()).zip(&predictions).zip(dataset.run_of_rows()).zip(scored);
    for (((exact, prediction), run), _) in states.filter(|(_, scored)| **scored) {
        let means: Vec<f64> = prediction.values.iter().map(|estimate| estimate.mean).collect();
        scorer.add(exact, &means);
        for ((scorer, exact), estimate) in each.iter_mut().zip(exact).zip(&prediction.values) {
            by_run[run][0] += (estimate.mean - exact) * (estimate.mean - exact);
            by_run[run][1] += exact * exact;
            scorer.add(&[*exact], &[estimate.mean]);
            if let Some(interval) = &estimate.interval {
                intervals += 1;
                held += usize::from(interval.lower <= *exact && *exact <= interval.upper);
            }
        }
    }
    let is_outside = |prediction: &&Prediction| prediction.is_extrapolated();
    Ok(Judged {
        score: scorer.score(),
        outputs: each.iter().map(Scorer::score).collect(),
        coverage: (intervals > 0).then(|| held as f64 / intervals as f64),
        outside: predictions.iter().filter(is_outside).count(),
        pooled: PooledError::new(&by_run),
    })
}

pub(crate) fn check_units(columns: &Columns) -> Result<()> {
    let Some(first) = columns.outputs.first() else { return Ok(()) };
    let Some(other) = columns.outputs.iter().find(|other| other.unit != first.unit) else { return Ok(()) };
    let unit = |unit: &str| if unit.is_empty() { "no unit".to_string() } else { unit.to_string() };
    Err(LearnError::Dataset(format!(
        "{} ({}) and {} ({}) have different units, and one score cannot cover both; fit them separately",
        first.name,
        unit(&first.unit),
        other.name,
        unit(&other.unit)
    )))
}
