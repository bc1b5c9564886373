//! Numbers in JSON, which has none for what is not finite.

use serde_json::{Value, json};

/// A number: what is not known is `null`, and an infinite one is a word, so that no reader takes it for zero or for a gap.
pub fn number(value: f64) -> Value {
    match value {
        _ if value.is_finite() => json!(value),
        f64::INFINITY => json!("inf"),
        f64::NEG_INFINITY => json!("-inf"),
        _ => Value::Null,
    }
}

/// A list of numbers.
pub fn numbers(values: &[f64]) -> Value {
    values.iter().map(|value| number(*value)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `tests/browser/browser.cjs` asks the same of `modules/numbers.js`.
    #[test]
    fn the_page_and_reports_write_numbers_alike() {
        let rows: Vec<(f64, String, String)> =
            serde_json::from_str(include_str!("../tests/browser/numbers.json")).unwrap();
        let raised = |c: char| {
            if c == '−' {
                '⁻'
            } else {
                "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c as usize - '0' as usize).unwrap()
            }
        };
        for (value, unit, text) in rows {
            let found = granum_report::numbers::quantity(value, &unit);
            let rich = granum_report::figure::Rich::new(&found);
            let part = |(text, kind): (&str, &str)| match kind {
                "sup" => text.chars().map(raised).collect(),
                _ => text.to_string(),
            };
            assert_eq!(rich.parts().into_iter().map(part).collect::<String>(), text, "{value} {unit}");
        }
    }

    #[test]
    fn gaps_and_infinities_stay_apart() {
        let text = numbers(&[1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0]).to_string();
        assert_eq!(text, r#"[1.0,null,"inf","-inf",2.0]"#);
    }
}
