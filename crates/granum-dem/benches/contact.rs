//! Time of one contact batch (eight contacts) in `interact`, for each pair of laws and each instruction set.
//!
//! `cargo bench -p granum-dem --bench contact`. The batches stay in the first-level cache, so that only the arithmetic is
//! measured: loads of histories and kinematics, the laws, stores of histories, and the sums that the engine makes.

use std::hint::black_box;
use std::time::Instant;

use granum_dem::config::Material;
use granum_dem::contact::evaluation::interaction::{PairMotion, interact};
use granum_dem::contact::evaluation::memory::Memory;
use granum_dem::contact::evaluation::set::Compiled;
use granum_dem::contact::normal::{Hertz, Jkr};
use granum_dem::contact::tangential::{MindlinDeresiewicz, NoSlip, Peeling};
use granum_dem::contact::{NormalLaw, PairConstants, PairProperties, TangentialLaw};
use granum_simd::{Isa, Kernel, LANES, Lanes, Real, Row8, Twice, dispatch};

/// Number of batches in use: about 28 kB with their histories.
const BATCHES: usize = 16;
/// Columns of kinematics: branch, velocity, rolling, mean spin.
const KINEMATICS: usize = 12;
/// Largest number of history columns.
const MEMORY: usize = 13;
/// Number of steps of one measurement.
const STEPS: usize = 388;
/// Number of measurements, of which the shortest counts.
const REPEATS: usize = 100;
const DIAMETER: f64 = 1e-4;

/// A small generator without dependencies: the fractional parts of multiples of the golden ratio.
struct Sequence(f64);
impl Sequence {
    fn next(&mut self) -> f64 {
        self.0 = (self.0 + 0.618_033_988_749_894_9).fract();
        2.0 * self.0 - 1.0
    }
}

/// Contacts that are at rest on average: overlaps as in a sample at 20 kPa, low velocities with changing signs.
fn kinematics() -> Vec<Row8> {
    let mut sequence = Sequence(0.1);
    let mut rows = vec![Row8::default(); BATCHES * KINEMATICS];
    for b in 0..BATCHES {
        for l in 0..LANES {
            let v: [f64; 3] = std::array::from_fn(|_| sequence.next());
            let size = v.iter().map(|x| x * x).sum::<f64>().sqrt();
            let overlap = 1e-8 * (1.2 + sequence.next());
            for a in 0..3 {
                rows[b * KINEMATICS + a].0[l] = v[a] / size * (DIAMETER - overlap);
                rows[b * KINEMATICS + 3 + a].0[l] = 2e-3 * sequence.next();
                rows[b * KINEMATICS + 6 + a].0[l] = 20.0 * sequence.next();
                rows[b * KINEMATICS + 9 + a].0[l] = 20.0 * sequence.next();
            }
        }
    }
    rows
}

struct Run<'a, N, T> {
    constants: &'a PairConstants<f64>,
    kinematics: &'a [Row8],
    memory: &'a mut [Row8],
    laws: std::marker::PhantomData<(N, T)>,
}

struct One<L>(std::marker::PhantomData<L>);
struct Two<L>(std::marker::PhantomData<L>);

/// How a kernel reads and writes `WIDTH` batches together.
trait Access<L: Lanes> {
    type Value: Real;
    const WIDTH: usize;
    fn load(rows: &[Row8], column: usize, stride: usize) -> Self::Value;
    fn store(value: Self::Value, rows: &mut [Row8], column: usize, stride: usize);
}

impl<L: Lanes> Access<L> for One<L> {
    type Value = L;
    const WIDTH: usize = 1;
    #[inline(always)]
    fn load(rows: &[Row8], column: usize, _stride: usize) -> L {
        L::load(&rows[column].0)
    }
    #[inline(always)]
    fn store(value: L, rows: &mut [Row8], column: usize, _stride: usize) {
        value.store(&mut rows[column].0);
    }
}

impl<L: Lanes> Access<L> for Two<L> {
    type Value = Twice<L>;
    const WIDTH: usize = 2;
    #[inline(always)]
    fn load(rows: &[Row8], column: usize, stride: usize) -> Twice<L> {
        Twice(L::load(&rows[column].0), L::load(&rows[column + stride].0))
    }
    #[inline(always)]
    fn store(value: Twice<L>, rows: &mut [Row8], column: usize, stride: usize) {
        value.0.store(&mut rows[column].0);
        value.1.store(&mut rows[column + stride].0);
    }
}

struct Four<L>(std::marker::PhantomData<L>);
impl<L: Lanes> Access<L> for Four<L> {
    type Value = Twice<Twice<L>>;
    const WIDTH: usize = 4;
    #[inline(always)]
    fn load(rows: &[Row8], column: usize, stride: usize) -> Twice<Twice<L>> {
        Twice(Two::<L>::load(rows, column, stride), Two::<L>::load(rows, column + 2 * stride, stride))
    }
    #[inline(always)]
    fn store(value: Twice<Twice<L>>, rows: &mut [Row8], column: usize, stride: usize) {
        Two::<L>::store(value.0, rows, column, stride);
        Two::<L>::store(value.1, rows, column + 2 * stride, stride);
    }
}
struct Wider<'a, N, T>(Run<'a, N, T>);
impl<N: NormalLaw, T: TangentialLaw> Kernel for Wider<'_, N, T> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        steps::<L, Four<L>, N, T>(self.0)
    }
}

struct Wide<'a, N, T>(Run<'a, N, T>);

impl<N: NormalLaw, T: TangentialLaw> Kernel for Run<'_, N, T> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        steps::<L, One<L>, N, T>(self)
    }
}

impl<N: NormalLaw, T: TangentialLaw> Kernel for Wide<'_, N, T> {
    type Output = f64;
    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        steps::<L, Two<L>, N, T>(self.0)
    }
}

#[inline(always)]
fn steps<L: Lanes, A: Access<L>, N: NormalLaw, T: TangentialLaw>(run: Run<'_, N, T>) -> f64 {
    let constants: PairConstants<A::Value> = run.constants.splat();
    let dt = A::Value::splat(1e-8);
    let mut sums = [A::Value::zero(); 13];
    for step in 0..STEPS {
        let sign = A::Value::splat(if step % 97 < 50 { 1.0 } else { -1.0 });
        for b in (0..BATCHES).step_by(A::WIDTH) {
            let given = &run.kinematics[b * KINEMATICS..(b + A::WIDTH) * KINEMATICS];
            let load = |c: usize| A::load(given, c, KINEMATICS);
            let kinematics = PairMotion {
                branch: [load(0), load(1), load(2)],
                velocity: [sign * load(3), sign * load(4), sign * load(5)],
                rolling: [load(6), load(7), load(8)],
                mean_spin: [load(9), load(10), load(11)],
                relative_spin: [A::Value::zero(); 3],
            };
            let rows = &mut run.memory[b * MEMORY..(b + A::WIDTH) * MEMORY];
            let mut memory = Memory::<A::Value>::new();
            for a in 0..3 {
                memory.normal[a] = A::load(rows, a, MEMORY);
            }
            for c in 0..T::HISTORY {
                memory.history[c] = A::load(rows, 3 + c, MEMORY);
            }
            let out = interact(&Compiled::<N, T>::new(), &constants, &kinematics, dt, &mut memory);
            for a in 0..3 {
                A::store(memory.normal[a], rows, a, MEMORY);
            }
            for c in 0..T::HISTORY {
                A::store(memory.history[c], rows, 3 + c, MEMORY);
            }
            for a in 0..3 {
                sums[a] = sums[a] + out.force[a];
                sums[3 + a] = sums[3 + a] + out.moment[a];
                sums[6 + a] = out.elastic[a].mul_add(kinematics.branch[a], sums[6 + a]);
            }
            sums[9] = sums[9] + out.tangential_work;
            sums[10] = sums[10] + out.friction_loss;
            sums[11] = sums[11] + out.damping_loss + out.adhesion_made + out.adhesion_broken;
            sums[12] = sums[12].max(out.normal_stiffness + out.tangential_stiffness);
        }
    }
    sums.iter().map(|s| s.reduce_add()).sum::<f64>()
}

struct Measure {
    isa: Isa,
    wide: usize,
}

impl Measure {
    fn run_laws<N: NormalLaw, T: TangentialLaw>(self) -> f64 {
        let material = Material::default();
        let side = (&material, 0.5 * DIAMETER);
        let constants = Compiled::<N, T>::constants(&PairProperties::new(side, side, 0.1), [&[]; 4]);
        let kinematics = kinematics();
        let mut memory = vec![Row8::default(); BATCHES * MEMORY];
        let mut best = f64::INFINITY;
        for _ in 0..REPEATS {
            let start = Instant::now();
            let run = Run::<N, T> {
                constants: &constants,
                kinematics: black_box(&kinematics),
                memory: &mut memory,
                laws: std::marker::PhantomData,
            };
            black_box(match self.wide {
                1 => dispatch(self.isa, run),
                2 => dispatch(self.isa, Wide(run)),
                _ => dispatch(self.isa, Wider(run)),
            });
            best = best.min(start.elapsed().as_secs_f64());
        }
        best * 1e9 / (STEPS * BATCHES) as f64
    }
}

fn main() {
    println!("ns per batch of {LANES} contacts");
    print!("{:8}{:22}", "normal", "tangential");
    let sets: Vec<Isa> = Isa::ALL.into_iter().skip(1).filter(|i| i.available()).collect();
    sets.iter().for_each(|i| print!("{:>10}{:>10}{:>10}", i.name(), "two", "four"));
    println!();
    type Law = (&'static str, &'static str, fn(Measure) -> f64);
    let laws: [Law; 5] = [
        ("hertz", "no-slip", Measure::run_laws::<Hertz, NoSlip>),
        ("hertz", "mindlin-deresiewicz", Measure::run_laws::<Hertz, MindlinDeresiewicz>),
        ("jkr", "no-slip", Measure::run_laws::<Jkr, NoSlip>),
        ("jkr", "mindlin-deresiewicz", Measure::run_laws::<Jkr, MindlinDeresiewicz>),
        ("jkr", "peeling", Measure::run_laws::<Jkr, Peeling>),
    ];
    for (normal, tangential, measure) in laws {
        print!("{normal:8}{tangential:22}");
        for isa in &sets {
            for wide in [1, 2, 4] {
                print!("{:10.1}", measure(Measure { isa: *isa, wide }));
            }
        }
        println!();
    }
}
