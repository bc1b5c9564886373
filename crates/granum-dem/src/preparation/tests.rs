use super::*;
use crate::config::{Grains, LARGEST_OVERLAP, NormalKind, TangentialKind};
use crate::contact::choice::contact_model::ContactModel;
use crate::observer::{EachProgress, Work};
use crate::random_insertion::random_insertion;

pub(super) fn grains(spread: f64) -> Grains {
    Grains { count: 80, spread, ..Grains::default() }
}

pub(super) fn quick() -> Preparation {
    Preparation {
        initial_solid_fraction: 0.3,
        inertial_number: 1e-2,
        unbalanced_force: 2e-2,
        ..Preparation::default()
    }
}

/// Both parts, saved and restored.
fn written_and_read(preparing: &Preparing) -> Preparing {
    let bytes = preparing.simulation.checkpoint("").unwrap();
    let progress = postcard::to_allocvec(&preparing.progress).unwrap();
    Preparing {
        simulation: Simulation::restore(&bytes).unwrap().0,
        progress: postcard::from_bytes(&progress).unwrap(),
    }
}

/// Continues to the end, with a stop and a restart every `strides` checks; returns the sample, the number of stops, and the
/// trials and phases at which they occurred.
pub(super) fn in_pieces(
    mut preparing: Preparing,
    specification: &SampleSpecification,
    strides: u32,
) -> (Sample, u32, Vec<(usize, Phase)>) {
    let (mut stops, mut seen) = (0, Vec::new());
    loop {
        preparing = written_and_read(&preparing);
        let mut left = strides;
        let mut observer = EachProgress(|p: &SimulationProgress| {
            if seen.last() != Some(&(p.trial, p.phase)) {
                seen.push((p.trial, p.phase));
            }
            left -= 1;
            if left == 0 { Flow::Stop } else { Flow::Continue }
        });
        match preparing.go_on(specification, &mut observer).unwrap() {
            PreparationOutcome::Sample(sample) => return (*sample, stops, seen),
            PreparationOutcome::Stopped(at) => preparing = *at,
            PreparationOutcome::Again(next) => {
                panic!("an initial state or a sample needs no packing: {next:?}")
            }
        }
        stops += 1;
    }
}

pub(super) fn assert_same(a: &Sample, b: &Sample) {
    assert!(a.simulation.state() == b.simulation.state());
    assert_eq!(a.simulation.checkpoint("").unwrap(), b.simulation.checkpoint("").unwrap());
    assert_eq!((&a.trials, a.steps, a.settled), (&b.trials, b.steps, b.settled));
    assert_eq!((a.unbalanced_force, a.solid_fraction_met), (b.unbalanced_force, b.solid_fraction_met));
}

#[test]
fn a_preparation_in_pieces_makes_the_same_sample() {
    let contact = ContactModel::default();
    for spread in [0.0, 0.2] {
        let grains = grains(spread);
        // No trial is so close, so that the search goes on.
        let preparation =
            Preparation { solid_fraction: Some(0.6), solid_fraction_tolerance: 1e-9, ..quick() };
        let specification = SampleSpecification::new(&grains, &contact, &preparation);
        let straight = prepare(&specification, &mut NoObserver).unwrap();
        assert!(straight.trials.len() >= 2 && !straight.solid_fraction_met, "{:?}", straight.trials);
        let (pieces, stops, seen) = in_pieces(Preparing::new(&specification).unwrap(), &specification, 3);
        assert!(stops > 20, "{stops}");
        assert!(seen.contains(&(2, Phase::Compaction)) && seen.contains(&(2, Phase::Relaxation)), "{seen:?}");
        assert_same(&straight, &pieces);
    }
}

/// Stops at every so many calls during work, also where grains are placed for another trial.
struct Impatient {
    every: u32,
    left: u32,
    placings: u32,
}

impl SimulationObserver for Impatient {
    fn work(&mut self, work: &Work) -> Flow {
        if matches!(work, Work::Placing { .. }) {
            self.placings += 1;
            // The same placing is tried again after the stop.
            return if self.placings.is_multiple_of(2) { Flow::Continue } else { Flow::Stop };
        }
        self.left -= 1;
        if self.left > 0 {
            return Flow::Continue;
        }
        self.left = self.every;
        Flow::Stop
    }

    fn work_every(&self) -> u64 {
        // 80 grains: five calls from one check to the next.
        80 * 97
    }
}

#[test]
fn a_preparation_that_is_stopped_between_its_checks_makes_the_same_sample() {
    let contact = ContactModel::default();
    let grains = grains(0.2);
    let preparation =
        Preparation { solid_fraction: Some(0.6), solid_fraction_tolerance: 1e-9, cycles: 1, ..quick() };
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    let straight = prepare(&specification, &mut NoObserver).unwrap();
    let mut observer = Impatient { every: 7, left: 7, placings: 0 };
    let stopped = Preparing::followed(&specification, &mut observer).err().unwrap();
    assert!(matches!(stopped, PreparationError::Stopped { phase: Phase::Placing }));
    let mut preparing = Preparing::followed(&specification, &mut observer).unwrap();
    let mut stops = 0;
    let sample = loop {
        preparing = written_and_read(&preparing);
        match preparing.go_on(&specification, &mut observer).unwrap() {
            PreparationOutcome::Sample(sample) => break *sample,
            PreparationOutcome::Stopped(at) => preparing = *at,
            PreparationOutcome::Again(next) => panic!("an initial state needs no packing: {next:?}"),
        }
        stops += 1;
    };
    assert!(stops > 20 && straight.trials.len() >= 2, "{stops}");
    assert_eq!(observer.placings as usize, 2 * straight.trials.len());
    assert_same(&straight, &sample);
}

/// Steel would be pressed into itself at a fifth of its modulus.
#[test]
fn a_stress_that_presses_grains_into_each_other_is_refused() {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let grains = grains(0.0);
    let preparation = Preparation {
        mean_stress: 0.2 * grains.material.youngs_modulus,
        solid_fraction: None,
        friction: Some(0.1),
        ..quick()
    };
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    let error = prepare(&specification, &mut NoObserver).err().unwrap();
    let PreparationError::Overlap { phase, overlap, limit } = error else { panic!("{error}") };
    assert!(phase == Phase::Compaction && limit == LARGEST_OVERLAP && overlap > limit && overlap < 0.2);
    let text = PreparationError::Overlap { phase, overlap: 0.123, limit }.to_string();
    assert!(
        text.starts_with("in the compaction, grains overlap by 12.3 % of the sum of their radii"),
        "{text}"
    );
}

#[test]
fn a_packing_settles_in_pieces_to_the_same_sample() {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let grains = grains(0.0);
    let preparation = Preparation { solid_fraction: None, friction: Some(0.1), ..quick() };
    let first = SampleSpecification::new(&grains, &contact, &preparation);
    let packing = prepare(&first, &mut NoObserver).unwrap().simulation;
    let denser = Preparation { mean_stress: 60e3, unbalanced_force: 1e-4, ..preparation.clone() };
    let second = SampleSpecification::new(&grains, &contact, &denser);
    let straight = settle(packing.clone(), &second, &mut NoObserver).unwrap();
    let (pieces, stops, _) = in_pieces(Preparing::settling(packing, &second), &second, 2);
    assert!(stops >= 2 && straight.trials.is_empty(), "{stops}");
    assert_same(&straight, &pieces);
}

/// The sample that results from a loose packing.
fn compacted(
    packing: &(crate::cell::Cell, Vec<crate::simulation::InitialSphere>),
    specification: &SampleSpecification,
) -> Sample {
    let mut next = NextTrial::first(specification);
    loop {
        let simulation = Simulation::new(packing.0, &packing.1, next.properties(specification)).unwrap();
        assert!(is_loose(&simulation, &specification.preparation));
        let preparing = Preparing::compacting(simulation, specification, next);
        match preparing.go_on(specification, &mut NoObserver).unwrap() {
            PreparationOutcome::Sample(sample) => return *sample,
            PreparationOutcome::Again(again) => next = again,
            PreparationOutcome::Stopped(_) => panic!("nobody stopped it"),
        }
    }
}

#[test]
fn a_loose_packing_is_compacted_by_friction_and_target_as_a_random_one_is() {
    let (grains, contact) = (grains(0.0), ContactModel::default());
    let packing = random_insertion(&grains, 0.3, 7).unwrap();
    let with = |friction, solid_fraction| {
        let preparation = Preparation { friction, solid_fraction, solid_fraction_tolerance: 2e-3, ..quick() };
        compacted(&packing, &SampleSpecification::new(&grains, &contact, &preparation))
    };
    let (slippery, rough) = (with(Some(0.0), None), with(Some(1.0), None));
    let density = |sample: &Sample| sample.simulation.state().solid_fraction();
    assert!(density(&slippery) > density(&rough) + 0.01, "{} {}", density(&slippery), density(&rough));
    assert_eq!((slippery.trials.len(), slippery.trials[0].friction), (1, 0.0));
    let searched = with(None, Some(0.5 * (density(&slippery) + density(&rough))));
    assert!(searched.trials.len() >= 2, "{:?}", searched.trials);
    // The same grains at rest are not loose, since they carry the stress.
    let preparation = Preparation { solid_fraction: None, ..quick() };
    assert!(!is_loose(&rough.simulation, &preparation));
    let dense = Preparation { solid_fraction: Some(0.5), mean_stress: 1e9, ..quick() };
    assert!(!is_loose(&rough.simulation, &dense), "denser than the target");
}

#[test]
fn a_sample_is_brought_to_another_mean_stress_and_is_at_rest_there() {
    let (grains, contact) = (grains(0.0), ContactModel::default());
    let preparation = Preparation { solid_fraction: None, friction: Some(0.1), ..quick() };
    let first = SampleSpecification::new(&grains, &contact, &preparation);
    let sample = prepare(&first, &mut NoObserver).unwrap().simulation;
    for mean_stress in [200e3, 5e3] {
        let other = Preparation { mean_stress, ..preparation.clone() };
        let specification = SampleSpecification::new(&grains, &contact, &other);
        let start = || Preparing::consolidating(sample.clone(), &specification);
        assert_eq!(start().progress.phase(), Phase::Consolidation);
        let PreparationOutcome::Sample(straight) = start().go_on(&specification, &mut NoObserver).unwrap()
        else {
            panic!("nobody stopped it")
        };
        let state = straight.simulation.state();
        assert!(straight.settled && (state.mean_stress() / mean_stress - 1.0).abs() < 0.005);
        assert!(straight.unbalanced_force < other.unbalanced_force && straight.trials.is_empty());
        let (pieces, _, _) = in_pieces(start(), &specification, 2);
        assert_same(&straight, &pieces);
    }
}

#[test]
fn an_observer_ends_a_preparation() {
    let (grains, contact, preparation) = (grains(0.0), ContactModel::default(), quick());
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    // It is asked while grains are placed as well; one that needs the simulation is first asked when there is one.
    let error = prepare(&specification, &mut |_: &granum_core::observer::Progress| Flow::Stop).err().unwrap();
    assert!(matches!(error, PreparationError::Stopped { phase: Phase::Placing }), "{error}");
    let error =
        prepare(&specification, &mut EachProgress(|_: &SimulationProgress| Flow::Stop)).err().unwrap();
    assert!(matches!(error, PreparationError::Stopped { phase: Phase::Compaction }), "{error}");
}

#[test]
fn cycles_make_a_sample_denser_and_can_be_interrupted() {
    let grains = grains(0.2);
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let plain = Preparation { solid_fraction: None, friction: Some(0.3), ..quick() };
    let cycled = Preparation { cycles: 3, cycle_strain: 0.02, ..plain.clone() };
    let sample = |preparation: &Preparation| {
        prepare(&SampleSpecification::new(&grains, &contact, preparation), &mut NoObserver).unwrap()
    };
    let (before, after) = (sample(&plain), sample(&cycled));
    let density = |sample: &Sample| sample.simulation.state().solid_fraction();
    assert!(density(&after) > density(&before) + 0.002, "{} {}", density(&before), density(&after));
    assert!(after.steps > before.steps);
    let cycled_specification = SampleSpecification::new(&grains, &contact, &cycled);
    let (pieces, _, seen) =
        in_pieces(Preparing::new(&cycled_specification).unwrap(), &cycled_specification, 3);
    assert!(seen.contains(&(1, Phase::Cycles)), "{seen:?}");
    assert_same(&after, &pieces);
}

/// The attraction and the resistance to rolling of the preparation act during compaction only, not in the finished sample.
#[test]
fn laws_of_the_compaction_are_gone_in_the_sample() {
    let grains = grains(0.0);
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let preparation = Preparation {
        solid_fraction: None,
        friction: Some(1.0),
        interface_energy: 8.0,
        rolling_friction: Some(0.5),
        ..quick()
    };
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    let start = Preparing::new(&specification).unwrap();
    let meanwhile = start.simulation.properties();
    assert_eq!(
        (meanwhile.contact.normal, meanwhile.contact.rolling.name()),
        (NormalKind::JKR, "elastic-plastic")
    );
    assert_eq!(meanwhile.contact.parameters.given("rolling_friction"), Some(0.5));
    assert_eq!((meanwhile.material.friction, meanwhile.material.interface_energy), (1.0, 8.0));
    let (sample, _, _) = in_pieces(start, &specification, 4);
    assert_eq!(sample.simulation.properties(), &specification.properties());
    assert_eq!(sample.simulation.properties().contact, contact);
    assert!((sample.simulation.state().mean_stress() / 20e3 - 1.0).abs() < 0.01 && sample.settled);
}

/// A tenth of the largest diameter: placed at random, compacted, at rest, with a search that misses no contact.
#[test]
fn grains_of_a_tenth_of_the_largest_diameter_are_placed_and_compacted() {
    use crate::sizes::{SizeKind, Sizes};
    let sizes = Sizes::new(SizeKind::SIEVE_CURVE).with_curve(vec![[2e-5, 0.0], [2e-4, 1.0]]);
    let grains = Grains { count: 800, sizes, ..Grains::default() };
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let preparation =
        Preparation { initial_solid_fraction: 0.45, friction: Some(0.1), solid_fraction: None, ..quick() };
    let sample =
        prepare(&SampleSpecification::new(&grains, &contact, &preparation), &mut NoObserver).unwrap();
    let state = sample.simulation.state();
    assert!(sample.settled && state.solid_fraction() > 0.66, "{}", state.solid_fraction());
    let assembly = sample.simulation.assembly();
    let [smallest, largest] = grains.size_range().unwrap();
    assert!(largest > 8.0 * smallest);
    let near = assembly.pieces.iter().map(|piece| piece.radius).fold(0.0, f64::max);
    assert!((2.0 * near / largest - 1.0).abs() < 1e-12);
}
