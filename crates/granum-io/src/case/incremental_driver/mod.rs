//! Reads the loading path `test.inp` of Niemunis' IncrementalDriver into stages.
//!
//! In this file the components are in the order 11, 22, 33, 12, 13, 23, compression is negative, strains are logarithmic and shear
//! strains are angles; values are totals over a step. Each step becomes a stage with ramps. The time of a step and its number of
//! increments are not used: the rate follows from the inertial number of the stage in the case. Commands that cannot be simulated are
//! refused by name.

use std::path::Path;

use granum_dem::loading::preset::{Given, PROBES, PathValue};
use granum_dem::loading::{
    Constraint, Control, Drive, Measure, Ramp, RecordedStates, Speed, Stage, Target, Until,
};

use super::case_stage::{CaseStage, MOST_NESTED, MOST_STAGES};
use crate::error::{Error, InputError, Result};
use crate::named_file::named_file;
use crate::shell::ShowPath;

/// Largest file that is read.
const LARGEST: u64 = 1 << 20;
/// Places of the components 11, 22, 33, 12, 13, 23 in granum's lists of six.
const PLACES: [usize; 6] = [0, 1, 2, 5, 4, 3];
/// Unbalanced force at which a sample is at rest, for steps in which everything is held.
const AT_REST: f64 = 1e-3;

/// What the file does not say.
pub(super) struct Options {
    /// Its unit of stress, Pa.
    pub(super) stress_unit: f64,
    /// How fast the stages go.
    pub(super) inertial_number: f64,
    /// Arc length of strain at which states are recorded.
    pub(super) interval: f64,
    /// True if it may name files outside its own folder.
    pub(super) outside: bool,
}

/// Keywords that are known and cannot be followed, with the reason.
const REFUSED: [(&str, &str); 3] = [
    ("*DeformationGradient", "a given final deformation gradient"),
    ("*RandomWalk", "random steps, which differ from run to run"),
    ("*UndrainedCreep", "creep, which these grains do not show"),
];

/// Reads a file.
///
/// # Errors
/// If it cannot be read; [`Error::Input`] with line and column for what is wrong in it or cannot be followed.
pub(super) fn read(path: &Path, options: &Options) -> Result<Vec<CaseStage>> {
    let text = crate::text::read_small(path, LARGEST)?;
    parse(&text, &path.shown(), path.parent().unwrap_or(Path::new("")), options)
}

fn parse(text: &str, file: &str, folder: &Path, options: &Options) -> Result<Vec<CaseStage>> {
    // The first line names a file for results, which granum has its own of.
    let lines: Vec<(usize, &str)> = text.lines().enumerate().skip(1).map(|(k, line)| (k + 1, line)).collect();
    let mut steps = Steps { lines, at: 0, nested: 0, file, folder, options };
    let mut stages = Vec::new();
    while let Some((number, line)) = steps.next() {
        if is(line, "*End") {
            break;
        }
        stages.extend(steps.step(number, line)?);
    }
    if stages.is_empty() {
        return Err(Error::content(Path::new(file), "has no steps, e.g. *TriaxialE1"));
    }
    Ok(stages)
}

/// The lines of a file, one after another.
struct Steps<'a> {
    lines: Vec<(usize, &'a str)>,
    at: usize,
    /// How many repetitions the present step is within.
    nested: usize,
    file: &'a str,
    folder: &'a Path,
    options: &'a Options,
}

/// The part of a line before a comment.
fn plain(line: &str) -> &str {
    let end = ["//", "!", "#"].iter().filter_map(|mark| line.find(mark)).min().unwrap_or(line.len());
    line[..end].trim()
}

fn is(line: &str, keyword: &str) -> bool {
    line.split_whitespace().next().is_some_and(|word| word.eq_ignore_ascii_case(keyword))
}

/// A number, also with the exponent D of Fortran.
fn number(text: &str) -> Option<f64> {
    text.replace(['d', 'D'], "e").parse().ok().filter(|x: &f64| x.is_finite())
}

impl<'a> Steps<'a> {
    /// The next line that says something, with its number.
    fn next(&mut self) -> Option<(usize, &'a str)> {
        while let Some(&(number, line)) = self.lines.get(self.at) {
            self.at += 1;
            if !plain(line).is_empty() {
                return Some((number, plain(line)));
            }
        }
        None
    }

    fn error(&self, line: usize, message: impl Into<String>) -> Error {
        let text = self.lines.iter().find(|(number, _)| *number == line).map_or("", |(_, text)| *text);
        InputError::in_line(self.file, line, text, 0..text.len(), message.into()).into()
    }

    fn needed(&mut self, after: usize, what: &str) -> Result<(usize, &'a str)> {
        self.next().ok_or_else(|| self.error(after, format!("the file ends where {what} is needed")))
    }

    /// The first number of the next line.
    fn value(&mut self, after: usize) -> Result<f64> {
        let (at, line) = self.needed(after, "a value")?;
        let found = line.split_whitespace().next().and_then(number);
        found.ok_or_else(|| self.error(at, format!("{line:?} is not a number")))
    }

    /// Whether each component is a stress, and its numbers, from six lines.
    fn components(&mut self, after: usize, count: usize) -> Result<Vec<(bool, Vec<f64>)>> {
        (0..6)
            .map(|_| {
                let (at, line) = self.needed(after, "a component")?;
                let mut words = line.split_whitespace();
                let stress = match words.next() {
                    Some("0") => false,
                    Some("1") => true,
                    _ => return Err(self.error(at, "a component begins with 1 (stress) or 0 (strain)")),
                };
                let values: Vec<f64> = words.map_while(number).take(count).collect();
                if values.len() < count {
                    return Err(self.error(at, format!("a component needs {count} numbers after its first")));
                }
                Ok((stress, values))
            })
            .collect()
    }

    /// Only plain components can be followed.
    fn cartesian(&mut self, after: usize) -> Result<()> {
        let (at, line) = self.needed(after, "*Cartesian")?;
        if is(line, "*Cartesian") {
            return Ok(());
        }
        Err(self.error(at, format!("the variables {line} are not supported; write the step with *Cartesian")))
    }

    /// One step.
    fn step(&mut self, at: usize, line: &str) -> Result<Vec<CaseStage>> {
        let (head, condition) = line.split_once('?').map_or((line, None), |(head, c)| (head, Some(c)));
        let (keyword, rest) = head.trim().split_once(char::is_whitespace).unwrap_or((head.trim(), ""));
        if is(keyword, "*Repetition") {
            return self.repetition(at);
        }
        if let Some((name, why)) = REFUSED.iter().find(|(name, _)| is(keyword, name)) {
            return Err(self.error(at, format!("{name} is not supported: {why}")));
        }
        // Increments, iterations and time, which have no part, but for the number of probes and of parts of a circle.
        let (header, counts) = self.needed(at, "a line of increments, iterations and time")?;
        let count = counts.split_whitespace().next().and_then(number).filter(|n| *n >= 1.0);
        let Some(count) = count else {
            return Err(self.error(header, format!("{counts:?} does not begin with a number of increments")));
        };
        let mut stages = match keyword.to_ascii_lowercase().as_str() {
            "*linearload" => self.linear(at)?,
            "*circulatingload" => self.circulating(at, count as usize)?,
            "*obeyrestrictions" => self.restrictions(at)?,
            "*importfile" => self.import(at, rest)?,
            "*perturbationss" | "*perturbationse" => return self.probes(at, keyword, count),
            name => vec![self.named(at, name, keyword)?],
        };
        if let Some(condition) = condition {
            let end = self.condition(at, condition)?;
            stages.iter_mut().for_each(|stage| stage.until.push(end));
        }
        Ok(stages.into_iter().map(|stage| CaseStage::Control(Box::new(stage))).collect())
    }

    fn stage(&self, name: &str, control: Control) -> Stage {
        let until =
            if control.has_ramp() { Until::RampOver } else { Until::AtRest { unbalanced_force: AT_REST } };
        Stage::new(name, control, vec![until])
            .recording(RecordedStates::every(Measure::ArcLength, self.options.interval))
    }

    fn control(&self, components: [Drive; 6]) -> Control {
        let speed = Speed::InertialNumber { number: self.options.inertial_number, at: None };
        Control::new(speed, components)
    }

    /// A component that changes by this much in the sense of the file.
    fn by(&self, stress: bool, change: f64) -> Drive {
        let change = 0.0 - change;
        match (stress, change == 0.0) {
            (true, true) => Drive::Stress(Target::current()),
            (false, true) => Drive::Fixed,
            (true, false) => Drive::Stress(Target::ramp(Ramp::By(change * self.options.stress_unit))),
            (false, false) => Drive::Ramp(Ramp::By(change)),
        }
    }

    fn drives(&self, changes: impl Iterator<Item = (bool, f64)>) -> [Drive; 6] {
        let mut drives = [Drive::Fixed; 6];
        for (place, (stress, change)) in PLACES.into_iter().zip(changes) {
            drives[place] = self.by(stress, change);
        }
        drives
    }

    fn linear(&mut self, at: usize) -> Result<Vec<Stage>> {
        self.cartesian(at)?;
        let components = self.components(at, 1)?;
        let drives = self.drives(components.iter().map(|(stress, values)| (*stress, values[0])));
        Ok(vec![self.stage("linear load", self.control(drives))])
    }

    /// One period of sines with a drift, in as many straight parts as the file has increments.
    fn circulating(&mut self, at: usize, count: usize) -> Result<Vec<Stage>> {
        self.cartesian(at)?;
        if count > 1000 {
            return Err(
                self.error(at, format!("{count} increments give too many stages; at most 1000 are possible"))
            );
        }
        let components = self.components(at, 3)?;
        let value = |values: &[f64], k: usize| {
            let share = k as f64 / count as f64;
            let sine = libm::sin(2.0 * std::f64::consts::PI * share + values[1]);
            // Zeros of a sine are zeros.
            values[0] * libm::round(sine * 1e12) / 1e12 + values[2] * share
        };
        let part = |k: usize| {
            let change =
                |(stress, values): &(bool, Vec<f64>)| (*stress, value(values, k) - value(values, k - 1));
            let control = self.control(self.drives(components.iter().map(change)));
            control.has_ramp().then(|| self.stage(&format!("circulating load {k}"), control))
        };
        Ok((1..=count).filter_map(part).collect())
    }

    /// Steps with a name of their own.
    fn named(&mut self, at: usize, name: &str, keyword: &str) -> Result<Stage> {
        let (held, fixed, free) = (Drive::Stress(Target::current()), Drive::Fixed, Drive::Free);
        let unit = self.options.stress_unit;
        let control = match name {
            "*oedometrice1" | "*oedometrics1" | "*triaxiale1" | "*triaxials1" => {
                let lateral = if name.starts_with("*tri") { held } else { fixed };
                let axial = self.value(at)?;
                let axial = self.by(name.ends_with("s1"), axial);
                self.control([axial, lateral, lateral, fixed, fixed, fixed])
            }
            // These two count compression positive. At constant volume eps_q is the axial strain.
            "*triaxialueq" => {
                let strain = self.value(at)?;
                let [axial, lateral] = [strain, -0.5 * strain].map(|by| Drive::Ramp(Ramp::By(by)));
                self.control([axial, lateral, lateral, fixed, fixed, fixed])
            }
            "*triaxialuq" => {
                let target = Target::ramp(Ramp::By(self.value(at)? * unit));
                self.control([free, free, free, fixed, fixed, fixed])
                    .with(Constraint::strains([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], 0.0))
                    .with(Constraint::strains([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], 0.0))
                    .with(Constraint::stresses([1.0, -0.5, -0.5, 0.0, 0.0, 0.0], target))
            }
            "*purerelaxation" => self.control([fixed; 6]),
            "*purecreep" => self.control([held; 6]),
            _ => {
                return Err(self.error(at, format!("{keyword} is not a known keyword, e.g. *TriaxialE1")));
            }
        };
        Ok(self.stage(name.trim_start_matches('*'), control))
    }

    /// `M deps + N dsigma = v`, six equations.
    fn restrictions(&mut self, at: usize) -> Result<Vec<Stage>> {
        let mut control = self.control([Drive::Free; 6]);
        for _ in 0..6 {
            let (line, text) = self.needed(at, "an equation")?;
            let equation = equation(text).map_err(|why| self.error(line, why))?;
            let [strain, stress] = equation.weights;
            let single = |weights: &[f64; 6]| {
                let mut places = (0..6).filter(|&k| weights[k] != 0.0);
                places.next().filter(|_| places.next().is_none())
            };
            // The sign of compression turns both sides of an equation round.
            let value = equation.value;
            match (stress == [0.0; 6], strain == [0.0; 6]) {
                (true, true) => return Err(self.error(line, "all coefficients of the equation are zero")),
                (true, false) => match single(&strain) {
                    Some(k) => control.components[k] = self.by(false, value / strain[k]),
                    None if value == 0.0 => control = control.with(Constraint::strains(strain, 0.0)),
                    None => {
                        let why = "a combination of strains with nonzero total is not supported; give single strains";
                        return Err(self.error(line, why));
                    }
                },
                (false, _) => {
                    let unit = self.options.stress_unit;
                    let target = match value {
                        0.0 => Target::current(),
                        value => Target::ramp(Ramp::By((0.0 - value) * unit)),
                    };
                    let constraint = Constraint {
                        strain: strain.map(|w| w * unit),
                        ..Constraint::stresses(stress, target)
                    };
                    control = control.with(constraint);
                }
            }
        }
        let found = control.check();
        found.map_err(|error| self.error(at, error.to_string()))?;
        Ok(vec![self.stage("restrictions", control)])
    }

    /// Rows of a file, from each to the next.
    fn import(&mut self, at: usize, rest: &str) -> Result<Vec<Stage>> {
        let name = rest.split('|').next().unwrap_or("").trim();
        self.cartesian(at)?;
        let mut columns = Vec::new();
        for _ in 0..6 {
            let (line, text) = self.needed(at, "a component")?;
            let words: Vec<&str> = text.split(['*', ' ', '\t']).filter(|word| !word.is_empty()).collect();
            let column = words.get(1).and_then(|word| word.parse::<usize>().ok());
            let factor = words.get(2).map_or(Some(1.0), |word| number(word));
            let (Some(&kind), Some(column), Some(factor)) = (words.first(), column, factor) else {
                return Err(
                    self.error(line, "a component is: 1 (stress) or 0 (strain), its column, and * a factor")
                );
            };
            columns.push((kind == "1", column, factor));
        }
        let path = named_file(self.folder, name, self.options.outside)
            .map_err(|why| self.error(at, format!("*ImportFile {name} {why}")))?;
        let text = crate::text::read_small(&path, LARGEST)?;
        let mut rows: Vec<Vec<f64>> = Vec::new();
        for (k, line) in text.lines().enumerate().filter(|(_, line)| !plain(line).is_empty()) {
            let row: Option<Vec<f64>> = plain(line).split_whitespace().map(number).collect();
            let most = columns.iter().map(|(_, column, _)| *column).max().unwrap_or(0);
            match row.filter(|row| row.len() >= most) {
                Some(row) => rows.push(row),
                None => {
                    let message = format!("the row is not a list of at least {most} numbers");
                    let file = path.shown();
                    return Err(InputError::in_line(&file, k + 1, line, 0..line.len(), message).into());
                }
            }
        }
        let stages = rows.windows(2).enumerate().filter_map(|(k, pair)| {
            let change = |&(stress, column, factor): &(bool, usize, f64)| {
                let value = |row: &Vec<f64>| if column == 0 { 0.0 } else { row[column - 1] * factor };
                (stress, value(&pair[1]) - value(&pair[0]))
            };
            let control = self.control(self.drives(columns.iter().map(change)));
            control.has_ramp().then(|| self.stage(&format!("row {}", k + 2), control))
        });
        Ok(stages.collect())
    }

    /// Probes round a circle in the plane of the axial and the lateral components.
    fn probes(&mut self, at: usize, keyword: &str, count: f64) -> Result<Vec<CaseStage>> {
        let (line, variables) = self.needed(at, "variables")?;
        if !["*Rendulic", "*RoscoeIsomorph"].iter().any(|known| is(variables, known)) {
            let why = "probes are made in the triaxial plane; write *Rendulic or *RoscoeIsomorph";
            return Err(self.error(line, why));
        }
        let size = self.value(at)?.abs();
        let by_stress = keyword.to_ascii_lowercase().ends_with('s');
        let (key, size) =
            if by_stress { ("stress", size * self.options.stress_unit) } else { ("strain", size) };
        let speed = PathValue::Number(self.options.inertial_number);
        let parameters = Given::from([
            ("directions".to_string(), PathValue::Number(count.min(360.0))),
            ("inertial_number".to_string(), speed),
            (key.to_string(), PathValue::Number(size)),
        ]);
        Ok(vec![CaseStage::Path { path: PROBES, parameters, resets: true, until: Vec::new() }])
    }

    fn repetition(&mut self, at: usize) -> Result<Vec<CaseStage>> {
        let (line, text) = self.needed(at, "the line with the numbers of steps and of repetitions")?;
        let mut words = text.split_whitespace().map(|word| word.parse::<u64>().ok());
        let (Some(Some(steps)), Some(Some(times))) = (words.next(), words.next()) else {
            return Err(self.error(line, "the numbers of steps and of repetitions are needed, e.g. 2 10"));
        };
        if steps == 0 || !(1..=MOST_STAGES).contains(&times) {
            let message = format!(
                "{steps} steps and {times} repetitions are not possible; at least 1 step can be repeated 1 to {MOST_STAGES} times"
            );
            return Err(self.error(line, message));
        }
        if self.nested == MOST_NESTED {
            let message = format!("this *Repetition is within {MOST_NESTED} others; no more are possible");
            return Err(self.error(at, message));
        }
        self.nested += 1;
        let mut stages = Vec::new();
        for _ in 0..steps {
            let (number, text) = self.needed(line, "a step to repeat")?;
            stages.extend(self.step(number, text)?);
        }
        self.nested -= 1;
        Ok(vec![CaseStage::Repeat { times, stages }])
    }

    /// `s1 < -100`: one measure beyond a value.
    fn condition(&self, at: usize, text: &str) -> Result<Until> {
        let wrong = || {
            let why = "the condition is not supported; compare one measure with a number, e.g. ? s1 < -100";
            self.error(at, why)
        };
        let (name, value) = text.split_once(['<', '>']).ok_or_else(wrong)?;
        let value = number(value.trim()).ok_or_else(wrong)?;
        let unit = self.options.stress_unit;
        let (measure, factor) = match name.trim() {
            "s1" => (Measure::Stress(0), -unit),
            "s2" => (Measure::Stress(1), -unit),
            "s3" => (Measure::Stress(2), -unit),
            "e1" => (Measure::Strain(0), -1.0),
            "e2" => (Measure::Strain(1), -1.0),
            "e3" => (Measure::Strain(2), -1.0),
            "ev" => (Measure::VolumetricStrain, -1.0),
            "p" => (Measure::MeanStress, unit),
            _ => return Err(wrong()),
        };
        Ok(Until::Reaches { measure, value: value * factor + 0.0 })
    }
}

/// An equation between increments of strain and stress, in granum's order of components.
struct Equation {
    /// Of strains and of stresses.
    weights: [[f64; 6]; 2],
    value: f64,
}

/// Reads `sd1 + sd2 + 2.0*ed3 = -10`.
fn equation(text: &str) -> std::result::Result<Equation, String> {
    let (left, right) =
        text.split_once('=').ok_or_else(|| format!("{text:?} is not an equation: it has no ="))?;
    let value =
        number(right.trim()).ok_or_else(|| format!("{:?} on the right is not a number", right.trim()))?;
    let mut weights = [[0.0; 6]; 2];
    // A sign begins a term, but for that of an exponent.
    let mut terms = vec![String::new()];
    let mut before = ' ';
    for c in left.chars().filter(|c| !c.is_whitespace()) {
        let exponent = matches!(before, 'e' | 'E' | 'd' | 'D');
        if (c == '+' || c == '-') && !exponent && terms.last().is_some_and(|term| !term.is_empty()) {
            terms.push(String::new());
        }
        terms.last_mut().map(|term| term.push(c)).unwrap_or_default();
        before = c;
    }
    for term in terms {
        let wrong = || format!("{term:?} is not a term such as 2.0*sd1 or -ed3");
        let (factor, name) = match term.rsplit_once('*') {
            Some((factor, name)) => (number(factor.trim_start_matches('+')).ok_or_else(wrong)?, name),
            None => match term.strip_prefix('-') {
                Some(name) => (-1.0, name),
                None => (1.0, term.trim_start_matches('+')),
            },
        };
        let kind = ["ed", "sd"].iter().position(|kind| name.starts_with(kind)).ok_or_else(wrong)?;
        let place = name[2..].parse::<usize>().ok().filter(|k| (1..=6).contains(k)).ok_or_else(wrong)?;
        weights[kind][PLACES[place - 1]] += factor;
    }
    Ok(Equation { weights, value })
}

#[cfg(test)]
mod tests;
