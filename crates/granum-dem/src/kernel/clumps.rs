//! The stage of clumps: sums the forces on the pieces of every clump, advances it, and puts its pieces to their new places. Eight clumps at a time turn side by side.

use std::ops::Range;

use granum_core::rotation::to_space;
use granum_simd::{Kernel, LANES, Lanes, Row4, Row8};

use super::grains::larger;
use super::views::Views;
use crate::clump::clumps::Clump;
use crate::clump::ranks::Rank;
use crate::clump::rotor;
use crate::pairs::resultant_lanes;

/// The stage of clumps for a range of blocks: each block moves a share of the clumps.
pub(crate) struct ClumpStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl Kernel for ClumpStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        let (blocks, all, eights) = (v.blocks.len(), v.clumps.len(), v.ranks_of_eight.len());
        for k in self.blocks {
            let (mut fastest, mut lost) = (L::zero(), L::zero());
            for eight in k * eights / blocks..(k + 1) * eights / blocks {
                let range = LANES * eight..usize::min(LANES * (eight + 1), all);
                // SAFETY: a clump belongs to one block, and a block to the thread that works on it; ranks are only read.
                let (clumps, ranks) = unsafe {
                    let [from, to] = v.ranks_of_eight.read()[eight];
                    (v.clumps.write(range), &v.ranks.read()[from as usize..to as usize])
                };
                let square = step::<L>(v, clumps, ranks);
                fastest = fastest.max(square);
                // A maximum leaves out what is not a number.
                lost = square.mul_add(L::zero(), lost);
            }
            // SAFETY: only this thread works on this block.
            let of_block = unsafe { &mut v.fastest_grain.write(k..k + 1)[0] };
            *of_block = larger(*of_block, fastest.reduce_max() + lost.reduce_add());
        }
    }
}

/// A vector in each lane.
type Vectors<L> = [L; 3];
/// A matrix in each lane.
type Matrices<L> = [[L; 3]; 3];

#[inline(always)]
fn apply<L: Lanes>(matrix: &Matrices<L>, x: &Vectors<L>) -> Vectors<L> {
    let mut y = [L::zero(); 3];
    for r in 0..3 {
        y[r] = matrix[r][0].mul_add(x[0], matrix[r][1].mul_add(x[1], matrix[r][2] * x[2]));
    }
    y
}

/// The velocity gradient of the cell times a vector.
#[inline(always)]
fn affine<L: Lanes>(v: &Views, x: &Vectors<L>) -> Vectors<L> {
    let mut y = [L::zero(); 3];
    for r in 0..3 {
        let [a, b, c] = v.gradient[r];
        y[r] = L::splat(a).mul_add(x[0], L::splat(b).mul_add(x[1], L::splat(c) * x[2]));
    }
    y
}

#[inline(always)]
fn cross<L: Lanes>(a: &Vectors<L>, b: &Vectors<L>) -> Vectors<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The centres of the pieces of a rank in the axes of their bodies.
#[inline(always)]
fn centres<L: Lanes>(rank: &Rank) -> Vectors<L> {
    [L::load(&rank.centre[0]), L::load(&rank.centre[1]), L::load(&rank.centre[2])]
}

/// A row of eight numbers of each clump as columns; lanes without a clump repeat the first.
#[inline(always)]
fn columns<L: Lanes>(clumps: &[Clump], row: usize) -> [L; 8] {
    let mut rows = [L::load(&clumps[0].rows()[row]); LANES];
    for (lane, clump) in rows.iter_mut().zip(clumps) {
        *lane = L::load(&clump.rows()[row]);
    }
    L::transpose(rows)
}

/// Stores columns into a row of eight numbers of each clump.
#[inline(always)]
fn put<L: Lanes>(clumps: &mut [Clump], row: usize, columns: [L; 8]) {
    let rows = L::transpose(columns);
    for (lane, clump) in rows.iter().zip(clumps) {
        lane.store(&mut clump.rows_mut()[row]);
    }
}

/// One step of up to eight clumps; returns the squares of the fluctuating velocities of their fastest pieces.
#[inline(always)]
fn step<L: Lanes>(v: &Views, clumps: &mut [Clump], ranks: &[Rank]) -> L {
    let turning = columns::<L>(clumps, 1);
    let axes = rotor::axes(&[turning[0], turning[1], turning[2], turning[3]]);
    let (mut force, mut moment) = ([L::zero(); 3], [L::zero(); 3]);
    for rank in ranks {
        add_loads(v, rank, &axes, &mut force, &mut moment);
    }
    let moved = advance::<L>(v, clumps, turning, &force, &moment);
    let (mut fastest, mut lost) = (L::zero(), L::zero());
    for rank in ranks {
        let square = move_pieces(v, rank, &axes, &moved);
        fastest = fastest.max(square);
        // A maximum leaves out what is not a number.
        lost = square.mul_add(L::zero(), lost);
    }
    fastest + lost
}

/// Adds the forces on the pieces of a rank to the forces on the clumps, and to the moments about their centres.
#[inline(always)]
fn add_loads<L: Lanes>(
    v: &Views,
    rank: &Rank,
    axes: &Matrices<L>,
    force: &mut Vectors<L>,
    moment: &mut Vectors<L>,
) {
    // SAFETY: forces and lists are only read in this stage.
    let (forces, offsets, outer) = unsafe { (v.forces.read(), v.outer_offsets.read(), v.outer.read()) };
    let mut totals = [L::zero(); LANES];
    for l in 0..LANES {
        if rank.present[l] {
            totals[l] = resultant_lanes::<L>(forces, offsets, outer, rank.rows[l] as usize);
        }
    }
    let [fx, fy, fz, _, mx, my, mz, _] = L::transpose(totals);
    let (on_piece, turning) = ([fx, fy, fz], [mx, my, mz]);
    let lever = cross(&apply(axes, &centres(rank)), &on_piece);
    let radius = L::load(&rank.radius);
    for a in 0..3 {
        force[a] = force[a] + on_piece[a];
        moment[a] = moment[a] + radius.mul_add(turning[a], lever[a]);
    }
}

/// What the pieces of eight clumps need after a step.
struct Moved<L> {
    centre: Vectors<L>,
    velocity: Vectors<L>,
    axes: Matrices<L>,
    /// The mean spins of the step, rad/s.
    spin: Vectors<L>,
    mass: L,
}

/// Kick and drift of up to eight clumps, whose second rows are given as columns.
#[inline(always)]
fn advance<L: Lanes>(
    v: &Views,
    clumps: &mut [Clump],
    turning: [L; 8],
    force: &Vectors<L>,
    moment: &Vectors<L>,
) -> Moved<L> {
    let (dt, retain) = (L::splat(v.dt), L::splat(v.retain));
    let moving = columns::<L>(clumps, 0);
    let (mass, volume) = (moving[3], moving[7]);
    let start = [moving[0], moving[1], moving[2]];
    let kick = dt / mass;
    let (mut velocity, mut momentum, mut inertia) = ([L::zero(); 3], [L::zero(); 3], [L::zero(); 3]);
    for a in 0..3 {
        velocity[a] = kick.mul_add(force[a], moving[4 + a] * retain);
        momentum[a] = dt.mul_add(moment[a], turning[4 + a] * retain);
        let mut moments = [clumps[0].inertia[a]; LANES];
        for (lane, clump) in moments.iter_mut().zip(clumps.iter()) {
            *lane = clump.inertia[a];
        }
        inertia[a] = L::load(&moments);
    }
    let (drift, mut centre) = (affine(v, &start), start);
    for a in 0..3 {
        centre[a] = dt.mul_add(velocity[a] + drift[a], start[a]);
    }
    let before = [turning[0], turning[1], turning[2], turning[3]];
    let after = rotor::turned(&before, &momentum, &inertia, dt);
    let spin = rotor::mean_spin(&before, &after, dt);
    let ([x, y, z], [vx, vy, vz]) = (centre, velocity);
    put(clumps, 0, [x, y, z, mass, vx, vy, vz, volume]);
    let ([a, b, c, d], [lx, ly, lz]) = (after, momentum);
    put(clumps, 1, [a, b, c, d, lx, ly, lz, turning[7]]);
    Moved { centre, velocity, axes: rotor::axes(&after), spin, mass }
}

/// Puts the pieces of a rank to their places, with the fluctuating velocity `v' + omega x c_mean - L c` of their rows; returns its square.
#[inline(always)]
fn move_pieces<L: Lanes>(v: &Views, rank: &Rank, before: &Matrices<L>, moved: &Moved<L>) -> L {
    let centre = centres(rank);
    let (old, arm) = (apply(before, &centre), apply(&moved.axes, &centre));
    let half = L::splat(0.5);
    let middle = [half * (old[0] + arm[0]), half * (old[1] + arm[1]), half * (old[2] + arm[2])];
    let (turning, drift) = (cross(&moved.spin, &middle), affine(v, &arm));
    let (mut velocity, mut place) = ([L::zero(); 3], [L::zero(); 3]);
    for a in 0..3 {
        velocity[a] = moved.velocity[a] + turning[a] - drift[a];
        place[a] = moved.centre[a] + arm[a];
    }
    let ([x, y, z], [vx, vy, vz]) = (place, velocity);
    let rows = L::transpose([x, y, z, L::load(&rank.radius), vx, vy, vz, moved.mass]);
    let (zero, [wx, wy, wz]) = (L::zero(), moved.spin);
    let beside = L::transpose([wx, wy, wz, zero, arm[0], arm[1], arm[2], zero]);
    for l in 0..LANES {
        if !rank.present[l] {
            continue;
        }
        let row = rank.rows[l] as usize;
        // SAFETY: the rows of a piece are written by the thread of its clump alone.
        let (particle, spin, arm) = unsafe {
            (
                &mut v.particles.write(row..row + 1)[0],
                &mut v.spin.write(row..row + 1)[0],
                &mut v.arms.write(row..row + 1)[0],
            )
        };
        rows[l].store(&mut particle.0);
        let mut pair = [0.0; 8];
        beside[l].store(&mut pair);
        *spin = Row4([pair[0], pair[1], pair[2], pair[3]]);
        *arm = Row4([pair[4], pair[5], pair[6], pair[7]]);
        if rank.imaged {
            add_image(v, rank.images[l], particle);
        }
    }
    vx.mul_add(vx, vy.mul_add(vy, vz * vz))
}

/// Moves a row to its image from that of the body.
#[cold]
fn add_image(v: &Views, [i, j, k]: [i32; 3], particle: &mut Row8) {
    if [i, j, k] == [0; 3] {
        return;
    }
    let image = to_space(&v.edges, &[f64::from(i), f64::from(j), f64::from(k)]);
    for a in 0..3 {
        particle.0[a] += image[a];
    }
}
