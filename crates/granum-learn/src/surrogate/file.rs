//! Files of surrogates: a readable JSON document with its version, and a SHA-256 digest as its last entry.

use std::io::Write;
use std::path::Path;

use granum_core::{digest, json};
use granum_io::Error;
use granum_io::atomic::write_atomically;
use granum_io::shell::ShowPath;
use serde::{Deserialize, Serialize};

use super::content::Content;
use super::spec::Columns;
use super::surrogate_trait::Surrogate;
use crate::error::{LearnError, Result};

const FORMAT: &str = "granum surrogate";
const VERSION: u64 = 1;
/// The text before the digest, which covers all bytes before this text.
const DIGEST: &str = ",\n  \"sha256\": \"";
/// Largest file that is read.
const LARGEST_FILE: u64 = 1 << 28;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    version: u64,
    granum_version: String,
    method: String,
    columns: Columns,
    content: serde_json::Value,
    #[serde(default, skip_serializing, rename = "sha256")]
    _digest: String,
}

/// The part that is read first, independently of the version of the file.
#[derive(Deserialize)]
struct Header {
    format: Option<String>,
    version: Option<u64>,
}

/// A file whose digest has been verified.
pub(crate) struct Opened {
    pub method: String,
    pub columns: Columns,
    pub content: Content,
}

/// The text of the file that [`save`] writes.
///
/// # Errors
/// If the content of the surrogate cannot be written.
pub fn to_json(surrogate: &dyn Surrogate) -> Result<String> {
    let file = File {
        format: FORMAT.into(),
        version: VERSION,
        granum_version: env!("CARGO_PKG_VERSION").into(),
        method: surrogate.method().into(),
        columns: surrogate.columns().clone(),
        content: surrogate.content()?.0,
        _digest: String::new(),
    };
    let text = json::readable(&file).map_err(|error| LearnError::Content(error.to_string()))?;
    Ok(sealed(&text))
}

/// A JSON document with the SHA-256 of its text as its last entry.
pub(crate) fn sealed(text: &str) -> String {
    // The digest is inserted before the closing brace of the document.
    let text = text.trim_end();
    let body = text.strip_suffix('}').unwrap_or(text).trim_end();
    format!("{body}{DIGEST}{}\"\n}}\n", digest::sha256(body.as_bytes()))
}

/// True if the last entry of a document is the SHA-256 of the text before it.
pub(crate) fn is_whole(text: &str) -> bool {
    let body = text.rfind(DIGEST).map(|at| (&text[..at], &text[at + DIGEST.len()..]));
    let whole =
        |(body, rest): (&str, &str)| rest.trim_end() == format!("{}\"\n}}", digest::sha256(body.as_bytes()));
    body.is_some_and(whole)
}

/// Writes a surrogate to a file, which [`super::SurrogateMethods::load`] can read.
///
/// # Errors
/// If the surrogate or the file cannot be written.
pub fn save(path: &Path, surrogate: &dyn Surrogate) -> Result<()> {
    let text = to_json(surrogate)?;
    write_atomically(path, |file| file.write_all(text.as_bytes()))?;
    Ok(())
}

pub(crate) fn read(path: &Path) -> Result<Opened> {
    let name = path.shown();
    let size = granum_core::input::size_of(path).map_err(Error::file("read", path))?;
    if size > LARGEST_FILE {
        let reason = format!("it has {size} bytes; a surrogate has at most {LARGEST_FILE}");
        return Err(LearnError::SurrogateFile { file: name, reason });
    }
    let text = granum_core::input::read_text(path, LARGEST_FILE).map_err(Error::file("read", path))?;
    parse(&text, &name)
}

pub(crate) fn parse(text: &str, name: &str) -> Result<Opened> {
    opened(text).map_err(|reason| LearnError::SurrogateFile { file: name.to_owned(), reason })
}

/// True if a text ends before its JSON does; a number that ends too early is otherwise told as an invalid one.
fn is_truncated(text: &str, error: &serde_json::Error) -> bool {
    let last = text.lines().last().map_or(0, str::len);
    error.is_eof() || (error.line() >= text.lines().count() && error.column() >= last)
}

fn opened(text: &str) -> std::result::Result<Opened, String> {
    let header: Header = serde_json::from_str(text).map_err(|error| match is_truncated(text, &error) {
        true => "the file is truncated; save the surrogate again".to_string(),
        false => format!("this is not a surrogate file: {error}"),
    })?;
    match (header.format.as_deref(), header.version) {
        (Some(FORMAT), Some(VERSION)) => {}
        (Some(FORMAT), Some(version)) => {
            return Err(format!("it has version {version}, this program reads version {VERSION}"));
        }
        (Some("granum model"), _) => {
            return Err("this is a single network; granum_nets::Model::load reads it".into());
        }
        (Some("granum study"), _) => {
            return Err("this is the file of a study, which is read with its folder".into());
        }
        (Some("granum family model"), _) => {
            return Err(
                "this is the surrogate of a family of tests, which granum predict --family reads".into()
            );
        }
        (format, _) => {
            let found = format.unwrap_or("none");
            return Err(format!(
                "this is not a surrogate file: \"format\" should be \"{FORMAT}\", found {found}"
            ));
        }
    }
    if !is_whole(text) {
        return Err(
            "the SHA-256 does not match the content: the file was altered or damaged; save the surrogate again"
                .into(),
        );
    }
    let file: File =
        serde_json::from_str(text).map_err(|error| format!("not a usable surrogate: {error}"))?;
    Ok(Opened { method: file.method, columns: file.columns, content: Content(file.content) })
}
