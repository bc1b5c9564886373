//! Random cases, reproducible from a seed.

use granum_dem::config::{NormalKind, Rate, Recording, Shear};
use granum_dem::contact::choice::check::{parameters_of, sets};
use granum_dem::loading::preset::{self, Given, PathValue};
use granum_dem::loading::{History, HistoryQuantity};
use granum_io::Case;
use granum_io::case::{CaseStage, CaseTest};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Paths of a preparation: those that every sample can follow without losing its stress.
const PREPARING: [&str; 5] = ["isotropic", "oedometer", "constant-p", "drained-triaxial", "cyclic"];

/// The second run of a case, whose results must be identical to those of the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Way {
    /// There is no second run.
    Plain,
    /// The second run is interrupted and resumed.
    Interrupted,
    /// The second run uses two threads.
    TwoThreads,
    /// The second run uses the portable instruction set.
    Portable,
}

impl Way {
    pub const ALL: [Way; 4] = [Way::Plain, Way::Interrupted, Way::TwoThreads, Way::Portable];

    pub fn name(self) -> &'static str {
        match self {
            Way::Plain => "plain",
            Way::Interrupted => "interrupted",
            Way::TwoThreads => "two threads",
            Way::Portable => "portable",
        }
    }
}

/// A sequence of random numbers from a seed.
pub struct Draws(ChaCha8Rng);

impl Draws {
    pub fn new(seed: u64) -> Draws {
        Draws(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A number between 0 and 1.
    pub fn fraction(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1u64 << 53) as f64
    }

    fn even(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.fraction()
    }

    /// A number between the bounds, with a uniform distribution of its logarithm.
    fn decades(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.fraction())
    }

    fn chance(&mut self, part: f64) -> bool {
        self.fraction() < part
    }

    pub fn way(&mut self) -> Way {
        match self.fraction() {
            x if x < 0.4 => Way::Plain,
            x if x < 0.7 => Way::Interrupted,
            x if x < 0.85 => Way::TwoThreads,
            _ => Way::Portable,
        }
    }

    /// A random case: materials from rubber to steel, grains from a micrometre to a centimetre, every set of contact
    /// laws, and mean stresses from a millionth to a thousandth of the modulus of the grains; half
    /// of the cases follow one or two random paths in place of the paper's test, and a third have a path in their preparation.
    pub fn case(&mut self) -> Case {
        let sets = sets();
        let mut case = Case::default();
        let grains = &mut case.grains;
        grains.count = self.decades(200.0, 2000.0) as usize;
        grains.diameter = self.decades(1e-6, 1e-2);
        grains.spread = if self.chance(0.4) { 0.0 } else { self.even(0.0, 0.5) };
        let material = &mut grains.material;
        material.density = self.decades(300.0, 10_000.0);
        material.youngs_modulus = self.decades(1e7, 2e11);
        material.poissons_ratio = self.even(0.0, 0.5);
        material.friction = if self.chance(0.1) { 0.0 } else { self.even(0.0, 1.2) };
        let preparation = &mut case.preparation;
        preparation.mean_stress = material.youngs_modulus * self.decades(1e-7, 3e-4);
        // The adhesion is at most about a third of the force with which the mean stress presses two grains together.
        let adhesion = if self.chance(0.2) { 0.0 } else { self.decades(1e-4, 0.3) };
        material.interface_energy = (adhesion * preparation.mean_stress * grains.diameter).min(100.0);
        preparation.interface_energy = if self.chance(0.3) { material.interface_energy } else { 0.0 };
        let force = preparation.mean_stress * grains.diameter * grains.diameter;
        let separation = 4e-10;
        case.contact = sets[(self.fraction() * sets.len() as f64) as usize];
        case.contact.damping = self.decades(0.01, 0.7);
        if case.contact.adhesion.law().acts() {
            // Temporary adhesion is that of JKR, which a law of adhesion does not go with.
            preparation.interface_energy = 0.0;
        }
        // With some normal laws contacts do not depend on it, and it is refused.
        let normal = case.contact.normal;
        let adhesive = normal.law().traits().adhesive && normal.name() != "luding";
        if !adhesive && normal != NormalKind::HERTZ {
            preparation.interface_energy = 0.0;
        }
        // Values with which a law is neither without effect nor out of proportion to the mean stress.
        let rolling_stiffness = force / (grains.diameter * self.decades(1e-4, 1e-2));
        let mass = material.density * std::f64::consts::PI / 6.0 * grains.diameter.powi(3);
        let values = [
            ("normal_stiffness", force / (grains.diameter * self.decades(1e-5, 3e-3))),
            ("roughness", grains.diameter * self.decades(1e-7, 1e-5)),
            ("surface_tension", adhesion * force / grains.diameter),
            ("bridge_volume", self.decades(1e-6, 0.01)),
            ("rupture_coefficient", if self.chance(0.5) { 0.1 } else { 0.0 }),
            // From too little liquid for any bridge to more than the bridges can hold.
            ("liquid_content", self.decades(1e-8, 0.1)),
            ("largest_bridge_volume", self.decades(1e-6, 0.01)),
            ("least_separation", separation),
            ("hamaker_constant", adhesion * force * 48.0 * separation * separation / grains.diameter),
            ("rolling_friction", self.even(0.0, 0.4)),
            ("rolling_damping", self.even(0.0, 0.5)),
            ("rolling_stiffness", rolling_stiffness),
            ("rolling_viscosity", self.even(0.0, 0.5) * (rolling_stiffness * mass).sqrt()),
        ];
        for parameter in parameters_of(&case.contact) {
            if let Some((_, value)) = values.iter().find(|(key, _)| *key == parameter.key) {
                let [low, high] = parameter.bounds;
                // A set has room for the parameters of all its laws.
                let _ = case.contact.parameters.set(parameter.key, value.clamp(low, high));
            }
        }
        preparation.seed = self.0.next_u64() >> 32;
        preparation.solid_fraction = None;
        preparation.friction = Some(if self.chance(0.2) { 0.0 } else { self.even(0.0, 0.8) });
        preparation.initial_solid_fraction = self.even(0.2, 0.36);
        preparation.inertial_number = self.decades(2e-3, 2e-2);
        preparation.unbalanced_force = self.decades(3e-3, 5e-2);
        let deviator_strain = self.decades(3e-3, 3e-2);
        let number = self.decades(3e-4, 1e-2);
        let mean_stress = self.chance(0.2).then(|| preparation.mean_stress * self.even(0.5, 2.0));
        let rate = if self.chance(0.8) {
            Rate::InertialNumber(number)
        } else {
            let density_scaling = self.decades(1e-3, 1e12);
            let slow = (case.preparation.mean_stress / (material.density * density_scaling)).sqrt();
            Rate::StrainRate { strain_rate: number * slow / grains.diameter, density_scaling }
        };
        case.test = CaseTest::Shear(Shear::default().with(|shear| {
            (shear.deviator_strain, shear.mean_stress, shear.rate) = (deviator_strain, mean_stress, rate);
        }));
        let states = self.even(2.0, 9.0) as usize;
        let observations = self.even(1.0, 4.0) as usize;
        case.recording = Recording::default().with(|recording| {
            recording.states = states;
            recording.observations_per_state = observations;
        });
        case.numerics.time_step_factor = self.even(0.08, 0.22);
        if self.chance(0.5) {
            let pressure = case.preparation.mean_stress;
            let names: Vec<&str> = preset::ALL.iter().map(|path| path.name).collect();
            let count = 1 + (self.fraction() * 2.0) as usize;
            case.test = CaseTest::Stages((0..count).map(|_| self.path(pressure, &names, true)).collect());
        }
        if self.chance(0.3) {
            let pressure = case.preparation.mean_stress;
            case.preparation_stages = vec![self.path(pressure, &PREPARING, false)];
        }
        case
    }

    /// One of some paths, short enough for a case of a few seconds, for a sample at a mean stress, Pa; with states to record or not.
    fn path(&mut self, pressure: f64, names: &[&str], records: bool) -> CaseStage {
        let name = names[(self.fraction() * names.len() as f64) as usize];
        let path = preset::ALL.iter().find(|path| path.name == name).expect("the name of a path");
        let mut given = Given::new();
        let strain = self.decades(1e-3, 1e-2);
        let sense = if self.chance(0.5) { 1.0 } else { -1.0 };
        for parameter in path.parameters() {
            let number = match parameter.key {
                "inertial_number" => self.decades(3e-4, 5e-3),
                "deviator_strain" if path.name == "constant-p" => sense * strain,
                "axial_strain" if ["drained-triaxial", "undrained-triaxial"].contains(&path.name) => {
                    sense * strain
                }
                "axial_strain" | "shear_strain" | "deviator_strain" => strain,
                "strain_amplitude" => 0.2 * strain,
                "cycles" => 1.0 + (2.0 * self.fraction()).floor(),
                "mean_stress" if path.name == "isotropic" => 1.5 * pressure,
                "axial_stress" => 2.0 * pressure,
                "unloading_stress" if self.chance(0.5) => 1.2 * pressure,
                "strain" if path.name == "probes" => 1e-5,
                "directions" => 2.0,
                "unbalanced_force" => 0.02,
                "states" if records => 3.0,
                "interval" if records => 1e-3,
                _ => continue,
            };
            let [low, high] = parameter.bounds;
            given.insert(parameter.key.to_string(), number.clamp(low, high).into());
        }
        match path.name {
            "cyclic" if !records => {
                given.insert("drainage".into(), PathValue::Word("drained".into()));
            }
            "unload-reload" => {
                given.insert("at".into(), PathValue::List(vec![0.5 * strain]));
            }
            "history" => {
                let columns = vec![HistoryQuantity::Strain(0), HistoryQuantity::Stress(2)];
                let rows = vec![vec![strain, 1.1 * pressure], vec![0.5 * strain, pressure]];
                given.insert("file".into(), PathValue::History(History { columns, rows }));
            }
            _ => {}
        }
        CaseStage::Path { path, parameters: given, resets: true, until: Vec::new() }
    }
}
