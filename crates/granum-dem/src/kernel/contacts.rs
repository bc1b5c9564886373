//! The contact stage: batches of eight pairs are evaluated and added to the force rows of their grains.
//!
//! The arithmetic of one contact is a long chain in which every operation waits for the one before. Two batches are
//! therefore evaluated side by side where the processor has enough registers.

use std::marker::PhantomData;
use std::ops::Range;

use granum_simd::{Kernel, LANES, Lanes, Mask, Real, Row8, Twice};

use super::fetch::{ROWS_AHEAD, coming_rows};
use super::laws::{BatchData, Couples, StageLaws};
use super::near::{Common, PairBatch, columns_of, constants_of, near_batch, touching_pair};
use super::order::Order;
use super::part::{First, Part, Second, Whole};
use super::push::Push;
use super::source::ConstantSource;
use super::sums::{self as sum, SUMS};
use super::views::Views;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::interaction::{Interaction, PairMotion};
use crate::contact::evaluation::memory::Memory;
use crate::contact::law::energy_channel::{LAWS, SetEnergies};
use crate::contact::law::limits::{LAW_CHANNELS, MAX_HISTORY};
use crate::discarded::Discarded;
use crate::pairs::{Marks, NORMAL_COLUMNS};
use granum_simd::vectors::dot;

const SUMS_OF_EIGHT: usize = SUMS.next_multiple_of(LANES);

/// The contact stage for a range of blocks.
pub(crate) struct ContactStage<'a, S, C> {
    pub(crate) views: &'a Views,
    pub(crate) blocks: Range<usize>,
    pub(crate) laws: PhantomData<(S, C)>,
}

impl<S: StageLaws, C: ConstantSource> Kernel for ContactStage<'_, S, C> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let v = self.views;
        let laws = S::from_views(v);
        let common = Common::<L> {
            gradient: v.gradient.map(|row| row.map(L::splat)),
            dt: L::splat(v.dt),
            alike: v.alike.splat(),
        };
        // SAFETY: grains are only read in this stage.
        let mass = unsafe { v.particles.read()[0].0[7] };
        let mut discarded = Discarded::new();
        let mut pair_batches = [PairBatch::<L>::none(); 2];
        let mut twos = [[PairBatch::<L>::none(); 2]; 2];
        let mut pushes = [Push::<L, S::Couples<L>>::none(); 2];
        for k in self.blocks {
            // SAFETY: blocks are only read; their rows of forces belong to the thread that works on the block.
            let block = unsafe { &v.blocks.read()[k] };
            for [from, to] in [block.grains, block.outer] {
                unsafe { v.forces.write(from as usize..to as usize) }.fill(Row8::default());
            }
            let order = Order::new(block);
            let mut totals = Totals {
                sums: [L::zero(); SUMS],
                channels: [[L::zero(); LAW_CHANNELS]; LAWS],
                fastest: L::zero(),
                discarded: L::zero(),
            };
            let sampled = laws.discards() && v.sampling_weight != 0.0;
            let mut waiting = 0;
            let mut coming = coming_rows(v, k);
            let pairs = if paired::<L, S>() { order.touching / 2 } else { 0 };
            if pairs > 0 {
                touching_pair::<L, S, C>(v, &laws, &order, 0, &common, &mut twos[0]);
            }
            for p in 0..pairs {
                for row in coming.by_ref().take(2 * ROWS_AHEAD) {
                    v.forces.prefetch(row as usize);
                }
                // The grains of the next two batches are loaded while the laws of these two are evaluated.
                if p + 1 < pairs {
                    touching_pair::<L, S, C>(v, &laws, &order, 2 * p + 2, &common, &mut twos[(p + 1) % 2]);
                }
                // The forces of the previous two batches are added only now: no later operation depends on them, and
                // at once they would have to wait for the end of the evaluation of their laws.
                if p > 0 {
                    pushes[0].add(v);
                    pushes[1].add(v);
                }
                let put = sampled.then_some(&mut discarded);
                pushes = pair::<L, S, C>(v, &laws, &twos[p % 2], &common, &mut totals, put);
                while sampled && discarded.is_full() {
                    totals.discarded = totals.discarded + discarded.take::<L, S>(&laws);
                }
            }
            if pairs > 0 {
                pushes[0].add(v);
                pushes[1].add(v);
            }
            for turn in 2 * pairs..=order.count {
                let last = turn == order.count;
                for row in coming.by_ref().take(ROWS_AHEAD) {
                    v.forces.prefetch(row as usize);
                }
                if !last {
                    let slot = &mut pair_batches[waiting];
                    let close = if turn < order.within {
                        near_batch::<L, S, C, false, true>(v, &laws, &order, turn, &common, slot)
                    } else {
                        near_batch::<L, S, C, true, true>(v, &laws, &order, turn, &common, slot)
                    };
                    waiting += usize::from(close);
                }
                let put = sampled.then_some(&mut discarded);
                if paired::<L, S>() && waiting == 2 {
                    for push in pair::<L, S, C>(v, &laws, &pair_batches, &common, &mut totals, put) {
                        push.add(v);
                    }
                    waiting = 0;
                } else if waiting == 1 && (last || !paired::<L, S>()) {
                    alone::<L, S, C>(v, &laws, &pair_batches[0], &common, &mut totals, put).add(v);
                    waiting = 0;
                }
                while sampled && discarded.is_full() {
                    totals.discarded = totals.discarded + discarded.take::<L, S>(&laws);
                }
            }
            if sampled {
                totals.discarded = totals.discarded + discarded.take::<L, S>(&laws);
            }
            let Totals { sums: mut totals, channels, fastest, discarded: lost } = totals;
            totals[sum::MICRO_SLIP] = lost.mul_add(L::splat(v.sampling_weight), totals[sum::MICRO_SLIP]);
            let s = reduced(&totals);
            // SAFETY: only this thread works on this block in this stage.
            let target = unsafe { &mut v.contact_sums.write(k..k + 1)[0] };
            // For equal grains the single mass is divided by here.
            let fastest = fastest.reduce_max() / if C::by_batch(v) { 1.0 } else { mass };
            *target = sum::contact_sums(&s, reduced_channels(&laws, &channels), fastest);
        }
    }
}

/// The sum of each over its lanes, in the order of [`Real::reduce_add`].
#[inline(always)]
fn reduced<L: Lanes>(sums: &[L; SUMS]) -> [f64; SUMS_OF_EIGHT] {
    let mut reduced = [0.0; SUMS_OF_EIGHT];
    for (to, from) in reduced.as_chunks_mut().0.iter_mut().zip(sums.chunks(LANES)) {
        let mut columns = [L::zero(); LANES];
        columns[..from.len()].copy_from_slice(from);
        L::reduce_add8(columns).store(to);
    }
    reduced
}

/// The same for the energies in the channels of the laws.
#[inline(always)]
fn reduced_channels<L: Lanes, S: StageLaws>(laws: &S, channels: &SetEnergies<L>) -> SetEnergies<f64> {
    let mut reduced = [[0.0; LAW_CHANNELS]; LAWS];
    if S::MAY_HAVE_CHANNELS && laws.has_channels() {
        for (to, from) in reduced.iter_mut().zip(channels) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = from.reduce_add();
            }
        }
    }
    reduced
}

/// True if two batches are evaluated side by side.
const fn paired<L: Lanes, S: StageLaws>() -> bool {
    L::PAIRED && !S::IN_PLACE
}

/// Sums over a block while it is being evaluated.
struct Totals<L> {
    sums: [L; SUMS],
    channels: SetEnergies<L>,
    fastest: L,
    /// Energy of discarded histories, J. It has a sum of its own, because the number of batches that are collected before
    /// it is evaluated varies.
    discarded: L,
}

/// The rows that hold the contact history of a batch.
#[inline(always)]
fn rows_of<S: StageLaws>(laws: &S, b: usize) -> Range<usize> {
    let columns = columns_of(laws);
    b * columns..(b + 1) * columns
}

/// The old normal, and the histories of the tangential law and the moment law if the laws are compiled into the loop. Other
/// histories are advanced in place.
#[inline(always)]
fn load_memory<R: Real, S: StageLaws>(laws: &S, load: impl Fn(usize) -> R) -> Memory<R> {
    let mut memory = Memory::<R>::new();
    for k in 0..NORMAL_COLUMNS {
        memory.normal[k] = load(k);
    }
    if !S::IN_PLACE {
        let [tangential, moments, ..] = laws.history();
        for k in 0..tangential {
            memory.history[k] = load(NORMAL_COLUMNS + k);
        }
        for k in 0..moments {
            memory.moments[k] = load(NORMAL_COLUMNS + tangential + k);
        }
    }
    memory
}

/// Evaluates one batch.
#[inline(always)]
fn alone<L: Lanes, S: StageLaws, C: ConstantSource>(
    v: &Views,
    laws: &S,
    pair_batch: &PairBatch<L>,
    common: &Common<L>,
    totals: &mut Totals<L>,
    discarded: Option<&mut Discarded>,
) -> Push<L, S::Couples<L>> {
    let b = pair_batch.batch;
    let constants = constants_of::<L, S, C>(v, laws, b, common);
    // SAFETY: this thread works on the batch's block.
    let rows = unsafe { v.memory.write(rows_of(laws, b)) };
    let mut memory = load_memory::<L, S>(
        laws,
        #[inline(always)]
        |c| L::load(&rows[c].0),
    );
    // Before the new history overwrites the old one.
    let past = discarded.as_ref().filter(|_| S::IN_PLACE).map(|_| past_of(laws, rows));
    let place = BatchData { views: v, batch: b, history: &mut *rows };
    let out = laws.interact(&constants, &pair_batch.kinematics, common.dt, &mut memory, place);
    if let Some(discarded) = discarded {
        let history = past.as_ref().map_or(&rows[NORMAL_COLUMNS..], |past| &past[..]);
        discarded.put(out.discards.bits(), &constants.tangential, out.tangential_stiffness, history);
    }
    finish_batch::<L, L, S, C, Whole>(v, laws, pair_batch, common, &constants, &memory, &out, totals)
}

/// A copy of the history of the tangential law.
#[inline(always)]
fn past_of<S: StageLaws>(laws: &S, rows: &[Row8]) -> [Row8; MAX_HISTORY] {
    let mut past = [Row8::default(); MAX_HISTORY];
    let used = laws.history()[0];
    past[..used].copy_from_slice(&rows[NORMAL_COLUMNS..NORMAL_COLUMNS + used]);
    past
}

#[inline(always)]
fn beside<L: Lanes>(a: [L; 3], b: [L; 3]) -> [Twice<L>; 3] {
    [Twice(a[0], b[0]), Twice(a[1], b[1]), Twice(a[2], b[2])]
}

/// Evaluates two batches side by side.
#[inline(always)]
fn pair<L: Lanes, S: StageLaws, C: ConstantSource>(
    v: &Views,
    laws: &S,
    pair_batches: &[PairBatch<L>; 2],
    common: &Common<L>,
    totals: &mut Totals<L>,
    discarded: Option<&mut Discarded>,
) -> [Push<L, S::Couples<L>>; 2] {
    let [x, y] = pair_batches;
    let own = [
        constants_of::<L, S, C>(v, laws, x.batch, common),
        constants_of::<L, S, C>(v, laws, y.batch, common),
    ];
    let constants = own[0].beside(&own[1]);
    let (p, q) = (&x.kinematics, &y.kinematics);
    let kinematics = PairMotion {
        branch: beside(p.branch, q.branch),
        velocity: beside(p.velocity, q.velocity),
        rolling: beside(p.rolling, q.rolling),
        mean_spin: beside(p.mean_spin, q.mean_spin),
        relative_spin: beside(p.relative_spin, q.relative_spin),
    };
    // SAFETY: this thread works on the block of the batches, and the two batches differ.
    let (p, q) = unsafe { (v.memory.write(rows_of(laws, x.batch)), v.memory.write(rows_of(laws, y.batch))) };
    let mut memory = load_memory::<Twice<L>, S>(
        laws,
        #[inline(always)]
        |c| Twice(L::load(&p[c].0), L::load(&q[c].0)),
    );
    let dt = Twice(common.dt, common.dt);
    let out = laws.interact_two(&constants, &kinematics, dt, &mut memory);
    if let Some(discarded) = discarded {
        let [a, b] = [&p[NORMAL_COLUMNS..], &q[NORMAL_COLUMNS..]];
        let stiffness = out.tangential_stiffness;
        discarded.put(out.discards.0.bits(), &own[0].tangential, stiffness.0, a);
        discarded.put(out.discards.1.bits(), &own[1].tangential, stiffness.1, b);
    }
    [
        finish_batch::<L, Twice<L>, S, C, First>(v, laws, x, common, &own[0], &memory, &out, totals),
        finish_batch::<L, Twice<L>, S, C, Second>(v, laws, y, common, &own[1], &memory, &out, totals),
    ]
}

/// Stores the history of a batch and adds its contributions to the sums; returns the forces to be added to its grains.
#[inline(always)]
fn finish_batch<L: Lanes, R: Real, S: StageLaws, C: ConstantSource, P: Part<L, R>>(
    v: &Views,
    laws: &S,
    pair_batch: &PairBatch<L>,
    common: &Common<L>,
    constants: &PairConstants<L>,
    memory: &Memory<R>,
    out: &Interaction<R>,
    totals: &mut Totals<L>,
) -> Push<L, S::Couples<L>> {
    let b = pair_batch.batch;
    // SAFETY: histories and marks of a batch belong to the thread that works on its block.
    let (rows, marks) = unsafe { (v.memory.write(rows_of(laws, b)), &mut v.marks.write(b..b + 1)[0]) };
    for k in 0..NORMAL_COLUMNS {
        P::part(memory.normal[k]).store(&mut rows[k].0);
    }
    if !S::IN_PLACE {
        let [tangential, moments, ..] = laws.history();
        for k in 0..tangential {
            P::part(memory.history[k]).store(&mut rows[NORMAL_COLUMNS + k].0);
        }
        for k in 0..moments {
            P::part(memory.moments[k]).store(&mut rows[NORMAL_COLUMNS + tangential + k].0);
        }
    }
    let sums = &mut totals.sums;
    let touching = P::mask(out.touching).bits() as u8;
    if touching != marks.touched {
        sums[sum::ADHESION_MADE] = sums[sum::ADHESION_MADE] + P::part(out.adhesion_made);
        sums[sum::ADHESION_BROKEN] = sums[sum::ADHESION_BROKEN] + P::part(out.adhesion_broken);
    }
    let (mut attracting, mut changed) = (0, 0);
    if S::MAY_HAVE_ADHESION && laws.has_adhesion() {
        attracting = P::mask(out.attracting).bits() as u8;
        sums[sum::ATTRACTION_LOSS] = sums[sum::ATTRACTION_LOSS] + P::part(out.attraction_loss);
        if laws.shares_liquid() {
            changed = (marks.attracting | touching & !marks.touched) & !attracting;
        }
    }
    if S::MAY_HAVE_CHANNELS && laws.has_channels() {
        for (law, count) in laws.channels().into_iter().enumerate() {
            for k in 0..LAW_CHANNELS {
                if k < count {
                    totals.channels[law][k] = totals.channels[law][k] + P::part(out.channels[law][k]);
                }
            }
        }
    }
    *marks = Marks { touched: touching, sliding: P::mask(out.sliding).bits() as u8, attracting, changed };
    let force = [P::part(out.force[0]), P::part(out.force[1]), P::part(out.force[2])];
    let moment = [P::part(out.moment[0]), P::part(out.moment[1]), P::part(out.moment[2])];
    let mut branch = pair_batch.kinematics.branch;
    if C::MAY_HAVE_CLUMPS && v.arms.len() > 0 {
        branch = branch_of_bodies::<L>(v, b, branch);
    }
    for r in 0..3 {
        let pull = -P::part(out.elastic[r]);
        for k in 0..3 {
            let place = sum::virial(r, k);
            sums[place] = pull.mul_add(branch[k], sums[place]);
        }
    }
    let affine = common.affine(branch);
    sums[sum::TANGENTIAL_WORK] = sums[sum::TANGENTIAL_WORK] + P::part(out.tangential_work);
    sums[sum::FRICTION] = sums[sum::FRICTION] + P::part(out.friction_loss);
    sums[sum::DAMPING] = sums[sum::DAMPING] + P::part(out.damping_loss);
    sums[sum::BOUNDARY_POWER] = sums[sum::BOUNDARY_POWER] + dot(force, affine);
    let square = constants.radius_sum * constants.radius_sum;
    sums[sum::STIFFNESS] = P::part(out.normal_stiffness).mul_add(square, sums[sum::STIFFNESS]);
    sums[sum::NORMAL_FORCE] = sums[sum::NORMAL_FORCE] + P::part(out.normal_force).abs();
    sums[sum::MICRO_SLIP] = sums[sum::MICRO_SLIP] + P::part(out.micro_slip_loss);
    let stiffness = P::part(out.step_stiffness);
    totals.fastest = totals.fastest.max(if C::by_batch(v) { stiffness / pair_batch.mass } else { stiffness });
    let mut couples = S::Couples::<L>::none();
    if S::MAY_HAVE_MOMENTS && laws.has_moments() {
        sums[sum::ROLLING_WORK] = sums[sum::ROLLING_WORK] + P::part(out.moment_work);
        sums[sum::ROLLING] = sums[sum::ROLLING] + P::part(out.moment_loss);
        let couple = [P::part(out.couple[0]), P::part(out.couple[1]), P::part(out.couple[2])];
        couples = S::Couples::from_couple(
            couple,
            #[inline(always)]
            || inverse_radii::<L, C>(v, b, constants),
        );
    }
    Push { batch: b, force, moment, couples }
}

/// The branch vectors between the centres of the bodies of a batch: those of its pieces, with the arms of pieces of clumps.
#[inline(always)]
fn branch_of_bodies<L: Lanes>(v: &Views, b: usize, branch: [L; 3]) -> [L; 3] {
    // SAFETY: arms and lists are only read in this stage.
    let arms = unsafe { v.arms.read() };
    let (one, two) = unsafe { (L::gather4(arms, &v.first.read()[b]), L::gather4(arms, &v.second.read()[b])) };
    [branch[0] + (one[0] - two[0]), branch[1] + (one[1] - two[1]), branch[2] + (one[2] - two[2])]
}

/// Reciprocals of the radii of the grains i and j of a batch, 1/m.
#[inline(always)]
fn inverse_radii<L: Lanes, C: ConstantSource>(v: &Views, b: usize, constants: &PairConstants<L>) -> [L; 2] {
    if !C::by_batch(v) {
        // The same bits: twice 1/2R is 1/R, exactly.
        return [constants.inverse_radius_sum + constants.inverse_radius_sum; 2];
    }
    // SAFETY: grains and lists are only read in this stage.
    let (particles, i, j) =
        unsafe { (&v.particles.read()[..v.grains + 2], &v.first.read()[b], &v.second.read()[b]) };
    let (mut a, mut c) = ([0.0; LANES], [0.0; LANES]);
    for l in 0..LANES {
        a[l] = particles[i[l] as usize].0[3];
        c[l] = particles[j[l] as usize].0[3];
    }
    // No `map`: a closure that is not inlined is compiled without vector instructions.
    let one = L::splat(1.0);
    [one / L::load(&a), one / L::load(&c)]
}
