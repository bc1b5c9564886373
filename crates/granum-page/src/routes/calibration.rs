//! What a calibration found: its parameters, its tests, what speaks against it, and its figures.

use std::path::PathBuf;

use granum_io::shell::quoted_path;
use serde_json::{Map, Value, json};

use crate::answer::{Answer, Answered};
use crate::commands;
use crate::query::Query;
use crate::refused::Refused;
use crate::site::Site;

/// Largest file of results and of a figure that is read, bytes.
const LARGEST: u64 = 1 << 26;
/// What is shown of the results.
const SHOWN: [&str; 10] = [
    "granum_version",
    "method",
    "found_by",
    "tests",
    "predicted_tests",
    "parameters",
    "explains_the_tests",
    "against_the_posterior",
    "share_outside_intervals",
    "remarks",
];

fn folder(site: &Site, query: &Query) -> Result<PathBuf, Refused> {
    let place = site.place(query.needed("path")?)?;
    let is_one = place.join("calibration.json").is_file();
    is_one.then_some(place).ok_or_else(|| Refused::not_found("there is no calibration"))
}

/// The results: `path`.
pub fn calibration(site: &Site, query: &Query) -> Answered {
    let place = folder(site, query)?;
    let wrong =
        |error: &dyn ToString| Refused::unreadable(format!("calibration.json: {}", error.to_string()));
    let text = granum_core::input::read_text(&place.join("calibration.json"), LARGEST);
    let text = text.map_err(|error| wrong(&error))?;
    let all: Map<String, Value> = serde_json::from_str(&text).map_err(|error| wrong(&error))?;
    let mut shown: Map<String, Value> =
        all.into_iter().filter(|(name, _)| SHOWN.contains(&name.as_str())).collect();
    let named = site.folder.as_named(query.needed("path")?);
    let lines = [
        ("Predict with draws from it", "draws.toml", "granum campaign"),
        ("Its mean as a plan", "posterior-mean.toml", "granum campaign"),
    ];
    let lines =
        lines.into_iter().filter(|(_, file, _)| place.join(file).is_file()).map(|(what, file, program)| {
            commands::line(what, format!("{program} {} --dry-run", quoted_path(&named.join(file))))
        });
    shown.insert("commands".into(), lines.collect());
    shown.insert("figures".into(), json!(figures(&place)));
    Ok(Answer::Json(Value::Object(shown)))
}

/// The names of its figures.
fn figures(place: &std::path::Path) -> Vec<String> {
    let read = std::fs::read_dir(place.join("figures"));
    let names = read.into_iter().flatten().flatten().filter_map(|entry| entry.file_name().into_string().ok());
    let mut names: Vec<String> = names.filter(|name| is_figure(name)).collect();
    names.sort();
    names
}

/// True for the plain name of a figure.
fn is_figure(name: &str) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    name.ends_with(".svg") && !name.starts_with('.') && name.chars().all(plain)
}

/// One of its figures: `path`, `name`. It is shown as a picture, in which nothing is executed.
pub fn figure(site: &Site, query: &Query) -> Answered {
    let (place, name) = (folder(site, query)?, query.needed("name")?);
    let nothing = || Refused::not_found(format!("there is no figure {name:?}"));
    if !is_figure(name) {
        return Err(nothing());
    }
    let text = granum_core::input::read_text(&place.join("figures").join(name), LARGEST);
    Ok(Answer::Svg(text.map_err(|_| nothing())?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_have_plain_names() {
        assert!(is_figure("figure-s1-curves.svg"));
        for name in ["../secret.svg", "a/b.svg", ".svg", "report.html", "a\\b.svg", "a b.svg"] {
            assert!(!is_figure(name), "{name}");
        }
    }
}
