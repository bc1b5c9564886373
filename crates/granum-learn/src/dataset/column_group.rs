//! The columns of a histogram.

use granum_core::quantity::format_number;

/// The columns of a histogram: one for each bin, with the probability density in it. The name of a column consists of the name of the
/// group and the centre of the bin: `probability_density_0.125` for the forces, `overlaps_probability_density_0.05` for a
/// histogram `overlaps`.
///
/// ```
/// use granum_core::{Column, Table};
/// use granum_learn::dataset::{ColumnGroup, RunStates};
///
/// let columns = ["probability_density_0.5", "probability_density_1.5"];
/// let table = Table::new(columns.iter().map(|name| Column::new(*name, "", vec![0.6, 0.7])).collect())?;
/// let centres = vec![0.5, 1.5];
/// let (name, binned) = ("probability_density".to_string(), "force".to_string());
/// let run = RunStates::new("run", table)?.with_group(ColumnGroup { name, binned, bin_width: 1.0, centres })?;
/// assert_eq!(run.group("probability_density").unwrap().columns().collect::<Vec<_>>(), columns);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnGroup {
    /// The quantity in the columns; the name of each column consists of it and the centre of the bin.
    pub name: String,
    /// The binned variable.
    pub binned: String,
    /// Width of a bin.
    pub bin_width: f64,
    /// Centre of each bin.
    pub centres: Vec<f64>,
}

impl ColumnGroup {
    /// Name of the column of a bin.
    pub fn column(&self, centre: f64) -> String {
        format!("{}_{}", self.name, format_number(without_rounding_error(centre)))
    }

    /// Names of all columns.
    pub fn columns(&self) -> impl Iterator<Item = String> + '_ {
        self.centres.iter().map(|&centre| self.column(centre))
    }

    /// The name of the column of a bin that is meant by a name with the same centre in other digits: `_0.35000000000000003`, as
    /// earlier versions wrote it, or `_0.350`.
    pub fn column_meant(&self, name: &str) -> Option<String> {
        let centre: f64 = name.strip_prefix(&self.name)?.strip_prefix('_')?.parse().ok()?;
        let near = |known: &&f64| (**known - centre).abs() < 1e-6 * self.bin_width;
        self.centres.iter().find(near).map(|known| self.column(*known))
    }
}

/// A number to twelve significant digits: the centre of a bin is a product, 3.5 times 0.1 for example, and shows its rounding error.
fn without_rounding_error(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
