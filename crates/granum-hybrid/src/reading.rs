//! What the networks learned, in plain sentences from the numbers.

use crate::size_study::SizeStudy;
use crate::study::Evaluation;
use crate::summary::SpeedSummary;

/// Differences between errors below this share of them are not told apart.
const NOTICEABLE: f64 = 0.05;

/// What the soft sensors of a mapping did for it on unseen runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The networks do better than twins that see strain only.
    Helps,
    /// No noticeable difference.
    NoDifference,
    /// They do worse.
    Hurts,
}

/// Compares networks with twins that see strain only, on unseen runs or else on held-out states.
pub fn verdict(evaluation: &Evaluation) -> Verdict {
    let (own, twin) = compared(evaluation);
    if own < twin * (1.0 - NOTICEABLE) {
        Verdict::Helps
    } else if own > twin * (1.0 + NOTICEABLE) {
        Verdict::Hurts
    } else {
        Verdict::NoDifference
    }
}

fn compared(evaluation: &Evaluation) -> (f64, f64) {
    if evaluation.network.unseen.states > 0 {
        (evaluation.network.unseen.relative_rmse, evaluation.strain_only.unseen.relative_rmse)
    } else {
        (evaluation.network.held_out.relative_rmse, evaluation.strain_only.held_out.relative_rmse)
    }
}

/// A sentence or two on a mapping.
pub fn read_mapping(evaluation: &Evaluation) -> String {
    let mapping = &evaluation.mapping;
    let (own, twin) = compared(evaluation);
    let of = if evaluation.network.unseen.states > 0 { "unseen runs" } else { "held-out states" };
    let sensors: Vec<&str> = mapping.inputs.iter().skip(1).map(|input| input.symbol()).collect();
    let sensors = sensors.join(" and ");
    let percent = |x: f64| format!("{:.1} %", 100.0 * x);
    let mut text = format!(
        "{}: on {of} the networks miss {} by {} (relative RMSE), networks of the same size that see strain only by {}: ",
        mapping.formula(),
        mapping.output.symbol(),
        percent(own),
        percent(twin)
    );
    text += &match verdict(evaluation) {
        Verdict::Helps => format!("{sensors} took away {} of the error.", percent(1.0 - own / twin)),
        Verdict::NoDifference => {
            format!("{sensors} added nothing that strain alone does not tell on this path.")
        }
        Verdict::Hurts => {
            format!(
                "being told {sensors} made the answer worse, the network follows peculiarities of its training run."
            )
        }
    };
    let best = evaluation.best_without_sensors().filter(|best| *best > 0.0);
    if let Some(best) = best.filter(|_| evaluation.network.unseen.states > 0) {
        let times = own / best;
        text += &format!(" Knowing the training run by heart would miss it by {}", percent(best));
        text += &if times < 1.0 - NOTICEABLE && verdict(evaluation) == Verdict::Helps {
            ", so the networks do use what they are told of the unseen run.".to_owned()
        } else if times < 1.0 - NOTICEABLE {
            ", a smooth curve by less, without using what it is told of the unseen run.".to_owned()
        } else if times <= 1.0 + 2.0 * NOTICEABLE {
            ", the scatter between samples: the networks are as good as that.".to_owned()
        } else {
            format!(", the scatter between samples; the networks miss it {times:.1} times as far.")
        };
    }
    text
}

/// Sentences on the size of networks with and without a further soft sensor.
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
            (Some(a), Some(b)) if b < a => "so here the further input does let the network be smaller",
            (None, Some(_)) => "so here the further input does let the network be smaller",
            (Some(a), Some(b)) if b == a => {
                "so here the further input does not change the size that is needed"
            }
            _ => "so here the further input does not let the network be smaller",
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
    // Two figures: the time of the networks wavers by more.
    let magnitude = 10f64.powf(speed.factor.max(1.0).log10().floor() - 1.0);
    let factor = (speed.factor / magnitude).round() * magnitude;
    format!(
        "The networks answer {} states of all mappings in {:.2} ms, the DEM test took {:.0} s: {factor:.0} times faster (the \
         paper says 5 to 10). That leaves out {:.1} s of training, the DEM it learned from, and that the networks are \
         told soft sensors of the test they answer.",
        speed.states,
        1e3 * speed.network_seconds,
        speed.dem_seconds,
        speed.training_seconds
    )
}

/// The whole reading.
pub fn read(
    evaluations: &[Evaluation],
    size_study: Option<&SizeStudy>,
    speed: Option<&SpeedSummary>,
) -> Vec<String> {
    let mut sentences: Vec<String> = evaluations.iter().map(read_mapping).collect();
    sentences.extend(size_study.map(read_size_study).unwrap_or_default());
    sentences.extend(speed.map(read_speed));
    sentences
}
