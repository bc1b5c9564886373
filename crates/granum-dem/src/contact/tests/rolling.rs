//! Rolling resistance compared with analytical solutions: stiffness and limit, cycles, paths in the plane, rigid rotation,
//! passivity.

use super::*;
use crate::contact::law::limits::{LAW_CHANNELS, MAX_MOMENT_HISTORY};
use crate::contact::law::{Moment, Normal, RelativeSpin};
use proptest::prelude::*;

type Rolling = ElasticPlasticRolling;

/// Load of the reference table, N.
const LOAD: f64 = 2e-4;

/// A Hertz contact under a load whose rotation is prescribed.
struct Cradle {
    constants: <Rolling as MomentLaw>::Constants<f64>,
    normal: Normal<f64>,
    history: [f64; MAX_MOMENT_HISTORY],
    work: f64,
    lost: f64,
}

impl Cradle {
    /// A contact of spheres with the radii R_i and R_j, m.
    fn new(radii: [f64; 2]) -> Cradle {
        let material = Material { interface_energy: 0.0, ..Material::default() };
        let pair = PairProperties::new((&material, radii[0]), (&material, radii[1]), 0.0);
        let normal = Hertz::loaded(&pair, &[], LOAD);
        let constants = Rolling::prepare(&pair, &[0.1, 0.3]);
        Cradle { constants, normal, history: [0.0; MAX_MOMENT_HISTORY], work: 0.0, lost: 0.0 }
    }

    /// Rotates i relative to j by two angles in one step; returns the state of the contact, with the couple on j.
    fn turn(&mut self, by: [f64; 2]) -> Moment<f64> {
        let spin = RelativeSpin { rolling: by, twisting: 0.0 };
        let out = Rolling::update(
            &self.constants,
            &self.normal,
            spin,
            1.0,
            &mut self.history,
            &mut [0.0; LAW_CHANNELS],
        );
        self.work += out.work;
        self.lost += out.loss;
        out
    }

    fn stored(&self) -> f64 {
        Rolling::energy(&self.constants, &self.history)
    }

    /// Measured stiffness and limit.
    fn measured(mut self) -> [f64; 2] {
        let stiffness = self.turn([1e-9, 0.0]).couple[0] / 1e-9;
        [stiffness, self.turn([1.0, 0.0]).couple[0]]
    }
}

/// `k = 9/4 k_n (mu_r R*)^2` and `mu_r R* N` for glass spheres of 0.1 mm, and of 0.1 and 0.05 mm, at 0.2 mN.
#[test]
fn stiffness_and_limit_are_those_of_the_paper() {
    let [stiffness, limit] = Cradle::new([5e-5; 2]).measured();
    assert!((stiffness / 4.9787546119e-7 - 1.0).abs() < 1e-9, "{stiffness:e}");
    assert!((limit / 5e-10 - 1.0).abs() < 1e-12, "{limit:e}");
    let [stiffness, limit] = Cradle::new([5e-5, 2.5e-5]).measured();
    assert!((stiffness / 1.9330412301e-7 - 1.0).abs() < 1e-9, "{stiffness:e}");
    assert!((limit / 3.3333333333e-10 - 1.0).abs() < 1e-9, "{limit:e}");
}

/// A cycle of rolling, in units of the angle and of the couple at the yield point: angle, couple, energy lost.
#[test]
fn a_cycle_stores_and_loses_as_spring_and_slider() {
    let mut cradle = Cradle::new([5e-5; 2]);
    let [stiffness, limit] = Cradle::new([5e-5; 2]).measured();
    let yields = limit / stiffness;
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
        let steps = 4000;
        let mut out = 0.0;
        for _ in 0..steps {
            let by = (angle - at) * yields / f64::from(steps);
            out = cradle.turn([0.6 * by, -0.8 * by]).couple[0] / 0.6 / limit;
        }
        at = angle;
        assert!((out - couple).abs() < 1e-9, "{angle}: {out}");
        let found = cradle.lost / (limit * yields);
        assert!((found - lost).abs() < 2e-3, "{angle}: lost {found}");
        let all = cradle.stored() + cradle.lost;
        assert!((cradle.work - all).abs() < 1e-12 * cradle.work.abs().max(limit * yields));
    }
}

/// Along one axis by twice the yield angle and then perpendicular to it: the couple is `(sech 2, tanh 2)`, and
/// `1 + ln cosh 2` is lost.
#[test]
fn a_path_with_a_corner_follows_the_exact_solution() {
    let mut cradle = Cradle::new([5e-5; 2]);
    let [stiffness, limit] = Cradle::new([5e-5; 2]).measured();
    let yields = limit / stiffness;
    let mut couple = [0.0; 3];
    for leg in 0..2 {
        for _ in 0..1000 {
            let mut by = [0.0; 2];
            by[leg] = 2.0 * yields / 1000.0;
            couple = cradle.turn(by).couple;
        }
    }
    let found = [couple[0] / limit, couple[1] / limit, cradle.lost / (limit * yields)];
    for (k, (found, steps)) in found.into_iter().zip([0.266141, 0.963934, 2.324761]).enumerate() {
        assert!((found - steps).abs() < 2e-6, "{k}: {found}");
        let exact = [1.0 / 2f64.cosh(), 2f64.tanh(), 1.0 + 2f64.cosh().ln()][k];
        assert!((found - exact).abs() < 5e-4, "{k}: {found} {exact}");
    }
}

/// Where the load decreases the couple decreases with the stiffness: unloading and reloading creates no energy.
#[test]
fn a_changing_load_makes_no_energy() {
    let mut cradle = Cradle::new([5e-5; 2]);
    let pair = PairProperties { interface_energy: 0.0, ..spheres(0.0) };
    let [stiffness, limit] = Cradle::new([5e-5; 2]).measured();
    cradle.turn([0.5 * limit / stiffness, 0.0]);
    let start = cradle.stored();
    for load in [1e-4, 5e-5, 1e-4, 2e-4] {
        cradle.normal = Hertz::loaded(&pair, &[], load);
        let before = cradle.stored();
        let out = cradle.turn([0.0; 2]);
        assert_eq!(out.work, 0.0);
        assert!(out.loss >= 0.0 && (out.loss - (before - cradle.stored())).abs() < 1e-12 * start);
    }
}

/// No dashpot acts at the limit.
#[test]
fn the_dashpot_ends_at_the_limit() {
    let mut cradle = Cradle::new([5e-5; 2]);
    let [stiffness, limit] = Cradle::new([5e-5; 2]).measured();
    let below = cradle.turn([0.5 * limit / stiffness, 0.0]);
    let inertia = 0.5 * 1.4 * 4.0 / 3.0 * std::f64::consts::PI * 2650.0 * 5e-5f64.powi(5);
    let critical = 2.0 * (inertia * stiffness).sqrt();
    assert!(!below.at_limit && (below.dashpot / (0.3 * critical) - 1.0).abs() < 1e-12);
    let beyond = cradle.turn([2.0 * limit / stiffness, 0.0]);
    assert!(beyond.at_limit && beyond.dashpot == 0.0);
}

/// Relative error of the history of a rolled pair after a rotation as a rigid body.
fn error_of_a_turn<M: MomentLaw>(steps: usize) -> f64 {
    let pair = spheres(0.0);
    let laws = Compiled::<Hertz, NoSlip, M>::new();
    let constants = constants::<Hertz, NoSlip, M>(&pair);
    let mut memory = Memory::<f64>::new();
    let distance = pair.radius_sum - 1e-8;
    let turned = |angle: f64| {
        // About (1, 2, 3): the component of the x axis along this axis is unchanged, the rest rotates.
        let along = NORMAL.map(|n| n * NORMAL[0]);
        let across: [f64; 3] = std::array::from_fn(|a| [1.0, 0.0, 0.0][a] - along[a]);
        let side = granum_simd::vectors::cross(NORMAL, [1.0, 0.0, 0.0]);
        let n: [f64; 3] = std::array::from_fn(|a| along[a] + across[a] * angle.cos() + side[a] * angle.sin());
        n
    };
    let angle = std::f64::consts::TAU / steps as f64;
    let mut couples = Vec::new();
    for k in 0..=steps {
        let (old, new) = (turned(k as f64 * angle - angle), turned(k as f64 * angle));
        let first = k == 0;
        let spin = if first { [0.0; 3] } else { NORMAL.map(|n| n * angle) };
        let motion = PairMotion {
            branch: new.map(|n| n * distance),
            velocity: std::array::from_fn(|a| if first { 0.0 } else { distance * (new[a] - old[a]) }),
            rolling: spin,
            mean_spin: spin,
            // Rolled in the first step, then both grains rotate together.
            relative_spin: if first { [0.0, 2e-4, -1e-4] } else { [0.0; 3] },
        };
        couples.push(interact(&laws, &constants, &motion, 1.0, &mut memory));
    }
    // The couple without the dashpot, which acts only in the first step.
    let first = crate::contact::evaluation::frame::ContactFrame::new(turned(0.0));
    let held = |memory: &Memory<f64>| first.vector([memory.moments[0], memory.moments[1]]);
    let mut start = Memory::<f64>::new();
    let motion = PairMotion {
        branch: turned(0.0).map(|n| n * distance),
        velocity: [0.0; 3],
        rolling: [0.0; 3],
        mean_spin: [0.0; 3],
        relative_spin: [0.0, 2e-4, -1e-4],
    };
    interact(&laws, &constants, &motion, 1.0, &mut start);
    let (a, b) = (held(&start), held(&memory));
    let off: [f64; 3] = std::array::from_fn(|k| b[k] - a[k]);
    assert!(couples.iter().all(|out| out.moment_loss.abs() < 1e-25));
    (dot(off, off) / dot(a, a)).sqrt()
}

/// A rolled pair that rotates as a rigid body keeps its couple, which rotates with it.
#[test]
fn a_turning_pair_keeps_its_couple() {
    let laws: [fn(usize) -> f64; 2] = [error_of_a_turn::<Rolling>, error_of_a_turn::<SpringDashpotSlider>];
    for error in laws {
        let errors = [error(1000), error(10_000)];
        assert!(errors[0] < 2.7e-6 && errors[1] < 2.7e-8, "{errors:?}");
    }
}

/// The other grain feels the opposite couple, whichever is called i; the result is the same for all observers.
#[test]
fn couples_are_opposite_and_the_same_for_all() {
    check_sides_and_observers::<Rolling>();
    check_sides_and_observers::<SpringDashpotSlider>();
}

fn check_sides_and_observers<M: MomentLaw>() {
    let laws = Compiled::<Hertz, NoSlip, M>::new();
    let constants = constants::<Hertz, NoSlip, M>(&spheres(0.0));
    let mut memories = [Memory::<f64>::new(); 3];
    let map = |v: [f64; 3]| [v[2], v[0], v[1]];
    for step in 0..200 {
        let wave = |rate: f64| (rate * f64::from(step)).sin();
        let n = [0.3 + 0.1 * wave(0.02), -0.5, 0.8];
        let size = dot(n, n).sqrt();
        let motion = PairMotion {
            branch: n.map(|x| x / size * (1e-4 - 1e-8)),
            velocity: [1e-2 * wave(0.1), 0.0, 0.0],
            rolling: [10.0, 5.0 * wave(0.3), 0.0],
            mean_spin: [10.0, 5.0, wave(0.2)],
            relative_spin: [3000.0 * wave(0.1), -2000.0 * wave(0.07), 1000.0],
        };
        let negated = |v: [f64; 3]| v.map(|x| -x);
        let swapped = PairMotion {
            branch: negated(motion.branch),
            velocity: negated(motion.velocity),
            relative_spin: negated(motion.relative_spin),
            ..motion
        };
        let turned = PairMotion {
            branch: map(motion.branch),
            velocity: map(motion.velocity),
            rolling: map(motion.rolling),
            mean_spin: map(motion.mean_spin),
            relative_spin: map(motion.relative_spin),
        };
        let [a, b, c] = [motion, swapped, turned];
        let one = interact(&laws, &constants, &a, 1e-8, &mut memories[0]).couple;
        let two = interact(&laws, &constants, &b, 1e-8, &mut memories[1]).couple;
        let three = interact(&laws, &constants, &c, 1e-8, &mut memories[2]).couple;
        let size = dot(one, one).sqrt();
        for k in 0..3 {
            assert!((one[k] + two[k]).abs() < 1e-10 * size, "step {step}: {one:?} {two:?}");
            assert!((map(one)[k] - three[k]).abs() < 1e-10 * size, "step {step}");
        }
    }
    assert!(memories[0].moments[0] != 0.0);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn no_path_at_constant_load_makes_energy(path in prop::collection::vec((-2e-3f64..2e-3, -2e-3f64..2e-3), 1..30)) {
        let mut cradle = Cradle::new([5e-5, 3e-5]);
        for (x, y) in path {
            let out = cradle.turn([x, y]);
            prop_assert!(out.loss >= -1e-12 * cradle.work.abs(), "{:e}", out.loss);
            prop_assert!(out.couple[0].hypot(out.couple[1]) <= cradle.constants.arm * LOAD * (1.0 + 1e-12));
        }
        prop_assert!(cradle.work >= 0.0);
        prop_assert!((cradle.work - cradle.stored() - cradle.lost).abs() < 1e-10 * cradle.work);
    }
}
