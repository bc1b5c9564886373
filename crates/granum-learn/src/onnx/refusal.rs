//! Why some surrogates have no ONNX form.

use crate::error::LearnError;

/// Most bytes of a file: programs read no more of this format.
pub(crate) const MOST_BYTES: usize = i32::MAX as usize;

/// The refusal of a surrogate whose file would have so many bytes.
pub(crate) fn too_large(method: &str, bytes: usize) -> LearnError {
    let [has, most] = [bytes, MOST_BYTES].map(|bytes| bytes / 1_000_000);
    let reason = format!(
        "its ONNX file would have {has} MB, and this format holds at most {most} MB: fit it to fewer runs"
    );
    LearnError::Surrogate { method: method.into(), reason }
}

/// The methods of granum without an ONNX form, with the reason.
const REASONS: [(&str, &str); 1] = [("nearest-run", "it looks up whole runs, which are data and no graph")];

/// The refusal of a surrogate of a method, by its name and with the reason.
///
/// ```
/// let text = granum_learn::onnx::refused("nearest-run").to_string();
/// assert!(text.starts_with("nearest-run: it has no ONNX form: it looks up whole runs"), "{text}");
/// ```
pub fn refused(method: &str) -> LearnError {
    let known = REASONS.iter().find(|(name, _)| *name == method).map(|(_, reason)| *reason);
    let reason = known.unwrap_or("its method does not say what graph it is (Surrogate::onnx)");
    LearnError::Surrogate { method: method.into(), reason: format!("it has no ONNX form: {reason}") }
}
