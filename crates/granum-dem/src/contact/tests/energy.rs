//! The balance of the work of a tangential force: stored, lost in micro-slip, lost in sliding.

use crate::contact::law::constants::named;
use proptest::prelude::*;

use granum_simd::Isa;

use super::One;
use super::observed::observed;
use super::{ALL, Bench, LawPair, spheres};
use crate::contact::choice::kind::{NormalKind, TangentialKind};
use crate::contact::law::{NormalLaw, TangentialLaw};
use crate::contact::normal::Hertz;
use crate::contact::tangential::MindlinDeresiewicz;

/// Sums over a path.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    work: f64,
    friction: f64,
    micro_slip: f64,
    stored: f64,
    /// Work if the force were at the limit throughout.
    size: f64,
}

impl Sums {
    /// The part of the work that is not accounted for.
    fn gap(&self) -> f64 {
        self.work - self.stored - self.friction - self.micro_slip
    }
}

impl Bench {
    fn add_to_sums(&mut self, approach: f64, slip: [f64; 2], sums: &mut Sums) {
        let before = self.memory.history;
        let out = self.step(approach, slip);
        if out.discards {
            let stiffness = out.tangential_stiffness;
            sums.micro_slip += self.slots.discarded::<One>(&self.constants.tangential, stiffness, &before);
        }
        sums.work += out.tangential_work;
        sums.friction += out.friction_loss;
        sums.micro_slip += out.micro_slip_loss;
        sums.size += 0.3 * self.friction_load(approach) * slip[0].hypot(slip[1]);
        let mut batch = [observed(&self.constants, &[(self.memory, approach, true)])];
        self.contact.observe(Isa::detect(), &mut batch);
        sums.stored = batch[0].tangential_energy.0[0];
    }

    /// A displacement in one direction, with a linear change of the approach from one value to another.
    fn way(&mut self, [from, to]: [f64; 2], slip: f64, steps: usize, sums: &mut Sums) {
        for k in 1..=steps {
            let approach = from + (to - from) * k as f64 / steps as f64;
            self.add_to_sums(approach, [0.6, 0.8].map(|c| c * slip / steps as f64), sums);
        }
    }
}

impl Bench {
    /// True if a way that slips in this direction leaves a reloading curve whose force still opposes that of the first turning
    /// point.
    fn leaves_reloading_early(&self, slip: f64) -> bool {
        let [fx, fy, px, py, qx, qy, stage, ..] = self.memory.history;
        let backwards = slip * (0.6 * (fx - qx) + 0.8 * (fy - qy)) < 0.0;
        stage == 2.0 && backwards && fx * px + fy * py < 0.0
    }
}

const CURVES: LawPair = (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ);
const APPROACH: f64 = 2e-8;

/// The limit force, and the displacement at which it is reached, `3/2 L / 8 G* a`.
fn limits(bench: &Bench) -> (f64, f64) {
    let normal = Hertz::evaluate(&named(&bench.constants.normal), APPROACH, true);
    let stiffness = MindlinDeresiewicz::stiffness(&named(&bench.constants.tangential), &normal);
    (0.3 * normal.force, 0.45 * normal.force / stiffness)
}

/// The loss of a cycle between `-T*` and `T*` at constant load (Mindlin and Deresiewicz 1953; Johnson 1985, eq. 7.49):
/// with `q = T* / L`, `36/5 L^2 / 8 G* a [1 - (1 - q)^(5/3) - 5/6 q (1 + (1 - q)^(2/3))]`.
#[test]
fn a_cycle_loses_what_mindlin_and_deresiewicz_say() {
    for share in [0.3, 0.6, 0.9] {
        let mut bench = Bench::new(CURVES, spheres(0.0));
        bench.step(APPROACH, [0.0; 2]);
        let (limit, reach) = limits(&bench);
        let way = |slip: f64, bench: &mut Bench| {
            let mut sums = Sums::default();
            bench.way([APPROACH; 2], slip * reach, 40_000, &mut sums);
            sums
        };
        let loading = way(share, &mut bench);
        assert!((loading.gap() / loading.work).abs() < 1e-4, "{loading:?}");
        let cycle = [way(-2.0 * share, &mut bench), way(2.0 * share, &mut bench)];
        let lost: f64 = cycle.iter().map(|sums| sums.micro_slip).sum();
        let work: f64 = cycle.iter().map(|sums| sums.work).sum();
        let q = 1.0 - (1.0 - share).powf(1.5);
        let rest = 1.0 - q;
        let bracket = 1.0 - rest.powf(5.0 / 3.0) - 5.0 / 6.0 * q * (1.0 + rest.powf(2.0 / 3.0));
        let exact = 7.2 * limit * limit * 1.5 / (limit / reach * 1.5 * 1.5) * bracket;
        assert!((lost / exact - 1.0).abs() < 2e-4, "{share}: {lost:e} {exact:e}");
        assert!((work / exact - 1.0).abs() < 2e-3, "{share}: {work:e} {exact:e}");
        // Back at the turning point, with the energy that was stored there.
        assert!((cycle[1].stored / loading.stored - 1.0).abs() < 1e-3);
    }
}

/// At the limit every spring is at its own limit: `9/4 L^2 / 2 k` times the integral of `(1 - x^2)^2`, 8/15.
#[test]
fn a_sliding_contact_stores_six_fifths_of_its_spring() {
    let mut bench = Bench::new(CURVES, spheres(0.0));
    bench.step(APPROACH, [0.0; 2]);
    let (limit, reach) = limits(&bench);
    let mut sums = Sums::default();
    bench.way([APPROACH; 2], 3.0 * reach, 3000, &mut sums);
    let spring = 0.5 * limit * limit / (1.5 * limit / reach);
    assert!((sums.stored / (1.2 * spring) - 1.0).abs() < 1e-9, "{}", sums.stored / spring);
    assert!((sums.friction / (limit * 2.0 * reach) - 1.0).abs() < 1e-2);
    assert!((sums.gap() / sums.work).abs() < 1e-3);
}

/// Displacements in one direction at constant load, or with a changing one: the gap relative to the amount of work, and whether a
/// reloading curve of Mindlin and Deresiewicz was left before the force had passed zero.
fn gap_of_a_line(laws: LawPair, path: &[(f64, f64)], changing_load: bool) -> (f64, bool) {
    let mut bench = Bench::new(laws, spheres(0.6));
    let mut sums = Sums::default();
    let mut at = path[0].0;
    bench.step(at, [0.0; 2]);
    let mut left_early = false;
    for &(overlap, slip) in path {
        left_early |= laws.1 == TangentialKind::MINDLIN_DERESIEWICZ && bench.leaves_reloading_early(slip);
        let next = if changing_load { overlap } else { at };
        bench.way([at, next], slip, 2000, &mut sums);
        at = next;
    }
    (if sums.size > 0.0 { sums.gap() / sums.size } else { 0.0 }, left_early)
}

/// The law remembers two turning points. Where a reloading curve is left before the force has passed zero, the state that it then
/// assumes cannot arise from springs, and a part of the energy is in no column: at most 0.35 % of the work at the limit.
#[test]
fn a_reloading_curve_that_is_left_early_costs_some_energy() {
    let gap = |back: f64| {
        gap_of_a_line(CURVES, &[5.14e-10, -7.93e-10, back, -7.9e-10].map(|slip| (3e-9, slip)), false)
    };
    let mut largest = 0.0f64;
    for back in [1e-13, 4.5e-12, 2e-11, 5e-11, 1e-10] {
        let (gap, left_early) = gap(back);
        assert!(left_early && gap.abs() < 4e-3, "{back:e}: {gap:e}");
        largest = largest.max(gap.abs());
    }
    assert!(largest > 3e-3, "{largest:e}");
    // Beyond zero the balance is closed.
    let (gap, left_early) = gap(3e-10);
    assert!(!left_early && gap.abs() < 2e-4, "{gap:e}");
}

/// Without a tangential displacement no work is done, stored or lost, whatever the load does.
#[test]
fn load_alone_costs_no_tangential_energy() {
    for laws in ALL {
        let mut bench = Bench::new(laws, spheres(0.6));
        let mut sums = Sums::default();
        bench.way([1e-9, 3e-8], 0.0, 50, &mut sums);
        bench.way([3e-8, 2e-9], 0.0, 50, &mut sums);
        assert_eq!([sums.work, sums.friction, sums.micro_slip, sums.stored], [0.0; 4], "{laws:?}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    #[test]
    fn work_is_stored_slipped_and_slid(
        path in prop::collection::vec((3e-9f64..3e-8, -8e-10f64..8e-10), 1..6)
    ) {
        for (normal, tangential) in ALL {
            // While a contact peels, a part of its energy is in the lost area.
            if tangential == TangentialKind::PEELING {
                continue;
            }
            let (gap, left_early) = gap_of_a_line((normal, tangential), &path, false);
            let bound = if left_early { 5e-3 } else { 2e-4 };
            prop_assert!(gap.abs() < bound, "{normal:?} {tangential:?}: {gap:e}");
            // Under a changing load the history of the incremental law does not determine all the energy that a contact stores.
            if tangential == TangentialKind::NO_SLIP {
                let (gap, _) = gap_of_a_line((normal, tangential), &path, true);
                prop_assert!(gap.abs() < 1e-10, "changing load, {normal:?}: {gap:e}");
            }
        }
    }
}
