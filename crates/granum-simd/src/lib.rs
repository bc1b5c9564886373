//! Eight double precision lanes with the same bits on every instruction set.
//!
//! A formula is written once, generic over [`Real`], and runs on a plain `f64`, on eight portable
//! lanes, on NEON, on the SIMD of WebAssembly, on AVX2 with FMA and on AVX-512. Only operations that IEEE 754 rounds correctly are
//! offered (add, subtract, multiply, divide, square root, fused multiply-add), together with exact
//! bit operations, so that the result does not depend on which of them ran. A fused operation
//! happens only where [`Real::mul_add`] or [`mul_add()`] is called: the compiler never contracts on its own. Where the processor has no
//! instruction for it, it is computed exactly (`fused.rs`), never by the C library, which on some platforms rounds twice.
//!
//! All `unsafe` of the arithmetic lives in `avx2.rs`, `avx512.rs` (x86-64), `neon.rs` (aarch64), `wasm/` (WebAssembly) and `scalar.rs`; [`Row8::numbers`] has
//! one more.

mod dispatch;
mod fused;
mod isa;
mod lanes;
mod math;
mod portable;
mod prefetch;
mod rows;
mod scalar;
mod twice;
pub mod vectors;

#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
#[cfg(target_arch = "aarch64")]
mod neon;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;

#[cfg(test)]
mod tests;

pub use dispatch::{Kernel, dispatch, dispatch_available, dispatch_or};
pub use fused::mul_add;
pub use isa::Isa;
pub use lanes::{Lanes, Mask, Real};
pub use math::{cbrt, exp, integer_power, power, sigmoid, tanh};
pub use portable::Portable;
pub use prefetch::prefetch;
pub use rows::{Row4, Row8};
pub use scalar::{ScalarKernel, fused, wide};
pub use twice::Twice;

/// Number of lanes of every vector type of this crate.
pub const LANES: usize = 8;
