//! Flags that change a case on the command line, with the same error messages as for the case file.

use std::collections::BTreeSet;
use std::path::Path;

use clap::Args;
use granum_io::case::field;
use granum_io::{Case, Error};

use crate::failure::Failure;

/// Keys of the case, given on the command line.
#[derive(Args, Clone, Debug, Default)]
pub struct SetFlags {
    /// Set a key of the case, e.g. --set grains.material.friction=0.2; can be repeated for several keys.
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
}

/// Keys of the case and the seed, given on the command line.
#[derive(Args, Clone, Debug, Default)]
pub struct CaseFlags {
    #[command(flatten)]
    set: SetFlags,
    /// Seed of the sample, the same as --set preparation.seed=N.
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    seed: Option<String>,
}

/// A flag as the user gave it, with its key and value.
struct Setting<'a> {
    flag: String,
    key: &'a str,
    value: &'a str,
}

impl Setting<'_> {
    fn of(text: &str) -> Result<Setting<'_>, Failure> {
        let Some((key, value)) = text.split_once('=').filter(|(key, _)| !key.trim().is_empty()) else {
            return Err(Failure::new(format!(
                "--set {text:?}: a key and its value are needed, e.g. --set grains.material.friction=0.2"
            )));
        };
        let (key, value) = (key.trim(), value.trim());
        // Quotes are removed, which a case file needs and which the shell may have passed on.
        let bare = value.strip_prefix('"').and_then(|rest| rest.strip_suffix('"'));
        Ok(Setting { flag: format!("--set {key}"), key, value: bare.unwrap_or(value) })
    }
}

impl SetFlags {
    fn settings(&self) -> Result<Vec<Setting<'_>>, Failure> {
        self.set.iter().map(|text| Setting::of(text)).collect()
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
        apply(case, &settings)
    }
}

impl CaseFlags {
    /// True if a key or the seed is given.
    pub fn is_given(&self) -> bool {
        self.seed.is_some() || !self.set.set.is_empty()
    }

    /// Reads a case file and applies the flags. With `packing`, flags that have no effect on a run from a packing are
    /// refused.
    pub fn read(&self, path: &Path, packing: bool) -> Result<Case, Failure> {
        self.read_with_path(path, packing, None)
    }

    /// As [`CaseFlags::read`], but a named path with its parameters replaces the test of the case.
    pub fn read_with_path(
        &self,
        path: &Path,
        packing: bool,
        loading: Option<(&str, &[(&str, &str)])>,
    ) -> Result<Case, Failure> {
        let mut settings = self.set.settings()?;
        if let Some(seed) = &self.seed {
            settings.push(Setting { flag: "--seed".into(), key: "preparation.seed", value: seed });
        }
        let mut case = Case::read(path)?;
        let unused = |setting: &&Setting| case.unused_with_packing().any(|key| key == setting.key);
        if let Some(setting) = settings.iter().find(unused).filter(|_| packing) {
            return Err(Failure::new(format!(
                "{} has no effect in a run from --packing: the grains are those of the packing",
                setting.flag
            )));
        }
        if let Some((name, parameters)) = loading {
            case = case.with_path(name, parameters)?;
        }
        apply(&mut case, &settings)?;
        Ok(case)
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

fn apply(case: &mut Case, settings: &[Setting]) -> Result<(), Failure> {
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
    case.check().map_err(|error| match (error, settings) {
        (error, []) => Failure::from(error),
        (error, _) => {
            let flags: Vec<String> =
                settings.iter().map(|setting| format!("{}={}", setting.flag, setting.value)).collect();
            Failure::new(format!("with {}: {error}", flags.join(" ")))
        }
    })
}
