//! Reports from made-up data: everything is there, nothing points elsewhere, the same data give the same bytes.
//!
//! The pages are left in the target directory, so that one can look at them.

mod synthetic;

use granum::report::{self, Document, Role, RunReport};
use std::path::Path;

fn keep(document: &Document, name: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    document.write(&folder).expect("the report can be written");
    assert_eq!(std::fs::read_to_string(folder.join("report.html")).ok().as_ref(), Some(&document.html));
}

/// What every report must be.
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

/// Every element that is opened is closed in order; HTML's void elements apart.
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
    assert_eq!(document, report::run_report(&run), "the same run is the same bytes");
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
