//! The speed-up that the processor itself provides with several threads, measured with sums that stay in its registers.
//!
//! If cores share a limit on their clock frequency, or if other programs use the computer, two threads are less than twice
//! as fast as one for any computation. The speed-up of the engine must be compared with this value.

use std::hint::black_box;
use std::time::Instant;

use granum_dem::simulation::Hardware;
use granum_simd::{Kernel, Lanes, dispatch};

/// Number of independent sums, enough to hide the latency of the additions.
const SUMS: usize = 8;

/// A number of rounds of fused multiply-add operations.
struct Rounds(u64);

impl Kernel for Rounds {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes>(self) -> f64 {
        let (factor, term) = (L::splat(black_box(0.999)), L::splat(black_box(1e-3)));
        let mut sums = [L::splat(1.0); SUMS];
        for _ in 0..self.0 {
            for sum in &mut sums {
                *sum = sum.mul_add(factor, term);
            }
        }
        let mut all = L::zero();
        for sum in sums {
            all = all + sum;
        }
        all.reduce_add()
    }
}

/// Rounds per second of all threads together, measured for about so many seconds.
pub fn rounds_per_second(hardware: Hardware, seconds: f64) -> f64 {
    let work = |rounds| {
        let clock = Instant::now();
        std::thread::scope(|scope| {
            for _ in 1..hardware.threads {
                scope.spawn(|| black_box(dispatch(hardware.isa, Rounds(rounds))));
            }
            black_box(dispatch(hardware.isa, Rounds(rounds)));
        });
        clock.elapsed().as_secs_f64()
    };
    let mut rounds = 1000;
    loop {
        let spent = work(rounds);
        if spent >= seconds {
            return (rounds * hardware.threads as u64) as f64 / spent;
        }
        rounds = (rounds as f64 * (1.2 * seconds / spent).clamp(2.0, 100.0)) as u64;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounds_are_made_and_counted_on_every_instruction_set() {
        for isa in granum_dem::Isa::ALL {
            // The sums start at a fixed point of the iteration: 0.999 + 0.001 is 1.
            let all = dispatch(isa, Rounds(1000));
            assert!((all - 64.0).abs() < 1e-9, "{}: {all}", isa.name());
            for threads in [1, 2] {
                let rate = rounds_per_second(Hardware { threads, isa }, 0.002);
                assert!(rate.is_finite() && rate > 1e4, "{} {threads}: {rate}", isa.name());
            }
        }
    }
}
