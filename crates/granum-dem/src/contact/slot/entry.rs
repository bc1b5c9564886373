//! The computation of a law as a function for one instruction set, chosen once and then called directly.

use std::marker::PhantomData;

use granum_simd::{Isa, Kernel, Lanes, Real, ScalarKernel, dispatch_available, fused};

use crate::contact::slot::columns::{Batch, Count, One, Sheet, Width};

/// A computation over columns, compiled for every width and instruction set.
pub(super) trait Call {
    fn call<W: Width>(sheet: &mut Sheet<'_>);
}

/// A computation for a batch.
struct InLanes<'a, 'b, C>(&'a mut Sheet<'b>, PhantomData<C>);

impl<C: Call> Kernel for InLanes<'_, '_, C> {
    type Output = ();
    #[inline(always)]
    fn run<L: Lanes>(self) {
        C::call::<Batch<L>>(self.0);
    }
}

/// A computation for one contact.
struct OfOne<'a, 'b, C>(&'a mut Sheet<'b>, PhantomData<C>);

impl<C: Call> ScalarKernel for OfOne<'_, '_, C> {
    type Output = ();
    #[inline(always)]
    fn run<R: Real>(self) {
        C::call::<One<R>>(self.0);
    }
}

/// The computation of a law over columns, for one contact or for a batch, with one instruction set.
#[derive(Clone, Copy)]
pub struct Entry(unsafe fn(&mut Sheet<'_>));

impl Entry {
    /// A computation that does nothing.
    pub(super) fn none() -> Entry {
        Entry(|_| ())
    }

    pub(super) fn new<C: Call>(isa: Isa, count: Count) -> Entry {
        // SAFETY of these functions: each is chosen only where its instructions are available.
        match (count, isa) {
            // A single contact needs no lanes.
            (Count::One, _) => Entry(|sheet| fused(OfOne::<C>(sheet, PhantomData))),
            (Count::Batch, Isa::Avx512) if isa.available() => {
                Entry(|sheet| unsafe { in_lanes::<C>(Isa::Avx512, sheet) })
            }
            (Count::Batch, Isa::Avx2) if isa.available() => {
                Entry(|sheet| unsafe { in_lanes::<C>(Isa::Avx2, sheet) })
            }
            (Count::Batch, Isa::Neon) if isa.available() => {
                Entry(|sheet| unsafe { in_lanes::<C>(Isa::Neon, sheet) })
            }
            (Count::Batch, Isa::Wasm) if isa.available() => {
                Entry(|sheet| unsafe { in_lanes::<C>(Isa::Wasm, sheet) })
            }
            (Count::Batch, _) => Entry(one_by_one::<C>),
        }
    }

    /// Evaluates the contacts of a sheet.
    #[inline(always)]
    pub(super) fn call(self, sheet: &mut Sheet<'_>) {
        // SAFETY: the function was chosen for instructions that the processor has.
        unsafe { (self.0)(sheet) }
    }
}

/// # Safety
/// The instruction set is available.
#[inline(always)]
unsafe fn in_lanes<C: Call>(isa: Isa, sheet: &mut Sheet<'_>) {
    let kernel = InLanes::<C>(sheet, PhantomData);
    // SAFETY: guaranteed by the caller.
    unsafe { dispatch_available(isa, kernel, |kernel| one_by_one::<C>(kernel.0)) }
}

/// Without vector instructions a batch is evaluated contact by contact, which gives the same bits: formulas over eight plain numbers
/// would be half of the code, and hardly anybody would run them.
fn one_by_one<C: Call>(sheet: &mut Sheet<'_>) {
    sheet.for_each_contact(|sheet| fused(OfOne::<C>(sheet, PhantomData)));
}
