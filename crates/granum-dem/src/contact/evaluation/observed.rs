//! Contacts as they are observed: their forces and stored energies, from their constants and histories.

use std::marker::PhantomData;

use granum_simd::{Isa, Kernel, LANES, Lanes, Real, Row8, ScalarKernel, dispatch_or, fused};

use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::memory::Memory;
use crate::contact::law::constants::LawConstants;
use crate::contact::law::limits::LAW_CHANNELS;
use crate::contact::law::{Normal, NormalLaw, TangentialLaw};

/// Eight pairs side by side, with what an observer wants to know about those that touch or on which a law of adhesion acts.
///
/// Every number has a row of eight, as in the list of pairs: rows are copied from it as they are, and a law evaluates the pairs in
/// lanes.
#[derive(Clone, Copy)]
pub struct ObservedBatch {
    /// The constants of the pairs.
    pub constants: PairConstants<Row8>,
    /// Their histories.
    pub memory: Memory<Row8>,
    /// Overlap, m.
    pub overlap: Row8,
    /// The pairs that touch, one bit for each.
    pub touching: u8,
    /// The pairs on which a law of adhesion acts, one bit for each.
    pub attracting: u8,
    /// The normal part of a contact, without force and area where the pair does not touch: the numbers of [`Normal`] in their order,
    /// `touching` as one or zero.
    pub contact: [Row8; 8],
    /// Elastic energy of the overlap, J.
    pub normal_energy: Row8,
    /// Elastic energy of the tangential displacement, J.
    pub tangential_energy: Row8,
    /// Elastic energy of rolling and twisting, J.
    pub rolling_energy: Row8,
    /// Attractive force of a law of adhesion, N.
    pub attraction: Row8,
    /// Energy of this attraction, J.
    pub attraction_energy: Row8,
}

impl ObservedBatch {
    /// Pairs with the same constants that have not been evaluated.
    pub(crate) fn new(constants: &PairConstants<f64>) -> ObservedBatch {
        let zero = Row8::default();
        let all = constants.to_array();
        ObservedBatch {
            constants: PairConstants::from_columns(PairConstants::COUNT, |c| Row8([all[c]; LANES])),
            memory: Memory {
                normal: [zero; 3],
                history: Default::default(),
                moments: Default::default(),
                adhesion: Default::default(),
                loading: Default::default(),
            },
            overlap: zero,
            touching: 0,
            attracting: 0,
            contact: [zero; 8],
            normal_energy: zero,
            tangential_energy: zero,
            rolling_energy: zero,
            attraction: zero,
            attraction_energy: zero,
        }
    }

    /// The overlap with which the normal law is evaluated, m: that of grains far apart where the pair does not touch, since only
    /// the law of adhesion acts there.
    #[inline(always)]
    fn overlap_of_contact(&self) -> Row8 {
        let mut overlap = self.overlap;
        for l in 0..LANES {
            if self.touching >> l & 1 == 0 {
                overlap.0[l] = -self.constants.radius_sum.0[l];
            }
        }
        overlap
    }
}

/// A part of the laws that is evaluated for a batch.
trait Evaluate {
    /// Evaluates numbers that `load` takes from a row, and that `store` writes to it: all eight of the row, or one of them.
    fn evaluate<R: Real>(
        batch: &mut ObservedBatch,
        load: impl Fn(&Row8) -> R + Copy,
        store: impl Fn(R, &mut Row8) + Copy,
    );
}

/// Evaluates batches in lanes, or on a processor without vector instructions pair by pair, which gives the same bits.
fn evaluate<E: Evaluate>(isa: Isa, batches: &mut [ObservedBatch]) {
    let each = |InLanes(batches, _): InLanes<'_, E>| fused(PairByPair::<E>(batches, PhantomData));
    dispatch_or(isa, InLanes::<E>(batches, PhantomData), each);
}

struct PairByPair<'a, E>(&'a mut [ObservedBatch], PhantomData<E>);

impl<E: Evaluate> ScalarKernel for PairByPair<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        for batch in self.0 {
            for l in 0..LANES {
                E::evaluate(
                    batch,
                    #[inline(always)]
                    |row| R::splat(row.0[l]),
                    #[inline(always)]
                    |value: R, row| row.0[l] = value.reduce_add(),
                );
            }
        }
    }
}

struct InLanes<'a, E>(&'a mut [ObservedBatch], PhantomData<E>);

impl<E: Evaluate> Kernel for InLanes<'_, E> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for batch in self.0 {
            E::evaluate(
                batch,
                #[inline(always)]
                |row| L::load(&row.0),
                #[inline(always)]
                |value: L, row| value.store(&mut row.0),
            );
        }
    }
}

/// Evaluates a normal law.
pub(in crate::contact) fn normal<N: NormalLaw>(isa: Isa, batches: &mut [ObservedBatch]) {
    evaluate::<NormalPart<N>>(isa, batches);
}

/// Evaluates the energy of a tangential law, for batches whose normal part is known.
pub(in crate::contact) fn tangential<T: TangentialLaw>(isa: Isa, batches: &mut [ObservedBatch]) {
    evaluate::<TangentialPart<T>>(isa, batches);
}

/// The numbers that `load` takes from the first rows; zero for the others.
#[inline(always)]
fn numbers<R: Real, const N: usize>(rows: &[Row8; N], used: usize, load: impl Fn(&Row8) -> R) -> [R; N] {
    let mut all = [R::zero(); N];
    for (to, row) in all.iter_mut().zip(rows).take(used) {
        *to = load(row);
    }
    all
}

struct NormalPart<N>(PhantomData<N>);

impl<N: NormalLaw> Evaluate for NormalPart<N> {
    #[inline(always)]
    fn evaluate<R: Real>(
        batch: &mut ObservedBatch,
        load: impl Fn(&Row8) -> R + Copy,
        store: impl Fn(R, &mut Row8) + Copy,
    ) {
        let rows = &batch.constants.normal;
        let constants = N::Constants::<R>::take(
            0,
            #[inline(always)]
            |c| load(&rows[c]),
        );
        let history = numbers(&batch.memory.loading, N::HISTORY, load);
        let overlap = load(&batch.overlap_of_contact());
        let everywhere = granum_simd::Mask::splat(true);
        let energies = &mut [R::zero(); LAW_CHANNELS];
        let n = N::update(&constants, overlap, everywhere, &mut { history }, energies);
        let mut touching = [0.0; LANES];
        for (l, one) in touching.iter_mut().enumerate() {
            *one = f64::from(batch.touching >> l & 1);
        }
        let touching = load(&Row8(touching)).gt(R::zero());
        store(N::stored(&constants, overlap, &history).keep(touching), &mut batch.normal_energy);
        let [rows @ .., touching] = &mut batch.contact;
        for (value, row) in n.numbers().into_iter().zip(rows) {
            store(value, row);
        }
        store(R::splat(1.0).keep(n.touching), touching);
    }
}

struct TangentialPart<T>(PhantomData<T>);

impl<T: TangentialLaw> Evaluate for TangentialPart<T> {
    #[inline(always)]
    fn evaluate<R: Real>(
        batch: &mut ObservedBatch,
        load: impl Fn(&Row8) -> R + Copy,
        store: impl Fn(R, &mut Row8) + Copy,
    ) {
        let rows = &batch.constants.tangential;
        let constants = T::Constants::<R>::take(
            0,
            #[inline(always)]
            |c| load(&rows[c]),
        );
        let history = numbers(&batch.memory.history, T::HISTORY, load);
        let [rows @ .., touching] = &batch.contact;
        let numbers = numbers(rows, usize::MAX, load);
        let contact = Normal::from_numbers(numbers, load(touching).gt(R::zero()));
        let stiffness = T::stiffness(&constants, &contact);
        store(T::energy(&constants, stiffness, &history), &mut batch.tangential_energy);
    }
}
