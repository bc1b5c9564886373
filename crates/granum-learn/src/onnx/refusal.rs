//! Why some surrogates have no ONNX form.

use crate::error::LearnError;

/// The methods of granum without an ONNX form, with the reason.
const REASONS: [(&str, &str); 10] = [
    ("mean-curve", "it is a table of means, which granum predict -o writes for any states"),
    ("nearest-run", "it looks up whole runs, which are data and no graph"),
    (
        "boosted-trees",
        "the operators of trees in ONNX have no standard deviations, and these trees need them",
    ),
    (
        "gaussian-process",
        "a Gaussian process of curves answers from the curves of its training runs by a calibration of whole runs; evaluate it with granum (program, library or Python)",
    ),
    ("cascade", "it hands distributions from stage to stage; export surrogates of its stages instead"),
    ("path-gru", PATHS),
    ("path-lstm", PATHS),
    ("path-state-space", PATHS),
    ("path-window", PATHS),
    ("path-tensor", PATHS),
];
const PATHS: &str = "its answer is a mean over rotations of the path, with errors that depend on the whole path so far; granum stream advances it step by step";

/// The refusal of a surrogate of a method, by its name and with the reason.
///
/// ```
/// let text = granum_learn::onnx::refused("gaussian-process").to_string();
/// assert!(text.starts_with("gaussian-process: it has no ONNX form: a Gaussian process of curves"), "{text}");
/// ```
pub fn refused(method: &str) -> LearnError {
    let known = REASONS.iter().find(|(name, _)| *name == method).map(|(_, reason)| *reason);
    let reason = known.unwrap_or("its method does not say what graph it is (Surrogate::onnx)");
    LearnError::Surrogate { method: method.into(), reason: format!("it has no ONNX form: {reason}") }
}
