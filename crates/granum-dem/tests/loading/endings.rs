//! How stages end, are stopped, and go on.

use super::*;

/// Passes on to notes, and stops at every third call during work, 300 grains times 70 steps apart.
#[derive(Default)]
struct Impatient {
    notes: Notes,
    calls: u64,
}

impl SimulationObserver for Impatient {
    fn next_observation(&self) -> f64 {
        self.notes.next_observation()
    }
    fn observe(&mut self, state: &dyn granum_core::ObservedState) {
        self.notes.observe(state);
    }
    fn work(&mut self, _: &Work) -> Flow {
        self.calls += 1;
        if self.calls.is_multiple_of(3) { Flow::Stop } else { Flow::Continue }
    }
    fn work_every(&self) -> u64 {
        300 * 70
    }
}

#[test]
fn a_stage_that_is_stopped_between_its_checks_goes_on_with_the_same_bits() {
    let mut stage = expand("drained-triaxial", &[("axial_strain", 0.004)]).remove(0);
    stage.turns = Some(Turns { measure: Measure::Strain(0), high: 1e-3, low: -1e-3 });
    stage.until = vec![Until::Reversals(3)];
    let (mut straight, mut stopped) = (sample(), sample());
    let (ends, notes) = run(&mut straight, std::slice::from_ref(&stage));
    let (mut observer, mut stops) = (Impatient::default(), 0);
    let mut progress = begin(&stage, &mut stopped).unwrap();
    let reason = loop {
        match follow(&stage, &mut progress, &mut stopped, &mut observer).unwrap() {
            Ending::Complete(reason) => break reason,
            Ending::Stopped => stops += 1,
        }
        let bytes = stopped.checkpoint("").unwrap();
        stopped = Simulation::restore(&bytes).unwrap().0;
    };
    assert!(stops > 10, "{stops}");
    assert_eq!(reason, ends[0].reason);
    assert_eq!(observer.notes.taken, notes.taken);
    assert!(straight.state() == stopped.state());
}

/// A cell that shrinks presses the grains into each other: the stage ends and says why, and later where it may go farther.
#[test]
fn a_stage_ends_where_grains_overlap_too_far() {
    let speed = Speed::StrainRate(3e3);
    let control = Control::new(
        speed,
        [Drive::Rate(1.0), Drive::Rate(1.0), Drive::Rate(1.0), Drive::Fixed, Drive::Fixed, Drive::Fixed],
    );
    let until = Until::Reaches { measure: Measure::Strain(0), value: 0.5 };
    let mut stage = Stage::new("shrink", control, vec![until]);
    let mut strains = Vec::new();
    for limit in [0.1, 0.2] {
        stage.largest_overlap = limit;
        let mut s = sample();
        let (ends, _) = run(&mut s, std::slice::from_ref(&stage));
        let Reason::TooDeep { overlap, limit: told } = ends[0].reason else { panic!("{}", ends[0].reason) };
        assert!(told == limit && overlap > limit && overlap == s.state().largest_overlap(), "{overlap}");
        assert!(!ends[0].reason.is_asked_for());
        strains.push(s.state().strain()[0][0]);
    }
    assert!(strains[0] > 0.02 && strains[1] > 1.5 * strains[0], "{strains:?}");
}

/// None of its end conditions can be met: the stage ends all the same and reports why.
#[test]
fn no_stage_can_hang() {
    let mut s = sample();
    let held = Drive::Stress(Target::default());
    let fixed = Drive::Fixed;
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let until = Until::Reaches { measure: Measure::Strain(0), value: 0.1 };
    let hold = Control::new(speed, [held, held, held, fixed, fixed, fixed]);
    let mut stage = Stage::new("hold", hold, vec![until]);
    stage.most_arc_length = Some(1e-3);
    let (ends, _) = run(&mut s, &[stage]);
    assert!(matches!(ends[0].reason, Reason::TooLong { .. }), "{}", ends[0].reason);
    assert!(ends[0].reason.to_string().contains("none of its end conditions was met"));
}

/// With wide bands any steady segment counts as a critical state; the stage then ends before its strain is reached.
#[test]
fn a_stage_ends_at_a_critical_state() {
    let mut s = sample();
    let critical = Until::CriticalState { window: 0.01, stress_ratio: 0.4, volumetric_strain: 0.01 };
    let mut stage = expand("drained-triaxial", &[("axial_strain", 0.1)]).remove(0);
    stage.until.push(critical);
    let (ends, _) = run(&mut s, &[stage]);
    assert!(ends[0].reason.to_string().starts_with("critical state"), "{}", ends[0].reason);
}

/// Grains without adhesion have no tensile strength: a stage that asks for tension ends with this result.
#[test]
fn grains_without_adhesion_have_no_tensile_strength() {
    let mut s = sample();
    let fixed = Drive::Fixed;
    let pull = Drive::Rate(-1.0);
    let held = Drive::Stress(Target::held(-50e3));
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let until = Until::Reaches { measure: Measure::Strain(0), value: -0.1 };
    let control = Control::new(speed, [pull, held, held, fixed, fixed, fixed]);
    let (ends, _) = run(&mut s, &[Stage::new("pull", control, vec![until])]);
    let Reason::TensileStrength { strength, measure } = ends[0].reason else { panic!("{}", ends[0].reason) };
    assert!(strength < 20.0 && measure == Measure::Stress(1), "{}", ends[0].reason);
    assert!(ends[0].reason.is_asked_for());
}

/// A sample that loses a stress which its stage holds ends the stage, which reports this.
#[test]
fn a_sample_that_loses_its_stress_ends_a_stage() {
    let mut s = sample();
    let fixed = Drive::Fixed;
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let until = Until::Reaches { measure: Measure::Strain(0), value: -0.1 };
    let pull = Drive::Rate(-1.0);
    let held = Constraint::stresses([0.0, 1.0, -1.0, 0.0, 0.0, 0.0], Target::held(0.0));
    let control = Control::new(speed, [pull, pull, Drive::Free, fixed, fixed, fixed]).with(held);
    let (ends, _) = run(&mut s, &[Stage::new("pull", control, vec![until])]);
    assert!(ends[0].reason.to_string().contains("no longer carries stress"), "{}", ends[0].reason);
    assert!(!ends[0].reason.is_asked_for());
}

/// A stage that is saved halfway, together with its run state, continues to the same bits.
#[test]
fn a_stage_goes_on_to_the_same_bits_after_a_checkpoint() {
    let stage = {
        let mut stage = expand("constant-p-and-b", &[("axial_strain", 0.004)]).remove(0);
        stage.until.push(Until::CriticalState { window: 1e-3, stress_ratio: 1e-3, volumetric_strain: 1e-3 });
        stage.until.push(Until::AtRest { unbalanced_force: 1e-9 });
        stage
    };
    let whole = {
        let mut s = sample();
        run(&mut s, std::slice::from_ref(&stage));
        format!("{:?}", s.state())
    };
    let mut s = sample();
    let mut stage_progress = begin(&stage, &mut s).unwrap();
    let mut notes = Notes { stop_at: s.state().step() + 2000, ..Notes::default() };
    assert_eq!(follow(&stage, &mut stage_progress, &mut s, &mut notes).unwrap(), Ending::Stopped);
    let text = serde_json::to_string(&(&stage, &stage_progress)).unwrap();
    let (mut s, text) = Simulation::restore(&s.checkpoint(&text).unwrap()).unwrap();
    let (stage, mut stage_progress): (Stage, StageProgress) = serde_json::from_str(&text).unwrap();
    notes.stop_at = u64::MAX;
    follow(&stage, &mut stage_progress, &mut s, &mut notes).unwrap();
    assert!(format!("{:?}", s.state()) == whole);
}
