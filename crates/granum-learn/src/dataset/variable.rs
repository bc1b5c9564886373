//! Name and unit of a column.

/// Name and unit of a column.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Variable {
    /// Its name.
    pub name: String,
    /// SI unit; empty for a dimensionless number, or if the source does not give it.
    pub unit: String,
}
