//! An observed contact has the same bits alone, in lanes, and on every instruction set.

use granum_simd::{Isa, LANES};

use super::{ALL, Bench, spheres};
use crate::contact::observed::{ObservedBatch, ObservedContact};

/// Contacts along a path of loading, slip back and forth, and separation.
fn contacts(bench: &mut Bench) -> Vec<ObservedBatch> {
    let new = ObservedContact::new(bench.constants);
    let mut all = Vec::new();
    for k in 0..40 * LANES {
        let turn = 0.037 * k as f64;
        let overlap = 1.6e-8 * turn.sin() + 9e-9;
        let slip = [4e-10 * (3.1 * turn).cos(), 3e-10 * (1.7 * turn).sin()];
        let touching = bench.step(overlap, slip).touching;
        all.push(ObservedContact { memory: bench.memory, overlap, touching, ..new });
    }
    all.as_chunks().0.to_vec()
}

/// What the laws give for a contact.
fn found(c: &ObservedContact) -> [u64; 6] {
    let n = &c.contact;
    [n.force, n.radius, n.stiffness, n.friction_load, c.normal_energy, c.tangential_energy].map(f64::to_bits)
}

#[test]
fn an_observed_contact_has_the_same_bits_in_lanes() {
    for interface_energy in [0.6, 0.0] {
        for pair in ALL {
            let mut bench = Bench::new(pair, spheres(interface_energy));
            let mut alone = contacts(&mut bench);
            let mut batches = [Isa::Neon, Isa::Avx2, Isa::Avx512].map(|isa| (isa, alone.clone()));
            bench.contact.observe(Isa::Portable, &mut alone);
            for (isa, batches) in &mut batches {
                bench.contact.observe(*isa, batches);
                for (lanes, alone) in batches.as_flattened().iter().zip(alone.as_flattened()) {
                    assert_eq!(found(lanes), found(alone), "{pair:?}, {isa:?}");
                    assert_eq!(lanes.contact.touching, alone.contact.touching, "{pair:?}, {isa:?}");
                }
            }
            let all = alone.as_flattened();
            let count = |is: fn(&&ObservedContact) -> bool| all.iter().filter(is).count();
            assert!(count(|c| c.normal_energy != 0.0) > 100 && count(|c| !c.touching) > 20, "{pair:?}");
            assert!(count(|c| c.tangential_energy > 0.0) > 100, "{pair:?}");
            assert!(all.iter().all(|c| found(c).map(f64::from_bits).iter().all(|x| x.is_finite())));
        }
    }
}
