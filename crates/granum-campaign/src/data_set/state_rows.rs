//! The states of all runs as one table with the columns that any of them has.

use std::collections::BTreeMap;

use granum_io::formats::parquet::{ListColumn, TableWithLists};
use granum_io::{Column, ColumnKind, Result, Table};

/// The columns of the states of all runs.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct StateColumns {
    /// Flat columns without rows, in the order in which runs first had them, with the number of runs that have each.
    flat: Vec<(Column, usize)>,
    places: BTreeMap<String, usize>,
    lists: Vec<ListColumn>,
    runs: usize,
}

impl StateColumns {
    /// Adds those of a run.
    pub fn add(&mut self, states: &TableWithLists) {
        self.runs += 1;
        for column in states.table.columns() {
            match self.places.get(&column.name) {
                Some(place) => self.flat[*place].1 += 1,
                None => {
                    self.places.insert(column.name.clone(), self.flat.len());
                    let Column { name, unit, kind, .. } = column;
                    self.flat.push((Column::new(name, unit, Vec::new()).of_kind(*kind), 1));
                }
            }
        }
        for list in &states.lists {
            if !self.lists.iter().any(|known| known.name == list.name) {
                self.lists.push(ListColumn::new(&list.name, &list.unit));
            }
        }
    }

    /// The kind of a column: only real numbers can be missing.
    fn kind(&self, (column, runs): &(Column, usize)) -> ColumnKind {
        if column.has_words() || *runs == self.runs { column.kind } else { ColumnKind::Real }
    }

    /// The columns as a table without rows.
    pub fn empty(&self) -> Result<TableWithLists> {
        let column = |known: &(Column, usize)| known.0.clone().of_kind(self.kind(known));
        Ok(TableWithLists {
            table: Table::new(self.flat.iter().map(column).collect())?,
            lists: self.lists.clone(),
        })
    }

    /// The states of some runs below each other. A number that a run does not have is NaN, a list empty.
    pub fn below_each_other(&self, runs: &[TableWithLists]) -> Result<TableWithLists> {
        let column = |(place, known): (usize, &(Column, usize))| {
            let name = known.0.name.as_str();
            // Most runs have all columns in the same order.
            let own = |run: &'_ TableWithLists| -> Option<usize> {
                let at =
                    |place: usize| run.table.columns().get(place).is_some_and(|column| column.name == name);
                if at(place) { Some(place) } else { (0..run.table.columns().len()).find(|place| at(*place)) }
            };
            if known.0.has_words() {
                let mut words = Vec::new();
                for run in runs {
                    let column = own(run).map(|place| &run.table.columns()[place]);
                    words.extend(
                        (0..run.table.rows())
                            .map(|row| column.and_then(|own| own.word(row)).unwrap_or_default()),
                    );
                }
                return Column::of_words(name, words);
            }
            let mut values = Vec::new();
            for run in runs {
                match own(run) {
                    Some(place) => values.extend_from_slice(&run.table.columns()[place].values),
                    None => values.extend(std::iter::repeat_n(f64::NAN, run.table.rows())),
                }
            }
            Column::new(name, &known.0.unit, values).of_kind(self.kind(known))
        };
        let table = Table::new(self.flat.iter().enumerate().map(column).collect())?;
        let lists = self.lists.iter().map(|known| {
            let mut all = ListColumn::new(&known.name, &known.unit);
            for run in runs {
                match run.lists.iter().find(|list| list.name == known.name) {
                    Some(list) => list.lists().for_each(|values| all.push(values.iter().copied())),
                    None => (0..run.table.rows()).for_each(|_| all.push([])),
                }
            }
            all
        });
        Ok(TableWithLists { table, lists: lists.collect() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_with_different_columns_stand_below_each_other() {
        let counted = |values: Vec<f64>| Column::new("counted", "", values).of_kind(ColumnKind::Integer);
        let mut list = ListColumn::new("density", "");
        list.push([1.0, 2.0]);
        let one = TableWithLists {
            table: Table::new(vec![Column::of_words("run", ["a"]), counted(vec![7.0])]).unwrap(),
            lists: vec![list],
        };
        let x = Column::new("x", "m", vec![0.5, 0.6]);
        let two = TableWithLists {
            table: Table::new(vec![Column::of_words("run", ["b", "b"]), x]).unwrap(),
            lists: Vec::new(),
        };
        let mut columns = StateColumns::default();
        columns.add(&one);
        columns.add(&two);
        let all = columns.below_each_other(&[one, two]).unwrap();
        assert_eq!(all.table.names().collect::<Vec<_>>(), ["run", "counted", "x"]);
        let [counted, x] = ["counted", "x"].map(|name| all.table.get(name).unwrap());
        assert!(counted.values[0] == 7.0 && counted.values[1].is_nan() && x.values[0].is_nan());
        assert_eq!(
            (counted.kind, x.values[2], all.table.get("run").unwrap().word(2)),
            (ColumnKind::Real, 0.6, Some("b"))
        );
        assert_eq!(all.lists[0].lengths, [2, 0, 0]);
        assert_eq!(columns.empty().unwrap().table.get("counted").unwrap().kind, ColumnKind::Real);
    }
}
