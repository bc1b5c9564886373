//! Runs a kernel with the instruction set that was chosen at run time.

use crate::isa::Isa;
use crate::lanes::Lanes;
use crate::portable::Portable;

/// A computation that runs on any lanes. `run` must be `#[inline(always)]`, and so must everything that it calls in its hot
/// loops, since the calls would otherwise be compiled for the baseline instruction set.
pub trait Kernel {
    /// What it returns.
    type Output;
    /// The computation.
    fn run<L: Lanes>(self) -> Self::Output;
}

/// Runs the kernel compiled for `isa`, or the portable version if the machine does not support `isa`.
#[inline]
pub fn dispatch<K: Kernel>(isa: Isa, kernel: K) -> K::Output {
    dispatch_or(isa, kernel, |kernel| kernel.run::<Portable>())
}

/// Runs the kernel compiled for `isa`, or `portable` where the machine lacks `isa` or `isa` is the portable path. A kernel
/// that exists in many versions need not be compiled for processors without vector instructions: `portable` can compute
/// the same in a slower way.
#[inline]
pub fn dispatch_or<K: Kernel>(isa: Isa, kernel: K, portable: impl FnOnce(K) -> K::Output) -> K::Output {
    // A module that has these instructions runs nowhere without them, and is a third smaller without kernels for lanes in memory.
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    {
        let _ = (isa, portable);
        kernel.run::<crate::wasm::Wasm>()
    }
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    {
        if !isa.available() {
            return portable(kernel);
        }
        // SAFETY: the processor has just been found to have every feature of the instruction set.
        unsafe { dispatch_available(isa, kernel, portable) }
    }
}

/// The same as [`dispatch_or`] without a test of the processor, for functions that are called too often for one.
///
/// # Safety
/// [`Isa::available`] is true for `isa`.
#[inline(always)]
pub unsafe fn dispatch_available<K: Kernel>(
    isa: Isa,
    kernel: K,
    portable: impl FnOnce(K) -> K::Output,
) -> K::Output {
    #[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
    return dispatch_or(isa, kernel, portable);
    #[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
    match isa {
        #[cfg(target_arch = "x86_64")]
        // SAFETY: guaranteed by the caller.
        Isa::Avx512 => unsafe { run_avx512(kernel) },
        #[cfg(target_arch = "x86_64")]
        // SAFETY: as above.
        Isa::Avx2 => unsafe { run_avx2(kernel) },
        #[cfg(target_arch = "aarch64")]
        Isa::Neon => kernel.run::<crate::neon::Neon>(),
        _ => portable(kernel),
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx512f,avx512dq,avx512bw,avx512vl,avx2,fma")]
fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<crate::avx512::Avx512>()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
    kernel.run::<crate::avx2::Avx2>()
}
