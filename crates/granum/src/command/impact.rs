//! `granum impact`: the collision of two grains.

use std::path::PathBuf;

use clap::Args;
use granum_core::quantity::{Dimension, parse_quantity};
use granum_dem::contact::impact::{self, AGREEMENT, collide};
use granum_io::{Column, Table};

use super::law::LawFlags;
use crate::context::Context;
use crate::failure::Failure;
use crate::output::put_table;

/// Let two equal grains collide and print their velocities after the collision.
///
/// The output has one row for every speed and angle. The angle is measured between the relative velocity and the line of
/// centres, 0 for a head-on impact. Tangential velocities are those at the contact point, including the spin. For grains
/// that stick together, the velocities after the impact and the restitution are zero. psi1 and psi2 are the tangential
/// velocities before and after, over the normal velocity before, times 2 (1 - nu) / (mu (2 - nu)) (Maw, Barber and Fawcett
/// 1976).
#[derive(Args)]
#[command(after_help = "\
Example:
  granum impact --speed '0.1 m/s' --angle 0,15,30,45,60 --normal hertz --damping 0 -o impacts.csv")]
pub struct Impact {
    /// Relative speed of the grains; several values are separated by commas.
    #[arg(long, value_name = "V,...", value_delimiter = ',', required = true, allow_hyphen_values = true)]
    speed: Vec<String>,
    /// Angle of impact in degrees, from 0 to below 90; several values are separated by commas.
    #[arg(
        long,
        value_name = "A,...",
        value_delimiter = ',',
        default_value = "0",
        allow_hyphen_values = true
    )]
    angle: Vec<String>,
    /// File for the result (.csv or .parquet); standard output by default.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    law: LawFlags,
}

/// A column of the result: name, unit, value.
type ImpactColumn = (&'static str, &'static str, fn(&impact::Impact) -> f64);

const COLUMNS: [ImpactColumn; 10] = [
    ("speed", "m/s", |impact| impact.speed),
    ("angle_deg", "deg", |impact| impact.angle_deg),
    ("normal_velocity_in", "m/s", |impact| impact.normal_velocity_in),
    ("tangential_velocity_in", "m/s", |impact| impact.tangential_velocity_in),
    ("normal_velocity_out", "m/s", |impact| impact.normal_velocity_out),
    ("tangential_velocity_out", "m/s", |impact| impact.tangential_velocity_out),
    ("spin_out", "rad/s", |impact| impact.spin_out),
    ("restitution", "", |impact| impact.restitution),
    ("psi1", "", |impact| impact.psi1),
    ("psi2", "", |impact| impact.psi2),
];

impl Impact {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        let _alone = context.nothing_written(Some("colliding"));
        let case = self.law.case_of_one_material(context)?;
        let speeds = quantities("--speed", &self.speed, Dimension::VELOCITY)?;
        let angles = self.angle.iter().map(|text| degrees(text)).collect::<Result<Vec<_>, _>>()?;
        let mut impacts = Vec::new();
        for speed in &speeds {
            for angle in &angles {
                context.check_stopped(|| "no impact was written".into())?;
                context.say(|| format!("impact at {speed} m/s and {angle} deg"));
                let grains = &case.grains;
                let impact = collide(&case.contact, &grains.material, grains.diameter, *speed, *angle)?;
                warn_if_uncertain(context, &impact);
                impacts.push(impact);
            }
        }
        let column = |(name, unit, value): &ImpactColumn| {
            Column::new(*name, *unit, impacts.iter().map(value).collect())
        };
        put_table(context, self.output.as_deref(), &Table::new(COLUMNS.iter().map(column).collect())?)
    }
}

fn warn_if_uncertain(context: &Context, impact: &impact::Impact) {
    let (speed, angle, uncertainty) = (impact.speed, impact.angle_deg, impact.uncertainty);
    if uncertainty.is_infinite() {
        context.warn(&format!(
            "at {speed} m/s and {angle} deg the grains barely stick or barely separate; the time step decides which"
        ));
    } else if uncertainty > AGREEMENT {
        context.warn(&format!(
            "at {speed} m/s and {angle} deg the grains barely separate: the velocities after impact are uncertain by \
             {uncertainty:.1e} of the impact velocity"
        ));
    }
}

fn quantities(flag: &str, texts: &[String], dimension: Dimension) -> Result<Vec<f64>, Failure> {
    let read = |text: &String| {
        parse_quantity(text, dimension).map_err(|why| Failure::new(format!("{flag} = {text:?} {why}")))
    };
    texts.iter().map(read).collect()
}

/// Plain numbers are in degrees here; an angle with a unit may be in rad.
fn degrees(text: &str) -> Result<f64, Failure> {
    if let Ok(plain) = parse_quantity(text, Dimension::NUMBER) {
        return Ok(plain);
    }
    match text.trim().strip_suffix("deg") {
        Some(number) => quantities("--angle", &[number.to_string()], Dimension::NUMBER).map(|all| all[0]),
        None => quantities("--angle", &[text.to_string()], Dimension::ANGLE).map(|all| all[0].to_degrees()),
    }
}
