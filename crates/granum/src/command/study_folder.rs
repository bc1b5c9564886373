//! The folder of a study that a command is given.

use std::path::Path;

use granum::contents::Contents;
use granum::families::FITTED;
use granum_io::shell::ShowPath;
use granum_io::shell::quoted_path;
use granum_learn::study::{STUDY_FILE, Study, load as load_study};

use crate::context::Context;
use crate::failure::Failure;

/// Reads the study in a folder; a folder of another kind is refused with what it holds and what to do.
pub fn load(context: &Context, folder: &Path) -> Result<Study, Failure> {
    if folder.try_exists().is_ok_and(|exists| !exists) {
        return Err(missing(folder));
    }
    if folder.is_dir() && !folder.join(STUDY_FILE).is_file() {
        let contents = Contents::read(folder, context.vocabulary())?;
        let quoted = quoted_path(folder);
        let next = match &contents {
            Contents::Run(_) => format!("networks are trained on runs: granum train {quoted} --out study"),
            Contents::Reproduction { .. } => {
                format!("its networks are in the folder {}", quoted_path(&folder.join("models")))
            }
            Contents::Training { .. } | Contents::Runs { .. } | Contents::Campaign(_) => {
                contents.next(folder).text
            }
            Contents::Nothing | Contents::Other => "give the folder that `granum train` wrote".into(),
        };
        return Err(Failure::new(format!(
            "{}: a study is needed here, and this folder holds {}; {next}",
            folder.shown(),
            contents.name()
        )));
    }
    Ok(load_study(folder, context.methods())?.study)
}

/// What is said where there is nothing of this name, which may be meant as that of a family.
fn missing(path: &Path) -> Failure {
    let family = FITTED.iter().find(|known| Some(known.name) == path.to_str());
    let next = match family {
        Some(known) => {
            format!("the family of this name is asked by `granum predict --family {}`", known.name)
        }
        None => "give the file of a surrogate or the folder of a study, as `granum train` writes them".into(),
    };
    Failure::new(format!("{}: there is no such file or folder; {next}", path.shown()))
}
