//! Named paths. A preset declares its parameters and expands to stages; it is one file and one line in [`ALL`], and a program
//! adds its own with [`Paths::with`].

mod constant_p;
mod constant_p_and_b;
mod cyclic;
mod definition;
mod drained_triaxial;
mod history;
mod hold;
mod isotropic;
mod oedometer;
mod parameter;
mod plane_strain;
mod probes;
mod proportional;
mod random;
mod simple_shear;
mod simple_shear_constant_volume;
mod unconfined_strength;
mod undrained_triaxial;
mod unload_reload;

use granum_core::RegistrationError;

pub use self::constant_p::antony2006;
pub use self::definition::{PathValues, Preset};
use self::definition::{consolidation, generous};
pub use self::parameter::{
    Given, INERTIAL_NUMBER, INTERVAL, PathFault, PathParameter, PathParameterDefault, PathParameterKind,
    PathValue, STATES, any_stress, deviator, number, optional, stress, word,
};

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
    plane_strain::PRESET,
    proportional::PRESET,
    cyclic::PRESET,
    unload_reload::PRESET,
    unconfined_strength::PRESET,
    hold::PRESET,
    history::PRESET,
    random::PRESET,
    probes::PRESET,
];

/// The path of strain or stress probes, which a file of the IncrementalDriver can ask for.
pub const PROBES: &Preset = &probes::PRESET;

/// One of granum's own presets by its name.
pub fn named(name: &str) -> Option<&'static Preset> {
    ALL.iter().find(|preset| preset.name == name)
}

/// The named paths of a program: those of granum, and those that the program adds.
///
/// ```
/// use granum_dem::loading::preset::{INERTIAL_NUMBER, Paths, Preset};
/// use granum_dem::loading::{Control, Drive, Measure, Stage, Target, Until};
///
/// const SHORT_BY_A_TENTH: Preset = Preset::new(
///     "compression-between-walls",
///     "Axis x is compressed, the stress along y is held, and z is fixed.",
///     &[INERTIAL_NUMBER],
///     |values| {
///         let (fixed, held) = (Drive::Fixed, Drive::Stress(Target::current()));
///         let control = Control::new(values.speed(), [Drive::Rate(1.0), held, fixed, fixed, fixed, fixed]);
///         vec![Stage::new("compression", control, vec![Until::Reaches { measure: Measure::Strain(0), value: 0.1 }])]
///     },
/// );
/// let paths = Paths::standard().with(&SHORT_BY_A_TENTH)?;
/// assert!(paths.named("compression-between-walls").is_some());
/// # Ok::<(), granum_core::RegistrationError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Paths(Vec<&'static Preset>);

impl Default for Paths {
    fn default() -> Paths {
        Paths::standard()
    }
}

impl Paths {
    /// The paths of granum.
    pub fn standard() -> Paths {
        Paths(ALL.iter().collect())
    }

    /// Adds a path, which case files can then name.
    ///
    /// # Errors
    /// If there is already another path of this name, or a parameter is declared twice or with a default outside its bounds.
    pub fn with(mut self, preset: &'static Preset) -> Result<Paths, RegistrationError> {
        match self.named(preset.name) {
            Some(known) if known.is_same_as(preset) => return Ok(self),
            _ => RegistrationError::check_name("path", preset.name, self.names())?,
        }
        preset.check()?;
        self.0.push(preset);
        Ok(self)
    }

    /// All paths, granum's own first.
    pub fn all(&self) -> &[&'static Preset] {
        &self.0
    }

    /// Their names.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone {
        self.0.iter().map(|preset| preset.name)
    }

    /// The path of a given name.
    pub fn named(&self, name: &str) -> Option<&'static Preset> {
        self.0.iter().copied().find(|preset| preset.name == name)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::loading::{History, HistoryQuantity, Speed, Start};

    /// A value for a parameter that has no default.
    fn example(parameter: &PathParameter) -> PathValue {
        match parameter.kind {
            PathParameterKind::History => {
                let columns = vec![HistoryQuantity::Strain(0), HistoryQuantity::Stress(1)];
                PathValue::History(History { columns, rows: vec![vec![0.0, 1e5], vec![0.01, 1e5]] })
            }
            _ => PathValue::Number(parameter.bounds[0].max(1e5).min(parameter.bounds[1])),
        }
    }

    fn assert_sound(preset: &Preset, given: &Given) {
        let stages = preset.expand(given);
        assert!(!stages.is_empty(), "{}", preset.name);
        let mut kept = false;
        for stage in &stages {
            assert_eq!(stage.control.check(), Ok(()), "{} {}", preset.name, stage.name);
            assert!(!stage.until.is_empty() && stage.most_arc_length.is_some(), "{}", preset.name);
            // A stage with a NaN would not be equal to itself.
            assert_eq!(stage, &stage.clone(), "{}", preset.name);
            kept |= stage.start == Start::Kept;
            assert!(stage.start != Start::Back || kept, "{}: nothing to go back to", preset.name);
        }
    }

    #[test]
    fn paths_that_would_mislead_are_refused() {
        const OWN: Preset =
            Preset::new("test-of-registration", "A path of one's own.", &[INERTIAL_NUMBER], |_| Vec::new());
        let paths = Paths::standard().with(&OWN).unwrap();
        assert_eq!(paths.clone().with(&OWN), Ok(paths.clone()), "once more is no harm");
        assert!(
            paths.all().len() > ALL.len() && paths.named(OWN.name).is_some() && named(OWN.name).is_none()
        );
        const TAKEN: Preset = Preset { name: "oedometer", ..OWN };
        assert_eq!(paths.clone().with(&TAKEN), Err(RegistrationError::name_taken("path", "oedometer")));
        const TWICE: Preset = Preset { name: "twice", own: &[STATES, STATES], ..OWN };
        let twice = RegistrationError::key_taken("path", "twice", "parameter", "states");
        assert_eq!(paths.clone().with(&TWICE), Err(twice));
        const UNSPEAKABLE: Preset = Preset { name: "two words", ..OWN };
        assert!(matches!(paths.clone().with(&UNSPEAKABLE), Err(RegistrationError::Name { .. })));
        const OUTSIDE: Preset = Preset {
            name: "outside",
            own: &[PathParameter { default: PathParameterDefault::Value(0.0), ..STATES }],
            ..OWN
        };
        assert!(matches!(
            paths.with(&OUTSIDE),
            Err(RegistrationError::Declaration { reason, .. }) if reason.contains("\"states\"")
        ));
    }

    #[test]
    fn every_preset_expands_to_stages_that_can_be_and_end() {
        for preset in ALL {
            assert_eq!(named(preset.name).map(|p| p.name), Some(preset.name));
            assert!(preset.help.ends_with('.'));
            let needed =
                preset.parameters().filter(|parameter| parameter.default == PathParameterDefault::Needed);
            let least: Given = needed.map(|p| (p.key.to_string(), example(p))).collect();
            assert_sound(preset, &least);
            for parameter in preset.parameters() {
                let [low, high] = parameter.bounds;
                assert!(low < high && parameter.help.ends_with('.'), "{}", parameter.key);
                let mut given = least.clone();
                match (parameter.kind, parameter.default) {
                    (PathParameterKind::Number, PathParameterDefault::Value(value)) => {
                        assert!((low..=high).contains(&value), "{}", parameter.key);
                    }
                    (PathParameterKind::Number, _) => {
                        given.insert(parameter.key.to_string(), example(parameter));
                        assert_sound(preset, &given);
                    }
                    (PathParameterKind::Word(words), PathParameterDefault::Word(default)) => {
                        assert!(words.iter().any(|[word, _]| *word == default));
                        for [word, meaning] in words {
                            assert!(!meaning.is_empty());
                            given.insert(parameter.key.to_string(), (*word).into());
                            assert_sound(preset, &given);
                        }
                    }
                    (PathParameterKind::List, PathParameterDefault::List(list)) => {
                        assert!(list.windows(2).all(|pair| pair[0] < pair[1]));
                    }
                    (PathParameterKind::History, PathParameterDefault::Needed) => {}
                    (kind, default) => panic!("{}: {kind:?} with {default:?}", parameter.key),
                }
            }
        }
    }

    /// A strain rate replaces the inertial number, together with its factor on the density, except in a consolidation.
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
