//! The files that a case can name: those that the reader of the page has handed to it.

use std::collections::BTreeMap;
use std::sync::Arc;

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Value, json};

use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// The most bytes of all files together.
const MOST: usize = 256 << 20;

/// Puts `files`, names with their content in base64, in place of those before.
pub(super) fn replace(_: &mut Page, arguments: &Arguments) -> Result<Value, CallError> {
    let mut files: BTreeMap<String, Arc<[u8]>> = BTreeMap::new();
    let mut total = 0;
    for (name, content) in arguments.value("files").as_object().into_iter().flatten() {
        let wrong = |why: String| CallError::Message(format!("the file {name:?} {why}"));
        let text = content.as_str().ok_or_else(|| wrong("has no content".into()))?;
        let bytes = STANDARD.decode(text).map_err(|error| wrong(format!("is no base64: {error}")))?;
        total += bytes.len();
        if total > MOST {
            return Err(wrong(format!("is too much: all files together have at most {} MB", MOST >> 20)));
        }
        files.insert(name.clone(), bytes.into());
    }
    let names: Vec<String> = files.keys().cloned().collect();
    #[cfg(all(target_arch = "wasm32", target_os = "unknown"))]
    granum_core::input::handed::replace(files);
    Ok(json!({ "files": names }))
}

#[cfg(test)]
mod tests {
    use crate::{Page, SURROGATES};

    #[test]
    fn what_is_no_file_is_refused_by_its_name() {
        let mut page = Page::new(SURROGATES);
        let answer = page.answer(r#"{"call": "files", "files": {"grain.stl": "c29saWQ="}}"#);
        assert_eq!(answer, r#"{"files":["grain.stl"]}"#);
        let answer = page.answer(r#"{"call": "files", "files": {"grain.stl": "?"}}"#);
        assert!(answer.contains("the file \\\"grain.stl\\\" is no base64"), "{answer}");
        assert!(page.answer(r#"{"call": "files", "files": {"grain.stl": 3}}"#).contains("has no content"));
    }
}
