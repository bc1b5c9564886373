//! An observed contact has the same bits alone, in lanes, and on every instruction set.

use granum_simd::{Isa, LANES, Row8};

use super::{ALL, Bench, spheres};
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::memory::Memory;
use crate::contact::evaluation::observed::ObservedBatch;

/// A contact: its history, its overlap, m, and whether it touches.
type Observed = (Memory<f64>, f64, bool);

/// A batch of up to eight contacts with the same constants; the other lanes have the history of a pair that never touched.
pub(super) fn observed(constants: &PairConstants<f64>, contacts: &[Observed]) -> ObservedBatch {
    let mut batch = ObservedBatch::new(constants);
    for (l, (memory, overlap, touching)) in contacts.iter().enumerate() {
        let columns = |to: &mut [Row8], from: &[f64]| {
            for (row, value) in to.iter_mut().zip(from) {
                row.0[l] = *value;
            }
        };
        columns(&mut batch.memory.normal, &memory.normal);
        columns(&mut batch.memory.history, &memory.history);
        columns(&mut batch.memory.loading, &memory.loading);
        batch.overlap.0[l] = *overlap;
        batch.touching |= u8::from(*touching) << l;
    }
    batch
}

/// Contacts along a path of loading, slip back and forth, and separation.
fn contacts(bench: &mut Bench) -> Vec<Observed> {
    let contact = |k: usize| {
        let turn = 0.037 * k as f64;
        let overlap = 1.6e-8 * turn.sin() + 9e-9;
        let slip = [4e-10 * (3.1 * turn).cos(), 3e-10 * (1.7 * turn).sin()];
        let touching = bench.step(overlap, slip).touching;
        (bench.memory, overlap, touching)
    };
    (0..40 * LANES).map(contact).collect()
}

/// What the laws give for the contacts of a batch.
fn found(b: &ObservedBatch) -> Vec<u64> {
    let rows = b.contact.iter().chain([&b.normal_energy, &b.tangential_energy]);
    rows.flat_map(|row| row.0).map(f64::to_bits).collect()
}

#[test]
fn an_observed_contact_has_the_same_bits_in_lanes() {
    for interface_energy in [0.6, 0.0] {
        for pair in ALL {
            let mut bench = Bench::new(pair, spheres(interface_energy));
            let all = contacts(&mut bench);
            let batches: Vec<_> = all.chunks(LANES).map(|eight| observed(&bench.constants, eight)).collect();
            let evaluated = |isa: Isa| {
                let mut batches = batches.clone();
                bench.contact.observe(isa, &mut batches);
                batches
            };
            let alone = evaluated(Isa::Portable);
            for isa in [Isa::Neon, Isa::Wasm, Isa::Avx2, Isa::Avx512] {
                for (lanes, alone) in evaluated(isa).iter().zip(&alone) {
                    assert_eq!(found(lanes), found(alone), "{pair:?}, {isa:?}");
                }
            }
            let numbers = |of: fn(&ObservedBatch) -> Row8| -> Vec<f64> {
                alone.iter().flat_map(|batch| of(batch).0).collect()
            };
            let stored = numbers(|batch| batch.normal_energy);
            let tangential = numbers(|batch| batch.tangential_energy);
            let apart = all.iter().zip(&stored).filter(|((.., touching), _)| !touching);
            assert!(apart.clone().count() > 20 && apart.into_iter().all(|(_, stored)| *stored == 0.0));
            let count = |values: &[f64]| values.iter().filter(|x| **x != 0.0 && x.is_finite()).count();
            assert!(count(&stored) > 100 && count(&tangential) > 100, "{pair:?}");
            assert!(alone.iter().flat_map(found).all(|bits| f64::from_bits(bits).is_finite()), "{pair:?}");
        }
    }
}
