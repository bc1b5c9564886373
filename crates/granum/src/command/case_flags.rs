//! Flags that change a case on the command line, with the same error messages as for the case file.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use clap::Args;
use granum_io::case::{SetKey, field, values_in};
use granum_io::{Case, Error};
use granum_run::queue::{Setting as Varied, combinations, names};

use crate::context::Context;
use crate::failure::Failure;

/// Keys of the case, given on the command line.
#[derive(Args, Clone, Debug, Default)]
pub struct SetFlags {
    /// Set a key of the case, e.g. --set grains.material.friction=0.2; can be repeated for several keys. `run`, `shear` and
    /// `prepare` take several values, e.g. --set grains.material.friction=0.2,0.4, and make all combinations.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Keys of the case and the seed, given on the command line.
#[derive(Args, Clone, Debug, Default)]
pub struct CaseFlags {
    #[command(flatten)]
    set: SetFlags,
    /// Seed of the sample, the same as --set preparation.seed=N; `run`, `shear` and `prepare` take several, e.g. --seed 1,2,3.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    seed: Option<String>,
}

/// A case that the flags give, with its name among several.
pub struct Combination {
    /// Name made of the values that differ; empty if there is one case only.
    pub name: String,
    /// The keys that have several values, with the values of this case.
    pub values: Vec<(String, String)>,
    pub case: Case,
}

/// A named path with the parameters that are given to it.
pub type Loading<'a> = Option<(&'a str, &'a [(&'a str, &'a str)])>;

/// A flag as the user gave it, with its key and value.
#[derive(Clone)]
struct Setting<'a> {
    flag: String,
    key: &'a str,
    value: &'a str,
}

impl Setting<'_> {
    fn parse(text: &str) -> Result<Setting<'_>, Failure> {
        let Some((key, value)) = text.split_once('=').filter(|(key, _)| !key.trim().is_empty()) else {
            return Err(Failure::new(format!(
                "--set {text:?}: a key and its value are needed, e.g. --set grains.material.friction=0.2"
            )));
        };
        let (key, value) = (key.trim(), value.trim());
        // Quotes are removed, which a case file needs and which the shell may have passed on.
        let bare = value.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        let bare = bare.filter(|bare| !bare.contains('"'));
        Ok(Setting { flag: format!("--set {key}"), key, value: bare.unwrap_or(value) })
    }
}

impl SetFlags {
    /// True if a key is given.
    pub fn is_given(&self) -> bool {
        !self.set.is_empty()
    }

    fn settings(&self) -> Result<Vec<Setting<'_>>, Failure> {
        self.set.iter().map(|text| Setting::parse(text)).collect()
    }

    /// Sets keys in the given sections of the case. Keys of other sections have no effect on the command and are refused, as
    /// are keys that another flag also sets (`others` lists these flags with their keys).
    pub fn apply_law(
        &self,
        case: &mut Case,
        sections: &[&str],
        others: &[(&str, &str)],
    ) -> Result<(), Failure> {
        let settings = self.settings()?;
        for setting in &settings {
            if field(setting.key).is_some_and(|field| !sections.contains(&field.section)) {
                return Err(Failure::new(format!(
                    "{} has no effect in this command, which uses only {} of a case",
                    setting.flag,
                    sections.iter().map(|section| format!("[{section}]")).collect::<Vec<_>>().join(", ")
                )));
            }
            if let Some((flag, _)) = others.iter().find(|(_, key)| *key == setting.key) {
                return Err(Failure::new(format!("{} and {flag} both set {}", setting.flag, setting.key)));
            }
        }
        apply(case, &settings, Case::check_law)
    }
}

impl CaseFlags {
    /// True if a key or the seed is given.
    pub fn is_given(&self) -> bool {
        self.seed.is_some() || !self.set.set.is_empty()
    }

    /// Reads a case file and applies the flags. With `packing`, flags that have no effect on a run from a packing are
    /// refused.
    pub fn read(&self, context: &Context, path: &Path, packing: bool) -> Result<Case, Failure> {
        self.read_with_path(context, path, packing, None)
    }

    /// As [`CaseFlags::read`], but a named path with its parameters replaces the test of the case.
    pub fn read_with_path(
        &self,
        context: &Context,
        path: &Path,
        packing: bool,
        loading: Loading,
    ) -> Result<Case, Failure> {
        let mut all = self.read_all(context, path, packing, loading)?;
        match (all.pop(), all.is_empty()) {
            (Some(only), true) => Ok(only.case),
            _ => Err(Failure::new(
                "several values of a key make several runs, which this command does not take; give one value of each",
            )),
        }
    }

    /// The cases of all combinations of the values that the flags give. A mistake in any of them is an error.
    pub fn read_all(
        &self,
        context: &Context,
        path: &Path,
        packing: bool,
        loading: Loading,
    ) -> Result<Vec<Combination>, Failure> {
        let mut settings = self.set.settings()?;
        if let Some(seed) = &self.seed {
            settings.push(Setting { flag: "--seed".into(), key: "preparation.seed", value: seed });
        }
        let case = Case::read_as(path, context.reading())?;
        let unused = |setting: &&Setting| case.unused_with_packing().any(|key| key == setting.key);
        if let Some(setting) = settings.iter().find(unused).filter(|_| packing) {
            return Err(Failure::new(format!(
                "{} has no effect in a run from --packing: the grains are those of the packing",
                setting.flag
            )));
        }
        if let Some(text) = loading.and_then(|loading| dropped(&case, loading)) {
            context.note(&text);
        }
        let varied = varied(&case, loading, &settings)?;
        let several = varied.iter().any(|setting| setting.values.len() > 1);
        let mut all: Vec<Combination> = Vec::new();
        let mut digests: BTreeMap<String, String> = BTreeMap::new();
        for (name, values) in names(&varied)?.into_iter().zip(combinations(&varied)?) {
            let case = one(&case, loading, &settings, &values)?;
            let kept = varied.iter().zip(values).filter(|(setting, _)| setting.values.len() > 1);
            let values = kept.map(|(setting, value)| (setting.key.clone(), value)).collect();
            let name = if several { name } else { String::new() };
            if let Some(same) = digests.insert(case.digest(), name.clone()) {
                let message = format!("{same} and {name} are the same case: give every value once");
                return Err(Failure::new(message));
            }
            all.push(Combination { name, values, case });
        }
        Ok(all)
    }
}

/// What the case gives to its own path and the named one would have as well, but does not take over.
fn dropped(case: &Case, (name, parameters): (&str, &[(&str, &str)])) -> Option<String> {
    let keys: Vec<&str> = parameters.iter().map(|(key, _)| *key).collect();
    let change = case.path_exchange(name, &keys)?;
    let lost: Vec<String> = change.carried.iter().map(|(key, text)| format!("{key} = {text}")).collect();
    (!lost.is_empty()).then(|| {
        format!(
            "--path {name} replaces the test of the case, so that its {} does not count; give what is to stay with --with",
            lost.join(", ")
        )
    })
}

/// The keys of the path and of the flags, each with its values.
fn varied(case: &Case, loading: Loading, settings: &[Setting]) -> Result<Vec<Varied>, Failure> {
    let mut varied = Vec::new();
    let mut case = case.clone();
    let mut add = |case: &Case, key: String, flag: &str, text: &str| -> Result<(), Failure> {
        let values = values_in(text, case.shape_of(&key))
            .map_err(|why| Failure::new(format!("{flag} = {text:?} {why}")))?;
        varied.push(Varied { key, values });
        Ok(())
    };
    if let Some((name, parameters)) = loading {
        case = case.with_path(name, &[])?;
        for (key, text) in parameters {
            add(&case, format!("stage.1.{key}"), &format!("--with {key}"), text)?;
        }
    }
    for setting in settings {
        add(&case, setting.key.to_string(), &setting.flag, setting.value)?;
    }
    Ok(varied)
}

/// The case with one value for each parameter of the path and then for each flag.
fn one(before: &Case, loading: Loading, settings: &[Setting], values: &[String]) -> Result<Case, Failure> {
    let mut case = before.clone();
    let mut with = Vec::new();
    let (of_path, of_flags) = values.split_at(values.len() - settings.len());
    if let Some((name, parameters)) = loading {
        let parameters: Vec<(&str, &str)> =
            parameters.iter().zip(of_path).map(|((key, _), value)| (*key, value.as_str())).collect();
        case = case.with_path(name, &parameters).map_err(named_with)?;
        with.extend(
            parameters
                .iter()
                .map(|(key, text)| (format!("{WITH} {key}"), format!("{FIRST_STAGE}{key}"), *text)),
        );
    }
    let settings: Vec<Setting> = settings
        .iter()
        .zip(of_flags)
        .map(|(setting, value)| Setting { value: value.as_str(), ..setting.clone() })
        .collect();
    apply(&mut case, &settings, Case::check)?;
    let with = with.iter().map(|(flag, path, text)| SetKey { flag, path, text });
    let set =
        settings.iter().map(|setting| SetKey { flag: &setting.flag, path: setting.key, text: setting.value });
    case.check_bare_numbers(before, &with.chain(set).collect::<Vec<_>>())?;
    Ok(case)
}

/// The flag of a parameter of a named path.
const WITH: &str = "--with";
/// The beginning of the keys of such a path, which is the only stage of its case.
const FIRST_STAGE: &str = "stage.1.";

/// The same error with the flag of the parameter instead of the key.
fn named_with(error: Error) -> Error {
    match error {
        Error::Value { name, value, message } if name != "path" => {
            let key = name.strip_prefix(FIRST_STAGE).unwrap_or(&name);
            Error::Value { name: format!("{WITH} {key}"), value, message }
        }
        other => other,
    }
}

/// Pairs of keys that exclude each other; without this check the last one given would silently take precedence.
const EXCLUSIVE: [[&str; 2]; 5] = [
    ["shear.inertial_number", "shear.strain_rate"],
    ["recording.first_strain", "recording.strains"],
    ["preparation.solid_fraction", "preparation.void_ratio"],
    ["preparation.solid_fraction", "preparation.relative_density"],
    ["preparation.void_ratio", "preparation.relative_density"],
];

/// Sets keys, and checks what the command uses of the case.
fn apply(
    case: &mut Case,
    settings: &[Setting],
    check: impl Fn(&Case) -> granum_io::Result<()>,
) -> Result<(), Failure> {
    let mut seen = BTreeSet::new();
    for setting in settings {
        if !seen.insert(setting.key) {
            return Err(Failure::new(format!("{} is given twice", setting.key)));
        }
        let value = setting.value;
        case.set(setting.key, value).map_err(|error| match error {
            Error::Value { value, message, .. } => {
                Error::Value { name: setting.flag.clone(), value, message }
            }
            other => other,
        })?;
    }
    if let Some([one, other]) = EXCLUSIVE.iter().find(|pair| pair.iter().all(|key| seen.contains(key))) {
        return Err(Failure::new(format!("--set {one} and --set {other} exclude each other")));
    }
    check(case).map_err(|error| match (error, settings) {
        (error, []) => Failure::from(error),
        (error, _) => {
            let flags: Vec<String> =
                settings.iter().map(|setting| format!("{}={}", setting.flag, setting.value)).collect();
            Failure::new(format!("with {}: {error}", flags.join(" ")))
        }
    })
}
