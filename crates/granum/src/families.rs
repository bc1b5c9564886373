//! Families of tests whose surrogates come with the program, one file for each path in `crates/granum/families/`. A fitted family needs a
//! file and a line in [`FITTED`].

use granum_learn::Result;
use granum_learn::family::{FamilyDefinition, FamilyModel};

/// A surrogate that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct FittedFamily {
    /// Name of the family.
    pub name: &'static str,
    /// Path of its tests.
    pub path: &'static str,
    /// The text of its file.
    pub text: &'static str,
}

/// A family and a path, with the file of this name.
macro_rules! fitted {
    ($name:literal, $path:literal) => {
        FittedFamily {
            name: $name,
            path: $path,
            text: include_str!(concat!("../families/", $name, "/", $path, ".json")),
        }
    };
}

/// The surrogates that come with the program.
pub const FITTED: &[FittedFamily] = &[
    fitted!("sand", "drained-triaxial"),
    fitted!("sand", "constant-p"),
    fitted!("sand", "undrained-triaxial"),
    fitted!("sand", "unload-reload"),
    fitted!("powder", "constant-p"),
    fitted!("powder", "oedometer"),
    fitted!("shaped-sand", "drained-triaxial"),
];

/// The fitted surrogate of a family along a path that comes with the program; `None` if it comes without one.
///
/// # Errors
/// If the file is not one of this version.
pub fn fitted(family: &FamilyDefinition) -> Result<Option<FamilyModel>> {
    let found = FITTED.iter().find(|known| known.is_of(family));
    found.map(|known| FamilyModel::from_json(known.text, known.name)).transpose()
}

impl FittedFamily {
    /// True if it is the surrogate of a family along its path.
    pub fn is_of(&self, family: &FamilyDefinition) -> bool {
        (self.name, self.path) == (family.name, family.path)
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use granum_campaign::data_set::DataSet;
    use granum_io::Reading;
    use granum_learn::{Dataset, RunStates};

    use super::*;

    /// The data sets in `data/families/` can be read, and the surrogate that comes with the program was fitted to them.
    #[test]
    fn the_surrogates_of_the_program_are_of_the_data_that_are_shipped() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../data/families");
        assert!(FITTED.iter().map(|known| known.text.len()).sum::<usize>() < 7_000_000);
        for known in FITTED {
            let FittedFamily { name, path, text } = known;
            let model = FamilyModel::from_json(text, name).unwrap();
            assert!(known.is_of(model.definition()), "{name} {path}");
            let scored = model.scores().iter().map(|scores| &scores.data);
            for data in model.data().iter().chain(scored) {
                let read = DataSet::read(&folder.join(name).join(&data.name), Reading::default()).unwrap();
                let run = |run: granum_campaign::data_set::DataSetRun| {
                    RunStates::of_case(&run.name, &run.case, run.measured).unwrap()
                };
                let runs = Dataset::new(read.each_run().unwrap().into_iter().map(run).collect()).unwrap();
                let runs = model.definition().along_its_path(&runs);
                assert_eq!(
                    (runs.runs().len(), &runs.digest()),
                    (data.runs, &data.digest),
                    "{name} {}",
                    data.name
                );
            }
        }
    }
}
