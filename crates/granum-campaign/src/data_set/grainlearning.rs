//! A data set in the layout of GrainLearning, whose recurrent networks learn from triaxial tests.
//!
//! Groups `PRESSURE/KIND`, where PRESSURE is the mean stress of the sample in Pa and KIND `drained` or `undrained`, have the arrays
//! `contact_params` (runs, parameters), `inputs` (runs, states, strains) and `outputs` (runs, states, quantities); the names of the
//! columns are attributes of the file. Source: `grainlearning/rnn/data_parsing/triaxial_YADE.py` of GrainLearning 2.0, which makes the
//! layout of results of YADE, and `grainlearning/rnn/preprocessor.py`, which reads it.

use std::collections::{BTreeMap, BTreeSet};

use granum_core::quantity::format_number;
use granum_io::formats::hdf5::{Array, Group, Node};
use granum_io::{Error, Result, Table};
use granum_run::derived_columns::single_parameters;

use super::read::{DataSet, DataSetRun};

/// Sections of the case whose numbers are parameters of the contacts.
const OF_CONTACTS: [&str; 4] = ["grains.material.", "contact.", "material.", "pair."];
/// The inputs: the strains along the axes, the first one axial, of drained and of undrained tests alike.
const INPUTS: [&str; 3] = ["axial_strain", "lateral_strain_2", "lateral_strain_3"];
/// The outputs that a run may have, with the unit in which GrainLearning has them. The void ratio must be the first one.
const OUTPUTS: [(&str, f64); 7] = [
    ("void_ratio", 1.0),
    ("mean_stress", 1e6),
    ("deviator_stress", 1e6),
    ("mean_normal_force", 1.0),
    ("contact_anisotropy", 1.0),
    ("normal_force_anisotropy", 1.0),
    ("tangential_force_anisotropy", 1.0),
];

/// The content of such a file, and what it has.
#[derive(Clone, Debug, PartialEq)]
pub struct GrainLearning {
    /// The content.
    pub root: Group,
    /// Number of runs.
    pub runs: usize,
    /// Number of states of each run.
    pub states: usize,
    /// Names of the parameters of contacts.
    pub parameters: Vec<String>,
    /// Names of the outputs.
    pub outputs: Vec<String>,
    /// Names of the runs that have fewer states.
    pub too_short: Vec<String>,
}

/// The data set in the layout of GrainLearning, with sequences of `states` states; by default as many as the shortest run has. Longer runs
/// are cut, shorter ones left out, as GrainLearning does it.
///
/// # Errors
/// If a run is neither a drained nor an undrained triaxial test, lacks a strain or a stress, or no run has so many states.
pub fn grainlearning(data_set: &DataSet, states: Option<usize>) -> Result<GrainLearning> {
    let runs = data_set.each_run()?;
    let wrong = |why: String| Error::content(data_set.folder(), why);
    let tables = runs.iter().map(sequence).collect::<Result<Vec<Table>>>()?;
    let shortest = tables.iter().map(Table::rows).min().unwrap_or(0);
    let states = states.unwrap_or(shortest);
    let outputs: Vec<(&str, f64)> =
        OUTPUTS.into_iter().filter(|(name, _)| tables.iter().all(|table| table.has(name))).collect();
    if states == 0 {
        return Err(wrong("sequences of no state cannot be learned from".into()));
    }
    for name in INPUTS.into_iter().chain(["void_ratio", "mean_stress", "deviator_stress"]) {
        if let Some((run, _)) = runs.iter().zip(&tables).find(|(_, table)| !table.has(name)) {
            return Err(wrong(format!(
                "the run {} has no column {name}, which GrainLearning needs",
                run.name
            )));
        }
    }
    let parameters = parameters(&runs);
    let (mut groups, mut too_short) = (BTreeMap::<(String, &str), Rows>::new(), Vec::new());
    let mut count = 0;
    for (run, table) in runs.iter().zip(&tables) {
        if table.rows() < states {
            too_short.push(run.name.clone());
            continue;
        }
        count += 1;
        let place = groups.entry((pressure(run), kind(run)?)).or_default();
        place.add(run, table, states, &parameters, &outputs)?;
    }
    if count == 0 {
        return Err(wrong(format!("no run has {states} states; the shortest has {shortest}")));
    }
    let mut root = Group { attributes: attributes(&parameters, &outputs), ..Group::default() };
    let pressures: BTreeSet<String> = groups.keys().map(|(pressure, _)| pressure.clone()).collect();
    for pressure in pressures {
        let inner = groups.iter().filter(|((own, _), _)| *own == pressure);
        let children = inner.map(|((_, kind), rows)| {
            (kind.to_string(), Node::Group(rows.group(states, parameters.len(), outputs.len())))
        });
        let group = Group { children: children.collect(), ..Group::default() };
        root.children.push((pressure, Node::Group(group)));
    }
    let outputs = outputs.iter().map(|(name, _)| (*name).to_string()).collect();
    Ok(GrainLearning { root, runs: count, states, parameters, outputs, too_short })
}

/// The arrays of a group.
#[derive(Default)]
struct Rows {
    parameters: Vec<f64>,
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    runs: usize,
}

impl Rows {
    fn add(
        &mut self,
        run: &DataSetRun,
        table: &Table,
        states: usize,
        parameters: &[String],
        outputs: &[(&str, f64)],
    ) -> Result<()> {
        let own = single_parameters(&run.case);
        for name in parameters {
            let number = own.iter().find(|known| known.key == *name).and_then(|known| known.number());
            self.parameters.push(number.unwrap_or(f64::NAN));
        }
        for row in 0..states {
            for name in INPUTS {
                self.inputs.push(table.column(name)?[row]);
            }
            for (name, unit) in outputs {
                self.outputs.push(table.column(name)?[row] / unit);
            }
        }
        self.runs += 1;
        Ok(())
    }

    fn group(&self, states: usize, parameters: usize, outputs: usize) -> Group {
        let array = |shape: Vec<usize>, values: &[f64]| Node::Array(Array { shape, values: values.to_vec() });
        Group {
            attributes: Vec::new(),
            children: vec![
                ("contact_params".into(), array(vec![self.runs, parameters], &self.parameters)),
                ("inputs".into(), array(vec![self.runs, states, INPUTS.len()], &self.inputs)),
                ("outputs".into(), array(vec![self.runs, states, outputs], &self.outputs)),
            ],
        }
    }
}

fn attributes(parameters: &[String], outputs: &[(&str, f64)]) -> Vec<(String, Vec<String>)> {
    let inputs: Vec<String> = INPUTS.map(String::from).to_vec();
    let outputs = outputs.iter().map(|(name, _)| (*name).to_string()).collect();
    vec![
        ("inputs_drained".into(), inputs.clone()),
        ("inputs_undrained".into(), inputs),
        ("outputs".into(), outputs),
        ("contact_params".into(), parameters.to_vec()),
        ("unused_keys_sequence".into(), Vec::new()),
        ("unused_keys_constant".into(), Vec::new()),
    ]
}

/// The series of a run, with the void ratio if it follows from the solid fraction.
fn sequence(run: &DataSetRun) -> Result<Table> {
    let mut table = run.measured.series.clone();
    let solid = table.values("solid_fraction").filter(|_| !table.has("void_ratio"));
    if let Some(void) = solid.map(|solid| solid.iter().map(|solid| (1.0 - solid) / solid).collect()) {
        table.set(granum_io::Column::new("void_ratio", "", void))?;
    }
    Ok(table)
}

/// The numbers of contacts and materials that differ between the runs; the coefficient of friction, if none does.
fn parameters(runs: &[DataSetRun]) -> Vec<String> {
    let mut values: BTreeMap<String, BTreeSet<u64>> = BTreeMap::new();
    for run in runs {
        let own = single_parameters(&run.case).into_iter();
        let own = own.filter(|known| OF_CONTACTS.iter().any(|section| known.key.starts_with(section)));
        for (key, number) in own.filter_map(|known| Some((known.key.clone(), known.number()?))) {
            values.entry(key).or_default().insert(number.to_bits());
        }
    }
    let differing: Vec<String> =
        values.into_iter().filter(|(_, values)| values.len() > 1).map(|(key, _)| key).collect();
    if differing.is_empty() { vec!["grains.material.friction".into()] } else { differing }
}

/// The mean stress with which the test begins, Pa, which GrainLearning reads as a number.
fn pressure(run: &DataSetRun) -> String {
    format_number(run.case.test_definition().mean_stress(run.case.preparation.mean_stress))
}

/// `drained` or `undrained`, by the name of the last path of the test.
fn kind(run: &DataSetRun) -> Result<&'static str> {
    let mut paths = single_parameters(&run.case)
        .into_iter()
        .filter(|known| known.key.starts_with("stage.") && known.key.ends_with(".path"));
    let last = paths.next_back().map(|known| known.value);
    match &last {
        Some(granum_io::case::ParameterValue::Word(word)) if word == "drained-triaxial" => Ok("drained"),
        Some(granum_io::case::ParameterValue::Word(word)) if word == "undrained-triaxial" => Ok("undrained"),
        _ => Err(Error::Rule(format!(
            "the run {} is neither a drained-triaxial nor an undrained-triaxial test, and GrainLearning's layout has these only",
            run.name
        ))),
    }
}
