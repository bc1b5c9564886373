//! The two instructions of WebAssembly's relaxed SIMD that granum uses: a fused multiply-add, and a selection by a mask.
//!
//! They stand in a crate of their own, because the compiler takes the instructions that it may use from the whole of a crate: where the
//! relaxed ones are allowed, LLVM also makes `relaxed_min` and `relaxed_max` of comparisons, whose results for zeros of both signs and for
//! NaN depend on the processor. `wasm-opt` inlines the two functions where a module is put together (`scripts/page`).
//!
//! On other processors this crate is empty.
#![no_std]

#[cfg(target_arch = "wasm32")]
#[allow(
    improper_ctypes_definitions,
    reason = "Rust calls these functions; the convention of C hands vectors over in registers"
)]
mod instructions {
    use core::arch::wasm32::{f64x2_relaxed_madd, i64x2_relaxed_laneselect, v128};

    /// `a b + c` of two doubles side by side: rounded once where the browser fuses, else twice. A page asks before it takes a module
    /// that has this instruction.
    #[inline(never)]
    #[target_feature(enable = "relaxed-simd")]
    pub extern "C" fn relaxed_mul_add(a: v128, b: v128, c: v128) -> v128 {
        f64x2_relaxed_madd(a, b, c)
    }

    /// `yes` where the mask is all ones, `no` where it is all zeros; other masks are not to be used.
    #[inline(never)]
    #[target_feature(enable = "relaxed-simd")]
    pub extern "C" fn relaxed_select(yes: v128, no: v128, mask: v128) -> v128 {
        i64x2_relaxed_laneselect(yes, no, mask)
    }
}

#[cfg(target_arch = "wasm32")]
pub use instructions::{relaxed_mul_add, relaxed_select};
