//! The description of a reproduction: the options that determine its results, which are written to its folder at the very
//! beginning.

use std::path::Path;

use granum_io::Error;
use granum_io::sealed::{unseal, unseal_strictly, write_sealed};
use granum_io::shell::{quoted, quoted_path};
use serde::{Deserialize, Serialize};

use crate::options::PaperOptions;
use granum_learn::Result;

/// File with the description of the reproduction in a folder.
pub const REPRODUCTION_FILE: &str = "reproduction.json";
/// Page with the computing times of a reproduction.
pub const SPEED_FILE: &str = "speed.html";
/// File with the numerical results of a reproduction; it is written last.
pub const SUMMARY_FILE: &str = "summary.json";
/// Folder of the runs.
pub const RUNS: &str = "runs";

const FORMAT: &str = "granum reproduction";
/// Version of the format. Version 1 had no SHA-256.
const VERSION: u64 = 2;

/// The options of `granum reproduce` that determine its results, in contrast to threads, instruction set and checkpoints.
///
/// A new option needs a field here and a line in [`ReproductionOptions::flags`]. An option that is missing in a file has its
/// default.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ReproductionOptions {
    /// True for fewer grains, fewer states and a faster test.
    pub quick: bool,
    /// Name of the trainer.
    pub trainer: String,
    /// Number of additional training runs for the same mappings; `None` for the default.
    pub training_runs: Option<usize>,
    /// Number of grains of every run; `None` for the default.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grains: Option<u64>,
}

impl Default for ReproductionOptions {
    fn default() -> Self {
        ReproductionOptions {
            quick: false,
            trainer: PaperOptions::default().trainer.name().to_owned(),
            training_runs: None,
            grains: None,
        }
    }
}

impl ReproductionOptions {
    /// The flags of the command line that differ from their defaults, with their values.
    fn flags(&self) -> Vec<(&'static str, Option<String>)> {
        let usual = ReproductionOptions::default();
        let mut flags = Vec::new();
        if self.quick {
            flags.push(("--quick", None));
        }
        if self.trainer != usual.trainer {
            flags.push(("--trainer", Some(self.trainer.clone())));
        }
        if let Some(runs) = self.training_runs {
            flags.push(("--training-runs", Some(runs.to_string())));
        }
        if let Some(grains) = self.grains {
            flags.push(("--grains", Some(grains.to_string())));
        }
        flags
    }

    /// The command line of this reproduction (with its output folder), quoted for use in a shell.
    pub fn command_line(&self, out: Option<&Path>) -> String {
        let mut line = "granum reproduce".to_string();
        for (flag, value) in self.flags() {
            line += &format!(" {flag}");
            if let Some(value) = value {
                line += &format!(" {}", quoted(&value));
            }
        }
        if let Some(out) = out {
            line += &format!(" --out {}", quoted_path(out));
        }
        line
    }

    /// The flags in which two sets of options differ.
    pub fn differences(&self, other: &ReproductionOptions) -> Vec<&'static str> {
        let (mine, theirs) = (self.flags(), other.flags());
        let only = |flags: &[(&'static str, Option<String>)], others: &[(&'static str, Option<String>)]| {
            flags.iter().filter(|flag| !others.contains(flag)).map(|flag| flag.0).collect::<Vec<_>>()
        };
        let mut names = only(&mine, &theirs);
        names.extend(only(&theirs, &mine));
        names.sort_unstable();
        names.dedup();
        names
    }
}

/// The description of the reproduction in a folder.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Reproduction {
    format: String,
    version: u64,
    /// Version of granum with which it was created.
    pub granum_version: String,
    /// Options of the reproduction.
    pub options: ReproductionOptions,
    /// Names of the folders of its runs.
    pub runs: Vec<String>,
}

impl Reproduction {
    /// The description of a reproduction with this version of granum.
    pub fn new(options: ReproductionOptions, runs: Vec<String>) -> Reproduction {
        Reproduction {
            format: FORMAT.into(),
            version: VERSION,
            granum_version: env!("CARGO_PKG_VERSION").into(),
            options,
            runs,
        }
    }

    /// Writes the file to a folder.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<()> {
        Ok(write_sealed(&folder.join(REPRODUCTION_FILE), self)?)
    }

    /// Reads the file of a folder; `None` if there is no such file.
    ///
    /// # Errors
    /// If the file is no regular file, is damaged, has another format, or names runs outside the folder.
    pub fn read(folder: &Path) -> Result<Option<Reproduction>> {
        let path = folder.join(REPRODUCTION_FILE);
        if !granum_io::is_there(&path)? {
            return Ok(None);
        }
        let text = granum_core::input::read_text(&path, granum_core::input::LARGEST_INPUT)
            .map_err(Error::file("read", &path))?;
        // Version 1 had no SHA-256. What is no JSON, or of another format, is told by the reader of the content.
        let version =
            serde_json::from_str::<serde_json::Value>(&text).ok().and_then(|value| value["version"].as_u64());
        let text = match version {
            Some(version) if version >= 2 => unseal_strictly(&path, &text)?,
            _ => unseal(&path, &text)?.text,
        };
        let of: Reproduction = serde_json::from_str(&text).map_err(|error| {
            let message =
                format!("does not describe a reproduction ({error}); it is damaged or from a newer granum");
            Error::content(&path, message)
        })?;
        if of.format != FORMAT || !(1..=VERSION).contains(&of.version) {
            let found = format!("format \"{}\" version {}", of.format, of.version);
            let wanted = format!("this program reads \"{FORMAT}\" up to version {VERSION}");
            return Err(Error::content(&path, format!("{found}, but {wanted}")).into());
        }
        for name in &of.runs {
            granum_io::check_name("runs", name).map_err(|error| Error::content(&path, error.to_string()))?;
        }
        Ok(Some(of))
    }

    /// The flags in which two reproductions differ, and the version of granum, with which results may change.
    pub fn differences(&self, other: &Reproduction) -> Vec<String> {
        let mut names: Vec<String> =
            self.options.differences(&other.options).into_iter().map(String::from).collect();
        if self.granum_version != other.granum_version {
            names.push(format!(
                "the version of granum ({}, not {})",
                self.granum_version, other.granum_version
            ));
        }
        names
    }

    /// True if it was created with this version of granum.
    pub fn is_of_this_version(&self) -> bool {
        self.granum_version == env!("CARGO_PKG_VERSION")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options(quick: bool, trainer: &str) -> ReproductionOptions {
        ReproductionOptions { quick, trainer: trainer.into(), ..Default::default() }
    }

    #[test]
    fn the_command_line_has_what_differs_from_the_defaults() {
        let line = |options: ReproductionOptions, out: &str| options.command_line(Some(Path::new(out)));
        assert_eq!(
            line(ReproductionOptions::default(), "reproduction"),
            "granum reproduce --out reproduction"
        );
        assert_eq!(
            line(options(true, "traingdx"), "my study"),
            "granum reproduce --quick --trainer traingdx --out 'my study'"
        );
        assert_eq!(options(true, "levenberg-marquardt").command_line(None), "granum reproduce --quick");
    }

    #[test]
    fn differences_are_told_by_flag() {
        let usual = ReproductionOptions::default();
        assert!(usual.differences(&usual).is_empty());
        assert_eq!(usual.differences(&options(true, &usual.trainer)), ["--quick"]);
        assert_eq!(options(true, "traingdx").differences(&options(true, "other")), ["--trainer"]);
        assert_eq!(options(true, "traingdx").differences(&usual), ["--quick", "--trainer"]);
    }

    #[test]
    fn a_record_comes_back_and_one_that_cannot_be_read_says_why() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path();
        assert_eq!(Reproduction::read(folder).unwrap(), None);
        let of = Reproduction::new(options(true, "traingdx"), vec!["training-11".into()]);
        of.write(folder).unwrap();
        assert_eq!(Reproduction::read(folder).unwrap(), Some(of));
        let path = folder.join(REPRODUCTION_FILE);
        let whole = std::fs::read_to_string(&path).unwrap();
        // A file of version 1, which had no SHA-256.
        let text = whole.split(",\n  \"sha256\"").next().unwrap().to_string() + "\n}";
        let text = text.replace("\"version\": 2", "\"version\": 1");
        let message = |text: String| {
            std::fs::write(&path, text).unwrap();
            Reproduction::read(folder).unwrap_err().to_string()
        };
        assert!(message(text.replace("\"quick\"", "\"slow\"")).contains("unknown field `slow`"));
        assert!(
            message(text.replace("\"version\": 1", "\"version\": 0")).contains("version 0, but this program")
        );
        assert!(message(text.replace("training-11", "../x")).contains("cannot be part of a file name"));
        assert!(message(whole.replace("training-11", "training-12")).contains("was changed or damaged"));
        // An option that is missing in a file has its default.
        std::fs::write(&path, text.replace("\"quick\": true,", "")).unwrap();
        assert_eq!(Reproduction::read(folder).unwrap().unwrap().options, options(false, "traingdx"));
    }
}
