//! Interpretation of the results of the networks in plain sentences.

use crate::evaluation::{Evaluation, ScoreParts};
use crate::size_study::SizeStudy;
use crate::summary::SpeedSummary;
use granum_core::words::{self, listed, percentage};
use granum_learn::input_use::Verdict;
use granum_learn::student_t::PairedTest;
use granum_report::figure::ticks::power_of_ten;

/// A mean difference with its standard error, in percentage points.
fn points(test: &PairedTest) -> String {
    let error = test.standard_error.map_or(String::new(), |error| format!(" ± {:.2}", 100.0 * error));
    format!("{}{error} percentage points", words::fixed(100.0 * test.mean, 2))
}

/// A few sentences on a mapping.
pub fn read_mapping(evaluation: &Evaluation) -> String {
    let mut sentences = vec![errors(evaluation)];
    sentences.extend(sensors(evaluation));
    sentences.extend(constants(evaluation));
    sentences.join(" ")
}

/// The errors of the networks and of the baselines.
fn errors(evaluation: &Evaluation) -> String {
    let mapping = &evaluation.mapping;
    let unseen = evaluation.network.unseen.states > 0;
    let of =
        |parts: &ScoreParts| percentage(if unseen { parts.unseen } else { parts.held_out }.relative_rmse);
    format!(
        "{}: on {} the relative RMSE of {} is {} for the networks, {} for strain-only networks, {} for ridge \
         regression on the same sensors, {} for the mean curve of the training runs.",
        mapping.formula(),
        if unseen { "unseen runs" } else { "held-out states" },
        mapping.output.symbol(),
        of(&evaluation.network),
        of(&evaluation.strain_only),
        of(&evaluation.ridge),
        of(&evaluation.mean_curve),
    )
}

/// The use that the networks make of their sensors; `None` without unseen runs.
fn sensors(evaluation: &Evaluation) -> Option<String> {
    let names: Vec<String> =
        evaluation.mapping.inputs.iter().skip(1).map(|input| input.symbol().to_owned()).collect();
    let names = listed(&names);
    let sensor_use = &evaluation.sensor_use;
    let runs = sensor_use.runs.len();
    let Some(lost) = sensor_use.lost_with_other() else {
        let found = if runs == 1 { "one unseen run" } else { "no unseen run" };
        return Some(format!("Whether they use {names} cannot be judged from {found}."));
    };
    let with_other = sensor_use.with_other.map_or(String::new(), |score| {
        format!(", their relative RMSE is {}", percentage(score.relative_rmse))
    });
    let exchanged = format!(
        "With {names} of another unseen run at the same strain{with_other}, {} {}",
        points(&PairedTest { mean: lost.mean.abs(), ..lost }),
        if lost.mean < 0.0 { "less" } else { "more" }
    );
    let help = sensor_use.help()?;
    let help_points = points(&PairedTest { mean: help.mean.abs(), ..help });
    Some(match sensor_use.verdict() {
        Verdict::Gains => format!(
            "{exchanged}: they use their sensors, and are {help_points} better than strain-only networks."
        ),
        Verdict::WithoutGain => format!(
            "{exchanged}: they use their sensors, but without gain over strain-only networks ({help_points} {}).",
            if help.mean < 0.0 { "worse" } else { "better, which is within the scatter" }
        ),
        Verdict::DoesNotUse => {
            format!(
                "{exchanged}, which is no more than the scatter over {runs} runs: they do not use their sensors."
            )
        }
        Verdict::TooFewRuns => {
            format!("{exchanged}; {runs} unseen runs are too few to test whether they use their sensors.")
        }
    })
}

/// A sentence that names the sub-models whose networks are constant.
fn constants(evaluation: &Evaluation) -> Option<String> {
    let numbers: Vec<String> = (evaluation.sub_models.iter().enumerate())
        .filter(|(_, sub_model)| sub_model.constant)
        .map(|(k, _)| (k + 1).to_string())
        .collect();
    match numbers.len() {
        0 => None,
        1 => Some(format!(
            "The network of sub-model {} predicts a constant: it has learned nothing.",
            numbers[0]
        )),
        _ => Some(format!(
            "The networks of sub-models {} predict constants: they have learned nothing.",
            listed(&numbers)
        )),
    }
}

/// Sentences on the size of networks with and without an additional soft sensor.
pub fn read_size_study(study: &SizeStudy) -> Vec<String> {
    let [first, others @ ..] = study.curves.as_slice() else { return Vec::new() };
    let size = |neurons: Option<usize>| match neurons {
        Some(1) => "1 neuron".to_owned(),
        Some(neurons) => format!("{neurons} neurons"),
        None => "more neurons than were tried".to_owned(),
    };
    let sentence = |other: &crate::size_study::SizeCurve| {
        let (a, b) = (first.neurons_for_held_out, other.neurons_for_held_out);
        let claim = match (a, b) {
            (Some(a), Some(b)) if b < a => "so here the additional input allows a smaller network",
            (None, Some(_)) => "so here the additional input allows a smaller network",
            (Some(a), Some(b)) if b == a => "so here the additional input does not change the required size",
            _ => "so here the additional input does not allow a smaller network",
        };
        format!(
            "To come within {:.0} % of the best held-out error of {}, {} needs {} in each hidden layer and {} {}; {claim}.",
            100.0 * study.tolerance,
            first.mapping,
            first.mapping,
            size(a),
            other.mapping,
            size(b),
        )
    };
    others.iter().map(sentence).collect()
}

/// A sentence on speed.
pub fn read_speed(speed: &SpeedSummary) -> String {
    // The factor is rounded to two digits, since the measured time of the networks varies by more than that.
    let magnitude = power_of_ten(libm::log10(speed.factor.max(1.0)).floor() as i32 - 1);
    let factor = (speed.factor / magnitude).round() * magnitude;
    format!(
        "The networks evaluate {} states of all mappings in {:.2} ms, the DEM test took {:.0} s: {factor:.0} times \
         faster (the paper says 5 to 10). This does not count {:.1} s of training and the DEM runs for it, and the \
         networks are given soft sensors of the test that they predict.",
        speed.states,
        1e3 * speed.network_seconds,
        speed.dem_seconds,
        speed.training_seconds
    )
}

/// The complete interpretation. Speed is not part of it, since it depends on the computer ([`read_speed`]).
pub fn read(evaluations: &[Evaluation], size_study: Option<&SizeStudy>) -> Vec<String> {
    let mut sentences: Vec<String> = evaluations.iter().map(read_mapping).collect();
    sentences.extend(size_study.map(read_size_study).unwrap_or_default());
    sentences
}
