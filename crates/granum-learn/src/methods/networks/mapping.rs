//! The quantities that networks map to each other, and the columns of the networks.
//!
//! A histogram can be an input in two forms. In the **point form** a state gives one row for each bin, and the inputs of the
//! networks are (coordinate, ..., binned variable, value of the bin). In the **histogram form** all bins of a state are inputs
//! of the same row. If a histogram is the output, in both forms the binned variable is an input of the networks, since a network
//! with one output cannot predict the value of a bin without knowing the bin.

use serde::{Deserialize, Serialize};

use crate::curve::range;
use crate::dataset::{ColumnGroup, Dataset, RunStates, Variable, record_error};
use crate::error::{LearnError, Result};
use crate::surrogate::settings::Form;
use crate::surrogate::sub_model::{SubModel, sub_model_at};
use crate::surrogate::{Columns, FitSpec};

/// A quantity among the inputs and the output: a column, or some bins of a histogram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MappingQuantity {
    /// Name of the column, or of the histogram.
    pub name: String,
    /// Unit; empty for a dimensionless number.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub unit: String,
    /// The bins that are used; `None` for a column.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bins: Option<MappingBins>,
}

/// Bins of a histogram.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MappingBins {
    /// The binned variable.
    pub binned: String,
    /// Width of a bin.
    pub width: f64,
    /// The centres of the bins.
    pub centres: Vec<f64>,
}

impl MappingBins {
    /// The columns of a data set with these bins of the histogram of the given name.
    pub fn columns(&self, histogram: &str) -> Vec<String> {
        let group = ColumnGroup {
            name: histogram.to_owned(),
            binned: self.binned.clone(),
            bin_width: self.width,
            centres: self.centres.clone(),
        };
        group.columns().collect()
    }
}

impl MappingQuantity {
    /// The columns of a data set with the quantity.
    pub fn variables(&self) -> Vec<Variable> {
        let variable = |name: String| Variable { name, unit: self.unit.clone() };
        match &self.bins {
            None => vec![variable(self.name.clone())],
            Some(bins) => bins.columns(&self.name).into_iter().map(variable).collect(),
        }
    }

    /// Number of values in a state.
    pub fn len(&self) -> usize {
        self.bins.as_ref().map_or(1, |bins| bins.centres.len())
    }

    /// True if it has no value, which no fitted quantity is.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn unit_of_networks(&self) -> &str {
        if self.unit.is_empty() { "1" } else { &self.unit }
    }
}

/// A mapping of quantities to a quantity, with a network for each sub-model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NetworkMapping {
    /// Its name.
    pub name: String,
    /// The inputs.
    pub inputs: Vec<MappingQuantity>,
    /// Number of the coordinate among the inputs, from 0.
    pub coordinate: usize,
    /// The output.
    pub output: MappingQuantity,
    /// Form in which histograms that are inputs enter the networks.
    pub form: Form,
    /// The networks in the order of the coordinate.
    pub sub_models: Vec<SubModel>,
}

impl NetworkMapping {
    /// The mapping of a fit to the columns of a data set. Without sub-models there is one for all states, with hidden layers of
    /// the given sizes.
    ///
    /// # Errors
    /// If there is no coordinate, the outputs are more than one column or histogram, ranges of sub-models overlap, or histograms
    /// cannot be used in this form.
    pub fn new(dataset: &Dataset, spec: &FitSpec, form: Form, hidden: &[usize]) -> Result<NetworkMapping> {
        let bad = |reason: String| Err(LearnError::Dataset(reason));
        let columns = spec.columns(dataset)?;
        let inputs = quantities(dataset, &columns.inputs)?;
        let mut outputs = quantities(dataset, &columns.outputs)?;
        let Some(name) = &spec.coordinate else {
            return bad(
                "networks by sub-model need a coordinate, which says where each of them predicts".into()
            );
        };
        let Some(coordinate) = inputs.iter().position(|input| input.name == *name) else {
            return bad(format!("the coordinate {name} is no input"));
        };
        let (Some(output), true) = (outputs.pop(), outputs.is_empty()) else {
            return bad(
                "networks by sub-model predict one column or one histogram; fit each output separately"
                    .into(),
            );
        };
        let sub_models = match spec.sub_models.as_slice() {
            [] => vec![SubModel::new(range(dataset.column(name)?), hidden)],
            given => given.to_vec(),
        };
        let ordered = sub_models.iter().all(|s| s.range[0] < s.range[1])
            && sub_models.windows(2).all(|pair| pair[0].range[1] <= pair[1].range[0]);
        if !ordered {
            let ranges: Vec<String> =
                sub_models.iter().map(|s| format!("{} to {}", s.range[0], s.range[1])).collect();
            return bad(format!("the ranges of {name} must follow each other: {}", ranges.join(", ")));
        }
        let histograms = inputs.iter().chain([&output]).filter(|quantity| quantity.bins.is_some()).count();
        if form == Form::Point && histograms > 1 {
            return bad("in point form there can be one histogram among the inputs and the output; use the histogram form".into());
        }
        Ok(NetworkMapping { name: spec.fit_name(), inputs, coordinate, output, form, sub_models })
    }

    /// The inputs and outputs as columns of a data set.
    pub fn columns(&self) -> Columns {
        let inputs = self.inputs.iter().flat_map(MappingQuantity::variables).collect();
        Columns { inputs, outputs: self.output.variables() }
    }

    /// Refuses a data set whose histograms have bins of another width.
    ///
    /// # Errors
    /// If there is such a histogram.
    pub fn check_bins(&self, dataset: &Dataset) -> Result<()> {
        for quantity in self.inputs.iter().chain([&self.output]) {
            let Some(bins) = &quantity.bins else { continue };
            for run in dataset.runs() {
                check_width(run, &quantity.name, bins.width)?;
            }
        }
        Ok(())
    }

    /// The value of the coordinate in a row of [`NetworkMapping::columns`].
    pub fn coordinate_of(&self, row: &[f64]) -> f64 {
        row[self.place_of_coordinate()]
    }

    /// Index of the coordinate in a row of [`NetworkMapping::columns`].
    pub(super) fn place_of_coordinate(&self) -> usize {
        self.inputs[..self.coordinate].iter().map(MappingQuantity::len).sum()
    }

    /// Index of the coordinate among the inputs of the networks.
    pub(super) fn place_in_networks(&self) -> usize {
        let before = &self.inputs[..self.coordinate];
        before.iter().map(|input| if self.is_point(input) { 2 } else { input.len() }).sum()
    }

    /// Name of the coordinate.
    pub fn coordinate_name(&self) -> &str {
        &self.inputs[self.coordinate].name
    }

    /// The sub-model for a value of the coordinate, see [`sub_model_at`].
    pub fn sub_model_at(&self, x: f64) -> (usize, bool) {
        sub_model_at(&self.sub_models, x)
    }

    /// True if the output is a histogram.
    pub fn predicts_histogram(&self) -> bool {
        self.output.bins.is_some()
    }

    pub(super) fn is_point(&self, input: &MappingQuantity) -> bool {
        input.bins.is_some() && self.form == Form::Point
    }

    /// The bins of which each gives a row, if a state gives several rows.
    fn points(&self) -> Option<&[f64]> {
        let bins = match &self.output.bins {
            Some(bins) => Some(bins),
            None => {
                self.inputs.iter().find(|input| self.is_point(input)).and_then(|input| input.bins.as_ref())
            }
        };
        bins.map(|bins| bins.centres.as_slice())
    }

    /// Number of rows of the networks that a state gives.
    pub(super) fn rows_of_state(&self) -> usize {
        self.points().map_or(1, <[f64]>::len)
    }

    /// Number of rows of the networks whose mean is the prediction of one value.
    pub(super) fn points_of_value(&self) -> usize {
        if self.predicts_histogram() { 1 } else { self.rows_of_state() }
    }

    /// The centres of the bins of the output; empty for a column.
    pub fn output_centres(&self) -> &[f64] {
        self.output.bins.as_ref().map_or(&[], |bins| &bins.centres)
    }

    /// Names and units of the inputs of the networks.
    pub fn network_inputs(&self) -> Vec<granum_nets::ModelColumn> {
        let mut columns = Vec::new();
        for input in &self.inputs {
            match &input.bins {
                Some(bins) if self.form == Form::Point => {
                    columns.push(granum_nets::ModelColumn::new(&bins.binned, "1"));
                    columns.push(granum_nets::ModelColumn::new(&input.name, input.unit_of_networks()));
                }
                _ => columns.extend(
                    input
                        .variables()
                        .iter()
                        .map(|v| granum_nets::ModelColumn::new(&v.name, input.unit_of_networks())),
                ),
            }
        }
        columns
            .extend(self.output.bins.as_ref().map(|bins| granum_nets::ModelColumn::new(&bins.binned, "1")));
        columns
    }

    /// Name and unit of the output of the networks.
    pub fn network_output(&self) -> granum_nets::ModelColumn {
        granum_nets::ModelColumn::new(&self.output.name, self.output.unit_of_networks())
    }

    /// For each input of the networks, the number of the quantity to which it belongs; all bins of a histogram are one quantity.
    pub(super) fn input_quantities(&self) -> Vec<usize> {
        let mut numbers: Vec<usize> = Vec::new();
        for input in &self.inputs {
            let next = numbers.last().map_or(0, |last| last + 1);
            match self.is_point(input) {
                true => numbers.extend([next, next + 1]),
                false => numbers.extend(std::iter::repeat_n(next, input.len())),
            }
        }
        if self.predicts_histogram() {
            numbers.push(numbers.last().map_or(0, |last| last + 1));
        }
        numbers
    }

    /// Adds the rows of network inputs for a state, given as a row of [`NetworkMapping::columns`]; a histogram is predicted at
    /// the values `at` of the binned variable.
    pub(super) fn push_inputs(&self, row: &[f64], at: &[f64], inputs: &mut Vec<f64>) {
        let points = if self.predicts_histogram() { Some(at) } else { self.points() };
        for point in 0..points.map_or(1, <[f64]>::len) {
            let mut start = 0;
            for input in &self.inputs {
                let values = &row[start..start + input.len()];
                start += input.len();
                match &input.bins {
                    Some(bins) if self.form == Form::Point => {
                        inputs.extend([bins.centres[point], values[point]])
                    }
                    _ => inputs.extend_from_slice(values),
                }
            }
            if self.predicts_histogram() {
                inputs.push(at[point]);
            }
        }
    }
}

/// The quantities in columns: successive bins of one histogram are one quantity.
fn quantities(dataset: &Dataset, variables: &[Variable]) -> Result<Vec<MappingQuantity>> {
    let mut found: Vec<MappingQuantity> = Vec::new();
    let groups: &[ColumnGroup] = dataset.runs().first().map_or(&[], RunStates::groups);
    for variable in variables {
        let unit = if variable.unit == "1" { String::new() } else { variable.unit.clone() };
        let centre = |group: &ColumnGroup| {
            group.centres.iter().copied().find(|centre| group.column(*centre) == variable.name)
        };
        let Some((group, centre)) = groups.iter().find_map(|group| Some((group, centre(group)?))) else {
            found.push(MappingQuantity { name: variable.name.clone(), unit, bins: None });
            continue;
        };
        if let Some(MappingQuantity { name, bins: Some(bins), .. }) = found.last_mut()
            && *name == group.name
        {
            bins.centres.push(centre);
            continue;
        }
        for run in dataset.runs() {
            check_width(run, &group.name, group.bin_width)?;
        }
        let bins =
            MappingBins { binned: group.binned.clone(), width: group.bin_width, centres: vec![centre] };
        found.push(MappingQuantity { name: group.name.clone(), unit, bins: Some(bins) });
    }
    Ok(found)
}

fn check_width(run: &RunStates, histogram: &str, width: f64) -> Result<()> {
    match run.group(histogram) {
        Some(group) if (group.bin_width - width).abs() > 1e-9 * width => Err(record_error(
            run.name(),
            format!(
                "its histogram {histogram} does not have the bins that the networks learn; record with bins of width {width}"
            ),
        )),
        _ => Ok(()),
    }
}
