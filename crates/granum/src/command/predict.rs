//! `granum predict`: predictions of the networks of a study, or of a saved surrogate.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_antony2006::evaluation::networks;
use granum_antony2006::{Mapping, is_of_paper};
use granum_io::shell::ShowPath;
use granum_io::{check_output_file, write_table};
use granum_learn::networks::SubModelNetworks;
use granum_learn::study::Study;
use granum_learn::{LearnError, Surrogate};
use serde_json::json;

use super::family_flags::FamilyFlags;
use super::predict_family;
use super::predict_surrogate;
use super::prediction_input::{LEVEL, outside_text, row, rows};
use super::study_folder;
use super::trained_range::inputs;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Evaluate the networks of a study, or a saved surrogate: one row by flags, or many from a table.
///
/// The inputs are those of a state of a test, whatever the form of the networks: deviator_strain, deviator_fabric, stress_ratio,
/// every bin of P(f) (probability_density_0.125, ...) where the mapping has it as an input, and force where P(f) is the output.
/// The prediction is given with the interval that should contain 90 % of the states of unseen runs; for networks that were trained on
/// a single run it does not include the scatter between samples. A row outside the range on which a network was trained is also
/// answered, and is marked as outside: do not trust it. Without --set and --input the error lists the inputs with their ranges.
///
/// A surrogate in a file of its own (of a study of any columns, or saved by a program) is evaluated by its own columns, without
/// --mapping.
///
/// With --family the answer are the curves of a whole test of grains and a sample that were never simulated, from a surrogate that comes with
/// the program.
#[derive(Args)]
#[command(after_help = "Example:\n  granum predict study --mapping F4 --set deviator_strain=0.12 --set \
                  deviator_fabric=0.1 --set force=1.125\n  granum predict study --mapping F1 --input rows.csv -o predictions.csv\n  granum predict surrogate.json \
                  --set arc_length=0.1\n  granum predict --family sand --friction 0.4 --rolling-friction 0.2 --pressure \"100 kPa\" \\\n    \
                  --youngs-modulus \"2 GPa\" --void-ratio 0.7 -o curves.svg\n  granum predict --family sand case.toml --check\n  granum predict --family sand \
                  --card")]
pub struct Predict {
    /// Folder of the study that `granum train` left (or `models` of a reproduction), or the file of a surrogate; with --family a case
    /// file that gives the inputs.
    #[arg(required_unless_present = "family", value_name = "STUDY")]
    study: Option<PathBuf>,
    /// Mapping to ask (F1 to F6), or surrogate of a study of any columns (stress_ratio-ridge).
    #[arg(short, long, visible_alias = "model", value_name = "NAME")]
    mapping: Option<String>,
    /// One input of the state; every input must be given once.
    #[arg(short = 's', long = "set", value_name = "INPUT=VALUE", conflicts_with = "input")]
    values: Vec<String>,
    /// Table (CSV or Parquet) with a column for every input; other columns are ignored. With --family a row for each test, with a column for each
    /// property that is known, named as its flag, with the unit in brackets: `pressure (kPa)`.
    #[arg(short, long, value_name = "FILE")]
    input: Option<PathBuf>,
    /// File for the predictions (CSV or Parquet by extension); standard output by default. Of a family also a figure (SVG) or JSON.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    family: FamilyFlags,
}

impl Predict {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("predicting"));
        if let Some(family) = &self.family.family {
            let files = predict_family::Files {
                case: self.study.as_deref(),
                input: self.input.as_deref(),
                out: self.output.as_deref(),
            };
            return predict_family::run(context, family, &self.family, files);
        }
        if let Some(output) = self.output.as_ref().filter(|_| self.input.is_none()) {
            return Err(Failure::new(format!(
                "--output {}: it is for the rows of --input FILE, or for the curves of --family NAME",
                output.shown()
            )));
        }
        let Some(path) = &self.study else { return Err(Failure::new("give the folder of a study")) };
        if path.is_file() {
            return self.ask_file(context, path);
        }
        let study = study_folder::load(context, path)?;
        if !is_of_paper(&study.definition) {
            return self.ask_study(context, &study);
        }
        let Some(name) = &self.mapping else {
            let names = study.fits.iter().map(|fit| fit.name.as_str()).collect::<Vec<_>>().join(", ");
            return Err(Failure::new(format!("give a mapping as --mapping NAME; the study has {names}")));
        };
        // A baseline is asked by its own name.
        if let Ok(member) = study.member(name) {
            return self.ask(context, member.surrogate.as_ref());
        }
        let surrogate = networks(&study, name)?;
        match &self.input {
            Some(path) => self.many(context, surrogate, path),
            None => {
                let fit = study.fits.iter().find(|fit| fit.name == *name);
                let formula = fit.map(|fit| Ok::<_, LearnError>(Mapping::from_fit(&fit.spec)?.formula()));
                self.one(context, surrogate, &formula.transpose()?.unwrap_or_default())
            }
        }
    }

    /// Asks one of the surrogates of a study of any columns.
    fn ask_study(&self, context: &Context, study: &Study) -> Result<(), Failure> {
        let Some(name) = &self.mapping else {
            let names: Vec<&str> = study.members().map(|member| member.name.as_str()).collect();
            return Err(Failure::new(format!(
                "give a surrogate as --model NAME; the study has {}",
                names.join(", ")
            )));
        };
        self.ask(context, study.member(name)?.surrogate.as_ref())
    }

    fn ask_file(&self, context: &Context, path: &Path) -> Result<(), Failure> {
        if let Some(mapping) = &self.mapping {
            let path = path.shown();
            return Err(Failure::new(format!(
                "--mapping {mapping}: {path} is the file of one surrogate; only a study has mappings to choose from"
            )));
        }
        let surrogate = context.methods().load(path)?;
        self.ask(context, surrogate.as_ref())
    }

    fn ask(&self, context: &Context, surrogate: &dyn Surrogate) -> Result<(), Failure> {
        match &self.input {
            Some(path) => predict_surrogate::many(context, surrogate, path, self.output.as_deref()),
            None => predict_surrogate::one(context, surrogate, &self.values),
        }
    }

    fn one(&self, context: &Context, surrogate: &SubModelNetworks, formula: &str) -> Result<(), Failure> {
        let needs = || format!("{formula} needs:\n{}", inputs(surrogate, None));
        let row = row(context, &surrogate.input_names(), &|_| String::new(), &self.values, &needs)?;
        let predicted = surrogate.predict_row(&row, LEVEL)?;
        let network = &surrogate.networks()[predicted.sub_model];
        let output = &surrogate.mapping().output.name;
        let range = surrogate.mapping().sub_models[predicted.sub_model].range;
        let outside =
            predicted.outside.iter().map(|o| json!({ "input": o.name, "value": o.value, "range": o.range }));
        let result = json!({
            "mapping": surrogate.mapping().name,
            "output": output,
            "value": predicted.value,
            "standard_deviation": predicted.deviation.map(|deviation| deviation.total),
            "level": LEVEL,
            "lower": predicted.interval.map(|[lower, _]| lower),
            "upper": predicted.interval.map(|[_, upper]| upper),
            "runs_of_interval": network.blocks(),
            "constant": network.is_constant(),
            "sub_model": predicted.sub_model + 1,
            "strain_range": range,
            "outside": outside.collect::<Vec<_>>(),
        });
        let remarks = surrogate.remarks(&[predicted.sub_model]);
        remarks.iter().chain(&outside_text(&predicted.outside)).for_each(|text| context.warn_in_json(text));
        output::say(context, &result, || {
            let interval = predicted
                .interval
                .map_or(String::new(), |[lower, upper]| format!(", 90 % interval {lower:.6} to {upper:.6}"));
            let head = format!(
                "{output} = {:.6}{interval}  ({} sub-model {}, deviator strain {} to {})",
                predicted.value,
                surrogate.mapping().name,
                predicted.sub_model + 1,
                range[0],
                range[1]
            );
            let mut lines = vec![head];
            lines.extend(remarks);
            lines.extend(outside_text(&predicted.outside));
            lines.join("\n")
        })
    }

    fn many(&self, context: &Context, surrogate: &SubModelNetworks, path: &Path) -> Result<(), Failure> {
        if let Some(output) = &self.output {
            check_output_file(output, context.force)?;
        }
        let names = surrogate.input_names();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let table = rows(context, path, &names, &[], &|_| String::new())?;
        let predictions = surrogate.predict_table(&table, LEVEL).map_err(|error| match error {
            LearnError::Rows(reason) => Failure::new(format!("{}: {reason}", path.shown())),
            other => other.into(),
        })?;
        let warning = format!(
            "{} of {} rows lie outside the trained range (column outside is 1): do not trust their predictions",
            predictions.outside,
            predictions.table.rows()
        );
        if predictions.outside > 0 {
            context.warn(&warning);
        }
        surrogate.remarks(&predictions.sub_models).iter().for_each(|remark| context.note(remark));
        let Some(path) = &self.output else { return output::put_table(context, None, &predictions.table) };
        write_table(path, &predictions.table)?;
        let result = json!({
            "output": output::path(path),
            "rows": predictions.table.rows(),
            "rows_outside": predictions.outside,
            "constant_sub_models": surrogate.constants(&predictions.sub_models),
        });
        output::say(context, &result, || {
            format!("wrote {} rows to {}", predictions.table.rows(), path.shown())
        })
    }
}
