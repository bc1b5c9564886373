//! Aligned rows of doubles: what a lane-wise gather reads and a scatter writes.

/// Eight doubles on one cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(64))]
pub struct Row8(pub [f64; 8]);

/// Four doubles on half a cache line.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C, align(32))]
pub struct Row4(pub [f64; 4]);
