//! The first page of a study: its numbers and findings, by explicit rules.

use granum_hybrid::summary::MappingSummary;

use super::numbers::{factor, listed, percent, significant};
use super::sample;
use super::study::StudyReport;
use super::symbols;

/// Differences between errors below this share of them are not told apart (as in the reading of granum-hybrid).
const NOTICEABLE: f64 = 0.05;
/// An error up to this many times the best possible without soft sensors counts as being as good as the scatter allows.
const AS_GOOD: f64 = 1.1;

/// The error that counts: on unseen runs, or, without any, on held-out states.
fn error(mapping: &MappingSummary) -> f64 {
    mapping.relative_rmse.unseen.unwrap_or(mapping.relative_rmse.held_out)
}

/// Names of the mappings that fulfil a condition.
fn those(study: &StudyReport, condition: impl Fn(&MappingSummary) -> bool) -> Vec<String> {
    let mappings = study.summary.mappings.iter();
    mappings.filter(|(_, mapping)| condition(mapping)).map(|(name, _)| symbols::mapping(name)).collect()
}

fn sensors_help(mapping: &MappingSummary) -> bool {
    error(mapping) < mapping.relative_rmse.strain_only * (1.0 - NOTICEABLE)
}

fn sensors_hurt(mapping: &MappingSummary) -> bool {
    error(mapping) > mapping.relative_rmse.strain_only * (1.0 + NOTICEABLE)
}

/// Error over the best that an answer without soft sensors of the unseen run can do.
fn over_best(mapping: &MappingSummary) -> Option<f64> {
    let best = mapping.best_without_sensors.filter(|best| *best > 0.0)?;
    Some(mapping.relative_rmse.unseen? / best)
}

/// The numbers at the top.
pub fn tiles(study: &StudyReport) -> Vec<[String; 3]> {
    let mappings = &study.summary.mappings;
    let mut out = Vec::new();
    let mut errors: Vec<f64> = mappings.values().map(error).filter(|error| error.is_finite()).collect();
    errors.sort_by(f64::total_cmp);
    if let (Some(first), Some(last)) = (errors.first(), errors.last()) {
        let on = if mappings.values().any(|m| m.relative_rmse.unseen.is_some()) {
            "unseen DEM runs"
        } else {
            "held-out states"
        };
        out.push([
            percent(errors[errors.len() / 2]),
            format!("median error on {on}"),
            format!("from {} to {} over the mappings", percent(*first), percent(*last)),
        ]);
        out.push([
            format!("{} of {}", those(study, sensors_help).len(), mappings.len()),
            "mappings gain from their soft sensors".into(),
            "against networks that see strain only".into(),
        ]);
    }
    if mappings.values().any(|mapping| over_best(mapping).is_some()) {
        let good = those(study, |mapping| over_best(mapping).is_some_and(|times| times <= AS_GOOD));
        out.push([
            format!("{} of {}", good.len(), mappings.len()),
            "mappings within the scatter of DEM".into(),
            "as near to an unseen run as runs of other seeds are to each other".into(),
        ]);
    }
    if study.summary.speed.factor > 0.0 {
        out.push([
            format!("× {}", factor(study.summary.speed.factor)),
            "faster than the DEM test".into(),
            "the paper: 5–10; training left out".into(),
        ]);
    }
    if let Some(solid) = sample::mean_start(&study.runs, "solid_fraction") {
        let z = sample::nearest_definition(&study.runs);
        let remark = z.map_or(String::new(), |(_, z)| {
            format!("nearest coordination number {} (paper 4.8)", significant(z, 3))
        });
        out.push([significant(solid, 3), "solid fraction (paper 0.61)".into(), remark]);
    }
    let peaks: Vec<f64> = study
        .runs
        .iter()
        .filter_map(|run| run.peak_row("stress_ratio").map(|row| run.column("stress_ratio")[row]))
        .collect();
    if !peaks.is_empty() {
        let mean = peaks.iter().sum::<f64>() / peaks.len() as f64;
        let late: Vec<f64> = study.runs.iter().filter_map(|run| run.late_mean("stress_ratio")).collect();
        let remark = format!("late: {}", significant(late.iter().sum::<f64>() / late.len().max(1) as f64, 3));
        out.push([significant(mean, 3), "peak *q*/*p*, mean of the runs".into(), remark]);
    }
    out
}

/// The findings, as sentences.
pub fn findings(study: &StudyReport) -> Vec<String> {
    let mut out = Vec::new();
    if let Some(curve) = &study.summary.learning_curve {
        out.extend(curve.reading().iter().map(|text| symbols::markup(text)));
    }
    out.extend(errors_sentence(study));
    out.extend(sensors_sentence(study));
    out.extend(scatter_sentence(study));
    if let Some(size) = &study.summary.size_study {
        out.extend(granum_hybrid::reading::read_size_study(size).iter().map(|text| symbols::markup(text)));
    }
    let speed = &study.summary.speed;
    if speed.factor > 0.0 {
        out.push(format!(
            "For the same curves the networks need 1/{} of the time of the DEM test (the paper says 1/5 to 1/10). They are \
             given soft sensors of the test that they answer for, which a laboratory would have to measure.",
            factor(speed.factor)
        ));
    }
    out.extend(sample::reading(&study.runs).into_iter().nth(1));
    out
}

fn errors_sentence(study: &StudyReport) -> Option<String> {
    let mappings = &study.summary.mappings;
    if mappings.is_empty() {
        return None;
    }
    let mut parts = Vec::new();
    for output in ["q/p", "P(f)", "φ_d"] {
        let of: Vec<(&String, &MappingSummary)> =
            mappings.iter().filter(|(_, m)| m.formula.starts_with(output)).collect();
        let errors: Vec<String> = of
            .iter()
            .map(|(name, m)| format!("{} ({})", percent(error(m)), symbols::mapping(name)))
            .collect();
        if !errors.is_empty() {
            parts.push(format!("{} by {}", symbols::markup(output), listed(&errors)));
        }
    }
    let where_to = if mappings.values().any(|m| m.relative_rmse.unseen.is_some()) {
        "On DEM runs that no network saw"
    } else {
        "On states that were kept from training"
    };
    Some(format!("{where_to}, the networks miss {} (relative RMSE).", parts.join("; ")))
}

fn sensors_sentence(study: &StudyReport) -> Option<String> {
    let count = study.summary.mappings.len();
    if count == 0 {
        return None;
    }
    let (help, hurt) = (those(study, sensors_help), those(study, sensors_hurt));
    let same = those(study, |mapping| !sensors_help(mapping) && !sensors_hurt(mapping));
    let mut text = match help.len() {
        0 => "No mapping does better for its soft sensors than a network of the same size that sees strain only: on this \
              one path strain alone tells what there is to tell."
            .to_owned(),
        n if n == count => {
            "Every mapping does better for its soft sensors than a network of the same size that sees strain only.".to_owned()
        }
        _ => format!(
            "Soft sensors take error away in {}, against networks of the same size that see strain only.",
            listed(&help)
        ),
    };
    if !same.is_empty() && !help.is_empty() {
        text += &format!(" In {} they add nothing that strain does not tell.", listed(&same));
    }
    if !hurt.is_empty() {
        text += &format!(" In {} they make the answer worse.", listed(&hurt));
    }
    Some(text)
}

fn scatter_sentence(study: &StudyReport) -> Option<String> {
    let judged: Vec<(&String, &MappingSummary, f64)> = (study.summary.mappings.iter())
        .filter_map(|(name, mapping)| Some((name, mapping, over_best(mapping)?)))
        .collect();
    if judged.is_empty() {
        return None;
    }
    let pick = |condition: &dyn Fn(&MappingSummary, f64) -> bool| -> Vec<String> {
        let chosen = judged.iter().filter(|(_, mapping, times)| condition(mapping, *times));
        chosen.map(|(name, _, _)| symbols::mapping(name)).collect()
    };
    let below = 1.0 - NOTICEABLE;
    // Coming below the yardstick proves nothing alone: a smooth curve does so too. The twins that see strain only tell.
    let used = pick(&|mapping, times| times < below && sensors_help(mapping));
    let smooth = pick(&|mapping, times| times < below && !sensors_help(mapping));
    let alike = pick(&|_, times| (below..=AS_GOOD).contains(&times));
    let worse: Vec<String> = (judged.iter().filter(|(_, _, times)| *times > AS_GOOD))
        .map(|(name, _, times)| format!("{} ({} times)", symbols::mapping(name), factor(*times)))
        .collect();
    let mut parts = Vec::new();
    let mut say = |names: &[String], one: &str, several: &str| {
        if !names.is_empty() {
            parts.push(format!("{} {}", listed(names), if names.len() == 1 { one } else { several }));
        }
    };
    say(
        &used,
        "stays below it by putting the sensors of the unseen run to use",
        "stay below it by putting the sensors of the unseen run to use",
    );
    say(
        &smooth,
        "stays below it, but so does a smooth curve through strain alone",
        "stay below it, but so do smooth curves through strain alone",
    );
    say(&alike, "comes to it", "come to it");
    say(&worse, "misses by more", "miss by more");
    Some(format!(
        "The yardstick is the scatter between samples: what an unseen run would be missed by if the training run were \
         repeated as the answer. {}.",
        parts.join("; ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_hybrid::Summary;
    use granum_hybrid::summary::PartScores;

    fn mapping(unseen: f64, strain_only: f64, best: f64) -> MappingSummary {
        MappingSummary {
            formula: "q/p = F1(ε_d, P(f))".into(),
            relative_rmse: PartScores { held_out: 0.5 * unseen, unseen: Some(unseen), strain_only },
            best_without_sensors: Some(best),
            ..Default::default()
        }
    }

    fn study(mappings: &[(&str, MappingSummary)]) -> StudyReport {
        let mappings = mappings.iter().map(|(name, m)| ((*name).to_owned(), m.clone())).collect();
        StudyReport { summary: Summary { mappings, ..Default::default() }, ..Default::default() }
    }

    #[test]
    fn sentences_follow_the_numbers() {
        let nothing = study(&[("F1", mapping(0.03, 0.03, 0.03)), ("F2", mapping(0.05, 0.051, 0.02))]);
        let text = findings(&nothing).join(" ");
        assert!(text.contains("No mapping does better") && text.contains("strain alone tells"), "{text}");
        assert!(
            text.contains("*F*_{1} comes to it") && text.contains("*F*_{2} (2.5 times) misses by more"),
            "{text}"
        );

        let some = study(&[("F1", mapping(0.01, 0.03, 0.03)), ("F2", mapping(0.09, 0.05, 0.05))]);
        let text = findings(&some).join(" ");
        assert!(
            text.contains("take error away in *F*_{1}") && text.contains("In *F*_{2} they make"),
            "{text}"
        );
        assert!(text.contains("*F*_{1} stays below it by putting"), "{text}");

        let smooth = study(&[("F1", mapping(0.02, 0.02, 0.03))]);
        assert!(findings(&smooth).join(" ").contains("so does a smooth curve through strain alone"));

        let all = study(&[("F1", mapping(0.01, 0.03, 0.03))]);
        assert!(findings(&all).join(" ").contains("Every mapping does better"));
        assert!(findings(&StudyReport::default()).is_empty() && tiles(&StudyReport::default()).is_empty());
    }

    #[test]
    fn tiles_count_what_the_sentences_say() {
        let study = study(&[("F1", mapping(0.01, 0.03, 0.03)), ("F2", mapping(0.09, 0.05, 0.05))]);
        let tiles = tiles(&study);
        assert_eq!(tiles[1][0], "1 of 2");
        assert_eq!(tiles[2][0], "1 of 2");
    }
}
