//! The stage of clumps: sums the forces on the pieces of every clump, advances it, and puts its pieces to their new places. Eight clumps at a time turn side by side.

use std::ops::Range;

use granum_core::rotation::to_space;
use granum_simd::{Kernel, LANES, Lanes, Row4, Row8};

use super::grains::larger;
use super::views::Views;
use crate::clump::clumps::{Clump, ClumpPiece};
use crate::clump::rotor;
use crate::pairs::resultant;

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
        let (blocks, clumps) = (v.blocks.len(), v.clumps.len());
        for k in self.blocks {
            let range = k * clumps / blocks..(k + 1) * clumps / blocks;
            // SAFETY: a clump belongs to one block, and a block to the thread that works on it; pieces are only read in this stage.
            let (clumps, pieces) = unsafe { (v.clumps.write(range), v.clump_pieces.read()) };
            let (mut fastest, mut lost) = (L::zero(), L::zero());
            for eight in clumps.chunks_mut(LANES) {
                let square = step::<L>(v, eight, pieces);
                fastest = fastest.max(square);
                // A maximum forgets what is not a number.
                lost = lost + (square - square);
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

#[inline(always)]
fn cross<L: Lanes>(a: &Vectors<L>, b: &Vectors<L>) -> Vectors<L> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// The pieces of one rank of up to eight clumps. Clumps with fewer pieces repeat their first one, and lanes without a clump that of the first
/// clump: neither is `present`.
struct Rank<L> {
    present: [bool; LANES],
    rows: [usize; LANES],
    images: [[i32; 3]; LANES],
    centre: Vectors<L>,
    radius: L,
}

impl<L: Lanes> Rank<L> {
    #[inline(always)]
    fn new(clumps: &[Clump], pieces: &[ClumpPiece], rank: u32) -> Self {
        let (mut present, mut rows, mut images) = ([false; LANES], [0; LANES], [[0; 3]; LANES]);
        let mut columns = [[0.0; LANES]; 4];
        for l in 0..LANES {
            let [first, end] = clumps[if l < clumps.len() { l } else { 0 }].pieces;
            let within = first + rank < end;
            let piece = &pieces[if within { first + rank } else { first } as usize];
            present[l] = within && l < clumps.len();
            rows[l] = piece.row as usize;
            images[l] = piece.image;
            for a in 0..3 {
                columns[a][l] = piece.centre[a];
            }
            columns[3][l] = piece.radius;
        }
        let [x, y, z, radius] = columns;
        let centre = [L::load(&x), L::load(&y), L::load(&z)];
        Rank { present, rows, images, centre, radius: L::load(&radius) }
    }
}

/// One step of up to eight clumps; returns the squares of the fluctuating velocities of their fastest pieces.
#[inline(always)]
fn step<L: Lanes>(v: &Views, clumps: &mut [Clump], pieces: &[ClumpPiece]) -> L {
    let ranks = clumps.iter().fold(0, |most, clump| (clump.pieces[1] - clump.pieces[0]).max(most));
    let mut orientation = [L::zero(); 4];
    for a in 0..4 {
        orientation[a] = column(clumps, |clump| clump.orientation[a]);
    }
    let axes = rotor::axes(&orientation);
    let (mut force, mut moment) = ([L::zero(); 3], [L::zero(); 3]);
    for rank in 0..ranks {
        add_loads(v, &Rank::<L>::new(clumps, pieces, rank), &axes, &mut force, &mut moment);
    }
    let moved = advance::<L>(v, clumps, &orientation, &force, &moment);
    let (mut fastest, mut lost) = (L::zero(), L::zero());
    for rank in 0..ranks {
        let square = move_pieces(v, &Rank::<L>::new(clumps, pieces, rank), &axes, &moved);
        fastest = fastest.max(square);
        // A maximum forgets what is not a number.
        lost = lost + (square - square);
    }
    fastest + lost
}

/// Adds the forces on the pieces of a rank to the forces on the clumps, and to the moments about their centres.
#[inline(always)]
fn add_loads<L: Lanes>(
    v: &Views,
    rank: &Rank<L>,
    axes: &Matrices<L>,
    force: &mut Vectors<L>,
    moment: &mut Vectors<L>,
) {
    let mut totals = [L::zero(); LANES];
    for l in 0..LANES {
        if rank.present[l] {
            // SAFETY: forces and lists are only read in this stage.
            let total = unsafe {
                resultant::<L>(v.forces.read(), v.outer_offsets.read(), v.outer.read(), rank.rows[l])
            };
            totals[l] = L::load(&total);
        }
    }
    let [fx, fy, fz, _, mx, my, mz, _] = L::transpose(totals);
    let (on_piece, turning) = ([fx, fy, fz], [mx, my, mz]);
    let lever = cross(&apply(axes, &rank.centre), &on_piece);
    for a in 0..3 {
        force[a] = force[a] + on_piece[a];
        moment[a] = moment[a] + rank.radius.mul_add(turning[a], lever[a]);
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

/// A number of each clump; lanes without one repeat the first.
#[inline(always)]
fn column<L: Lanes>(clumps: &[Clump], number: impl Fn(&Clump) -> f64) -> L {
    let mut values = [number(&clumps[0]); LANES];
    for (value, clump) in values.iter_mut().zip(clumps) {
        *value = number(clump);
    }
    L::load(&values)
}

/// Stores a number of each clump.
#[inline(always)]
fn put<L: Lanes>(clumps: &mut [Clump], numbers: L, place: impl Fn(&mut Clump) -> &mut f64) {
    let mut values = [0.0; LANES];
    numbers.store(&mut values);
    for (clump, value) in clumps.iter_mut().zip(values) {
        *place(clump) = value;
    }
}

/// Kick and drift of up to eight clumps.
#[inline(always)]
fn advance<L: Lanes>(
    v: &Views,
    clumps: &mut [Clump],
    before: &[L; 4],
    force: &Vectors<L>,
    moment: &Vectors<L>,
) -> Moved<L> {
    let (dt, retain) = (L::splat(v.dt), L::splat(v.retain));
    let mass = column::<L>(clumps, |clump| clump.mass);
    let kick = dt / mass;
    let (mut velocity, mut momentum) = ([L::zero(); 3], [L::zero(); 3]);
    let (mut start, mut inertia) = ([L::zero(); 3], [L::zero(); 3]);
    for a in 0..3 {
        velocity[a] = kick.mul_add(force[a], column::<L>(clumps, |clump| clump.velocity[a]) * retain);
        momentum[a] = dt.mul_add(moment[a], column::<L>(clumps, |clump| clump.momentum[a]) * retain);
        start[a] = column::<L>(clumps, |clump| clump.centre[a]);
        inertia[a] = column::<L>(clumps, |clump| clump.inertia[a]);
    }
    let mut centre = start;
    for a in 0..3 {
        let [x, y, z] = v.gradient[a];
        let affine = L::splat(x).mul_add(start[0], L::splat(y).mul_add(start[1], L::splat(z) * start[2]));
        centre[a] = dt.mul_add(velocity[a] + affine, start[a]);
    }
    let after = rotor::turned(before, &momentum, &inertia, dt);
    let spin = rotor::mean_spin(before, &after, dt);
    for a in 0..3 {
        put(clumps, velocity[a], |clump| &mut clump.velocity[a]);
        put(clumps, momentum[a], |clump| &mut clump.momentum[a]);
        put(clumps, centre[a], |clump| &mut clump.centre[a]);
    }
    for a in 0..4 {
        put(clumps, after[a], |clump| &mut clump.orientation[a]);
    }
    Moved { centre, velocity, axes: rotor::axes(&after), spin, mass }
}

/// Puts the pieces of a rank to their places, with the fluctuating velocity `v' + omega x c_mean - L c` of their rows; returns its square.
#[inline(always)]
fn move_pieces<L: Lanes>(v: &Views, rank: &Rank<L>, before: &Matrices<L>, moved: &Moved<L>) -> L {
    let (old, arm) = (apply(before, &rank.centre), apply(&moved.axes, &rank.centre));
    let half = L::splat(0.5);
    let middle = [half * (old[0] + arm[0]), half * (old[1] + arm[1]), half * (old[2] + arm[2])];
    let turning = cross(&moved.spin, &middle);
    let (mut velocity, mut place) = ([L::zero(); 3], [L::zero(); 3]);
    for a in 0..3 {
        let [x, y, z] = v.gradient[a];
        let affine = L::splat(x).mul_add(arm[0], L::splat(y).mul_add(arm[1], L::splat(z) * arm[2]));
        velocity[a] = moved.velocity[a] + turning[a] - affine;
        place[a] = moved.centre[a] + arm[a];
    }
    let [x, y, z] = place;
    let [vx, vy, vz] = velocity;
    let rows = L::transpose([x, y, z, rank.radius, vx, vy, vz, moved.mass]);
    let zero = L::zero();
    let [wx, wy, wz] = moved.spin;
    let beside = L::transpose([wx, wy, wz, zero, arm[0], arm[1], arm[2], zero]);
    for l in 0..LANES {
        if !rank.present[l] {
            continue;
        }
        let row = rank.rows[l];
        // SAFETY: the rows of a piece are written by the thread of its clump alone.
        let (particle, spin, arm) = unsafe {
            (
                &mut v.particles.write(row..row + 1)[0],
                &mut v.spin.write(row..row + 1)[0],
                &mut v.arms.write(row..row + 1)[0],
            )
        };
        rows[l].store(&mut particle.0);
        if rank.images[l] != [0; 3] {
            add_image(v, rank.images[l], particle);
        }
        let mut pair = [0.0; 8];
        beside[l].store(&mut pair);
        *spin = Row4([pair[0], pair[1], pair[2], pair[3]]);
        *arm = Row4([pair[4], pair[5], pair[6], pair[7]]);
    }
    vx.mul_add(vx, vy.mul_add(vy, vz * vz))
}

/// Moves a row to the image of the body in which it is.
#[inline(always)]
fn add_image(v: &Views, [i, j, k]: [i32; 3], particle: &mut Row8) {
    let image = to_space(&v.edges, &[f64::from(i), f64::from(j), f64::from(k)]);
    for a in 0..3 {
        particle.0[a] += image[a];
    }
}
