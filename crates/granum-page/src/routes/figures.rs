//! The figures of runs, campaigns, studies and reproductions: those of their reports.

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::answer::{Answer, Answered};
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Most folders that are drawn over each other.
const MOST_FOLDERS: usize = 100;

/// The folders of an address: `path`, once or several times.
pub(super) fn places(site: &Site, query: &Query) -> Result<Vec<PathBuf>, Refused> {
    let paths: Vec<&str> = query.all("path").collect();
    if paths.is_empty() || paths.len() > MOST_FOLDERS {
        return Err(Refused::bad(format!("choose between 1 and {MOST_FOLDERS} folders")));
    }
    paths.into_iter().map(|path| site.place(path)).collect()
}

/// The figures of a report, with what stands below them: all at once, since those of a run under way change from one request to the next.
pub fn list(site: &Site, query: &Query) -> Answered {
    // A run that has not begun has nothing to draw, which is no mistake.
    let report = match site.report(&places(site, query)?) {
        Ok(report) => report,
        Err(refused) => return Ok(Answer::Json(json!({ "figures": [], "remarks": [refused.reason] }))),
    };
    let figure = |((name, svg), caption): (&(String, String), &String)| -> Value {
        json!({ "name": name, "title": title(svg), "caption": caption, "svg": svg })
    };
    let document = &report.document;
    let figures: Vec<Value> = document.figures.iter().zip(&document.captions).map(figure).collect();
    let remarks: Vec<String> = report.remarks.iter().map(|remark| site.without_root(remark)).collect();
    Ok(Answer::Json(json!({ "figures": figures, "remarks": remarks })))
}

/// One of them: `name`.
pub fn figure(site: &Site, query: &Query) -> Answered {
    let wanted = query.needed("name")?;
    let report = site.report(&places(site, query)?)?;
    let found = report.document.figures.iter().find(|(name, _)| name == wanted);
    let (_, svg) = found.ok_or_else(|| Refused::not_found(format!("there is no figure {wanted:?}")))?;
    Ok(Answer::Svg(svg.clone()))
}

/// What a figure shows, as it says itself.
fn title(svg: &str) -> String {
    let inner = svg.split_once("<title>").and_then(|(_, rest)| rest.split_once("</title>"));
    let text = inner.map_or("", |(text, _)| text);
    [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&#39;", "'"), ("&apos;", "'"), ("&amp;", "&")]
        .iter()
        .fold(text.to_string(), |text, (escape, sign)| text.replace(escape, sign))
}
