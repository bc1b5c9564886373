//! The way in which a segment of a run ended.

/// The way in which a segment of a run ended.
pub(super) enum Segment {
    /// The run continues with the next segment.
    GoOn,
    /// The observer stopped the run.
    Stop,
    /// The run is complete.
    Complete,
}
