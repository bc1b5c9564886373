//! Named paths. A preset declares its parameters and expands to stages; it is one file and one line in [`ALL`].

mod constant_p;
mod constant_p_and_b;
mod drained_triaxial;
mod isotropic;
mod oedometer;
mod simple_shear;
mod simple_shear_constant_volume;
mod undrained_triaxial;

use std::collections::BTreeMap;

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

/// Every preset. A new one is a file and a line here.
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

/// The preset of that name.
pub fn named(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|preset| preset.name == name)
}

impl Preset {
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
    fn speed(&self) -> Speed {
        Speed::InertialNumber { number: self.number("inertial_number"), at: None }
    }

    /// Number of states to record.
    fn states(&self) -> usize {
        self.number("states") as usize
    }

    /// A stage that brings the sample to rest at the stress of a parameter, where it is given.
    fn consolidation(&self, key: &str) -> Option<Stage> {
        self.optional(key).map(|stress| consolidation(stress, self.number("inertial_number")))
    }
}

const INERTIAL_NUMBER: Parameter = Parameter {
    key: "inertial_number",
    unit: "1",
    help: "How fast: inertial number I of the driving strain rate at the mean stress at the start of the stage.",
    default: Default::Value(1e-3),
    bounds: [1e-8, 0.1],
};

const STATES: Parameter = Parameter {
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
