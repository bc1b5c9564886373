//! `summary.json`: the numerical results of the whole study.
//!
//! The keys `dem` and `mappings`, and the keys inside them that this module names first, are guaranteed to remain; more keys
//! may be added. Times are written into `seconds.json` ([`super::times`]), so that the file has the same bytes on every computer.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::evaluation::Evaluation;
use crate::learning_curve::PaperLearningCurve;
use crate::size_study::SizeStudy;
use granum_learn::input_use::Verdict;
use granum_learn::networks::NetworkScores;
use granum_learn::score::Score;
use granum_learn::student_t::PairedTest;

/// The contents of `summary.json`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PaperSummary {
    /// The sample and the runs.
    pub dem: DemSummary,
    /// The mappings by name, `F1` to `F6`.
    pub mappings: BTreeMap<String, MappingSummary>,
    /// Computing time of the networks compared with DEM; in the file `seconds.json`.
    #[serde(default, skip_serializing)]
    pub speed: SpeedSummary,
    /// The study of network sizes, if it was carried out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub size_study: Option<SizeStudy>,
    /// The learning curve for more than one training run, if it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub learning_curve: Option<PaperLearningCurve>,
    /// Interpretation of the results in plain sentences.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reading: Vec<String>,
}

/// The sample and the runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct DemSummary {
    /// Number of grains.
    pub grains: usize,
    /// Solid fraction at the start of shear.
    pub solid_fraction: f64,
    /// Coordination number over all grains.
    pub coordination_number: f64,
    /// Mechanical coordination number (Thornton 2000).
    pub mechanical_coordination_number: f64,
    /// The runs.
    pub runs: Vec<RunSummary>,
}

/// One run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct RunSummary {
    /// `training` or `unseen`.
    pub role: String,
    /// Seed of the sample.
    pub seed: u64,
    /// Wall time of preparation and shear, s; in the file `seconds.json`.
    #[serde(default, skip_serializing)]
    pub wall_seconds: f64,
    /// Number of grains times number of steps.
    pub grain_steps: f64,
}

/// One mapping.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MappingSummary {
    /// The networks of the mapping.
    pub sub_models: Vec<SubModelSummary>,
    /// Relative RMSE: root mean square error over the root mean square of the DEM values.
    pub relative_rmse: PartScores,
    /// Coefficient of determination.
    pub r2: PartScores,
    /// Scatter between DEM runs with different seeds, in the measure of `relative_rmse`; null for fewer than two runs.
    pub seed_scatter: Option<f64>,
    /// Expected error on an unseen run if the training runs are known perfectly and nothing else is known: the seed
    /// scatter times sqrt(1 + 1/n), where n is the number of training runs.
    pub best_without_sensors: Option<f64>,
    /// Formula of the mapping, as in the paper.
    pub formula: String,
    /// Relative RMSE of the mean curve of the training runs, without any network, on unseen runs.
    pub mean_curve: Option<f64>,
    /// Relative RMSE of ridge regression on the same sensors, on unseen runs.
    #[serde(default)]
    pub ridge: Option<f64>,
    /// Relative RMSE of ridge regression on strain alone, on unseen runs.
    #[serde(default)]
    pub ridge_strain_only: Option<f64>,
    /// Relative RMSE of the networks on unseen runs with the sensors of every other unseen run in turn, at the same
    /// strain; null for fewer than two unseen runs.
    #[serde(default)]
    pub with_other_sensors: Option<f64>,
    /// Relative RMSE with the sensors of the run permuted over its states, within the range of each sub-model.
    #[serde(default)]
    pub with_permuted_sensors: Option<f64>,
    /// Relative RMSE with the sensors of other runs minus that with the sensors of the run itself, over the unseen runs.
    #[serde(default, rename = "use")]
    pub sensor_use: Option<PairedTest>,
    /// Relative RMSE with permuted sensors minus that with the sensors in order, over the unseen runs.
    #[serde(default)]
    pub use_against_permuted: Option<PairedTest>,
    /// Relative RMSE of the strain-only networks minus that of the networks, over the unseen runs.
    #[serde(default)]
    pub help: Option<PairedTest>,
    /// The conclusion from `use` and `help`.
    #[serde(default)]
    pub verdict: Verdict,
    /// Relative RMSE of the networks on the training states.
    pub training: f64,
    /// Relative RMSE of the strain-only networks on held-out states.
    pub strain_only_held_out: f64,
}

/// One network.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SubModelSummary {
    /// Range of deviator strain.
    pub strain_range: [f64; 2],
    /// Numbers of neurons of the hidden layers.
    pub hidden: Vec<usize>,
    /// Number of epochs of the training.
    pub epochs: u64,
    /// Name of the trainer.
    pub trainer: String,
    /// Number of training rows.
    pub rows: usize,
    /// Reason why the training ended.
    pub termination: String,
    /// Effective number of parameters, if the trainer determines it.
    pub effective_parameters: Option<f64>,
    /// True if its predictions for all training states in its range are nearly equal, so that it has learned nothing.
    #[serde(default)]
    pub constant: bool,
    /// Score on held-out states in its range.
    pub held_out: Score,
    /// Score on unseen runs in its range.
    pub unseen: Score,
}

impl From<&NetworkScores> for SubModelSummary {
    fn from(scores: &NetworkScores) -> SubModelSummary {
        let scores = scores.clone();
        SubModelSummary {
            strain_range: scores.range,
            hidden: scores.hidden,
            epochs: scores.epochs,
            trainer: scores.trainer,
            rows: scores.rows,
            termination: scores.termination,
            effective_parameters: scores.effective_parameters,
            constant: scores.constant,
            held_out: scores.held_out,
            unseen: scores.unseen,
        }
    }
}

/// Scores on the parts of a data set.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PartScores {
    /// Score on held-out states of the training runs.
    pub held_out: f64,
    /// Score on unseen runs; null if there are none.
    pub unseen: Option<f64>,
    /// Score of a strain-only network of the same size, on unseen runs (on held-out states if there are none).
    pub strain_only: f64,
}

/// Computing time of the networks compared with DEM.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct SpeedSummary {
    /// Wall time of one DEM test (shear), s.
    pub dem_seconds: f64,
    /// Wall time of the predictions of the networks for the same test, for all mappings and all recorded states, s.
    pub network_seconds: f64,
    /// `dem_seconds / network_seconds`.
    pub factor: f64,
    /// Wall time of the training of all networks, which the factor does not include, s.
    pub training_seconds: f64,
    /// Number of predicted states.
    pub states: usize,
    /// Number of repetitions, of which the median is taken.
    pub repetitions: usize,
}

impl MappingSummary {
    /// The summary of the evaluation of one mapping.
    pub fn new(evaluation: &Evaluation) -> Self {
        let e = evaluation;
        let unseen = |score: Score| (score.states > 0).then_some(score);
        let strain_only = unseen(e.strain_only.unseen).unwrap_or(e.strain_only.held_out);
        MappingSummary {
            sub_models: e.sub_models.iter().map(SubModelSummary::from).collect(),
            relative_rmse: PartScores {
                held_out: e.network.held_out.relative_rmse,
                unseen: unseen(e.network.unseen).map(|score| score.relative_rmse),
                strain_only: strain_only.relative_rmse,
            },
            r2: PartScores {
                held_out: e.network.held_out.r2,
                unseen: unseen(e.network.unseen).map(|score| score.r2),
                strain_only: strain_only.r2,
            },
            seed_scatter: e.seed_scatter,
            best_without_sensors: e.best_without_sensors(),
            formula: e.mapping.formula(),
            mean_curve: unseen(e.mean_curve.unseen).map(|score| score.relative_rmse),
            ridge: unseen(e.ridge.unseen).map(|score| score.relative_rmse),
            ridge_strain_only: unseen(e.ridge_strain_only.unseen).map(|score| score.relative_rmse),
            with_other_sensors: e.sensor_use.with_other.map(|score| score.relative_rmse),
            with_permuted_sensors: e.sensor_use.permuted.map(|score| score.relative_rmse),
            sensor_use: e.sensor_use.lost_with_other(),
            use_against_permuted: e.sensor_use.lost_permuted(),
            help: e.sensor_use.help(),
            verdict: e.sensor_use.verdict(),
            training: e.network.training.relative_rmse,
            strain_only_held_out: e.strain_only.held_out.relative_rmse,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The guaranteed keys exist with their names and types.
    #[test]
    fn the_promised_keys_are_there() {
        let mapping = MappingSummary {
            sub_models: vec![SubModelSummary {
                strain_range: [0.0, 0.1],
                hidden: vec![60, 60],
                epochs: 100,
                trainer: "levenberg-marquardt".into(),
                ..Default::default()
            }],
            seed_scatter: Some(0.03),
            relative_rmse: PartScores { unseen: Some(0.05), ..Default::default() },
            ridge: Some(0.04),
            ridge_strain_only: Some(0.05),
            with_other_sensors: Some(0.06),
            with_permuted_sensors: Some(0.07),
            sensor_use: PairedTest::new(&[0.01, 0.02, 0.03]),
            help: PairedTest::new(&[0.01, 0.02, 0.03]),
            ..Default::default()
        };
        let summary = PaperSummary {
            dem: DemSummary { grains: 5000, runs: vec![RunSummary::default()], ..Default::default() },
            mappings: [("F1".to_owned(), mapping)].into(),
            ..Default::default()
        };
        let json: serde_json::Value = serde_json::to_value(&summary).unwrap();
        for pointer in [
            "/dem/grains",
            "/dem/solid_fraction",
            "/dem/coordination_number",
            "/dem/mechanical_coordination_number",
            "/dem/runs/0/seed",
            "/dem/runs/0/grain_steps",
            "/mappings/F1/sub_models/0/strain_range/1",
            "/mappings/F1/sub_models/0/hidden/0",
            "/mappings/F1/sub_models/0/epochs",
            "/mappings/F1/relative_rmse/held_out",
            "/mappings/F1/relative_rmse/unseen",
            "/mappings/F1/relative_rmse/strain_only",
            "/mappings/F1/r2/held_out",
            "/mappings/F1/r2/strain_only",
            "/mappings/F1/seed_scatter",
            "/mappings/F1/ridge",
            "/mappings/F1/ridge_strain_only",
            "/mappings/F1/with_other_sensors",
            "/mappings/F1/with_permuted_sensors",
            "/mappings/F1/use/mean",
            "/mappings/F1/use/standard_error",
            "/mappings/F1/help/t",
        ] {
            let value = json.pointer(pointer).unwrap_or_else(|| panic!("{pointer} is missing"));
            assert!(value.is_number(), "{pointer}: {value}");
        }
        assert!(json.pointer("/dem/runs/0/role").unwrap().is_string());
        assert!(json.pointer("/mappings/F1/sub_models/0/trainer").unwrap().is_string());
        assert!(json.pointer("/mappings/F1/verdict").unwrap().is_string());
        assert!(json.pointer("/mappings/F1/sub_models/0/constant").unwrap().is_boolean());
        let back: PaperSummary = serde_json::from_value(json).unwrap();
        assert_eq!(back, summary);
    }
}
