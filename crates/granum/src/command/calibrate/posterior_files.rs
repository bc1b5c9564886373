//! The posterior as files, which are written as soon as it is found, so that nothing is lost if its confirmation is interrupted.

use granum_calibration::posterior::outcome::Outcome;
use granum_calibration::simulations::simulation::{DesignPoint, of_test, plan, planned};
use granum_calibration::simulations::target::all_curves;
use granum_campaign::plan::VariableKind;
use granum_core::quantity::format_number;
use granum_io::shell::ShowPath;
use granum_io::{Column, Table, write_table};
use granum_report::calibration::corner_figure;

use super::calibration::Calibration;
use super::infer::Found;
use super::results::{put, write};
use crate::failure::Failure;

impl Calibration<'_> {
    /// Writes the posterior: its table, its draws, the file for ArviZ, its picture, and the cases to go on with.
    pub fn save_posterior(&self, found: &Found) -> Result<(), Failure> {
        let at = |name: &str| self.out.join(name);
        let table = self.posterior_table(found)?;
        for name in ["posterior.csv", "posterior.parquet"] {
            write_table(at(name), &table)?;
        }
        write_table(at("draws.parquet"), &draws_table(&found.outcome, &self.units())?)?;
        let inference = found.outcome.inference_data(&all_curves(self.targets));
        put(inference.to_string(), &at("inference_data.json"))?;
        put(corner_figure(&found.outcome).to_svg(), &at("posterior.svg"))?;
        self.cases(found)?;
        let then = if self.file.calibration.confirm > 0 { "; simulations confirm it next" } else { "" };
        self.context.note(&format!(
            "the posterior is written to {}: posterior.csv, draws.parquet, inference_data.json, posterior-mean.toml, draws.toml{then}",
            self.out.shown()
        ));
        Ok(())
    }

    /// A row for each coordinate of a posterior.
    pub fn posterior_table(&self, found: &Found) -> Result<Table, Failure> {
        Ok(found.outcome.table(&found.priors, &self.units())?)
    }

    /// SI units of the parameters.
    pub fn units(&self) -> Vec<String> {
        let of_variable = |free: &granum_calibration::file::FreeVariable| {
            vec![free.unit.clone(); if free.own { self.targets.len() } else { 1 }]
        };
        self.file.free.iter().flat_map(of_variable).collect()
    }

    /// The case of the posterior mean at the conditions of the first test, and the plan of a campaign of draws from the posterior that starts
    /// from it.
    fn cases(&self, found: &Found) -> Result<(), Failure> {
        let tests = self.targets.len();
        let simulation =
            |values: &[f64]| DesignPoint { test: 0, values: of_test(self.file, tests, values, 0) };
        let mean = simulation(&found.outcome.mean());
        let mut one = plan(self.file, self.targets, std::slice::from_ref(&mean));
        one.design.sample_seeds = granum_campaign::plan::SampleSeeds::Same;
        let planned = planned(&one)?;
        // It stays in its comment, whatever it holds.
        let test = granum_io::safe_text::line(&self.targets[0].name);
        if let Some(run) = planned.runs.first() {
            let head =
                format!("# The posterior mean of a calibration, at the conditions of the test {test}.\n\n");
            write(&self.out.join("posterior-mean.toml"), &(head + &run.case.readable_toml(None)?))?;
        }
        let draws = found.outcome.spread(self.file.calibration.draws);
        let mut text = format!(
            "# Draws from the posterior of a calibration, at the conditions of the test {test}: what they scatter is what the calibration \
             leaves open.\n\ncase = \"posterior-mean.toml\"\n\n[design]\nkind = \"list\"\nrows = [\n"
        );
        for draw in &draws {
            let cells = self.file.free.iter().zip(simulation(draw).values);
            let given = self.file.conditions.iter().zip(&self.targets[0].conditions);
            let cells: Vec<String> = cells
                .map(|(free, value)| format!("{} = {}", free.name, format_number(value)))
                .chain(given.map(|((name, _), value)| format!("{name} = {}", format_number(*value))))
                .collect();
            text += &format!("  {{ {} }},\n", cells.join(", "));
        }
        text += "]\n";
        for variable in &self.file.plan.variables {
            let keys: Vec<String> = variable.keys.iter().map(|key| format!("{:?}", key.value)).collect();
            text += &format!("\n[[variable]]\nname = {:?}\n", variable.name);
            if !keys.is_empty() {
                text += &format!("keys = [{}]\n", keys.join(", "));
            }
            if let VariableKind::Expression(expression) = &variable.kind {
                text += &format!("expression = {:?}\n", expression.value.text());
            }
        }
        write(&self.out.join("draws.toml"), &text)
    }
}

/// A row for each draw.
fn draws_table(outcome: &Outcome, units: &[String]) -> Result<Table, Failure> {
    let chains = outcome.values.first().into_iter().flatten().enumerate();
    let chain = chains.flat_map(|(k, draws)| vec![k as f64; draws.len()]).collect();
    let mut columns = vec![Column::new("chain", "", chain)];
    for (k, (name, values)) in outcome.names.iter().zip(&outcome.values).enumerate() {
        let unit = units.get(k).map_or("", String::as_str);
        columns.push(Column::new(name, unit, values.iter().flatten().copied().collect()));
    }
    Ok(Table::new(columns)?)
}
