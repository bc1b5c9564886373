//! The names of materials in case files and packings.

/// True for a name that a material can have.
pub(crate) fn is_material_name(name: &str) -> bool {
    let usual = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !name.is_empty() && name.len() <= 60 && name.chars().all(usual)
}
