//! What is in the folder that is served.

use std::cmp::Reverse;

use granum_core::parallel;
use granum_io::shell::{ShowPath, quoted_path};
use serde_json::{Map, Value, json};

use crate::answer::{Answer, Answered};
use crate::listing::{Found, Kind, scan, told};
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Rows of a list, and the most that are asked for at once.
const ROWS: (usize, usize) = (100, 1000);

/// A part of the list: `kind` and `filter` (a part of the path) choose, `order` is `newest` or `name`, `from` and `count` are the rows.
pub fn list(site: &Site, query: &Query) -> Answered {
    let from = query.count("from", 0)?;
    let count = query.count("count", ROWS.0)?.min(ROWS.1);
    let scan = scan(site.folder.root());
    let counts: Map<String, Value> = Kind::ALL
        .iter()
        .map(|kind| (*kind, scan.found.iter().filter(|found| found.kind == *kind).count()))
        .map(|(kind, count)| (kind.word().to_string(), json!(count)))
        .collect();
    let chosen = chosen(site, query, scan.found)?;
    let rows = chosen.get(from..).unwrap_or(&[]);
    let rows = &rows[..count.min(rows.len())];
    let row = |k: usize| -> Result<Value, Refused> {
        let (path, found) = &rows[k];
        let mut about =
            told(found, found.kind != Kind::Run || site.folder.check_content(&found.place).is_ok());
        about.insert("path".into(), json!(path));
        Ok(Value::Object(about))
    };
    // The present folder has no name of its own.
    let named = site.folder.named();
    let shown = if named == std::path::Path::new(".") { site.folder.root() } else { named };
    Ok(Answer::Json(json!({
        "folder": shown.shown(),
        "version": site.program.version(),
        "counts": counts,
        "is_cut": scan.is_cut,
        "total": chosen.len(),
        "from": from,
        "rows": parallel::map(rows.len(), 0, row)?,
        "command": format!("granum table {}", quoted_path(named)),
    })))
}

/// What is asked for, with its path, in the order that is asked for.
fn chosen(site: &Site, query: &Query, found: Vec<Found>) -> Result<Vec<(String, Found)>, Refused> {
    let kind = match query.get("kind").filter(|word| !word.is_empty()) {
        Some(word) => {
            Some(Kind::named(word).ok_or_else(|| Refused::bad(format!("there is no kind {word:?}")))?)
        }
        None => None,
    };
    let filter = query.get("filter").unwrap_or("").to_lowercase();
    let mut chosen: Vec<(String, Found)> = found
        .into_iter()
        .filter(|found| kind.is_none_or(|kind| found.kind == kind))
        .filter_map(|found| Some((site.folder.inside(&found.place)?, found)))
        .filter(|(path, _)| filter.is_empty() || path.to_lowercase().contains(&filter))
        .collect();
    match query.get("order").unwrap_or("newest") {
        "newest" => chosen.sort_by_key(|(_, found)| Reverse(found.modified)),
        "name" => chosen.sort_by(|a, b| a.0.cmp(&b.0)),
        other => return Err(Refused::bad(format!("there is no order {other:?}; there are newest and name"))),
    }
    Ok(chosen)
}
