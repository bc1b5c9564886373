//! `granum measure`: every sensor on one assembly or on a series of them, of granum or of another program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::quantity::format_number;
use granum_core::{Assembly, Column, Part, Parts, Table};
use granum_dem::config::Recording;
use granum_io::Case;
use granum_io::formats::ObservedAssembly;
use granum_io::shell::ShowPath;
use granum_run::laboratory::observed_packing;
use granum_sensors::{MeasuredSeries, Measurement, ParameterDefault, SensorColumn, SensorParameter, Sensors};
use serde_json::{Map, Value, json};

use super::sources::SourceFlags;
use super::whole::open_run;
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Measure an assembly with every sensor that its data allow, and say which sensors cannot be applied and what they lack.
///
/// The data are a snapshot of a run folder, a packing (with --case the forces of its contacts follow from the contact law), or results of another program, as they are: LAMMPS and LIGGGHTS dumps and data files, text and VTK of YADE,
/// .data, .fstat and restart of MercuryDPM, extended XYZ, GSD, or tables (CSV, Parquet) of grains, with the columns id,
/// position_x ... and any others of a snapshot, and of contacts, with first, second and any others. Several files are joined,
/// and several instants make a series. Without contacts among the data, grains that overlap touch; a table of contacts is held
/// against the grains beside it, and what was set right or is doubtful is said.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum measure run-1\n  granum measure packing.csv --case my-sand.toml\n  granum measure grains.csv \
                  contacts.csv --cell \"2 mm, 2 mm, 2 mm\"\n  granum measure grains.dump contacts.dump --columns \
                  contacts.dump=index,patom1,patom2,fx,fy,fz,p1,p2,p3 --output series.parquet\n  granum measure --list"
)]
pub struct Measure {
    /// A run folder, a packing file, or files of results of another program.
    #[arg(required_unless_present_any = ["list", "grains"], value_name = "DATA")]
    data: Vec<PathBuf>,
    #[command(flatten)]
    sources: SourceFlags,
    /// Snapshot of the run folder; the one at its end by default.
    #[arg(long, value_name = "NAME", requires = "data")]
    snapshot: Option<String>,
    /// Case whose material and contact law give the forces of a packing.
    #[arg(long, value_name = "FILE", requires = "data")]
    case: Option<PathBuf>,
    /// Table of grains (CSV or Parquet) of another program, in SI units: the same as to give it among the data.
    #[arg(long, value_name = "FILE", conflicts_with = "data")]
    grains: Option<PathBuf>,
    /// Table of contacts of another program, beside that of the grains.
    #[arg(long, value_name = "FILE", requires = "grains")]
    contacts: Option<PathBuf>,
    /// List the sensors with their columns and what they need, and measure nothing.
    #[arg(long, conflicts_with_all = ["data", "grains"])]
    list: bool,
    /// Where to write the values as a table of one row an instant (CSV or Parquet by extension).
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Measure {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("measuring"));
        let sensors = context.vocabulary().sensors();
        if self.list {
            return list(context, sensors);
        }
        let observations = self.read(context)?;
        let parameters = self.parameters(context)?;
        let recording = Recording::default().with(|recording| recording.parameters = parameters);
        if let [one] = &observations[..] {
            let measured = sensors.measure_with(&one.assembly, one.parts, &recording);
            let rows = measured.columns.iter().map(|(column, value)| (*column, vec![*value])).collect();
            self.write(context, rows)?;
            return output::say(context, &as_json(one, &measured), || text(one, &measured));
        }
        let views: Vec<(&Assembly, Parts)> =
            observations.iter().map(|one| (&one.assembly, one.parts)).collect();
        let series = sensors.measure_series_with(&views, &recording);
        self.write(context, series.columns.clone())?;
        let computed = observations.iter().filter(|one| one.contacts_are_computed).count();
        output::say(context, &series_json(&series, computed), || {
            series_text(&series, observations.len(), computed)
        })
    }

    /// The parameters of sensors that the run or the case gives.
    fn parameters(&self, context: &Context) -> Result<BTreeMap<String, f64>, Failure> {
        Ok(match (&self.case, self.data.first()) {
            (Some(case), _) => Case::read_as(case, context.reading().for_law())?.recording.parameters,
            (None, Some(data)) if data.is_dir() => context.run_at(data)?.case()?.recording.parameters,
            _ => BTreeMap::new(),
        })
    }

    /// Writes the columns to the requested file, if any.
    fn write(&self, context: &Context, columns: Vec<(SensorColumn, Vec<f64>)>) -> Result<(), Failure> {
        let Some(path) = &self.output else { return Ok(()) };
        let column = |(column, values): (SensorColumn, Vec<f64>)| {
            Column::new(column.name, if column.unit == "1" { "" } else { column.unit }, values)
        };
        let table = Table::new(columns.into_iter().map(column).collect())?;
        granum_io::check_output_file(path, context.force)?;
        Ok(granum_io::write_table(path, &table)?)
    }

    /// The assemblies and which of their parts are known.
    fn read(&self, context: &Context) -> Result<Vec<ObservedAssembly>, Failure> {
        if let Some(grains) = &self.grains {
            let tables: Vec<PathBuf> =
                [Some(grains), self.contacts.as_ref()].into_iter().flatten().cloned().collect();
            return self.joined(context, &tables);
        }
        let Some(data) = self.data.first() else { return Err(Failure::new("there is nothing to measure")) };
        if data.is_dir() && self.data.len() == 1 {
            return Ok(vec![ObservedAssembly::complete(self.run_folder(context, data)?)]);
        }
        if let Some(name) = &self.snapshot {
            return Err(Failure::new(format!("--snapshot {name}: {} is no run folder", data.shown())));
        }
        if self.data.len() == 1 && (self.case.is_some() || !context.formats().is_result(data)?) {
            return Ok(vec![self.packing(context, data)?]);
        }
        if let Some(case) = &self.case {
            return Err(Failure::new(format!(
                "--case {}: it goes with one packing, not with several files",
                case.shown()
            )));
        }
        self.joined(context, &self.data)
    }

    /// The instants of files that belong together.
    fn joined(&self, context: &Context, files: &[PathBuf]) -> Result<Vec<ObservedAssembly>, Failure> {
        let observations = self.sources.read(context, files)?;
        Ok(observations.into_iter().map(ObservedAssembly::with_contacts_by_geometry).collect())
    }

    fn run_folder(&self, context: &Context, data: &Path) -> Result<Assembly, Failure> {
        if self.case.is_some() {
            return Err(Failure::new(format!("--case: {} is a run, which has its own case", data.shown())));
        }
        let run = open_run(context, data)?;
        let names = run.snapshots()?;
        let usual = || names.iter().find(|name| *name == "end").or(names.first()).cloned();
        let Some(name) = self.snapshot.clone().or_else(usual) else {
            return Err(Failure::new(format!("{}: it has no snapshot yet", data.shown())));
        };
        if !names.contains(&name) {
            let known = names.join(", ");
            return Err(Failure::new(format!(
                "{}: it has no snapshot {name}; there are {known}",
                data.shown()
            )));
        }
        Ok(run.snapshot(&name)?)
    }

    /// A packing: what follows from places and radii, and with a case from its contact law.
    fn packing(&self, context: &Context, path: &Path) -> Result<ObservedAssembly, Failure> {
        let packing = match self.sources.first_given() {
            None => context.read_packing(path)?,
            // What the file does not say is given beside it; its last instant counts.
            Some(_) => match self.sources.read(context, &[path.to_path_buf()])?.last() {
                Some(last) => last.packing(path)?,
                None => return Err(Failure::new(format!("{}: it has no grains", path.shown()))),
            },
        };
        let reading = || context.reading().for_law();
        let case = self.case.as_ref().map(|case| Case::read_as(case, reading())).transpose()?;
        Ok(observed_packing(&packing, case.as_ref())?)
    }
}

/// A packing without a contact law: grains that overlap touch.
pub fn packing_alone(context: &Context, path: &Path) -> Result<(Assembly, Parts), Failure> {
    let found = observed_packing(&context.read_packing(path)?, None)?;
    Ok((found.assembly, found.parts))
}

/// Whether the contacts stand in the data, for the keys of JSON.
fn origin_of_contacts(observed: &ObservedAssembly) -> Option<&'static str> {
    let origin = if observed.contacts_are_computed { "computed" } else { "read" };
    observed.parts.has(Part::Contacts).then_some(origin)
}

fn as_json(observed: &ObservedAssembly, measured: &Measurement) -> Value {
    let assembly = &observed.assembly;
    let columns: Map<String, Value> =
        measured.columns.iter().map(|(column, value)| (column.name.to_string(), json!(value))).collect();
    let left_out = |left_out: &granum_sensors::LeftOut| {
        let missing: Vec<&str> = left_out.missing.iter().map(|part| part.name()).collect();
        json!({ "sensor": left_out.sensor, "columns": left_out.columns, "missing": missing, "reason": left_out.to_string() })
    };
    let histogram = |(bins, counts): &(granum_sensors::Bins, granum_sensors::Histogram)| {
        let centres: Vec<f64> = (0..counts.bins()).map(|bin| counts.centre(bin)).collect();
        let histogram = json!({ bins.quantity: centres, "counts": counts.counts, "below": counts.below, "above": counts.above });
        (bins.name.to_string(), histogram)
    };
    json!({
        "grains": assembly.bodies.len(),
        "contacts": assembly.contacts.len(),
        "contacts_are": origin_of_contacts(observed),
        "values": columns,
        "histograms": measured.histograms.iter().map(histogram).collect::<Map<String, Value>>(),
        "left_out": measured.left_out.iter().map(left_out).collect::<Vec<_>>(),
    })
}

fn text(observed: &ObservedAssembly, measured: &Measurement) -> String {
    let assembly = &observed.assembly;
    let origin = match origin_of_contacts(observed) {
        Some("computed") => " (computed from the overlaps of the grains)",
        Some(_) => " (read)",
        None => " (the data have neither contacts nor radii)",
    };
    let mut lines =
        vec![format!("{} grains, {} contacts{origin}", assembly.bodies.len(), assembly.contacts.len())];
    for (column, value) in &measured.columns {
        let unit = if column.unit == "1" { "" } else { column.unit };
        lines.push(format!("{:32} {value:13.6e} {unit}", column.name).trim_end().to_string());
    }
    if !measured.left_out.is_empty() {
        lines.push("not measured:".into());
        lines.extend(measured.left_out.iter().map(|left_out| format!("  {left_out}")));
    }
    lines.join("\n")
}

fn series_json(series: &MeasuredSeries, computed: usize) -> Value {
    let columns: Map<String, Value> =
        series.columns.iter().map(|(column, values)| (column.name.to_string(), json!(values))).collect();
    let left_out: Vec<Value> = (series.left_out.iter())
        .map(|left_out| json!({ "sensor": left_out.sensor, "columns": left_out.columns, "reason": left_out.to_string() }))
        .collect();
    json!({ "values": columns, "left_out": left_out, "instants_with_computed_contacts": computed })
}

/// The first and the last value of every column.
fn series_text(series: &MeasuredSeries, count: usize, computed: usize) -> String {
    let mut lines = vec![format!("{count} instants; the first and the last value of each column")];
    if computed > 0 {
        lines.push(format!("contacts of {computed} instants are computed from the overlaps of the grains"));
    }
    for (column, values) in &series.columns {
        let unit = if column.unit == "1" { "" } else { column.unit };
        let [first, last] = [values.first(), values.last()].map(|value| value.copied().unwrap_or(0.0));
        lines.push(format!("{:32} {first:13.6e} {last:13.6e} {unit}", column.name).trim_end().to_string());
    }
    if !series.left_out.is_empty() {
        lines.push("not measured:".into());
        lines.extend(series.left_out.iter().map(|left_out| format!("  {left_out}")));
    }
    lines.join("\n")
}

/// The sensors with their columns and what they need.
fn list(context: &Context, sensors: &Sensors) -> Result<(), Failure> {
    let mut all = Vec::new();
    let mut lines = Vec::new();
    for sensor in sensors.descriptions() {
        let recorded = sensors.recorded(sensor.name).unwrap_or_default();
        let needs: Vec<&str> = sensor.needs.iter().map(|part| part.name()).collect();
        let columns: Vec<Value> = (sensor.columns.iter())
            .map(|column| json!({ "name": column.name, "unit": column.unit, "description": column.description }))
            .collect();
        let parameters: Vec<Value> = sensor.parameters.iter().map(parameter_json).collect();
        all.push(json!({
            "name": sensor.name, "description": sensor.help, "speaks_of": sensor.subject.name(), "recorded": recorded, "needs": needs, "columns": columns,
            "parameters": parameters,
        }));
        let of = sensor.subject.name();
        lines.push(format!("{}: {} (of {of}; recorded {recorded})", sensor.name, sensor.help));
        if !needs.is_empty() {
            lines.push(format!("  needs {}", needs.join(", ")));
        }
        lines.extend(sensor.parameters.iter().map(parameter_line));
        lines.extend(sensor.columns.iter().map(|column| {
            let unit = if column.unit == "1" { String::new() } else { format!(" ({})", column.unit) };
            format!("  {}{unit}: {}", column.name, column.description)
        }));
    }
    output::say(context, &json!({ "sensors": all }), || lines.join("\n"))
}

/// `recording.bin_width (from 0.001 to 10, default 0.25): Width of a bin of f = N/<N>.`
fn parameter_line(parameter: &SensorParameter) -> String {
    let unit = parameter.dimension.si_unit();
    let number = |value: f64| format!("{} {unit}", format_number(value)).trim_end().to_string();
    let [low, high] = parameter.bounds.map(number);
    let default = match parameter.default {
        ParameterDefault::Value(value) => format!("default {}", number(value)),
        ParameterDefault::Absent(meaning) => format!("default: {meaning}"),
        _ => "needed".into(),
    };
    let meaning = parameter.meaning.trim_end_matches('.');
    format!("  parameter recording.{} (from {low} to {high}, {default}): {meaning}", parameter.key)
}

fn parameter_json(parameter: &SensorParameter) -> Value {
    json!({
        "key": format!("recording.{}", parameter.key),
        "unit": parameter.dimension.si_unit(),
        "default": parameter.default_value(),
        "bounds": parameter.bounds,
        "description": parameter.meaning,
    })
}
