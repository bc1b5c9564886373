//! Several values of one key in one text, as a flag of the program takes them: `0.2,0.4,0.6`.
//!
//! The values stand between commas, in brackets or not: `0.2,0.4` and `[0.2, 0.4]` are two values. A key whose value is itself
//! a list takes a text such as `0.01,0.1` as one value, as ever; several lists are written as a list of lists,
//! `[[0.01, 0.1], [0.02, 0.2]]`. A key whose value is a file takes several files in brackets, `[a.csv, b.csv]`.

use granum_dem::loading::preset::PathParameterKind;

use super::case_stage::CaseStage;
use super::case_stage::{PREPARATION_STAGE, STAGE};
use super::definition::Case;
use super::stage::{place, stage_in};

/// What a value of a key is, as far as it decides how several of them are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ValueShape {
    /// A number with a fractional part, perhaps with a unit.
    Number,
    /// A whole number or a word.
    Plain,
    /// A list of numbers or names.
    List,
    /// A file, or a table of points.
    File,
}

impl Case {
    /// What the values of a key are: `grains.material.friction`, `recording.sensors`, `stage.1.axial_strain`.
    ///
    /// ```
    /// use granum_io::case::{Case, ValueShape};
    ///
    /// let case = Case::default();
    /// assert_eq!(case.shape_of("grains.material.friction"), ValueShape::Number);
    /// assert_eq!(case.shape_of("recording.strains"), ValueShape::List);
    /// ```
    pub fn shape_of(&self, key: &str) -> ValueShape {
        let preparation = (PREPARATION_STAGE, self.preparation_stages.as_slice());
        for (heading, stages) in [preparation, (STAGE, self.test.tables())] {
            if let Some(rest) = key.strip_prefix(heading).and_then(|rest| rest.strip_prefix('.')) {
                return shape_in_stage(stages, rest);
            }
        }
        let of_material = ["material.", "pair."].iter().any(|heading| key.starts_with(heading));
        match self.fields().named(key) {
            _ if of_material => ValueShape::Number,
            Some(field) if field.is_list() => ValueShape::List,
            Some(field) if field.is_curve() || field.is_spheres() => ValueShape::File,
            Some(field) if field.is_real() => ValueShape::Number,
            _ => ValueShape::Plain,
        }
    }
}

fn shape_in_stage(stages: &[CaseStage], rest: &str) -> ValueShape {
    let found = place(rest).and_then(|(numbers, key)| match stage_in(stages, &numbers)? {
        CaseStage::Path { path, .. } => path.parameter(key),
        _ => None,
    });
    match found.map(|parameter| parameter.kind) {
        Some(PathParameterKind::Number) => ValueShape::Number,
        Some(PathParameterKind::List) => ValueShape::List,
        Some(PathParameterKind::History) => ValueShape::File,
        Some(PathParameterKind::Word(_)) | None => ValueShape::Plain,
    }
}

/// The values in a text, one or several.
///
/// ```
/// use granum_io::case::{ValueShape, values_in};
///
/// assert_eq!(values_in("0.2,0.4", ValueShape::Number)?, ["0.2", "0.4"]);
/// assert_eq!(values_in("0.01,0.1", ValueShape::List)?, ["0.01,0.1"]);
/// assert_eq!(values_in("[[0.01, 0.1], [0.2]]", ValueShape::List)?, ["0.01, 0.1", "0.2"]);
/// # Ok::<(), String>(())
/// ```
///
/// # Errors
/// A sentence that continues "key = value": an empty value, a list of lists in which something is no list, or a text that can
/// be read as one number with a decimal comma and as two values.
pub fn values_in(text: &str, shape: ValueShape) -> Result<Vec<String>, String> {
    let text = text.trim();
    match shape {
        ValueShape::List => lists(text),
        ValueShape::File => files(text),
        ValueShape::Number if in_brackets(text).is_none() && may_be_a_decimal_comma(text) => {
            let pair = text.split_once(',').unwrap_or((text, ""));
            Err(format!(
                "can be one number with a decimal comma or two values; write {}.{} or [{}, {}]",
                pair.0, pair.1, pair.0, pair.1
            ))
        }
        ValueShape::Number | ValueShape::Plain => each(in_brackets(text).unwrap_or(text)),
    }
}

/// The text between brackets that enclose all of it.
fn in_brackets(text: &str) -> Option<&str> {
    let inner = text.strip_prefix('[')?.strip_suffix(']')?;
    let closes_early = inner.chars().try_fold(0i32, |depth, c| match c {
        '[' => Some(depth + 1),
        ']' if depth == 0 => None,
        ']' => Some(depth - 1),
        _ => Some(depth),
    });
    closes_early.map(|_| inner)
}

/// Values between commas, none of them empty.
fn each(text: &str) -> Result<Vec<String>, String> {
    let parts = apart(text);
    if parts.len() > 1 && parts.iter().any(|part| part.is_empty()) {
        return Err("has an empty value between its commas".into());
    }
    Ok(parts.into_iter().map(|part| unquoted(part).to_string()).collect())
}

/// One list, or the lists of a list of lists.
fn lists(text: &str) -> Result<Vec<String>, String> {
    let inner = in_brackets(text).unwrap_or(text);
    let parts = apart(inner);
    // The brackets of a single list belong to it.
    if !inner.trim_start().starts_with('[') {
        return Ok(vec![text.to_string()]);
    }
    let list = |part: &&str| in_brackets(part).map(|list| list.trim().to_string());
    parts
        .iter()
        .map(|part| {
            list(part).ok_or_else(|| {
                format!(
                    "is a list of lists in which {part:?} is no list; write it as [[0.01, 0.1], [0.02, 0.2]]"
                )
            })
        })
        .collect()
}

/// One file or one table of points, or several in brackets.
fn files(text: &str) -> Result<Vec<String>, String> {
    let Some(inner) = in_brackets(text) else { return Ok(vec![text.to_string()]) };
    let inner = inner.trim();
    // [[d, share], ...] is the table of one curve.
    if inner.starts_with('[') && !inner.starts_with("[[") {
        return Ok(vec![text.to_string()]);
    }
    each(inner)
}

/// The parts between the commas that are in no quotes, brackets or braces.
fn apart(text: &str) -> Vec<&str> {
    let (mut parts, mut from, mut depth, mut quoted) = (Vec::new(), 0, 0i32, false);
    for (at, c) in text.char_indices() {
        match c {
            '"' => quoted = !quoted,
            _ if quoted => {}
            '[' | '{' => depth += 1,
            ']' | '}' => depth -= 1,
            ',' if depth == 0 => {
                parts.push(text[from..at].trim());
                from = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[from..].trim());
    parts
}

/// The text without the quotes around it, which a case file needs and which the shell may have passed on.
pub(super) fn unquoted(text: &str) -> &str {
    let inner = text.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
    inner.filter(|inner| !inner.contains('"')).unwrap_or(text)
}

/// True for digits, a comma and digits, perhaps with a unit: `0,3`, `1,5 mm`.
fn may_be_a_decimal_comma(text: &str) -> bool {
    let Some((whole, rest)) = text.split_once(',') else { return false };
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let fraction: String = rest.chars().take_while(char::is_ascii_digit).collect();
    let tail = &rest[fraction.len()..];
    digits(whole.trim_start_matches('-')) && digits(&fraction) && !tail.contains([',', '.'])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn several(text: &str, shape: ValueShape) -> Vec<String> {
        values_in(text, shape).unwrap_or_else(|error| panic!("{text}: {error}"))
    }

    #[test]
    fn values_stand_between_commas_with_or_without_brackets() {
        for text in
            ["50 kPa,100 kPa", "[50 kPa, 100 kPa]", "\"50 kPa\" , \"100 kPa\"", "[\"50 kPa\",\"100 kPa\"]"]
        {
            assert_eq!(several(text, ValueShape::Number), ["50 kPa", "100 kPa"], "{text}");
        }
        assert_eq!(several("0.3", ValueShape::Number), ["0.3"]);
        assert_eq!(several("hertz,jkr", ValueShape::Plain), ["hertz", "jkr"]);
        assert_eq!(several("1,2", ValueShape::Plain), ["1", "2"], "whole numbers have no decimals");
        let error = values_in("0.2,,0.4", ValueShape::Number).unwrap_err();
        assert_eq!(error, "has an empty value between its commas");
    }

    #[test]
    fn a_decimal_comma_is_not_taken_for_two_values() {
        for text in ["0,3", "1,5 mm", "-0,1", "10,20"] {
            let error = values_in(text, ValueShape::Number).unwrap_err();
            assert!(
                error.starts_with("can be one number with a decimal comma or two values"),
                "{text}: {error}"
            );
        }
        assert_eq!(several("[0,3]", ValueShape::Number), ["0", "3"]);
        assert_eq!(several("0, 3", ValueShape::Number), ["0", "3"]);
        assert_eq!(several("0.1,3", ValueShape::Number), ["0.1", "3"]);
        assert_eq!(several("1,2,3", ValueShape::Number), ["1", "2", "3"]);
    }

    #[test]
    fn a_list_is_one_value_and_a_list_of_lists_several() {
        for text in ["0.01,0.1", "[0.01, 0.1]", "[\"void_ratio\", \"networks\"]"] {
            assert_eq!(several(text, ValueShape::List), [text], "{text}");
        }
        for text in ["[[0.01, 0.1], [0.2]]", "[0.01, 0.1], [0.2]"] {
            assert_eq!(several(text, ValueShape::List), ["0.01, 0.1", "0.2"], "{text}");
        }
        let error = values_in("[[0.01], 0.2]", ValueShape::List).unwrap_err();
        assert!(error.contains("in which \"0.2\" is no list"), "{error}");
    }

    #[test]
    fn a_table_of_points_is_one_value_and_files_stand_in_brackets() {
        for text in ["curve,1.csv", "[[1e-4, 0.5], [2e-4, 1]]"] {
            assert_eq!(several(text, ValueShape::File), [text]);
        }
        assert_eq!(several("[a.csv, b.csv]", ValueShape::File), ["a.csv", "b.csv"]);
        let two = "[[[1e-4, 1]], [[1e-4, 0.5], [2e-4, 1]]]";
        assert_eq!(several(two, ValueShape::File), ["[[1e-4, 1]]", "[[1e-4, 0.5], [2e-4, 1]]"]);
    }

    #[test]
    fn the_shape_follows_from_the_key() {
        let text = "[[stage]]\npath = 'drained-triaxial'\n[[stage]]\nrepeat = 2\n[[stage.stage]]\npath = 'cyclic'\n\
                    [[material]]\nname = 'a'\n";
        let case = Case::parse(text, "case.toml").unwrap();
        for (key, shape) in [
            ("stage.1.lateral_stress", ValueShape::Number),
            ("stage.2.1.strain_amplitude", ValueShape::Number),
            ("material.a.friction", ValueShape::Number),
            ("preparation.seed", ValueShape::Plain),
            ("contact.normal", ValueShape::Plain),
            ("contact.damping", ValueShape::Number),
            ("recording.sensors", ValueShape::List),
            ("grains.sieve_curve", ValueShape::File),
        ] {
            assert_eq!(case.shape_of(key), shape, "{key}");
        }
    }
}
