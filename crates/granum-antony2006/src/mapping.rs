//! The six mappings of Antony, Zhou and Wang (2006) with the sub-models of their Tables 1-6.
//!
//! `P(f)` can be an input in two forms. In the **point form** of the paper, a state of a test gives one row for each bin
//! of f, and the inputs are (strain, ..., f, P). In the **histogram form** all bins of a state are inputs of the same row.
//!
//! If `P(f)` is the output, the captions of the paper mention f among the inputs only once (F2, sub-model 1). Since a
//! network with one output cannot predict P without knowing f, in both forms f is an input of every network whose output
//! is `P(f)`.

use serde::{Deserialize, Serialize};

use granum_learn::{LearnError, Result};

/// A quantity that is an input or the output of a mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Deviator strain `eps_d = eps_1 - eps_3`.
    DeviatorStrain,
    /// Stress ratio `q/p`.
    StressRatio,
    /// Deviator fabric `phi_d = phi_1 - phi_3`.
    DeviatorFabric,
    /// Distribution `P(f)` of contact normal forces, `f = N/<N>`.
    ForceDistribution,
}

impl Quantity {
    /// Symbol of the quantity in the paper.
    pub fn symbol(self) -> &'static str {
        match self {
            Quantity::DeviatorStrain => "ε_d",
            Quantity::StressRatio => "q/p",
            Quantity::DeviatorFabric => "φ_d",
            Quantity::ForceDistribution => "P(f)",
        }
    }

    /// The column of a data set with this quantity; for the force distribution the name of the histogram, whose bins are
    /// columns.
    pub fn column(self) -> &'static str {
        match self {
            Quantity::DeviatorStrain => "deviator_strain",
            Quantity::StressRatio => "stress_ratio",
            Quantity::DeviatorFabric => "deviator_fabric",
            Quantity::ForceDistribution => "probability_density",
        }
    }

    fn is_distribution(self) -> bool {
        self == Quantity::ForceDistribution
    }
}

/// The form in which the force distribution enters a network.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// As single points: f and P(f) are one input each, and a state gives one row for each bin (as in the paper).
    #[default]
    Point,
    /// As a whole: every bin is an input.
    Histogram,
}

/// One network of a mapping: its range of strain, size and training.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SubModel {
    /// Range of deviator strain; its end belongs to the next sub-model, if there is one.
    pub strain_range: [f64; 2],
    /// Numbers of neurons of the hidden layers.
    pub hidden: Vec<usize>,
    /// Number of epochs of the trainer of the paper.
    pub epochs: u64,
}

/// A mapping between micro- and macroscopic quantities.
///
/// ```
/// let mappings = granum_antony2006::paper_mappings();
/// assert_eq!(mappings[2].formula(), "q/p = F3(ε_d, φ_d, P(f))");
/// // The range of the second sub-model starts at a deviator strain of 0.1.
/// assert_eq!(mappings[2].sub_model_at(0.1), (1, true));
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mapping {
    /// Name of the mapping, `F1` to `F6` in the paper.
    pub name: String,
    /// The inputs, starting with the strain.
    pub inputs: Vec<Quantity>,
    /// The output.
    pub output: Quantity,
    /// The networks in the order of increasing strain.
    pub sub_models: Vec<SubModel>,
}

use Quantity::{DeviatorFabric, DeviatorStrain, ForceDistribution, StressRatio};

/// A row of the tables of the paper: start and end of the range, number of neurons in each of the two hidden layers, epochs.
type Row = (f64, f64, usize, u64);

/// Tables 1-6 of the paper.
const TABLES: [(&str, &[Quantity], Quantity, [Row; 3]); 6] = [
    (
        "F1",
        &[DeviatorStrain, ForceDistribution],
        StressRatio,
        [(0.0, 0.1, 60, 120_000), (0.1, 0.2, 55, 150_000), (0.2, 0.3, 50, 150_000)],
    ),
    (
        "F2",
        &[DeviatorStrain, StressRatio],
        ForceDistribution,
        [(0.0, 0.05, 25, 90_000), (0.05, 0.176, 40, 120_000), (0.176, 0.298, 65, 90_000)],
    ),
    (
        "F3",
        &[DeviatorStrain, DeviatorFabric, ForceDistribution],
        StressRatio,
        [(0.0, 0.1, 50, 150_000), (0.1, 0.2, 50, 90_000), (0.2, 0.3, 50, 60_000)],
    ),
    (
        "F4",
        &[DeviatorStrain, DeviatorFabric],
        ForceDistribution,
        [(0.0, 0.05, 25, 60_000), (0.05, 0.176, 40, 150_000), (0.176, 0.298, 55, 60_000)],
    ),
    (
        "F5",
        &[DeviatorStrain, DeviatorFabric, StressRatio],
        ForceDistribution,
        [(0.0, 0.05, 25, 150_000), (0.05, 0.176, 40, 120_000), (0.176, 0.298, 55, 120_000)],
    ),
    (
        "F6",
        &[DeviatorStrain, ForceDistribution],
        DeviatorFabric,
        [(0.0, 0.1, 50, 120_000), (0.1, 0.2, 60, 120_000), (0.2, 0.3, 65, 60_000)],
    ),
];

/// Deviator strain at the end of the tests of the paper.
pub const PAPER_STRAIN: f64 = 0.3;

/// The mappings F1-F6 with the sub-models of Tables 1-6.
pub fn paper_mappings() -> Vec<Mapping> {
    paper_mappings_to(PAPER_STRAIN)
}

/// The mappings F1-F6 for tests that end at another strain: the strain ranges are scaled so that 0.3 becomes `end`.
pub fn paper_mappings_to(end: f64) -> Vec<Mapping> {
    let scaled = |strain: f64| if end == PAPER_STRAIN { strain } else { strain / PAPER_STRAIN * end };
    TABLES
        .iter()
        .map(|(name, inputs, output, rows)| Mapping {
            name: (*name).to_owned(),
            inputs: inputs.to_vec(),
            output: *output,
            sub_models: rows
                .iter()
                .map(|&(low, high, neurons, epochs)| SubModel {
                    strain_range: [scaled(low), scaled(high)],
                    hidden: vec![neurons, neurons],
                    epochs,
                })
                .collect(),
        })
        .collect()
}

/// The mapping of the given name among F1-F6.
///
/// # Errors
/// [`LearnError::Unknown`] if there is no such mapping.
pub fn paper_mapping(name: &str) -> Result<Mapping> {
    paper_mappings().into_iter().find(|mapping| mapping.name == name).ok_or_else(|| LearnError::Unknown {
        kind: "mapping",
        name: name.to_owned(),
        known: TABLES.map(|row| row.0).join(", "),
    })
}

impl Mapping {
    /// The formula as in the paper: `q/p = F1(ε_d, P(f))`.
    pub fn formula(&self) -> String {
        let inputs: Vec<&str> = self.inputs.iter().map(|input| input.symbol()).collect();
        format!("{} = {}({})", self.output.symbol(), self.name, inputs.join(", "))
    }

    /// The sub-model for a strain, and whether its range contains the strain; if no range does, it is the nearest sub-model.
    pub fn sub_model_at(&self, strain: f64) -> (usize, bool) {
        let last = self.sub_models.len().saturating_sub(1);
        let holds = |k: usize| {
            let [low, high] = self.sub_models[k].strain_range;
            strain >= low && (strain < high || (k == last && strain <= high))
        };
        if let Some(k) = (0..self.sub_models.len()).find(|&k| holds(k)) {
            return (k, true);
        }
        let distance = |k: usize| {
            let [low, high] = self.sub_models[k].strain_range;
            (low - strain).max(strain - high)
        };
        let nearest = (0..self.sub_models.len()).min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
        (nearest.unwrap_or(0), false)
    }

    /// The strain-only version of the mapping, with the same output, ranges, sizes and epochs.
    pub fn strain_only(&self) -> Mapping {
        Mapping { inputs: vec![Quantity::DeviatorStrain], ..self.clone() }
    }

    /// The same mapping with the given number of neurons in every hidden layer.
    pub fn with_neurons(&self, neurons: usize) -> Mapping {
        let mut mapping = self.clone();
        for sub_model in &mut mapping.sub_models {
            sub_model.hidden.iter_mut().for_each(|layer| *layer = neurons);
        }
        mapping
    }

    /// Names of the inputs of the networks, for bins of f with the given centres.
    pub fn network_inputs(&self, form: Form, forces: &[f64]) -> Vec<String> {
        let mut names = Vec::new();
        for input in &self.inputs {
            let column = input.column();
            match (input.is_distribution(), form) {
                (false, _) => names.push(column.to_owned()),
                (true, Form::Point) => names.extend(["force".to_owned(), column.to_owned()]),
                (true, Form::Histogram) => {
                    names.extend(forces.iter().map(|force| format!("{column}_{force}")))
                }
            }
        }
        if self.output == Quantity::ForceDistribution {
            names.push("force".to_owned());
        }
        names
    }

    /// For each input of the networks, the number of the quantity to which it belongs; all bins of a distribution are one
    /// quantity.
    pub fn input_quantities(&self, form: Form, bins: usize) -> Vec<usize> {
        let mut numbers = Vec::new();
        for input in &self.inputs {
            let next = numbers.last().map_or(0, |last| last + 1);
            match (input.is_distribution(), form) {
                (false, _) => numbers.push(next),
                (true, Form::Point) => numbers.extend([next, next + 1]),
                (true, Form::Histogram) => numbers.extend(std::iter::repeat_n(next, bins)),
            }
        }
        if self.output == Quantity::ForceDistribution {
            numbers.push(numbers.last().map_or(0, |last| last + 1));
        }
        numbers
    }

    /// Name of the output of the networks.
    pub fn network_output(&self) -> &'static str {
        self.output.column()
    }

    /// True if a state gives one row for each bin of f.
    pub fn has_point_rows(&self, form: Form) -> bool {
        let reads = self.inputs.contains(&Quantity::ForceDistribution);
        self.output == Quantity::ForceDistribution || (reads && form == Form::Point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formulas_are_those_of_the_tables() {
        let formulas: Vec<String> = paper_mappings().iter().map(Mapping::formula).collect();
        assert_eq!(
            formulas,
            [
                "q/p = F1(ε_d, P(f))",
                "P(f) = F2(ε_d, q/p)",
                "q/p = F3(ε_d, φ_d, P(f))",
                "P(f) = F4(ε_d, φ_d)",
                "P(f) = F5(ε_d, φ_d, q/p)",
                "φ_d = F6(ε_d, P(f))",
            ]
        );
    }

    #[test]
    fn ranges_join_without_gaps_and_end_where_the_paper_ends() {
        for mapping in paper_mappings() {
            assert_eq!(mapping.sub_models.len(), 3);
            assert_eq!(mapping.sub_models[0].strain_range[0], 0.0);
            for pair in mapping.sub_models.windows(2) {
                assert_eq!(pair[0].strain_range[1], pair[1].strain_range[0]);
            }
            let end = if mapping.output == Quantity::ForceDistribution { 0.298 } else { 0.3 };
            assert_eq!(mapping.sub_models[2].strain_range[1], end);
        }
    }

    #[test]
    fn the_sub_model_is_chosen_by_strain() {
        let f2 = paper_mapping("F2").unwrap();
        for (strain, expected) in [
            (0.0, (0, true)),
            (0.049, (0, true)),
            (0.05, (1, true)),
            (0.176, (2, true)),
            (0.298, (2, true)),
            (0.299, (2, false)),
            (-0.001, (0, false)),
        ] {
            assert_eq!(f2.sub_model_at(strain), expected, "{strain}");
        }
    }

    #[test]
    fn inputs_and_outputs_have_names_in_both_forms() {
        let forces = [0.125, 0.375];
        let f5 = paper_mapping("F5").unwrap();
        assert_eq!(
            f5.network_inputs(Form::Point, &forces),
            ["deviator_strain", "deviator_fabric", "stress_ratio", "force"]
        );
        assert_eq!(f5.network_output(), "probability_density");
        let f1 = paper_mapping("F1").unwrap();
        assert_eq!(
            f1.network_inputs(Form::Point, &forces),
            ["deviator_strain", "force", "probability_density"]
        );
        assert_eq!(
            f1.network_inputs(Form::Histogram, &forces),
            ["deviator_strain", "probability_density_0.125", "probability_density_0.375"]
        );
        assert_eq!(f1.strain_only().network_inputs(Form::Point, &forces), ["deviator_strain"]);
        assert_eq!(f5.strain_only().network_inputs(Form::Point, &forces), ["deviator_strain", "force"]);
        assert!(
            !f1.strain_only().has_point_rows(Form::Point) && f5.strain_only().has_point_rows(Form::Point)
        );
    }

    #[test]
    fn an_unknown_mapping_lists_the_known_ones() {
        let message = paper_mapping("F7").unwrap_err().to_string();
        assert_eq!(message, "there is no mapping `F7`; there are: F1, F2, F3, F4, F5, F6");
    }

    #[test]
    fn stretched_ranges_keep_their_proportions() {
        let mappings = paper_mappings_to(0.15);
        assert!((mappings[1].sub_models[1].strain_range[1] - 0.088).abs() < 1e-15);
        assert!((mappings[0].sub_models[2].strain_range[1] - 0.15).abs() < 1e-15);
    }
}
