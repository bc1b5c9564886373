//! Stages to zero stress, into tension and back.

use super::*;

/// Interface energy of the adhesive grains, J/m2.
const INTERFACE_ENERGY: f64 = 0.2;

/// The same 300 grains with adhesion, at rest at 20 kPa: their contacts hold each other with about a kilopascal.
fn adhesive() -> Simulation {
    static SAMPLE: OnceLock<Simulation> = OnceLock::new();
    SAMPLE.get_or_init(|| prepared(NormalKind::JKR, INTERFACE_ENERGY)).clone()
}

fn isotropic(target: Target, until: Vec<Until>, settling: bool) -> Stage {
    let (held, fixed) = (Drive::Stress(target), Drive::Fixed);
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let control = Control::new(speed, [held, held, held, fixed, fixed, fixed]);
    Stage::new("isotropic", control, until).with(|stage| stage.settling = settling)
}

const REST: Until = Until::AtRest { unbalanced_force: 1e-3 };

/// Dry grains end their stage at zero stress however it is asked for, and are loaded again.
#[test]
fn dry_grains_are_unloaded_to_zero_and_loaded_again() {
    let zero = Until::Reaches { measure: Measure::MeanStress, value: 0.0 };
    let to_zero = Target::ramp(Ramp::To(0.0));
    let ways = [
        ("held", isotropic(Target::held(0.0), vec![REST], true)),
        ("ramp", isotropic(to_zero, vec![Until::RampOver], false)),
        ("value", isotropic(to_zero, vec![zero], false)),
        ("path", expand("isotropic", &[("mean_stress", 0.0), ("inertial_number", 1e-2)]).remove(0)),
    ];
    for (way, stage) in ways {
        let mut s = sample();
        let p = s.state().mean_stress();
        let (ends, _) = run(&mut s, &[stage]);
        assert!(matches!(ends[0].reason, Reason::End(_)), "{way}: {}", ends[0].reason);
        assert!(s.state().mean_stress().abs() < 5e-3 * p, "{way}: {}", s.state().mean_stress());
        assert!(ends[0].servo_error.largest().is_finite(), "{way}");
        let again = expand("isotropic", &[("mean_stress", 10e3), ("inertial_number", 1e-2)]);
        let (ends, _) = run(&mut s, &again);
        assert!(matches!(ends[0].reason, Reason::End(_)), "{way}: {}", ends[0].reason);
        assert!((s.state().mean_stress() / 10e3 - 1.0).abs() < 5e-3, "{way}: {}", s.state().mean_stress());
    }
}

/// A sample that is held at zero is strained on: it carries nothing, and that is no failure.
#[test]
fn dry_grains_are_strained_without_stress() {
    let mut s = sample();
    let (ends, _) = run(
        &mut s,
        &expand(
            "unconfined-strength",
            &[
                ("lateral_stress", 20e3),
                ("pre_shear_strain", 0.01),
                ("axial_strain", 0.01),
                ("inertial_number", 5e-3),
            ],
        ),
    );
    assert_eq!(ends.len(), 5);
    assert!(ends.iter().all(|end| matches!(end.reason, Reason::End(_))), "{ends:?}");
    assert!(s.state().mean_stress().abs() < 100.0, "{}", s.state().mean_stress());
}

/// Tensile strength by Rumpf (1962), `phi Z F / (pi d^2)` with the pull-off force F, Pa: that of all contacts breaking at once.
fn rumpf(simulation: &Simulation) -> f64 {
    let (state, diameter) = (simulation.state(), simulation.mean_diameter());
    let pull_off = 1.5 * std::f64::consts::PI * INTERFACE_ENERGY * 0.25 * diameter;
    let coordination = 2.0 * state.contacts() as f64 / state.grains() as f64;
    state.solid_fraction() * coordination * pull_off / (std::f64::consts::PI * diameter * diameter)
}

/// Adhesive grains carry a tension below their strength, and are at rest under it; a target beyond it ends with the strength.
#[test]
fn adhesive_grains_have_a_tensile_strength() {
    let mut s = adhesive();
    let (ends, _) = run(&mut s, &[isotropic(Target::held(0.0), vec![REST], true)]);
    assert!(matches!(ends[0].reason, Reason::End(_)), "{}", ends[0].reason);
    assert!(s.state().mean_stress().abs() < 100.0 && s.state().contact_stress() > 100.0);
    let unloaded = s.clone();
    let pull = |to: f64| {
        let mut stage = isotropic(Target::ramp(Ramp::To(to)), vec![Until::RampOver], false);
        stage.control.speed = Speed::InertialNumber { number: 2e-3, at: None };
        stage
    };
    let torn = |to: f64| {
        let mut s = unloaded.clone();
        let (ends, _) = run(&mut s, &[pull(to)]);
        let Reason::TensileStrength { measure, strength } = ends[0].reason else {
            panic!("{}", ends[0].reason)
        };
        assert!(measure == Measure::MeanStress && ends[0].reason.is_asked_for());
        strength
    };
    let strength = torn(-50e3);
    let share = strength / rumpf(&unloaded);
    assert!((0.05..1.0).contains(&share), "{strength} is {share} of Rumpf's");
    // However much is asked for, the strength is about the same; a part of it is carried.
    assert!((torn(-100e3) / strength - 1.0).abs() < 0.5, "{strength}");
    let part = [isotropic(Target::held(-0.3 * strength), vec![REST], true)];
    let (ends, _) = run(&mut s, &part);
    assert!(matches!(ends[0].reason, Reason::End(_)), "{}", ends[0].reason);
    assert!((s.state().mean_stress() / strength + 0.3).abs() < 0.02, "{}", s.state().mean_stress());
}

/// The strength does not depend on when the stage is looked at, stopped and resumed.
#[test]
fn a_tensile_strength_is_the_same_after_a_checkpoint() {
    let stage = isotropic(Target::ramp(Ramp::To(-50e3)), vec![Until::RampOver], false);
    let (mut straight, mut stopped) = (adhesive(), adhesive());
    let (ends, _) = run(&mut straight, std::slice::from_ref(&stage));
    let mut progress = begin(&stage, &mut stopped).unwrap();
    let mut notes = Notes { stop_at: stopped.state().step() + 1000, ..Notes::default() };
    assert_eq!(follow(&stage, &mut progress, &mut stopped, &mut notes).unwrap(), Ending::Stopped);
    let text = serde_json::to_string(&progress).unwrap();
    let (mut stopped, text) = Simulation::restore(&stopped.checkpoint(&text).unwrap()).unwrap();
    let mut progress: StageProgress = serde_json::from_str(&text).unwrap();
    notes.stop_at = u64::MAX;
    let ending = follow(&stage, &mut progress, &mut stopped, &mut notes).unwrap();
    assert_eq!(ending, Ending::Complete(ends[0].reason));
    assert!(straight.state() == stopped.state());
}

/// What is recorded on the way changes neither the strength nor the step at which it is known.
#[test]
fn a_tensile_strength_does_not_depend_on_what_is_recorded() {
    // So slowly that the stress changes by less than the resolution of the strength in a step.
    let mut unloaded = adhesive();
    run(&mut unloaded, &[isotropic(Target::held(0.0), vec![REST], true)]);
    let stage = isotropic(Target::ramp(Ramp::To(-3e3)), vec![Until::RampOver], false);
    let [often, never] = [2e-7, f64::INFINITY].map(|interval| {
        let mut sample = unloaded.clone();
        let mut progress = begin(&stage, &mut sample).unwrap();
        let mut notes = Notes { next: interval, interval, ..Notes::default() };
        let ending = follow(&stage, &mut progress, &mut sample, &mut notes).unwrap();
        (ending, sample.state().step(), notes.taken.len())
    });
    assert!(often.2 > 500 && never.2 == 0, "{often:?} {never:?}");
    assert_eq!((often.0, often.1), (never.0, never.1));
}
