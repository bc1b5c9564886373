use super::tests::{assert_same, in_pieces, quick};
use super::*;
use crate::config::{Grains, NormalKind, RollingKind, TangentialKind};
use crate::contact::choice::contact_model::ContactModel;
use crate::sizes::{SizeKind, Sizes};

/// Spheres with the sizes of a sand.
fn sand(count: usize) -> Grains {
    let sizes = Sizes::new(SizeKind::SIEVE_CURVE).with_curve(vec![
        [7.95e-5, 0.05],
        [1.249e-4, 0.28],
        [1.581e-4, 0.85],
        [2.441e-4, 1.0],
    ]);
    let mut grains = Grains { count, sizes, ..Grains::default() };
    (grains.material.youngs_modulus, grains.material.friction) = (2e9, 0.5);
    grains.material.interface_energy = 0.0;
    grains
}

fn contact() -> ContactModel {
    let mut contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    contact.rolling = RollingKind::ELASTIC_PLASTIC;
    contact.parameters.set("rolling_friction", 0.3).unwrap();
    contact
}

fn asked(void_ratio: f64, seed: u64) -> Preparation {
    Preparation {
        seed,
        mean_stress: 100e3,
        void_ratio: Some(void_ratio),
        solid_fraction: None,
        solid_fraction_tolerance: 5e-4,
        inertial_number: 2e-3,
        unbalanced_force: 5e-3,
        ..quick()
    }
}

/// From loose to dense, also where strain cycles are needed: what a search over procedures alone misses by up to 0.015.
#[test]
fn a_density_that_is_asked_for_exactly_is_met_to_two_thousandths_of_the_void_ratio() {
    let (grains, contact) = (sand(200), contact());
    for (void_ratio, seed) in [(0.51, 2), (0.52, 1), (0.58, 2), (0.64, 1), (0.70, 1), (0.74, 2)] {
        let preparation = asked(void_ratio, seed);
        let specification = SampleSpecification::new(&grains, &contact, &preparation);
        let sample = prepare(&specification, &mut NoObserver).unwrap();
        let reached = 1.0 / sample.simulation.state().solid_fraction() - 1.0;
        assert!(
            sample.solid_fraction_met && (reached - void_ratio).abs() < 2e-3,
            "{void_ratio}, seed {seed}: {reached}, {:?}",
            sample.trials
        );
        assert!(sample.settled && sample.simulation.properties() == &specification.properties());
        let last = sample.trials.last().unwrap();
        assert_eq!(last.solid_fraction, sample.simulation.state().solid_fraction());
    }
}

#[test]
fn a_densification_in_pieces_makes_the_same_sample() {
    let (grains, contact) = (sand(100), contact());
    for (void_ratio, phase) in [(0.64, Phase::Compaction), (0.505, Phase::Cycles)] {
        let preparation = asked(void_ratio, 3);
        let specification = SampleSpecification::new(&grains, &contact, &preparation);
        let straight = prepare(&specification, &mut NoObserver).unwrap();
        let (pieces, stops, seen) = in_pieces(Preparing::new(&specification).unwrap(), &specification, 2);
        assert!(stops > 10, "{stops}");
        // After a relaxation the same trial goes on.
        let again =
            seen.windows(2).any(|pair| pair[0].1 == Phase::Relaxation && pair[1] == (pair[0].0, phase));
        assert!(again, "{void_ratio}: {seen:?}");
        assert_same(&straight, &pieces);
    }
}

/// Looser than the loosest trial there is nothing to be made denser.
#[test]
fn a_density_beyond_the_loosest_is_missed_and_the_search_ends() {
    let (grains, contact) = (sand(100), contact());
    let preparation = asked(1.1, 1);
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    let sample = prepare(&specification, &mut NoObserver).unwrap();
    assert!(!sample.solid_fraction_met && sample.trials.len() <= MOST_TRIALS + 1, "{:?}", sample.trials);
}
