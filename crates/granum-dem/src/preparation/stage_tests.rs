//! Tests of the stages between compaction and relaxation.

use super::tests::{assert_same, grains, in_pieces, quick};
use super::*;
use crate::config::{Grains, NormalKind, TangentialKind};
use crate::contact::choice::contact_model::ContactModel;
use crate::loading;
use crate::loading::preset::{self, Given, PathValue};
use crate::loading::{
    Constraint, Control, Drive, Measure, Reason, RecordedStates, Speed, Start, Target, Turns, Until,
};
use crate::observer::{EachProgress, NoObserver};

fn contact() -> ContactModel {
    ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1)
}

fn path(name: &str, numbers: &[(&str, f64)]) -> Vec<loading::Stage> {
    let given: Given = numbers.iter().map(|(key, x)| (key.to_string(), PathValue::Number(*x))).collect();
    preset::named(name).unwrap().expand(&given)
}

/// Compression without lateral strain, and unloading.
fn oedometer(loading: f64, unloading: f64) -> Vec<loading::Stage> {
    path(
        "oedometer",
        &[("axial_stress", loading), ("unloading_stress", unloading), ("inertial_number", 1e-2)],
    )
}

/// Cycles of the axial strain at constant lateral stress, with an explicit control.
fn cyclic(amplitude: f64, reversals: u64) -> loading::Stage {
    let (held, fixed) = (Drive::Stress(Target::current()), Drive::Fixed);
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let control = Control::new(speed, [Drive::Rate(1.0), held, held, fixed, fixed, fixed]);
    loading::Stage::new("cyclic", control, vec![Until::Reversals(reversals)]).with(|stage| {
        stage.turns = Some(Turns { measure: Measure::Strain(0), high: amplitude, low: -amplitude });
    })
}

fn prepared(specification: &SampleSpecification) -> Sample {
    prepare(specification, &mut NoObserver).unwrap()
}

fn failure(specification: &SampleSpecification) -> PreparationError {
    prepare(specification, &mut NoObserver).err().unwrap()
}

fn density(sample: &Sample) -> f64 {
    sample.simulation.state().solid_fraction()
}

/// Cycles, paths and explicit controls in each trial of a search, stopped and resumed in the middle of each.
#[test]
fn a_preparation_with_stages_in_pieces_makes_the_same_sample() {
    let grains = grains(0.2);
    let preparation = Preparation {
        solid_fraction: Some(0.61),
        solid_fraction_tolerance: 1e-9,
        cycles: 1,
        cycle_strain: 0.003,
        ..quick()
    };
    let mut stages = oedometer(60e3, 30e3);
    stages.push(cyclic(0.002, 3));
    // The same physics with another density, whose time step differs.
    stages[2].control.speed = Speed::StrainRate(5.0);
    stages[2].density_scaling = 64.0;
    let contact = contact();
    let specification = SampleSpecification::new(&grains, &contact, &preparation).with_stages(stages);
    let straight = prepared(&specification);
    assert!(straight.trials.len() >= 2, "{:?}", straight.trials);
    let (pieces, stops, seen) = in_pieces(Preparing::new(&specification).unwrap(), &specification, 2);
    assert!(stops > 20, "{stops}");
    for phase in [Phase::Cycles, Phase::PreparationStage, Phase::Relaxation] {
        assert!(seen.contains(&(1, phase)) && seen.contains(&(2, phase)), "{seen:?}");
    }
    assert_same(&straight, &pieces);
    assert_eq!(straight.time.to_bits(), pieces.time.to_bits());
    assert_eq!(straight.simulation.properties(), &specification.properties());
}

/// An over-consolidated sample is denser than a normally consolidated one. It is at rest at an isotropic stress.
#[test]
fn consolidation_in_an_oedometer_leaves_a_denser_sample_at_an_isotropic_stress() {
    let grains = Grains { count: 200, ..grains(0.2) };
    let contact = contact();
    let preparation =
        Preparation { solid_fraction: None, friction: Some(0.3), unbalanced_force: 5e-3, ..quick() };
    let plain = SampleSpecification::new(&grains, &contact, &preparation);
    let consolidated = plain.clone().with_stages(path(
        "oedometer",
        &[("axial_stress", 10e6), ("inertial_number", 5e-3), ("interval", 1e-3)],
    ));
    let mut ratios = Vec::new();
    let mut named = false;
    let sample = prepare(
        &consolidated,
        &mut EachProgress(|progress: &SimulationProgress| {
            if progress.phase == Phase::PreparationStage {
                ratios
                    .push(Measure::StressRatio.value(&progress.simulation().unwrap().state().macro_state()));
                named |= progress.stage == Some("loading")
                    && progress.steps > progress.simulation().unwrap().state().step();
                assert_eq!(progress.simulation().unwrap().properties().material.friction, 0.3);
            }
            Flow::Continue
        }),
    )
    .unwrap();
    assert!(named && ratios.last().is_some_and(|ratio| *ratio > 0.2), "{ratios:?}");
    let before = prepared(&plain);
    assert!(density(&sample) > density(&before) + 0.002, "{} {}", density(&sample), density(&before));
    let stress = sample.simulation.state().stress();
    assert!(sample.settled);
    for axis in 0..3 {
        assert!((stress[axis][axis] / preparation.mean_stress - 1.0).abs() < 0.02, "{stress:?}");
    }
    assert!(sample.steps > before.steps && sample.time > before.time);
}

/// What the stages of a test record does not change how the stages of a preparation proceed.
#[test]
fn nothing_is_recorded_and_the_recording_has_no_effect() {
    let grains = grains(0.0);
    let contact = contact();
    let preparation = Preparation { solid_fraction: None, friction: Some(0.1), ..quick() };
    let recording = oedometer(60e3, 30e3);
    assert!(recording.iter().all(|stage| stage.record != RecordedStates::default()));
    let bare = recording.iter().cloned().map(|stage| stage.recording(RecordedStates::default())).collect();
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    struct Eager;
    impl SimulationObserver for Eager {
        fn next_observation(&self) -> f64 {
            0.0
        }
        fn observe(&mut self, _: &dyn granum_core::ObservedState) {
            panic!("a preparation records nothing");
        }
    }
    let with = prepare(&specification.clone().with_stages(recording), &mut Eager).unwrap();
    assert_same(&with, &prepared(&specification.with_stages(bare)));
}

/// The strain rate changes sign at the first step at which a turning point of the cycles is reached.
#[test]
fn cycles_turn_at_their_amplitude() {
    let grains = grains(0.2);
    let contact = contact();
    let amplitude = 0.004;
    let preparation = Preparation {
        solid_fraction: None,
        friction: Some(0.3),
        cycles: 2,
        cycle_strain: amplitude,
        ..quick()
    };
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    let (mut extremes, mut step) = ([0.0f64; 2], 0.0f64);
    prepare(
        &specification,
        &mut EachProgress(|progress: &SimulationProgress| {
            let state = progress.simulation().unwrap().state();
            if progress.phase == Phase::Cycles {
                let strain = state.strain()[0][0];
                extremes = [extremes[0].min(strain), extremes[1].max(strain)];
                let rate = progress
                    .simulation()
                    .unwrap()
                    .strain_rate(preparation.inertial_number, preparation.mean_stress);
                step = step.max(rate * state.time_step());
                assert!((state.mean_stress() / preparation.mean_stress - 1.0).abs() < 0.2);
            }
            Flow::Continue
        }),
    )
    .unwrap();
    let late = [-extremes[0] - amplitude, extremes[1] - amplitude];
    assert!(step > 0.0 && late.iter().all(|late| (0.0..=1.5 * step).contains(late)), "{late:?} {step}");
}

#[test]
fn a_stage_that_cannot_be_executed_to_its_end_is_an_error_and_none_goes_on_for_ever() {
    let grains = grains(0.0);
    let contact = contact();
    let preparation = Preparation { solid_fraction: None, friction: Some(0.1), ..quick() };
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    let with = |stages: Vec<loading::Stage>| specification.clone().with_stages(stages);
    let [loading, unloading] = oedometer(60e3, 30e3).try_into().unwrap();
    let short = loading.clone().with(|stage| {
        stage.until = vec![Until::Reaches { measure: Measure::Stress(0), value: 1e12 }];
        stage.most_arc_length = Some(1e-3);
    });
    let error = failure(&with(vec![loading.clone(), unloading, short]));
    let text = error.to_string();
    assert!(text.starts_with("stage 3 of the 3 stages of the preparation (loading): none of its"), "{text}");
    assert!(matches!(
        error,
        PreparationError::Stage { number: 3, fault: StageFault::CutShort(Reason::TooLong { .. }), .. }
    ));
    // A stage that nothing strains, without a limit of its own, would never reach its end.
    let still = Control { speed: Speed::StrainRate(1e6), ..Control::default() };
    let far = Until::Reaches { measure: Measure::Strain(0), value: 1.0 };
    let still = loading::Stage::new("still", still, vec![far]).with(|stage| stage.most_arc_length = None);
    assert!(matches!(failure(&with(vec![still])), PreparationError::Stage { number: 1, .. }));
    let back = loading.clone().with(|stage| stage.start = Start::Back);
    let text = failure(&with(vec![loading, back])).to_string();
    assert!(text.contains("stage 2 of the 2") && text.contains("starts from a saved state"), "{text}");
    let twice = Constraint::mean_stress(Target::current());
    let singular = cyclic(0.001, 1).with(|stage| stage.control = stage.control.with(twice));
    let text = failure(&with(vec![singular])).to_string();
    assert!(text.contains("(cyclic): the stage gives 7 equations"), "{text}");
}
