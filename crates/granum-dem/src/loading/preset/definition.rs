//! The definition of a named path: its parameters, the values given to them, and the stages to which it expands.

use granum_core::RegistrationError;

use super::parameter::{
    COMMON, DENSITY_SCALING, Given, INERTIAL_NUMBER, PathFault, PathParameter, PathParameterDefault,
    PathValue, STATES, STRAIN_RATE,
};
use crate::loading::{Control, Drive, History, Speed, Stage, Target, Until};

/// A named path.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// Description of the path, in one or two sentences.
    pub help: &'static str,
    /// Its parameters in addition to those of every preset ([`Preset::parameters`]).
    pub own: &'static [PathParameter],
    /// What is wrong with its parameters together, such as two that exclude each other.
    pub faults: fn(&PathValues) -> Option<PathFault>,
    /// Its stages.
    pub stages: fn(&PathValues) -> Vec<Stage>,
}

/// Two presets are equal if their names and declarations are.
impl PartialEq for Preset {
    fn eq(&self, other: &Preset) -> bool {
        (self.name, self.help, self.own) == (other.name, other.help, other.own)
    }
}

/// Keys of a stage in a case file that no parameter of a path may have.
const RESERVED: [&str; 4] = ["path", "stage", "repeat", "resets"];

impl Preset {
    /// A path of the given name, with its own parameters and a function that returns its stages.
    pub const fn new(
        name: &'static str,
        help: &'static str,
        own: &'static [PathParameter],
        stages: fn(&PathValues) -> Vec<Stage>,
    ) -> Preset {
        Preset { name, help, own, faults: |_| None, stages }
    }

    /// The same with a check of its parameters together.
    pub const fn refusing(self, faults: fn(&PathValues) -> Option<PathFault>) -> Preset {
        Preset { faults, ..self }
    }

    /// What is wrong with parameters together, if anything is.
    pub fn fault(&self, given: &Given) -> Option<PathFault> {
        let values = PathValues { preset: self, given };
        values.not_whole(STATES.key).or_else(|| (self.faults)(&values))
    }

    pub(super) fn is_same_as(&self, other: &Preset) -> bool {
        self == other && std::ptr::fn_addr_eq(self.stages, other.stages)
    }

    /// Checks the declarations of its parameters.
    pub(super) fn check(&self) -> Result<(), RegistrationError> {
        for (k, PathParameter { key, default, bounds, .. }) in self.own.iter().enumerate() {
            // Keys of a stage have a meaning already, and a key that is declared twice would have two.
            let is_taken = RESERVED.contains(key) || self.own[..k].iter().any(|other| other.key == *key);
            RegistrationError::check_key("path", self.name, "parameter", key, is_taken)?;
            let [low, high] = *bounds;
            let inside = match default {
                PathParameterDefault::Value(value) => (low..=high).contains(value),
                PathParameterDefault::List(values) => values.iter().all(|value| (low..=high).contains(value)),
                PathParameterDefault::Word(_)
                | PathParameterDefault::Absent(_)
                | PathParameterDefault::Needed => low <= high,
            };
            if !inside {
                let (what, name) = ("path", self.name.to_string());
                let reason = format!(
                    "its parameter {key:?} has a default outside its bounds, or bounds that do not increase; mend the declaration"
                );
                return Err(RegistrationError::Declaration { what, name, reason });
            }
        }
        Ok(())
    }

    /// All parameters: its own, and those of every preset.
    pub fn parameters(&self) -> impl Iterator<Item = &'static PathParameter> + Clone {
        let own = self.own;
        let common = COMMON.iter().filter(move |common| !own.iter().any(|known| known.key == common.key));
        own.iter().chain(common)
    }

    /// The parameter of a given key.
    pub fn parameter(&self, key: &str) -> Option<&'static PathParameter> {
        self.parameters().find(|parameter| parameter.key == key)
    }

    /// Its stages with the given parameters; the others have their defaults.
    pub fn expand(&self, given: &Given) -> Vec<Stage> {
        let values = PathValues { preset: self, given };
        let mut stages = (self.stages)(&values);
        let scaling = values.optional(DENSITY_SCALING.key).unwrap_or(1.0);
        for stage in &mut stages {
            if matches!(stage.control.speed, Speed::StrainRate(_)) && !stage.is_mark() {
                stage.density_scaling = scaling;
            }
        }
        stages
    }
}

impl PathValues<'_> {
    /// The stress given by a parameter; if it is not given, the stress of the sample at the start of the stage.
    pub fn target(&self, key: &str) -> Target {
        self.optional(key).map_or_else(Target::current, Target::held)
    }

    /// A stage that brings the sample to rest at the stress given by a parameter, if it is given.
    pub fn consolidation(&self, key: &str) -> Option<Stage> {
        self.optional(key).map(|stress| consolidation(stress, self.number(INERTIAL_NUMBER.key)))
    }
}

/// Unbalanced force below which a sample is at rest.
pub(super) const AT_REST: f64 = 1e-3;

/// All three axes are brought to a given stress, and the sample comes to rest there.
pub(super) fn consolidation(stress: f64, inertial_number: f64) -> Stage {
    let held = Drive::Stress(Target::held(stress));
    let fixed = Drive::Fixed;
    let speed = Speed::InertialNumber { number: inertial_number, at: None };
    let control =
        Control { servo_limit: 1.0, ..Control::new(speed, [held, held, held, fixed, fixed, fixed]) };
    let rest = Until::AtRest { unbalanced_force: AT_REST };
    Stage { settling: true, ..Stage::new("consolidation", control, vec![rest]) }
}

/// A large bound on the arc length of a test, after which it is considered not to reach its end.
pub(super) fn generous(strain: f64) -> Option<f64> {
    Some(4.0 * strain.abs() + 0.01)
}

/// The parameters of a preset, given or default.
pub struct PathValues<'a> {
    pub(super) preset: &'a Preset,
    pub(super) given: &'a Given,
}

impl<'a> PathValues<'a> {
    fn default(&self, key: &str) -> Option<PathParameterDefault> {
        self.preset.parameter(key).map(|parameter| parameter.default)
    }

    /// A number that may be left out.
    pub fn optional(&self, key: &str) -> Option<f64> {
        match (self.given.get(key), self.default(key)) {
            (Some(PathValue::Number(number)), _) => Some(*number),
            (_, Some(PathParameterDefault::Value(number))) => Some(number),
            _ => None,
        }
    }

    /// True if the key is given, so that no default takes its place.
    pub fn is_given(&self, key: &str) -> bool {
        self.given.contains_key(key)
    }

    /// The fault that a key is given which has no effect with another one.
    pub fn both(&self, key: &'static str, with: &str) -> Option<PathFault> {
        let both = self.is_given(key) && self.is_given(with);
        both.then(|| (key, format!("{key} has no effect with {with}; keep one of them")))
    }

    /// The fault that an end is zero, at which the path would be over before it begins.
    pub fn zero(&self, key: &'static str) -> Option<PathFault> {
        (self.number(key) == 0.0).then(|| (key, format!("{key} must not be 0, where the path begins")))
    }

    /// The fault that a number of things is not whole.
    pub fn not_whole(&self, key: &'static str) -> Option<PathFault> {
        let value = self.optional(key)?;
        (value.fract() != 0.0).then(|| (key, format!("{key} = {value} must be a whole number")))
    }

    /// A number that has a default.
    pub fn number(&self, key: &str) -> f64 {
        self.optional(key).unwrap_or(f64::NAN)
    }

    /// True if a word was chosen.
    pub fn is(&self, key: &str, word: &str) -> bool {
        match (self.given.get(key), self.default(key)) {
            (Some(PathValue::Word(given)), _) => given == word,
            (_, Some(PathParameterDefault::Word(default))) => default == word,
            _ => false,
        }
    }

    /// The numbers of a list.
    pub fn list(&self, key: &str) -> &[f64] {
        match (self.given.get(key), self.default(key)) {
            (Some(PathValue::List(list)), _) => list,
            (_, Some(PathParameterDefault::List(list))) => list,
            _ => &[],
        }
    }

    /// A history, where one is given.
    pub fn history(&self, key: &str) -> Option<&'a History> {
        match self.given.get(key) {
            Some(PathValue::History(history)) => Some(history),
            _ => None,
        }
    }

    /// The speed that is given by the parameter `strain_rate` or `inertial_number`.
    pub fn speed(&self) -> Speed {
        match self.optional(STRAIN_RATE.key) {
            Some(rate) => Speed::StrainRate(rate),
            None => Speed::InertialNumber { number: self.number(INERTIAL_NUMBER.key), at: None },
        }
    }

    /// Number of states to record.
    pub fn states(&self) -> usize {
        self.number("states") as usize
    }
}
