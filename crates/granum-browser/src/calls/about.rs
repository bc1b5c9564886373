//! What the module is.

use granum_simd::Isa;
use serde_json::{Value, json};

use crate::answer::CallError;
use crate::page::{Arguments, Page};

/// Version, instruction set, and how products are added: `relaxed`, by an instruction that the page has found to fuse, or `exact`.
pub(super) fn about(page: &mut Page, _: &Arguments) -> Result<Value, CallError> {
    let fused = if cfg!(granum_relaxed) { "relaxed" } else { "exact" };
    Ok(json!({
        "version": page.laboratory.version,
        "instruction_set": Isa::detect().name(),
        "fused_multiply_add": fused,
    }))
}
