//! Text of others in the places where granum shows it. Names of values, tests, columns, materials, files and folders may hold anything:
//! signs that move the cursor of a terminal or turn the direction of writing, marks of Markdown and HTML, formulas of a spreadsheet.
//! Nothing else in granum decides how they are shown; numbers are never changed.

use std::borrow::Cow;

/// Longest text of others that a message quotes.
const LONGEST_QUOTED: usize = 80;

/// True for a sign that a terminal or a viewer obeys instead of showing it: control characters, marks of the direction of writing,
/// separators of lines and paragraphs, invisible letters.
pub fn is_obeyed(c: char) -> bool {
    c.is_control()
        || matches!(c,
            '\u{61c}' | '\u{180e}' | '\u{200b}'..='\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2060}'..='\u{206f}'
            | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e007f}')
}

/// Appends a sign in the form `\n`, `\u001b` or `\udb40\udc01`, which is also that of JSON.
fn push_escaped(text: &mut String, c: char) {
    match c {
        '\n' => text.push_str("\\n"),
        '\t' => text.push_str("\\t"),
        '\r' => text.push_str("\\r"),
        c => c.encode_utf16(&mut [0; 2]).iter().for_each(|unit| text.push_str(&format!("\\u{unit:04x}"))),
    }
}

fn escaped_where(text: &str, is_escaped: impl Fn(char) -> bool) -> Cow<'_, str> {
    if !text.contains(&is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len() + 8);
    for c in text.chars() {
        if is_escaped(c) { push_escaped(&mut safe, c) } else { safe.push(c) }
    }
    Cow::Owned(safe)
}

/// A text for a terminal, with its lines: signs that a terminal obeys are shown as `\u001b`. Of a text in JSON the meaning stays.
///
/// ```
/// assert_eq!(granum_io::safe_text::terminal("a\n\u{1b}[31mb\u{202e}"), "a\n\\u001b[31mb\\u202e");
/// ```
pub fn terminal(text: &str) -> Cow<'_, str> {
    escaped_where(text, |c| is_obeyed(c) && !matches!(c, '\n' | '\t'))
}

/// A name for a terminal: it stays on its line.
pub fn line(text: &str) -> Cow<'_, str> {
    escaped_where(text, is_obeyed)
}

/// A text of others for a message: on one line, and no longer than can be read.
pub fn quoted(text: &str) -> String {
    let short: String = text.chars().take(LONGEST_QUOTED).collect();
    let more = text.chars().count() > LONGEST_QUOTED;
    format!("{}{}", line(&short), if more { "..." } else { "" })
}

/// A text in which each sign that a terminal obeys is replaced by as many bytes that it shows, so that places in it remain. Lines and tabs
/// stay.
pub fn of_same_length(text: &str) -> Cow<'_, str> {
    let is_replaced = |c: char| is_obeyed(c) && !matches!(c, '\n' | '\t' | '\r');
    if !text.contains(is_replaced) {
        return Cow::Borrowed(text);
    }
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match (is_replaced(c), c.len_utf8()) {
            (false, _) => safe.push(c),
            // The sign for what cannot be shown has three bytes.
            (true, 3) => safe.push(char::REPLACEMENT_CHARACTER),
            (true, length) => (0..length).for_each(|_| safe.push('?')),
        }
    }
    Cow::Owned(safe)
}

/// A text in Markdown, also in a cell of a table: no sign has a meaning.
///
/// ```
/// assert_eq!(granum_io::safe_text::markdown("<b>|a_b"), "&lt;b&gt;\\|a\\_b");
/// ```
pub fn markdown(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    let line = line(text);
    let end = line.len();
    for (at, c) in line.char_indices() {
        match c {
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '&' => safe.push_str("&amp;"),
            // An underscore within a word means nothing, but two words of a text may have one each.
            '\\' | '|' | '`' | '*' | '_' | '[' | ']' | '~' | '$' => safe.extend(['\\', c]),
            '#' | '+' | '-' | '=' if at == 0 && end > 1 && !begins_number(&line) => safe.extend(['\\', c]),
            c => safe.push(c),
        }
    }
    safe
}

/// A name in Markdown as code, or as other text where code could not hold it.
pub fn markdown_code(text: &str) -> String {
    let is_plain = |c: char| !is_obeyed(c) && !matches!(c, '`' | '|' | '<' | '>' | '&' | '\\');
    if text.chars().all(is_plain) { format!("`{text}`") } else { markdown(text) }
}

/// A text in HTML or XML: the five special signs are escaped.
pub fn html(text: &str) -> String {
    let mut safe = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => safe.push_str("&amp;"),
            '<' => safe.push_str("&lt;"),
            '>' => safe.push_str("&gt;"),
            '"' => safe.push_str("&quot;"),
            '\'' => safe.push_str("&#39;"),
            '\t' | '\n' => safe.push(' '),
            // XML has no way to write these.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => {
                safe.push(char::REPLACEMENT_CHARACTER)
            }
            c if is_obeyed(c) => push_escaped(&mut safe, c),
            c => safe.push(c),
        }
    }
    safe
}

/// A text for a cell of CSV, before it is quoted: a spreadsheet shows it and does not take it for a formula. What begins like one gets an
/// apostrophe before it, unless it is a number.
///
/// ```
/// use granum_io::safe_text::csv;
/// assert_eq!((csv("=A1").as_ref(), csv("-1.5e3").as_ref(), csv("-x").as_ref()), ("'=A1", "-1.5e3", "'-x"));
/// ```
pub fn csv(text: &str) -> Cow<'_, str> {
    // A quoted cell may have several lines, which are read back as they were.
    let safe = escaped_where(text, |c| is_obeyed(c) && c != '\n');
    let first = safe.trim_start().chars().next();
    let is_formula =
        matches!(first, Some('=' | '+' | '-' | '@' | '\u{ff1d}' | '\u{ff0b}' | '\u{ff0d}' | '\u{ff20}'));
    if is_formula && safe.trim().parse::<f64>().is_err() {
        return Cow::Owned(format!("'{safe}"));
    }
    safe
}

/// The text that [`csv()`] has made safe.
pub fn of_csv(cell: &str) -> &str {
    match cell.strip_prefix('\'') {
        Some(text) if csv(text).len() == cell.len() && csv(text) == cell => text,
        _ => cell,
    }
}

fn begins_number(text: &str) -> bool {
    text.chars().nth(1).is_some_and(|c| c.is_ascii_digit() || c == '.')
}

#[cfg(test)]
mod tests {
    use super::*;

    const NASTY: &str = "]]>&<b>\u{202e}X\u{1b}[31m\nnew|\u{9b}2J\u{e0041}";

    #[test]
    fn nothing_is_left_that_a_terminal_obeys() {
        assert_eq!(line(NASTY), "]]>&<b>\\u202eX\\u001b[31m\\nnew|\\u009b2J\\udb40\\udc41");
        assert_eq!(terminal("a\tb\r\nc"), "a\tb\\r\nc");
        assert!(matches!(terminal("grün 0.3 µm"), Cow::Borrowed(_)));
        let quoted = quoted(&"\u{1b}x".repeat(100));
        assert!(quoted.ends_with("...") && quoted.len() < 300 && !quoted.contains('\u{1b}'));
        for text in [NASTY, "x", "a\u{85}b"] {
            let same = of_same_length(text);
            assert_eq!(same.len(), text.len());
            assert!(!same.chars().any(|c| is_obeyed(c) && c != '\n'), "{same:?}");
        }
    }

    /// JSON means the same after it was made safe for a terminal.
    #[test]
    fn json_keeps_its_meaning() {
        let value = serde_json::json!({ "name": NASTY, "list": [1.5, "\u{feff}"] });
        let text = value.to_string();
        let safe = terminal(&text);
        assert!(safe.chars().all(|c| !is_obeyed(c)));
        assert_eq!(serde_json::from_str::<serde_json::Value>(&safe).unwrap(), value);
    }

    #[test]
    fn marks_have_no_meaning() {
        assert_eq!(html("<a href='x'>\u{202e}"), "&lt;a href=&#39;x&#39;&gt;\\u202e");
        let text = markdown("a|b\n# <script>*x* [l](u)");
        assert_eq!(text, "a\\|b\\\\n# &lt;script&gt;\\*x\\* \\[l\\](u)");
        assert_eq!(markdown("# x"), "\\# x");
        assert_eq!(markdown("-0.5 to 3 kPa"), "-0.5 to 3 kPa");
        assert_eq!(
            (markdown_code("stage.1.x").as_str(), markdown_code("a|b").as_str()),
            ("`stage.1.x`", "a\\|b")
        );
    }

    #[test]
    fn a_spreadsheet_sees_text_and_numbers_stay() {
        for number in ["-1", "+2e-3", "-.5", "-inf", "1", ""] {
            assert_eq!(csv(number), number);
        }
        for formula in ["=cmd|'/C calc'!A0", "+a", "-a", "@x", " =1", "-1+2", "\u{ff1d}1"] {
            let cell = csv(formula).into_owned();
            assert!(cell.starts_with('\''), "{cell}");
            assert_eq!(of_csv(&cell), formula);
        }
        assert_eq!((csv("\t=1").as_ref(), csv("a\nb").as_ref()), ("\\t=1", "a\nb"));
        assert_eq!((of_csv("'quoted'"), of_csv("x"), of_csv("'-1")), ("'quoted'", "x", "'-1"));
    }
}
