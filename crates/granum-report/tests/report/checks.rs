//! What every report must fulfil.

use std::path::Path;

use granum_report::Document;

/// Writes the report to the target directory, where it can be inspected.
pub fn keep(document: &Document, name: &str) {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    document.write(&folder).expect("the report can be written");
    assert_eq!(std::fs::read_to_string(folder.join("report.html")).ok().as_ref(), Some(&document.html));
}

/// Checks the properties that every report must have.
pub fn check(document: &Document) {
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
