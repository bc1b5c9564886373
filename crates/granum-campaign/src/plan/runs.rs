//! The runs of a plan: every one is resolved and checked before anything is computed.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use granum_io::case::{SEED, SetKey};
use granum_io::safe_text::quoted;
use granum_io::{Case, Error, InputError, Result};

use super::definition::{DesignKind, PATH, Plan, PlanRow, PlanVariable, RowPlace, SampleSeeds, VariableKind};
use super::dependence::in_order;
use super::design::{Axis, DesignSize, MOST_POINTS, Point, sobol};
use super::units;
use super::values::{Chosen, RunValue, axis, chosen, given, levels, rounded};

/// Number of digits of the case digest in the name of a run.
const DIGITS: usize = 12;
/// Most values of a run that a message names.
const MOST_SHOWN: usize = 30;
/// Most mistakes that are told one by one.
const MOST_TOLD: usize = 5;
/// Most runs of a plan.
const MOST_RUNS: usize = 1_000_000;
/// The first stage, whose parameters belong to the named path.
pub(super) const FIRST_STAGE: &str = "stage.1.";

/// A run of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanRun {
    /// Its name, made of the digest of its case: the same case has the same name in every plan.
    pub name: String,
    /// The values of the variables, in their order.
    pub values: Vec<(String, RunValue)>,
    /// The keys that it sets over the base case, in the order in which they are set, with their values as text.
    pub settings: Vec<(String, String)>,
    /// The case.
    pub case: Case,
}

/// The runs of a plan.
#[derive(Clone, Debug, PartialEq)]
pub struct PlannedRuns {
    /// The runs, in the order of the design; replicates follow each other.
    pub runs: Vec<PlanRun>,
    /// Number of points that the constraints left out.
    pub left_out: usize,
    /// Number of runs whose case another run already has.
    pub repeated: usize,
}

/// The base case with the keys of a run.
///
/// # Errors
/// As [`Case::set`] for a key or value that is wrong, and as [`Case::check`] for values that do not go together.
pub fn apply_settings(base: &Case, settings: &[(String, String)]) -> Result<Case> {
    let path = settings.iter().find(|(key, _)| key == PATH);
    let mut case = match path {
        Some((_, name)) => {
            let of_path = settings
                .iter()
                .filter_map(|(key, text)| Some((key.strip_prefix(FIRST_STAGE)?, text.as_str())));
            base.with_path(name, &of_path.collect::<Vec<_>>())?
        }
        None => base.clone(),
    };
    for (key, text) in settings {
        if key != PATH && !(path.is_some() && key.starts_with(FIRST_STAGE)) {
            case.set(key, text)?;
        }
    }
    case.check()?;
    Ok(case)
}

/// A mistake of a run, with the place in the plan, or in the file of rows, that it concerns.
struct Mistake {
    error: InputError,
    /// The values of the run.
    values: String,
}

/// A point with its values, before its case is made.
pub(super) struct Valued {
    pub(super) values: Vec<(String, RunValue)>,
    pub(super) settings: Vec<(String, String)>,
}

/// What keeps a point from being a run.
pub(super) enum Refusal {
    /// A constraint does not hold.
    Constraint(usize),
    /// Something is wrong with it.
    Mistake(Range<usize>, String),
}

impl Plan {
    /// Makes the runs and checks each of them. Nothing is written.
    ///
    /// # Errors
    /// [`Error::Inputs`] with the runs that no case accepts: the place in the plan, the values of the run and what is wrong.
    pub fn runs(&self) -> Result<PlannedRuns> {
        let mut left_out = 0;
        let mut mistakes = Vec::new();
        let points = self.points(&mut left_out, &mut mistakes)?;
        self.check_count(points.len())?;
        self.check_bare_numbers(points.first())?;
        let (mut runs, mut repeated) = (Vec::new(), 0);
        let mut names = BTreeSet::new();
        for (k, (valued, row)) in points.into_iter().enumerate() {
            for seed in self.seeds(k, &valued.settings) {
                let mut settings = valued.settings.clone();
                settings.extend(seed.map(|seed| (SEED.to_string(), seed.to_string())));
                let (case, digest) = match apply_settings(&self.case, &settings) {
                    Ok(case) => {
                        let digest = case.digest();
                        (case, digest)
                    }
                    Err(error) => {
                        mistakes.push(self.mistake(&valued, row, &error));
                        break;
                    }
                };
                let name = digest[..DIGITS.min(digest.len())].to_string();
                if names.insert(name.clone()) {
                    runs.push(PlanRun { name, values: valued.values.clone(), settings, case });
                } else {
                    repeated += 1;
                }
            }
        }
        if !mistakes.is_empty() {
            return Err(told(mistakes));
        }
        if runs.is_empty() {
            let message = "the plan has no run: the constraints leave out every point";
            return Err(self.source.error(&self.design.span, message).into());
        }
        Ok(PlannedRuns { runs, left_out, repeated })
    }

    /// Refuses more runs than a campaign can have.
    fn check_count(&self, points: usize) -> Result<()> {
        let replicates = self.design.replicates;
        if points.saturating_mul(replicates) <= MOST_RUNS {
            return Ok(());
        }
        let message = format!(
            "the design has {points} points with {replicates} runs each; at most {MOST_RUNS} runs are possible"
        );
        Err(self.source.error(&self.design.span, message).into())
    }

    /// The seeds of the runs of point k with its settings, counted from the seed of its case; `None` for that seed itself.
    fn seeds(&self, k: usize, settings: &[(String, String)]) -> Vec<Option<u64>> {
        let replicates = self.design.replicates;
        let counted_from = |start: usize| {
            // Settings that no case accepts are told when the run is made.
            let case = apply_settings(&self.case, settings);
            let first = case.as_ref().unwrap_or(&self.case).preparation.seed;
            (start..start + replicates).map(|number| Some(first.wrapping_add(number as u64))).collect()
        };
        match self.design.sample_seeds {
            SampleSeeds::Same if replicates == 1 => vec![None],
            SampleSeeds::Same => counted_from(0),
            SampleSeeds::Different => counted_from(k * replicates),
        }
    }

    /// The points with their values, and the row of each if the design has rows.
    fn points(
        &self,
        left_out: &mut usize,
        mistakes: &mut Vec<Mistake>,
    ) -> Result<Vec<(Valued, Option<&PlanRow>)>> {
        let free: Vec<&PlanVariable> =
            self.variables.iter().filter(|variable| variable.kind.is_free()).collect();
        let axes: Vec<Axis> = free.iter().map(|variable| axis(variable)).collect();
        let mut found = Vec::new();
        let mut take = |valued: std::result::Result<Valued, Refusal>, row: Option<&RowPlace>| match valued {
            Ok(valued) => Some(valued),
            Err(Refusal::Constraint(_)) if row.is_none() => {
                *left_out += 1;
                None
            }
            Err(Refusal::Constraint(k)) => {
                let constraint = &self.constraints[k];
                let message = format!("the row breaks the constraint {}", quoted(constraint.value.text()));
                mistakes.extend(
                    row.map(|row| Mistake { error: row.error(&self.source, message), values: String::new() }),
                );
                None
            }
            Err(Refusal::Mistake(span, message)) => {
                let error = match row {
                    Some(row) => row.error(&self.source, message),
                    None => self.source.error(&span, message),
                };
                mistakes.push(Mistake { error, values: String::new() });
                None
            }
        };
        let wanted = self.design.points.unwrap_or(0);
        match &self.design.kind {
            DesignKind::Rows(rows) => {
                for row in rows {
                    let valued = self.of_row(row);
                    found.extend(take(valued, Some(&row.place)).map(|valued| (valued, Some(row))));
                }
            }
            DesignKind::Points(design) => {
                let axes = match design.size {
                    DesignSize::Levels => {
                        let counts: Vec<usize> = free.iter().map(|variable| levels(variable)).collect();
                        self.check_count(
                            counts.iter().fold(1usize, |all, count| all.saturating_mul(*count)),
                        )?;
                        counts.into_iter().map(Axis::Levels).collect()
                    }
                    DesignSize::Points | DesignSize::PointsThatFulfil => axes,
                };
                let fulfil = design.size == DesignSize::PointsThatFulfil;
                for point in (design.points)(wanted, self.design.seed, &axes) {
                    if fulfil && found.len() == wanted {
                        break;
                    }
                    found.extend(take(self.of_point(&free, &point), None).map(|valued| (valued, None)));
                }
                if fulfil && found.len() < wanted && mistakes.is_empty() {
                    let message = format!(
                        "of the first {MOST_POINTS} points of the sequence only {} fulfil the constraints, and {wanted} are wanted",
                        found.len()
                    );
                    return Err(self.source.error(&self.design.span, message).into());
                }
            }
            DesignKind::Chosen(numbers) => {
                for number in numbers {
                    let valued = self.of_point(&free, &sobol(*number, self.design.seed, &axes));
                    found.extend(take(valued, None).map(|valued| (valued, None)));
                }
            }
        }
        Ok(found)
    }

    /// A number of the base case, with the keys that all runs have, by which an expression can use it; `None` for any other name.
    pub fn case_number(&self, name: &str) -> Option<f64> {
        if !name.contains('.') {
            return None;
        }
        let fixed = self.fixed.iter().find(|fixed| fixed.key == name);
        let unit = || self.case.unit_of(name).unwrap_or_default();
        match fixed {
            Some(fixed) => units::quantity(&fixed.text, &unit()).ok(),
            None => self.case.parameters().into_iter().find(|known| known.key == name)?.number(),
        }
    }

    /// The numbers of the base case that an evaluation has asked for, each of which is looked up once.
    fn case_numbers(&self) -> impl Fn(&str) -> Option<f64> {
        let numbers: RefCell<BTreeMap<String, Option<f64>>> = RefCell::default();
        move |name: &str| {
            if let Some(number) = numbers.borrow().get(name) {
                return *number;
            }
            let number = self.case_number(name);
            numbers.borrow_mut().insert(name.to_string(), number);
            number
        }
    }

    pub(super) fn of_point(
        &self,
        free: &[&PlanVariable],
        point: &Point,
    ) -> std::result::Result<Valued, Refusal> {
        let mut values = BTreeMap::new();
        for (variable, coordinate) in free.iter().zip(point) {
            values.insert(variable.name.as_str(), chosen(variable, *coordinate));
        }
        self.valued(values)
    }

    fn of_row(&self, row: &PlanRow) -> std::result::Result<Valued, Refusal> {
        let mut values = BTreeMap::new();
        let cells: BTreeMap<&str, &String> =
            row.cells.iter().map(|(name, text)| (name.as_str(), text)).rev().collect();
        for variable in self.variables.iter().filter(|variable| variable.kind.is_free()) {
            let Some(text) = cells.get(variable.name.as_str()) else { continue };
            let value = given(variable, text).map_err(|why| {
                Refusal::Mistake(variable.span.clone(), format!("{} = {text} {why}", variable.name))
            })?;
            values.insert(variable.name.as_str(), value);
        }
        self.valued(values)
    }

    /// Adds the values of expressions, and compares the constraints.
    fn valued<'a>(&'a self, mut values: BTreeMap<&'a str, Chosen>) -> std::result::Result<Valued, Refusal> {
        let case_number = self.case_numbers();
        // Each follows those that it depends on; a circle was refused when the plan was read.
        for variable in in_order(&self.variables) {
            let VariableKind::Expression(expression) = &variable.kind else { continue };
            let of = |name: &str| match values.get(name) {
                Some(chosen) => chosen.value.number(),
                None => case_number(name),
            };
            let number = expression.value.value(&of).map_err(|why| {
                let message = format!("{}: {why}, where {}", variable.name, shown(&self.ordered(&values)));
                Refusal::Mistake(expression.span.clone(), message)
            })?;
            let number = rounded(number, variable.step);
            values.insert(&variable.name, Chosen::number(number));
        }
        let of = |name: &str| match values.get(name) {
            Some(chosen) => chosen.value.number(),
            None => case_number(name),
        };
        for (k, constraint) in self.constraints.iter().enumerate() {
            match constraint.value.holds(&of) {
                Ok(true) => {}
                Ok(false) => return Err(Refusal::Constraint(k)),
                Err(why) => {
                    let message = format!("{}: {why}", quoted(constraint.value.text()));
                    return Err(Refusal::Mistake(constraint.span.clone(), message));
                }
            }
        }
        let mut settings: Vec<(String, String)> =
            self.fixed.iter().map(|fixed| (fixed.key.clone(), fixed.text.clone())).collect();
        for variable in &self.variables {
            let Some(chosen) = values.get(variable.name.as_str()) else { continue };
            settings.extend(variable.keys.iter().map(|key| (key.value.clone(), chosen.text.clone())));
            settings.extend(chosen.set.iter().cloned());
        }
        settings.extend(self.carried_over(&settings)?);
        Ok(Valued { values: self.ordered(&values), settings })
    }

    fn ordered(&self, values: &BTreeMap<&str, Chosen>) -> Vec<(String, RunValue)> {
        let of = |variable: &PlanVariable| {
            values.get(variable.name.as_str()).map(|chosen| (variable.name.clone(), chosen.value.clone()))
        };
        self.variables.iter().filter_map(of).collect()
    }

    /// Refuses numbers without a unit that the plan has for stresses and strains and that are probably meant in another one.
    fn check_bare_numbers(&self, first: Option<&(Valued, Option<&PlanRow>)>) -> Result<()> {
        let Some((valued, _)) = first else { return Ok(()) };
        // What is wrong with the run itself is told with all runs.
        let Ok(case) = apply_settings(&self.case, &valued.settings) else { return Ok(()) };
        let check = |path: &str, text: &str, span: &Range<usize>| {
            let key = SetKey { flag: path, path, text };
            case.check_bare_numbers(&self.case, &[key])
                .map_err(|error| Error::from(self.source.error(span, error.to_string())))
        };
        for fixed in &self.fixed {
            check(&fixed.key, &fixed.text, &fixed.span)?;
        }
        for variable in &self.variables {
            for key in &variable.keys {
                match &variable.kind {
                    VariableKind::Range { texts, .. } => {
                        texts.iter().try_for_each(|text| check(&key.value, text, &variable.span))?;
                    }
                    VariableKind::Choice(choices) => {
                        choices
                            .iter()
                            .try_for_each(|choice| check(&key.value, &choice.name, &choice.span))?;
                    }
                    VariableKind::Expression(_) | VariableKind::Given => {}
                }
            }
        }
        Ok(())
    }

    /// The mistake of a run whose case is refused, at the variable that sets the key in question if that is known.
    fn mistake(&self, valued: &Valued, row: Option<&PlanRow>, error: &Error) -> Mistake {
        let values = shown(&valued.values);
        if let Some(row) = row {
            return Mistake { error: row.place.error(&self.source, error.to_string()), values };
        }
        let named = match error {
            Error::Value { name, .. } => Some(name.as_str()),
            _ => None,
        };
        let sets = |variable: &&PlanVariable, key: &str| {
            let by_choice = match &variable.kind {
                VariableKind::Choice(choices) => {
                    choices.iter().any(|choice| choice.set.iter().any(|(own, _)| own == key))
                }
                _ => false,
            };
            by_choice || variable.keys.iter().any(|own| own.value == key)
        };
        let variable = named.and_then(|key| self.variables.iter().find(|variable| sets(variable, key)));
        let span = variable.map_or(&self.design.span, |variable| &variable.span);
        Mistake { error: self.source.error(span, error.to_string()), values }
    }
}

/// `friction = 0.2, law = hertz`.
pub(crate) fn shown(values: &[(String, RunValue)]) -> String {
    let text = |(name, value): &(String, RunValue)| format!("{name} = {}", quoted(&value.to_string()));
    let shown = values.iter().take(MOST_SHOWN).map(text).collect::<Vec<_>>().join(", ");
    match values.len().saturating_sub(MOST_SHOWN) {
        0 => shown,
        more => format!("{shown} and {more} more"),
    }
}

/// The mistakes of runs as one error: the first few, and how many more there are.
fn told(mistakes: Vec<Mistake>) -> Error {
    let count = mistakes.len();
    let tell = |mistake: Mistake| {
        let Mistake { mut error, values } = mistake;
        if !values.is_empty() {
            error.message = format!("{} in the run with {values}", error.message);
        }
        error
    };
    let mut errors: Vec<InputError> = mistakes.into_iter().take(MOST_TOLD).map(tell).collect();
    if let Some(last) = errors.last_mut().filter(|_| count > MOST_TOLD) {
        last.message = format!("{}; {} more runs are refused", last.message, count - MOST_TOLD);
    }
    Error::Inputs(errors)
}
