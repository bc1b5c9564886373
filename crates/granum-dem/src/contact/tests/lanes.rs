//! The same bits for a single contact, in lanes, for two batches side by side, on every instruction set, and after a
//! restart.

use std::marker::PhantomData;

use super::*;
use crate::contact::adhesion::CapillaryBridge;
use crate::contact::choice::kind::{AdhesionKind, RollingKind};
use crate::contact::law::AdhesionLaw;
use crate::contact::slot::columns::Batch;
use granum_simd::{Kernel, LANES, Lanes, Twice, dispatch, dispatch_or};

const STEPS: usize = 400;
/// Columns of motion: branch, velocity, rolling, mean spin, relative spin.
const MOTION: usize = 15;
/// Number of columns of a result.
const VALUES: usize = 24;

/// The laws of a set that is compiled into a loop of its own, with resistance to rolling and twisting and with bridges.
type Set<N, T> = Compiled<N, T, ElasticPlasticTwisting, CapillaryBridge>;

/// Volume of a bridge over the cube of the radius: it ruptures at 5 nm, so that bridges of these pairs come and go.
const BRIDGE: f64 = 1e-12;

type Motion = [f64; MOTION];
type StepBits = [u64; VALUES];

/// A generator without dependencies.
struct Sequence(u64);
impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64 * 2.0 - 1.0
    }
}

/// Pairs that touch and separate, rotate, roll and slip back and forth; some normals cross the equator, some are parallel to
/// an axis.
fn motions(lane: usize) -> Vec<Motion> {
    let mut sequence = Sequence(17 + lane as u64);
    let mut n = [sequence.next(), sequence.next(), 0.02 * sequence.next()];
    if lane == 3 {
        n = [0.0, 0.0, -1.0];
    }
    let mut drift = [0.0; 3];
    (0..STEPS)
        .map(|step| {
            if step % 29 == 0 {
                drift = [0; 3].map(|_| 4e-3 * sequence.next());
            }
            n = std::array::from_fn(|a| n[a] + if lane == 3 && step < 100 { 0.0 } else { drift[a] });
            let size = dot(n, n).sqrt();
            n = n.map(|x| x / size);
            let overlap = 1.5e-8 * (0.02 * step as f64 + lane as f64).sin() + 8e-9;
            // One rotation that is too large for the series.
            if step == 250 && lane == 5 {
                n = [n[1], n[2], n[0]];
            }
            let d = 1e-4 - overlap;
            let mut motion = [0.0; MOTION];
            for a in 0..3 {
                motion[a] = n[a] * d;
                motion[3 + a] = 2e-2 * (sequence.next() + if step % 60 < 30 { 0.5 } else { -0.5 });
                motion[6 + a] = 200.0 * sequence.next();
                motion[9 + a] = 200.0 * sequence.next();
                motion[12 + a] = 2000.0 * wave(step, lane, a);
            }
            motion
        })
        .collect()
}

/// Spins that oscillate; independent of the sequence, which other tests rely on.
fn wave(step: usize, lane: usize, axis: usize) -> f64 {
    (0.05 * step as f64 * (1.0 + 0.1 * axis as f64) + lane as f64).sin()
}

fn kinematics<R: Real>(column: impl Fn(usize) -> R) -> PairMotion<R> {
    PairMotion {
        branch: [column(0), column(1), column(2)],
        velocity: [column(3), column(4), column(5)],
        rolling: [column(6), column(7), column(8)],
        mean_spin: [column(9), column(10), column(11)],
        relative_spin: [column(12), column(13), column(14)],
    }
}

fn columns<R: Real>(out: &Interaction<R>) -> [R; VALUES] {
    let one = R::splat(1.0);
    [
        out.force[0],
        out.force[1],
        out.force[2],
        out.moment[0],
        out.moment[1],
        out.moment[2],
        out.elastic[0],
        out.elastic[1],
        out.elastic[2],
        out.normal_force,
        out.radius,
        out.normal_stiffness,
        out.tangential_stiffness,
        one.keep(out.touching),
        one.keep(out.sliding) + one.keep(out.discards),
        out.tangential_work,
        out.friction_loss + out.micro_slip_loss,
        out.damping_loss + out.adhesion_made + out.adhesion_broken + out.channels[0][0],
        out.couple[0],
        out.couple[1],
        out.couple[2],
        out.moment_work + out.moment_loss + out.step_stiffness,
        one.keep(out.attracting),
        out.attraction_loss,
    ]
}
use granum_simd::Real;

/// The contacts one after another through the slots, with or without restarts from the bytes of a checkpoint.
fn alone(
    contact: &ContactModel,
    isa: Isa,
    constants: &PairConstants<f64>,
    motions: &[Motion],
    restart: bool,
) -> Vec<StepBits> {
    let slots = Slots::new(contact, isa);
    let laws = Open::<One>::new(&slots);
    let mut memory = Memory::<f64>::new();
    let step = |(step, motion): (usize, &Motion)| {
        if restart && step % 37 == 0 {
            memory = through_bytes(&memory);
            assert!(memory.history[contact.history()[0]..].iter().all(|kept| *kept == 0.0));
        }
        let out = interact(&laws, constants, &kinematics(|c| motion[c]), 1e-8, &mut memory);
        columns(&out).map(f64::to_bits)
    };
    motions.iter().enumerate().map(step).collect()
}

/// The memory read back from the bytes of a checkpoint.
fn through_bytes(memory: &Memory<f64>) -> Memory<f64> {
    fn read<const N: usize>(values: [f64; N]) -> [f64; N] {
        values.map(|x| f64::from_le_bytes(x.to_le_bytes()))
    }
    Memory {
        normal: read(memory.normal),
        history: read(memory.history),
        moments: read(memory.moments),
        adhesion: read(memory.adhesion),
        loading: read(memory.loading),
    }
}

/// The contacts one after another with compiled laws.
fn alone_compiled<N: NormalLaw, T: TangentialLaw>(
    constants: &PairConstants<f64>,
    motions: &[Motion],
) -> Vec<StepBits> {
    let mut memory = Memory::<f64>::new();
    let step = |motion: &Motion| {
        let out = interact(&Set::<N, T>::new(), constants, &kinematics(|c| motion[c]), 1e-8, &mut memory);
        columns(&out).map(f64::to_bits)
    };
    motions.iter().map(step).collect()
}

struct InLanes<'a, N, T>(&'a PairConstants<f64>, &'a [Vec<Motion>], PhantomData<(N, T)>);
impl<N: NormalLaw, T: TangentialLaw> Kernel for InLanes<'_, N, T> {
    type Output = Vec<Vec<StepBits>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<Vec<StepBits>> {
        let mut results = vec![vec![[0; VALUES]; STEPS]; LANES];
        let mut memory = Memory::<L>::new();
        for step in 0..STEPS {
            let motion = kinematics(|c| L::load(&std::array::from_fn(|l| self.1[l][step][c])));
            let out = interact(&Set::<N, T>::new(), &self.0.splat(), &motion, L::splat(1e-8), &mut memory);
            for (c, column) in columns(&out).into_iter().enumerate() {
                let mut values = [0.0; LANES];
                column.store(&mut values);
                (0..LANES).for_each(|l| results[l][step][c] = values[l].to_bits());
            }
        }
        results
    }
}

/// Two batches side by side, on processors on which the engine evaluates them so.
struct SideBySide<'a, N, T>(&'a PairConstants<f64>, &'a [Vec<Motion>], PhantomData<(N, T)>);
impl<N: NormalLaw, T: TangentialLaw> Kernel for SideBySide<'_, N, T> {
    type Output = Option<Vec<Vec<StepBits>>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<Vec<Vec<StepBits>>> {
        if !L::PAIRED {
            return None;
        }
        let mut results = vec![vec![[0; VALUES]; STEPS]; 2 * LANES];
        let mut memory = Memory::<Twice<L>>::new();
        for step in 0..STEPS {
            let load = |c: usize, first: usize| L::load(&std::array::from_fn(|l| self.1[first + l][step][c]));
            let motion = kinematics(|c| Twice(load(c, 0), load(c, LANES)));
            let out =
                interact(&Set::<N, T>::new(), &self.0.splat(), &motion, Twice::splat(1e-8), &mut memory);
            for (c, column) in columns(&out).into_iter().enumerate() {
                for (half, first) in [(column.0, 0), (column.1, LANES)] {
                    let mut values = [0.0; LANES];
                    half.store(&mut values);
                    (0..LANES).for_each(|l| results[first + l][step][c] = values[l].to_bits());
                }
            }
        }
        Some(results)
    }
}

/// The same laws called through their slots.
struct ThroughSlots<'a>(&'a Slots, &'a PairConstants<f64>, &'a [Vec<Motion>]);
impl Kernel for ThroughSlots<'_> {
    type Output = Vec<Vec<StepBits>>;
    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<Vec<StepBits>> {
        let ThroughSlots(slots, constants, motions) = self;
        let mut results = vec![vec![[0; VALUES]; STEPS]; LANES];
        let mut memory = Memory::<L>::new();
        for step in 0..STEPS {
            let motion = kinematics(|c| L::load(&std::array::from_fn(|l| motions[l][step][c])));
            let laws = Open::<Batch<L>>::new(slots);
            let out = interact(&laws, &constants.splat(), &motion, L::splat(1e-8), &mut memory);
            for (c, column) in columns(&out).into_iter().enumerate() {
                let mut values = [0.0; LANES];
                column.store(&mut values);
                (0..LANES).for_each(|l| results[l][step][c] = values[l].to_bits());
            }
        }
        results
    }
}

/// A pair with the constants of a set that has resistance to rolling and twisting and bridges.
fn constants_of(contact: &ContactModel, interface_energy: f64) -> PairConstants<f64> {
    let pair = PairProperties { damping: 0.1, ..spheres(interface_energy) };
    let mut constants = contact.constants(&pair);
    constants.adhesion =
        crate::contact::law::constants::columns(CapillaryBridge::prepare(&pair, &[0.072, 0.3, BRIDGE, 0.1]));
    constants
}

/// Through the slots, in every width, on every instruction set and after restarts: the results of single contacts.
fn same_bits_through_slots(contact: &ContactModel, constants: &PairConstants<f64>) -> Vec<Vec<StepBits>> {
    let motions: Vec<Vec<Motion>> = (0..2 * LANES).map(motions).collect();
    let by_itself = |motions: &Vec<Motion>| alone(contact, Isa::Portable, constants, motions, false);
    let reference: Vec<Vec<StepBits>> = motions.iter().map(by_itself).collect();
    for (motion, expected) in motions.iter().zip(&reference) {
        assert_eq!(&alone(contact, Isa::Portable, constants, motion, true), expected, "restart");
    }
    for isa in Isa::ALL.into_iter().filter(|i| i.available()) {
        let slots = dispatch(isa, ThroughSlots(&Slots::new(contact, isa), constants, &motions));
        assert!(slots == reference[..LANES], "{} in a batch", isa.name());
        let one = alone(contact, isa, constants, &motions[5], false);
        assert!(one == reference[5], "{} alone", isa.name());
    }
    reference
}

/// Laws that are compiled into the lanes, as in the engine's loops of their own, give the same results.
fn same_bits_compiled<N: NormalLaw, T: TangentialLaw>(
    constants: &PairConstants<f64>,
    reference: &[Vec<StepBits>],
) {
    let motions: Vec<Vec<Motion>> = (0..2 * LANES).map(motions).collect();
    for (motion, expected) in motions.iter().zip(reference) {
        assert_eq!(&alone_compiled::<N, T>(constants, motion), expected, "compiled, alone");
    }
    // Without vector instructions the engine calls every law through its slot.
    for isa in Isa::ALL.into_iter().filter(|isa| *isa != Isa::Portable && isa.available()) {
        let lanes = InLanes::<N, T>(constants, &motions, PhantomData);
        assert!(dispatch_or(isa, lanes, |_| Vec::new()) == reference[..LANES], "{}", isa.name());
        let both = SideBySide::<N, T>(constants, &motions, PhantomData);
        if let Some(both) = dispatch_or(isa, both, |_| None) {
            assert!(both == reference, "{} side by side", isa.name());
        }
    }
}

/// Runs [`same_bits_compiled`] for the pairs of laws that the engine compiles into loops of their own.
fn check_compiled(laws: LawPair, constants: &PairConstants<f64>, reference: &[Vec<StepBits>]) {
    match (laws.0.name(), laws.1.name()) {
        ("hertz", "mindlin-deresiewicz") => {
            same_bits_compiled::<Hertz, MindlinDeresiewicz>(constants, reference)
        }
        ("hertz", "no-slip") => same_bits_compiled::<Hertz, NoSlip>(constants, reference),
        ("jkr", "mindlin-deresiewicz") => same_bits_compiled::<Jkr, MindlinDeresiewicz>(constants, reference),
        ("jkr", "no-slip") => same_bits_compiled::<Jkr, NoSlip>(constants, reference),
        ("jkr", "peeling") => same_bits_compiled::<Jkr, Peeling>(constants, reference),
        _ => {}
    }
}

#[test]
fn every_law_has_the_same_bits_everywhere() {
    for energy in [0.6, 0.0] {
        for (normal, tangential) in super::ALL {
            let (rolling, adhesion) = (RollingKind::ELASTIC_PLASTIC_TWISTING, AdhesionKind::CAPILLARY_BRIDGE);
            let contact = ContactModel { rolling, adhesion, ..ContactModel::new(normal, tangential, 0.1) };
            let constants = constants_of(&contact, energy);
            let results = same_bits_through_slots(&contact, &constants);
            check_compiled((normal, tangential), &constants, &results);
            let values = || results.iter().flatten().map(|result| result.map(f64::from_bits));
            assert!(values().flatten().all(f64::is_finite));
            let count = |column: usize| values().filter(|result| result[column] == 1.0).count();
            let [touching, sliding, bridged] = [13, 14, 22].map(count);
            let ruptured = values().filter(|result| result[23] > 0.0).count();
            let all = 2 * LANES * STEPS;
            // The motions include contact and separation, sticking and sliding.
            assert!(touching > all / 3 && touching < all, "{normal:?} {tangential:?}: {touching}");
            assert!(bridged > all / 3 && bridged < all && ruptured > 10, "{normal:?}: {bridged} {ruptured}");
            assert!(
                sliding > 50 && sliding < touching - 50,
                "{normal:?} {tangential:?}: {sliding} {touching}"
            );
        }
    }
}

/// A law of rolling that no compiled set contains.
#[test]
fn spring_dashpot_slider_has_the_same_bits_everywhere() {
    for normal in [NormalKind::HERTZ, NormalKind::JKR] {
        let rolling = RollingKind::SPRING_DASHPOT_SLIDER;
        let mut contact = ContactModel { rolling, ..ContactModel::new(normal, TangentialKind::NO_SLIP, 0.1) };
        contact.adhesion = AdhesionKind::CAPILLARY_BRIDGE;
        let results = same_bits_through_slots(&contact, &constants_of(&contact, 0.6));
        let rolls = results.iter().flatten().filter(|result| f64::from_bits(result[18]) != 0.0).count();
        assert!(rolls > LANES * STEPS / 2, "{normal:?}: {rolls}");
    }
}
