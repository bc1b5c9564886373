//! The number in a cell, and what is said of a cell that has none.

use super::decimal_mark::{DecimalMark, Evidence, evidence, leading_number};

/// Blanks and signs that separate thousands: `1 234`, `1'234`, with a narrow blank that breaks no line.
const THOUSANDS: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '\u{2019}'];

/// Words of what was not measured.
const MISSING: [&str; 8] = ["n/a", "na", "-", "–", "--", "nv", "#nv", "k.a."];

/// The number of a cell; `nan` and `inf` count as numbers, an empty cell does not.
///
/// # Errors
/// What the cell of the column is, and what would be right.
pub(super) fn number(column: &str, cell: &str, mark: DecimalMark) -> Result<f64, String> {
    if mark == DecimalMark::Point
        && let Ok(value) = cell.parse()
    {
        return Ok(value);
    }
    let plain = with_point(cell, mark);
    let refused = || refusal(column, cell, mark);
    if mark == DecimalMark::Comma && cell.contains('.') {
        return Err(refused());
    }
    plain.parse().map_err(|_| refused())
}

/// A cell whose leading number has a point for its mark and an ordinary sign.
pub(super) fn with_point(cell: &str, mark: DecimalMark) -> String {
    let number = leading_number(cell);
    let cell = cell.trim();
    if number.is_empty() {
        return cell.to_string();
    }
    let mut plain = number.replace('\u{2212}', "-");
    if mark == DecimalMark::Comma {
        plain = plain.replace(',', ".");
    }
    plain + &cell[number.len()..]
}

fn refusal(column: &str, cell: &str, mark: DecimalMark) -> String {
    let shown: String = cell.chars().take(40).collect();
    if cell.is_empty() {
        return format!("the cell of column {column} is empty; a number is needed");
    }
    let digits: String = cell.chars().filter(|c| !THOUSANDS.contains(c)).collect();
    let has_blanks = digits != cell && leading_number(&digits) == digits && !digits.is_empty();
    if has_blanks
        || evidence(cell) == Evidence::Thousands
        || (mark == DecimalMark::Comma && cell.contains('.'))
    {
        return thousands(column, &shown, mark);
    }
    let number = leading_number(cell);
    let unit = cell.trim()[number.len()..].trim();
    if !number.is_empty() && granum_core::quantity::is_unit(unit) && !unit.is_empty() {
        return format!(
            "{column} = {shown:?} is not a number: the unit belongs into the header, as {column} ({unit}), with a number alone in each cell"
        );
    }
    let lower = cell.to_lowercase();
    if MISSING.contains(&lower.as_str()) || cell.starts_with('#') {
        return format!("{column} = {shown:?} is not a number: a row without this reading must be left out");
    }
    format!("{column} = {shown:?} is not a number")
}

/// What is said of a number with a thousands separator.
pub(super) fn thousands(column: &str, shown: &str, mark: DecimalMark) -> String {
    let last = shown.rfind(['.', ',']);
    let plain: String = shown
        .char_indices()
        .filter_map(|(at, c)| match c {
            '.' | ',' => (Some(at) == last && shown.matches(c).count() == 1).then_some(mark.character()),
            c => (!THOUSANDS.contains(&c)).then_some(c),
        })
        .collect();
    format!(
        "{column} = {shown:?} has a thousands separator, which could be a decimal mark; write numbers without, e.g. {plain}"
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_one_mark() {
        use DecimalMark::{Comma, Point};
        assert_eq!(number("q", "-1.5e3", Point), Ok(-1500.0));
        assert_eq!(number("q", "-1,5E+03", Comma), Ok(-1500.0));
        assert_eq!(number("q", "\u{2212}0,5", Comma), Ok(-0.5));
        assert_eq!(number("q", "12", Comma), Ok(12.0));
        assert!(number("q", "nan", Point).unwrap().is_nan());
        for (cell, mark, part) in [
            (
                "1.234,5",
                Comma,
                "thousands separator, which could be a decimal mark; write numbers without, e.g. 1234,5",
            ),
            ("1,234.5", Point, "e.g. 1234.5"),
            ("1 234", Point, "thousands"),
            ("1'234.5", Point, "e.g. 1234.5"),
            ("1.234", Comma, "thousands"),
            ("0.5 %", Point, "as q (%)"),
            ("n/a", Point, "q = \"n/a\" is not a number: a row without this reading must be left out"),
            ("#DIV/0!", Point, "left out"),
            ("x", Comma, "q = \"x\" is not a number"),
            ("", Comma, "the cell of column q is empty; a number is needed"),
        ] {
            let said = number("q", cell, mark).unwrap_err();
            assert!(said.contains(part), "{cell}: {said}");
        }
    }
}
