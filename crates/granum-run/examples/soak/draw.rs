//! Random cases, reproducible from a seed.

use granum_dem::config::{NormalKind, Rate, Recording, TangentialKind};
use granum_io::Case;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

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

    /// A random case: materials from rubber to steel, grains from a micrometre to a centimetre, every pair of contact
    /// laws, and mean stresses from a millionth to a thousandth of the modulus of the grains.
    pub fn case(&mut self) -> Case {
        const LAWS: [(NormalKind, TangentialKind); 5] = [
            (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ),
            (NormalKind::HERTZ, TangentialKind::NO_SLIP),
            (NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ),
            (NormalKind::JKR, TangentialKind::NO_SLIP),
            (NormalKind::JKR, TangentialKind::PEELING),
        ];
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
        (case.contact.normal, case.contact.tangential) = LAWS[(self.fraction() * 5.0) as usize];
        case.contact.damping = self.decades(0.01, 0.7);
        preparation.seed = self.0.next_u64() >> 32;
        preparation.solid_fraction = None;
        preparation.friction = Some(if self.chance(0.2) { 0.0 } else { self.even(0.0, 0.8) });
        preparation.initial_solid_fraction = self.even(0.2, 0.36);
        preparation.inertial_number = self.decades(2e-3, 2e-2);
        preparation.unbalanced_force = self.decades(3e-3, 5e-2);
        case.shear.deviator_strain = self.decades(3e-3, 3e-2);
        let number = self.decades(3e-4, 1e-2);
        case.shear.mean_stress = self.chance(0.2).then(|| preparation.mean_stress * self.even(0.5, 2.0));
        case.shear.rate = if self.chance(0.8) {
            Rate::InertialNumber(number)
        } else {
            let density_scaling = self.decades(1e-3, 1e12);
            let slow = (case.preparation.mean_stress / (material.density * density_scaling)).sqrt();
            Rate::StrainRate { strain_rate: number * slow / grains.diameter, density_scaling }
        };
        let states = self.even(2.0, 9.0) as usize;
        let observations = self.even(1.0, 4.0) as usize;
        case.recording = Recording::default().with(|recording| {
            recording.states = states;
            recording.observations_per_state = observations;
        });
        case.numerics.time_step_factor = self.even(0.08, 0.22);
        case
    }
}
