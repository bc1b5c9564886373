//! Named paths. A preset declares its parameters and expands to stages; it is one file and one line in [`ALL`], and a program
//! adds its own with [`register`].

mod constant_p;
mod constant_p_and_b;
mod drained_triaxial;
mod isotropic;
mod oedometer;
mod simple_shear;
mod simple_shear_constant_volume;
mod undrained_triaxial;

use std::collections::BTreeMap;
use std::sync::{PoisonError, RwLock};

use super::{Control, Drive, Speed, Stage, Target, Until};

pub use self::constant_p::antony2006;

/// A number that a preset takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter {
    /// Its key in a case file.
    pub key: &'static str,
    /// Its SI unit; `1` for a number.
    pub unit: &'static str,
    /// What it is, in one or two sentences.
    pub help: &'static str,
    /// Its default; `None` where it may be left out, with what then holds.
    pub default: Default,
    /// Smallest and largest value.
    pub bounds: [f64; 2],
}

/// What holds where a parameter is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    /// This value.
    Value(f64),
    /// What this sentence says.
    Absent(&'static str),
}

/// A named path.
#[derive(Clone, Copy, Debug)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// What it is, in one or two sentences.
    pub help: &'static str,
    /// The numbers that it takes.
    pub parameters: &'static [Parameter],
    /// Its stages.
    pub stages: fn(&Values) -> Vec<Stage>,
}

/// granum's own presets. A new one is a file and a line here.
pub const ALL: &[Preset] = &[
    constant_p::PRESET,
    isotropic::PRESET,
    drained_triaxial::PRESET,
    undrained_triaxial::PRESET,
    constant_p_and_b::PRESET,
    oedometer::PRESET,
    simple_shear::PRESET,
    simple_shear_constant_volume::PRESET,
];

/// Presets of the caller's own.
static OWN: RwLock<Vec<&'static Preset>> = RwLock::new(Vec::new());

/// Every preset that a name can stand for: granum's, then those of [`register`].
pub fn all() -> Vec<&'static Preset> {
    let own = OWN.read().unwrap_or_else(PoisonError::into_inner);
    ALL.iter().chain(own.iter().copied()).collect()
}

/// The preset of that name.
pub fn named(name: &str) -> Option<&'static Preset> {
    all().into_iter().find(|preset| preset.name == name)
}

/// A preset that cannot be registered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RegisterError {
    /// Its name stands for another preset.
    #[error("there is already a path {name:?}: give the new one another name")]
    NameTaken {
        /// The name.
        name: &'static str,
    },
    /// A key is used twice, or has a meaning of its own in a stage.
    #[error(
        "the path {path:?} has the parameter {key:?} twice, or it is the key of the path's name: choose another key"
    )]
    KeyTaken {
        /// The path.
        path: &'static str,
        /// The key.
        key: &'static str,
    },
    /// The default of a parameter is out of its bounds, or the bounds are not in order.
    #[error("the path {path:?} has the parameter {key:?} with a default outside its bounds, which must rise")]
    OutOfBounds {
        /// The path.
        path: &'static str,
        /// The key.
        key: &'static str,
    },
}

/// Lets a name in case files stand for a path of the caller's own.
///
/// ```
/// use granum_dem::loading::preset::{INERTIAL_NUMBER, Preset, named, register};
/// use granum_dem::loading::{Control, Drive, Measure, Stage, Until};
///
/// const PLANE_STRAIN: Preset = Preset {
///     name: "plane-strain-at-constant-lateral-stress",
///     help: "Axis x is compressed, the stress along y is held, and z is fixed.",
///     parameters: &[INERTIAL_NUMBER],
///     stages: |values| {
///         let (fixed, held) = (Drive::Fixed, Drive::Stress(Default::default()));
///         let control = Control::of(values.speed(), [Drive::Rate(1.0), held, fixed, fixed, fixed, fixed]);
///         vec![Stage::new("compression", control, vec![Until::Reaches { measure: Measure::Strain(0), value: 0.1 }])]
///     },
/// };
/// register(&PLANE_STRAIN)?;
/// assert!(named("plane-strain-at-constant-lateral-stress").is_some());
/// # Ok::<(), granum_dem::loading::preset::RegisterError>(())
/// ```
///
/// # Errors
/// If the name stands for another path, or a parameter is declared twice or with a default outside its bounds.
pub fn register(preset: &'static Preset) -> Result<(), RegisterError> {
    match named(preset.name) {
        Some(known) if known.is_same_as(preset) => return Ok(()),
        Some(_) => return Err(RegisterError::NameTaken { name: preset.name }),
        None => preset.check()?,
    }
    OWN.write().unwrap_or_else(PoisonError::into_inner).push(preset);
    Ok(())
}

impl Preset {
    fn is_same_as(&self, other: &Preset) -> bool {
        (self.name, self.help, self.parameters) == (other.name, other.help, other.parameters)
            && std::ptr::fn_addr_eq(self.stages, other.stages)
    }

    /// Whether its parameters can be.
    fn check(&self) -> Result<(), RegisterError> {
        for (k, Parameter { key, default, bounds, .. }) in self.parameters.iter().enumerate() {
            if *key == "path" || self.parameters[..k].iter().any(|other| other.key == *key) {
                return Err(RegisterError::KeyTaken { path: self.name, key });
            }
            let [low, high] = *bounds;
            let inside = match default {
                Default::Value(value) => (low..=high).contains(value),
                Default::Absent(_) => low <= high,
            };
            if !inside {
                return Err(RegisterError::OutOfBounds { path: self.name, key });
            }
        }
        Ok(())
    }

    /// The parameter of that key.
    pub fn parameter(&self, key: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.key == key)
    }

    /// Its stages with these parameters; those not given have their defaults.
    pub fn expand(&self, given: &BTreeMap<String, f64>) -> Vec<Stage> {
        (self.stages)(&Values { preset: self, given })
    }
}

/// The parameters of a preset, given or by default.
pub struct Values<'a> {
    preset: &'a Preset,
    given: &'a BTreeMap<String, f64>,
}

impl Values<'_> {
    /// A parameter that may be left out.
    pub fn optional(&self, key: &str) -> Option<f64> {
        let default = self.preset.parameter(key).map(|parameter| parameter.default);
        self.given.get(key).copied().or(match default {
            Some(Default::Value(value)) => Some(value),
            _ => None,
        })
    }

    /// A parameter that has a default.
    pub fn number(&self, key: &str) -> f64 {
        self.optional(key).unwrap_or(f64::NAN)
    }

    /// The speed that the parameter `inertial_number` says.
    pub fn speed(&self) -> Speed {
        Speed::InertialNumber { number: self.number("inertial_number"), at: None }
    }

    /// Number of states to record, as the parameter `states` says.
    pub fn states(&self) -> usize {
        self.number("states") as usize
    }

    /// A stage that brings the sample to rest at the stress of a parameter, where it is given.
    pub fn consolidation(&self, key: &str) -> Option<Stage> {
        self.optional(key).map(|stress| consolidation(stress, self.number("inertial_number")))
    }
}

/// How fast a path goes, for [`Values::speed`].
pub const INERTIAL_NUMBER: Parameter = Parameter {
    key: "inertial_number",
    unit: "1",
    help: "How fast: inertial number I of the driving strain rate at the mean stress at the start of the stage.",
    default: Default::Value(1e-3),
    bounds: [1e-8, 0.1],
};

/// How many states a path records, for [`Values::states`].
pub const STATES: Parameter = Parameter {
    key: "states",
    unit: "1",
    help: "Number of equal intervals at whose ends a state is recorded.",
    default: Default::Value(100.0),
    bounds: [1.0, 1e6],
};

/// A stress to which the sample is brought before the test.
const fn stress(key: &'static str, help: &'static str) -> Parameter {
    Parameter { key, unit: "Pa", help, default: Default::Absent("that of the sample"), bounds: [1e-3, 1e11] }
}

const fn number(key: &'static str, help: &'static str, default: f64, bounds: [f64; 2]) -> Parameter {
    Parameter { key, unit: "1", help, default: Default::Value(default), bounds }
}

/// Unbalanced force below which a sample is at rest.
const AT_REST: f64 = 1e-3;

/// All three axes are brought to a stress, and the sample to rest there.
fn consolidation(stress: f64, inertial_number: f64) -> Stage {
    let held = Drive::Stress(Target { value: Some(stress), rate: 0.0 });
    let fixed = Drive::Fixed;
    let speed = Speed::InertialNumber { number: inertial_number, at: None };
    let control = Control { servo_limit: 1.0, ..Control::of(speed, [held, held, held, fixed, fixed, fixed]) };
    let rest = Until::AtRest { unbalanced_force: AT_REST };
    Stage { settling: true, ..Stage::new("consolidation", control, vec![rest]) }
}

/// A strain from which a test may go further than asked before it counts as one that does not end.
fn generous(strain: f64) -> Option<f64> {
    Some(4.0 * strain.abs() + 0.01)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_would_mislead_are_refused() {
        const OWN: Preset = Preset {
            name: "test-of-registration",
            help: "A path of one's own.",
            parameters: &[INERTIAL_NUMBER],
            stages: |_| Vec::new(),
        };
        assert_eq!(register(&OWN), Ok(()));
        assert_eq!(register(&OWN), Ok(()), "once more is no harm");
        assert!(all().len() > ALL.len() && named(OWN.name).is_some());
        const TAKEN: Preset = Preset { name: "oedometer", ..OWN };
        assert_eq!(register(&TAKEN), Err(RegisterError::NameTaken { name: "oedometer" }));
        const TWICE: Preset = Preset { name: "twice", parameters: &[STATES, STATES], ..OWN };
        assert!(matches!(register(&TWICE), Err(RegisterError::KeyTaken { key: "states", .. })));
        const OUTSIDE: Preset = Preset {
            name: "outside",
            parameters: &[Parameter { default: super::Default::Value(0.0), ..STATES }],
            ..OWN
        };
        assert!(matches!(register(&OUTSIDE), Err(RegisterError::OutOfBounds { key: "states", .. })));
        assert!(named("twice").is_none() && named("outside").is_none());
    }

    #[test]
    fn every_preset_expands_to_stages_that_can_be_and_end() {
        for preset in ALL {
            assert_eq!(named(preset.name).map(|p| p.name), Some(preset.name));
            assert!(preset.help.ends_with('.'));
            let mut given = BTreeMap::new();
            for round in 0..2 {
                let stages = preset.expand(&given);
                assert!(!stages.is_empty());
                for stage in &stages {
                    assert_eq!(stage.control.check(), Ok(()), "{}", preset.name);
                    assert!(!stage.until.is_empty() && stage.most_arc_length.is_some(), "{}", preset.name);
                    // NaN would be no equal of itself.
                    assert_eq!(stage, &stage.clone(), "{}", preset.name);
                }
                for parameter in preset.parameters {
                    let [low, high] = parameter.bounds;
                    assert!(low < high && parameter.help.ends_with('.'), "{}", parameter.key);
                    match parameter.default {
                        Default::Value(value) => assert!((low..=high).contains(&value)),
                        Default::Absent(_) if round == 0 => {
                            given.insert(parameter.key.to_string(), low.max(1e5).min(high));
                        }
                        Default::Absent(_) => {}
                    }
                }
            }
        }
    }
}
