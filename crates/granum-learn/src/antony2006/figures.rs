//! The data of Figures 3-8: networks as lines, unseen DEM as points, the seed scatter as a band.
//!
//! Figures 3, 5 and 8 draw a number against strain, with a line for each sub-model; Figures 4, 6 and 7 draw P(f)
//! against f, a panel a sub-model, at three strains each. The soft sensors that a network reads are those of the
//! unseen run whose points it is drawn with, linear between recorded states.

use serde::{Deserialize, Serialize};

use crate::antony2006::mapping::{Mapping, Quantity};
use crate::antony2006::study::{Study, TrainedMapping, scatter};
use crate::antony2006::study_data::{Run, State, StudyData};
use crate::error::Result;

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figure {
    /// Name of the mapping.
    pub mapping: String,
    /// As the paper writes it.
    pub formula: String,
    /// What is drawn upward.
    pub output: Quantity,
    /// Its panels.
    pub panels: Vec<Panel>,
}

/// A panel of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Panel {
    /// Range of deviator strain that it shows.
    pub strain_range: [f64; 2],
    /// True if f is drawn to the right, false if the deviator strain.
    pub against_force: bool,
    /// Curves of the networks.
    pub lines: Vec<Curve>,
    /// Curves of the strain-only networks.
    pub strain_only: Vec<Curve>,
    /// DEM, runs that no network saw.
    pub points: Vec<Curve>,
    /// Mean of all DEM runs less and plus one standard deviation between them.
    pub bands: Vec<Band>,
}

/// Values to draw as a line or as points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Curve {
    /// Name of the DEM run that is shown, or whose soft sensors were read.
    pub run: String,
    /// Number of the sub-model, from 1; 0 for DEM.
    pub sub_model: usize,
    /// Deviator strain of the curve, where it is drawn against f.
    pub strain: Option<f64>,
    /// To the right.
    pub x: Vec<f64>,
    /// Upward.
    pub y: Vec<f64>,
    /// Where a network was asked outside the range it was trained in.
    pub outside: Vec<bool>,
}

/// A band to shade.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Band {
    /// Deviator strain of the band, where it is drawn against f.
    pub strain: Option<f64>,
    /// To the right.
    pub x: Vec<f64>,
    /// Its lower edge.
    pub low: Vec<f64>,
    /// Its upper edge.
    pub high: Vec<f64>,
}

/// Points of a line.
const FINE: usize = 200;

/// The figures of a study, one a mapping. Without unseen runs the training runs take their place.
///
/// # Errors
/// If a state holds a value that is not finite.
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

/// States of a run at fine, equal steps of strain within a sub-model and within the run.
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

/// The state of a run nearest to a strain, within a sub-model.
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
