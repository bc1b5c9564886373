//! The six mappings of Antony, Zhou and Wang (2006) with the sub-models of their Tables 1-6, as fits of a study.
//!
//! `P(f)` is a histogram, which can enter the networks in two forms ([`granum_learn::networks::Form`]); the paper uses single
//! points. If `P(f)` is the output, the captions of the paper mention f among the inputs only once (F2, sub-model 1). Since a
//! network with one output cannot predict P without knowing f, in both forms f is an input of every network whose output
//! is `P(f)`.

use serde::{Deserialize, Serialize};

use granum_learn::networks::{MappingBins, SubModel, sub_model_at};
use granum_learn::{FitSpec, LearnError, Result};

/// A quantity that is an input or the output of a mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PaperQuantity {
    /// Deviator strain `eps_d = eps_1 - eps_3`.
    DeviatorStrain,
    /// Stress ratio `q/p`.
    StressRatio,
    /// Deviator fabric `phi_d = phi_1 - phi_3`.
    DeviatorFabric,
    /// Distribution `P(f)` of contact normal forces, `f = N/<N>`.
    ForceDistribution,
}

impl PaperQuantity {
    /// Symbol of the quantity in the paper.
    pub fn symbol(self) -> &'static str {
        match self {
            PaperQuantity::DeviatorStrain => "ε_d",
            PaperQuantity::StressRatio => "q/p",
            PaperQuantity::DeviatorFabric => "φ_d",
            PaperQuantity::ForceDistribution => "P(f)",
        }
    }

    /// The column of a data set with this quantity; for the force distribution the name of the histogram, whose bins are
    /// columns.
    pub fn column(self) -> &'static str {
        match self {
            PaperQuantity::DeviatorStrain => "deviator_strain",
            PaperQuantity::StressRatio => "stress_ratio",
            PaperQuantity::DeviatorFabric => "deviator_fabric",
            PaperQuantity::ForceDistribution => "probability_density",
        }
    }

    /// The columns of a data set with this quantity, for the given bins of f.
    pub fn columns(self, bins: &MappingBins) -> Vec<String> {
        let column = self.column();
        match self {
            PaperQuantity::ForceDistribution => bins.columns(column),
            _ => vec![column.to_owned()],
        }
    }

    /// The quantity to which a column belongs.
    fn of_column(name: &str) -> Option<PaperQuantity> {
        let all = [DeviatorStrain, StressRatio, DeviatorFabric, ForceDistribution];
        all.into_iter().find(|quantity| match quantity {
            ForceDistribution => name.starts_with(quantity.column()),
            _ => name == quantity.column(),
        })
    }
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
    pub inputs: Vec<PaperQuantity>,
    /// The output.
    pub output: PaperQuantity,
    /// The networks in the order of increasing strain.
    pub sub_models: Vec<SubModel>,
}

use PaperQuantity::{DeviatorFabric, DeviatorStrain, ForceDistribution, StressRatio};

/// A row of the tables of the paper: start and end of the range, number of neurons in each of the two hidden layers, epochs.
type Row = (f64, f64, usize, u64);

/// Tables 1-6 of the paper.
const TABLES: [(&str, &[PaperQuantity], PaperQuantity, [Row; 3]); 6] = [
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
                    range: [scaled(low), scaled(high)],
                    hidden: vec![neurons, neurons],
                    epochs: Some(epochs),
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
        sub_model_at(&self.sub_models, strain)
    }

    /// The mapping as a fit of a study, for the given bins of f.
    pub fn fit(&self, bins: &MappingBins) -> FitSpec {
        let inputs = self.inputs.iter().flat_map(|input| input.columns(bins));
        let spec = FitSpec::new(inputs, self.output.columns(bins)).with_name(&self.name);
        spec.with_coordinate(DeviatorStrain.column()).with_sub_models(self.sub_models.clone())
    }

    /// The mapping that a fit of a study is.
    ///
    /// # Errors
    /// If it has columns that no mapping of the paper has.
    pub fn from_fit(spec: &FitSpec) -> Result<Mapping> {
        let quantities = |names: &[String]| -> Result<Vec<PaperQuantity>> {
            let mut found = Vec::new();
            for name in names {
                let quantity = PaperQuantity::of_column(name).ok_or_else(|| LearnError::Unknown {
                    kind: "quantity of the paper",
                    name: name.clone(),
                    known: [DeviatorStrain, StressRatio, DeviatorFabric, ForceDistribution]
                        .map(PaperQuantity::column)
                        .join(", "),
                })?;
                if found.last() != Some(&quantity) {
                    found.push(quantity);
                }
            }
            Ok(found)
        };
        let output = quantities(&spec.outputs)?.first().copied().unwrap_or(StressRatio);
        let (name, inputs, sub_models) =
            (spec.fit_name(), quantities(&spec.inputs)?, spec.sub_models.clone());
        Ok(Mapping { name, inputs, output, sub_models })
    }

    /// The same mapping with the given number of neurons in every hidden layer.
    pub fn with_neurons(&self, neurons: usize) -> Mapping {
        let mut mapping = self.clone();
        for sub_model in &mut mapping.sub_models {
            sub_model.hidden.iter_mut().for_each(|layer| *layer = neurons);
        }
        mapping
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
            assert_eq!(mapping.sub_models[0].range[0], 0.0);
            for pair in mapping.sub_models.windows(2) {
                assert_eq!(pair[0].range[1], pair[1].range[0]);
            }
            let end = if mapping.output == PaperQuantity::ForceDistribution { 0.298 } else { 0.3 };
            assert_eq!(mapping.sub_models[2].range[1], end);
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
    fn a_mapping_is_a_fit_of_columns() {
        let bins = MappingBins { binned: "force".into(), width: 0.25, centres: vec![0.125, 0.375] };
        let f3 = paper_mapping("F3").unwrap();
        let fit = f3.fit(&bins);
        let densities = ["probability_density_0.125", "probability_density_0.375"];
        assert_eq!(fit.inputs, [&["deviator_strain", "deviator_fabric"][..], &densities].concat());
        assert_eq!(
            (fit.outputs.as_slice(), fit.fit_name()),
            (&["stress_ratio".to_string()][..], "F3".into())
        );
        for mapping in paper_mappings() {
            assert_eq!(Mapping::from_fit(&mapping.fit(&bins)).unwrap(), mapping);
        }
    }

    #[test]
    fn an_unknown_mapping_lists_the_known_ones() {
        let message = paper_mapping("F7").unwrap_err().to_string();
        assert_eq!(message, "there is no mapping `F7`; there are: F1, F2, F3, F4, F5, F6");
    }

    #[test]
    fn stretched_ranges_keep_their_proportions() {
        let mappings = paper_mappings_to(0.15);
        assert!((mappings[1].sub_models[1].range[1] - 0.088).abs() < 1e-15);
        assert!((mappings[0].sub_models[2].range[1] - 0.15).abs() < 1e-15);
    }
}
