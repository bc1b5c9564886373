//! Reports from synthetic data: they are complete and self-contained, and the same data give identical bytes.
//!
//! The pages are written to the target directory, where they can be inspected.

mod study;
mod synthetic;

use granum_report::{self as report, Document, Role, RunReport, StudyReport};
use std::path::Path;

fn keep(document: &Document, name: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    document.write(&folder).expect("the report can be written");
    assert_eq!(std::fs::read_to_string(folder.join("report.html")).ok().as_ref(), Some(&document.html));
}

/// Checks the properties that every report must have.
fn check(document: &Document) {
    for bad in ["http:", "https:", "<script", "src=", "url(", "@import", "NaN", "<link"] {
        assert!(!document.html.contains(bad), "the page contains {bad}");
    }
    assert_tags_close(&document.html);
    for (name, svg) in &document.figures {
        assert!(name.ends_with(".svg") && !name.contains(['/', '\\', ' ']), "{name}");
        assert!(svg.len() < 1_500_000, "{name} has {} bytes", svg.len());
        roxmltree::Document::parse(svg).unwrap_or_else(|error| panic!("{name}: {error}"));
    }
}

/// Asserts that all elements are closed in order, except the void elements of HTML.
fn assert_tags_close(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut rest = html;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap_or("");
        if tag.starts_with('!') || tag.ends_with('/') || matches!(name, "meta" | "br" | "hr" | "img" | "link")
        {
            continue;
        }
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "closing tag");
            continue;
        }
        open.push(name);
        if name == "style" {
            rest = &rest[rest.find("</style>").expect("the style ends")..];
        }
    }
    assert!(open.is_empty(), "{open:?}");
}

#[test]
fn a_run_has_every_section_and_figure() {
    let mut run = synthetic::run(Role::Single, 3);
    run.start = Some(synthetic::assembly(0.0));
    run.end = Some(synthetic::assembly(0.35));
    let document = report::run_report(&run);
    keep(&document, "run");
    check(&document);
    for id in ["behaviour", "forces", "quality", "case"] {
        assert!(document.html.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    for file in
        ["stress", "coordination", "fabric", "forces", "roses", "force-chains", "strong-network", "energy"]
    {
        assert!(document.figures.iter().any(|(name, _)| name.contains(file)), "{file}");
    }
    assert!(document.html.contains("Compression is positive"));
    assert!(document == report::run_report(&run), "the same run is the same bytes");
}

#[test]
fn a_run_without_anything_is_still_a_page() {
    let document = report::run_report(&RunReport::default());
    check(&document);
    assert!(document.html.contains("stopped before its end"));
}

#[test]
fn names_cannot_break_the_page() {
    let run = RunReport { name: "</title><b>\"&'".into(), ..Default::default() };
    let document = report::run_report(&run);
    check(&document);
    assert!(!document.html.contains("<b>\"&'"));
}

#[test]
fn a_study_has_the_papers_figures_and_tables_and_says_what_was_learned() {
    let study = study::study();
    let document = report::study_report(study);
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
    assert!(document == report::study_report(study), "the same study is the same bytes");
    let mut names: Vec<&String> = document.figures.iter().map(|(name, _)| name).collect();
    names.sort();
    names.dedup();
    assert_eq!(names.len(), document.figures.len(), "every figure has a file of its own");
}

#[test]
fn figures_3_to_8_draw_lines_points_and_a_band_with_nothing_hidden() {
    let study = study::study();
    let document = report::study_report(study);
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
    let document = report::study_report(&StudyReport::default());
    check(&document);
    assert!(document.html.contains("What the networks learned"));
}

#[test]
fn a_run_is_read_from_its_folder_as_it_was_written() {
    let mut run = synthetic::run(Role::Single, 5);
    run.start = Some(synthetic::assembly(0.0));
    run.end = Some(synthetic::assembly(0.2));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("run-5");
    {
        let out = granum_io::RunFolder::create(&path, false).expect("a new folder");
        out.write_case(&run.case, None).expect("written");
        out.write_record(&run.run).expect("written");
        granum_run::record::write_record(&out, &run.record).expect("written");
        for (name, assembly) in
            [(granum_run::laboratory::SAMPLE, &run.start), (granum_run::laboratory::END, &run.end)]
        {
            out.write_snapshot(name, assembly.as_ref().expect("set above")).expect("written");
        }
    }
    let read = RunReport::read(&granum_io::Run::at(&path).expect("a run"), Role::Single).expect("readable");
    assert_eq!(read.name, "run-5");
    for (found, written) in read.record.series.columns().iter().zip(run.record.series.columns()) {
        assert!(found == written, "{} differs", written.name);
    }
    assert!(read.record.histograms == run.record.histograms, "the histograms differ");
    assert!(read.case == run.case, "the case differs");
    let [written, again] = [&run, &read].map(|run| {
        let document = report::run_report(&RunReport { name: "same".into(), ..run.clone() });
        document.figures
    });
    assert!(written == again, "the figures of the folder are those of the run");
}
