//! Contacts as they are observed: their forces and stored energies, from their constants and histories.

use std::marker::PhantomData;

use granum_simd::{Isa, Kernel, LANES, Lanes, Mask, Real, Row8, dispatch_or, fused};

use super::constants::PairConstants;
use super::law::{Normal, NormalLaw, TangentialLaw};
use super::limits::{LAW_CONSTANTS, MAX_HISTORY, MAX_NORMAL_HISTORY};
use super::memory::Memory;
use super::selection::ContactModel;

/// A pair whose grains touch, or on which a law of adhesion acts, with what an observer wants to know about it.
#[derive(Clone, Copy)]
pub struct ObservedContact {
    /// The constants of the pair.
    pub constants: PairConstants<f64>,
    /// The history of the pair.
    pub memory: Memory<f64>,
    /// Overlap, m.
    pub overlap: f64,
    /// True if the pair touches.
    pub touching: bool,
    /// True if a law of adhesion acts on the pair.
    pub attracting: bool,
    /// The normal part of the contact; without force and area where the pair does not touch.
    pub contact: Normal<f64>,
    /// Elastic energy of the overlap, J.
    pub normal_energy: f64,
    /// Elastic energy of the tangential displacement, J.
    pub tangential_energy: f64,
    /// Elastic energy of rolling and twisting, J.
    pub rolling_energy: f64,
    /// Attractive force of a law of adhesion, N.
    pub attraction: f64,
    /// Energy of this attraction, J.
    pub attraction_energy: f64,
}

/// Contacts that a law evaluates side by side.
pub type ObservedBatch = [ObservedContact; LANES];

impl ObservedContact {
    /// A pair with these constants that has not been evaluated.
    pub(crate) fn new(constants: PairConstants<f64>) -> ObservedContact {
        ObservedContact {
            constants,
            memory: Memory::new(),
            overlap: 0.0,
            touching: false,
            attracting: false,
            contact: Normal::none(),
            normal_energy: 0.0,
            tangential_energy: 0.0,
            rolling_energy: 0.0,
            attraction: 0.0,
            attraction_energy: 0.0,
        }
    }

    /// The overlap with which the normal law is evaluated, m: that of grains far apart where the pair does not touch, since only
    /// the law of adhesion acts there.
    #[inline(always)]
    fn overlap_of_contact(&self) -> f64 {
        if self.touching { self.overlap } else { -self.constants.radius_sum }
    }
}

impl ContactModel {
    /// Evaluates the laws of the set for these pairs.
    pub(crate) fn observe(&self, isa: Isa, contacts: &mut [ObservedBatch]) {
        self.normal.law().observe(isa, contacts);
        self.tangential.law().observe(isa, contacts);
        let (rolling, adhesion) = (self.rolling.law(), self.adhesion.law());
        if rolling.acts() {
            for c in contacts.as_flattened_mut() {
                c.rolling_energy = rolling.energy(&c.constants.rolling, &c.memory.moments);
            }
        }
        if adhesion.acts() {
            for c in contacts.as_flattened_mut() {
                (c.attraction, c.attraction_energy) = (0.0, 0.0);
                if c.attracting {
                    let (constants, history) = (&c.constants.adhesion, &c.memory.adhesion);
                    c.attraction = adhesion.force(constants, c.overlap, c.touching, history);
                    c.attraction_energy = adhesion.energy(constants, c.overlap, history);
                }
            }
        }
    }
}

/// Evaluates a normal law for batches of contacts.
pub(super) fn normal<N: NormalLaw>(isa: Isa, contacts: &mut [ObservedBatch]) {
    let kernel = NormalPart::<N>(contacts, PhantomData);
    dispatch_or(isa, kernel, |NormalPart(contacts, _)| {
        fused(
            #[inline(always)]
            || {
                for c in contacts.as_flattened_mut() {
                    let (constants, overlap) = (&c.constants.normal, c.overlap_of_contact());
                    c.contact = N::update(constants, overlap, true, &mut { c.memory.loading }).0;
                    c.normal_energy = N::stored(constants, overlap, &c.memory.loading).keep(c.touching);
                }
            },
        );
    });
}

/// Evaluates the energy of a tangential law for batches of contacts whose normal part is known.
pub(super) fn tangential<T: TangentialLaw>(isa: Isa, contacts: &mut [ObservedBatch]) {
    let kernel = TangentialPart::<T>(contacts, PhantomData);
    dispatch_or(isa, kernel, |TangentialPart(contacts, _)| {
        fused(
            #[inline(always)]
            || {
                for c in contacts.as_flattened_mut() {
                    let constants = &c.constants.tangential;
                    let stiffness = T::stiffness(constants, &c.contact);
                    c.tangential_energy = T::energy(constants, stiffness, &c.memory.history);
                }
            },
        );
    });
}

struct NormalPart<'a, N>(&'a mut [ObservedBatch], PhantomData<N>);

impl<N: NormalLaw> Kernel for NormalPart<'_, N> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for batch in self.0 {
            let constants = columns::<L, LAW_CONSTANTS>(
                batch,
                LAW_CONSTANTS,
                #[inline(always)]
                |c| &c.constants.normal,
            );
            let history = columns::<L, MAX_NORMAL_HISTORY>(
                batch,
                N::HISTORY,
                #[inline(always)]
                |c| &c.memory.loading,
            );
            let mut overlaps = [0.0; LANES];
            for (overlap, c) in overlaps.iter_mut().zip(batch.iter()) {
                *overlap = c.overlap_of_contact();
            }
            let overlap = L::load(&overlaps);
            let (n, _) = N::update(&constants, overlap, L::Mask::splat(true), &mut { history });
            let stored = N::stored(&constants, overlap, &history);
            let touching = n.touching.bits();
            let columns = [
                n.force,
                n.radius,
                n.stiffness,
                n.root_stiffness,
                n.tangential_measure,
                n.root_tangential_measure,
                n.friction_load,
                stored,
            ];
            let mut rows = [Row8::default(); LANES];
            L::scatter8(columns, &mut rows);
            for l in 0..LANES {
                let [
                    force,
                    radius,
                    stiffness,
                    root_stiffness,
                    tangential_measure,
                    root_tangential_measure,
                    friction_load,
                    stored,
                ] = rows[l].0;
                batch[l].contact = Normal {
                    force,
                    radius,
                    stiffness,
                    root_stiffness,
                    tangential_measure,
                    root_tangential_measure,
                    friction_load,
                    touching: touching >> l & 1 != 0,
                };
                batch[l].normal_energy = stored.keep(batch[l].touching);
            }
        }
    }
}

struct TangentialPart<'a, T>(&'a mut [ObservedBatch], PhantomData<T>);

impl<T: TangentialLaw> Kernel for TangentialPart<'_, T> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        for batch in self.0 {
            let constants = columns::<L, LAW_CONSTANTS>(
                batch,
                LAW_CONSTANTS,
                #[inline(always)]
                |c| &c.constants.tangential,
            );
            let history = columns::<L, MAX_HISTORY>(
                batch,
                T::HISTORY,
                #[inline(always)]
                |c| &c.memory.history,
            );
            let mut rows = [L::zero(); LANES];
            for (row, c) in rows.iter_mut().zip(batch.iter()) {
                let n = &c.contact;
                *row = L::load(&[
                    n.force,
                    n.radius,
                    n.stiffness,
                    n.root_stiffness,
                    n.tangential_measure,
                    n.root_tangential_measure,
                    n.friction_load,
                    f64::from(u8::from(n.touching)),
                ]);
            }
            let [
                force,
                radius,
                stiffness,
                root_stiffness,
                tangential_measure,
                root_tangential_measure,
                friction_load,
                touching,
            ] = L::transpose(rows);
            let contact = Normal {
                force,
                radius,
                stiffness,
                root_stiffness,
                tangential_measure,
                root_tangential_measure,
                friction_load,
                touching: touching.gt(L::zero()),
            };
            let stiffness = T::stiffness(&constants, &contact);
            let mut energies = [0.0; LANES];
            T::energy(&constants, stiffness, &history).store(&mut energies);
            for (c, energy) in batch.iter_mut().zip(energies) {
                c.tangential_energy = energy;
            }
        }
    }
}

/// The first columns of a table of which every contact holds a row, side by side; the others are zero.
#[inline(always)]
fn columns<L: Lanes, const N: usize>(
    batch: &ObservedBatch,
    used: usize,
    row: impl Fn(&ObservedContact) -> &[f64; N],
) -> [L; N] {
    let mut all = [L::zero(); N];
    for (block, to) in all.chunks_mut(LANES).enumerate().take(used.div_ceil(LANES)) {
        let from = block * LANES;
        let mut rows = [L::zero(); LANES];
        for l in 0..LANES {
            let mut values = [0.0; LANES];
            values[..to.len()].copy_from_slice(&row(&batch[l])[from..from + to.len()]);
            rows[l] = L::load(&values);
        }
        to.copy_from_slice(&L::transpose(rows)[..to.len()]);
    }
    all
}
