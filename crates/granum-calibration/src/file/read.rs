//! Reading the file of a calibration: all mistakes are reported at once, each with its place and what would be right.

use std::path::Path;

use granum_campaign::plan::{
    DesignKind, DesignTable, Keep, Plan, PlanSource, PlanVariable, Reader, SampleSeeds, VariableKind,
};
use granum_core::words;
use granum_io::{Reading, Result};
use granum_run::engine::LammpsStart;
use toml::de::DeTable;

use super::definition::{CalibrationFile, CalibrationTable, TestCondition};
use super::read_table::table;
use super::read_variable::{Role, VARIABLE_KEYS, variable};

/// The keys of the file.
const KEYS: [&str; 5] = ["case", "set", "variable", "accept", "calibration"];
/// The key of the case that says how far a test goes, where its path has it.
const AXIAL_STRAIN: &str = "stage.1.axial_strain";

impl CalibrationFile {
    /// Reads the file of a calibration and its base case.
    ///
    /// # Errors
    /// [`granum_io::Error::Inputs`] with all mistakes of the file, and as [`granum_io::Case::read`] for the base case.
    pub fn read(path: &Path, reading: Reading) -> Result<CalibrationFile> {
        CalibrationFile::parse(PlanSource::open(path)?, reading)
    }

    /// Reads the text of a calibration and the base case that it names.
    ///
    /// # Errors
    /// As [`CalibrationFile::read`].
    pub fn parse(source: PlanSource, reading: Reading) -> Result<CalibrationFile> {
        Reader::read(source, reading, read)
    }
}

fn read(reader: &mut Reader, document: &DeTable<'_>) -> Result<Option<CalibrationFile>> {
    reader.refuse_unknown(document, &KEYS, "calibration file");
    let Some((case_file, case)) = reader.base_case(document)? else { return Ok(None) };
    let fixed = document.get("set").map_or_else(Vec::new, |node| reader.fixed(node));
    let drafts = reader.drafts(document.get("variable"), &VARIABLE_KEYS);
    let names: Vec<String> = drafts.iter().map(|draft| draft.name.clone()).collect();
    let Some(reference) = reader.reference(&case, &fixed, &drafts) else { return Ok(None) };
    let (mut variables, mut free, mut conditions) = (Vec::new(), Vec::new(), Vec::new());
    for draft in drafts {
        let Some((variable, role)) = variable(reader, draft, &reference) else { continue };
        match role {
            Role::Free(variable) => free.push(variable),
            Role::OfTest(condition) => conditions.push((variable.name.clone(), condition)),
            Role::Expression => {}
        }
        variables.push(variable);
    }
    let Some(calibration) = table(reader, document.get("calibration")) else { return Ok(None) };
    if free.is_empty() && reader.errors.is_empty() {
        let help = "give a variable prior = \"uniform\", from and to";
        reader.error(0..0, "no variable is free, so that there is nothing to calibrate", help);
    }
    let design = DesignTable {
        kind: DesignKind::Rows(Vec::new()),
        points: None,
        seed: calibration.seed,
        replicates: 1,
        // Each simulation has a sample of its own, so that the scatter of samples is a part of what is learned.
        sample_seeds: SampleSeeds::Different,
        span: 0..0,
    };
    let accept = reader.conditions(document, "accept");
    let plan = Plan {
        source: reader.source.clone(),
        case_file,
        case,
        fixed,
        variables,
        design,
        constraints: Vec::new(),
        accept,
        keep: Keep::Folders,
        engine: String::new(),
        lammps: LammpsStart::default(),
    };
    reader.check_names(&plan, &reference, &names);
    check_uses(reader, &plan);
    check_conditions(reader, &conditions, &calibration, &plan.variables);
    let end = reference.parameters().into_iter().find(|known| known.key == AXIAL_STRAIN);
    check_strains(reader, &calibration, end.and_then(|known| known.number()));
    Ok(Some(CalibrationFile { plan, free, conditions, calibration }))
}

/// Refuses a variable that changes nothing: it has no key, and no expression uses it.
fn check_uses(reader: &mut Reader, plan: &Plan) {
    let expressions: Vec<&str> = plan
        .variables
        .iter()
        .filter_map(|variable| match &variable.kind {
            VariableKind::Expression(expression) => Some(expression.value.names()),
            _ => None,
        })
        .flatten()
        .collect();
    let is_idle =
        |variable: &&PlanVariable| variable.keys.is_empty() && !expressions.contains(&variable.name.as_str());
    for variable in plan.variables.iter().filter(is_idle) {
        let message = format!("the variable {} changes nothing", variable.name);
        let help = "give it a key of the case, or use it in the expression of a variable that has one";
        reader.error(variable.span.clone(), message, help);
    }
}

/// Refuses a relative density without the void ratios that it counts between, and a state parameter without the critical state.
fn check_conditions(
    reader: &mut Reader,
    conditions: &[(String, TestCondition)],
    calibration: &CalibrationTable,
    variables: &[PlanVariable],
) {
    for (name, condition) in conditions {
        let (message, help) = match condition {
            TestCondition::RelativeDensity if calibration.void_ratio_limits.is_none() => (
                format!("{name}: a relative density counts between two void ratios"),
                "add [calibration.density] with densest_void_ratio and loosest_void_ratio of the laboratory",
            ),
            TestCondition::StateParameter if calibration.critical_state.is_none() => (
                format!("{name}: a state parameter counts from the critical state"),
                "add [calibration.critical_state] with void_ratio and slope of the laboratory's critical state line",
            ),
            _ => continue,
        };
        let span = variables.iter().find(|variable| variable.name == *name);
        reader.error(span.map_or(0..0, |found| found.span.clone()), message, help);
    }
}

/// Refuses strains that the tests of the case do not reach, whose axial strain is logarithmic.
fn check_strains(reader: &mut Reader, calibration: &CalibrationTable, end: Option<f64>) {
    let Some(end) = end else { return };
    let reached = 1.0 - libm::exp(-end);
    for compared in &calibration.quantities {
        let Some(last) = compared.strains.last().filter(|last| **last > reached) else { continue };
        let needed = 100.0 * -libm::log(1.0 - last) + 0.05;
        let message = format!(
            "{} is compared up to an axial strain of {}, and the tests of the case end at {} ({AXIAL_STRAIN} = {end} is \
             logarithmic)",
            compared.quantity.word(),
            words::percent(*last, 4),
            words::percent(reached, 4)
        );
        let help = format!("write {AXIAL_STRAIN} = \"{needed:.1} %\" below [set], or compare less");
        reader.error(compared.span.clone(), message, &help);
    }
}
