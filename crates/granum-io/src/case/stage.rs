//! The tables `[[stage]]` and `[[preparation.stage]]` of a case: named paths with their parameters, or an explicit control.

use std::path::Path;

use granum_dem::config::Recording;
use granum_dem::loading::preset::{
    self, Given, PathFault, PathParameter, PathParameterDefault, PathParameterKind, PathValue, Preset,
};
use granum_dem::loading::{RecordedStates, Stage, Start};

use super::case_stage::{CaseStage, MOST_NESTED, MOST_STAGES, PREPARATION_STAGE, STAGE, driven};
use super::case_test::CaseTest;
use super::definition::Case;
use super::doubt::in_per_cent_instead;
use super::history;
use super::suggestion::meant;
use super::unit::dimension;
use crate::error::{Error, Result};
use granum_core::quantity::{format_number, parse_quantity};

/// The number of a stage, from 1, that starts from a saved state although no state was saved before it, with the fault in words.
pub(super) fn fault_of_order(stages: &[CaseStage]) -> Option<(usize, String)> {
    let mut kept = false;
    for (k, stage) in stages.iter().enumerate() {
        for stage in stage.stages() {
            kept |= stage.start == Start::Kept;
            if stage.start == Start::Back && !kept {
                let message = "goes back to a state, but no stage before it has start = \"kept\"";
                return Some((k + 1, message.into()));
            }
        }
    }
    None
}

/// What is wrong with parameters of a path together: the key, and a sentence that begins with it.
pub(super) fn path_fault(preset: &Preset, given: &Given) -> Option<PathFault> {
    let needed = |p: &&PathParameter| p.default == PathParameterDefault::Needed && !given.contains_key(p.key);
    if let Some(parameter) = preset.parameters().find(needed) {
        return Some((parameter.key, format!("{} must be given", parameter.key)));
    }
    let said = |key: &str| given.contains_key(key);
    if said("strain_rate") && said("inertial_number") {
        return Some((
            "strain_rate",
            "strain_rate and inertial_number both set the speed; keep one of them".into(),
        ));
    }
    if said("density_scaling") && !said("strain_rate") {
        let message =
            "density_scaling has no effect without strain_rate; add it, or give inertial_number alone";
        return Some(("density_scaling", message.into()));
    }
    preset.fault(given)
}

/// Reads a value of a parameter of a path from text, as a flag has it.
///
/// # Errors
/// A sentence that continues "key = value".
pub(super) fn parse_value(parameter: &PathParameter, text: &str) -> std::result::Result<PathValue, String> {
    match parameter.kind {
        PathParameterKind::Number => parse_number(parameter, text).map(PathValue::Number),
        PathParameterKind::Word(words) => match words.iter().find(|[word, _]| *word == text) {
            Some([word, _]) => Ok(PathValue::Word((*word).into())),
            None => Err(format!("is not known; {}", meant(text, words.iter().map(|[word, _]| *word)))),
        },
        PathParameterKind::List => {
            let values = text.split(',').map(|part| parse_number(parameter, part.trim()));
            let values = values.collect::<std::result::Result<Vec<f64>, String>>()?;
            if values.windows(2).any(|pair| pair[0] >= pair[1]) {
                return Err("does not increase from value to value".into());
            }
            Ok(PathValue::List(values))
        }
        PathParameterKind::History => history::read(Path::new(text))
            .map(PathValue::History)
            .map_err(|error| format!("cannot be used: {error}")),
    }
}

fn parse_number(parameter: &PathParameter, text: &str) -> std::result::Result<f64, String> {
    let value = parse_quantity(text, dimension(parameter.unit))? + 0.0;
    check_number(parameter, value).map(|()| value).map_err(|why| {
        match in_per_cent_instead(parameter, value, text) {
            Some(hint) => format!("{why}; {hint}"),
            None => why,
        }
    })
}

fn check_number(parameter: &PathParameter, value: f64) -> std::result::Result<(), String> {
    let [low, high] = parameter.bounds;
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(format!("is out of bounds; it must be {}", bounds(parameter)))
}

/// Checks a value that a program gave.
fn check_value(parameter: &PathParameter, value: &PathValue) -> std::result::Result<(), String> {
    match (parameter.kind, value) {
        (PathParameterKind::Number, PathValue::Number(number)) => check_number(parameter, *number),
        (PathParameterKind::Word(_), PathValue::Word(word)) => parse_value(parameter, word).map(drop),
        (PathParameterKind::List, PathValue::List(values)) => {
            values.iter().try_for_each(|x| check_number(parameter, *x))
        }
        (PathParameterKind::History, PathValue::History(history)) => history.fault().map_or(Ok(()), Err),
        _ => Err("has the wrong type".into()),
    }
}

/// "from 0.001 Pa to 1e11 Pa".
pub(super) fn bounds(parameter: &PathParameter) -> String {
    let unit = if parameter.unit == "1" { String::new() } else { format!(" {}", parameter.unit) };
    let [low, high] = parameter.bounds.map(format_number);
    format!("from {low}{unit} to {high}{unit}")
}

impl Case {
    /// Stages with the largest overlap of the case.
    pub(super) fn within_overlaps(&self, stages: impl Iterator<Item = Stage>) -> Vec<Stage> {
        let limit = self.numerics.overlap_limit();
        stages.map(|stage| stage.with(|stage| stage.largest_overlap = limit)).collect()
    }

    /// The same case with a named path instead of its test. The parameters are given as text, like flags of the program.
    ///
    /// # Errors
    /// [`Error::Value`] if there is no such path or parameter, or a text is not a value for it.
    pub fn with_path(&self, name: &str, parameters: &[(&str, &str)]) -> Result<Case> {
        let wrong = |name: &str, value: &str, message: String| Error::Value {
            name: name.to_string(),
            value: value.to_string(),
            message,
        };
        let Some(preset) = self.vocabulary.paths().named(name) else {
            let help = meant(name, self.vocabulary.paths().names());
            return Err(wrong("path", name, format!("is not a path; {help}")));
        };
        let mut case = self.clone();
        let own = self.recording.clone();
        case.recording = Recording::default().with(|recording| {
            recording.observations_per_state = own.observations_per_state;
            (recording.sensors, recording.parameters) = (own.sensors, own.parameters);
        });
        let stage =
            CaseStage::Path { path: preset, parameters: Given::new(), resets: true, until: Vec::new() };
        case.test = CaseTest::Stages(vec![stage]);
        for (key, text) in parameters {
            if preset.parameter(key).is_none() {
                let help = meant(key, preset.parameters().map(|parameter| parameter.key));
                return Err(wrong(key, text, format!("is not a parameter of the path {name}; {help}")));
            }
            case.set(&format!("stage.1.{key}"), text)?;
        }
        Ok(case)
    }

    /// Sets a parameter of a stage that is a named path: `stage.1.axial_strain`, the first stage being 1; `stage.2.1.axial_strain`
    /// the first of those that the second repeats, and `stage.2.repeat` how often it does.
    pub(super) fn set_stage(&mut self, path: &str, text: &str) -> Result<()> {
        let wrong =
            |message: String| Error::Value { name: path.to_string(), value: text.to_string(), message };
        let (list, heading) = match path.starts_with(PREPARATION_STAGE) {
            true => (self.preparation_stages.as_mut_slice(), PREPARATION_STAGE),
            false => (self.test.tables_mut(), STAGE),
        };
        let rest = path.strip_prefix(heading).and_then(|rest| rest.strip_prefix('.')).unwrap_or(path);
        let none = no_such_stage(heading, list.len());
        let (numbers, key) = place(rest).ok_or_else(|| wrong(none.clone()))?;
        let stage = stage_at(list, &numbers).ok_or_else(|| wrong(none))?;
        match stage {
            CaseStage::Path { path, parameters, .. } => {
                let Some(parameter) = path.parameter(key) else {
                    let help = meant(key, path.parameters().map(|parameter| parameter.key));
                    return Err(wrong(format!("is not a parameter of the path {}; {help}", path.name)));
                };
                if heading == PREPARATION_STAGE && RECORDING_KEYS.contains(&key) {
                    return Err(wrong(NOTHING_RECORDED.into()));
                }
                parameters.insert(key.to_string(), parse_value(parameter, text).map_err(wrong)?);
                Ok(())
            }
            CaseStage::Repeat { times, .. } if key == "repeat" => {
                let count = text.parse().ok().filter(|count| (1..=MOST_STAGES).contains(count));
                *times =
                    count.ok_or_else(|| wrong(format!("must be a whole number from 1 to {MOST_STAGES}")))?;
                Ok(())
            }
            CaseStage::Repeat { .. } => Err(wrong(
                "is not a key of a stage that repeats others; it has repeat, and its stages are numbered, as in \
                 stage.2.1.KEY".into(),
            )),
            CaseStage::Control(_) => {
                Err(wrong("belongs to a stage with an explicit control; change it in the case file".into()))
            }
        }
    }

    /// The parameter of a path that a key such as `stage.1.axial_strain` sets.
    pub(super) fn parameter_of(&self, path: &str) -> Option<&'static PathParameter> {
        let (mut list, rest) = match path.strip_prefix("preparation.stage.") {
            Some(rest) => (self.preparation_stages.as_slice(), rest),
            None => (self.test.tables(), path.strip_prefix("stage.")?),
        };
        let (numbers, key) = place(rest)?;
        let mut found = None;
        for number in numbers {
            let stage = list.get(number.checked_sub(1)?)?;
            list = if let CaseStage::Repeat { stages, .. } = stage { stages } else { &[] };
            found = Some(stage);
        }
        match found? {
            CaseStage::Path { path, .. } => path.parameter(key),
            CaseStage::Control(_) | CaseStage::Repeat { .. } => None,
        }
    }

    /// The stages of the preparation of the sample, between its compaction and its relaxation.
    pub fn sample_stages(&self) -> Vec<Stage> {
        self.within_overlaps(self.preparation_stages.iter().flat_map(CaseStage::stages))
    }

    /// The tables `[[stage]]` as TOML in SI units; empty without stages.
    pub fn stages_toml(&self) -> String {
        self.test.tables().iter().map(|stage| format!("\n{}", stage.toml(STAGE))).collect()
    }

    /// The tables `[[preparation.stage]]` as TOML in SI units; empty without stages.
    pub fn preparation_stages_toml(&self) -> String {
        self.preparation_stages.iter().map(|stage| format!("\n{}", stage.toml(PREPARATION_STAGE))).collect()
    }

    /// Checks the stages: bounds of parameters, and that each control determines the strain rates.
    pub(super) fn check_stages(&self) -> Result<()> {
        self.test.check()?;
        let preparation = (self.preparation_stages.as_slice(), PREPARATION_STAGE);
        for (stages, heading) in [(self.test.tables(), STAGE), preparation] {
            if let Some((k, message)) = (1..).zip(stages).find_map(|(k, stage)| Some((k, too_nested(stage)?)))
            {
                return Err(Error::Rule(format!("{heading}.{k} {message}")));
            }
            check_list(stages, heading)?;
            if let Some(message) = too_many(stages) {
                return Err(Error::Rule(message));
            }
        }
        check_unrecorded(&self.preparation_stages, PREPARATION_STAGE)?;
        match fault_of_order(self.test.tables()) {
            Some((number, message)) => Err(Error::Rule(format!("stage.{number} {message}"))),
            None => Ok(()),
        }
    }
}

/// Parameters of paths that choose the recorded states.
pub(super) const RECORDING_KEYS: [&str; 2] = [preset::STATES.key, preset::INTERVAL.key];
/// What is wrong with them in a preparation, as the continuation of "key = value".
pub(super) const NOTHING_RECORDED: &str = "has no effect in a preparation, which records no states";
/// What is wrong with a stage of a preparation that saves its start, or starts from a saved state.
pub(super) const NOTHING_SAVED: &str = "starts from a saved state or saves its start for later stages, but each stage of a \
                                        preparation starts where the one before it ended";

/// True if a stage saves its start, or starts from a saved state.
pub(super) fn goes_back(stage: &CaseStage) -> bool {
    match stage {
        CaseStage::Repeat { stages, .. } => stages.iter().any(goes_back),
        _ => stage.stages().iter().any(|stage| stage.start != Start::Here),
    }
}

/// Removes the recording that a file of the IncrementalDriver sets.
pub(super) fn without_recording(stage: CaseStage) -> CaseStage {
    match stage {
        CaseStage::Control(stage) => CaseStage::Control(Box::new(stage.recording(RecordedStates::default()))),
        CaseStage::Repeat { times, stages } => {
            CaseStage::Repeat { times, stages: stages.into_iter().map(without_recording).collect() }
        }
        path => path,
    }
}

/// Checks that the stages of a preparation record and save nothing.
fn check_unrecorded(stages: &[CaseStage], place: &str) -> Result<()> {
    for (k, stage) in stages.iter().enumerate() {
        let place = format!("{place}.{}", k + 1);
        let key = match stage {
            CaseStage::Repeat { stages, .. } => {
                check_unrecorded(stages, &place)?;
                continue;
            }
            CaseStage::Path { parameters, .. } => {
                RECORDING_KEYS.into_iter().find(|key| parameters.contains_key(*key))
            }
            CaseStage::Control(stage) => (stage.record != RecordedStates::default()).then_some("record"),
        };
        if let Some(key) = key {
            return Err(Error::Rule(format!("{place}.{key} {NOTHING_RECORDED}")));
        }
        if goes_back(stage) {
            return Err(Error::Rule(format!("{place} {NOTHING_SAVED}")));
        }
    }
    Ok(())
}

/// The error message if there are too many stages.
pub(super) fn too_many(stages: &[CaseStage]) -> Option<String> {
    let count = stages.iter().fold(0u64, |sum, stage| sum.saturating_add(stage.count()));
    (count > MOST_STAGES).then(|| {
        format!("the case has {count} stages with their repetitions; at most {MOST_STAGES} are possible")
    })
}

/// What is wrong with a stage whose repetitions lie too deep within one another, as the continuation of its name.
pub(super) fn too_nested(stage: &CaseStage) -> Option<String> {
    let nested = stage.nested();
    (nested > MOST_NESTED)
        .then(|| format!("has {nested} repetitions within one another; at most {MOST_NESTED} are possible"))
}

/// The numbers and the key of `1.2.axial_strain`.
pub(super) fn place(text: &str) -> Option<(Vec<usize>, &str)> {
    let (numbers, key) = text.rsplit_once('.')?;
    let numbers = numbers.split('.').map(|number| number.parse().ok()).collect::<Option<_>>()?;
    Some((numbers, key))
}

/// The stage of those numbers, from 1: of a repetition the ones that it repeats.
fn stage_at<'s>(stages: &'s mut [CaseStage], numbers: &[usize]) -> Option<&'s mut CaseStage> {
    let (first, rest) = numbers.split_first()?;
    let stage = stages.get_mut(first.checked_sub(1)?)?;
    match stage {
        _ if rest.is_empty() => Some(stage),
        CaseStage::Repeat { stages, .. } => stage_at(stages, rest),
        _ => None,
    }
}

/// As [`stage_at`], for looking only.
pub(super) fn stage_in<'s>(stages: &'s [CaseStage], numbers: &[usize]) -> Option<&'s CaseStage> {
    let (first, rest) = numbers.split_first()?;
    let stage = stages.get(first.checked_sub(1)?)?;
    match stage {
        _ if rest.is_empty() => Some(stage),
        CaseStage::Repeat { stages, .. } => stage_in(stages, rest),
        _ => None,
    }
}

fn no_such_stage(heading: &str, count: usize) -> String {
    let stages = match count {
        0 => format!("this case has no [[{heading}]]"),
        _ => format!("this case has the stages 1 to {count}"),
    };
    format!("is not a key of a stage, e.g. {heading}.1.axial_strain; {stages}")
}

fn check_list(stages: &[CaseStage], place: &str) -> Result<()> {
    for (k, stage) in stages.iter().enumerate() {
        let place = format!("{place}.{}", k + 1);
        match stage {
            CaseStage::Path { path, parameters, until, .. } => {
                check_path(path, parameters, &place)?;
                if !until.is_empty() && driven(&path.expand(parameters)).is_none() {
                    return Err(Error::Rule(format!(
                        "{place}.until: the path {} has several stages that are driven; write them out, each with its own until",
                        path.name
                    )));
                }
            }
            CaseStage::Control(_) => {}
            CaseStage::Repeat { times, stages } if *times == 0 || stages.is_empty() => {
                return Err(Error::Rule(format!("{place} has no stages to repeat")));
            }
            CaseStage::Repeat { stages, .. } => {
                check_list(stages, &place)?;
                continue;
            }
        }
        for stage in stage.stages() {
            stage.control.check().map_err(|error| Error::Rule(format!("{place}: {error}")))?;
        }
    }
    Ok(())
}

fn check_path(preset: &Preset, parameters: &Given, place: &str) -> Result<()> {
    for (key, value) in parameters {
        let found = preset.parameter(key).map(|parameter| check_value(parameter, value));
        if let Some(Err(message)) = found {
            let value = match value {
                PathValue::Number(number) => format_number(*number),
                PathValue::Word(word) => word.clone(),
                PathValue::List(_) | PathValue::History(_) => "...".into(),
            };
            return Err(Error::Value { name: format!("{place}.{key}"), value, message });
        }
    }
    match path_fault(preset, parameters) {
        Some((_, message)) => Err(Error::Rule(format!("{place}.{message}"))),
        None => Ok(()),
    }
}
