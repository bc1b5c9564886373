//! The case of a run, its grains, its digest, and the computer.

use maud::{Markup, html};

use super::data::RunReport;
use super::figure::literal;
use super::numbers::whole;
use super::page::paragraphs;

/// The number of grains, and the packing if they are from one.
pub fn whose_grains(run: &RunReport) -> String {
    let grains = format!("{} grains", whole(run.grains() as f64));
    match &run.run.packing {
        Some(packing) => format!("{grains} of {}", literal(&packing.file_name)),
        None => grains,
    }
}

/// The complete case and its digest. The computer and its times are in `seconds.json`, so that a report has the same bytes
/// everywhere.
pub fn case_details(run: &RunReport) -> Markup {
    let digest = run.case.digest_with(run.run.packing_digest());
    let mut facts = vec![match &run.run.packing {
        Some(packing) => {
            format!(
                "Case digest {digest}; packing {}, SHA-256 {}.",
                literal(&packing.file_name),
                packing.sha256
            )
        }
        None => format!("Case digest {digest}; seed {}.", run.case.preparation.seed),
    }];
    facts.extend(run.run.notes.iter().map(|note| literal(note)));
    html! {
        (paragraphs(&facts))
        details { summary { "The case in full" } pre tabindex="0" { (run.case.resolved_toml_with(run.run.packing.as_ref().map(|packing| packing.file_name.as_str()))) } }
    }
}
