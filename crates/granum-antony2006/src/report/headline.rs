//! The first page of a study: its main numbers and findings, which follow from explicit rules.

use crate::summary::MappingSummary;
use granum_learn::input_use::Verdict;

use super::StudyReport;
use granum_core::words::listed;
use granum_report::numbers::{factor, percent, significant};
use granum_report::sample;
use granum_report::symbols;

/// An error of up to this multiple of the best possible one without soft sensors counts as being as good as the scatter
/// permits.
const AS_GOOD: f64 = 1.1;
/// An error below this multiple of the best possible one without soft sensors counts as smaller.
const ALIKE: f64 = 0.95;

/// The relevant error: on unseen runs, or on held-out states if there are none.
fn error(mapping: &MappingSummary) -> f64 {
    mapping.relative_rmse.unseen.unwrap_or(mapping.relative_rmse.held_out)
}

/// Names of the mappings that satisfy a condition.
fn those(study: &StudyReport, condition: impl Fn(&MappingSummary) -> bool) -> Vec<String> {
    let mappings = study.summary.mappings.iter();
    mappings.filter(|(_, mapping)| condition(mapping)).map(|(name, _)| symbols::mapping(name)).collect()
}

/// Error over the best possible error of a prediction without the soft sensors of the unseen run.
fn over_best(mapping: &MappingSummary) -> Option<f64> {
    let best = mapping.best_without_sensors.filter(|best| *best > 0.0)?;
    Some(mapping.relative_rmse.unseen? / best)
}

/// The main numbers at the top of the page.
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
        out.push(many_runs_tile(study).unwrap_or_else(|| sensors_tile(study)));
    }
    if mappings.values().any(|mapping| over_best(mapping).is_some()) {
        let good = those(study, |mapping| over_best(mapping).is_some_and(|times| times <= AS_GOOD));
        out.push([
            format!("{} of {}", good.len(), mappings.len()),
            "mappings within the scatter of DEM".into(),
            "as close to an unseen run as runs with different seeds are to each other".into(),
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

/// Tile with the number of mappings that gain by their sensors.
fn sensors_tile(study: &StudyReport) -> [String; 3] {
    let mappings = &study.summary.mappings;
    let what = "mappings use their soft sensors and gain by it".to_owned();
    if mappings.values().all(|mapping| mapping.verdict == Verdict::TooFewRuns) {
        return ["–".to_owned(), what, "fewer than three unseen runs are too few to test".into()];
    }
    let gain = those(study, |mapping| mapping.verdict == Verdict::Gains).len();
    let used = those(study, |mapping| mapping.verdict == Verdict::WithoutGain).len();
    let remark = match used {
        0 => "by a t test over the unseen runs".to_owned(),
        1 => "1 more uses them without gain".to_owned(),
        _ => format!("{used} more use them without gain"),
    };
    [format!("{gain} of {}", mappings.len()), what, remark]
}

/// Tile with the number of mappings that gain by their sensors if they are trained on several runs.
fn many_runs_tile(study: &StudyReport) -> Option<[String; 3]> {
    let curve = study.summary.learning_curve.as_ref()?;
    let names: Vec<&String> = study.summary.mappings.keys().collect();
    let most = curve.points.iter().map(|point| point.training_runs).max()?;
    let gain = names.iter().filter(|name| curve.helps_from(name).is_some()).count();
    Some([
        format!("{gain} of {}", names.len()),
        "mappings gain by their soft sensors".into(),
        format!("with {most} training runs, on {} unseen ones", curve.unseen_runs),
    ])
}

/// The findings, as sentences.
pub fn findings(study: &StudyReport) -> Vec<String> {
    let mut out = Vec::new();
    if let Some(curve) = &study.summary.learning_curve {
        out.extend(curve.interpretation().iter().map(|text| symbols::markup(text)));
    }
    out.extend(errors_sentence(study));
    out.extend(sensors_sentence(study));
    out.extend(scatter_sentence(study));
    if let Some(size) = &study.summary.size_study {
        out.extend(crate::interpretation::read_size_study(size).iter().map(|text| symbols::markup(text)));
    }
    out.extend(sample::interpretation(&study.runs).into_iter().nth(1));
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
            parts.push(format!("{}: {}", symbols::markup(output), listed(&errors)));
        }
    }
    let where_to = if mappings.values().any(|m| m.relative_rmse.unseen.is_some()) {
        "On unseen DEM runs"
    } else {
        "On held-out states"
    };
    Some(format!("{where_to} the networks have these errors (relative RMSE): {}.", parts.join("; ")))
}

fn sensors_sentence(study: &StudyReport) -> Option<String> {
    let mappings = &study.summary.mappings;
    if mappings.is_empty() {
        return None;
    }
    let with = |verdict: Verdict| those(study, |mapping| mapping.verdict == verdict);
    let (gains, without) = (with(Verdict::Gains), with(Verdict::WithoutGain));
    let (unused, untold) = (with(Verdict::DoesNotUse), with(Verdict::TooFewRuns));
    let mut parts = Vec::new();
    let mut say = |names: &[String], one: &str, several: &str| {
        if !names.is_empty() {
            parts.push(format!("{} {}", listed(names), if names.len() == 1 { one } else { several }));
        }
    };
    say(&gains, "uses its soft sensors and gains by it", "use their soft sensors and gain by it");
    say(&without, "uses its sensors without gain", "use their sensors without gain");
    say(
        &unused,
        "does as well with another run\u{2019}s sensors as with its own, so it does not use them",
        "do as well with another run\u{2019}s sensors as with their own, so they do not use them",
    );
    if untold.len() == mappings.len() {
        let runs =
            mappings.values().filter_map(|mapping| mapping.help).map(|test| test.runs).max().unwrap_or(0);
        let found = match runs {
            0 => "there is no unseen run".to_owned(),
            1 => "there is only one unseen run".to_owned(),
            _ => format!("{runs} unseen runs are too few to test it"),
        };
        let of = match study.summary.learning_curve {
            Some(_) => " of the paper\u{2019}s protocol, trained on one run,",
            None => "",
        };
        return Some(format!("Whether the networks{of} use their soft sensors cannot be judged: {found}."));
    }
    say(&untold, "was tested on too few runs", "were tested on too few runs");
    let best =
        mappings.iter().filter(|(_, mapping)| mapping.verdict == Verdict::Gains).filter_map(|(name, m)| {
            let alone = m.relative_rmse.strain_only;
            (alone > 0.0).then_some((name, 1.0 - m.relative_rmse.unseen? / alone))
        });
    let best = best.max_by(|a, b| a.1.total_cmp(&b.1)).map_or(String::new(), |(name, share)| {
        format!(
            " The largest gain is in {}: {} of the error of strain-only networks.",
            symbols::mapping(name),
            percent(share)
        )
    });
    Some(format!(
        "Tested with the sensors of another unseen run in place of its own: {}.{best}",
        parts.join("; ")
    ))
}

fn scatter_sentence(study: &StudyReport) -> Option<String> {
    let judged: Vec<(&String, f64)> = (study.summary.mappings.iter())
        .filter_map(|(name, mapping)| Some((name, over_best(mapping)?)))
        .collect();
    if judged.is_empty() {
        return None;
    }
    let pick = |condition: &dyn Fn(f64) -> bool| -> Vec<String> {
        judged.iter().filter(|(_, times)| condition(*times)).map(|(name, _)| symbols::mapping(name)).collect()
    };
    let below = pick(&|times| times < ALIKE);
    let alike = pick(&|times| (ALIKE..=AS_GOOD).contains(&times));
    let worse: Vec<String> = (judged.iter().filter(|(_, times)| *times > AS_GOOD))
        .map(|(name, times)| format!("{} ({} times)", symbols::mapping(name), factor(*times)))
        .collect();
    let mut parts = Vec::new();
    let mut say = |names: &[String], one: &str, several: &str| {
        if !names.is_empty() {
            parts.push(format!("{} {}", listed(names), if names.len() == 1 { one } else { several }));
        }
    };
    say(&below, "stays below it", "stay below it");
    say(&alike, "equals it", "equal it");
    say(&worse, "exceeds it", "exceed it");
    Some(format!(
        "Error compared with the scatter between samples, that is with the error if an unseen run is predicted by the \
         mean of the training runs: {}.",
        parts.join("; ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::PaperSummary;
    use crate::summary::PartScores;
    use granum_learn::student_t::PairedTest;

    fn mapping(unseen: f64, best: f64, verdict: Verdict) -> MappingSummary {
        MappingSummary {
            formula: "q/p = F1(ε_d, P(f))".into(),
            relative_rmse: PartScores { held_out: 0.5 * unseen, unseen: Some(unseen), strain_only: 0.04 },
            best_without_sensors: Some(best),
            help: PairedTest::new(&[0.01, 0.011]),
            verdict,
            ..Default::default()
        }
    }

    fn study(mappings: &[(&str, MappingSummary)]) -> StudyReport {
        let mappings = mappings.iter().map(|(name, m)| ((*name).to_owned(), m.clone())).collect();
        StudyReport { summary: PaperSummary { mappings, ..Default::default() }, ..Default::default() }
    }

    #[test]
    fn sentences_follow_the_verdicts() {
        let all = study(&[
            ("F1", mapping(0.03, 0.03, Verdict::Gains)),
            ("F2", mapping(0.05, 0.02, Verdict::WithoutGain)),
            ("F3", mapping(0.01, 0.02, Verdict::DoesNotUse)),
        ]);
        let text = findings(&all).join(" ");
        assert!(
            text.contains("*F*_{1} uses its soft sensors and gains by it; *F*_{2} uses its sensors without"),
            "{text}"
        );
        assert!(
            text.contains("*F*_{3} does as well with another run\u{2019}s sensors as with its own"),
            "{text}"
        );
        assert!(text.contains("gain is in *F*_{1}: 25\u{202f}% of the error"), "{text}");
        assert!(
            text.contains("*F*_{3} stays below it; *F*_{1} equals it; *F*_{2} (2.5 times) exceeds"),
            "{text}"
        );
        assert_eq!(tiles(&all)[1][0], "1 of 3");
        assert_eq!(tiles(&all)[1][2], "1 more uses them without gain");
        assert_eq!(tiles(&all)[2][0], "2 of 3");

        let few = study(&[("F1", mapping(0.01, 0.03, Verdict::TooFewRuns))]);
        let text = findings(&few).join(" ");
        assert!(text.contains("cannot be judged: 2 unseen runs are too few to test it"), "{text}");
        assert_eq!(tiles(&few)[1][0], "–");
        assert!(findings(&StudyReport::default()).is_empty() && tiles(&StudyReport::default()).is_empty());
    }
}
