//! The value of the section `[grains.shape]` of a case, and lists of spheres as text.

use granum_core::quantity::format_number;
use granum_dem::shape::ShapeEntry;
use granum_dem::shape::family::ALL;

use super::definition::Case;

/// The section, and the beginning of its keys.
pub(super) const SHAPE: &str = "grains.shape";
/// The only shape of a case, a sphere where none is given.
pub(super) fn only(case: &Case) -> ShapeEntry {
    case.grains.shapes.first().cloned().unwrap_or_default()
}

/// Changes the only shape of a case. A sphere about which nothing is said counts as not given.
pub(super) fn change(case: &mut Case, change: impl FnOnce(&mut ShapeEntry)) {
    let mut entry = only(case);
    change(&mut entry);
    case.grains.shapes = if entry.is_plain_sphere() { Vec::new() } else { vec![entry] };
}

/// The spheres of a shape from text: `[[x, y, z, radius], ...]`.
pub(super) fn parse_spheres(text: &str) -> std::result::Result<Vec<[f64; 4]>, String> {
    let plain: String = text.chars().filter(|c| !c.is_whitespace()).collect();
    let list = plain.strip_prefix('[').and_then(|rest| rest.strip_suffix(']')).ok_or_else(spheres_text)?;
    let mut spheres = Vec::new();
    for item in list.split(']').map(|item| item.trim_start_matches(',')).filter(|item| !item.is_empty()) {
        let numbers = item.strip_prefix('[').ok_or_else(spheres_text)?;
        let numbers: Vec<&str> = numbers.trim_end_matches(',').split(',').collect();
        spheres.push(sphere(&numbers)?);
    }
    if spheres.is_empty() { Err(spheres_text()) } else { Ok(spheres) }
}

/// One sphere from its four numbers.
pub(super) fn sphere(numbers: &[&str]) -> std::result::Result<[f64; 4], String> {
    let parsed: Vec<f64> = numbers.iter().filter_map(|number| number.parse().ok()).collect();
    let four: Option<[f64; 4]> = if parsed.len() == numbers.len() { parsed.try_into().ok() } else { None };
    four.filter(|sphere| sphere.iter().all(|x| x.is_finite())).ok_or_else(spheres_text)
}

/// What a list of spheres must be.
pub(super) fn spheres_text() -> String {
    "must be a list of spheres, each with its centre and radius in any unit of length, e.g. [[-0.5, 0, 0, 1], [0.5, 0, 0, 1]]".into()
}

/// A list of spheres as a case file has it.
pub(super) fn spheres_toml(spheres: &[[f64; 4]]) -> String {
    let sphere = |sphere: &[f64; 4]| format!("[{}]", sphere.map(format_number).join(", "));
    format!("[{}]", spheres.iter().map(sphere).collect::<Vec<_>>().join(", "))
}

/// Names and meanings of the families.
pub(super) fn kinds() -> Vec<[&'static str; 2]> {
    ALL.iter().map(|kind| [kind.name(), kind.family().description().help]).collect()
}
