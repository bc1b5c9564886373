//! The configuration of user materials: a small TOML file that names cases, samples and surrogates.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use granum_core::input::{self, LARGEST_INPUT};
use granum_point::{BeyondLargest, Controls, Tangent, Trust};
use serde::Deserialize;

use super::component_order::ComponentOrder;
use crate::failure::Failure;

/// The configuration of user materials.
///
/// ```toml
/// host = "kratos"            # order of the shear components: kratos (xy yz xz; PLAXIS too) or abaqus (12 13 23)
///
/// [[material]]               # PROPS(1) = 1 is the first one
/// case = "sand.toml"         # beside this file; or `sample`, a folder that `granum prepare` made
///
/// [[material]]               # a surrogate that `granum train` made, in place of grains
/// surrogate = "sand.json"
/// inputs = { "sample.void_ratio" = 0.62 }
/// initial_stress = "sample"
///
/// [[material]]               # both: the surrogate answers while it knows, grains where it does not
/// surrogate = "sand.json"
/// case = "sand.toml"
/// largest_trusted_deviation = 0.1
/// initial_stress = "sample"
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Configuration {
    /// The order of components of the host.
    pub host: ComponentOrder,
    /// Pascals in a unit of stress of the host: 1 where it computes in Pa, 1000 where in kPa.
    #[serde(default = "one")]
    pub pascals_per_unit: f64,
    /// File of states that is read when the configuration is opened, if it is there; beside this file.
    #[serde(default)]
    pub restart: Option<PathBuf>,
    /// The materials, by their numbers from 1.
    #[serde(rename = "material")]
    pub materials: Vec<MaterialConfiguration>,
}

fn one() -> f64 {
    1.0
}

/// The stress with which a point begins.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum InitialStress {
    /// The one that the host gives at the first call, also if it is zero.
    #[default]
    Host,
    /// That of the sample, if the host gives none.
    Sample,
}

/// How the stiffness is found that the host gets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum TangentKind {
    /// [`Tangent::Affine`] of the state at the beginning of the increment.
    Affine,
    /// [`Tangent::Elastic`] of the state at the beginning of the increment.
    Elastic,
    /// [`Tangent::Probes`] of the state at the end of the increment.
    Probes,
    /// [`Tangent::Secant`] of the state at the end of the increment.
    #[default]
    Secant,
}

/// One material.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MaterialConfiguration {
    /// Case file of the sample.
    #[serde(default)]
    pub case: Option<PathBuf>,
    /// Folder of a sample that was prepared, instead.
    #[serde(default)]
    pub sample: Option<PathBuf>,
    /// File of a surrogate, instead or beside it.
    #[serde(default)]
    pub surrogate: Option<PathBuf>,
    /// Beside a case or a sample: the largest standard deviation of a stress over the mean stress up to which the surrogate answers. Beyond it, and outside of what it was
    /// trained on, grains do.
    pub largest_trusted_deviation: Option<f64>,
    /// True if grains that take over from a surrogate are brought to its last stress, so that what the host computes stays in equilibrium.
    #[serde(default)]
    pub takeover_keeps_stress: bool,
    /// The values of those inputs of the surrogate that are no strains; beside a case or a sample those of its state are measured.
    #[serde(default)]
    pub inputs: BTreeMap<String, f64>,
    /// Number of samples of a case, which differ in their seed: the name of a point modulo this number chooses one.
    #[serde(default = "one_sample")]
    pub samples: u64,
    /// The stress with which a point begins.
    #[serde(default)]
    pub initial_stress: InitialStress,
    /// How the stiffness is found.
    #[serde(default)]
    pub tangent: TangentKind,
    /// Size of the strains of probes.
    #[serde(default = "usual_probe")]
    pub probe_strain: f64,
    /// Inertial number of the straining.
    pub inertial_number: Option<f64>,
    /// Steps of relaxation after an increment.
    pub relaxation: Option<u64>,
    /// Steps over which the stress is averaged.
    pub averaging: Option<u64>,
    /// Largest size of an increment in one piece.
    pub largest_increment: Option<f64>,
    /// True to answer a larger one with NaN, so that the host takes a smaller step, instead of dividing it.
    #[serde(default)]
    pub refuse_larger: bool,
    /// Size from which on an increment is refused in any case.
    pub absurd_increment: Option<f64>,
    /// Mean stress, Pa, whose strain rate is the smallest one.
    pub least_mean_stress: Option<f64>,
    /// Largest number of steps of an increment.
    pub most_steps: Option<u64>,
}

fn one_sample() -> u64 {
    1
}

fn usual_probe() -> f64 {
    1e-5
}

impl MaterialConfiguration {
    /// What is wrong with its keys.
    fn check(&self) -> Result<(), String> {
        let grains = [&self.case, &self.sample].into_iter().flatten().count();
        let is_one = match (grains, self.surrogate.is_some(), self.largest_trusted_deviation) {
            (1, false, None) | (0, true, None) => true,
            (1, true, Some(largest_deviation)) => {
                let trust = Trust::up_to(largest_deviation);
                trust.check().map_err(|error| format!("cannot be trusted so: {error}"))?;
                true
            }
            _ => false,
        };
        if !is_one {
            return Err(
                "must have either a case or a sample or a surrogate; or a surrogate beside one of the others with largest_trusted_deviation, up to which it answers"
                    .to_string(),
            );
        }
        if self.takeover_keeps_stress && self.largest_trusted_deviation.is_none() {
            return Err(
                ": takeover_keeps_stress needs largest_trusted_deviation, beyond which grains take over"
                    .to_string(),
            );
        }
        if self.samples == 0 || (self.samples > 1 && self.case.is_none()) {
            return Err(": samples must be at least 1, and 1 for what is no case".to_string());
        }
        let Some(_) = &self.surrogate else {
            return match self.inputs.keys().next() {
                Some(name) => Err(format!("has the input {name} without a surrogate")),
                None => Ok(()),
            };
        };
        if matches!(self.tangent, TangentKind::Affine | TangentKind::Elastic) {
            return Err("has a surrogate, whose tangent is \"probes\" or \"secant\"".to_string());
        }
        Ok(())
    }

    /// The controls of its points.
    pub fn controls(&self) -> Controls {
        Controls::default().with(|controls| {
            controls.inertial_number = self.inertial_number.unwrap_or(controls.inertial_number);
            controls.relaxation = self.relaxation.unwrap_or(controls.relaxation);
            // A shorter relaxation than the usual average shortens the average.
            controls.averaging = self.averaging.unwrap_or(controls.averaging.min(controls.relaxation));
            controls.largest_increment = self.largest_increment.unwrap_or(controls.largest_increment);
            controls.absurd_increment = self.absurd_increment.unwrap_or(controls.absurd_increment);
            controls.most_steps = self.most_steps.unwrap_or(controls.most_steps);
            controls.least_mean_stress = self.least_mean_stress;
            if self.refuse_larger {
                controls.beyond_largest = BeyondLargest::Refuse;
            }
        })
    }

    /// The stiffness that it asks for.
    pub fn tangent(&self) -> Tangent {
        match self.tangent {
            TangentKind::Affine => Tangent::Affine,
            TangentKind::Elastic => Tangent::Elastic,
            TangentKind::Probes => Tangent::Probes { strain: self.probe_strain },
            TangentKind::Secant => Tangent::Secant,
        }
    }
}

impl Configuration {
    /// Reads and checks a file.
    ///
    /// # Errors
    /// [`Failure::File`] with the line of a mistake.
    pub fn read(path: &Path) -> Result<Configuration, Failure> {
        let wrong = |what: String| Failure::File { path: path.to_path_buf(), what };
        let text = input::read_text(path, LARGEST_INPUT).map_err(|error| wrong(error.to_string()))?;
        let configuration: Configuration = toml::from_str(&text).map_err(|error| wrong(error.to_string()))?;
        let unit = configuration.pascals_per_unit;
        if !(unit > 0.0 && unit.is_finite()) {
            return Err(wrong(format!("pascals_per_unit is {unit}; it must be positive")));
        }
        for (k, material) in configuration.materials.iter().enumerate() {
            let number = k + 1;
            material.check().map_err(|what| wrong(format!("material {number} {what}")))?;
            material.controls().check().map_err(|error| wrong(format!("material {number}: {error}")))?;
        }
        if configuration.materials.is_empty() {
            return Err(wrong("there is no [[material]]".to_string()));
        }
        Ok(configuration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Configuration, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("granum-materials.toml");
        std::fs::write(&path, text).unwrap();
        Configuration::read(&path).map_err(|error| error.to_string())
    }

    #[test]
    fn mistakes_are_named() {
        let good = read("host = 'abaqus'\n[[material]]\ncase = 'sand.toml'\ntangent = 'elastic'").unwrap();
        assert_eq!(good.host, ComponentOrder::Abaqus);
        assert_eq!(good.materials[0].tangent(), Tangent::Elastic);
        let refused = |text: &str, word: &str| {
            let error = read(text).unwrap_err();
            assert!(error.contains(word) && error.contains("granum-materials.toml"), "{error}");
        };
        refused("host = 'ansys'\n[[material]]\ncase = 'a'", "ansys");
        refused("host = 'kratos'\nmaterial = []", "no [[material]]");
        refused("host = 'kratos'\n[[material]]\ncase = 'a'\nsample = 'b'", "either");
        refused("host = 'kratos'\n[[material]]\ncase = 'a'\ninertial = 1", "inertial");
        refused("host = 'kratos'\n[[material]]\ncase = 'a'\ninertial_number = 3.0", "inertial number");
        refused("host = 'kratos'\npascals_per_unit = -1.0\n[[material]]\ncase = 'a'", "pascals_per_unit");
        refused("host = 'kratos'\n[[material]]\nsample = 'a'\nsamples = 3", "samples");
        refused("host = 'kratos'\n[[material]]\ncase = 'a'\nsurrogate = 'b'", "either");
        let both = "host = 'kratos'\n[[material]]\ncase = 'a'\nsurrogate = 'b'\ninitial_stress = 'sample'";
        refused(both, "largest_trusted_deviation");
        assert!(read(&format!("{both}\nlargest_trusted_deviation = 0.1")).is_ok());
        refused(&format!("{both}\nlargest_trusted_deviation = -0.1"), "largest trusted deviation");
        assert!(
            read(&format!("{both}\nlargest_trusted_deviation = 0.1\ntakeover_keeps_stress = true")).is_ok()
        );
        refused(
            "host = 'kratos'\n[[material]]\ncase = 'a'\ntakeover_keeps_stress = true",
            "needs largest_trusted_deviation",
        );
        refused(&format!("{both}\nlargest_trusted_deviation = 0.1\nsample = 'c'"), "either");
        refused(&format!("{both}\nlargest_trusted_deviation = 0.1\ntangent = 'elastic'"), "probes");
        refused("host = 'kratos'\n[[material]]\ncase = 'a'\nlargest_trusted_deviation = 0.1", "either");
        refused("host = 'kratos'\n[[material]]\nsurrogate = 'b'\nlargest_trusted_deviation = 0.1", "either");
        assert!(read("host = 'kratos'\n[[material]]\nsurrogate = 'b'").is_ok());
        let surrogate = "host = 'kratos'\n[[material]]\nsurrogate = 'b'\ninitial_stress = 'sample'";
        assert!(read(surrogate).is_ok());
        refused(&format!("{surrogate}\ntangent = 'affine'"), "probes");
        refused(
            "host = 'kratos'\n[[material]]\ncase = 'a'\ninputs = { 'sample.void_ratio' = 0.6 }",
            "sample.void_ratio",
        );
    }
}
