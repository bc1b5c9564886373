//! The history of a contact.

use granum_simd::Real;

use crate::contact::evaluation::frame::{self, ContactFrame};
use crate::contact::law::limits::{
    MAX_ADHESION_HISTORY, MAX_HISTORY, MAX_MOMENT_HISTORY, MAX_NORMAL_HISTORY,
};

/// The history that a contact keeps between steps.
#[derive(Clone, Copy)]
pub struct Memory<R> {
    /// Unit normal at the last step; zero where the pair did not touch.
    pub normal: [R; 3],
    /// The columns of the tangential law; vectors by their components in the [`ContactFrame`] of the normal.
    pub history: [R; MAX_HISTORY],
    /// The columns of the moment law.
    pub moments: [R; MAX_MOMENT_HISTORY],
    /// The columns of the adhesion law, which may act on separated grains.
    pub adhesion: [R; MAX_ADHESION_HISTORY],
    /// The columns of the normal law.
    pub loading: [R; MAX_NORMAL_HISTORY],
}

impl<R: Real> Memory<R> {
    /// The history of a pair that has not touched.
    #[inline(always)]
    pub fn new() -> Self {
        Memory {
            normal: [R::zero(); 3],
            history: [R::zero(); MAX_HISTORY],
            moments: [R::zero(); MAX_MOMENT_HISTORY],
            adhesion: [R::zero(); MAX_ADHESION_HISTORY],
            loading: [R::zero(); MAX_NORMAL_HISTORY],
        }
    }
}

impl<R: Real> Default for Memory<R> {
    fn default() -> Self {
        Memory::new()
    }
}

/// Rewrites the plane vectors at the beginning of a history for the pair (j, i) instead of (i, j): every stored vector is
/// reversed in space, and so is the normal.
pub fn swap_sides(normal: [f64; 3], vectors: usize, history: &mut [f64]) {
    for v in 0..vectors {
        let vector = [history[2 * v], history[2 * v + 1]];
        history[2 * v..2 * v + 2].copy_from_slice(&frame::swap_sides(normal, vector));
    }
}

/// The tangential force T on grain i stored in a contact history, N.
pub fn tangential_force(memory: &Memory<f64>) -> [f64; 3] {
    ContactFrame::new(memory.normal).vector([memory.history[0], memory.history[1]])
}
