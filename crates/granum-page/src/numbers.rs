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

    #[test]
    fn gaps_and_infinities_stay_apart() {
        let text = numbers(&[1.0, f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 2.0]).to_string();
        assert_eq!(text, r#"[1.0,null,"inf","-inf",2.0]"#);
    }
}
