//! A loaded pair that rotates as a rigid body keeps its forces: one full rotation about (1, 2, 3).

use super::*;
use crate::contact::evaluation::frame::{ContactFrame, Turn};
use granum_simd::vectors::{add_scaled, cross, scale};

/// The vector rotated by an angle about the unit axis (1, 2, 3) / sqrt 14.
fn turned(v: [f64; 3], angle: f64) -> [f64; 3] {
    let part = scale(dot(NORMAL, v), NORMAL);
    let across: [f64; 3] = std::array::from_fn(|a| v[a] - part[a]);
    let side = cross(NORMAL, v);
    std::array::from_fn(|a| part[a] + across[a] * angle.cos() + side[a] * angle.sin())
}

const START: [f64; 3] = [1.0, 0.0, 0.0];

/// The force stored in the history of a pair in the initial direction.
fn force_of(memory: &Memory<f64>) -> [f64; 3] {
    crate::contact::evaluation::memory::tangential_force(&Memory { normal: START, ..*memory })
}

fn swap(memory: &mut Memory<f64>, plane_vectors: usize) {
    crate::contact::evaluation::memory::swap_sides(memory.normal, plane_vectors, &mut memory.history);
    memory.normal = memory.normal.map(|x| -x);
}

/// Relative error of the stored force after one full rotation, from the rotation of the history alone.
fn history_alone(steps: usize) -> f64 {
    let angle = std::f64::consts::TAU / steps as f64;
    let mut vector = [0.8, -0.6];
    let begin = ContactFrame::new(START).vector(vector);
    for k in 0..steps {
        let (old, new) = (turned(START, k as f64 * angle), turned(START, (k + 1) as f64 * angle));
        let sum: [f64; 3] = std::array::from_fn(|a| old[a] + new[a]);
        let middle = scale(1.0 / dot(sum, sum).sqrt(), sum);
        vector = Turn::new(old, new, dot(old, new), angle * dot(NORMAL, middle)).apply(vector);
    }
    let end = ContactFrame::new(START).vector(vector);
    let off: [f64; 3] = std::array::from_fn(|a| end[a] - begin[a]);
    dot(off, off).sqrt()
}

#[test]
fn turning_of_the_history_is_of_second_order() {
    let errors = [1000, 10_000, 100_000].map(history_alone);
    println!("history alone, error over |T|: {errors:?}");
    assert!(errors[0] < 2.65e-6 && errors[1] < 2.65e-8 && errors[2] < 2.65e-10, "{errors:?}");
    assert!((errors[0] / errors[1] / 100.0 - 1.0).abs() < 0.05);
}

/// Relative errors of the force and of its magnitude after one full rotation of a pair with alpha / R = 1e-3 and T = mu N /
/// 2.
struct OneTurn {
    steps: usize,
    unlike: bool,
    energy: f64,
    /// If true, the mid-step velocity is that of the exact rotation; otherwise it is that of the leapfrog scheme, the chord
    /// of the step.
    tangent: bool,
}
impl OneTurn {
    fn errors(self, laws: LawPair) -> [f64; 2] {
        let material = Material { interface_energy: self.energy, ..Material::default() };
        let (ri, rj) = if self.unlike { (5e-5, 8e-5) } else { (5e-5, 5e-5) };
        let pair = PairProperties::new((&material, ri), (&material, rj), 0.0);
        let mut bench = Bench::new(laws, pair);
        let distance = pair.radius_sum - 1e-3 * ri;
        // Shear it without rotation to half the limit.
        let across = cross(START, NORMAL);
        let across = scale(1.0 / dot(across, across).sqrt(), across);
        let limit = pair.friction * bench.friction_load(1e-3 * ri);
        let mut force = [0.0; 3];
        let rest = |slip: f64| PairMotion {
            branch: scale(distance, START),
            velocity: scale(slip, across),
            rolling: [0.0; 3],
            mean_spin: [0.0; 3],
            relative_spin: [0.0; 3],
        };
        bench.interact(&rest(0.0), 1.0);
        while dot(force, force).sqrt() < 0.5 * limit {
            bench.interact(&rest(1e-12), 1.0);
            force = force_of(&bench.memory);
        }
        let angle = std::f64::consts::TAU / self.steps as f64;
        for k in 0..self.steps {
            // Leapfrog: the mid-step velocity carries the branch vector from its start to its end.
            let (old, new) = (turned(START, k as f64 * angle), turned(START, (k + 1) as f64 * angle));
            let spin = scale(angle, NORMAL);
            let velocity: [f64; 3] = if self.tangent {
                cross(spin, scale(distance, turned(START, (k as f64 + 0.5) * angle)))
            } else {
                std::array::from_fn(|a| distance * (new[a] - old[a]))
            };
            let motion = PairMotion {
                branch: scale(distance, new),
                velocity,
                rolling: spin,
                mean_spin: spin,
                relative_spin: [0.0; 3],
            };
            bench.interact(&motion, 1.0);
        }
        let end = force_of(&bench.memory);
        let off = add_scaled(end, -1.0, force);
        let size = dot(force, force).sqrt();
        [dot(off, off).sqrt() / size, dot(end, end).sqrt() / size - 1.0]
    }
}

/// Errors of 3.5e-2, 3.5e-4 and 3.5e-6 of |T| with 1e3, 1e4 and 1e5 steps per rotation; with other lever arms, or with a
/// normal other than that of mid-step, the errors would be 0.84 to 84 |T|.
#[test]
fn a_turning_pair_keeps_its_force() {
    let errors = [1000, 10_000, 100_000].map(|steps| {
        let laws = (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ);
        OneTurn { steps, unlike: false, energy: 0.0, tangent: true }.errors(laws)[0]
    });
    println!(
        "Hertz, Mindlin-Deresiewicz: error over |T| {errors:.3?}, 1e4 steps {:.2e}, 1e5 steps {:.2e}",
        errors[1], errors[2]
    );
    for (error, stated) in errors.into_iter().zip([3.5e-2, 3.5e-4, 3.5e-6]) {
        assert!(error < 1.05 * stated, "{error:e} {stated:e}");
    }
}

#[test]
fn every_law_keeps_its_force_in_a_turn() {
    for (normal, tangential) in super::ALL {
        for (unlike, energy) in [(false, 0.0), (true, 0.6)] {
            let errors = [1000, 10_000].map(|steps| {
                let turn = OneTurn { steps, unlike, energy, tangent: false };
                turn.errors((normal, tangential))[0]
            });
            println!(
                "{normal:?} {tangential:?} unlike {unlike}: error over |T| {:.2e} {:.2e}",
                errors[0], errors[1]
            );
            assert!(errors[0] < 0.3 && errors[1] < 3e-3, "{errors:?}");
            assert!((errors[0] / errors[1] / 100.0 - 1.0).abs() < 0.2, "{errors:?}");
        }
    }
}

/// The transformation of vectors to another frame.
type Map<'a> = &'a dyn Fn([f64; 3]) -> [f64; 3];

/// The same motion in another frame of reference, and with the roles of the grains exchanged, gives the same result.
fn is_seen_alike_in_other_frames(laws: LawPair) {
    let vectors = laws.1.law().history()[1];
    let pair = PairProperties { damping: 0.1, ..spheres(0.6) };
    let mut benches: [Bench; 4] = std::array::from_fn(|_| Bench::new(laws, pair));
    let mut direction = START;
    for step in 0..600 {
        let wave = |rate: f64| (rate * step as f64).sin();
        direction = add_scaled(direction, 2e-3, [wave(0.1), wave(0.07), -3.0 + wave(0.05)]);
        direction = scale(1.0 / dot(direction, direction).sqrt(), direction);
        let motion = PairMotion {
            branch: scale(1e-4 - 1e-8 * (1.2 + wave(0.03)), direction),
            velocity: [2e-2 * wave(0.2), -1e-2 * wave(0.13), 3e-2 * wave(0.11)],
            rolling: [100.0 * wave(0.3), 200.0, -50.0],
            mean_spin: [100.0 * wave(0.3), 200.0, -50.0],
            relative_spin: [-80.0, 60.0 * wave(0.21), 70.0 * wave(0.17)],
        };
        let seen = |f: Map| PairMotion {
            branch: f(motion.branch),
            velocity: f(motion.velocity),
            rolling: f(motion.rolling),
            mean_spin: f(motion.mean_spin),
            relative_spin: f(motion.relative_spin),
        };
        let permuted = |v: [f64; 3]| [v[2], v[0], v[1]];
        let oblique = |v: [f64; 3]| turned(v, 2.3);
        let negated = |v: [f64; 3]| v.map(|x| -x);
        // Spins are axial vectors: they keep their sign when i and j change roles.
        let swapped =
            PairMotion { branch: negated(motion.branch), velocity: negated(motion.velocity), ..motion };
        let reference = benches[0].interact(&motion, 1e-8);
        let scale_of_force = dot(reference.force, reference.force).sqrt().max(1e-6);
        let cases: [(PairMotion<f64>, Map); 3] =
            [(seen(&permuted), &permuted), (seen(&oblique), &oblique), (swapped, &negated)];
        for (k, (motion, map)) in cases.iter().enumerate() {
            if k == 2 && step % 50 == 0 {
                // Exchanged twice, as when the engine sorts its grains again.
                swap(&mut benches[3].memory, vectors);
                swap(&mut benches[3].memory, vectors);
            }
            let out = benches[k + 1].interact(motion, 1e-8);
            let expected = map(reference.force);
            for a in 0..3 {
                let error = (out.force[a] - expected[a]).abs() / scale_of_force;
                assert!(error < 1e-6, "step {step}, case {k}: {error:e}");
            }
        }
    }
    // The history of (i, j) rewritten for (j, i) is that of the pair seen from j.
    let mut mine = benches[0].memory;
    swap(&mut mine, vectors);
    for a in 0..3 {
        assert!((mine.normal[a] - benches[3].memory.normal[a]).abs() < 1e-12);
    }
    for (c, (a, b)) in mine.history.iter().zip(&benches[3].memory.history).enumerate() {
        assert!((a - b).abs() <= 1e-6 * a.abs().max(1e-5), "column {c}: {a} {b}");
    }
}

#[test]
fn results_do_not_depend_on_the_frame() {
    super::ALL.into_iter().for_each(is_seen_alike_in_other_frames);
}
