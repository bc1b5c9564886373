//! The surrogate that a command is given: a file of one, or the folder of a study with a name.

use std::path::Path;

use granum_antony2006::evaluation::networks;
use granum_antony2006::is_of_paper;
use granum_io::shell::ShowPath;
use granum_learn::Surrogate;
use granum_learn::study::Study;

use super::study_folder;
use crate::context::Context;
use crate::failure::Failure;

/// A surrogate and what it is in.
pub enum ChosenModel {
    /// A file of its own.
    File(Box<dyn Surrogate>),
    /// A study, and the name of one of its surrogates.
    Study(Box<Study>, String),
}

impl ChosenModel {
    /// Reads a file or a folder; `name` chooses among the surrogates of a study.
    pub fn read(context: &Context, path: &Path, name: Option<&str>) -> Result<ChosenModel, Failure> {
        if path.is_file() {
            if let Some(name) = name {
                let path = path.shown();
                return Err(Failure::new(format!(
                    "--model {name}: {path} is the file of one surrogate; only a study has several to choose from"
                )));
            }
            return Ok(ChosenModel::File(context.methods().load(path)?));
        }
        let study = study_folder::load(context, path)?;
        let Some(name) = name else {
            let mut names: Vec<&str> = study.members().map(|member| member.name.as_str()).collect();
            if is_of_paper(&study.definition) {
                names.extend(study.fits.iter().map(|fit| fit.name.as_str()));
            }
            return Err(Failure::new(format!(
                "give a surrogate as --model NAME; the study has {}",
                names.join(", ")
            )));
        };
        let chosen = ChosenModel::Study(Box::new(study), name.to_owned());
        chosen.surrogate()?;
        Ok(chosen)
    }

    /// The surrogate.
    pub fn surrogate(&self) -> Result<&dyn Surrogate, Failure> {
        match self {
            ChosenModel::File(surrogate) => Ok(surrogate.as_ref()),
            ChosenModel::Study(study, name) => match study.member(name) {
                Ok(member) => Ok(member.surrogate.as_ref()),
                Err(_) if is_of_paper(&study.definition) => Ok(networks(study, name)?),
                Err(error) => Err(error.into()),
            },
        }
    }
}
