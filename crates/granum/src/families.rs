//! Families of tests whose surrogates come with the program, one file each in `crates/granum/families/`. A fitted family needs a file and a
//! line in [`FITTED`].

use granum_learn::Result;
use granum_learn::family::FamilyModel;

/// The names of families and the texts of their files.
pub const FITTED: &[(&str, &str)] = &[("sand", include_str!("../families/sand/model.json"))];

/// The fitted surrogate of a family that comes with the program; `None` if it comes without one.
///
/// # Errors
/// If the file is not one of this version.
pub fn fitted(name: &str) -> Result<Option<FamilyModel>> {
    let found = FITTED.iter().find(|(known, _)| *known == name);
    found.map(|(name, text)| FamilyModel::from_json(text, name)).transpose()
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
        for (name, text) in FITTED {
            assert!(text.len() < 5_000_000, "{name}");
            let model = FamilyModel::from_json(text, name).unwrap();
            assert_eq!(model.definition().name, *name);
            let scored = model.scores().iter().map(|scores| &scores.data);
            for data in model.data().iter().chain(scored) {
                let read = DataSet::read(&folder.join(name).join(&data.name), Reading::default()).unwrap();
                let run = |run: granum_campaign::data_set::DataSetRun| {
                    RunStates::of_case(&run.name, &run.case, run.measured).unwrap()
                };
                let runs = Dataset::new(read.each_run().unwrap().into_iter().map(run).collect()).unwrap();
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
