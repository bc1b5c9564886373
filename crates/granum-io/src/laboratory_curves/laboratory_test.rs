//! A laboratory test: the quantities that a file can have, the readings as they stand in it, and the test in SI units.

use granum_core::quantity::Dimension;

/// The quantities that a file can have, each with its dimension.
pub const QUANTITIES: [(&str, Dimension); 9] = [
    ("axial_strain", Dimension::NUMBER),
    ("volumetric_strain", Dimension::NUMBER),
    ("axial_stress", Dimension::STRESS),
    ("lateral_stress", Dimension::STRESS),
    ("deviator_stress", Dimension::STRESS),
    ("mean_stress", Dimension::STRESS),
    ("pore_pressure", Dimension::STRESS),
    ("void_ratio", Dimension::NUMBER),
    ("initial_void_ratio", Dimension::NUMBER),
];

/// A doubt about the readings of a test.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LaboratoryDoubt {
    /// What the readings show.
    pub evidence: String,
    /// What was probably meant, and how to state it.
    pub remedy: String,
}

impl std::fmt::Display for LaboratoryDoubt {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        write!(f, "{}: {}", self.evidence, self.remedy)
    }
}

/// One test, in SI units, compression positive, strains engineering ones.
///
/// A quantity that the file does not have is empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LaboratoryTest {
    /// Its name; empty if the file has one test without a name.
    pub name: String,
    /// Change of height over the initial height.
    pub axial_strain: Vec<f64>,
    /// Change of volume over the initial volume.
    pub volumetric_strain: Vec<f64>,
    /// Deviator stress q = axial minus lateral stress, Pa.
    pub deviator_stress: Vec<f64>,
    /// Effective mean stress p, Pa.
    pub mean_stress: Vec<f64>,
    /// Void ratio e.
    pub void_ratio: Vec<f64>,
    /// What its readings are probably not taken for what they are.
    pub doubts: Vec<LaboratoryDoubt>,
}

/// The readings of a test as they stand in the file, in SI units.
pub(super) struct Readings<'a> {
    pub(super) rows: &'a [[f64; QUANTITIES.len()]],
    /// For each quantity -1 if compression is negative in its column.
    pub(super) signs: [f64; QUANTITIES.len()],
}

impl Readings<'_> {
    /// The column of a quantity; empty if the file does not have it, or not in every row.
    pub(super) fn column(&self, wanted: &str) -> Vec<f64> {
        let Some(at) = place(wanted) else { return Vec::new() };
        if self.rows.iter().any(|row| row[at].is_nan()) {
            return Vec::new();
        }
        self.rows.iter().map(|row| row[at]).collect()
    }

    /// The column with compression positive. Zero keeps no sign, which would be printed as "-0 %".
    pub(super) fn signed(&self, wanted: &str) -> Vec<f64> {
        let sign = place(wanted).map_or(1.0, |at| self.signs[at]);
        self.column(wanted).into_iter().map(|x| sign * x + 0.0).collect()
    }
}

/// The place of a quantity among all.
pub(super) fn place(wanted: &str) -> Option<usize> {
    QUANTITIES.iter().position(|(name, _)| *name == wanted)
}
