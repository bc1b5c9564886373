//! The inner list: the pairs of the neighbour list that are evaluated in every step, and for how long it is valid.

use std::ops::Range;

use serde::{Deserialize, Serialize};

/// The inner list should last this many steps; the inner skin is adapted to that.
const WANTED_STEPS: Range<u64> = 20..60;

/// The inner list: the pairs that touched or were closer than the inner skin when the pairs were last sorted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct InnerList {
    /// Pairs with a smaller gap belong to the inner list, m.
    pub(crate) inner_skin: f64,
    /// Bound on the displacement of any grain between the building of the neighbour list and the sorting of its pairs, m;
    /// minus infinity before the first sorting.
    pub(crate) travel: f64,
    /// Bound on the strain over the same time.
    pub(crate) distortion: f64,
    /// Steps since the pairs were sorted.
    pub(crate) steps: u64,
}

impl InnerList {
    /// The inner list before the first sorting.
    pub(crate) fn new(inner_skin: f64) -> InnerList {
        InnerList { inner_skin, travel: f64::NEG_INFINITY, distortion: 0.0, steps: 0 }
    }

    /// True while no pair outside the inner list can have come to touch; `diameter` is the largest distance of a listed pair.
    pub(crate) fn holds(&self, travel: f64, distortion: f64, diameter: f64) -> bool {
        2.0 * (travel - self.travel) + 1.01 * (distortion - self.distortion) * diameter <= self.inner_skin
    }

    /// Widens the inner skin if the inner list lasted too few steps, and narrows it if it lasted too many.
    pub(crate) fn adapt(&mut self, skin: f64) {
        if self.steps < WANTED_STEPS.start {
            self.inner_skin *= 1.25;
        } else if self.steps > WANTED_STEPS.end {
            self.inner_skin *= 0.9;
        }
        self.inner_skin = self.inner_skin.min(skin);
    }
}

/// One bit for each pair of a batch: whether it touches, and whether it is within the inner skin.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Nearness {
    pub(crate) touching: u8,
    pub(crate) near: u8,
}
