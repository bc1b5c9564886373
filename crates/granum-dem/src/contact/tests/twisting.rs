//! Resistance to twisting against analysis: stiffness and limit, cycles, turning, sides, passivity.

use super::*;
use crate::contact::evaluation::frame::swap_sides;
use crate::contact::law::constants::named;
use crate::contact::law::limits::{LAW_CHANNELS, MAX_MOMENT_HISTORY};
use crate::contact::law::{Moment, Normal, RelativeSpin};

type Twisting = ElasticPlasticTwisting;

/// Load, N.
const LOAD: f64 = 2e-4;
const FRICTION: f64 = 0.08;

/// A contact of Hertz under a load, twisted and rolled by hand.
struct Cradle {
    constants: <Twisting as MomentLaw>::Constants<f64>,
    normal: Normal<f64>,
    history: [f64; MAX_MOMENT_HISTORY],
    work: f64,
    lost: f64,
}

fn pair() -> PairProperties {
    spheres(0.0)
}

impl Cradle {
    fn new() -> Cradle {
        let constants = Twisting::prepare(&pair(), &[0.1, 0.3, FRICTION, 0.3]);
        let normal = Hertz::loaded(&pair(), &[], LOAD);
        Cradle { constants, normal, history: [0.0; MAX_MOMENT_HISTORY], work: 0.0, lost: 0.0 }
    }

    fn turn(&mut self, rolling: [f64; 2], twisting: f64) -> Moment<f64> {
        let spin = RelativeSpin { rolling, twisting };
        let out = Twisting::update(
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
        Twisting::energy(&self.constants, &self.history)
    }
}

/// `k = 9/4 k_n (mu_t R*)^2` and the limit `mu_t R* N`.
fn expected() -> [f64; 2] {
    let arm = FRICTION * 25e-6;
    [2.25 * Hertz::loaded(&pair(), &[], LOAD).stiffness * arm * arm, arm * LOAD]
}

/// A cycle about the normal, in units of the angle and of the couple at which it yields: angle, couple, lost.
#[test]
fn a_cycle_stores_and_loses_as_spring_and_slider() {
    let [stiffness, limit] = expected();
    let yields = limit / stiffness;
    let mut cradle = Cradle::new();
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
            out = cradle.turn([0.0; 2], (angle - at) * yields / 4000.0).couple[2] / limit;
        }
        at = angle;
        assert!((out - couple).abs() < 1e-9, "{angle}: {out}");
        let found = cradle.lost / (limit * yields);
        assert!((found - lost).abs() < 2e-3, "{angle}: lost {found}");
        let all = cradle.stored() + cradle.lost;
        assert!((cradle.work - all).abs() < 1e-12 * cradle.work.abs().max(limit * yields));
    }
}

/// Rolling with any twisting of the contact gives the couples of the law without twisting, and the reverse.
#[test]
fn rolling_and_twisting_do_not_see_each_other() {
    let alone = ElasticPlasticRolling::prepare(&pair(), &[0.1, 0.3]);
    let (mut both, mut twisted) = (Cradle::new(), Cradle::new());
    let mut history = [0.0; MAX_MOMENT_HISTORY];
    for step in 0..400 {
        let wave = |rate: f64| 2e-4 * (rate * f64::from(step)).sin();
        let (rolling, twisting) = ([wave(0.11), wave(0.07)], 10.0 * wave(0.05));
        let out = both.turn(rolling, twisting);
        let spin = RelativeSpin { rolling, twisting };
        let reference = ElasticPlasticRolling::update(
            &alone,
            &both.normal,
            spin,
            1.0,
            &mut history,
            &mut [0.0; LAW_CHANNELS],
        );
        assert_eq!(out.couple[..2], reference.couple[..2]);
        assert_eq!(out.couple[2], twisted.turn([0.0; 2], twisting).couple[2]);
        assert_eq!(out.dashpot, reference.dashpot);
    }
    assert!(both.lost > 0.0 && twisted.lost > 0.0);
}

/// Where the load decreases, the couple decreases with the stiffness, and the difference of the stored energy is lost.
#[test]
fn a_changing_load_makes_no_energy() {
    let [stiffness, limit] = expected();
    let mut cradle = Cradle::new();
    cradle.turn([0.0; 2], 0.5 * limit / stiffness);
    let start = cradle.stored();
    for load in [1e-4, 5e-5, 1e-4, 2e-4] {
        cradle.normal = Hertz::loaded(&pair(), &[], load);
        let before = cradle.stored();
        let out = cradle.turn([0.0; 2], 0.0);
        assert_eq!(out.work, 0.0);
        assert!(out.loss >= 0.0 && (out.loss - (before - cradle.stored())).abs() < 1e-12 * start);
    }
}

/// A fraction of critical damping of two spheres that twist against each other about their line of centres.
#[test]
fn the_dashpot_ends_at_the_limit() {
    let [stiffness, limit] = expected();
    let mut cradle = Cradle::new();
    let below = cradle.turn([0.0; 2], 0.5 * limit / stiffness);
    let inertia = 0.5 * 0.4 * 4.0 / 3.0 * std::f64::consts::PI * 2650.0 * 5e-5f64.powi(5);
    let critical = 2.0 * (inertia * stiffness).sqrt();
    assert!((below.twisting_dashpot / (0.3 * critical) - 1.0).abs() < 1e-12);
    let beyond = cradle.turn([0.0; 2], 2.0 * limit / stiffness);
    assert!(beyond.at_limit && beyond.twisting_dashpot == 0.0);
}

/// A twisted pair in rigid rotation keeps its couple about the normal, and the pair (j, i) gives the same result as (i, j).
#[test]
fn the_couple_turns_with_the_pair_and_is_opposite_on_the_other_grain() {
    let laws = Compiled::<Hertz, NoSlip, Twisting>::new();
    let constants = constants::<Hertz, NoSlip, Twisting>(&pair());
    let [mut mine, mut other] = [Memory::<f64>::new(); 2];
    let distance = 1e-4 - 1e-8;
    let mut before = [0.0, 0.0, 1.0];
    let mut couple = 0.0;
    for step in 0..=1000 {
        let angle = f64::from(step) * 0.003;
        let n = [angle.sin() * 0.6, angle.sin() * 0.8, angle.cos()];
        let about = [-0.8 * 0.003, 0.6 * 0.003, 0.0];
        let first = step == 0;
        let spin = if first { [0.0; 3] } else { about };
        let motion = PairMotion {
            branch: n.map(|x| x * distance),
            velocity: std::array::from_fn(|a| if first { 0.0 } else { distance * (n[a] - before[a]) }),
            rolling: spin,
            mean_spin: spin,
            relative_spin: if first { [0.0, 0.0, 1e-4] } else { [0.0; 3] },
        };
        let negated = |v: [f64; 3]| v.map(|x| -x);
        let swapped = PairMotion {
            branch: negated(motion.branch),
            velocity: negated(motion.velocity),
            relative_spin: negated(motion.relative_spin),
            ..motion
        };
        let out = interact(&laws, &constants, &motion, 1.0, &mut mine);
        let opposite = interact(&laws, &constants, &swapped, 1.0, &mut other);
        before = n;
        let along = -dot(out.couple, n);
        if step == 1 {
            couple = along;
        }
        for a in 0..3 {
            assert!((out.couple[a] + opposite.couple[a]).abs() < 1e-9 * couple.abs().max(1e-12));
            let across = out.couple[a] + along * n[a];
            assert!(first || across.abs() < 1e-12 * couple.abs(), "step {step}: {across:e}");
        }
        // The dashpot acts in the first step alone.
        assert!(first || (along / couple - 1.0).abs() < 1e-9, "step {step}: {along:e} {couple:e}");
    }
    // A couple about the normal does not change when the grains change sides; the plane vector of rolling does.
    let [x, y] = swap_sides(mine.normal, [mine.moments[0], mine.moments[1]]);
    let reversed = [x, y, mine.moments[2], mine.moments[3], mine.moments[4]];
    for (mine, other) in reversed.iter().zip(&other.moments) {
        assert!((mine - other).abs() <= 1e-9 * mine.abs().max(1e-16), "{reversed:?} {:?}", other);
    }
}

/// Two hundred turns about an oblique axis, 200,000 steps: a rolled and twisted pair that turns as one body neither gains nor loses
/// energy, both couples keep their size, and the couple of rolling comes back to where it was. Its direction is off by the second
/// order of a step in each turn.
#[test]
fn a_long_turn_as_one_body_changes_nothing() {
    let laws = Compiled::<Hertz, NoSlip, Twisting>::new();
    let constants = constants::<Hertz, NoSlip, Twisting>(&pair());
    let mut memory = Memory::<f64>::new();
    let distance = 1e-4 - 1e-8;
    let (turns, steps) = (200, 1000);
    let angle = std::f64::consts::TAU / f64::from(steps);
    // The x axis turned about (1, 2, 3).
    let side = granum_simd::vectors::cross(super::NORMAL, [1.0, 0.0, 0.0]);
    let at = |step: i32| -> [f64; 3] {
        let angle = f64::from(step % steps) * angle;
        std::array::from_fn(|a| {
            let along = super::NORMAL[a] * super::NORMAL[0];
            along + ([1.0, 0.0, 0.0][a] - along) * angle.cos() + side[a] * angle.sin()
        })
    };
    let (mut start, mut lost, mut worked) = ([0.0; 5], 0.0, 0.0);
    for step in 0..=turns * steps {
        let first = step == 0;
        let (old, new) = (at(step + steps - 1), at(step));
        let spin = if first { [0.0; 3] } else { super::NORMAL.map(|n| n * angle) };
        let motion = PairMotion {
            branch: new.map(|n| n * distance),
            velocity: std::array::from_fn(|a| if first { 0.0 } else { distance * (new[a] - old[a]) }),
            rolling: spin,
            mean_spin: spin,
            relative_spin: if first { [5e-5, 2e-4, -1e-4] } else { [0.0; 3] },
        };
        let out = interact(&laws, &constants, &motion, 1.0, &mut memory);
        if first {
            start = std::array::from_fn(|c| memory.moments[c]);
        } else {
            lost += out.moment_loss;
            worked += out.moment_work;
        }
    }
    let end = memory.moments;
    let stored = Twisting::energy(&named(&constants.rolling), &memory.moments);
    let size = |couple: &[f64]| (couple[0] * couple[0] + couple[1] * couple[1]).sqrt();
    let turned = ((end[0] - start[0]).powi(2) + (end[1] - start[1]).powi(2)).sqrt() / size(&start);
    println!(
        "200 turns: rolling {:.1e}, its direction {turned:.1e}, twisting {:.1e}, lost {:.1e} of what is stored",
        size(&end) / size(&start) - 1.0,
        end[2] / start[2] - 1.0,
        lost / stored
    );
    assert!(start[2] != 0.0 && worked == 0.0);
    assert!((size(&end) / size(&start) - 1.0).abs() < 1e-6 && (end[2] / start[2] - 1.0).abs() < 1e-6);
    assert!(lost.abs() < 1e-5 * stored, "{lost:e} {stored:e}");
    assert!(turned < 200.0 * 2.7e-6, "{turned:e}");
}
