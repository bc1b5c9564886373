//! The file of a fitted family: a JSON document with the digest of its text as its last entry.

use std::io::Write;
use std::path::Path;

use granum_core::json;
use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::shell::ShowPath;
use serde::{Deserialize, Serialize};

use super::by_name;
use super::model::{FamilyModel, unfit};
use super::score_types::{FamilyScores, TrainingData};
use crate::error::{LearnError, Result};
use crate::surrogate::file::{is_whole, sealed};
use crate::surrogate::{Columns, Content, GaussianProcessOfCurves, Surrogate, SurrogateMethod};

const FORMAT: &str = "granum family model";
const VERSION: u64 = 1;
/// Largest file that is read.
const LARGEST_FILE: u64 = 1 << 28;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u64,
    granum_version: String,
    family: String,
    /// Files of a family with a single path did not name it.
    #[serde(default)]
    path: Option<String>,
    data: Vec<TrainingData>,
    scores: Vec<FamilyScores>,
    rows: Vec<Vec<f64>>,
    columns: Columns,
    surrogate: serde_json::Value,
    #[serde(default, skip_serializing, rename = "sha256")]
    _digest: String,
}

impl FamilyModel {
    /// The text of its file.
    ///
    /// # Errors
    /// If the surrogate cannot be written.
    pub fn to_json(&self) -> Result<String> {
        let file = File {
            format: FORMAT.into(),
            version: VERSION,
            granum_version: env!("CARGO_PKG_VERSION").into(),
            family: self.definition.name.into(),
            path: Some(self.definition.path.into()),
            data: self.data.clone(),
            scores: self.scores.clone(),
            rows: self.rows.clone(),
            columns: self.surrogate.columns().clone(),
            surrogate: self.surrogate.content()?.read()?,
            _digest: String::new(),
        };
        let text = json::readable(&file).map_err(|error| LearnError::Content(error.to_string()))?;
        Ok(sealed(&text))
    }

    /// Writes its file.
    ///
    /// # Errors
    /// If the surrogate or the file cannot be written.
    pub fn save(&self, path: &Path) -> Result<()> {
        let text = self.to_json()?;
        write_atomically(path, |file| file.write_all(text.as_bytes()))?;
        Ok(())
    }

    /// Reads a file that [`FamilyModel::save`] wrote.
    ///
    /// # Errors
    /// If the file cannot be read, was altered, or is not that of a family that this program knows; the message names the file.
    pub fn load(path: &Path) -> Result<FamilyModel> {
        let text = granum_core::input::read_text(path, LARGEST_FILE).map_err(Error::file("read", path))?;
        FamilyModel::from_json(&text, &path.shown())
    }

    /// Reads a fitted family from the text of its file; `name` is used in error messages.
    ///
    /// # Errors
    /// As [`FamilyModel::load`].
    pub fn from_json(text: &str, name: &str) -> Result<FamilyModel> {
        opened(text)
            .map_err(|error| LearnError::SurrogateFile { file: name.into(), reason: error.to_string() })
    }
}

fn opened(text: &str) -> Result<FamilyModel> {
    let file: File = serde_json::from_str(text)
        .map_err(|error| LearnError::Content(format!("this is not the file of a fitted family: {error}")))?;
    if file.format != FORMAT || file.version != VERSION {
        return Err(unfit(&format!(
            "the file is a {} of version {}; this program reads a {FORMAT} of version {VERSION}",
            file.format, file.version
        )));
    }
    if !is_whole(text) {
        return Err(unfit("the SHA-256 does not match the content; train the family again"));
    }
    let definition = by_name(&file.family, file.path.as_deref())?;
    let content = Content::new(&file.surrogate)?;
    let surrogate: Box<dyn Surrogate> = GaussianProcessOfCurves::default().load(file.columns, &content)?;
    let model = FamilyModel {
        definition,
        surrogate,
        rows: file.rows,
        data: file.data,
        scores: file.scores,
        typical: Default::default(),
    };
    let inputs = definition.inputs.len();
    let names = model.surrogate.columns().input_names();
    let expected =
        [definition.coordinate].into_iter().chain(definition.inputs.iter().map(|input| input.name));
    if names.iter().map(String::as_str).ne(expected) {
        return Err(unfit("the inputs are not those of the family; train it again with this version"));
    }
    let is_row = |row: &Vec<f64>| row.len() == inputs && row.iter().all(|value| value.is_finite());
    let curves = model.curves().map_or(0, |curves| curves.runs());
    if !model.rows.iter().all(is_row) || model.rows.len() != curves || curves == 0 {
        return Err(unfit("the rows are not those of its runs"));
    }
    Ok(model)
}
