//! A history of strains and stresses, row by row: the points through which the loading path passes.

use serde::{Deserialize, Serialize};

use crate::servo::COMPONENTS;

/// Most rows of a history.
pub const MOST_ROWS: usize = 5000;

/// The quantity in a column of a history, with the number of its component ([`COMPONENTS`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum HistoryQuantity {
    /// Strain since the start of the test; shear strains are angles.
    Strain(u8),
    /// Stress, Pa.
    Stress(u8),
}

impl HistoryQuantity {
    /// Every quantity.
    pub fn all() -> impl Iterator<Item = HistoryQuantity> {
        (0..6).map(HistoryQuantity::Strain).chain((0..6).map(HistoryQuantity::Stress))
    }

    /// Its name, e.g. `xx_strain`.
    pub fn name(self) -> String {
        match self {
            HistoryQuantity::Strain(k) => format!("{}_strain", COMPONENTS[usize::from(k.min(5))]),
            HistoryQuantity::Stress(k) => format!("{}_stress", COMPONENTS[usize::from(k.min(5))]),
        }
    }

    /// The quantity of that name.
    pub fn named(name: &str) -> Option<HistoryQuantity> {
        HistoryQuantity::all().find(|quantity| quantity.name() == name)
    }

    /// The number of its component.
    pub fn component(self) -> usize {
        match self {
            HistoryQuantity::Strain(k) | HistoryQuantity::Stress(k) => usize::from(k.min(5)),
        }
    }
}

/// Points of a path: strains and stresses, compression positive. Components without a column are not strained.
///
/// ```
/// use granum_dem::loading::{History, HistoryQuantity};
///
/// let columns = vec![HistoryQuantity::Strain(0), HistoryQuantity::Stress(1)];
/// let history = History { columns, rows: vec![vec![0.0, 1e5], vec![0.02, 1e5]] };
/// assert_eq!(history.fault(), None);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct History {
    /// The quantity in each column.
    pub columns: Vec<HistoryQuantity>,
    /// One value per column in every row.
    pub rows: Vec<Vec<f64>>,
}

impl History {
    /// The fault of the history, if there is one, as the continuation of a sentence that begins with its name.
    pub fn fault(&self) -> Option<String> {
        if self.columns.is_empty() {
            return Some("has no column of strains or stresses, e.g. xx_strain or yy_stress".into());
        }
        for (k, column) in self.columns.iter().enumerate() {
            let other = self.columns[..k].iter().find(|other| other.component() == column.component());
            if let Some(other) = other {
                return Some(format!(
                    "has {} and {}, but a component of the cell can follow only one of them",
                    other.name(),
                    column.name()
                ));
            }
        }
        if self.rows.is_empty() || self.rows.len() > MOST_ROWS {
            return Some(format!("has {} rows; it must have 1 to {MOST_ROWS}", self.rows.len()));
        }
        let whole = |row: &Vec<f64>| row.len() == self.columns.len() && row.iter().all(|x| x.is_finite());
        let bad = self.rows.iter().position(|row| !whole(row))?;
        Some(format!(
            "has a row {} without a finite number for each of its {} columns",
            bad + 1,
            self.columns.len()
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantities_have_one_name_each_and_faults_are_named() {
        for quantity in HistoryQuantity::all() {
            assert_eq!(HistoryQuantity::named(&quantity.name()), Some(quantity));
        }
        let history = |columns: &[HistoryQuantity], rows: &[&[f64]]| History {
            columns: columns.to_vec(),
            rows: rows.iter().map(|row| row.to_vec()).collect(),
        };
        let (strain, stress) = (HistoryQuantity::Strain(0), HistoryQuantity::Stress(0));
        let fault = |history: History| history.fault().unwrap_or_default();
        assert!(fault(history(&[strain, stress], &[&[0.0, 0.0]])).contains("xx_strain and xx_stress"));
        assert!(fault(history(&[strain], &[])).contains("0 rows"));
        assert!(fault(history(&[strain], &[&[0.0], &[f64::NAN]])).contains("row 2"));
        assert!(fault(history(&[], &[&[]])).contains("no column"));
    }
}
