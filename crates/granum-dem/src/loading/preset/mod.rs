//! Named paths. A preset declares its parameters and expands to stages; it is one file and one line in [`ALL`].

mod constant_p;
mod constant_p_and_b;
mod cyclic;
mod drained_triaxial;
mod history;
mod hold;
mod isotropic;
mod oedometer;
mod parameter;
mod plane_strain;
mod probes;
mod proportional;
mod simple_shear;
mod simple_shear_constant_volume;
mod undrained_triaxial;
mod unload_reload;

use super::{Control, Drive, Speed, Stage, Target, Until};

pub use self::constant_p::antony2006;
use self::parameter::{
    COMMON, DENSITY_SCALING, INERTIAL_NUMBER, INTERVAL, STATES, deviator, number, optional, stress, word,
};
pub use self::parameter::{Default, Given, Kind, Parameter, Value, Values};

/// A named path.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// What it is, in one or two sentences.
    pub help: &'static str,
    /// What it takes beside what every preset takes ([`Preset::parameters`]).
    pub own: &'static [Parameter],
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
    plane_strain::PRESET,
    proportional::PRESET,
    cyclic::PRESET,
    unload_reload::PRESET,
    hold::PRESET,
    history::PRESET,
    probes::PRESET,
];

/// The preset of that name.
pub fn named(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|preset| preset.name == name)
}

impl Preset {
    /// Everything that it takes: its own parameters, and those of every preset.
    pub fn parameters(&self) -> impl Iterator<Item = &'static Parameter> + Clone {
        let own = self.own;
        let common = COMMON.iter().filter(move |common| !own.iter().any(|known| known.key == common.key));
        own.iter().chain(common)
    }

    /// The parameter of that key.
    pub fn parameter(&self, key: &str) -> Option<&'static Parameter> {
        self.parameters().find(|parameter| parameter.key == key)
    }

    /// Its stages with these parameters; those not given have their defaults.
    pub fn expand(&self, given: &Given) -> Vec<Stage> {
        let values = Values { preset: self, given };
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

impl Values<'_> {
    /// The stress of a parameter, or what it is when the stage begins.
    fn target(&self, key: &str) -> Target {
        self.optional(key).map_or_else(Target::current, Target::held)
    }

    /// A stage that brings the sample to rest at the stress of a parameter, where it is given.
    fn consolidation(&self, key: &str) -> Option<Stage> {
        self.optional(key).map(|stress| consolidation(stress, self.number(INERTIAL_NUMBER.key)))
    }
}

/// Unbalanced force below which a sample is at rest.
const AT_REST: f64 = 1e-3;

/// All three axes are brought to a stress, and the sample to rest there.
fn consolidation(stress: f64, inertial_number: f64) -> Stage {
    let held = Drive::Stress(Target::held(stress));
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
    use crate::loading::{History, Quantity, Start};

    /// A value for a parameter that has no default.
    fn example(parameter: &Parameter) -> Value {
        match parameter.kind {
            Kind::History => {
                let columns = vec![Quantity::Strain(0), Quantity::Stress(1)];
                Value::History(History { columns, rows: vec![vec![0.0, 1e5], vec![0.01, 1e5]] })
            }
            _ => Value::Number(parameter.bounds[0].max(1e5).min(parameter.bounds[1])),
        }
    }

    fn assert_sound(preset: &Preset, given: &Given) {
        let stages = preset.expand(given);
        assert!(!stages.is_empty(), "{}", preset.name);
        let mut kept = false;
        for stage in &stages {
            assert_eq!(stage.control.check(), Ok(()), "{} {}", preset.name, stage.name);
            assert!(!stage.until.is_empty() && stage.most_arc_length.is_some(), "{}", preset.name);
            // NaN would be no equal of itself.
            assert_eq!(stage, &stage.clone(), "{}", preset.name);
            kept |= stage.start == Start::Kept;
            assert!(stage.start != Start::Back || kept, "{}: nothing to go back to", preset.name);
        }
    }

    #[test]
    fn every_preset_expands_to_stages_that_can_be_and_end() {
        for preset in ALL {
            assert_eq!(named(preset.name).map(|p| p.name), Some(preset.name));
            assert!(preset.help.ends_with('.'));
            let needed = preset.parameters().filter(|parameter| parameter.default == Default::Needed);
            let least: Given = needed.map(|p| (p.key.to_string(), example(p))).collect();
            assert_sound(preset, &least);
            for parameter in preset.parameters() {
                let [low, high] = parameter.bounds;
                assert!(low < high && parameter.help.ends_with('.'), "{}", parameter.key);
                let mut given = least.clone();
                match (parameter.kind, parameter.default) {
                    (Kind::Number, Default::Value(value)) => {
                        assert!((low..=high).contains(&value), "{}", parameter.key);
                    }
                    (Kind::Number, _) => {
                        given.insert(parameter.key.to_string(), example(parameter));
                        assert_sound(preset, &given);
                    }
                    (Kind::Word(words), Default::Word(default)) => {
                        assert!(words.iter().any(|[word, _]| *word == default));
                        for [word, meaning] in words {
                            assert!(!meaning.is_empty());
                            given.insert(parameter.key.to_string(), (*word).into());
                            assert_sound(preset, &given);
                        }
                    }
                    (Kind::List, Default::List(list)) => {
                        assert!(list.windows(2).all(|pair| pair[0] < pair[1]));
                    }
                    (Kind::History, Default::Needed) => {}
                    (kind, default) => panic!("{}: {kind:?} with {default:?}", parameter.key),
                }
            }
        }
    }

    /// A strain rate takes the place of the inertial number and brings its factor on the density, but for a consolidation.
    #[test]
    fn a_strain_rate_scales_the_density_of_the_test_alone() {
        let given = Given::from([
            ("lateral_stress".into(), 1e5.into()),
            ("strain_rate".into(), 1e-5.into()),
            ("density_scaling".into(), 1e12.into()),
        ]);
        let stages = drained_triaxial::PRESET.expand(&given);
        assert_eq!(stages[0].density_scaling, 1.0);
        assert!(matches!(stages[0].control.speed, Speed::InertialNumber { .. }));
        assert_eq!((stages[1].control.speed, stages[1].density_scaling), (Speed::StrainRate(1e-5), 1e12));
    }
}
