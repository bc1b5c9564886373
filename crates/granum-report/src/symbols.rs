//! Symbols in the notation of the paper.

/// Label of the strain axis of the paper's test.
pub const STRAIN: &str = "Deviator strain *ε*_{d}";

/// Marks up the symbols in a plain text from granum-learn: `φ_d` becomes φ with a subscript, `F1` an F with a subscript.
pub fn markup(text: &str) -> String {
    let mut out = text.to_owned();
    for (plain, marked) in
        [("ε_d", "*ε*_{d}"), ("φ_d", "*φ*_{d}"), ("q/p", "*q*/*p*"), ("P(f)", "*P*(*f*)"), (", f)", ", *f*)")]
    {
        out = out.replace(plain, marked);
    }
    for k in 1..=9 {
        out = out.replace(&format!("F{k}"), &mapping(&format!("F{k}")));
    }
    out
}

/// The marked-up name of a mapping.
pub fn mapping(name: &str) -> String {
    match name.strip_prefix('F') {
        Some(number) if !number.is_empty() => format!("*F*_{{{number}}}"),
        _ => name.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::figure::Rich;

    #[test]
    fn formulas_are_set_as_in_the_paper() {
        assert_eq!(
            Rich::new(&markup("q/p = F3(ε_d, φ_d, P(f))")).html(),
            "<i>q</i>/<i>p</i> = <i>F</i><sub>3</sub>(<i>ε</i><sub>d</sub>, <i>φ</i><sub>d</sub>, <i>P</i>(<i>f</i>))"
        );
        assert_eq!(Rich::new(&markup("F1: plain")).plain(), "F1: plain");
    }
}
