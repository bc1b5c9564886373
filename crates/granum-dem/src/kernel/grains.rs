//! The grain stage: sums the forces on every sphere and advances it by kick and drift. The pieces of clumps are left to the stage of clumps.

use std::ops::Range;

use granum_simd::{Kernel, Lanes, Real, Row4, Row8};

use super::views::Views;
use crate::clump::clumps::NO_CLUMP;
use crate::pairs::resultant;
use crate::particle_row::ParticleRow;

/// The grain stage for a range of blocks: force sums, kicks and drifts. With `CLUMPS`, rows of clumps are passed over.
pub(crate) struct GrainStage<'a, const CLUMPS: bool> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl<const CLUMPS: bool> Kernel for GrainStage<'_, CLUMPS> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        let drift = Drift::new(v);
        for k in self.blocks {
            // SAFETY: forces and lists are only read in this stage; the grains of a block belong to the thread that
            // works on it.
            let [start, end] = unsafe { v.blocks.read()[k] }.grains;
            let range = start as usize..end as usize;
            let (forces, offsets, outer, particles, spin) = unsafe {
                (
                    v.forces.read(),
                    v.outer_offsets.read(),
                    v.outer.read(),
                    v.particles.write(range.clone()),
                    v.spin.write(range.clone()),
                )
            };
            let mut fastest = 0.0f64;
            let equal = v.equal.then(|| kicks(v, &particles[0]));
            for (n, g) in range.enumerate() {
                // SAFETY: never written during a step.
                if CLUMPS && unsafe { v.clump_of.read()[g] } != NO_CLUMP {
                    continue;
                }
                if v.far {
                    fetch_ahead(v, outer, offsets[g] as usize, g + AHEAD);
                }
                let total = resultant::<L>(forces, offsets, outer, g);
                let [kick, turn] = equal.unwrap_or_else(
                    #[inline(always)]
                    || kicks(v, &particles[n]),
                );
                let square =
                    advance_grain::<L::Scalar>(&drift, kick, turn, &total, &mut particles[n], &mut spin[n]);
                fastest = larger(fastest, square);
            }
            // SAFETY: only this thread works on this block.
            unsafe { v.fastest_grain.write(k..k + 1)[0] = fastest };
        }
    }
}

/// Number of grains between prefetching one and moving it.
const AHEAD: usize = 12;

/// Prefetches what a later grain will read: the rows of other blocks can be anywhere.
#[inline(always)]
fn fetch_ahead(v: &Views, outer: &[u32], from: usize, later: usize) {
    v.forces.prefetch(later);
    v.particles.prefetch(later);
    v.spin.prefetch(later);
    for &row in outer.iter().skip(from + AHEAD).take(2) {
        v.forces.prefetch(row as usize);
    }
}

/// The larger of two numbers, or NaN if either is NaN.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Factors that convert the force on a grain to a change of its velocity, and torque over radius to a change of its spin.
#[inline(always)]
fn kicks(v: &Views, particle: &Row8) -> [f64; 2] {
    let kick = v.dt / particle.mass();
    // Torque = R * moment and inertia = 2/5 m R^2.
    [kick, 2.5 * kick / particle.radius()]
}

/// Coefficients of the drift of every grain, entry by entry: the fourth entry of a row is not changed.
struct Drift {
    /// Columns of the velocity gradient.
    gradient: [[f64; 4]; 3],
    dt: [f64; 4],
    retain: [f64; 4],
}

impl Drift {
    fn new(v: &Views) -> Self {
        let column = |c: usize| [v.gradient[0][c], v.gradient[1][c], v.gradient[2][c], 0.0];
        Drift {
            gradient: [column(0), column(1), column(2)],
            dt: [v.dt, v.dt, v.dt, 0.0],
            retain: [v.retain, v.retain, v.retain, 1.0],
        }
    }
}

/// Kick and drift of a grain; returns the square of its fluctuating velocity.
///
/// The loops over rows of four are vectorized.
#[inline(always)]
fn advance_grain<R: Real>(
    drift: &Drift,
    kick: f64,
    turn: f64,
    total: &[f64; 8],
    particle: &mut Row8,
    spin: &mut Row4,
) -> f64 {
    let [gx, gy, gz]: [[R; 4]; 3] =
        [four(drift.gradient[0]), four(drift.gradient[1]), four(drift.gradient[2])];
    let (dt, retain): ([R; 4], [R; 4]) = (four(drift.dt), four(drift.retain));
    let (kick, turn) = (R::splat(kick), R::splat(turn));
    let p = &mut particle.0;
    let [x, y, z] = [R::splat(p[0]), R::splat(p[1]), R::splat(p[2])];
    let mut velocity = [R::zero(); 4];
    for k in 0..4 {
        velocity[k] = kick.mul_add(R::splat(total[k]), R::splat(p[4 + k]) * retain[k]);
    }
    for k in 0..4 {
        spin.0[k] = turn.mul_add(R::splat(total[4 + k]), R::splat(spin.0[k]) * retain[k]).reduce_add();
    }
    for k in 0..4 {
        let drift = gx[k].mul_add(x, gy[k].mul_add(y, gz[k].mul_add(z, velocity[k])));
        p[k] = dt[k].mul_add(drift, R::splat(p[k])).reduce_add();
    }
    for k in 0..4 {
        p[4 + k] = velocity[k].reduce_add();
    }
    let [x, y, z, _] = velocity;
    z.mul_add(z, y.mul_add(y, x * x)).reduce_add()
}

#[inline(always)]
fn four<R: Real>(row: [f64; 4]) -> [R; 4] {
    [R::splat(row[0]), R::splat(row[1]), R::splat(row[2]), R::splat(row[3])]
}
