//! Spring, dashpot and slider against rolling: couples of LAMMPS, analytical cycles and paths, energy.

use std::array::from_fn;

use super::*;
use crate::contact::law::limits::{LAW_CHANNELS, MAX_MOMENT_HISTORY};
use crate::contact::law::{Moment, Normal, RelativeSpin};
use crate::contact::normal::Hooke;
use proptest::prelude::*;

type Rolling = SpringDashpotSlider;

const LOAD: f64 = 2e-4;
const STIFFNESS: f64 = 1e3;
const FRICTION: f64 = 0.1;
/// R* of the reference pair, m.
const RADIUS: f64 = 2.5e-5;

/// A contact under a load whose rotation is prescribed.
struct Cradle {
    constants: <Rolling as MomentLaw>::Constants<f64>,
    normal: Normal<f64>,
    history: [f64; MAX_MOMENT_HISTORY],
    work: f64,
    lost: f64,
    damped: f64,
}

fn under(load: f64) -> Normal<f64> {
    Hooke::loaded(&spheres(0.0), &[1e4], load)
}

impl Cradle {
    fn new(viscosity: f64) -> Cradle {
        let constants = Rolling::prepare(&spheres(0.0), &[FRICTION, STIFFNESS, viscosity]);
        let history = [0.0; MAX_MOMENT_HISTORY];
        Cradle { constants, normal: under(LOAD), history, work: 0.0, lost: 0.0, damped: 0.0 }
    }

    /// Rotates i relative to j by two angles in one step of a given length, s; returns the state of the contact and the couple
    /// on j, dashpot included, N m.
    fn turn(&mut self, by: [f64; 2], dt: f64) -> (Moment<f64>, [f64; 2]) {
        let rolling = by.map(|angle| angle / dt);
        let spin = RelativeSpin { rolling, twisting: 0.0 };
        let out = Rolling::update(
            &self.constants,
            &self.normal,
            spin,
            dt,
            &mut self.history,
            &mut [0.0; LAW_CHANNELS],
        );
        self.work += out.work;
        self.lost += out.loss;
        self.damped += out.dashpot * (rolling[0] * by[0] + rolling[1] * by[1]);
        (out, from_fn(|k| out.couple[k] + out.dashpot * rolling[k]))
    }

    fn stored(&self) -> f64 {
        Rolling::energy(&self.constants, &self.history)
    }

    /// The part of the work that is neither stored nor lost, over the energy of the spring at the limit.
    fn gap(&self) -> f64 {
        (self.work - self.stored() - self.lost) / (FRICTION * FRICTION * LOAD * LOAD / (2.0 * STIFFNESS))
    }
}

/// Couple and angle at the limit.
const LIMIT: f64 = FRICTION * LOAD * RADIUS;
const YIELDS: f64 = FRICTION * LOAD / (STIFFNESS * RADIUS);

/// The spins of the comparison with LAMMPS in a step, rad/s.
fn spins(step: usize) -> [[f64; 3]; 2] {
    let k = step as f64;
    [
        [2000.0 * (0.1 * k).sin(), 1400.0 * (0.07 * k).cos(), -800.0 * (0.13 * k + 1.0).sin()],
        [-1000.0 * (0.05 * k).cos(), 500.0 * (0.11 * k).sin(), 900.0 * (0.02 * k).sin()],
    ]
}

/// Couple on the first grain after 20, 40, ... steps, N m: `rolling sds 1000 1e-3 0.1` of LAMMPS 29 Sep 2021.
const LAMMPS: [[f64; 3]; 10] = [
    [-3.37611728689884e-10, 1.63184796487676e-10, 3.74737857151072e-12],
    [3.53564455729061e-10, 1.00621934888634e-11, -1.24562947568929e-10],
    [3.35973520826586e-10, -7.40816880642265e-11, -6.26033815660444e-11],
    [-2.98152073544927e-10, -1.3042360929615e-10, 1.86333097379076e-10],
    [7.28702519020658e-11, -1.18997325152781e-10, 5.50414661344989e-11],
    [-6.52138827099946e-11, 1.21415842685428e-10, -5.9205934220287e-11],
    [-1.44523848106861e-10, 2.01703419109761e-11, 3.47277214283028e-11],
    [1.3891380666281e-10, -5.58644932101168e-11, -9.06160674752532e-12],
    [1.4319710276586e-10, -3.90263741566527e-11, -2.17147848175182e-11],
    [-1.44505447155675e-10, 2.50996556162304e-11, 3.14353786410713e-11],
];

/// Spheres of 50 and 30 um whose spins are prescribed, at a normal force of 0.2 mN, from step 100 on of 0.08 mN, with steps of 0.1 us. Spring
/// and dashpot together would be 0.93 to 3.1 times the limit in these rows.
#[test]
fn couples_are_those_of_lammps() {
    let material = Material { interface_energy: 0.0, ..Material::default() };
    let pair = PairProperties::new((&material, 5e-5), (&material, 3e-5), 0.0);
    let laws = Compiled::<Hooke, NoSlip, Rolling>::new();
    let constants = constants::<Hooke, NoSlip, Rolling>(&pair);
    let mut memory = Memory::<f64>::new();
    for step in 0..=200 {
        let overlap = if step < 100 { 2e-8 } else { 8e-9 };
        let [i, j] = if step == 0 { [[0.0; 3]; 2] } else { spins(step) };
        let motion = PairMotion {
            branch: NORMAL.map(|n| n * (pair.radius_sum - overlap)),
            velocity: [0.0; 3],
            rolling: [0.0; 3],
            // LAMMPS does not rotate the history with the spin about the normal.
            mean_spin: [0.0; 3],
            relative_spin: from_fn(|k| i[k] - j[k]),
        };
        let couple = interact(&laws, &constants, &motion, 1e-7, &mut memory).couple;
        if step % 20 == 0 && step > 0 {
            for (found, expected) in couple.into_iter().zip(LAMMPS[step / 20 - 1]) {
                let off = (found - expected) / (FRICTION * LOAD * pair.effective_radius);
                assert!(off.abs() < 1e-11, "step {step}: {couple:?}");
            }
        }
    }
}

/// A slow cycle of rolling, in units of the angle and of the couple at the yield point: angle, couple, energy lost.
#[test]
fn a_slow_cycle_stores_and_loses_as_spring_and_slider() {
    let mut cradle = Cradle::new(0.0);
    let table = [
        (1.0, 1.0, 0.0),
        (3.0, 1.0, 2.0),
        (2.5, 0.5, 2.0),
        (1.0, -1.0, 2.0),
        (-3.0, -1.0, 6.0),
        (-1.0, 1.0, 6.0),
        (3.0, 1.0, 10.0),
        (2.0, 0.0, 10.0),
    ];
    let mut at = 0.0;
    for (angle, couple, lost) in table {
        let mut out = 0.0;
        for _ in 0..4000 {
            let by = (angle - at) * YIELDS / 4000.0;
            out = cradle.turn([0.6 * by, -0.8 * by], 1.0).1[0] / 0.6 / LIMIT;
        }
        at = angle;
        assert!((out - couple).abs() < 1e-9, "{angle}: {out}");
        let found = cradle.lost / (LIMIT * YIELDS);
        assert!((found - lost).abs() < 2e-3, "{angle}: lost {found}");
        assert!(cradle.gap().abs() < 1e-11);
    }
}

/// Along one axis by twice the yield angle and then perpendicular to it: the couple is `(sech 2, tanh 2)`, and `1 + ln cosh 2` is lost.
#[test]
fn a_path_with_a_corner_follows_the_exact_solution() {
    let mut cradle = Cradle::new(0.0);
    let mut couple = [0.0; 2];
    for leg in 0..2 {
        for _ in 0..1000 {
            let mut by = [0.0; 2];
            by[leg] = 2.0 * YIELDS / 1000.0;
            couple = cradle.turn(by, 1.0).1;
        }
    }
    let found = [couple[0] / LIMIT, couple[1] / LIMIT, cradle.lost / (LIMIT * YIELDS)];
    let exact = [1.0 / 2f64.cosh(), 2f64.tanh(), 1.0 + 2f64.cosh().ln()];
    assert!(
        found.iter().zip(exact).all(|(found, exact)| (found - exact).abs() < 5e-4),
        "{found:?} {exact:?}"
    );
}

/// At a steady rate the couple is at the limit and the spring holds the rest of it, which is negative where the dashpot alone exceeds
/// the limit; all work beyond the limit is lost, in the dashpot and in the slider.
#[test]
fn the_limit_holds_for_spring_and_dashpot_together() {
    for share in [0.3, 0.9, 2.5] {
        let mut cradle = Cradle::new(1e-3);
        // The rate at which the dashpot alone is a share of the limit.
        let rate = share * FRICTION * LOAD / (1e-3 * RADIUS);
        let angle = 0.01 * YIELDS;
        for _ in 0..400 {
            cradle.turn([angle, 0.0], angle / rate);
        }
        let held = cradle.history[0] * STIFFNESS * RADIUS / LIMIT;
        assert!((held - (1.0 - share)).abs() < 1e-9, "{share}: {held}");
        let [lost, damped] = [cradle.lost, cradle.damped];
        let (out, couple) = cradle.turn([angle, 0.0], angle / rate);
        assert!(out.at_limit && (couple[0] / LIMIT - 1.0).abs() < 1e-12);
        let [slider, dashpot] =
            [cradle.lost - lost, cradle.damped - damped].map(|loss| loss / (LIMIT * angle));
        assert!(
            (slider - (1.0 - share)).abs() < 1e-9 && (dashpot - share).abs() < 1e-9,
            "{slider} {dashpot}"
        );
        assert!(cradle.gap().abs() < 1e-9, "{share}: {:e}", cradle.gap());
    }
}

/// The stiffness does not depend on the load, but the limit does: a contact that is unloaded loses what its spring cannot hold, one that
/// is loaded again gains nothing, and one that breaks loses all.
#[test]
fn a_changing_load_makes_no_energy() {
    let mut cradle = Cradle::new(1e-3);
    cradle.turn([0.8 * YIELDS, 0.0], 1.0);
    for (load, held) in [(1.8e-4, 0.8), (1e-4, 0.5), (5e-5, 0.25), (1e-4, 0.25), (2e-4, 0.25)] {
        cradle.normal = under(load);
        let before = cradle.stored();
        let (out, couple) = cradle.turn([0.0; 2], 1.0);
        assert!((couple[0] / LIMIT - held).abs() < 1e-4, "{load}: {}", couple[0] / LIMIT);
        assert!(out.work == 0.0 && out.loss >= 0.0);
        assert!((out.loss - (before - cradle.stored())).abs() < 1e-12 * before);
    }
    let before = cradle.stored();
    cradle.normal = Normal::none();
    let (out, _) = cradle.turn([1e-9; 2], 1e-9);
    assert_eq!((out.couple, cradle.history), ([0.0; 3], [0.0; MAX_MOMENT_HISTORY]));
    assert!((out.loss - before - out.work).abs() < 1e-12 * before && cradle.gap().abs() < 1e-12);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn work_is_stored_and_lost(
        path in prop::collection::vec((-2e-3f64..2e-3, -2e-3f64..2e-3, 1e-5f64..3e-4), 1..30),
        viscosity in prop::sample::select(vec![0.0, 1e-4, 1e-2]),
    ) {
        let mut cradle = Cradle::new(viscosity);
        for (x, y, load) in path {
            // Without a dashpot a path at a constant load creates no energy.
            let load = if viscosity > 0.0 { load } else { LOAD };
            cradle.normal = under(load);
            let (out, couple) = cradle.turn([x, y], 1e-6);
            prop_assert!(couple[0].hypot(couple[1]) <= FRICTION * load * RADIUS * (1.0 + 1e-12));
            prop_assert!(viscosity > 0.0 || out.loss >= -1e-12 * LIMIT * YIELDS, "{:e}", out.loss);
        }
        let size = cradle.work.abs() + cradle.lost.abs();
        prop_assert!((cradle.work - cradle.stored() - cradle.lost).abs() <= 1e-12 * size);
    }
}
