//! The data of Figures 3-8: networks as lines, unseen DEM runs as points, the seed scatter as a band.
//!
//! Figures 3, 5 and 8 show a scalar as a function of strain, with one line for each sub-model; Figures 4, 6 and 7 show
//! P(f) as a function of f at three strains, with one panel for each sub-model. The soft sensors that a network receives
//! are those of the unseen run that is shown as points, interpolated linearly between recorded states.

use serde::{Deserialize, Serialize};

use crate::mapping::{Mapping, Quantity};
use crate::study::evaluation::scatter;
use crate::study::trained::{Study, TrainedMapping};
use crate::study_data::{Run, State, StudyData};
use granum_learn::Result;

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Name of the mapping.
    pub mapping: String,
    /// Formula of the mapping, as in the paper.
    pub formula: String,
    /// Quantity on the vertical axis.
    pub output: Quantity,
    /// Panels of the figure.
    pub panels: Vec<Panel>,
}

/// A panel of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Panel {
    /// Range of deviator strain of the panel.
    pub strain_range: [f64; 2],
    /// True if the horizontal axis is f, false if it is the deviator strain.
    pub against_force: bool,
    /// Curves of the networks.
    pub lines: Vec<Curve>,
    /// Curves of the strain-only networks.
    pub strain_only: Vec<Curve>,
    /// Unseen DEM runs.
    pub points: Vec<Curve>,
    /// Mean of all DEM runs minus and plus one standard deviation between them.
    pub bands: Vec<Band>,
}

/// Values to draw as a line or as points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the DEM run that is shown, or whose soft sensors were the inputs.
    pub run: String,
    /// Number of the sub-model, from 1; 0 for DEM.
    pub sub_model: usize,
    /// Deviator strain of the curve, if the horizontal axis is f.
    pub strain: Option<f64>,
    /// Horizontal coordinates.
    pub x: Vec<f64>,
    /// Vertical coordinates.
    pub y: Vec<f64>,
    /// True where the inputs of a network were outside its trained range.
    pub outside: Vec<bool>,
}

/// A band to shade.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Deviator strain of the band, if the horizontal axis is f.
    pub strain: Option<f64>,
    /// Horizontal coordinates.
    pub x: Vec<f64>,
    /// Lower edge of the band.
    pub low: Vec<f64>,
    /// Upper edge of the band.
    pub high: Vec<f64>,
}

/// Number of points of a line.
const FINE: usize = 200;

/// The figures of a study, one for each mapping. If there are no unseen runs, the training runs are shown instead.
///
/// # Errors
/// If a state contains a value that is not finite.
pub fn figures(study: &Study, dataset: &StudyData) -> Result<Vec<Figure>> {
    let runs = if dataset.unseen_runs.is_empty() { &dataset.training_runs } else { &dataset.unseen_runs };
    study
        .mappings
        .iter()
        .map(|trained| {
            let mapping = trained.surrogate.mapping();
            let panels = if mapping.output == Quantity::ForceDistribution {
                (0..mapping.sub_models.len())
                    .map(|k| distribution_panel(trained, dataset, runs, k))
                    .collect::<Result<_>>()?
            } else {
                vec![scalar_panel(trained, dataset, runs)?]
            };
            Ok(Figure {
                mapping: mapping.name.clone(),
                formula: mapping.formula(),
                output: mapping.output,
                panels,
            })
        })
        .collect()
}

fn scalar_panel(trained: &TrainedMapping, dataset: &StudyData, runs: &[Run]) -> Result<Panel> {
    let mapping = trained.surrogate.mapping();
    let sub_models = &mapping.sub_models;
    let range = [sub_models[0].strain_range[0], sub_models[sub_models.len() - 1].strain_range[1]];
    let mut panel = empty_panel(range, false);
    for run in runs {
        for k in 0..sub_models.len() {
            let states = fine_states(mapping, run, k);
            for (surrogate, lines) in
                [(&trained.surrogate, &mut panel.lines), (&trained.strain_only, &mut panel.strain_only)]
            {
                let answers = surrogate.answer(&states)?;
                lines.push(Curve {
                    run: run.name.clone(),
                    sub_model: k + 1,
                    strain: None,
                    x: states.iter().map(|state| state.strain).collect(),
                    y: answers.iter().map(|answer| answer.values[0]).collect(),
                    outside: answers.iter().map(|answer| answer.outside).collect(),
                });
            }
        }
        let states: Vec<&State> =
            run.states.iter().filter(|s| s.strain >= range[0] && s.strain <= range[1]).collect();
        panel.points.push(Curve {
            run: run.name.clone(),
            sub_model: 0,
            strain: None,
            x: states.iter().map(|state| state.strain).collect(),
            y: states.iter().map(|state| state.values(mapping.output)[0]).collect(),
            outside: vec![false; states.len()],
        });
    }
    if let Some(scatter) = scatter(dataset, mapping, mapping.output) {
        let edges = scatter.means.iter().zip(&scatter.deviations);
        let (low, high) = edges.map(|(mean, s)| (mean[0] - s[0], mean[0] + s[0])).unzip();
        panel.bands.push(Band { strain: None, x: scatter.strains, low, high });
    }
    Ok(panel)
}

/// States of a run at small, equal intervals of strain within the range of a sub-model and of the run.
fn fine_states(mapping: &Mapping, run: &Run, sub_model: usize) -> Vec<State> {
    let [low, high] = mapping.sub_models[sub_model].strain_range;
    let (Some(first), Some(last)) = (run.states.first(), run.states.last()) else { return Vec::new() };
    let (low, high) = (low.max(first.strain), high.min(last.strain));
    (0..=FINE)
        .map(|k| low + (high - low) * k as f64 / FINE as f64)
        .filter(|&strain| mapping.sub_model_at(strain).0 == sub_model && low < high)
        .filter_map(|strain| run.at(strain))
        .collect()
}

fn distribution_panel(
    trained: &TrainedMapping,
    dataset: &StudyData,
    runs: &[Run],
    k: usize,
) -> Result<Panel> {
    let mapping = trained.surrogate.mapping();
    let range = mapping.sub_models[k].strain_range;
    let mut panel = empty_panel(range, true);
    let forces = trained.surrogate.forces();
    let (Some(&first), Some(&last)) = (forces.first(), forces.last()) else { return Ok(panel) };
    let fine: Vec<f64> = (0..=FINE).map(|i| first + (last - first) * i as f64 / FINE as f64).collect();
    let scatter = scatter(dataset, mapping, mapping.output);
    for part in [1.0, 3.0, 5.0] {
        let wanted = range[0] + (range[1] - range[0]) * part / 6.0;
        for run in runs {
            let Some(state) = nearest(mapping, run, wanted, k) else { continue };
            for (surrogate, lines) in
                [(&trained.surrogate, &mut panel.lines), (&trained.strain_only, &mut panel.strain_only)]
            {
                for answer in surrogate.answer_at([state], &fine)? {
                    lines.push(Curve {
                        run: run.name.clone(),
                        sub_model: k + 1,
                        strain: Some(state.strain),
                        x: fine.clone(),
                        y: answer.values,
                        outside: vec![answer.outside; fine.len()],
                    });
                }
            }
            panel.points.push(Curve {
                run: run.name.clone(),
                sub_model: 0,
                strain: Some(state.strain),
                x: forces.to_vec(),
                y: state.densities.clone(),
                outside: vec![false; forces.len()],
            });
        }
        if let Some(scatter) = &scatter
            && let Some(at) = (0..scatter.strains.len()).min_by(|&a, &b| {
                (scatter.strains[a] - wanted).abs().total_cmp(&(scatter.strains[b] - wanted).abs())
            })
        {
            let edges = scatter.means[at].iter().zip(&scatter.deviations[at]);
            let (low, high) = edges.map(|(mean, s)| (mean - s, mean + s)).unzip();
            panel.bands.push(Band { strain: Some(scatter.strains[at]), x: forces.to_vec(), low, high });
        }
    }
    Ok(panel)
}

/// The state of a run closest to a strain, within the range of a sub-model.
fn nearest<'a>(mapping: &Mapping, run: &'a Run, strain: f64, sub_model: usize) -> Option<&'a State> {
    run.states
        .iter()
        .filter(|state| mapping.sub_model_at(state.strain) == (sub_model, true))
        .min_by(|a, b| (a.strain - strain).abs().total_cmp(&(b.strain - strain).abs()))
}

fn empty_panel(strain_range: [f64; 2], against_force: bool) -> Panel {
    Panel {
        strain_range,
        against_force,
        lines: Vec::new(),
        strain_only: Vec::new(),
        points: Vec::new(),
        bands: Vec::new(),
    }
}
