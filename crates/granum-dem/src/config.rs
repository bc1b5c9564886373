//! Everything that defines a simulation, in SI units. Every [`Default`] is the sample of Antony, Zhou and Wang (2006).

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use crate::contact::choice::contact_model::ContactModel;
pub use crate::contact::choice::kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
pub use crate::contact::choice::parameters::ParameterValues;
pub use crate::material::Material;
pub use crate::mixture::{Component, Mixture, PairRule};
pub use crate::sizes::{Grains, SizeKind, Sizes};

/// Gives configurations the method `with`, which changes fields of a value: fields can be added to them without breaking anybody.
macro_rules! with {
    ($($kind:ident: $field:ident = $value:expr),+) => {
        $(impl $kind {
            /// The same with some fields changed.
            ///
            /// ```
            #[doc = concat!("use granum_dem::config::", stringify!($kind), ";")]
            ///
            #[doc = concat!("let changed = ", stringify!($kind), "::default().with(|new| new.", stringify!($field), " = ", stringify!($value), ");")]
            #[doc = concat!("assert_eq!(changed.", stringify!($field), ", ", stringify!($value), ");")]
            /// ```
            pub fn with(mut self, change: impl FnOnce(&mut $kind)) -> $kind {
                change(&mut self);
                self
            }
        })+
    };
}
with!(
    Grains: count = 300,
    Material: friction = 0.5,
    ContactModel: damping = 0.2,
    Preparation: seed = 7,
    Shear: deviator_strain = 0.1,
    Recording: states = 50,
    Numerics: time_step_factor = 0.1
);

/// Number of stiff contacts of a grain up to which the time step is stable.
pub const MOST_CONTACTS: f64 = 12.0;

/// How grains lie that were deposited in layers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Bedding {
    /// Angle between the normal of the layers and axis 1, rad, in the plane of the axes 1 and 2.
    pub tilt: f64,
    /// Standard deviation of the angle between the long axes of the grains and their layer, rad.
    pub spread: f64,
}

/// How a sample is prepared: random insertion from a seed, isotropic compression, then relaxation with the final properties.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Preparation {
    /// Seed of the loose initial state.
    pub seed: u64,
    /// Target mean stress p, Pa.
    pub mean_stress: f64,
    /// Solid fraction of the loose initial state.
    pub initial_solid_fraction: f64,
    /// How grains that are not spheres lie in the loose initial state; `None`: in all directions alike.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bedding: Option<Bedding>,
    /// Coefficient of friction during compaction; `None`: found such that `solid_fraction` is met or, without a target, the
    /// friction of the material.
    pub friction: Option<f64>,
    /// Mean stress at which the grains are compacted, Pa; `None`: the target mean stress or, where the target density needs it, a
    /// smaller one. The relaxation brings the sample to the target mean stress.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compaction_stress: Option<f64>,
    /// Interface energy during compaction, J/m2.
    pub interface_energy: f64,
    /// Coefficient of rolling friction during compaction; `None`: as the contact law has it. A sample whose contact law has no
    /// resistance to rolling gets one while it is compacted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rolling_friction: Option<f64>,
    /// Number of cycles of axial strain at constant mean stress after the compaction.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub cycles: u64,
    /// Amplitude of the axial strain of these cycles.
    #[serde(default = "usual_cycle_strain", skip_serializing_if = "is_usual_cycle_strain")]
    pub cycle_strain: f64,
    /// Target solid fraction; granum then finds the preparation friction that meets it. Not used with a target
    /// void ratio or relative density.
    pub solid_fraction: Option<f64>,
    /// Target void ratio e, in place of the solid fraction 1/(1 + e).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub void_ratio: Option<f64>,
    /// Target relative density `(e_max - e) / (e_max - e_min)`, which needs the two void ratios below.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_density: Option<f64>,
    /// Void ratio e_min of the densest state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub densest_void_ratio: Option<f64>,
    /// Void ratio e_max of the loosest state.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub loosest_void_ratio: Option<f64>,
    /// Accepted difference from the target solid fraction.
    pub solid_fraction_tolerance: f64,
    /// Highest inertial number during compression, once grains carry load.
    pub inertial_number: f64,
    /// The sample is in equilibrium when the unbalanced force is below this value.
    pub unbalanced_force: f64,
}

/// Amplitude of the strain cycles of a preparation where none is given.
const USUAL_CYCLE_STRAIN: f64 = 0.01;

fn usual_cycle_strain() -> f64 {
    USUAL_CYCLE_STRAIN
}

fn is_usual_cycle_strain(strain: &f64) -> bool {
    *strain == USUAL_CYCLE_STRAIN
}

fn is_zero(number: &u64) -> bool {
    *number == 0
}

impl Preparation {
    /// The solid fraction that the sample is to have, from whichever measure of density is given.
    ///
    /// ```
    /// use granum_dem::config::Preparation;
    ///
    /// let mut preparation = Preparation::default().with(|preparation| preparation.void_ratio = Some(0.6));
    /// assert_eq!(preparation.target(), Some(0.625));
    /// preparation.void_ratio = None;
    /// preparation.relative_density = Some(0.25);
    /// (preparation.densest_void_ratio, preparation.loosest_void_ratio) = (Some(0.55), Some(0.75));
    /// assert_eq!(preparation.target(), Some(1.0 / 1.7));
    /// ```
    pub fn target(&self) -> Option<f64> {
        let by_density = || {
            let [densest, loosest] = [self.densest_void_ratio?, self.loosest_void_ratio?];
            Some(loosest - self.relative_density? * (loosest - densest))
        };
        let void_ratio = self.void_ratio.or_else(by_density);
        void_ratio.map(|e| 1.0 / (1.0 + e)).or(self.solid_fraction)
    }
}

impl Default for Preparation {
    fn default() -> Self {
        Preparation {
            seed: 1,
            mean_stress: 20e3,
            initial_solid_fraction: 0.35,
            bedding: None,
            friction: None,
            compaction_stress: None,
            interface_energy: 0.0,
            rolling_friction: None,
            cycles: 0,
            cycle_strain: USUAL_CYCLE_STRAIN,
            void_ratio: None,
            relative_density: None,
            densest_void_ratio: None,
            loosest_void_ratio: None,
            solid_fraction: Some(0.61),
            solid_fraction_tolerance: 0.005,
            inertial_number: 1e-3,
            unbalanced_force: 1e-3,
        }
    }
}

/// Rate of a test. Both forms describe the same physics: without gravity only the inertial number
/// `I = strain_rate * d * sqrt(density / p)` matters.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rate {
    /// Inertial number I of the axial strain rate; the strain rate follows from the density of the grains.
    InertialNumber(f64),
    /// Axial strain rate, 1/s, with the density of the grains multiplied by `density_scaling`.
    StrainRate {
        /// Axial strain rate, 1/s.
        strain_rate: f64,
        /// Factor on the density of every grain.
        density_scaling: f64,
    },
}

/// Axisymmetric compression at constant mean stress: `eps_1` grows, `sigma_2 = sigma_3` follow the servo.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Shear {
    /// Deviator strain `eps_1 - eps_3` at the end.
    pub deviator_strain: f64,
    /// Rate of loading.
    pub rate: Rate,
    /// Mean stress p held constant, Pa; `None`: that of the sample.
    pub mean_stress: Option<f64>,
}

impl Default for Shear {
    fn default() -> Self {
        Shear { deviator_strain: 0.3, rate: Rate::InertialNumber(3.64e-4), mean_stress: None }
    }
}

/// The deviator strains of a test at which states are recorded. State 0, the sample before it is strained, is always
/// recorded.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Spacing {
    /// At the ends of `states` equal intervals.
    #[default]
    Equal,
    /// At `states` strains from this one to the end, with a constant factor between successive strains.
    Geometric(f64),
    /// At these strains, in ascending order.
    Strains(Vec<f64>),
    /// At every multiple of this strain, up to the end of the test.
    Every(f64),
}

/// The times of observation by the sensors, and their parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Recording {
    /// Number of intervals of deviator strain; a state is recorded at each end of an interval. Not used with
    /// [`Spacing::Strains`].
    pub states: usize,
    /// Strains of the states.
    #[serde(default, skip_serializing_if = "is_equal")]
    pub spacing: Spacing,
    /// Deviator strains at which a snapshot of all grains and contacts is taken, in ascending order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub snapshots: Vec<f64>,
    /// Number of observations averaged for one state, spread evenly over one interval around it.
    #[serde(alias = "looks")]
    pub observations_per_state: usize,
    /// Names of sensors that are recorded beside those that always are.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<String>,
    /// Values given to parameters of sensors, in SI units, by key; the others have their defaults. The sensors declare their
    /// parameters.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub parameters: BTreeMap<String, f64>,
}

/// The columns that the record of a test has.
///
/// The columns of a case are a part of its results: they are in the digest of a run, and networks are trained on them by name.
/// The section `[shear]` was published with the columns of its first version, so that a case that is written with it keeps them;
/// every other test records all columns.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RecordedColumns {
    /// The number of the stage, and everything that describes a test along any path.
    #[default]
    All,
    /// Those of the first version: neither the number of the stage nor the sensors that were added for general paths, unless
    /// `recording.sensors` names them.
    FirstPublished,
}

impl Default for Recording {
    fn default() -> Self {
        Recording {
            states: 120,
            spacing: Spacing::Equal,
            snapshots: Vec::new(),
            observations_per_state: 20,
            sensors: Vec::new(),
            parameters: BTreeMap::new(),
        }
    }
}

fn is_equal(spacing: &Spacing) -> bool {
    *spacing == Spacing::Equal
}

/// Numerical choices that should not change a result beyond scatter.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Numerics {
    /// Time step as a fraction of `sqrt(m / k_t)` of the stiffest contact.
    pub time_step_factor: f64,
    /// Largest overlap of two grains over the sum of their radii with which a run goes on; [`LARGEST_OVERLAP`] if it is not given.
    pub largest_overlap: Option<f64>,
}

/// Largest overlap of two grains over the sum of their radii with which a run goes on unless its case allows more. The theory of
/// elastic contacts is one of small overlaps, and beyond a tenth of a diameter neighbours of one grain would touch through it.
pub const LARGEST_OVERLAP: f64 = 0.1;

impl Numerics {
    /// The largest overlap with which a run goes on.
    pub fn overlap_limit(&self) -> f64 {
        self.largest_overlap.unwrap_or(LARGEST_OVERLAP)
    }
}

impl Default for Numerics {
    fn default() -> Self {
        Numerics { time_step_factor: 0.2, largest_overlap: None }
    }
}
