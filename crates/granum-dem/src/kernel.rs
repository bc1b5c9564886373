//! The two stages of a step: every contact adds to the force rows of its grains, every grain sums its rows and moves.
//!
//! Both stages work on the blocks of the pair list, so that their sums do not depend on who computed them. [`Views`] is what all
//! threads see of the state during a stage; its `unsafe` follows the rules of [`crate::team::RawSlice`].

use std::marker::PhantomData;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use granum_simd::{Kernel, LANES, Lanes, Mask, Row4, Row8};

use crate::assembly::Matrix;
use crate::contact::interaction::{Kinematics, Memory, dot, interact};
use crate::contact::{NormalLaw, PairConstants, TangentialLaw};
use crate::forgotten::Forgotten;
use crate::pairs::{Block, IMAGES, Marks};
use crate::team::RawSlice;

/// Columns of memory before the tangential law's own: the old normal.
pub(crate) const NORMAL_COLUMNS: usize = 3;

/// Sums over the contacts of a block (or of all).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub struct ContactSums {
    /// `- sum of (elastic force on i)_a (branch)_b`, J: the stress times the volume.
    pub virial: [f64; 9],
    /// Work taken up by the elastic tangential forces in this step, J.
    pub tangential_work: f64,
    /// Lost to sliding in this step, J.
    pub friction_loss: f64,
    /// Lost without sliding in this step, J.
    pub micro_slip_loss: f64,
    /// Lost in dashpots in this step, J.
    pub damping_loss: f64,
    /// Lost by contacts made in this step, J.
    pub adhesion_made: f64,
    /// Lost by contacts broken in this step, J.
    pub adhesion_broken: f64,
    /// Power that the cell's deformation feeds into the contacts, W.
    pub boundary_power: f64,
    /// `sum of k_n D^2`, J.
    pub stiffness: f64,
    /// `sum of |N|` of the elastic normal forces, N.
    pub normal_force: f64,
    /// Largest `k_t / m` of a contact, with the smaller mass of the two, 1/s2.
    pub fastest: f64,
}

const SUMS: usize = 18;

impl ContactSums {
    /// The sums of blocks, in their order.
    pub(crate) fn total(blocks: &[ContactSums]) -> ContactSums {
        let mut t = ContactSums::default();
        for c in blocks {
            for a in 0..9 {
                t.virial[a] += c.virial[a];
            }
            t.tangential_work += c.tangential_work;
            t.friction_loss += c.friction_loss;
            t.damping_loss += c.damping_loss;
            t.micro_slip_loss += c.micro_slip_loss;
            t.adhesion_made += c.adhesion_made;
            t.adhesion_broken += c.adhesion_broken;
            t.boundary_power += c.boundary_power;
            t.stiffness += c.stiffness;
            t.normal_force += c.normal_force;
            t.fastest = t.fastest.max(c.fastest);
        }
        t
    }
}

/// What the threads see of the state during the stages of a step.
#[derive(Clone, Copy)]
pub(crate) struct Views {
    pub(crate) grains: usize,
    pub(crate) place: RawSlice<Row8>,
    pub(crate) spin: RawSlice<Row4>,
    pub(crate) blocks: RawSlice<Block>,
    pub(crate) first: RawSlice<[u32; LANES]>,
    pub(crate) second: RawSlice<[u32; LANES]>,
    pub(crate) target: RawSlice<[u32; LANES]>,
    pub(crate) image: RawSlice<[u32; LANES]>,
    pub(crate) memory: RawSlice<Row8>,
    pub(crate) marks: RawSlice<Marks>,
    pub(crate) constants: RawSlice<Row8>,
    pub(crate) forces: RawSlice<Row8>,
    pub(crate) outer_offsets: RawSlice<u32>,
    pub(crate) outer: RawSlice<u32>,
    pub(crate) contact_sums: RawSlice<ContactSums>,
    pub(crate) fastest_grain: RawSlice<f64>,
    /// True where all grains have one mass and radius.
    pub(crate) equal: bool,
    /// True where the memory of the contacts does not fit into the caches.
    pub(crate) far: bool,
    pub(crate) alike: PairConstants<f64>,
    pub(crate) images: [Row4; IMAGES],
    pub(crate) gradient: Matrix,
    pub(crate) dt: f64,
    /// How often what is forgotten in this step counts, zero if not at all.
    pub(crate) account: f64,
    /// Factor on velocities and spins in a step: 1 without global damping.
    pub(crate) retain: f64,
}

/// Where the constants of a batch come from.
pub(crate) trait ConstantSource: Copy {
    /// True if each batch has its own.
    const BY_BATCH: bool;
}

/// All pairs are alike.
#[derive(Clone, Copy)]
pub(crate) struct Alike;
/// Pairs differ.
#[derive(Clone, Copy)]
pub(crate) struct ByBatch;
impl ConstantSource for Alike {
    const BY_BATCH: bool = false;
}
impl ConstantSource for ByBatch {
    const BY_BATCH: bool = true;
}

/// The contact stage for a range of blocks.
pub(crate) struct ContactStage<'a, N, T, C> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
    pub(crate) laws: PhantomData<(N, T, C)>,
}

/// What the kernel holds for all batches of a stage.
struct Common<L: Lanes> {
    gradient: [[L; 3]; 3],
    dt: L,
    alike: PairConstants<L>,
}

impl<N: NormalLaw, T: TangentialLaw, C: ConstantSource> Kernel for ContactStage<'_, N, T, C> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        let common = Common::<L> {
            gradient: v.gradient.map(|row| row.map(L::splat)),
            dt: L::splat(v.dt),
            alike: v.alike.splat(),
        };
        // SAFETY: grains are only read in this stage.
        let mass = unsafe { v.place.read()[0].0[7] };
        let mut forgotten = Forgotten::new();
        for k in self.blocks {
            // SAFETY: blocks are only read; their rows of forces belong to the thread that works on the block.
            let block = unsafe { &v.blocks.read()[k] };
            for [from, to] in [block.grains, block.outer] {
                unsafe { v.forces.write(from as usize..to as usize) }.fill(Row8::default());
            }
            let [start, inner, end] = block.batches.map(|b| b as usize);
            let mut sums = [L::zero(); SUMS];
            let mut fastest = L::zero();
            if T::FORGETS && v.account != 0.0 {
                // Rare: one kind of batch is enough.
                for b in start..end {
                    let put = Some(&mut forgotten);
                    contact_batch::<L, N, T, C, true>(v, b, &common, &mut sums, &mut fastest, put);
                    if forgotten.is_full() || b + 1 == end {
                        let lost = forgotten.take::<L, T>();
                        sums[15] = lost.mul_add(L::splat(v.account), sums[15]);
                    }
                }
            } else {
                for b in start..inner {
                    contact_batch::<L, N, T, C, false>(v, b, &common, &mut sums, &mut fastest, None);
                }
                for b in inner..end {
                    contact_batch::<L, N, T, C, true>(v, b, &common, &mut sums, &mut fastest, None);
                }
            }
            let mut s = [0.0; SUMS];
            for (sum, lanes) in s.iter_mut().zip(sums) {
                *sum = lanes.reduce_add();
            }
            // SAFETY: this thread alone works on this block in this stage.
            let target = unsafe { &mut v.contact_sums.write(k..k + 1)[0] };
            *target = ContactSums {
                virial: std::array::from_fn(|a| s[a]),
                tangential_work: s[9],
                friction_loss: s[10],
                damping_loss: s[11],
                boundary_power: s[12],
                stiffness: s[13],
                normal_force: s[14],
                micro_slip_loss: s[15],
                adhesion_made: s[16],
                adhesion_broken: s[17],
                // Equal grains have one mass to divide by.
                fastest: fastest.reduce_max() / if C::BY_BATCH { 1.0 } else { mass },
            };
        }
    }
}

#[inline(always)]
fn contact_batch<L: Lanes, N: NormalLaw, T: TangentialLaw, C: ConstantSource, const IMAGE: bool>(
    v: &Views,
    b: usize,
    common: &Common<L>,
    sums: &mut [L; SUMS],
    fastest: &mut L,
    forgotten: Option<&mut Forgotten>,
) {
    let columns = NORMAL_COLUMNS + T::HISTORY;
    // SAFETY: grains and lists are only read in this stage; memory and marks of a batch belong to the thread that
    // works on its block.
    let (place, spin, i, j, memory_rows, marks) = unsafe {
        (
            &v.place.read()[..v.grains + 2],
            &v.spin.read()[..v.grains + 2],
            &v.first.read()[b],
            &v.second.read()[b],
            v.memory.write(b * columns..(b + 1) * columns),
            &mut v.marks.write(b..b + 1)[0],
        )
    };
    if v.far {
        fetch_ahead(v, b, columns);
    }
    let constants = if C::BY_BATCH {
        // SAFETY: constants are only read.
        let rows = unsafe { &v.constants.read()[b * PairConstants::COUNT..(b + 1) * PairConstants::COUNT] };
        PairConstants::from_columns(|c| L::load(&rows[c].0))
    } else {
        common.alike
    };
    let a = L::gather8(place, i);
    let c = L::gather8(place, j);
    let mut branch = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    if IMAGE {
        // SAFETY: only read in this stage.
        let image = L::gather4(&v.images, unsafe { &v.image.read()[b] });
        branch = std::array::from_fn(|k| branch[k] + image[k]);
    }
    let near = dot(branch, branch).lt(constants.radius_sum * constants.radius_sum);
    if !near.any() && marks.touched == 0 {
        return;
    }
    let mut memory = Memory::<L>::new();
    for k in 0..NORMAL_COLUMNS {
        memory.normal[k] = L::load(&memory_rows[k].0);
    }
    for k in 0..T::HISTORY {
        memory.history[k] = L::load(&memory_rows[NORMAL_COLUMNS + k].0);
    }
    let affine: [L; 3] = std::array::from_fn(|k| dot(common.gradient[k], branch));
    let wa = L::gather4(spin, i);
    let wc = L::gather4(spin, j);
    let half = L::splat(0.5);
    let mean_spin: [L; 3] = std::array::from_fn(|k| half * (wa[k] + wc[k]));
    let rolling = if C::BY_BATCH {
        std::array::from_fn(|k| a[3].mul_add(wa[k], c[3] * wc[k]) * constants.inverse_radius_sum)
    } else {
        mean_spin
    };
    let kinematics = Kinematics {
        branch,
        velocity: std::array::from_fn(|k| c[4 + k] - a[4 + k] + affine[k]),
        rolling,
        mean_spin,
    };
    let out = interact::<L, N, T>(&constants, &kinematics, common.dt, &mut memory);
    if let Some(forgotten) = forgotten {
        // Before the new memory is written over the old.
        let history = &memory_rows[NORMAL_COLUMNS..];
        forgotten.put(out.forgets.bits(), &constants.tangential, out.tangential_stiffness, history);
    }
    for k in 0..3 {
        memory.normal[k].store(&mut memory_rows[k].0);
    }
    for k in 0..T::HISTORY {
        memory.history[k].store(&mut memory_rows[NORMAL_COLUMNS + k].0);
    }
    let touching = out.touching.bits() as u8;
    if touching != marks.touched {
        sums[16] = sums[16] + out.adhesion_made;
        sums[17] = sums[17] + out.adhesion_broken;
    }
    *marks = Marks { touched: touching, sliding: out.sliding.bits() as u8 };
    // SAFETY: only read in this stage.
    let target = unsafe { &v.target.read()[b] };
    add_forces(v, i, target, out.force, out.moment);
    for r in 0..3 {
        for k in 0..3 {
            sums[3 * r + k] = (-out.elastic[r]).mul_add(branch[k], sums[3 * r + k]);
        }
    }
    sums[9] = sums[9] + out.tangential_work;
    sums[10] = sums[10] + out.friction_loss;
    sums[11] = sums[11] + out.damping_loss;
    sums[12] = sums[12] + dot(out.force, affine);
    let square = constants.radius_sum * constants.radius_sum;
    sums[13] = out.normal_stiffness.mul_add(square, sums[13]);
    sums[14] = sums[14] + out.normal_force.abs();
    sums[15] = sums[15] + out.micro_slip_loss;
    let tangential = half * constants.sixteen_shear_moduli * out.radius;
    *fastest = fastest.max(if C::BY_BATCH { tangential / a[7].min(c[7]) } else { tangential });
}

/// Batches between asking for memory and using it.
const AHEAD: usize = 3;

/// Asks for what a later batch will read: the processor foresees neither the places of grains nor the next page.
#[inline(always)]
fn fetch_ahead(v: &Views, b: usize, columns: usize) {
    let later = b + AHEAD;
    for c in 0..columns {
        v.memory.prefetch(later * columns + c);
    }
    // SAFETY: lists are only read in this stage.
    let (first, second) = unsafe { (v.first.read(), v.second.read()) };
    if let (Some(i), Some(j)) = (first.get(later), second.get(later)) {
        for &grain in j.iter().chain(&i[LANES - 1..]) {
            v.place.prefetch(grain as usize);
            v.spin.prefetch(grain as usize);
        }
    }
}

/// Adds what eight pairs do to the force rows of their grains.
#[inline(always)]
fn add_forces<L: Lanes>(v: &Views, i: &[u32; LANES], target: &[u32; LANES], force: [L; 3], moment: [L; 3]) {
    let zero = L::zero();
    let rows = L::transpose([force[0], force[1], force[2], zero, moment[0], moment[1], moment[2], zero]);
    // The force on j is the opposite of that on i; the moments are alike.
    let sign = L::load(&[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    v.forces.check(i);
    v.forces.check(target);
    for l in 0..LANES {
        // SAFETY: checked to be rows; those that the pairs of a block point at belong to the thread that works on it.
        unsafe {
            let on_i = v.forces.at(i[l]);
            (L::load(&on_i.0) + rows[l]).store(&mut on_i.0);
            let on_j = v.forces.at(target[l]);
            rows[l].mul_add(sign, L::load(&on_j.0)).store(&mut on_j.0);
        }
    }
}

/// The grain stage for a range of blocks: sums the forces, kicks, drifts.
pub(crate) struct GrainStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
}

impl Kernel for GrainStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        for k in self.blocks {
            // SAFETY: forces and lists are only read in this stage; the grains of a block belong to the thread that
            // works on it.
            let [start, end] = unsafe { v.blocks.read()[k] }.grains;
            let range = start as usize..end as usize;
            let (forces, offsets, outer, place, spin) = unsafe {
                (
                    v.forces.read(),
                    v.outer_offsets.read(),
                    v.outer.read(),
                    v.place.write(range.clone()),
                    v.spin.write(range.clone()),
                )
            };
            let mut fastest = 0.0f64;
            let equal = v.equal.then(|| kicks(v, &place[0]));
            for (n, g) in range.enumerate() {
                let total = resultant::<L>(forces, offsets, outer, g);
                let [kick, turn] = equal.unwrap_or_else(
                    #[inline(always)]
                    || kicks(v, &place[n]),
                );
                let square = advance_grain(v, kick, turn, &total, &mut place[n], &mut spin[n]);
                fastest = larger(fastest, square);
            }
            // SAFETY: this thread alone works on this block.
            unsafe { v.fastest_grain.write(k..k + 1)[0] = fastest };
        }
    }
}

/// The larger of two numbers, or NaN once either is.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Sum of the force rows of a grain: force (entries 0..3) and torque over radius (4..7).
#[inline(always)]
pub(crate) fn resultant<L: Lanes>(forces: &[Row8], offsets: &[u32], outer: &[u32], g: usize) -> [f64; 8] {
    let mut sum = L::load(&forces[g].0);
    for &row in &outer[offsets[g] as usize..offsets[g + 1] as usize] {
        sum = sum + L::load(&forces[row as usize].0);
    }
    let mut total = [0.0; 8];
    sum.store(&mut total);
    total
}

/// What turns the force on a grain into a change of its velocity, and torque over radius into one of its spin.
#[inline(always)]
fn kicks(v: &Views, place: &Row8) -> [f64; 2] {
    let kick = v.dt / place.0[7];
    // Torque = R * moment and inertia = 2/5 m R^2.
    [kick, 2.5 * kick / place.0[3]]
}

/// Kick and drift; returns the square of the fluctuating velocity.
#[inline(always)]
fn advance_grain(
    v: &Views,
    kick: f64,
    turn: f64,
    total: &[f64; 8],
    place: &mut Row8,
    spin: &mut Row4,
) -> f64 {
    let p = &mut place.0;
    let x = [p[0], p[1], p[2]];
    let mut square = 0.0;
    for k in 0..3 {
        let velocity = kick.mul_add(total[k], p[4 + k] * v.retain);
        spin.0[k] = turn.mul_add(total[4 + k], spin.0[k] * v.retain);
        let row = &v.gradient[k];
        let drift = row[0].mul_add(x[0], row[1].mul_add(x[1], row[2].mul_add(x[2], velocity)));
        p[4 + k] = velocity;
        p[k] = v.dt.mul_add(drift, x[k]);
        square = velocity.mul_add(velocity, square);
    }
    square
}
