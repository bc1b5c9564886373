//! Reading the design of a plan.

use granum_core::names::suggestion;
use granum_io::shell::ShowPath;
use granum_io::{Result, named_file};
use toml::Spanned as TomlSpanned;
use toml::de::{DeTable, DeValue};

use super::definition::{DesignKind, DesignTable, PlanRow, RowPlace, SampleSeeds};
use super::design::{ALL, DesignSize, MOST_POINTS, rows};
use super::reader::{Node, Reader};

/// The keys of a design.
pub(super) const DESIGN_KEYS: [&str; 7] =
    ["kind", "points", "seed", "replicates", "sample_seeds", "rows", "file"];

/// The kinds of design as a plan names them.
pub(super) fn kinds() -> Vec<&'static str> {
    ALL.iter().map(|design| design.name).chain(["list", "csv"]).collect()
}

impl Reader {
    pub(super) fn design(&mut self, node: &Node, variables: &[String]) -> Result<Option<DesignTable>> {
        let DeValue::Table(table) = node.get_ref() else {
            self.error(node.span(), "design must be a table", "write [design] with its keys below");
            return Ok(None);
        };
        self.refuse_unknown(table, &DESIGN_KEYS, "design");
        let Some(kind_node) = table.get("kind") else {
            self.error(
                node.span(),
                "the design has no kind",
                &format!("kind is one of {}", kinds().join(", ")),
            );
            return Ok(None);
        };
        let Some(word) = self.text(kind_node, "kind") else { return Ok(None) };
        let by_itself = ALL.into_iter().find(|design| design.name == word);
        let kind = match word.as_str() {
            "list" => match self.listed_rows(node, table) {
                Some(rows) => DesignKind::Rows(rows),
                None => return Ok(None),
            },
            "csv" => match self.csv_rows(node, table, variables)? {
                Some(rows) => DesignKind::Rows(rows),
                None => return Ok(None),
            },
            other => match by_itself {
                Some(design) => DesignKind::Points(design),
                None => {
                    let help = suggestion(other, kinds().into_iter());
                    self.error(kind_node.span(), format!("kind = {other:?} is no kind of design"), &help);
                    return Ok(None);
                }
            },
        };
        let points = self.count(table, "points", 1, MOST_POINTS as u64);
        let has_points = matches!(&kind, DesignKind::Points(design) if design.size != DesignSize::Levels);
        match (has_points, points, table.get("points")) {
            (true, None, None) => {
                self.error(kind_node.span(), format!("{word} needs points, the number of points"), "")
            }
            (false, Some(_), Some(node)) => {
                self.error(
                    node.span(),
                    format!("points has no effect on a design of kind {word}"),
                    "leave it out",
                );
            }
            _ => {}
        }
        for (key, of) in [("rows", "list"), ("file", "csv")] {
            if let Some(node) = table.get(key).filter(|_| word != of) {
                self.error(node.span(), format!("{key} belongs to a design of kind {of}"), "leave it out");
            }
        }
        let sample_seeds = match table.get("sample_seeds") {
            None => SampleSeeds::Same,
            Some(node) => match self.text(node, "sample_seeds").as_deref() {
                Some("same") => SampleSeeds::Same,
                Some("different") => SampleSeeds::Different,
                Some(other) => {
                    let message = format!("sample_seeds = {other:?} must be \"same\" or \"different\"");
                    self.error(node.span(), message, "");
                    SampleSeeds::Same
                }
                None => SampleSeeds::Same,
            },
        };
        let seed = self.count(table, "seed", 0, u64::from(u32::MAX)).unwrap_or(1) as u32;
        let replicates = self.count(table, "replicates", 1, 1000).unwrap_or(1) as usize;
        let points = points.map(|count| count as usize);
        Ok(Some(DesignTable { kind, points, seed, replicates, sample_seeds, span: kind_node.span() }))
    }

    pub(super) fn listed_rows(&mut self, design: &Node, table: &DeTable) -> Option<Vec<PlanRow>> {
        let Some(node) = table.get("rows") else {
            let help = "write rows = [{ friction = 0.2 }, { friction = 0.4 }]";
            self.error(design.span(), "a design of kind list needs rows", help);
            return None;
        };
        let mut rows = Vec::new();
        for item in self.array(node, "rows")?.iter() {
            let DeValue::Table(cells) = item.get_ref() else {
                self.error(item.span(), "a row must be a table", "write { friction = 0.2 }");
                return None;
            };
            let cell = |(key, node): (&TomlSpanned<_>, &Node)| -> Option<(String, String)> {
                let key: &std::borrow::Cow<str> = key.get_ref();
                Some((key.to_string(), self.scalar(node, key)?))
            };
            let cells = cells.iter().map(cell).collect::<Option<Vec<_>>>()?;
            rows.push(PlanRow { cells, place: RowPlace::Plan(item.span()) });
        }
        if rows.is_empty() {
            self.error(node.span(), "rows must have one row or more", "");
            return None;
        }
        Some(rows)
    }

    pub(super) fn csv_rows(
        &mut self,
        design: &Node,
        table: &DeTable,
        variables: &[String],
    ) -> Result<Option<Vec<PlanRow>>> {
        let Some(node) = table.get("file") else {
            self.error(design.span(), "a design of kind csv needs file, the name of a CSV file", "");
            return Ok(None);
        };
        let Some(name) = self.text(node, "file") else { return Ok(None) };
        let variables: Vec<&str> = variables.iter().map(String::as_str).collect();
        match named_file(&self.source.folder, &name, self.reading.outside) {
            Ok(path) if path.is_file() => rows::read_csv(&path, &variables).map(Some),
            Ok(path) => {
                let message = format!("file = {name:?}: there is no file {}", path.shown());
                self.error(node.span(), message, "the name counts from the folder of the plan");
                Ok(None)
            }
            Err(why) => {
                self.error(node.span(), format!("file = {name:?} {why}"), "");
                Ok(None)
            }
        }
    }
}
