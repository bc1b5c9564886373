//! The name of a column and the unit that stands with it in the header.

use granum_core::quantity::is_unit;

/// Ends of names that are units: `axial_stress_kPa`.
const ENDINGS: [(&str, &str); 4] = [("_percent", "%"), ("_kPa", "kPa"), ("_MPa", "MPa"), ("_Pa", "Pa")];
/// What stands between name and unit where there are no brackets: `eps / %`, `q in kPa`, `q, kPa`.
const BETWEEN: [&str; 3] = [" / ", " in ", ", "];

/// Name and unit of a header, e.g. of `axial_stress (kPa)`, `axial_stress [kPa]`, `axial_stress_kPa` or `axial_stress / kPa`; the unit is
/// empty if there is none.
pub(crate) fn split(cell: &str) -> (&str, &str) {
    let cell = cell.trim();
    for [open, close] in [['(', ')'], ['[', ']']] {
        let Some((name, rest)) = cell.split_once(open) else { continue };
        let rest = rest.trim_end();
        let inside = rest.strip_suffix(close).unwrap_or(rest);
        if !inside.contains(['(', ')', '[', ']', ';', '\t', '"']) {
            return (name.trim(), unit_of_cell(inside).unwrap_or(inside.trim()));
        }
    }
    for (ending, unit) in ENDINGS {
        if let Some(name) = cell.strip_suffix(ending) {
            return (name, unit);
        }
    }
    for between in BETWEEN {
        if let Some((name, unit)) = cell.rsplit_once(between)
            && let Some(unit) = unit_of_cell(unit).filter(|unit| !unit.is_empty())
        {
            return (name.trim(), unit);
        }
    }
    (cell, "")
}

/// The unit that a cell of a row of units holds, with or without brackets: empty for an empty cell, `1` for a dash.
pub(super) fn unit_of_cell(cell: &str) -> Option<&str> {
    let cell = cell.trim();
    let inside = [['(', ')'], ['[', ']']]
        .iter()
        .find_map(|[open, close]| cell.strip_prefix(*open)?.strip_suffix(*close));
    match inside.unwrap_or(cell).trim() {
        "-" | "–" | "—" => Some("1"),
        unit => is_unit(unit).then_some(unit),
    }
}

/// A name in the way of the names that granum knows: `Axial strain` as `axial_strain`.
pub(crate) fn plain(name: &str) -> String {
    name.trim().to_lowercase().replace([' ', '-', '\u{a0}', '\n', '\r'], "_")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_stand_in_many_ways() {
        for (cell, wanted) in [
            ("axial_stress (kPa)", ("axial_stress", "kPa")),
            ("sigma_1 [kPa]", ("sigma_1", "kPa")),
            ("eps_a(%)", ("eps_a", "%")),
            ("axial_strain [-]", ("axial_strain", "1")),
            ("axial_stress_kPa", ("axial_stress", "kPa")),
            ("axial_strain_percent", ("axial_strain", "%")),
            ("q / kPa", ("q", "kPa")),
            ("q in kPa", ("q", "kPa")),
            ("eps, %", ("eps", "%")),
            ("void_ratio", ("void_ratio", "")),
            ("q (psi)", ("q", "psi")),
            ("axial_strain (%);q (kPa)", ("axial_strain (%);q (kPa)", "")),
        ] {
            assert_eq!(split(cell), wanted, "{cell}");
        }
        assert_eq!(plain("Axial strain"), "axial_strain");
    }
}
