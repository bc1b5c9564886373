//! Steps of the size of rounding: they decide neither a force nor the branch of a law with memory that the next steps follow.

use proptest::prelude::*;

use super::*;
use crate::contact::choice::kind::{AdhesionKind, RollingKind};

/// Approach about which the overlaps of the paths lie, m.
const APPROACH: f64 = 2e-8;
/// A slip at which contacts of this approach slide, m.
const SLIDING: f64 = 4e-9;
/// An angle at which they roll at their limit, rad.
const ROLLING: f64 = 1e-4;

/// Part of the force by which rounding may change one. The share theta of the contact that sticks is a cubic root of a difference of forces,
/// so that at the limit of friction 1e-12 of the load is 1e-4 of theta.
const TOLERANCE: f64 = 1e-4;

/// The overlap at the end of a step, its slip in two directions, and its rolling about two axes.
type Step = (f64, [f64; 2], [f64; 2]);

/// The forces and couples after each of the last steps of a path, in which every number is changed by a fraction of its size.
fn ends(contact: &ContactModel, path: &[Step], held: &[f64], hair: f64) -> Vec<[f64; 7]> {
    let energy = if contact.normal.law().traits().adhesive { 0.05 } else { 0.0 };
    let mut bench = Bench::new((contact.normal, contact.tangential), spheres(energy));
    bench.slots = Slots::new(contact, Isa::Portable);
    bench.constants = contact.constants(&bench.pair);
    bench.contact = *contact;
    let mut go = |overlap: f64, slip: [f64; 2], turn: [f64; 2]| {
        let spin = std::array::from_fn(|a| turn[0] * FIRST[a] + turn[1] * SECOND[a]);
        let out = bench.interact(
            &PairMotion {
                branch: NORMAL.map(|n| n * (bench.pair.radius_sum - overlap)),
                velocity: std::array::from_fn(|a| slip[0] * FIRST[a] + slip[1] * SECOND[a]),
                rolling: [0.0; 3],
                mean_spin: [0.0; 3],
                relative_spin: spin,
            },
            1.0,
        );
        let mut all = [0.0; 7];
        all[..3].copy_from_slice(&out.elastic);
        all[3..6].copy_from_slice(&out.couple);
        all[6] = out.normal_force;
        all
    };
    for &(overlap, slip, turn) in path {
        go(overlap, slip, turn);
    }
    // The load changes, or not, while nothing but rounding moves the surfaces along each other; then both move on.
    let small = [hair * SLIDING, -0.7 * hair * SLIDING];
    let mut rows: Vec<[f64; 7]> = held
        .iter()
        .map(|&overlap| go(overlap * (1.0 + hair), small, [hair * ROLLING, -0.3 * hair * ROLLING]))
        .collect();
    let last = held[held.len() - 1];
    for share in [0.05, 0.1, -0.02] {
        rows.push(go(last, [share * SLIDING, 0.3 * share * SLIDING], [share * ROLLING, -share * ROLLING]));
    }
    rows
}

/// Every pair of laws, and the laws against rolling and across gaps.
fn models() -> Vec<ContactModel> {
    let mut models: Vec<ContactModel> =
        ALL.iter().map(|&(normal, tangential)| ContactModel::new(normal, tangential, 0.0)).collect();
    let plain = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0);
    for rolling in [
        RollingKind::ELASTIC_PLASTIC,
        RollingKind::ELASTIC_PLASTIC_TWISTING,
        RollingKind::SPRING_DASHPOT_SLIDER,
    ] {
        models.push(ContactModel { rolling, ..plain });
    }
    for adhesion in
        [AdhesionKind::CAPILLARY_BRIDGE, AdhesionKind::CAPILLARY_BRIDGE_FILMS, AdhesionKind::VAN_DER_WAALS]
    {
        models.push(ContactModel { adhesion, ..plain });
    }
    models
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]
    #[test]
    fn rounding_decides_nothing(
        path in prop::collection::vec(
            (0.6..1.4f64, prop::array::uniform2(-0.2..0.2f64), prop::array::uniform2(-0.2..0.2f64)), 1..12),
        change in prop_oneof![Just(0.0), -0.02..0.02f64],
    ) {
        let path: Vec<Step> = path
            .into_iter()
            .map(|(share, slip, turn)| {
                (share * APPROACH, slip.map(|s| s * SLIDING), turn.map(|t| t * ROLLING))
            })
            .collect();
        let from = path[path.len() - 1].0;
        let held: Vec<f64> = (1..=10).map(|k| from * (1.0 + change * f64::from(k))).collect();
        for contact in models() {
            let still = ends(&contact, &path, &held, 0.0);
            let force = still.iter().fold(0.0f64, |most, row| row[..3].iter().fold(most, |most, f| most.max(f.abs())));
            for hair in [1e-15, -1e-15, 1e-14, -1e-14] {
                for (k, (row, other)) in ends(&contact, &path, &held, hair).iter().zip(&still).enumerate() {
                    for c in 0..7 {
                        // Couples are forces times less than a radius.
                        let size = if (3..6).contains(&c) { force * 5e-5 } else { force };
                        prop_assert!(
                            (row[c] - other[c]).abs() <= TOLERANCE * size,
                            "{:?} {:?}, hair {hair:e}, row {k}, column {c}: {:e} {:e}", contact.normal, contact.tangential, row[c], other[c]
                        );
                    }
                }
            }
        }
    }
}
