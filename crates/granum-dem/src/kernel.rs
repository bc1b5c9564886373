//! The two stages of a step: every contact writes one record, every grain sums its records and moves.
//!
//! Both stages work on fixed chunks, so that their sums do not depend on who computed them. [`Views`] is what all
//! threads see of the state during a stage; its `unsafe` follows the rules of [`crate::team::RawSlice`].

use std::marker::PhantomData;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use granum_simd::{Kernel, LANES, Lanes, Mask, Row4, Row8};

use crate::assembly::Matrix;
use crate::contact::interaction::{Kinematics, Memory, dot, interact};
use crate::contact::{NormalLaw, PairConstants, TangentialLaw};
use crate::pairs::IMAGES;
use crate::team::RawSlice;

/// Batches of contacts in a chunk.
pub(crate) const CONTACT_CHUNK: usize = 32;
/// Grains in a chunk.
pub(crate) const GRAIN_CHUNK: usize = 128;
/// Columns of memory before the tangential law's own: the old normal.
pub(crate) const NORMAL_COLUMNS: usize = 3;

/// Sums over the contacts of a chunk (or of all).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub struct ContactSums {
    /// `- sum of (elastic force on i)_a (branch)_b`, J: the stress times the volume.
    pub virial: [f64; 9],
    /// Work taken up by the elastic tangential forces in this step, J.
    pub tangential_work: f64,
    /// Lost to sliding in this step, J.
    pub friction_loss: f64,
    /// Lost in dashpots in this step, J.
    pub damping_loss: f64,
    /// Lost by breaking in this step, J.
    pub adhesion_loss: f64,
    /// Power that the cell's deformation feeds into the contacts, W.
    pub boundary_power: f64,
    /// `sum of k_n D^2`, J.
    pub stiffness: f64,
    /// Largest `k_t / m` of a contact, with the smaller mass of the two, 1/s2.
    pub fastest: f64,
}

const SUMS: usize = 15;

impl ContactSums {
    /// The sums of chunks, in their order.
    pub(crate) fn total(chunks: &[ContactSums]) -> ContactSums {
        let mut t = ContactSums::default();
        for c in chunks {
            for a in 0..9 {
                t.virial[a] += c.virial[a];
            }
            t.tangential_work += c.tangential_work;
            t.friction_loss += c.friction_loss;
            t.damping_loss += c.damping_loss;
            t.adhesion_loss += c.adhesion_loss;
            t.boundary_power += c.boundary_power;
            t.stiffness += c.stiffness;
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
    pub(crate) first: RawSlice<[u32; LANES]>,
    pub(crate) second: RawSlice<[u32; LANES]>,
    pub(crate) image: RawSlice<[u32; LANES]>,
    pub(crate) memory: RawSlice<Row8>,
    pub(crate) records: RawSlice<Row8>,
    pub(crate) constants: RawSlice<Row8>,
    pub(crate) offsets: RawSlice<u32>,
    pub(crate) incident: RawSlice<u32>,
    pub(crate) contact_sums: RawSlice<ContactSums>,
    pub(crate) fastest_grain: RawSlice<f64>,
    pub(crate) inner_batches: usize,
    pub(crate) alike: PairConstants<f64>,
    pub(crate) images: [Row4; IMAGES],
    pub(crate) gradient: Matrix,
    pub(crate) dt: f64,
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

/// The contact stage for a range of chunks.
pub(crate) struct ContactStage<'a, N, T, C> {
    pub(crate) views: &'a Views,
    pub(crate) chunks: Range<usize>,
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
        for chunk in self.chunks {
            let batches = chunk * CONTACT_CHUNK..((chunk + 1) * CONTACT_CHUNK).min(v.first.len());
            let mut sums = [L::zero(); SUMS];
            let mut fastest = L::zero();
            for b in batches {
                if b < v.inner_batches {
                    contact_batch::<L, N, T, C, false>(v, b, &common, &mut sums, &mut fastest);
                } else {
                    contact_batch::<L, N, T, C, true>(v, b, &common, &mut sums, &mut fastest);
                }
            }
            let mut s = [0.0; SUMS];
            for k in 0..SUMS {
                s[k] = sums[k].reduce_add();
            }
            // SAFETY: this thread alone works on this chunk in this stage.
            let target = unsafe { &mut v.contact_sums.write(chunk..chunk + 1)[0] };
            *target = ContactSums {
                virial: std::array::from_fn(|a| s[a]),
                tangential_work: s[9],
                friction_loss: s[10],
                damping_loss: s[11],
                adhesion_loss: s[12],
                boundary_power: s[13],
                stiffness: s[14],
                fastest: fastest.reduce_max(),
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
) {
    let columns = NORMAL_COLUMNS + T::HISTORY;
    // SAFETY: grains and lists are only read in this stage; memory and records of a batch belong to the thread
    // that works on its chunk.
    let (place, spin, i, j, memory_rows, records) = unsafe {
        (
            &v.place.read()[..v.grains + 2],
            &v.spin.read()[..v.grains + 2],
            &v.first.read()[b],
            &v.second.read()[b],
            v.memory.write(b * columns..(b + 1) * columns),
            v.records.write(b * LANES..(b + 1) * LANES),
        )
    };
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
    let mut memory = Memory::<L>::new();
    for k in 0..3 {
        memory.normal[k] = L::load(&memory_rows[k].0);
    }
    let near = dot(branch, branch).lt(constants.radius_sum * constants.radius_sum);
    let touched = dot(memory.normal, memory.normal).gt(L::splat(0.5));
    if !(near | touched).any() {
        records.fill(Row8::default());
        return;
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
        std::array::from_fn(|k| a[3].mul_add(wa[k], c[3] * wc[k]) / constants.radius_sum)
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
    for k in 0..3 {
        memory.normal[k].store(&mut memory_rows[k].0);
    }
    for k in 0..T::HISTORY {
        memory.history[k].store(&mut memory_rows[NORMAL_COLUMNS + k].0);
    }
    let sliding = L::splat(1.0).keep(out.sliding);
    let columns = [
        out.force[0],
        out.force[1],
        out.force[2],
        sliding,
        out.moment[0],
        out.moment[1],
        out.moment[2],
        out.normal_force,
    ];
    if let Ok(rows) = <&mut [Row8; LANES]>::try_from(records) {
        L::scatter8(columns, rows);
    }
    for r in 0..3 {
        for k in 0..3 {
            sums[3 * r + k] = (-out.elastic[r]).mul_add(branch[k], sums[3 * r + k]);
        }
    }
    sums[9] = sums[9] + out.tangential_work;
    sums[10] = sums[10] + out.friction_loss;
    sums[11] = sums[11] + out.damping_loss;
    sums[12] = sums[12] + out.adhesion_loss;
    sums[13] = sums[13] + dot(out.force, affine);
    let square = constants.radius_sum * constants.radius_sum;
    sums[14] = out.normal_stiffness.mul_add(square, sums[14]);
    let tangential = half * constants.sixteen_shear_moduli * out.radius;
    *fastest = fastest.max(tangential / a[7].min(c[7]));
}

/// The grain stage for a range of chunks: sums the records, kicks, drifts.
pub(crate) struct GrainStage<'a> {
    pub(crate) views: &'a Views,
    pub(crate) chunks: Range<usize>,
}

impl Kernel for GrainStage<'_> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        for chunk in self.chunks {
            let range = chunk * GRAIN_CHUNK..((chunk + 1) * GRAIN_CHUNK).min(v.grains);
            // SAFETY: records and lists are only read in this stage; the grains of a chunk belong to the thread
            // that works on it.
            let (records, offsets, incident, place, spin) = unsafe {
                (
                    v.records.read(),
                    v.offsets.read(),
                    v.incident.read(),
                    v.place.write(range.clone()),
                    v.spin.write(range.clone()),
                )
            };
            let mut fastest = 0.0f64;
            for (n, g) in range.enumerate() {
                let total = resultant::<L>(records, offsets, incident, g);
                let square = advance_grain(v, &total, &mut place[n], &mut spin[n]);
                fastest = larger(fastest, square);
            }
            // SAFETY: this thread alone works on this chunk.
            unsafe { v.fastest_grain.write(chunk..chunk + 1)[0] = fastest };
        }
    }
}

/// The larger of two numbers, or NaN once either is.
#[inline(always)]
pub(crate) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Sum of the records of a grain: force (entries 0..3) and torque over radius (4..7).
#[inline(always)]
pub(crate) fn resultant<L: Lanes>(records: &[Row8], offsets: &[u32], incident: &[u32], g: usize) -> [f64; 8] {
    let (start, middle, end) =
        (offsets[2 * g] as usize, offsets[2 * g + 1] as usize, offsets[2 * g + 2] as usize);
    let mut as_first = L::zero();
    for &slot in &incident[start..middle] {
        as_first = as_first + L::load(&records[slot as usize].0);
    }
    let mut as_second = L::zero();
    for &slot in &incident[middle..end] {
        as_second = as_second + L::load(&records[slot as usize].0);
    }
    // The force on j is the opposite of that on i; the moments are alike.
    let sign = L::load(&[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
    let mut total = [0.0; 8];
    as_second.mul_add(sign, as_first).store(&mut total);
    total
}

/// Kick and drift; returns the square of the fluctuating velocity.
#[inline(always)]
fn advance_grain(v: &Views, total: &[f64; 8], place: &mut Row8, spin: &mut Row4) -> f64 {
    let p = &mut place.0;
    let kick = v.dt / p[7];
    // Torque = R * moment and inertia = 2/5 m R^2.
    let turn = 2.5 * kick / p[3];
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
