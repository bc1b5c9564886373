//! `granum measure`: every sensor on one assembly, of granum or of another program.

use std::path::{Path, PathBuf};

use clap::Args;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_core::{Assembly, Column, Part, Parts, Table};
use granum_dem::config::{Contact, CriticalState, Material, NormalKind, Recording, TangentialKind};
use granum_dem::simulation::Properties;
use granum_io::{Case, Run};
use granum_run::laboratory::simulation;
use granum_sensors::{Measurement, Sensors};
use serde_json::{Map, Value, json};

use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Measure an assembly with every sensor that its data allow, and say which sensors cannot be applied and what they lack.
///
/// The data are a snapshot of a run folder, a packing (grains that overlap touch; with --case their forces follow from the
/// contact law), or tables of another program: --grains with the columns id, position_x ... and any others of a snapshot,
/// --contacts with first, second and any others.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum measure run-1\n  granum measure packing.csv --case my-sand.toml\n  granum measure --grains \
                  grains.csv --contacts contacts.csv --cell \"2 mm, 2 mm, 2 mm\"\n  granum measure --list"
)]
pub struct Measure {
    /// A run folder or a packing file.
    #[arg(required_unless_present_any = ["list", "grains"])]
    data: Option<PathBuf>,
    /// Snapshot of the run folder; the one at its end by default.
    #[arg(long, value_name = "NAME", requires = "data")]
    snapshot: Option<String>,
    /// Case whose material and contact law give the forces of a packing.
    #[arg(long, value_name = "FILE", requires = "data")]
    case: Option<PathBuf>,
    /// Table of grains (CSV or Parquet) of another program, in SI units.
    #[arg(long, value_name = "FILE", requires = "cell", conflicts_with = "data")]
    grains: Option<PathBuf>,
    /// Table of contacts of another program.
    #[arg(long, value_name = "FILE", requires = "grains")]
    contacts: Option<PathBuf>,
    /// Edges of its periodic cuboid cell.
    #[arg(long, value_name = "A, B, C", requires = "grains")]
    cell: Option<String>,
    /// List the sensors with their columns and what they need, and measure nothing.
    #[arg(long, conflicts_with_all = ["data", "grains"])]
    list: bool,
    /// Where to write the values as a table of one row (CSV or Parquet by extension).
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
}

impl Measure {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let sensors = Sensors::standard();
        if self.list {
            return list(context, &sensors);
        }
        let (assembly, parts) = self.read()?;
        let critical_state = self.critical_state()?;
        let recording = Recording::default().with(|recording| recording.critical_state = critical_state);
        let measured = sensors.measure_with(&assembly, parts, &recording);
        if let Some(path) = &self.output {
            let column = |(column, value): &(granum_sensors::SensorColumn, f64)| {
                Column::new(column.name, if column.unit == "1" { "" } else { column.unit }, vec![*value])
            };
            let table = Table::new(measured.columns.iter().map(column).collect())?;
            granum_io::check_output_file(path, context.force)?;
            granum_io::write_table(path, &table)?;
        }
        output::say(context, &as_json(&assembly, &measured), || text(&assembly, &measured))
    }

    /// The critical state line of the run or of the case, if one is given.
    fn critical_state(&self) -> Result<CriticalState, Failure> {
        Ok(match (&self.case, &self.data) {
            (Some(case), _) => Case::read(case)?.recording.critical_state,
            (None, Some(data)) if data.is_dir() => Run::at(data)?.case()?.recording.critical_state,
            _ => CriticalState::default(),
        })
    }

    /// The assembly and which of its parts are known.
    fn read(&self) -> Result<(Assembly, Parts), Failure> {
        if let (Some(grains), Some(cell)) = (&self.grains, &self.cell) {
            return Ok(granum_io::read_assembly(grains, self.contacts.as_deref(), edges(cell)?)?);
        }
        let Some(data) = &self.data else { return Err(Failure::new("there is nothing to measure")) };
        if !data.is_dir() {
            if let Some(name) = &self.snapshot {
                return Err(Failure::new(format!(
                    "--snapshot {name}: {} is not a run folder",
                    data.display()
                )));
            }
            return self.packing(data);
        }
        if self.case.is_some() {
            return Err(Failure::new(format!("--case: {} is a run, which has its own case", data.display())));
        }
        let run = Run::at(data)?;
        let names = run.snapshots()?;
        let usual = || names.iter().find(|name| *name == "end").or(names.first()).cloned();
        let Some(name) = self.snapshot.clone().or_else(usual) else {
            return Err(Failure::new(format!("{}: it has no snapshot yet", data.display())));
        };
        if !names.contains(&name) {
            let known = names.join(", ");
            return Err(Failure::new(format!(
                "{}: it has no snapshot {name}; there are {known}",
                data.display()
            )));
        }
        Ok((run.snapshot(&name)?, Parts::all()))
    }

    /// A packing: what follows from places and radii, and with a case from its contact law.
    fn packing(&self, path: &Path) -> Result<(Assembly, Parts), Failure> {
        let packing = granum_io::read_packing(path)?;
        let mut parts =
            Parts::of(&[Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::Overlaps]);
        let Some(case) = &self.case else {
            let material = Material::default().with(|material| material.interface_energy = 0.0);
            let contact = Contact::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
            return Ok((simulation(&packing, Properties::new(material, contact))?.assembly(), parts));
        };
        let case = Case::read(case)?;
        parts = parts.with(Part::Masses).with(Part::NormalForces);
        if case.grains.material.friction == 0.0 && case.grains.mixture.is_empty() {
            // Only then is it known, without the history of the contacts, what acts along them: nothing.
            let known = [Part::TangentialForces, Part::ResultantForces, Part::Sliding, Part::ContactEnergies];
            parts = known.into_iter().fold(parts, Parts::with);
        }
        Ok((simulation(&packing, case.properties())?.assembly(), parts))
    }
}

/// Three lengths with units, as `2 mm, 2 mm, 3 mm`.
fn edges(text: &str) -> Result<[f64; 3], Failure> {
    let wrong = |why: String| {
        Failure::new(format!("--cell {text:?}: {why}; give three lengths, e.g. \"2 mm, 2 mm, 3 mm\""))
    };
    let lengths = text.split(',').map(|item| parse_quantity(item.trim(), Dimension::LENGTH).map_err(&wrong));
    let lengths = lengths.collect::<Result<Vec<f64>, Failure>>()?;
    <[f64; 3]>::try_from(lengths).map_err(|found| wrong(format!("it has {} lengths", found.len())))
}

fn as_json(assembly: &Assembly, measured: &Measurement) -> Value {
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
        "grains": assembly.grains.len(),
        "contacts": assembly.contacts.len(),
        "values": columns,
        "histograms": measured.histograms.iter().map(histogram).collect::<Map<String, Value>>(),
        "left_out": measured.left_out.iter().map(left_out).collect::<Vec<_>>(),
    })
}

fn text(assembly: &Assembly, measured: &Measurement) -> String {
    let mut lines = vec![format!("{} grains, {} contacts", assembly.grains.len(), assembly.contacts.len())];
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
        all.push(json!({
            "name": sensor.name, "description": sensor.help, "recorded": recorded, "needs": needs, "columns": columns
        }));
        lines.push(format!("{}: {} (recorded {recorded})", sensor.name, sensor.help));
        if !needs.is_empty() {
            lines.push(format!("  needs {}", needs.join(", ")));
        }
        lines.extend(sensor.columns.iter().map(|column| {
            let unit = if column.unit == "1" { String::new() } else { format!(" ({})", column.unit) };
            format!("  {}{unit}: {}", column.name, column.description)
        }));
    }
    output::say(context, &json!({ "sensors": all }), || lines.join("\n"))
}
