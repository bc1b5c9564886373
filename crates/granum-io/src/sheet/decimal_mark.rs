//! The decimal mark of the numbers of a table, and whether there can be doubt about it.
//!
//! A point is the mark of decimals, or a comma is, in the whole of a table. The other one would then be a thousands separator. `1,234`
//! alone could be either; `0,125`, `12,5` and `1234,567` can only be decimals, and one such number decides for the table. Nothing is guessed:
//! what stays open is refused with the comment that decides it.

/// The decimal mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DecimalMark {
    /// `0.5`.
    Point,
    /// `0,5`.
    Comma,
}

impl DecimalMark {
    /// The mark of a word, `point` or `comma`.
    pub(crate) fn from_word(word: &str) -> Option<DecimalMark> {
        match word {
            "point" => Some(DecimalMark::Point),
            "comma" => Some(DecimalMark::Comma),
            _ => None,
        }
    }

    pub(super) fn character(self) -> char {
        match self {
            DecimalMark::Point => '.',
            DecimalMark::Comma => ',',
        }
    }

    pub(super) fn other(self) -> DecimalMark {
        match self {
            DecimalMark::Point => DecimalMark::Comma,
            DecimalMark::Comma => DecimalMark::Point,
        }
    }

    pub(super) fn word(self) -> &'static str {
        match self {
            DecimalMark::Point => "point",
            DecimalMark::Comma => "comma",
        }
    }
}

/// What one number says of the mark.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Evidence {
    /// No mark, or no number.
    None,
    /// Only this can be its mark.
    Certain(DecimalMark),
    /// Either its mark or a thousands separator.
    Open(DecimalMark),
    /// It has a thousands separator.
    Thousands,
}

/// What a number says of the mark.
pub(super) fn evidence(text: &str) -> Evidence {
    let number = leading_number(text);
    let unsigned = number.trim_start_matches(['+', '-', '\u{2212}']);
    let marks = || unsigned.char_indices().filter(|(_, c)| matches!(c, '.' | ','));
    let Some((at, mark)) = marks().next() else { return Evidence::None };
    if marks().count() > 1 {
        let groups = unsigned.split(['.', ',']).skip(1);
        let is_mixed = unsigned.contains('.') && unsigned.contains(',');
        let is_grouped = groups.clone().all(|group| group.len() == 3);
        // A date has several marks, too.
        return if is_mixed || is_grouped { Evidence::Thousands } else { Evidence::None };
    }
    let mark = if mark == '.' { DecimalMark::Point } else { DecimalMark::Comma };
    let (whole, decimals) = (&unsigned[..at], &unsigned[at + 1..]);
    let is_group = decimals.len() == 3 && decimals.bytes().all(|byte| byte.is_ascii_digit());
    match (1..=3).contains(&whole.len()) && !whole.starts_with('0') && is_group {
        true => Evidence::Open(mark),
        false => Evidence::Certain(mark),
    }
}

/// The number with which a text begins, also with marks of both kinds; empty if it begins with none.
pub(super) fn leading_number(text: &str) -> &str {
    let text = text.trim();
    let end = text
        .find(|c: char| !(c.is_ascii_digit() || matches!(c, '.' | ',' | '+' | '-' | '\u{2212}' | 'e' | 'E')))
        .unwrap_or(text.len());
    let number = &text[..end];
    // A unit may follow the number, but not a letter of a word that only begins with digits.
    let is_alone = text[end..].is_empty()
        || text[end..].starts_with([' ', '\u{a0}', '%', '\u{202f}'])
        || text[end..].starts_with(char::is_alphabetic);
    let number = number.trim_end_matches(['e', 'E', ',']);
    match is_alone && number.contains(|c: char| c.is_ascii_digit()) {
        true => number,
        false => "",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_tell_their_mark() {
        use DecimalMark::{Comma, Point};
        for (text, wanted) in [
            ("12", Evidence::None),
            ("n/a", Evidence::None),
            ("0,5", Evidence::Certain(Comma)),
            ("-0,125", Evidence::Certain(Comma)),
            ("1234,567", Evidence::Certain(Comma)),
            ("1,50E+03", Evidence::Certain(Comma)),
            (",5", Evidence::Certain(Comma)),
            ("0.125", Evidence::Certain(Point)),
            ("1,234", Evidence::Open(Comma)),
            ("123.456", Evidence::Open(Point)),
            ("1.234,5", Evidence::Thousands),
            ("1,234,567", Evidence::Thousands),
            ("50,5 kPa", Evidence::Certain(Comma)),
            ("hertz, dense", Evidence::None),
            ("01.02.2024", Evidence::None),
        ] {
            assert_eq!(evidence(text), wanted, "{text}");
        }
    }
}
