//! Every preset on small samples: how well stresses are held, how stages end, the same bits after a checkpoint.

use std::collections::BTreeMap;
use std::sync::OnceLock;

use granum_dem::assembly::Matrix;
use granum_dem::config::{Contact, Grains, Material, NormalKind, Preparation, TangentialKind};
use granum_dem::invariants;
use granum_dem::loading::{
    Control, Drive, Ending, Measure, Reason, Speed, Stage, StageEnd, StageProgress, Target, Turns, Until,
    begin, follow, preset,
};
use granum_dem::observer::{Flow, Observer, Progress};
use granum_dem::preparation::{Recipe, prepare};
use granum_dem::simulation::{Hardware, Simulation};

/// 300 equal grains at rest at 20 kPa: Hertz, no-slip, friction 0.3.
fn sample() -> Simulation {
    static SAMPLE: OnceLock<Simulation> = OnceLock::new();
    let make = || {
        let material = Material { interface_energy: 0.0, ..Material::default() };
        let contact = Contact::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
        let grains = Grains { count: 300, material, ..Grains::default() };
        let preparation = Preparation {
            friction: Some(0.1),
            solid_fraction: None,
            inertial_number: 3e-3,
            unbalanced_force: 2e-3,
            ..Preparation::default()
        };
        let hardware = Hardware::default();
        let recipe = Recipe {
            grains: &grains,
            contact: &contact,
            preparation: &preparation,
            time_step_factor: 0.2,
            hardware,
        };
        prepare(&recipe, &mut |_: &Progress| Flow::Continue).unwrap().simulation
    };
    SAMPLE.get_or_init(make).clone()
}

/// Notes the stress and strain at every 2e-4 of the record's measure; stops at a step where it is told to.
struct Notes {
    next: f64,
    taken: Vec<(Matrix, Matrix)>,
    stop_at: u64,
}

impl Default for Notes {
    fn default() -> Self {
        Notes { next: 2e-4, taken: Vec::new(), stop_at: u64::MAX }
    }
}

impl Observer for Notes {
    fn next_look(&self) -> f64 {
        self.next
    }
    fn look(&mut self, simulation: &Simulation) {
        self.taken.push((simulation.state().stress(), simulation.state().strain()));
        self.next += 2e-4;
    }
    fn progress(&mut self, progress: &Progress) -> Flow {
        if progress.steps >= self.stop_at { Flow::Stop } else { Flow::Continue }
    }
}

/// Runs stages one after another; what each came to, and what was noted in the last.
fn run(simulation: &mut Simulation, stages: &[Stage]) -> (Vec<StageEnd>, Notes) {
    let mut ends = Vec::new();
    let mut notes = Notes::default();
    for stage in stages {
        notes = Notes::default();
        let mut stage_progress = begin(stage, simulation).unwrap();
        let Ending::Complete(reason) = follow(stage, &mut stage_progress, simulation, &mut notes).unwrap()
        else {
            panic!("{} was stopped", stage.name)
        };
        let end = StageEnd::of(stage, &stage_progress, reason, simulation);
        let error = &end.servo_error;
        println!(
            "{}: {reason}; {} steps, servo rms {:.4} % largest {:.4} %",
            end.name,
            end.steps,
            100.0 * error.rms(),
            100.0 * error.largest()
        );
        ends.push(end);
    }
    (ends, notes)
}

fn expand(name: &str, parameters: &[(&str, f64)]) -> Vec<Stage> {
    let given: BTreeMap<String, f64> =
        parameters.iter().map(|(key, value)| (key.to_string(), *value)).collect();
    preset::named(name).unwrap().expand(&given)
}

/// The stage ended as asked, and every controlled stress was within half a per cent of p, root mean square.
fn assert_held(end: &StageEnd) {
    let rms = end.servo_error.rms();
    assert!(end.reason.is_asked_for(), "{}: {}", end.name, end.reason);
    assert!(end.servo_error.steps[0] > 0 && rms < 0.005, "{}: rms {rms}", end.name);
}

#[test]
fn isotropic_compression_comes_to_rest_at_its_stress() {
    let mut s = sample();
    let (ends, _) = run(&mut s, &expand("isotropic", &[("mean_stress", 30e3)]));
    assert_held(&ends[0]);
    for a in 0..3 {
        assert!((s.state().stress()[a][a] / 30e3 - 1.0).abs() < 0.01, "{:?}", s.state().stress());
    }
    assert!(s.state().unbalanced_force() < 1e-3);
}

#[test]
fn drained_triaxial_holds_the_lateral_stresses() {
    for strain in [0.02, -0.01] {
        let mut s = sample();
        let before = s.state().stress();
        let (ends, notes) = run(&mut s, &expand("drained-triaxial", &[("axial_strain", strain)]));
        assert_held(&ends[0]);
        let last = notes.taken.last().unwrap();
        for a in 1..3 {
            assert!((last.0[a][a] / before[a][a] - 1.0).abs() < 0.02, "{:?}", last.0);
        }
        let q = invariants::signed_von_mises(&last.0);
        assert!(q * strain > 0.0 && q.abs() > 5e3, "q = {q}");
        assert!((s.state().strain()[0][0] / strain - 1.0).abs() < 1e-3);
    }
}

#[test]
fn a_test_at_another_lateral_stress_is_consolidated_before() {
    let mut s = sample();
    let stages = expand("drained-triaxial", &[("axial_strain", 0.005), ("lateral_stress", 30e3)]);
    let (ends, notes) = run(&mut s, &stages);
    assert_eq!(ends.len(), 2);
    assert!(ends.iter().all(|end| end.reason.is_asked_for()));
    assert_held(&ends[1]);
    assert!((notes.taken.last().unwrap().0[2][2] / 30e3 - 1.0).abs() < 0.02);
}

#[test]
fn undrained_triaxial_keeps_the_volume() {
    let mut s = sample();
    let before = s.state().cell().volume();
    let (ends, notes) = run(&mut s, &expand("undrained-triaxial", &[("axial_strain", 0.01)]));
    assert!(ends[0].reason.is_asked_for());
    assert!((s.state().cell().volume() / before - 1.0).abs() < 1e-4);
    assert!(invariants::signed_von_mises(&notes.taken.last().unwrap().0) > 5e3);
}

#[test]
fn constant_p_and_b_holds_both() {
    for b in [0.0, 0.5, 1.0] {
        let mut s = sample();
        let (ends, notes) = run(&mut s, &expand("constant-p-and-b", &[("axial_strain", 0.02), ("b", b)]));
        assert_held(&ends[0]);
        let late = &notes.taken[notes.taken.len() / 2..];
        let mean = late.iter().map(|(stress, _)| {
            let (x, y, z) = (stress[0][0], stress[1][1], stress[2][2]);
            ((y - z) / (x - z), (x + y + z) / 3.0)
        });
        let n = late.len() as f64;
        let (found, p) = mean.fold((0.0, 0.0), |sum, (b, p)| (sum.0 + b / n, sum.1 + p / n));
        println!("b {b}: {found:.4}, p {p:.1}");
        assert!((found - b).abs() < 0.01 && (p / 20e3 - 1.0).abs() < 0.01, "b = {found}, p = {p}");
    }
}

#[test]
fn simple_shear_holds_the_normal_stress() {
    let mut s = sample();
    let normal = s.state().stress()[1][1];
    let (ends, notes) = run(&mut s, &expand("simple-shear", &[("shear_strain", 0.03)]));
    assert_held(&ends[0]);
    let (stress, strain) = notes.taken.last().unwrap();
    assert!((stress[1][1] / normal - 1.0).abs() < 0.02, "{stress:?}");
    assert!(stress[0][1] > 2e3 && strain[0][0] == 0.0 && strain[1][0] == 0.0);
}

#[test]
fn simple_shear_at_constant_volume_strains_no_axis() {
    let mut s = sample();
    let before = s.state().cell().volume();
    let (ends, _) = run(&mut s, &expand("simple-shear-constant-volume", &[("shear_strain", 0.01)]));
    assert!(ends[0].reason.is_asked_for());
    assert!((s.state().cell().volume() / before - 1.0).abs() < 1e-9);
}

#[test]
fn oedometer_loads_and_unloads() {
    let mut s = sample();
    let stages = expand("oedometer", &[("axial_stress", 400e3), ("unloading_stress", 100e3)]);
    let (ends, _) = run(&mut s, &stages);
    assert!(ends.iter().all(|end| end.reason.is_asked_for()) && ends.len() == 2);
    let (stress, strain) = (s.state().stress(), s.state().strain());
    // Unloaded, more lateral stress is left than the same axial stress began with.
    assert!((stress[0][0] / 100e3 - 1.0).abs() < 0.01 && stress[1][1] > 0.5 * stress[0][0], "{stress:?}");
    assert!(strain[1][1] == 0.0 && strain[0][0] > 0.0, "{strain:?}");
}

/// A stress that rises at a rate does not lag behind.
#[test]
fn a_stress_rate_is_followed() {
    let mut s = sample();
    let p = s.state().mean_stress();
    let (held, fixed) = (Drive::Stress(Target::default()), Drive::Fixed);
    // Half as much again in 60,000 steps.
    let rate = 0.5 * p / (60_000.0 * s.state().time_step());
    let rising = Drive::Stress(Target { value: None, rate });
    let speed = Speed::InertialNumber { number: 1e-3, at: None };
    let control = Control::of(speed, [rising, held, held, fixed, fixed, fixed]);
    let until = Until::Reaches { measure: Measure::Stress(0), value: 1.4 * p };
    let (ends, _) = run(&mut s, &[Stage::new("stress rate", control, vec![until])]);
    assert_held(&ends[0]);
}

/// A shear stress held at zero while the sample is compressed.
#[test]
fn shear_stresses_are_held_too() {
    let mut s = sample();
    let held = Drive::Stress(Target::default());
    let zero = Drive::Stress(Target { value: Some(0.0), rate: 0.0 });
    let speed = Speed::InertialNumber { number: 1e-3, at: None };
    let control = Control::of(speed, [Drive::Rate(1.0), held, held, zero, zero, zero]);
    let until = Until::Reaches { measure: Measure::Strain(0), value: 0.01 };
    let (ends, notes) = run(&mut s, &[Stage::new("no shear", control, vec![until])]);
    assert_held(&ends[0]);
    let stress = notes.taken.last().unwrap().0;
    assert!([[1, 2], [2, 0], [0, 1]].iter().all(|[r, c]| stress[*r][*c].abs() < 0.02 * 20e3), "{stress:?}");
}

/// Two cycles between strains, drained; the stage counts its reversals.
#[test]
fn a_cyclic_stage_turns_round_and_counts() {
    let mut s = sample();
    let (held, fixed) = (Drive::Stress(Target::default()), Drive::Fixed);
    // Where the strain rate turns round at once, the lateral stresses jump; the slower, the less.
    let speed = Speed::InertialNumber { number: 1e-4, at: None };
    let control = Control::of(speed, [Drive::Rate(1.0), held, held, fixed, fixed, fixed]);
    let turns = Turns { measure: Measure::Strain(0), high: 1e-3, low: -1e-3 };
    let stage = Stage { turns: Some(turns), ..Stage::new("cyclic", control, vec![Until::Reversals(4)]) };
    let (ends, notes) = run(&mut s, &[stage]);
    assert_held(&ends[0]);
    assert_eq!(ends[0].reason.to_string(), "it was turned round 4 times");
    let strains = || notes.taken.iter().map(|(_, strain)| strain[0][0]);
    let (low, high) = (strains().fold(1.0, f64::min), strains().fold(-1.0, f64::max));
    assert!(low < -0.8e-3 && low > -1.01e-3 && high > 0.8e-3 && high < 1.01e-3, "{low} {high}");
}

/// None of its ends can come: the stage ends all the same, and says why.
#[test]
fn no_stage_can_hang() {
    let mut s = sample();
    let held = Drive::Stress(Target::default());
    let fixed = Drive::Fixed;
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let until = Until::Reaches { measure: Measure::Strain(0), value: 0.1 };
    let hold = Control::of(speed, [held, held, held, fixed, fixed, fixed]);
    let stage = Stage { most_arc_length: Some(1e-3), ..Stage::new("hold", hold, vec![until]) };
    let (ends, _) = run(&mut s, &[stage]);
    assert!(matches!(ends[0].reason, Reason::TooLong { .. }), "{}", ends[0].reason);
    assert!(ends[0].reason.to_string().contains("none of its ends came"));
}

/// A loose window makes any steady stretch a critical state; a stage then ends before its strain is reached.
#[test]
fn a_stage_ends_at_a_critical_state() {
    let mut s = sample();
    let critical = Until::CriticalState { window: 0.01, stress_ratio: 0.4, volumetric_strain: 0.01 };
    let mut stage = expand("drained-triaxial", &[("axial_strain", 0.1)]).remove(0);
    stage.until.push(critical);
    let (ends, _) = run(&mut s, &[stage]);
    assert!(ends[0].reason.to_string().starts_with("critical state"), "{}", ends[0].reason);
}

/// A sample that is pulled apart no longer carries stress; the stage says so and ends.
#[test]
fn a_sample_that_carries_nothing_ends_a_stage() {
    let mut s = sample();
    let fixed = Drive::Fixed;
    let pull = Drive::Rate(-1.0);
    let held = Drive::Stress(Target { value: Some(-50e3), rate: 0.0 });
    let speed = Speed::InertialNumber { number: 1e-2, at: None };
    let until = Until::Reaches { measure: Measure::Strain(0), value: -0.1 };
    let control = Control::of(speed, [pull, held, held, fixed, fixed, fixed]);
    let (ends, _) = run(&mut s, &[Stage::new("pull", control, vec![until])]);
    assert!(ends[0].reason.to_string().contains("no longer carries stress"), "{}", ends[0].reason);
}

/// A stage that is written down in the middle, with what it has to remember, goes on to the same bits.
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
