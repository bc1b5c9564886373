//! Families by name or file, and the inputs that flags and cases give them.

use std::path::Path;

use clap::Args;
use granum::families;
use granum_core::quantity::Dimension;
use granum_io::Case;
use granum_io::case::ParameterValue;
use granum_io::shell::ShowPath;
use granum_learn::dataset::RunStates;
use granum_learn::family::{ALL, FamilyDefinition, FamilyModel, by_name};
use granum_run::derived_columns::single_parameters;

use super::family_rows::{Asked, Property, check_used, combinations, of_table, values_of_flag};
use super::known_numbers::KnownNumbers;
use crate::context::Context;
use crate::failure::Failure;

/// The end of the names of files of fitted families.
const FILE: &str = ".json";
/// The key of the shape of the grains.
const SHAPE: &str = "grains.shape.kind";
/// The key of the void ratio of the sample.
pub const VOID_RATIO: &str = "sample.void_ratio";

/// A family and what is known of a test.
#[derive(Args, Clone, Debug, Default)]
#[command(next_help_heading = "Families of tests")]
pub struct FamilyFlags {
    /// Predict the curves of a test of this family, or of a fitted family in a file (NAME.json); without a name: list the families.
    #[arg(long, value_name = "NAME", num_args = 0..=1, default_missing_value = "", conflicts_with_all = ["mapping", "values"])]
    pub family: Option<String>,
    /// Coefficient of friction of the grains. As for all properties, several values stand between commas: all combinations are answered; a property
    /// of the grains that is not given is integrated over its range.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    friction: Option<String>,
    /// Length of long grains over their thickness.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    aspect_ratio: Option<String>,
    /// Coefficient of rolling friction of the grains.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    rolling_friction: Option<String>,
    /// Stress of the sample, e.g. "100 kPa".
    #[arg(long, value_name = "STRESS", requires = "family")]
    pressure: Option<String>,
    /// Young's modulus of the grains, e.g. "2 GPa".
    #[arg(long, value_name = "STRESS", requires = "family")]
    youngs_modulus: Option<String>,
    /// Interface energy of cohesive grains, e.g. "0.02 J/m2".
    #[arg(long, value_name = "ENERGY", requires = "family")]
    interface_energy: Option<String>,
    /// Mean diameter of cohesive grains, e.g. "10 um".
    #[arg(long, value_name = "LENGTH", requires = "family")]
    diameter: Option<String>,
    /// Half the range of the diameters over their mean; by default a typical one.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    spread: Option<String>,
    /// Void ratio of the sample; by default that of such grains as the family usually prepares them.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    void_ratio: Option<String>,
    /// Mechanical coordination number of the sample; by default the typical one.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    coordination_number: Option<String>,
    /// Coefficient of friction while the sample is made, if its void ratio is not known.
    #[arg(long, value_name = "NUMBER", requires = "family")]
    preparation_friction: Option<String>,
    /// Path of the test; that of the case, or the first one of the family by default.
    #[arg(long, value_name = "NAME", requires = "family")]
    path: Option<String>,
    /// Make a sample and test it as well, say how far off the prediction was, and draw the test over the prediction for its sample.
    #[arg(long, requires = "family", conflicts_with = "card")]
    pub check: bool,
    /// Number of grains of the sample of --check; by default that of the family.
    #[arg(long, value_name = "N", requires = "check")]
    pub grains: Option<usize>,
    /// Print the card of the family: how it was made, how good it is on runs that it has not seen, where not to use it.
    #[arg(long, requires = "family")]
    pub card: bool,
}

impl FamilyFlags {
    /// The flags of numbers: name, key, dimension, value.
    fn numbers(&self) -> [(&'static str, &'static str, Dimension, &Option<String>); 11] {
        let number = Dimension::NUMBER;
        [
            ("--friction", "grains.material.friction", number, &self.friction),
            ("--aspect-ratio", "grains.shape.aspect_ratio", number, &self.aspect_ratio),
            ("--rolling-friction", "contact.rolling_friction", number, &self.rolling_friction),
            ("--pressure", "preparation.mean_stress", Dimension::STRESS, &self.pressure),
            ("--youngs-modulus", "grains.material.youngs_modulus", Dimension::STRESS, &self.youngs_modulus),
            (
                "--interface-energy",
                "grains.material.interface_energy",
                Dimension::SURFACE_ENERGY,
                &self.interface_energy,
            ),
            ("--diameter", "grains.diameter", Dimension::LENGTH, &self.diameter),
            ("--spread", "grains.spread", number, &self.spread),
            ("--preparation-friction", "preparation.friction", number, &self.preparation_friction),
            ("--void-ratio", VOID_RATIO, number, &self.void_ratio),
            (
                "--coordination-number",
                "sample.mechanical_coordination_number",
                number,
                &self.coordination_number,
            ),
        ]
    }

    /// The flags of numbers with their keys and dimensions.
    pub fn properties() -> [Property; 11] {
        FamilyFlags::default().numbers().map(|(flag, key, dimension, _)| (flag, key, dimension))
    }

    /// The flag that gives a number; its key if there is none.
    pub fn flag_of(key: &str) -> String {
        let flags = FamilyFlags::default();
        let found = flags.numbers().into_iter().find(|(_, known, ..)| *known == key);
        found.map_or_else(|| key.to_string(), |(flag, ..)| flag.to_string())
    }

    /// The fitted family that is meant: by its name and the path of the flag or of the case, or in a file.
    pub fn fitted(&self, context: &Context, name: &str, case: Option<&Path>) -> Result<FamilyModel, Failure> {
        if let Some(case) = case.filter(|_| !is_file(name) && self.path.is_none()) {
            let case = Case::read_as(case, context.reading())?;
            // A path that the family does not have is refused with the words of the case.
            let own = path_of(&case).and_then(|path| by_name(name, Some(&path)).ok());
            return of_definition(own.map_or_else(|| by_name(name, None), Ok)?);
        }
        fitted(name, self.path.as_deref())
    }

    /// The tests that are asked for by flags, the case and the rows of a table, flags and rows before the case.
    pub fn asked(
        &self,
        context: &Context,
        family: &FamilyDefinition,
        case: Option<&Path>,
        input: Option<&Path>,
    ) -> Result<Vec<Asked>, Failure> {
        let mut known = KnownNumbers::default();
        if let Some(path) = case {
            let case = Case::read_as(path, context.reading())?;
            known = of_case(context, family, &case)?;
        }
        let properties = FamilyFlags::properties();
        let mut values: Vec<(Property, Vec<f64>)> = Vec::new();
        for (flag, key, dimension, text) in self.numbers() {
            let Some(text) = text else { continue };
            check_used(family, flag, key, &properties)?;
            values.push(((flag, key, dimension), values_of_flag((flag, key, dimension), text)?));
        }
        let asked = combinations(&known, &values)?;
        match input {
            Some(path) => of_table(context, path, family, &properties, &asked),
            None => Ok(asked),
        }
    }

    /// Refuses options that a list or a card has no use for.
    pub fn refuse_properties(&self, of: &str) -> Result<(), Failure> {
        match self.numbers().into_iter().find(|(.., text)| text.is_some()) {
            Some((flag, ..)) => {
                Err(Failure::new(format!("{flag}: {of} does not depend on it; leave it out")))
            }
            None => Ok(()),
        }
    }
}

/// The numbers of a case, whose words must be those of the family.
fn of_case(context: &Context, family: &FamilyDefinition, case: &Case) -> Result<KnownNumbers, Failure> {
    let mut known = KnownNumbers::default();
    for parameter in single_parameters(case) {
        match &parameter.value {
            ParameterValue::Number(number) => known.set(&parameter.key, *number),
            ParameterValue::Word(word) => {
                let wanted = family.words.iter().find(|(key, _)| *key == parameter.key);
                if let Some((key, wanted)) = wanted.filter(|(_, wanted)| wanted != word) {
                    return Err(Failure::new(format!(
                        "{key} of the case is {word}; the family {} along the path {} has {wanted}",
                        family.name, family.path
                    )));
                }
            }
            ParameterValue::List(_) => {}
        }
    }
    // A case of spheres has no shape among its parameters.
    let word = |words: Option<String>| words.unwrap_or_else(|| "sphere".into());
    let of_family = family.words.iter().find(|(key, _)| *key == SHAPE).map(|(_, word)| (*word).to_string());
    let of_case = single_parameters(case).into_iter().find(|parameter| parameter.key == SHAPE);
    let of_case = of_case.and_then(|parameter| match parameter.value {
        ParameterValue::Word(word) => Some(word),
        _ => None,
    });
    let (of_case, of_family) = (word(of_case), word(of_family));
    if of_case != of_family {
        return Err(Failure::new(format!(
            "{SHAPE} of the case is {of_case}; the grains of the family {} are of the kind {of_family}",
            family.name
        )));
    }
    for (key, text) in family.settings.iter().filter(|(key, _)| key.starts_with("contact.")) {
        let Some((of_case, of_family)) = known.get(key).zip(text.parse::<f64>().ok()) else { continue };
        if of_case != of_family {
            context.warn(&format!(
                "{key} of the case is {of_case}, and all tests of the family {} have {of_family}: the answer is for that",
                family.name
            ));
        }
    }
    let target = known.get("preparation.void_ratio");
    let fraction = known.get("preparation.solid_fraction").filter(|fraction| *fraction > 0.0);
    if let Some(ratio) = target.or_else(|| fraction.map(|fraction| 1.0 / fraction - 1.0)) {
        // The preparation looks for this void ratio, and its friction follows.
        known.set(VOID_RATIO, ratio);
        known.forget("preparation.friction");
    } else if known.get("preparation.cycles").is_some_and(|cycles| cycles > 0.0) {
        known.forget("preparation.friction");
        context.note(
            "the case makes its sample denser by cycles of strain, which the samples of the family are not: the void ratio below is not \
             that of such a sample; give --void-ratio",
        );
    }
    Ok(known)
}

/// True if it is the file of a fitted family, and not the name of a family.
pub fn is_file(name: &str) -> bool {
    name.ends_with(FILE)
}

/// The path of the first stage of a case.
fn path_of(case: &Case) -> Option<String> {
    single_parameters(case).into_iter().find_map(|parameter| {
        match (parameter.key.as_str(), parameter.value) {
            ("stage.1.path", ParameterValue::Word(word)) => Some(word),
            _ => None,
        }
    })
}

/// The fitted family of a name along a path, or in a file.
pub fn fitted(name: &str, path: Option<&str>) -> Result<FamilyModel, Failure> {
    if !is_file(name) {
        return of_definition(by_name(name, path)?);
    }
    let model = FamilyModel::load(Path::new(name))?;
    let own = model.definition().path;
    match path.filter(|path| *path != own) {
        Some(path) => Err(Failure::new(format!("--path {path}: the tests of {name} have the path {own}"))),
        None => Ok(model),
    }
}

/// The family that a command is given where it takes a surrogate: that of a name, if there is no file of that name, or that in a file; `None` if it is something else, which may be a
/// `model` of a study. `family_path` is the path of its tests.
pub fn chosen_family(
    path: &Path,
    family_path: Option<&str>,
    model: Option<&str>,
) -> Result<Option<FamilyModel>, Failure> {
    let mut names: Vec<&str> = families::FITTED.iter().map(|known| known.name).collect();
    names.dedup();
    let found = match path.exists() {
        // Files of families and of surrogates have the same ending.
        true if path.is_file() => FamilyModel::load(path).ok(),
        true => None,
        false => match names.iter().find(|name| Some(**name) == path.to_str()) {
            Some(name) => Some(fitted(name, family_path)?),
            None => {
                let family = granum_core::names::suggestion(&path.to_string_lossy(), names.into_iter());
                return Err(Failure::new(format!(
                    "{}: there is no such file or folder, and no such family ({family}); give the file of a surrogate, the folder of a study, as \
                     `granum train` writes them, or the name of a family",
                    path.shown()
                )));
            }
        },
    };
    match (&found, family_path, model) {
        (None, Some(family_path), _) => Err(Failure::new(format!(
            "--path {family_path} goes with the name of a family, and {} is none",
            path.shown()
        ))),
        (Some(family), Some(family_path), _) if family.definition().path != family_path => {
            let own = family.definition().path;
            Err(Failure::new(format!(
                "--path {family_path}: the tests of {} have the path {own}",
                path.shown()
            )))
        }
        (Some(_), _, Some(name)) => Err(Failure::new(format!(
            "--model {name}: a family has one surrogate for each path, which --path chooses"
        ))),
        _ => Ok(found),
    }
}

/// The fitted family that comes with the program.
fn of_definition(family: &FamilyDefinition) -> Result<FamilyModel, Failure> {
    families::fitted(family)?.ok_or_else(|| {
        let FamilyDefinition { name, path, plan, .. } = family;
        Failure::new(format!(
            "this program has no fitted surrogate of the family {name} along the path {path}; fit one: granum train --family {name} --path {path} \
             DATA... -o {name}.json (runs: granum init --plan {plan}), and give its file: --family {name}.json"
        ))
    })
}

/// A line for each family and path.
pub fn listed() -> Vec<String> {
    let line = |family: &&FamilyDefinition| {
        let has = families::FITTED.iter().any(|known| known.is_of(family));
        let fitted = if has { "" } else { " (no fitted surrogate in this program)" };
        format!("{} --path {}: {}{fitted}", family.name, family.path, family.title)
    };
    ALL.iter().map(line).collect()
}

/// The value of every input that the numbers give; at least one must be given.
pub fn inputs_of(family: &FamilyDefinition, known: &KnownNumbers) -> Result<Vec<Option<f64>>, Failure> {
    let value = |key: &str| known.get(key);
    let inputs: Vec<Option<f64>> = family.inputs.iter().map(|input| input.from_numbers(&value)).collect();
    for (input, value) in family.inputs.iter().zip(&inputs) {
        let keys: Vec<&str> = std::iter::once(input.key).chain(input.over.iter().copied()).collect();
        if value.is_none() && keys.iter().all(|key| known.get(key).is_some()) {
            let each = |key: &&str| {
                format!("{} = {}", FamilyFlags::flag_of(key), known.get(key).unwrap_or(f64::NAN))
            };
            let each: Vec<String> = keys.iter().map(each).collect();
            return Err(Failure::new(format!(
                "{} ({}) has no finite value with {}; give numbers that grains can have",
                input.name,
                input.meaning,
                each.join(" and ")
            )));
        }
    }
    if inputs.iter().any(Option::is_some) {
        return Ok(inputs);
    }
    let lacking =
        family.inputs.iter().zip(&inputs).filter(|(input, value)| input.is_required && value.is_none());
    let keys = lacking.flat_map(|(input, _)| std::iter::once(input.key).chain(input.over.iter().copied()));
    let mut missing: Vec<String> = Vec::new();
    for flag in keys.filter(|key| known.get(key).is_none()).map(FamilyFlags::flag_of) {
        if !missing.contains(&flag) {
            missing.push(flag);
        }
    }
    Err(Failure::new(format!(
        "missing: {}; the family {} has these properties, of which one at least must be given (a case file gives them too: granum predict --family {} \
         CASE)",
        missing.join(", "),
        family.name,
        family.name
    )))
}

/// The inputs of a run that was measured, which leave nothing to be typical.
pub fn inputs_of_run(family: &FamilyDefinition, run: &RunStates) -> Result<Vec<Option<f64>>, Failure> {
    Ok(family.inputs.iter().map(|input| input.of_run(run).map(Some)).collect::<Result<_, _>>()?)
}
