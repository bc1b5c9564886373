//! Tables 1-6, with the columns of the paper and those of this study.

use crate::mapping::{Mapping, paper_mappings};
use crate::summary::{MappingSummary, SubModelSummary};
use granum_learn::networks::SubModel;

use granum_report::numbers::{percent, trimmed, whole};
use granum_report::page::PageTable;
use granum_report::symbols;

/// Number of the table of a mapping in the paper.
pub fn table_number(mapping: &str) -> Option<usize> {
    let number: usize = mapping.strip_prefix('F')?.parse().ok()?;
    (1..=6).contains(&number).then_some(number)
}

/// The table of a mapping in the paper, together with the results of this study; `None` for a mapping that is not in the
/// paper.
pub fn table(name: &str, ours: &MappingSummary) -> Option<PageTable> {
    let paper: Mapping = paper_mappings().into_iter().find(|mapping| mapping.name == name)?;
    let label = format!("Table {}", table_number(name)?);
    let same_ranges = paper.sub_models.len() == ours.sub_models.len()
        && paper.sub_models.iter().zip(&ours.sub_models).all(|(a, b)| a.range == b.strain_range);
    let mut columns = vec!["No.", "Range of *ε*_{d}", "First layer", "Second layer", "Training epochs"];
    if !same_ranges {
        columns.push("Range of *ε*_{d}");
    }
    columns.extend(["Neurons", "Epochs", "Rows", "Weights in use", "Held-out", "Unseen"]);
    let caption = format!("Model for mapping {}.", symbols::markup(&ours.formula));
    let mut table = PageTable::new(&label, &caption, &columns);
    table.groups = vec![(String::new(), 1), ("Paper".into(), 4), ("Here".into(), columns.len() - 5)];
    let count = paper.sub_models.len().max(ours.sub_models.len());
    for k in 0..count {
        let mut cells = vec![(k + 1).to_string()];
        cells.extend(paper.sub_models.get(k).map_or_else(|| dashes(4), paper_cells));
        if !same_ranges {
            cells.push(ours.sub_models.get(k).map_or("–".to_owned(), |model| range(model.strain_range)));
        }
        cells.extend(ours.sub_models.get(k).map_or_else(|| dashes(6), our_cells));
        table.row(cells);
    }
    let mut trainers: Vec<&str> = ours.sub_models.iter().map(|model| model.trainer.as_str()).collect();
    trainers.dedup();
    if !trainers.is_empty() {
        table.note = format!("Trainer here: {}; {}.", trainers.join(", "), endings(&ours.sub_models));
    }
    Some(table)
}

fn dashes(count: usize) -> Vec<String> {
    vec!["–".to_owned(); count]
}

fn range([low, high]: [f64; 2]) -> String {
    // Word joiners prevent a line break at the dash.
    format!("{}\u{2060}–\u{2060}{}", trimmed(low), trimmed(high))
}

fn neurons(hidden: &[usize]) -> String {
    hidden.iter().map(usize::to_string).collect::<Vec<_>>().join("\u{a0}+\u{a0}")
}

fn paper_cells(model: &SubModel) -> Vec<String> {
    let layer = |k: usize| model.hidden.get(k).map_or("–".to_owned(), usize::to_string);
    vec![
        range(model.range),
        layer(0),
        layer(1),
        model.epochs.map_or("–".to_owned(), |epochs| whole(epochs as f64)),
    ]
}

fn our_cells(model: &SubModelSummary) -> Vec<String> {
    let unseen = if model.unseen.states > 0 { percent(model.unseen.relative_rmse) } else { "–".to_owned() };
    vec![
        neurons(&model.hidden),
        whole(model.epochs as f64),
        whole(model.rows as f64),
        if model.constant {
            "a constant".to_owned()
        } else {
            model.effective_parameters.map_or("–".to_owned(), whole)
        },
        percent(model.held_out.relative_rmse),
        unseen,
    ]
}

/// The reasons why training ended, without repetitions.
fn endings(models: &[SubModelSummary]) -> String {
    let mut reasons: Vec<String> =
        models.iter().map(|model| model.termination.replace(['_', '-'], " ")).collect();
    reasons.sort();
    reasons.dedup();
    format!("training ended by: {}", reasons.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_columns_stand_beside_ours() {
        let ours = MappingSummary {
            formula: "q/p = F1(ε_d, P(f))".into(),
            sub_models: vec![SubModelSummary {
                strain_range: [0.0, 0.1],
                hidden: vec![60, 60],
                epochs: 37,
                trainer: "levenberg-marquardt".into(),
                termination: "no_more_progress".into(),
                effective_parameters: Some(61.4),
                ..Default::default()
            }],
            ..Default::default()
        };
        let table = table("F1", &ours).unwrap();
        assert_eq!(table.rows.len(), 3);
        let cells: Vec<String> = table.rows[0].iter().map(|cell| cell.replace('\u{2060}', "")).collect();
        assert_eq!(
            cells[..8],
            ["1", "0–0.1", "60", "60", "120\u{202f}000", "0–0.1", "60\u{a0}+\u{a0}60", "37"]
        );
        assert_eq!(table.rows[2][5], "–");
        assert!(table.note.contains("no more progress"));
        assert!(super::table("F7", &ours).is_none());
        assert!(table.rows.iter().all(|row| row.len() == table.columns.len()));
    }
}
