//! The report of a small study: it is complete and self-contained, and the same data give identical bytes.

#[path = "../../../granum-report/tests/report/checks.rs"]
mod checks;
mod study;
#[path = "../../../granum-report/tests/report/synthetic.rs"]
mod synthetic;

use granum_antony2006::{StudyReport, speed_page, study_report};

use checks::{check, keep};

#[test]
fn a_study_has_the_papers_figures_and_tables_and_says_what_was_learned() {
    let study = study::study();
    let document = study_report(study);
    keep(&document, "study");
    check(&document);
    for id in [
        "networks",
        "tables",
        "claims",
        "reading",
        "sample",
        "behaviour",
        "forces",
        "quality",
        "reproducibility",
    ] {
        assert!(document.html.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    for k in 3..=8 {
        assert!(document.html.contains(&format!("<b>Figure {k}.</b>")), "Figure {k}");
        assert!(
            document.figures.iter().any(|(name, _)| *name == format!("figure-{k}.svg")),
            "figure-{k}.svg"
        );
    }
    for k in 1..=6 {
        assert!(document.html.contains(&format!("<b>Table {k}.</b>")), "Table {k}");
    }
    // The columns of the paper are present.
    assert!(document.html.contains("<td>60</td><td>60</td>") && document.html.contains("120\u{202f}000"));
    assert!(document.html.contains("Compression is positive"));
    let sentence = study.summary.reading[0].split(':').next_back().map(str::trim).unwrap_or("");
    assert!(!sentence.is_empty());
    assert!(document == study_report(study), "the same study is the same bytes");
    // Times depend on the computer and have a page of their own.
    let mut elsewhere = study.clone();
    elsewhere.summary.speed = Default::default();
    elsewhere.runs.iter_mut().for_each(|run| {
        (run.run.machine, run.run.wall_seconds) = Default::default();
    });
    assert!(document == study_report(&elsewhere), "the report depends on times");
    assert!(speed_page(&elsewhere).is_none());
    let speed = speed_page(study).expect("the times are known");
    keep(&speed, "speed");
    check(&speed);
    assert!(speed.html.contains("9000") || speed.html.contains("9\u{202f}000"), "{}", speed.html);
    let mut names: Vec<&String> = document.figures.iter().map(|(name, _)| name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), document.figures.len(), "every figure has a file of its own");
}

#[test]
fn figures_3_to_8_draw_lines_points_and_a_band_with_nothing_hidden() {
    let study = study::study();
    let document = study_report(study);
    for (k, data) in study.figures.iter().enumerate() {
        let (_, svg) = document
            .figures
            .iter()
            .find(|(name, _)| *name == format!("figure-{}.svg", k + 3))
            .expect("there");
        let drawn = roxmltree::Document::parse(svg).expect("well-formed");
        let with = |name: &str, value: &str| {
            drawn
                .descendants()
                .filter(|node| node.attribute(name).is_some_and(|v| v.starts_with(value)))
                .count()
        };
        assert!(with("fill-opacity", "0.2") >= data.panels.len(), "bands of figure {}", k + 3);
        let lines: usize = data.panels.iter().map(|panel| panel.lines.len()).sum();
        assert!(
            with("stroke-width", "1.6") + with("stroke-width", "1.4") >= lines,
            "lines of figure {}",
            k + 3
        );
        assert!(with("fill", "#ffffff") > data.panels.len(), "points of figure {}", k + 3);
    }
}

#[test]
fn a_study_without_anything_is_still_a_page() {
    let document = study_report(&StudyReport::default());
    check(&document);
    assert!(document.html.contains("What the networks learned"));
}
