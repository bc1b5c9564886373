//! Tangential laws compared with analytical solutions: Mindlin-Deresiewicz curves and loops, sliding, passivity.

use super::*;
use crate::contact::choice::kind::TangentialKind;
use crate::contact::law::Normal;
use crate::contact::law::limits::{LAW_CHANNELS, MAX_HISTORY};
use crate::contact::tangential::mindlin_deresiewicz::MindlinDeresiewiczConstants;
use proptest::prelude::*;

/// Column of the stage in the history of the law.
const STAGE: usize = 6;

/// A contact in the units `mu F = 1`, `8 G* a = 1`, driven along one direction.
struct Unit {
    constants: MindlinDeresiewiczConstants<f64>,
    history: [f64; MAX_HISTORY],
    force: f64,
}

impl Unit {
    fn new() -> Self {
        let pair = PairProperties { effective_shear_modulus: 0.125, friction: 0.5, ..spheres(0.0) };
        Unit {
            constants: MindlinDeresiewicz::prepare(&pair, &PLAIN, &[]),
            history: [0.0; MAX_HISTORY],
            force: 0.0,
        }
    }

    /// A step at a load F (mu is 1/2); the radius stays 1.
    fn step(&mut self, load: f64, slip: f64) -> f64 {
        let normal = Normal {
            force: load,
            radius: 1.0,
            stiffness: 1.0,
            root_stiffness: 1.0,
            tangential_measure: 1.0,
            root_tangential_measure: 1.0,
            friction_load: load,
            touching: true,
        };
        // Oblique in the plane, so that both components are tested.
        let increment = [0.6 * slip, -0.8 * slip];
        let out = MindlinDeresiewicz::update(
            &self.constants,
            &normal,
            increment,
            &mut self.history,
            &mut [0.0; LAW_CHANNELS],
        );
        self.force = 0.6 * out.force[0] - 0.8 * out.force[1];
        assert!((0.8 * out.force[0] + 0.6 * out.force[1]).abs() < 1e-10);
        self.force
    }

    /// Moves by a total slip in equal steps at a load of 2 and returns the work done.
    fn travel(&mut self, total: f64, steps: usize) -> f64 {
        let slip = total / steps as f64;
        (0..steps)
            .map(|_| {
                let before = self.force;
                slip * 0.5 * (before + self.step(2.0, slip))
            })
            .sum()
    }
}

/// Fraction t of the limit at the reversal, displacement there, force after the return to zero displacement, work lost in a
/// cycle, and the same for the incremental law with 200 steps per quarter.
const LOOP: [(f64, f64, f64, f64, f64); 5] = [
    (0.25, 0.261777281665, -0.005980776538, 0.004175495657, 0.00417549),
    (0.50, 0.555059212579, -0.028532643274, 0.042260535347, 0.04226164),
    (0.75, 0.904724605512, -0.082626627277, 0.199843343150, 0.19986719),
    (0.90, 1.176834796495, -0.152482698834, 0.481485969700, 0.48164235),
    (1.0, 1.5, f64::NAN, 1.2, 1.20498755),
];

#[test]
fn hysteresis_loop_follows_the_table() {
    for (share, displacement, back, exact, stepped) in LOOP {
        let cycle = |quarter: usize| {
            let mut contact = Unit::new();
            contact.step(2.0, 0.0);
            contact.travel(displacement, quarter);
            let turn = contact.force;
            let mut lost = contact.travel(-displacement, quarter);
            let home = contact.force;
            lost += contact.travel(-displacement, quarter);
            lost += contact.travel(2.0 * displacement, 2 * quarter);
            (turn, home, lost, contact.force)
        };
        let (turn, home, lost, end) = cycle(200);
        println!(
            "t {share}: turn off by {:.1e}, back by {:.1e}, loss {lost:.8} (table {stepped}), exact off by {:.1e}",
            turn - share,
            home - back,
            lost - exact
        );
        let (fine_turn, fine_home, fine_lost, _) = cycle(20_000);
        println!(
            "   with 20000 steps: {:.1e} {:.1e} {:.1e}",
            fine_turn - share,
            fine_home - back,
            fine_lost - exact
        );
        assert!((lost - stepped).abs() < 1e-7, "{lost} {stepped}");
        assert!((end - share).abs() < 6e-3);
        assert!((fine_turn - share).abs() < 1e-4 && (fine_lost - exact).abs() < 1e-4);
        assert!(share == 1.0 || (fine_home - back).abs() < 1e-4);
    }
}

/// Mindlin and Deresiewicz at constant load: `T = mu N (1 - (1 - delta/C)^(3/2))`, sliding at `C`.
#[test]
fn loading_at_constant_load_is_analytic() {
    let mut contact = Unit::new();
    contact.step(2.0, 0.0);
    for k in 1..=20_000 {
        let force = contact.step(2.0, 1e-4);
        let rest = (1.0 - k as f64 * 1e-4 / 1.5f64).max(0.0);
        assert!((force - (1.0 - rest.powf(1.5))).abs() < 1e-4, "{k}: {force}");
    }
    assert_eq!(contact.force, 1.0);
}

/// The consistency that Mindlin and Deresiewicz require: with `ddelta = mu dN / 8 G* a` the force follows `mu dN`.
#[test]
fn growing_together_does_not_slip() {
    let mut contact = Unit::new();
    contact.step(2.0, 0.0);
    contact.travel(0.4, 1000);
    let start = contact.force;
    for k in 1..=1000 {
        let force = contact.step(2.0 + 2e-3 * k as f64, 1e-3);
        assert!((force - start - 1e-3 * k as f64).abs() < 1e-12);
    }
}

/// Load first, then shear: an implementation that accumulates the condition for theta = 1 would fail this test.
#[test]
fn load_then_shear_is_the_constant_load_curve() {
    let mut contact = Unit::new();
    for k in 1..=1000 {
        contact.step(2e-3 * k as f64, 0.0);
    }
    contact.travel(0.6, 20_000);
    assert!((contact.force - (1.0 - (1.0 - 0.4f64).powf(1.5))).abs() < 2e-5);
}

/// A small loop closes at its turning point, and beyond that point the curve of first loading continues.
#[test]
fn turning_points_are_met_again() {
    let mut contact = Unit::new();
    contact.step(2.0, 0.0);
    contact.travel(0.8, 8000);
    let first = contact.force;
    contact.travel(-0.3, 3000);
    assert_eq!(contact.history[STAGE], 1.0);
    contact.travel(0.299, 2990);
    assert_eq!(contact.history[STAGE], 2.0);
    contact.travel(0.001, 10);
    assert!((contact.force - first).abs() < 1e-3, "{} {first}", contact.force);
    contact.travel(0.3, 3000);
    assert_eq!(contact.history[STAGE], 0.0);
    let virgin = 1.0 - (1.0 - 1.1f64 / 1.5).powf(1.5);
    assert!((contact.force - virgin).abs() < 1e-3, "{} {virgin}", contact.force);
    // In the opposite direction, past the mirror image of the turning point.
    let turn = contact.force;
    contact.travel(-2.3, 23_000);
    assert_eq!(contact.history[STAGE], 0.0);
    let mirrored = -(1.0 - (1.0 - 1.2f64 / 1.5).powf(1.5));
    assert!((contact.force - mirrored).abs() < 1e-3, "{} {mirrored} {turn}", contact.force);
}

#[test]
fn no_slip_rescales_when_the_contact_shrinks() {
    let pair = spheres(0.0);
    let mut bench = Bench::new((NormalKind::HERTZ, TangentialKind::NO_SLIP), pair);
    bench.step(4e-8, [0.0; 2]);
    let high = tangential(&bench.step(4e-8, [1e-10, 0.0]))[0];
    // Half the radius, then back: the force is scaled down, but not up again.
    let low = tangential(&bench.step(1e-8, [0.0; 2]))[0];
    assert!((low / high - 0.5).abs() < 1e-11);
    let again = tangential(&bench.step(4e-8, [0.0; 2]))[0];
    assert!((again / low - 1.0).abs() < 1e-12);
}

/// Thornton (1991): an adhesive contact slides at `mu (N + 2 N_c)`, also without load and under tension.
fn slides_at_the_limit(laws: LawPair) {
    let pair = spheres(0.6);
    for approach in [3e-9, 1e-8, 5e-8] {
        let mut bench = Bench::new(laws, pair);
        let mut last = bench.step(approach, [0.0; 2]);
        let load = bench.friction_load(approach);
        let (mut work, mut friction) = (0.0, 0.0);
        for _ in 0..12_000 {
            last = bench.step(approach, [6e-12, 8e-12]);
            work += last.tangential_work;
            friction += last.friction_loss;
        }
        let force = tangential(&last);
        assert!(last.sliding);
        assert!((force[0].hypot(force[1]) / (0.3 * load) - 1.0).abs() < 1e-10);
        assert!((force[1] / force[0] - 4.0 / 3.0).abs() < 1e-9);
        // The energy of the sliding beyond the limit is lost: less than all the work, but more than half of it.
        assert!(friction > 0.5 * work && friction < work, "{friction} {work}");
    }
}

#[test]
fn sliding_stands_at_the_limit() {
    super::ALL.into_iter().for_each(slides_at_the_limit);
}

/// A path of slip, in steps of 1e-11 m.
fn path() -> impl Strategy<Value = Vec<(usize, f64, f64)>> {
    prop::collection::vec((1usize..60, 0.0f64..std::f64::consts::TAU, 0.2f64..1.0), 1..8)
}

/// Starting from zero force, no path at constant load returns more energy than was put in.
fn least_work(laws: LawPair, path: &[(usize, f64, f64)], overlap: f64) -> f64 {
    let mut bench = Bench::new(laws, spheres(0.6));
    bench.step(overlap, [0.0; 2]);
    let (mut work, mut least, mut most) = (0.0f64, 0.0f64, 0.0f64);
    for &(steps, angle, size) in path {
        for _ in 0..steps {
            let out = bench.step(overlap, [1e-11 * size * angle.cos(), 1e-11 * size * angle.sin()]);
            assert!(out.friction_loss >= 0.0);
            work += out.tangential_work;
            least = least.min(work);
            most = most.max(work);
        }
    }
    if most > 0.0 { least / most } else { 0.0 }
}

/// A closed path in one direction, repeated three times: the last cycle loses energy or nothing at all.
fn loss_of_a_closed_cycle(laws: LawPair, targets: &[f64], overlap: f64) -> f64 {
    let mut bench = Bench::new(laws, spheres(0.6));
    bench.step(overlap, [0.0; 2]);
    let (mut lost, mut size) = (0.0, 0.0f64);
    for round in 0..3 {
        (lost, size) = (0.0, 0.0);
        let mut at = 0.0;
        for &target in targets.iter().chain(&[0.0]) {
            let steps = 50;
            for _ in 0..steps {
                let out = bench
                    .step(overlap, [0.6 * (target - at) / steps as f64, 0.8 * (target - at) / steps as f64]);
                lost += out.tangential_work;
                size = size.max(out.tangential_work.abs() * steps as f64);
            }
            at = target;
        }
        assert!(round < 3);
    }
    if size > 0.0 { lost / size } else { 0.0 }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn no_path_at_constant_load_makes_energy(path in path(), approach in 2e-9f64..3e-8) {
        for (normal, tangential) in super::ALL {
            let least = least_work((normal, tangential), &path, approach);
            // Peeling is reversible along a curve: this bounds the discretization error.
            let bound = if tangential == TangentialKind::PEELING { -1e-3 } else { -1e-9 };
            prop_assert!(least > bound, "{normal:?} {tangential:?}: {least:e}");
        }
    }

    #[test]
    fn closed_cycles_lose(targets in prop::collection::vec(-1e-9f64..1e-9, 1..6), approach in 2e-9f64..3e-8) {
        for (normal, tangential) in super::ALL {
            let lost = loss_of_a_closed_cycle((normal, tangential), &targets, approach);
            // Peeling is reversible along a curve: this bounds the discretization error.
            let bound = if tangential == TangentialKind::PEELING { -1e-3 } else { -1e-6 };
            prop_assert!(lost > bound, "{normal:?} {tangential:?}: {lost:e}");
        }
    }

    /// Approach and slip change together in small steps: energy returned beyond that put in, over the loss of sliding
    /// throughout.
    #[test]
    fn little_energy_is_made_with_changing_load(
        path in prop::collection::vec((3e-9f64..3e-8, -4e-10f64..4e-10, -4e-10f64..4e-10), 2..12)
    ) {
        for (normal, tangential) in super::ALL {
            if tangential == TangentialKind::PEELING {
                continue;
            }
            let least = least_work_under_changing_load((normal, tangential), &path);
            // Rescaling makes the no-slip law passive. The incremental law is exact at constant load only: of 3000 paths the
            // worst created a tenth (Elata and Berryman 1996 show why this is unavoidable).
            let bound = if tangential == TangentialKind::NO_SLIP { -1e-3 } else { -BOUND };
            prop_assert!(least > bound, "{normal:?} {tangential:?}: {least:e}");
        }
    }
}

/// Bound on the energy that the incremental law creates.
const BOUND: f64 = 0.15;

/// The least work along a path of overlap and slip, over the loss of sliding throughout.
fn least_work_under_changing_load(laws: LawPair, path: &[(f64, f64, f64)]) -> f64 {
    const SUBSTEPS: usize = 400;
    let mut bench = Bench::new(laws, spheres(0.3));
    bench.step(path[0].0, [0.0; 2]);
    let (mut work, mut least, mut size) = (0.0f64, 0.0f64, 0.0f64);
    for pair in path.windows(2) {
        for k in 1..=SUBSTEPS {
            let approach = pair[0].0 + (pair[1].0 - pair[0].0) * k as f64 / SUBSTEPS as f64;
            let slip = [pair[1].1 / SUBSTEPS as f64, pair[1].2 / SUBSTEPS as f64];
            work += bench.step(approach, slip).tangential_work;
            least = least.min(work);
            let load = bench.friction_load(approach);
            size += 0.3 * load * slip[0].hypot(slip[1]);
        }
    }
    if size > 0.0 { least / size } else { 0.0 }
}

/// A contact that opens loses its history, and a closed cycle of making and breaking an adhesive contact loses the
/// corresponding energy.
#[test]
fn make_and_break_lose_the_adhesion() {
    let pair = spheres(0.6);
    let mut bench = Bench::new((NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ), pair);
    let (mut work, mut lost) = (0.0, 0.0);
    let n = 20_000;
    let mut before = 0.0;
    let turn = 2e-8;
    let end = -4e-9;
    for k in 0..2 * n {
        let share = k as f64 / n as f64;
        let approach = if share < 1.0 { share * turn } else { turn + (share - 1.0) * (end - turn) };
        let out = bench.step(approach, [1e-14, 0.0]);
        if k > 0 {
            let previous = if share <= 1.0 { turn / n as f64 } else { (end - turn) / n as f64 };
            work += 0.5 * (out.normal_force + before) * previous;
        }
        before = out.normal_force;
        lost += out.adhesion_made + out.adhesion_broken;
        assert_eq!(out.touching, bench.memory.normal != [0.0; 3]);
    }
    assert_eq!(bench.memory.history, [0.0; MAX_HISTORY]);
    assert!((lost / 1.942085691e-13 - 1.0).abs() < 1e-8);
    assert!((work / lost - 1.0).abs() < 2e-3, "{work} {lost}");
}
