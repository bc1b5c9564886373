//! Reading a plan: all mistakes are reported at once, each with its place and what would be right.

use std::path::{Path, PathBuf};

use granum_core::names::suggestion;
use granum_io::shell::ShowPath;
use granum_io::{Case, Reading, Result, named_file};
use granum_run::engine::{LAMMPS, LammpsStart};
use toml::de::DeTable;

use super::definition::{Keep, Plan, PlanSource, PlanVariable, Spanned};
use super::expression::Condition;
use super::read_design::kinds;
use super::read_variables::VARIABLE_KEYS;
use super::reader::Reader;

/// The keys of a plan.
pub(super) const PLAN_KEYS: [&str; 10] =
    ["case", "set", "design", "variable", "constraints", "accept", "keep", "engine", "ranks", "command"];
/// Most processes of one run.
pub(super) const MOST_RANKS: u64 = 1 << 20;

impl Plan {
    /// Reads a plan and its base case.
    ///
    /// # Errors
    /// [`granum_io::Error::Inputs`] with all mistakes of the plan, and as [`Case::read`] for the base case.
    pub fn read(path: &Path, reading: Reading) -> Result<Plan> {
        Plan::parse(PlanSource::open(path)?, reading)
    }

    /// Reads the text of a plan and the base case that it names.
    ///
    /// # Errors
    /// As [`Plan::read`].
    pub fn parse(source: PlanSource, reading: Reading) -> Result<Plan> {
        Reader::read(source, reading, Reader::plan)
    }
}

impl Reader {
    fn plan(&mut self, table: &DeTable<'_>) -> Result<Option<Plan>> {
        self.refuse_unknown(table, &PLAN_KEYS, "plan");
        let Some((case_file, case)) = self.base_case(table)? else { return Ok(None) };
        let fixed = table.get("set").map_or_else(Vec::new, |node| self.fixed(node));
        let drafts = self.drafts(table.get("variable"), &VARIABLE_KEYS);
        let names: Vec<String> = drafts.iter().map(|draft| draft.name.clone()).collect();
        let Some(reference) = self.reference(&case, &fixed, &drafts) else { return Ok(None) };
        let variables: Vec<PlanVariable> =
            drafts.into_iter().filter_map(|draft| self.variable(draft, &reference)).collect();
        let constraints = self.conditions(table, "constraints");
        let accept = self.conditions(table, "accept");
        let keep = self.keep(table);
        let engine = table.get("engine").and_then(|node| self.text(node, "engine")).unwrap_or_default();
        let lammps = self.lammps(table, &engine);
        let design = match table.get("design") {
            Some(node) => self.design(node, &names)?,
            None => {
                let help = format!("add [design] with kind = one of {}", kinds().join(", "));
                self.error(0..0, "the plan has no design", &help);
                None
            }
        };
        let Some(design) = design else { return Ok(None) };
        let source = self.source.clone();
        let plan = Plan {
            source,
            case_file,
            case,
            fixed,
            variables,
            design,
            constraints,
            accept,
            keep,
            engine,
            lammps,
        };
        self.check_names(&plan, &reference, &names);
        self.check_design(&plan);
        Ok(Some(plan))
    }

    /// The base case that the key `case` names, and its file; `None` after a mistake that was noted.
    ///
    /// # Errors
    /// As [`Case::read`] for the case.
    pub fn base_case(&mut self, table: &DeTable<'_>) -> Result<Option<(PathBuf, Case)>> {
        let Some(node) = table.get("case") else {
            self.error(
                0..0,
                "the plan names no base case",
                "write e.g. case = \"sand.toml\" in its first line",
            );
            return Ok(None);
        };
        let Some(name) = self.text(node, "case") else { return Ok(None) };
        let case_file = match named_file(&self.source.folder, &name, self.reading.outside) {
            Ok(path) => path,
            Err(why) => {
                self.error(node.span(), format!("case = {name:?} {why}"), "");
                return Ok(None);
            }
        };
        if !case_file.is_file() {
            let message = format!("case = {name:?}: there is no file {}", case_file.shown());
            self.error(node.span(), message, "the name counts from the folder of the plan");
            return Ok(None);
        }
        let case = Case::read_as(&case_file, self.reading.clone())?;
        Ok(Some((case_file, case)))
    }

    /// How LAMMPS is started.
    fn lammps(&mut self, table: &DeTable, engine: &str) -> LammpsStart {
        let ranks = self.count(table, "ranks", 1, MOST_RANKS).map(|count| count as usize);
        let command = table.get("command").and_then(|node| self.text(node, "command"));
        let start = LammpsStart { ranks, command };
        let Some(key) = start.given() else { return start };
        let span = table.get(key).map_or(0..0, |node| node.span());
        if engine != LAMMPS {
            let message = format!("{key} says how LAMMPS is started, and the engine of this plan is another");
            self.error(span, message, "add engine = \"lammps\", or leave it out");
        } else if let Some(why) = start.fault() {
            self.error(span, why, "");
        }
        start
    }

    fn keep(&mut self, table: &DeTable) -> Keep {
        let Some(node) = table.get("keep") else { return Keep::default() };
        match self.text(node, "keep").as_deref() {
            None | Some("folders") => Keep::Folders,
            Some("dataset") => Keep::Dataset,
            Some(other) => {
                let help = suggestion(other, ["folders", "dataset"].into_iter());
                self.error(
                    node.span(),
                    format!("keep = {other:?} must be \"folders\" or \"dataset\""),
                    &help,
                );
                Keep::default()
            }
        }
    }

    /// The conditions of a list.
    pub fn conditions(&mut self, table: &DeTable, key: &str) -> Vec<Spanned<Condition>> {
        let Some(node) = table.get(key) else { return Vec::new() };
        let mut found = Vec::new();
        for item in self.array(node, key).into_iter().flat_map(|items| items.iter()) {
            let Some(text) = self.text(item, key) else { continue };
            match Condition::parse(&text) {
                Ok(value) => found.push(Spanned { value, span: item.span() }),
                Err(why) => self.error(item.span(), format!("{key}: {why}"), ""),
            }
        }
        found
    }
}
