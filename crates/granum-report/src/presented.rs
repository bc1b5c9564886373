//! What a run has found and whether it can be trusted, as data. The report of a run, the page over a folder of results and the laboratory in a
//! browser show the same: here it is put into words and numbers once, and each of them only draws it.

use serde_json::{Value, json};

use super::data::RunReport;
use super::figure::Rich;
use super::page::{Check, PageTable};
use super::{headline, strength, trust};
use granum_io::RunKind;

/// A result in words and numbers, with the markup of [`Rich`].
#[derive(Clone, Debug, Default)]
pub struct Presented {
    /// The main numbers: value, name and remark of each.
    pub tiles: Vec<[String; 3]>,
    /// The convention of signs and the meaning of symbols.
    pub signs: String,
    /// A remark on a test that did not reach its end.
    pub unfinished: Option<String>,
    /// Whether all checks are passed, in a sentence.
    pub verdict: String,
    /// The checks.
    pub checks: Vec<Check>,
    /// Strength and state at a glance, of a test that has them.
    pub strength: Option<PageTable>,
}

impl Presented {
    /// What a run has found.
    pub fn of_run(report: &RunReport) -> Presented {
        let is_test = report.run.kind == RunKind::Test;
        let runs = std::slice::from_ref(report);
        Presented {
            tiles: if is_test { headline::of_test(report) } else { headline::of_sample(report) },
            signs: if is_test { headline::signs(report).into() } else { String::new() },
            unfinished: (is_test && !report.is_complete()).then(|| headline::UNFINISHED.into()),
            verdict: trust::verdict(runs),
            checks: trust::checks(&report.run.quality),
            strength: strength::table(report).filter(|_| is_test),
        }
    }

    /// The same as JSON, with each marked-up text as its parts ([`Rich::parts`]).
    pub fn to_json(&self) -> Value {
        json!({
            "tiles": self.tiles.iter().map(|tile| tile.each_ref().map(|text| rich(text))).collect::<Vec<_>>(),
            "signs": rich(&self.signs),
            "unfinished": self.unfinished.as_deref().map(rich),
            "verdict": rich(&self.verdict),
            "checks": self.checks.iter().map(check).collect::<Vec<_>>(),
            "strength": self.strength.as_ref().map(table),
        })
    }
}

/// A check as JSON.
fn check(check: &Check) -> Value {
    let Check { passed, advice, .. } = check;
    let [name, before, value, after] =
        [&check.name, &check.before, &check.value, &check.after].map(|text| rich(text));
    json!({ "passed": passed, "name": name, "before": before, "value": value, "after": after, "advice": advice })
}

/// A table as JSON.
pub fn table(table: &PageTable) -> Value {
    let texts = |texts: &[String]| texts.iter().map(|text| rich(text)).collect::<Vec<_>>();
    json!({
        "label": table.label,
        "caption": rich(&table.caption),
        "groups": table.groups.iter().map(|(name, columns)| json!([rich(name), columns])).collect::<Vec<_>>(),
        "columns": texts(&table.columns),
        "rows": table.rows.iter().map(|row| texts(row)).collect::<Vec<_>>(),
        "words": table.words,
        "note": rich(&table.note),
    })
}

fn rich(markup: &str) -> Value {
    json!(Rich::new(markup).parts())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marked_up_text_is_told_in_parts() {
        assert_eq!(
            rich("peak *q*/*p*_{0} <b>").to_string(),
            r#"[["peak ",""],["q","i"],["/",""],["p","i"],["0","sub"],[" <b>",""]]"#
        );
        let check = Check {
            passed: false,
            name: "Inertial number".into(),
            before: String::new(),
            value: "2 × 10^{−3}".into(),
            after: " (at most 10^{−3})".into(),
            advice: "shear slower".into(),
        };
        let presented = Presented {
            tiles: vec![["1".into(), "*K*_{0}".into(), String::new()]],
            checks: vec![check],
            ..Presented::default()
        };
        let json = presented.to_json();
        assert_eq!(json["tiles"][0][1], json!([["K", "i"], ["0", "sub"]]));
        assert_eq!(json["checks"][0]["value"], json!([["2 × 10", ""], ["−3", "sup"]]));
        assert!(json["strength"].is_null() && json["unfinished"].is_null());
    }
}
