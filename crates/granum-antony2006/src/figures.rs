//! The data of Figures 3-8: networks as lines, unseen DEM runs as points, the seed scatter as a band.
//!
//! Figures 3, 5 and 8 show a scalar as a function of strain, with one line for each sub-model; Figures 4, 6 and 7 show
//! P(f) as a function of f at three strains, with one panel for each sub-model. The soft sensors that a network receives
//! are those of the unseen run that is shown as points, interpolated linearly between recorded states.

use serde::{Deserialize, Serialize};

use granum_learn::curve::RunCurves;
use granum_learn::dataset::RunStates;
use granum_learn::networks::SubModelNetworks;
use granum_learn::study::Study;
use granum_learn::{Result, Surrogate};

use crate::data::PaperData;
use crate::evaluation::{networks, scatter, strain_only};
use crate::mapping::{Mapping, PaperQuantity};

/// A figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperFigure {
    /// Name of the mapping.
    pub mapping: String,
    /// Formula of the mapping, as in the paper.
    pub formula: String,
    /// Quantity on the vertical axis.
    pub output: PaperQuantity,
    /// Panels of the figure.
    pub panels: Vec<PaperPanel>,
}

/// A panel of a figure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PaperPanel {
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
pub fn figures(study: &Study, data: &PaperData) -> Result<Vec<PaperFigure>> {
    let runs = if data.parts.unseen.rows() == 0 { &data.parts.training_runs } else { &data.parts.unseen };
    let figure = |fit: &granum_learn::study::StudyFit| {
        let mapping = Mapping::from_fit(&fit.spec)?;
        let shown = Shown {
            with_sensors: networks(study, &fit.name)?,
            strain_only: strain_only(study, &fit.name)?,
            mapping: &mapping,
            data,
            runs: runs.runs(),
        };
        let panels = match mapping.output {
            PaperQuantity::ForceDistribution => {
                (0..mapping.sub_models.len()).map(|k| distribution_panel(&shown, k)).collect::<Result<_>>()?
            }
            _ => vec![scalar_panel(&shown)?],
        };
        Ok(PaperFigure {
            mapping: mapping.name.clone(),
            formula: mapping.formula(),
            output: mapping.output,
            panels,
        })
    };
    study.fits.iter().map(figure).collect()
}

/// The networks of a mapping and the runs that a figure shows.
struct Shown<'a> {
    with_sensors: &'a SubModelNetworks,
    strain_only: &'a SubModelNetworks,
    mapping: &'a Mapping,
    data: &'a PaperData,
    runs: &'a [RunStates],
}

impl Shown<'_> {
    /// The inputs of networks along a run.
    fn inputs(&self, networks: &SubModelNetworks, run: &RunStates) -> Result<RunCurves> {
        RunCurves::new(
            run,
            PaperQuantity::DeviatorStrain.column(),
            &Surrogate::columns(networks).input_names(),
        )
    }

    fn outputs(&self, run: &RunStates) -> Result<RunCurves> {
        RunCurves::new(
            run,
            PaperQuantity::DeviatorStrain.column(),
            &self.mapping.output.columns(&self.data.bins),
        )
    }
}

fn scalar_panel(shown: &Shown) -> Result<PaperPanel> {
    let sub_models = &shown.mapping.sub_models;
    let range = [sub_models[0].range[0], sub_models[sub_models.len() - 1].range[1]];
    let mut panel = empty_panel(range, false);
    for run in shown.runs {
        for k in 0..sub_models.len() {
            for (networks, lines) in
                [(shown.with_sensors, &mut panel.lines), (shown.strain_only, &mut panel.strain_only)]
            {
                let states = fine_states(shown.mapping, &shown.inputs(networks, run)?, k);
                let predictions = networks.predict_states(&states.concat())?;
                lines.push(Curve {
                    run: run.name().to_owned(),
                    sub_model: k + 1,
                    strain: None,
                    x: states.iter().map(|state| state[0]).collect(),
                    y: predictions.iter().map(|predicted| predicted.values[0]).collect(),
                    outside: predictions.iter().map(|predicted| predicted.outside).collect(),
                });
            }
        }
        let outputs = shown.outputs(run)?;
        let strains = outputs.coordinate.iter().zip(&outputs.columns[0]);
        let (x, y): (Vec<f64>, Vec<f64>) =
            strains.filter(|(strain, _)| **strain >= range[0] && **strain <= range[1]).unzip();
        let outside = vec![false; x.len()];
        panel.points.push(Curve { run: run.name().to_owned(), sub_model: 0, strain: None, x, y, outside });
    }
    if let Some(scatter) = scatter(shown.data, shown.mapping, shown.mapping.output)? {
        let edges = scatter.means.iter().zip(&scatter.deviations);
        let (low, high) = edges.map(|(mean, s)| (mean[0] - s[0], mean[0] + s[0])).unzip();
        panel.bands.push(Band { strain: None, x: scatter.coordinates, low, high });
    }
    Ok(panel)
}

/// The inputs at small, equal intervals of strain within the range of a sub-model and of the run.
fn fine_states(mapping: &Mapping, run: &RunCurves, sub_model: usize) -> Vec<Vec<f64>> {
    let [low, high] = mapping.sub_models[sub_model].range;
    let (Some(first), Some(last)) = (run.coordinate.first(), run.coordinate.last()) else {
        return Vec::new();
    };
    let (low, high) = (low.max(*first), high.min(*last));
    (0..=FINE)
        .map(|k| low + (high - low) * k as f64 / FINE as f64)
        .filter(|&strain| mapping.sub_model_at(strain).0 == sub_model && low < high)
        .map(|strain| run.at(strain))
        .collect()
}

fn distribution_panel(shown: &Shown, k: usize) -> Result<PaperPanel> {
    let range = shown.mapping.sub_models[k].range;
    let mut panel = empty_panel(range, true);
    let forces = &shown.data.bins.centres;
    let (Some(&first), Some(&last)) = (forces.first(), forces.last()) else { return Ok(panel) };
    let fine: Vec<f64> = (0..=FINE).map(|i| first + (last - first) * i as f64 / FINE as f64).collect();
    let scatter = scatter(shown.data, shown.mapping, shown.mapping.output)?;
    for part in [1.0, 3.0, 5.0] {
        let wanted = range[0] + (range[1] - range[0]) * part / 6.0;
        for run in shown.runs {
            let outputs = shown.outputs(run)?;
            let Some(state) = nearest(shown.mapping, &outputs.coordinate, wanted, k) else { continue };
            let strain = outputs.coordinate[state];
            for (networks, lines) in
                [(shown.with_sensors, &mut panel.lines), (shown.strain_only, &mut panel.strain_only)]
            {
                let inputs = shown.inputs(networks, run)?.row(state);
                for predicted in networks.predict_states_at(&inputs, &fine)? {
                    lines.push(Curve {
                        run: run.name().to_owned(),
                        sub_model: k + 1,
                        strain: Some(strain),
                        x: fine.clone(),
                        y: predicted.values,
                        outside: vec![predicted.outside; fine.len()],
                    });
                }
            }
            panel.points.push(Curve {
                run: run.name().to_owned(),
                sub_model: 0,
                strain: Some(strain),
                x: forces.clone(),
                y: outputs.row(state),
                outside: vec![false; forces.len()],
            });
        }
        if let Some(scatter) = &scatter
            && let Some(at) = (0..scatter.coordinates.len()).min_by(|&a, &b| {
                (scatter.coordinates[a] - wanted).abs().total_cmp(&(scatter.coordinates[b] - wanted).abs())
            })
        {
            let edges = scatter.means[at].iter().zip(&scatter.deviations[at]);
            let (low, high) = edges.map(|(mean, s)| (mean - s, mean + s)).unzip();
            panel.bands.push(Band { strain: Some(scatter.coordinates[at]), x: forces.clone(), low, high });
        }
    }
    Ok(panel)
}

/// The number of the state closest to a strain, within the range of a sub-model.
fn nearest(mapping: &Mapping, strains: &[f64], wanted: f64, sub_model: usize) -> Option<usize> {
    (0..strains.len())
        .filter(|&k| mapping.sub_model_at(strains[k]) == (sub_model, true))
        .min_by(|&a, &b| (strains[a] - wanted).abs().total_cmp(&(strains[b] - wanted).abs()))
}

fn empty_panel(strain_range: [f64; 2], against_force: bool) -> PaperPanel {
    PaperPanel {
        strain_range,
        against_force,
        lines: Vec::new(),
        strain_only: Vec::new(),
        points: Vec::new(),
        bands: Vec::new(),
    }
}
