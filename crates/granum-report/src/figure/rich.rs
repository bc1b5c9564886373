//! Text with italics, subscripts and superscripts, for labels in figures and for pages.
//!
//! Markup: `*q*` is italic, `_{d}` a subscript, `^{-3}` a superscript, and `\` escapes the next character. Italics may
//! contain subscripts and superscripts. Invalid markup is treated as plain text, so that no text is lost.

use super::svg::{Anchor, Point, Svg, escape, number};
use std::fmt::Write;

/// Fonts that exist on every system, with a generic fallback; all have about the widths of Helvetica.
pub const FONT: &str = "Helvetica, Arial, 'Liberation Sans', 'Nimbus Sans', sans-serif";

/// The vertical position of a span.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Script {
    Base,
    Sub,
    Super,
}

#[derive(Clone, Debug, PartialEq)]
struct Span {
    text: String,
    italic: bool,
    script: Script,
}

/// A parsed text.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Rich {
    spans: Vec<Span>,
}

/// Size of scripts relative to the text.
const SCRIPT_SIZE: f64 = 0.72;

/// Markup that shows a text letter by letter: for names that a user chose.
pub fn literal(text: &str) -> String {
    let mut markup = String::with_capacity(text.len());
    for c in text.chars() {
        if matches!(c, '*' | '_' | '^' | '\\') {
            markup.push('\\');
        }
        markup.push(c);
    }
    markup
}

impl Rich {
    /// Parses markup.
    pub fn new(markup: &str) -> Self {
        let mut rich = Rich::default();
        let chars: Vec<char> = markup.chars().collect();
        let (mut italic, mut k) = (false, 0);
        while k < chars.len() {
            let script = match chars[k] {
                '_' => Script::Sub,
                '^' => Script::Super,
                _ => Script::Base,
            };
            let close = if script != Script::Base && chars.get(k + 1) == Some(&'{') {
                chars[k..].iter().position(|&c| c == '}').map(|n| k + n)
            } else {
                None
            };
            if let Some(end) = close {
                rich.push_script(&chars[k + 2..end], script);
                k = end + 1;
            } else if chars[k] == '*' && (italic || chars[k + 1..].contains(&'*')) {
                italic = !italic;
                k += 1;
            } else {
                if chars[k] == '\\' && k + 1 < chars.len() {
                    k += 1;
                }
                rich.push(chars[k], italic, Script::Base);
                k += 1;
            }
        }
        rich
    }

    /// Adds the characters of a subscript or superscript, in which a pair of asterisks also marks italics.
    fn push_script(&mut self, chars: &[char], script: Script) {
        let mut italic = false;
        for &c in chars {
            if c == '*' {
                italic = !italic;
            } else {
                self.push(c, italic, script);
            }
        }
    }

    fn push(&mut self, c: char, italic: bool, script: Script) {
        // A hyphen before a digit is replaced by a minus sign.
        match self.spans.last_mut() {
            Some(last) if last.italic == italic && last.script == script => last.text.push(c),
            _ => self.spans.push(Span { text: c.to_string(), italic, script }),
        }
    }

    /// The text without its markup.
    pub fn plain(&self) -> String {
        self.spans.iter().map(|span| span.text.as_str()).collect()
    }

    /// The text as escaped HTML.
    pub fn html(&self) -> String {
        let mut out = String::new();
        for span in &self.spans {
            let mut text = escape(&span.text);
            if span.italic {
                text = format!("<i>{text}</i>");
            }
            match span.script {
                Script::Base => out.push_str(&text),
                Script::Sub => out.push_str(&format!("<sub>{text}</sub>")),
                Script::Super => out.push_str(&format!("<sup>{text}</sup>")),
            }
        }
        out
    }

    /// The text as data: its parts in their order, each a text with the names of what it is in HTML, as `"i"`, `"sub"` or `"sub i"`; none for
    /// upright text on the line.
    pub fn parts(&self) -> Vec<(&str, &'static str)> {
        let part = |span: &'_ Span| match (span.script, span.italic) {
            (Script::Base, false) => "",
            (Script::Base, true) => "i",
            (Script::Sub, false) => "sub",
            (Script::Sub, true) => "sub i",
            (Script::Super, false) => "sup",
            (Script::Super, true) => "sup i",
        };
        self.spans.iter().map(|span| (span.text.as_str(), part(span))).collect()
    }

    /// Width at a font size, px, by the widths of Helvetica.
    pub fn width(&self, size: f64) -> f64 {
        self.spans
            .iter()
            .map(|span| {
                let scale = if span.script == Script::Base { size } else { SCRIPT_SIZE * size };
                span.text.chars().map(character_width).sum::<f64>() * scale
            })
            .sum()
    }

    fn tspans(&self, size: f64) -> String {
        let mut out = String::new();
        let mut shift = 0.0;
        for span in &self.spans {
            let (wanted, font_size) = match span.script {
                Script::Base => (0.0, size),
                Script::Sub => (0.26 * size, SCRIPT_SIZE * size),
                Script::Super => (-0.36 * size, SCRIPT_SIZE * size),
            };
            let mut attributes = String::new();
            if wanted != shift {
                let _ = write!(attributes, " dy=\"{}\"", number(wanted - shift));
                shift = wanted;
            }
            if font_size != size {
                let _ = write!(attributes, " font-size=\"{}\"", number(font_size));
            }
            if span.italic {
                attributes.push_str(" font-style=\"italic\"");
            }
            let text = escape(&span.text);
            if attributes.is_empty() {
                out.push_str(&text);
            } else if let Some(rest) = text.strip_prefix(' ') {
                // Some programs drop a space at the start of a raised or lowered part.
                let _ = write!(out, "<tspan{attributes}>\u{a0}{rest}</tspan>");
            } else {
                let _ = write!(out, "<tspan{attributes}>{text}</tspan>");
            }
        }
        out
    }
}

/// The style of a text.
#[derive(Clone, Copy, Debug)]
pub struct TextStyle<'a> {
    /// Size, px.
    pub size: f64,
    /// Colour.
    pub color: &'a str,
    /// Position relative to its point.
    pub anchor: Anchor,
    /// True for bold text.
    pub bold: bool,
    /// True for text that is rotated by 90 degrees to the left.
    pub vertical: bool,
}

/// Draws marked-up text with its baseline at a point.
pub fn text(svg: &mut Svg, at: Point, markup: &str, style: TextStyle) {
    let rich = Rich::new(markup);
    if rich.spans.is_empty() {
        return;
    }
    let mut attributes = format!(
        "x=\"{}\" y=\"{}\" font-size=\"{}\" fill=\"{}\"",
        number(at[0]),
        number(at[1]),
        number(style.size),
        escape(style.color)
    );
    if style.anchor != Anchor::Start {
        let _ = write!(attributes, " text-anchor=\"{}\"", style.anchor.name());
    }
    if style.bold {
        attributes.push_str(" font-weight=\"bold\"");
    }
    if style.vertical {
        let _ = write!(attributes, " transform=\"rotate(-90 {} {})\"", number(at[0]), number(at[1]));
    }
    svg.raw(&format!("<text {attributes}>{}</text>\n", rich.tspans(style.size)));
}

/// Width of a character relative to the font size (Helvetica; characters that are not listed have the width of a digit).
fn character_width(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | '\'' => 0.222,
        '|' => 0.26,
        ' ' | 'f' | 't' | 'I' | '.' | ',' | ':' | ';' | '!' | '/' | '[' | ']' | '\u{a0}' | '·' => 0.278,
        'r' | '-' | '(' | ')' => 0.333,
        '"' => 0.355,
        's' | 'c' | 'k' | 'v' | 'x' | 'y' | 'z' | 'J' => 0.5,
        '−' | '+' | '=' | '<' | '>' | '×' | '±' | '≤' | '≥' | 'F' | 'T' | 'Z' => 0.6,
        'A' | 'B' | 'E' | 'K' | 'P' | 'S' | 'V' | 'X' | 'Y' | '&' => 0.667,
        'C' | 'D' | 'H' | 'N' | 'R' | 'U' | 'w' => 0.722,
        'G' | 'O' | 'Q' => 0.778,
        'm' | 'M' | '%' | '⟶' => 0.86,
        'W' | '@' | '—' => 1.0,
        '\u{2009}' => 0.2,
        '⟨' | '⟩' => 0.35,
        _ => 0.556,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_shown_letter_by_letter() {
        for name in ["*a*", "x_{1}^{2}", "back\\slash", "\\*", "plain name"] {
            assert_eq!(Rich::new(&literal(name)).plain(), name);
        }
    }

    #[test]
    fn markup_becomes_html() {
        assert_eq!(Rich::new("*q*/*p*").html(), "<i>q</i>/<i>p</i>");
        assert_eq!(Rich::new("*ε*_{d}").html(), "<i>ε</i><sub>d</sub>");
        assert_eq!(Rich::new("10^{−3} J/m^{2}").html(), "10<sup>−3</sup> J/m<sup>2</sup>");
        assert_eq!(Rich::new("a_{*i*}").html(), "a<sub><i>i</i></sub>");
        assert_eq!(Rich::new("a<b").html(), "a&lt;b");
    }

    #[test]
    fn broken_markup_loses_nothing() {
        for text in ["2 * 3", "a_b", "x^2", "a_{b", "}{", "\\", "snake_case_{", ""] {
            assert_eq!(Rich::new(text).plain(), text);
        }
        assert_eq!(Rich::new("\\*a\\*").plain(), "*a*");
    }

    #[test]
    fn scripts_return_to_the_base_line() {
        let mut svg = Svg::new();
        let style =
            TextStyle { size: 10.0, color: "#000", anchor: Anchor::Middle, bold: false, vertical: false };
        text(&mut svg, [0.0, 0.0], "a_{b}c", style);
        let body = svg.into_body();
        assert!(body.contains("dy=\"2.6\" font-size=\"7.2\">b</tspan>"), "{body}");
        assert!(body.contains("dy=\"-2.6\">c</tspan>"), "{body}");
    }

    #[test]
    fn width_grows_with_text() {
        assert!(Rich::new("0.25").width(10.0) < Rich::new("0.250").width(10.0));
        assert!(Rich::new("a_{b}").width(10.0) < Rich::new("ab").width(10.0));
    }
}
