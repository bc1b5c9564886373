//! Families of tests whose surrogates come with the program, one file each in `crates/granum/families/`. A fitted family needs a file and a
//! line in [`FITTED`].

use granum_learn::Result;
use granum_learn::family::FamilyModel;

/// The names of families and the texts of their files.
pub const FITTED: &[(&str, &str)] = &[];

/// The fitted surrogate of a family that comes with the program; `None` if it comes without one.
///
/// # Errors
/// If the file is not one of this version.
pub fn fitted(name: &str) -> Result<Option<FamilyModel>> {
    let found = FITTED.iter().find(|(known, _)| *known == name);
    found.map(|(name, text)| FamilyModel::from_json(text, name)).transpose()
}
