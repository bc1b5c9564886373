//! The contact law and the grains of a command, from a case file, from flags, or from both (flags win).

use std::path::PathBuf;

use clap::{Args, Command};
use granum_dem::contact::choice::registry::Laws;
use granum_io::Case;

use super::case_flags::SetFlags;
use crate::context::Context;
use crate::failure::Failure;

/// Contact law and grains; the defaults are those of Antony, Zhou and Wang (2006).
#[derive(Args)]
#[command(next_help_heading = "Law and grains (quantities with units, e.g. \"70 GPa\", or SI numbers)")]
pub struct LawFlags {
    /// Case file with the contact law and the grains.
    #[arg(long, value_name = "FILE")]
    pub case: Option<PathBuf>,
    #[command(flatten)]
    set: SetFlags,
    /// Normal law.
    #[arg(long, value_name = "LAW")]
    normal: Option<String>,
    /// Tangential law.
    #[arg(long, value_name = "LAW")]
    tangential: Option<String>,
    /// Resistance to rolling and twisting.
    #[arg(long, value_name = "LAW")]
    rolling: Option<String>,
    /// Additional attraction of grains.
    #[arg(long, value_name = "LAW")]
    adhesion: Option<String>,
    /// Diameter d of a grain.
    #[arg(long, value_name = "LENGTH")]
    diameter: Option<String>,
    /// Density rho of the solid.
    #[arg(long, value_name = "DENSITY")]
    density: Option<String>,
    /// Young's modulus E.
    #[arg(long, value_name = "STRESS")]
    youngs_modulus: Option<String>,
    /// Poisson's ratio nu.
    #[arg(long, value_name = "NUMBER")]
    poissons_ratio: Option<String>,
    /// Coefficient of friction mu.
    #[arg(long, value_name = "NUMBER")]
    friction: Option<String>,
    /// Interface energy Gamma.
    #[arg(long, value_name = "ENERGY/AREA")]
    interface_energy: Option<String>,
    /// Fraction zeta of critical damping.
    #[arg(long, value_name = "NUMBER")]
    damping: Option<String>,
}

/// A help text with the names of the laws, such as "Normal law: hertz or jkr".
fn names(what: &str, laws: impl Iterator<Item = &'static str>) -> String {
    let laws: Vec<_> = laws.collect();
    let (last, others) = laws.split_last().map_or(("", &[][..]), |(last, others)| (*last, others));
    if others.is_empty() {
        format!("{what}: {last}")
    } else {
        format!("{what}: {} or {last}", others.join(", "))
    }
}

/// The same command, with the laws that the program knows in the help of its flags, and the parameters of laws that `--set` accepts.
pub fn described(command: Command, laws: &Laws) -> Command {
    let rolling = names("Resistance to rolling and twisting", laws.rolling().iter().map(|law| law.name()));
    let keys: Vec<_> = laws.parameters().iter().map(|p| format!("contact.{}", p.key)).collect();
    let long = format!("{rolling}. Parameters of laws are set by --set: {}", keys.join(", "));
    let normal = names("Normal law", laws.normal().iter().map(|law| law.name()));
    let tangential = names("Tangential law", laws.tangential().iter().map(|law| law.name()));
    let adhesion = names("Additional attraction of grains", laws.adhesion().iter().map(|law| law.name()));
    command
        .mut_arg("normal", |argument| argument.help(normal))
        .mut_arg("tangential", |argument| argument.help(tangential))
        .mut_arg("rolling", |argument| argument.help(rolling).long_help(long))
        .mut_arg("adhesion", |argument| argument.help(adhesion))
}

impl LawFlags {
    /// As [`LawFlags::case`], for a command that supports only one material.
    pub fn case_of_one_material(&self, context: &Context) -> Result<Case, Failure> {
        let case = self.case(context)?;
        if case.grains.mixture.is_empty() {
            return Ok(case);
        }
        Err(Failure::new(
            "the case has several materials, but this command takes two grains of one material: leave [[material]] and \
             [[pair]] out and give the properties under [grains.material]"
                .to_string(),
        ))
    }

    /// The case that results from the file and the flags.
    pub fn case(&self, context: &Context) -> Result<Case, Failure> {
        let mut case = match &self.case {
            Some(path) => Case::read_as(path, context.reading().for_law())?,
            None => Case::default(),
        };
        let flags = [
            ("--normal", "contact.normal", &self.normal),
            ("--tangential", "contact.tangential", &self.tangential),
            ("--rolling", "contact.rolling", &self.rolling),
            ("--adhesion", "contact.adhesion", &self.adhesion),
            ("--diameter", "grains.diameter", &self.diameter),
            ("--density", "grains.material.density", &self.density),
            ("--youngs-modulus", "grains.material.youngs_modulus", &self.youngs_modulus),
            ("--poissons-ratio", "grains.material.poissons_ratio", &self.poissons_ratio),
            ("--friction", "grains.material.friction", &self.friction),
            ("--interface-energy", "grains.material.interface_energy", &self.interface_energy),
            ("--damping", "contact.damping", &self.damping),
        ];
        for (flag, path, value) in flags {
            let Some(value) = value else { continue };
            case.set(path, value).map_err(|error| named(flag, error))?;
        }
        let given: Vec<(&str, &str)> =
            flags.iter().filter(|flag| flag.2.is_some()).map(|flag| (flag.0, flag.1)).collect();
        self.set.apply_law(&mut case, &["grains", "grains.material", "contact"], &given)?;
        case.check_law()?;
        Ok(case)
    }
}

/// The same error with the name of the flag instead of the key.
fn named(flag: &str, error: granum_io::Error) -> granum_io::Error {
    match error {
        granum_io::Error::Value { value, message, .. } => {
            granum_io::Error::Value { name: flag.to_string(), value, message }
        }
        other => other,
    }
}
