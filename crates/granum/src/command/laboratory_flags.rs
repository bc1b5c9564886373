//! The flags that say how a laboratory's file is to be read, and what is doubtful about its readings.

use clap::{Args, ValueEnum};
use granum_io::{Conventions, LaboratoryTest};

use crate::failure::Failure;

/// How a laboratory's file is to be read.
#[derive(Args)]
pub struct LaboratoryFlags {
    /// The column of a quantity, e.g. --map axial_strain='eps1 (%)'; can be repeated.
    #[arg(long, value_name = "QUANTITY=COLUMN")]
    map: Vec<String>,
    /// What the file's numbers are, e.g. --as strain=logarithmic, --as stress=total, --as deviator_stress=half, --as bedding_strain='0.3 %',
    /// --as decimal=comma; can be repeated.
    #[arg(long = "as", value_name = "KEY=VALUE")]
    read_as: Vec<String>,
    /// Sign of compression in the file, or in one of its columns: --compression negative, --compression axial_strain=negative,
    /// --compression volumetric_strain=negative for a volumetric strain that is positive in dilation; can be repeated.
    #[arg(long, value_name = "[QUANTITY=]SIGN")]
    compression: Vec<String>,
    /// Kind of the strains in the file.
    #[arg(long, value_enum)]
    strain: Option<Strain>,
}

/// Kind of strain.
#[derive(Clone, Copy, PartialEq, ValueEnum)]
enum Strain {
    /// Changes over initial lengths and volume.
    Engineering,
    /// Logarithms of ratios.
    Logarithmic,
}

impl LaboratoryFlags {
    /// True if any of them is given.
    pub fn is_given(&self) -> bool {
        let lists = [&self.map, &self.read_as, &self.compression];
        lists.iter().any(|list| !list.is_empty()) || self.strain.is_some()
    }

    /// The conventions that they state.
    pub fn conventions(&self) -> Result<Conventions, Failure> {
        let mut conventions = Conventions {
            logarithmic: self.strain.map(|strain| strain == Strain::Logarithmic),
            ..Conventions::default()
        };
        for text in &self.map {
            let Some((quantity, column)) = text.split_once('=') else {
                return Err(Failure::new(format!(
                    "--map {text:?}: a quantity and its column are needed, as --map axial_strain='eps1 (%)'"
                )));
            };
            conventions.columns.push((quantity.trim().to_string(), column.trim().to_string()));
        }
        for text in &self.compression {
            conventions
                .state("compression", text)
                .map_err(|message| Failure::new(format!("--compression {text:?}: {message}")))?;
        }
        for text in &self.read_as {
            let stated = match text.split_once('=') {
                Some((key, value)) => conventions.state(key.trim(), value.trim()),
                None => Err("a convention and its value are needed, as strain=logarithmic".to_string()),
            };
            stated.map_err(|message| Failure::new(format!("--as {text:?}: {message}")))?;
        }
        Ok(conventions)
    }
}

/// What the readings of tests are probably not taken for; a doubt that several tests share is told once.
pub fn doubts(tests: &[&LaboratoryTest]) -> Vec<String> {
    let mut told: Vec<(&str, &str, Vec<&str>)> = Vec::new();
    for test in tests {
        for doubt in &test.doubts {
            match told.iter_mut().find(|(_, remedy, _)| *remedy == doubt.remedy) {
                Some((_, _, names)) => names.push(&test.name),
                None => told.push((&doubt.evidence, &doubt.remedy, vec![&test.name])),
            }
        }
    }
    let line = |(evidence, remedy, names): (&str, &str, Vec<&str>)| match names.as_slice() {
        [""] => format!("{evidence}; {remedy}"),
        [name] => format!("test {name}: {evidence}; {remedy}"),
        [name, others @ ..] => {
            format!("test {name} and {} more ({}): {evidence}; {remedy}", others.len(), others.join(", "))
        }
        [] => evidence.to_string(),
    };
    told.into_iter().map(line).collect()
}
