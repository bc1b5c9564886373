//! The list of all keys of the case file.

use std::ops::Deref;
use std::sync::{Arc, LazyLock};

use granum_dem::config::{Bedding, Preparation, Rate, Shear, Spacing};
use granum_dem::contact::choice::registry::Laws;
use granum_dem::shape::family::parameters as shape_parameters;
use granum_dem::shape::{ShapeKind, SizeMeasure};
use granum_dem::sizes;

use super::Case;
use super::field::{Field, FieldKind};
use super::shape_value as shape;
use super::vocabulary::Vocabulary;
use granum_core::quantity::Dimension;

/// The field with a path such as `grains.material.friction`, among those of a case file that knows granum's own laws and sensors.
pub fn field(path: &str) -> Option<Arc<Field>> {
    Fields::standard().named(path)
}

/// Keys that had another name: the old one and the new one. An old name is rejected with a hint to the new one; digests are
/// computed from the old names and do not change.
pub(super) const RENAMED: &[[&str; 2]] = &[["recording.looks", "recording.observations_per_state"]];

/// Spread of the long axes about their layer where none is given: 15 degrees.
const USUAL_SPREAD: f64 = 15.0 * std::f64::consts::PI / 180.0;

/// Key of the family of the shape.
const KIND_OF_SHAPE: &str = "grains.shape.kind";

/// Key of the sensors that a case names.
const SENSORS: &str = "recording.sensors";

/// Help and meaning of every section, in the order of the file.
pub(super) const SECTIONS: &[[&str; 2]] = &[
    ["grains", "The grains: how many and how large."],
    [
        "grains.shape",
        "The shape of the grains: rigid bodies of several spheres. Several shapes: tables [[grains.shape]] with share.",
    ],
    ["grains.material", "What the grains are made of."],
    ["contact", "The contact law."],
    [
        "preparation",
        "The sample: a loose initial state of grains that do not touch, placed at random from a seed, compressed \
         isotropically and relaxed with the final properties.",
    ],
    ["shear", "The test: axisymmetric compression at constant mean stress."],
    ["recording", "The states that the sensors record, and the bins of the force distribution P(f)."],
    ["numerics", "Numerical choices that should not change a result beyond scatter."],
];

/// Name and help text of each law of a kind.
macro_rules! options {
    ($laws:expr) => {
        $laws.iter().map(|law| [law.name(), law.law().description().help]).collect()
    };
}

/// A number that is required.
macro_rules! number {
    ($dimension:ident, $low:literal..=$high:literal, $($place:ident).+) => {
        FieldKind::Number {
            dimension: Dimension::$dimension,
            bounds: [$low, $high],
            absent: None,
            get: |case| Some(case.$($place).+),
            set: |case, value| case.$($place).+ = value.unwrap_or(case.$($place).+),
        }
    };
}

/// A number or a word for its absence.
macro_rules! optional {
    ($dimension:ident, $low:literal..=$high:literal, $word:literal: $meaning:literal, $($place:ident).+) => {
        FieldKind::Number {
            dimension: Dimension::$dimension,
            bounds: [$low, $high],
            absent: Some([$word, $meaning]),
            get: |case| case.$($place).+,
            set: |case, value| case.$($place).+ = value,
        }
    };
}

/// A whole number.
macro_rules! count {
    ($low:literal..=$high:literal, $($place:ident).+) => {
        FieldKind::Count {
            bounds: [$low, $high],
            get: |case| case.$($place).+ as u64,
            set: |case, value| case.$($place).+ = value as _,
        }
    };
}

/// Sets one of the measures of density of a sample; the others are then not given.
fn density(case: &mut Case, value: Option<f64>, which: fn(&mut Preparation) -> &mut Option<f64>) {
    let p = &mut case.preparation;
    if value.is_some() {
        (p.solid_fraction, p.void_ratio, p.relative_density) = (None, None, None);
    }
    *which(p) = value;
}

fn entry(
    section: &'static str,
    key: &'static str,
    help: &'static str,
    example: &str,
    kind: FieldKind,
) -> Field {
    Field { section, key, help: help.to_string(), example: example.to_string(), kind }
}

/// All keys of the case file, in the order of the file: those of the case, with the parameters of all contact laws that are
/// known inserted after `contact.damping`, and with those that sensors declare in the section `[recording]`.
#[derive(Clone)]
pub struct Fields(Arc<[Arc<Field>]>);

static STANDARD: LazyLock<Fields> = LazyLock::new(|| Fields::with_vocabulary(&Vocabulary::standard()));

impl Fields {
    /// The keys with granum's own contact laws and sensors.
    pub fn standard() -> Fields {
        STANDARD.clone()
    }

    /// The keys with the contact laws and sensors of a vocabulary.
    pub fn new(vocabulary: &Vocabulary) -> Fields {
        if vocabulary.is_standard() { Fields::standard() } else { Fields::with_vocabulary(vocabulary) }
    }

    /// The fields with the parameters that size distributions, contact laws and sensors declare. Those of sensors that are recorded
    /// where a case names them follow `recording.sensors`; those of the usual ones are the last of the section.
    fn with_vocabulary(vocabulary: &Vocabulary) -> Fields {
        let laws = vocabulary.laws();
        let mut fields = fields(laws);
        let after = fields.iter().position(|field| field.key == "distribution").map_or(0, |at| at + 1);
        fields.splice(after..after, sizes::parameters().into_iter().map(Field::of_sizes));
        let after = fields.iter().position(|field| field.path() == KIND_OF_SHAPE).map_or(0, |at| at + 1);
        fields.splice(after..after, shape_parameters().into_iter().map(Field::of_shapes));
        let after = fields.iter().rposition(|field| field.section == "contact").map_or(0, |at| at + 1);
        let parameters = laws.parameters();
        fields.splice(after..after, parameters.into_iter().map(|parameter| Field::of_law(parameter, laws)));
        let declared = vocabulary.sensors().declared_parameters();
        let (usual, named): (Vec<_>, Vec<_>) = declared.into_iter().partition(|declared| declared.always);
        let after = fields.iter().position(|field| field.path() == SENSORS).map_or(0, |at| at + 1);
        fields.splice(after..after, named.iter().map(Field::of_sensor));
        let after = fields.iter().rposition(|field| field.section == "recording").map_or(0, |at| at + 1);
        fields.splice(after..after, usual.iter().map(Field::of_sensor));
        Fields(fields.into_iter().map(Arc::new).collect())
    }

    /// The field with a path such as `grains.material.friction`.
    pub fn named(&self, path: &str) -> Option<Arc<Field>> {
        self.iter().find(|field| field.path() == path).cloned()
    }
}

impl Deref for Fields {
    type Target = [Arc<Field>];
    fn deref(&self) -> &[Arc<Field>] {
        &self.0
    }
}

impl Case {
    /// The keys of a case file with the contact laws and sensors that this case knows.
    pub fn fields(&self) -> Fields {
        Fields::new(&self.vocabulary)
    }
}

#[rustfmt::skip]
fn fields(laws: &Laws) -> Vec<Field> { vec![
    entry("grains", "count", "Number of grains.", "5000",
        count!(50..=100_000_000, grains.count)),
    entry("grains", "diameter", "Mean diameter d.", "0.1 mm", FieldKind::Number {
        dimension: Dimension::LENGTH,
        bounds: ["10 nm", "10 m"],
        absent: None,
        get: |case| {
            let has_mean = case.grains.sizes.distribution.distribution().description().has_mean;
            has_mean.then_some(case.grains.diameter)
        },
        set: |case, value| case.grains.diameter = value.unwrap_or(case.grains.diameter),
    }),
    entry("grains", "spread", "Half-width of the uniform distribution of radii relative to the mean; 0 makes equal grains.", "0",
        number!(NUMBER, "0"..="0.9", grains.spread)),
    entry("grains", "distribution", "Distribution of the diameters.", "uniform", FieldKind::Choice {
        options: sizes::ALL.iter().map(|kind| [kind.name(), kind.distribution().description().help]).collect(),
        get: |case| case.grains.sizes.distribution.name(),
        set: |case, name| if let Some(kind) = sizes::SizeKind::named(name) { case.grains.sizes.distribution = kind },
    }),
    entry("grains", "smallest", "Smallest diameter: the distribution is cut there.", "none",
        optional!(LENGTH, "1 nm"..="10 m", "none": "not cut", grains.sizes.smallest)),
    entry("grains", "largest", "Largest diameter: the distribution is cut there.", "none",
        optional!(LENGTH, "1 nm"..="10 m", "none": "not cut", grains.sizes.largest)),
    entry("grains", "sieve_curve", "Sieve curve of distribution = \"sieve-curve\": the name of a CSV file with the columns diameter (mm),finer (%), or a list of points.", "none", FieldKind::Curve {
        absent: ["none", "no curve"],
        get: |case| case.grains.sizes.curve.clone(),
        set: |case, points| case.grains.sizes.curve = points,
    }),

    entry("grains", "size_measure", "What a diameter means where grains are not spheres.", "volume", FieldKind::Choice {
        options: vec![
            ["volume", "the diameter of the sphere of equal volume"],
            ["sieve", "the edge of the smallest square hole that the grain passes: its intermediate length"],
        ],
        get: |case| match case.grains.size_measure { SizeMeasure::Volume => "volume", SizeMeasure::Sieve => "sieve" },
        set: |case, name| case.grains.size_measure = if name == "sieve" { SizeMeasure::Sieve } else { SizeMeasure::Volume },
    }),

    entry("grains.shape", "kind", "Family of the shape.", "sphere", FieldKind::Choice {
        options: shape::kinds(),
        get: |case| shape::only(case).kind.name(),
        set: |case, name| if let Some(kind) = ShapeKind::named(name) { shape::change(case, |entry| entry.kind = kind) },
    }),
    entry("grains.shape", "spheres", "The spheres of kind = \"pieces\": centre and radius of each, [[x, y, z, radius], ...], in any unit of length.", "none", FieldKind::Spheres {
        absent: ["none", "no list"],
        get: |case| shape::only(case).spheres,
        set: |case, spheres| shape::change(case, |entry| entry.spheres = spheres),
    }),

    entry("grains.material", "density", "Density rho of the solid.", "2650 kg/m3",
        number!(DENSITY, "1 kg/m3"..="100000 kg/m3", grains.material.density)),
    entry("grains.material", "youngs_modulus", "Young's modulus E.", "70 GPa",
        number!(STRESS, "1 kPa"..="10 TPa", grains.material.youngs_modulus)),
    entry("grains.material", "poissons_ratio", "Poisson's ratio nu.", "0.3",
        number!(NUMBER, "0"..="0.5", grains.material.poissons_ratio)),
    entry("grains.material", "friction", "Coefficient of friction mu between grains, in the test.", "0.3",
        number!(NUMBER, "0"..="10", grains.material.friction)),
    entry("grains.material", "interface_energy", "Interface energy Gamma: work of adhesion per area, used by normal = \"jkr\", \"dmt\" and \"jkr-dmt\"; 0 is no adhesion.", "0.6 J/m2",
        number!(SURFACE_ENERGY, "0 J/m2"..="100 J/m2", grains.material.interface_energy)),

    entry("contact", "normal", "Normal law.", "jkr", FieldKind::Choice {
        options: options!(laws.normal()),
        get: |case| case.contact.normal.name(),
        set: |case, name| if let Some(law) = case.vocabulary.laws().normal_named(name) { case.contact.normal = law },
    }),
    entry("contact", "tangential", "Tangential law.", "mindlin-deresiewicz", FieldKind::Choice {
        options: options!(laws.tangential()),
        get: |case| case.contact.tangential.name(),
        set: |case, name| if let Some(law) = case.vocabulary.laws().tangential_named(name) { case.contact.tangential = law },
    }),
    entry("contact", "rolling", "Resistance to rolling and twisting.", "none", FieldKind::Choice {
        options: options!(laws.rolling()),
        get: |case| case.contact.rolling.name(),
        set: |case, name| if let Some(law) = case.vocabulary.laws().rolling_named(name) { case.contact.rolling = law },
    }),
    entry("contact", "adhesion", "Additional attraction of grains, which may act across a gap.", "none", FieldKind::Choice {
        options: options!(laws.adhesion()),
        get: |case| case.contact.adhesion.name(),
        set: |case, name| if let Some(law) = case.vocabulary.laws().adhesion_named(name) { case.contact.adhesion = law },
    }),
    entry("contact", "damping", "Fraction zeta of critical damping in the contact dashpots.", "0.1",
        number!(NUMBER, "0"..="1", contact.damping)),

    entry("preparation", "seed", "Seed of the loose initial state: another seed is another sample of the same material.", "1",
        count!(0..=9_223_372_036_854_775_807, preparation.seed)),
    entry("preparation", "mean_stress", "Target mean stress p.", "20 kPa",
        number!(STRESS, "0.001 Pa"..="100 GPa", preparation.mean_stress)),
    entry("preparation", "initial_solid_fraction", "Solid fraction of the loose initial state, in which no grains touch.", "0.35",
        number!(NUMBER, "0.01"..="0.5", preparation.initial_solid_fraction)),
    entry("preparation", "bedding_tilt", "Angle between the normal of the layers in which grains that are not spheres were deposited and axis 1, in the plane of the axes 1 and 2: long axes lie in the layers.", "none", FieldKind::Number {
        dimension: Dimension::ANGLE,
        bounds: ["0 deg", "90 deg"],
        absent: Some(["none", "no layers: all orientations are alike"]),
        get: |case| case.preparation.bedding.map(|bedding| bedding.tilt),
        set: |case, value| case.preparation.bedding = value.map(|tilt| Bedding { tilt, spread: case.preparation.bedding.map_or(USUAL_SPREAD, |bedding| bedding.spread) }),
    }),
    entry("preparation", "bedding_spread", "Standard deviation of the angle between the long axes and their layer; only with bedding_tilt.", "15 deg", FieldKind::Number {
        dimension: Dimension::ANGLE,
        bounds: ["0 deg", "60 deg"],
        absent: None,
        get: |case| case.preparation.bedding.map(|bedding| bedding.spread),
        set: |case, value| if let (Some(spread), Some(bedding)) = (value, case.preparation.bedding.as_mut()) { bedding.spread = spread },
    }),
    entry("preparation", "friction", "Coefficient of friction while compacting.", "auto",
        optional!(NUMBER, "0"..="10", "auto": "found so that the target density is met; without a target the friction of the material", preparation.friction)),
    entry("preparation", "compaction_stress", "Mean stress while compacting, from which the sample is brought to mean_stress: a smaller one makes looser samples.", "auto",
        optional!(STRESS, "1e-6 Pa"..="100 GPa", "auto": "mean_stress, or what the target density needs", preparation.compaction_stress)),
    entry("preparation", "interface_energy", "Interface energy while compacting; contacts of normal = \"hertz\" follow JKR meanwhile.", "0 J/m2",
        number!(SURFACE_ENERGY, "0 J/m2"..="100 J/m2", preparation.interface_energy)),
    entry("preparation", "rolling_friction", "Coefficient of rolling friction while compacting, also where the contact law has none.", "auto",
        optional!(NUMBER, "0"..="2", "auto": "as the contact law has it", preparation.rolling_friction)),
    entry("preparation", "cycles", "Number of cycles of axial strain at constant mean stress after the compaction. They make dense samples.", "0",
        count!(0..=100_000, preparation.cycles)),
    entry("preparation", "cycle_strain", "Amplitude of the axial strain of these cycles.", "0.01",
        number!(NUMBER, "1e-5"..="0.2", preparation.cycle_strain)),
    entry("preparation", "solid_fraction", "Target solid fraction of the sample.", "0.61",
        FieldKind::Number {
            dimension: Dimension::NUMBER,
            bounds: ["0.3", "0.8"],
            absent: Some(["none", "no target"]),
            get: |case| case.preparation.solid_fraction,
            set: |case, value| density(case, value, |p| &mut p.solid_fraction),
        }),
    entry("preparation", "void_ratio", "Target void ratio e of the sample, in place of solid_fraction = 1/(1 + e).", "none",
        FieldKind::Number {
            dimension: Dimension::NUMBER,
            bounds: ["0.2", "2"],
            absent: Some(["none", "not given"]),
            get: |case| case.preparation.void_ratio,
            set: |case, value| density(case, value, |p| &mut p.void_ratio),
        }),
    entry("preparation", "relative_density", "Target relative density (e_max - e)/(e_max - e_min), in place of solid_fraction; it needs the two void ratios below.", "none",
        FieldKind::Number {
            dimension: Dimension::NUMBER,
            bounds: ["-0.5", "1.5"],
            absent: Some(["none", "not given"]),
            get: |case| case.preparation.relative_density,
            set: |case, value| density(case, value, |p| &mut p.relative_density),
        }),
    entry("preparation", "densest_void_ratio", "Void ratio e_min of the densest state, which `granum limits` finds.", "none",
        optional!(NUMBER, "0.05"..="2", "none": "not given", preparation.densest_void_ratio)),
    entry("preparation", "loosest_void_ratio", "Void ratio e_max of the loosest state, which `granum limits` finds.", "none",
        optional!(NUMBER, "0.05"..="3", "none": "not given", preparation.loosest_void_ratio)),
    entry("preparation", "solid_fraction_tolerance", "Accepted deviation from the target solid fraction.", "0.005",
        number!(NUMBER, "0.0001"..="0.1", preparation.solid_fraction_tolerance)),
    entry("preparation", "inertial_number", "Highest inertial number I while compressing, once grains carry load.", "1e-3",
        number!(NUMBER, "1e-7"..="0.1", preparation.inertial_number)),
    entry("preparation", "unbalanced_force", "The sample is at rest when the unbalanced force is below this fraction of the mean contact force.", "1e-3",
        number!(NUMBER, "1e-9"..="0.1", preparation.unbalanced_force)),

    entry("shear", "deviator_strain", "Deviator strain eps_1 - eps_3 at the end.", "0.3",
        FieldKind::Number {
            dimension: Dimension::NUMBER,
            bounds: ["1e-6", "3"],
            absent: None,
            get: |case| case.test.shear().map(|shear| shear.deviator_strain),
            set: |case, value| if let (Some(strain), Some(shear)) = (value, case.test.shear_mut()) { shear.deviator_strain = strain },
        }),
    entry("shear", "inertial_number", "Speed: inertial number I = strain_rate d sqrt(density / p) of the axial strain rate. Without gravity only I matters.", "3.64e-4", FieldKind::Number {
        dimension: Dimension::NUMBER,
        bounds: ["1e-8", "0.1"],
        absent: None,
        get: |case| match case.test.shear()?.rate {
            Rate::InertialNumber(number) => Some(number),
            Rate::StrainRate { .. } => None,
        },
        set: |case, value| if let (Some(number), Some(shear)) = (value, case.test.shear_mut()) { shear.rate = Rate::InertialNumber(number) },
    }),
    entry("shear", "strain_rate", "Axial strain rate, which can be given instead of inertial_number. The paper's 1e-5 /s with density_scaling = 1e12 gives the I above.", "1e-5 /s", FieldKind::Number {
        dimension: Dimension::RATE,
        bounds: ["1e-12 /s", "1e6 /s"],
        absent: None,
        get: |case| match case.test.shear()?.rate {
            Rate::InertialNumber(_) => None,
            Rate::StrainRate { strain_rate, .. } => Some(strain_rate),
        },
        set: |case, value| if let (Some(strain_rate), Some(shear)) = (value, case.test.shear_mut()) {
            let density_scaling = match shear.rate {
                Rate::StrainRate { density_scaling, .. } => density_scaling,
                Rate::InertialNumber(_) => 1.0,
            };
            shear.rate = Rate::StrainRate { strain_rate, density_scaling };
        },
    }),
    entry("shear", "density_scaling", "Factor on the density of every grain; only together with strain_rate.", "1e12", FieldKind::Number {
        dimension: Dimension::NUMBER,
        bounds: ["1e-6", "1e24"],
        absent: None,
        get: |case| match case.test.shear()?.rate {
            Rate::InertialNumber(_) => None,
            Rate::StrainRate { density_scaling, .. } => Some(density_scaling),
        },
        set: |case, value| if let (Some(factor), Some(Shear { rate: Rate::StrainRate { density_scaling, .. }, .. })) = (value, case.test.shear_mut()) {
            *density_scaling = factor;
        },
    }),
    entry("shear", "mean_stress", "Mean stress p held constant.", "sample",
        FieldKind::Number {
            dimension: Dimension::STRESS,
            bounds: ["0.001 Pa", "100 GPa"],
            absent: Some(["sample", "that of the sample"]),
            get: |case| case.test.shear()?.mean_stress,
            set: |case, value| if let Some(shear) = case.test.shear_mut() { shear.mean_stress = value },
        }),

    entry("recording", "states", "Number of equal intervals of deviator strain; a state is recorded at each end of an interval.", "120",
        count!(1..=1_000_000, recording.states)),
    entry("recording", "first_strain", "Deviator strain of the first state after the start: states are then spaced from there to the end by a constant factor.", "none", FieldKind::Number {
        dimension: Dimension::NUMBER,
        bounds: ["1e-9", "3"],
        absent: Some(["none", "equal intervals"]),
        get: |case| match case.recording.spacing {
            Spacing::Geometric(first) => Some(first),
            Spacing::Equal | Spacing::Strains(_) | Spacing::Every(_) => None,
        },
        set: |case, value| match value {
            Some(first) => case.recording.spacing = Spacing::Geometric(first),
            None if matches!(case.recording.spacing, Spacing::Geometric(_)) => case.recording.spacing = Spacing::Equal,
            None => {}
        },
    }),
    entry("recording", "strains", "Deviator strains at which a state is recorded, instead of states and first_strain, e.g. [1e-5, 1e-4, 1e-3, 0.01, 0.1].", "none", FieldKind::List {
        dimension: Dimension::NUMBER,
        bounds: ["1e-9", "3"],
        absent: ["none", "given by states and first_strain"],
        get: |case| match &case.recording.spacing {
            Spacing::Strains(strains) => strains.clone(),
            Spacing::Equal | Spacing::Geometric(_) | Spacing::Every(_) => Vec::new(),
        },
        set: |case, strains| {
            if !strains.is_empty() {
                case.recording.spacing = Spacing::Strains(strains);
            } else if matches!(case.recording.spacing, Spacing::Strains(_)) {
                case.recording.spacing = Spacing::Equal;
            }
        },
    }),
    entry("recording", "snapshots", "Deviator strains at which all grains and contacts are saved, in addition to the start and the end, e.g. [0.01, 0.1].", "none", FieldKind::List {
        dimension: Dimension::NUMBER,
        bounds: ["1e-9", "3"],
        absent: ["none", "start and end only"],
        get: |case| case.recording.snapshots.clone(),
        set: |case, strains| case.recording.snapshots = strains,
    }),
    entry("recording", "sensors", "Sensors that are recorded in addition to the usual ones, e.g. [\"overlap_distribution\"]; `granum measure --list` shows all.", "none", FieldKind::Names {
        what: "sensors",
        absent: ["none", "the usual ones"],
        get: |case| case.recording.sensors.clone(),
        set: |case, names| case.recording.sensors = names,
    }),
    entry("recording", "observations_per_state", "Observations averaged for one recorded state, spread evenly over one interval of strain around it.", "20",
        count!(1..=100_000, recording.observations_per_state)),

    entry("numerics", "time_step_factor", "Time step as a fraction of sqrt(m / k_t) of the stiffest contact; shortened where contact.damping is above 0.1.", "0.2",
        number!(NUMBER, "0.0001"..="1", numerics.time_step_factor)),
    entry("numerics", "largest_overlap", "Largest overlap of two grains over the sum of their radii: a run ends beyond it. More than a tenth only for very soft or plastic grains.", "usual",
        optional!(NUMBER, "0.1"..="0.5", "usual": "0.1", numerics.largest_overlap)),
]}
