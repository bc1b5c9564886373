//! Every preset on small samples: accuracy of the controlled stresses, end conditions of stages, the same bits after a
//! checkpoint.

mod endings;
mod same_bits;
mod zero_stress;

use std::sync::OnceLock;

use granum_dem::assembly::Matrix;
use granum_dem::config::{ContactModel, Grains, Material, NormalKind, Preparation, TangentialKind};
use granum_dem::invariants;
use granum_dem::loading::preset::{Given, PathValue};
use granum_dem::loading::{
    Constraint, Control, Drive, Ending, History, HistoryQuantity, Measure, Ramp, Reason, Speed, Stage,
    StageEnd, StageProgress, Start, Target, Turns, Until, begin, follow, preset,
};
use granum_dem::observer::{Flow, NoObserver, SimulationObserver, SimulationProgress, Work};
use granum_dem::preparation::{SampleSpecification, prepare};
use granum_dem::simulation::{Hardware, Simulation};

/// A sample of 300 equal grains at rest at 20 kPa: Hertz without micro-slip, friction 0.3.
fn sample() -> Simulation {
    static SAMPLE: OnceLock<Simulation> = OnceLock::new();
    SAMPLE.get_or_init(|| prepared(NormalKind::HERTZ, 0.0)).clone()
}

/// 300 equal grains with a normal law and an interface energy, J/m2, at rest at 20 kPa.
fn prepared(normal: NormalKind, interface_energy: f64) -> Simulation {
    let material = Material::default().with(|material| material.interface_energy = interface_energy);
    let contact = ContactModel::new(normal, TangentialKind::NO_SLIP, 0.1);
    let grains = Grains::default().with(|grains| {
        grains.count = 300;
        grains.material = material;
    });
    let preparation = Preparation::default().with(|preparation| {
        preparation.friction = Some(0.1);
        preparation.solid_fraction = None;
        preparation.inertial_number = 3e-3;
        preparation.unbalanced_force = 2e-3;
    });
    let specification = SampleSpecification::new(&grains, &contact, &preparation);
    prepare(&specification, &mut NoObserver).unwrap().simulation
}

/// Records stress and strain at equal intervals of the record's measure; stops at a given step.
struct Notes {
    next: f64,
    interval: f64,
    taken: Vec<(Matrix, Matrix)>,
    stop_at: u64,
}

impl Default for Notes {
    fn default() -> Self {
        Notes { next: 2e-4, interval: 2e-4, taken: Vec::new(), stop_at: u64::MAX }
    }
}

impl SimulationObserver for Notes {
    fn next_observation(&self) -> f64 {
        self.next
    }
    fn observe(&mut self, state: &dyn granum_core::ObservedState) {
        let now = state.macro_state();
        self.taken.push((now.stress, now.strain));
        self.next += self.interval;
    }
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        if progress.steps >= self.stop_at { Flow::Stop } else { Flow::Continue }
    }
}

/// Runs stages one after another; returns their ends, and what was recorded in the last.
fn run(simulation: &mut Simulation, stages: &[Stage]) -> (Vec<StageEnd>, Notes) {
    let mut ends = Vec::new();
    let mut notes = Notes::default();
    let mut kept = None;
    for stage in stages {
        notes = Notes::default();
        match (stage.start, &kept) {
            (Start::Kept, _) => kept = Some(simulation.clone()),
            (Start::Back, Some(state)) => *simulation = Simulation::clone(state),
            _ => {}
        }
        let mut stage_progress = begin(stage, simulation).unwrap();
        let Ending::Complete(reason) = follow(stage, &mut stage_progress, simulation, &mut notes).unwrap()
        else {
            panic!("{} was stopped", stage.name)
        };
        let end = StageEnd::new(stage, &stage_progress, reason, simulation);
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
    let given: Given = parameters.iter().map(|(key, value)| (key.to_string(), (*value).into())).collect();
    preset::named(name).unwrap().expand(&given)
}

/// The same with words beside the numbers.
fn expand_with(name: &str, words: &[(&str, &str)], parameters: &[(&str, f64)]) -> Vec<Stage> {
    let numbers = parameters.iter().map(|(key, value)| (key.to_string(), (*value).into()));
    let words = words.iter().map(|(key, word)| (key.to_string(), (*word).into()));
    preset::named(name).unwrap().expand(&numbers.chain(words).collect())
}

/// The stage ended as requested, and every controlled stress was within half a per cent of p, root mean square.
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
    // After unloading, the lateral stress is higher than it was at the same axial stress during loading.
    assert!((stress[0][0] / 100e3 - 1.0).abs() < 0.01 && stress[1][1] > 0.5 * stress[0][0], "{stress:?}");
    assert!(strain[1][1] == 0.0 && strain[0][0] > 0.0, "{strain:?}");
}

/// A stress that increases at a given rate does not lag behind its target.
#[test]
fn a_stress_rate_is_followed() {
    let mut s = sample();
    let p = s.state().mean_stress();
    let (held, fixed) = (Drive::Stress(Target::default()), Drive::Fixed);
    // An increase by half in 60,000 steps.
    let rate = 0.5 * p / (60_000.0 * s.state().time_step());
    let rising = Drive::Stress(Target::current().moving(rate));
    let speed = Speed::InertialNumber { number: 1e-3, at: None };
    let control = Control::new(speed, [rising, held, held, fixed, fixed, fixed]);
    let until = Until::Reaches { measure: Measure::Stress(0), value: 1.4 * p };
    let (ends, _) = run(&mut s, &[Stage::new("stress rate", control, vec![until])]);
    assert_held(&ends[0]);
}

/// A shear stress held at zero while the sample is compressed.
#[test]
fn shear_stresses_are_held_too() {
    let mut s = sample();
    let held = Drive::Stress(Target::default());
    let zero = Drive::Stress(Target::held(0.0));
    let speed = Speed::InertialNumber { number: 1e-3, at: None };
    let control = Control::new(speed, [Drive::Rate(1.0), held, held, zero, zero, zero]);
    let until = Until::Reaches { measure: Measure::Strain(0), value: 0.01 };
    let (ends, notes) = run(&mut s, &[Stage::new("no shear", control, vec![until])]);
    assert_held(&ends[0]);
    let stress = notes.taken.last().unwrap().0;
    assert!([[1, 2], [2, 0], [0, 1]].iter().all(|[r, c]| stress[*r][*c].abs() < 0.02 * 20e3), "{stress:?}");
}

/// Two drained cycles between given strains; the stage counts its reversals.
#[test]
fn a_cyclic_stage_turns_round_and_counts() {
    let mut s = sample();
    let (held, fixed) = (Drive::Stress(Target::default()), Drive::Fixed);
    // When the strain rate reverses abruptly, the lateral stresses jump, but the less, the lower the rate.
    let speed = Speed::InertialNumber { number: 1e-4, at: None };
    let control = Control::new(speed, [Drive::Rate(1.0), held, held, fixed, fixed, fixed]);
    let turns = Turns { measure: Measure::Strain(0), high: 1e-3, low: -1e-3 };
    let mut stage = Stage::new("cyclic", control, vec![Until::Reversals(4)]);
    stage.turns = Some(turns);
    let (ends, notes) = run(&mut s, &[stage]);
    assert_held(&ends[0]);
    assert_eq!(ends[0].reason.to_string(), "it was reversed 4 times");
    let strains = || notes.taken.iter().map(|(_, strain)| strain[0][0]);
    let (low, high) = (strains().fold(1.0, f64::min), strains().fold(-1.0, f64::max));
    assert!(low < -0.8e-3 && low > -1.01e-3 && high > 0.8e-3 && high < 1.01e-3, "{low} {high}");
}

fn mean_of(notes: &Notes, of: impl Fn(&Matrix, &Matrix) -> f64) -> f64 {
    let late = &notes.taken[notes.taken.len() / 2..];
    late.iter().map(|(stress, strain)| of(stress, strain)).sum::<f64>() / late.len() as f64
}

#[test]
fn after_isotropic_unloading_a_part_of_the_compression_remains() {
    let mut s = sample();
    let before = s.state().solid_fraction();
    let stages = expand("isotropic", &[("mean_stress", 80e3), ("unloading_stress", 20e3)]);
    let (ends, _) = run(&mut s, &stages);
    ends.iter().for_each(assert_held);
    assert!(s.state().solid_fraction() > before, "{} {before}", s.state().solid_fraction());
    assert!((s.state().mean_stress() / 20e3 - 1.0).abs() < 0.01);
}

#[test]
fn the_lateral_stress_ratio_of_an_oedometer_is_sensible() {
    let mut s = sample();
    let (ends, notes) = run(&mut s, &expand("oedometer", &[("axial_stress", 200e3)]));
    assert!(ends[0].reason.is_asked_for());
    let at_rest = mean_of(&notes, |stress, _| 0.5 * (stress[1][1] + stress[2][2]) / stress[0][0]);
    println!("K0 = {at_rest:.3}");
    assert!((0.3..0.9).contains(&at_rest), "K0 = {at_rest}");
}

#[test]
fn plane_strain_holds_one_stress_and_one_strain() {
    let mut s = sample();
    let (ends, notes) = run(&mut s, &expand("plane-strain", &[("axial_strain", 0.02)]));
    assert_held(&ends[0]);
    let (stress, strain) = *notes.taken.last().unwrap();
    assert!(strain[1][1] == 0.0 && (stress[2][2] / 20e3 - 1.0).abs() < 0.03, "{stress:?}");
    assert!(stress[0][0] > stress[1][1] && stress[1][1] > stress[2][2], "{stress:?}");
}

#[test]
fn proportional_strains_keep_their_ratio() {
    let mut s = sample();
    let (ends, _) =
        run(&mut s, &expand("proportional", &[("ratio_y", 0.25), ("ratio_z", -0.5), ("axial_strain", 0.01)]));
    assert!(ends[0].reason.is_asked_for());
    let strain = s.state().strain();
    assert!(
        (strain[1][1] / strain[0][0] - 0.25).abs() < 1e-9 && (strain[2][2] / strain[0][0] + 0.5).abs() < 1e-9
    );
}

#[test]
fn proportional_stresses_keep_their_ratio() {
    let mut s = sample();
    let parameters = [("ratio_y", 0.6), ("ratio_z", 0.8), ("axial_strain", 0.01), ("axial_stress", 200e3)];
    let (ends, _) = run(&mut s, &expand_with("proportional", &[("ratios_of", "stress")], &parameters));
    assert_eq!(ends.len(), 2);
    ends.iter().for_each(assert_held);
    let stress = s.state().stress();
    let [y, z] = [1, 2].map(|a| stress[a][a] / stress[0][0]);
    assert!((y - 0.6).abs() < 0.01 && (z - 0.8).abs() < 0.01, "{y} {z}");
}

/// A compressible pore fluid: between drained and undrained, and the cell pressure stays.
#[test]
fn a_compressible_fluid_keeps_the_total_lateral_stress() {
    let mut s = sample();
    let modulus = 20e6;
    let stages = expand("undrained-triaxial", &[("axial_strain", 0.01), ("fluid_modulus", modulus)]);
    let before = s.state().stress()[2][2];
    let (ends, notes) = run(&mut s, &stages);
    assert_held(&ends[0]);
    let total = mean_of(&notes, |stress, strain| stress[2][2] + modulus * invariants::trace(strain));
    assert!((total / before - 1.0).abs() < 0.02, "{total} {before}");
    assert!(invariants::trace(&s.state().strain()).abs() > 1e-5);
}

fn extremes(notes: &Notes, of: impl Fn(&Matrix, &Matrix) -> f64) -> [f64; 2] {
    let values = notes.taken.iter().map(|(stress, strain)| of(stress, strain));
    values.fold([f64::MAX, f64::MIN], |[low, high], value| [low.min(value), high.max(value)])
}

#[test]
fn drained_cycles_turn_at_their_strains() {
    let mut s = sample();
    let numbers = [("strain_amplitude", 1e-3), ("mean_strain", 5e-4), ("cycles", 2.0)];
    let (ends, notes) = run(&mut s, &expand_with("cyclic", &[("drainage", "drained")], &numbers));
    assert_held(&ends[0]);
    assert_eq!(ends[0].reason, Reason::End(Until::Reversals(4)));
    let [low, high] = extremes(&notes, |_, strain| strain[0][0]);
    assert!(low > -5.1e-4 && low < -2e-4 && high < 1.51e-3 && high > 1.2e-3, "{low} {high}");
}

#[test]
fn undrained_cycles_turn_at_their_stresses_or_end_at_a_double_amplitude() {
    let mut s = sample();
    let before = s.state().cell().volume();
    let numbers = [("stress_amplitude", 4e3), ("cycles", 2.0)];
    let (ends, notes) = run(&mut s, &expand("cyclic", &numbers));
    assert_eq!(ends[0].reason, Reason::End(Until::Reversals(4)));
    assert_held(&ends[0]);
    assert!((s.state().cell().volume() / before - 1.0).abs() < 1e-6);
    let [low, high] = extremes(&notes, |stress, _| invariants::axial_deviator(stress));
    assert!(low > -4.6e3 && high < 4.6e3, "{low} {high}");

    let numbers = [("stress_amplitude", 9e3), ("cycles", 10.0), ("double_amplitude", 1e-4)];
    let (ends, _) = run(&mut sample(), &expand("cyclic", &numbers));
    assert!(matches!(ends[0].reason, Reason::End(Until::DoubleAmplitude { .. })), "{}", ends[0].reason);
}

/// Large cycles at constant volume take the mean stress off.
#[test]
fn undrained_cycles_end_at_a_pore_pressure_ratio() {
    let mut s = sample();
    let before = s.state().mean_stress();
    let numbers = [("strain_amplitude", 5e-4), ("cycles", 10.0), ("pore_pressure_ratio", 0.3)];
    let (ends, _) = run(&mut s, &expand("cyclic", &numbers));
    assert_eq!(ends[0].reason, Reason::End(Until::PorePressureRatio(0.3)), "{}", ends[0].reason);
    assert!(s.state().mean_stress() <= 0.7 * before);
}

#[test]
fn unloading_loops_take_the_deviator_stress_off_and_put_it_on() {
    let mut s = sample();
    // So few grains jump too far where the strain rate turns round at 1e-3; an unloading is over in a few hundred steps.
    let numbers = [("axial_strain", 0.012), ("inertial_number", 3e-4)];
    let mut given: Given = numbers.map(|(key, value)| (key.to_string(), value.into())).into();
    given.insert("at".into(), PathValue::List(vec![0.005, 0.008, 0.5]));
    let stages = preset::named("unload-reload").unwrap().expand(&given);
    assert_eq!(stages.len(), 5);
    let mut deviators = Vec::new();
    for stage in &stages {
        let (ends, _) = run(&mut s, std::slice::from_ref(stage));
        assert_held(&ends[0]);
        deviators.push(invariants::axial_deviator(&s.state().stress()));
    }
    assert!(deviators[1] <= 0.0 && deviators[3] <= 0.0 && deviators[2] > 0.8 * deviators[0], "{deviators:?}");
    assert!((s.state().strain()[0][0] / 0.012 - 1.0).abs() < 1e-3);
}

#[test]
fn a_hold_keeps_stresses_or_strains() {
    let loaded = || {
        let mut s = sample();
        run(&mut s, &expand("drained-triaxial", &[("axial_strain", 0.005)]));
        s
    };
    let mut s = loaded();
    let (before, strain) = (s.state().stress(), expand("hold", &[]));
    let (ends, _) = run(&mut s, &strain);
    assert_held(&ends[0]);
    assert!((s.state().stress()[0][0] / before[0][0] - 1.0).abs() < 0.01);
    assert!(s.state().strain()[0][0].abs() > 0.0 && s.state().unbalanced_force() < 1e-3);

    let mut s = loaded();
    let duration = 5000.0 * s.state().time_step();
    let (ends, _) = run(&mut s, &expand_with("hold", &[("held", "strain")], &[("duration", duration)]));
    assert!(ends[0].reason.is_asked_for() && s.state().strain() == [[0.0; 3]; 3]);
}

#[test]
fn a_history_is_followed_row_by_row() {
    let mut s = sample();
    let columns = vec![HistoryQuantity::Strain(0), HistoryQuantity::Stress(1), HistoryQuantity::Stress(2)];
    let rows = vec![vec![0.0, -20e3, -20e3], vec![-0.004, -24e3, -24e3], vec![-0.003, -22e3, -26e3]];
    let mut given = Given::from([("compression".into(), "negative".into())]);
    given.insert("file".into(), PathValue::History(History { columns, rows }));
    let stages = preset::named("history").unwrap().expand(&given);
    for (k, wanted) in [(1, [0.004, 24e3, 24e3]), (2, [0.003, 22e3, 26e3])] {
        let part = if k == 1 { &stages[..2] } else { &stages[2..] };
        let (ends, _) = run(&mut s, part);
        ends.iter().filter(|end| end.steps > 0).for_each(assert_held);
        let (stress, strain) = (s.state().stress(), s.state().strain());
        assert!((strain[0][0] / wanted[0] - 1.0).abs() < 1e-4, "{strain:?}");
        for a in 1..3 {
            assert!((stress[a][a] / wanted[a] - 1.0).abs() < 0.02, "{stress:?}");
        }
    }
}

/// Each probe begins from the same state; opposite increments have nearly opposite responses, and their size is what was asked.
#[test]
fn probes_begin_from_one_state() {
    let mut s = sample();
    let stages = expand("probes", &[("directions", 4.0), ("unbalanced_force", 1e-3)]);
    assert_eq!(stages.len(), 1 + 2 * 4);
    let mut kept: Option<Simulation> = None;
    let mut responses = Vec::new();
    for stage in &stages {
        match stage.start {
            Start::Kept => kept = Some(s.clone()),
            Start::Back => s = kept.clone().unwrap(),
            Start::Here => {}
        }
        let before = s.state().stress();
        let (ends, _) = run(&mut s, std::slice::from_ref(stage));
        assert!(ends[0].reason.is_asked_for());
        if stage.name.starts_with("probe") {
            let strain = s.state().strain();
            let size = (0..3).map(|a| strain[a][a].powi(2)).sum::<f64>().sqrt();
            assert!((size / 1e-5 - 1.0).abs() < 0.01, "{size}");
            responses.push((0..3).map(|a| s.state().stress()[a][a] - before[a][a]).collect::<Vec<_>>());
        }
    }
    println!("{responses:?}");
    assert!(responses[0][0] > 0.0 && responses[2][0] < 0.0);
    assert!((responses[0][0] / -responses[2][0] - 1.0).abs() < 0.5, "{responses:?}");
}

/// Stresses and constraints along a ramp arrive together, where they were sent.
#[test]
fn ramps_of_stress_arrive_together() {
    let mut s = sample();
    let fixed = Drive::Fixed;
    let to = |value: f64| Drive::Stress(Target::ramp(Ramp::To(value)));
    let speed = Speed::InertialNumber { number: 1e-3, at: None };
    let control = Control::new(
        speed,
        [to(26e3), to(22e3), Drive::Stress(Target::ramp(Ramp::By(1e3))), fixed, fixed, fixed],
    );
    let last = s.state().stress()[2][2] + 1e3;
    let (ends, _) = run(&mut s, &[Stage::new("ramp", control, vec![Until::RampOver])]);
    assert_held(&ends[0]);
    let stress = s.state().stress();
    for (a, wanted) in [26e3, 22e3, last].into_iter().enumerate() {
        assert!((stress[a][a] / wanted - 1.0).abs() < 0.02, "{stress:?}");
    }
}
