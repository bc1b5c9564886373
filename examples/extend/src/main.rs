//! A program with what granum does not have, one file each: a contact law, a sensor, a loading path, a packing format, an engine, a
//! method of surrogates with memory, a study, a scheduler of campaigns, a boundary on which grains rest, a law of bonds, and a
//! subcommand. It has all commands of granum as well, which know them by name.
//!
//! `cargo run` tries them all; `cargo run -- pair --help` and other words are commands.

mod biaxial;
mod fading_memory;
mod fluctuating_speeds;
mod hardening_study;
mod lattice;
mod replay;
mod rigid_plane;
mod rolling_spring;
mod spheres;
mod this_process;
mod thread;
mod trial;

use std::process::ExitCode;

use granum::prelude::*;

/// All that granum knows by name and all that is added here: a line each. Case files that are read with this registry know the law,
/// the path and the sensor by their names, and their parameters by their keys.
fn registry() -> Result<Registry, RegistrationError> {
    Registry::standard()
        .with_law(RollingKind::new(&rolling_spring::RollingSpring))?
        .with_bond_law(thread::THREAD)?
        .with_path(&biaxial::BIAXIAL)?
        .with_sensor(fluctuating_speeds::FluctuatingSpeeds)?
        .with_packing_format(spheres::Spheres)?
        .with_method(fading_memory::FadingMemory)?
        .with_scheduler(this_process::THIS_PROCESS)
}

fn main() -> ExitCode {
    let registry = match registry() {
        Ok(registry) => registry,
        Err(error) => return ended(Err(error.into())),
    };
    let words: Vec<String> = std::env::args().skip(1).collect();
    match words.split_first() {
        None => ended(trial::all(&registry)),
        Some((word, rest)) if word == "lattice" => ended(lattice::lattice(&registry, rest)),
        Some(_) => granum::program::run(registry),
    }
}

fn ended(result: Result<(), Box<dyn std::error::Error>>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
