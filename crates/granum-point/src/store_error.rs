//! Reasons why a store has no answer, and why a file is not a store.

use std::path::PathBuf;

use crate::error::PointError;

/// Reasons why a store has no answer.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// There is no such point.
    #[error("there is no point {name}; the store has {count} points")]
    NoPoint {
        /// Name of the point.
        name: u64,
        /// Number of points.
        count: usize,
    },
    /// The point has no such ticket.
    #[error(
        "point {name} has no state with the ticket {ticket}: the ticket is of another point, of another store, or of a state that was \
         left behind when a later one was accepted; its accepted state has the ticket {accepted}"
    )]
    NoTicket {
        /// Name of the point.
        name: u64,
        /// The ticket.
        ticket: u64,
        /// Ticket of the state that was accepted last.
        accepted: u64,
    },
    /// The point gave no answer.
    #[error("point {name}: {source}")]
    Point {
        /// Name of the point.
        name: u64,
        /// The reason.
        source: PointError,
    },
    /// The file cannot be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The file cannot be written.
    #[error(transparent)]
    Write(#[from] granum_io::Error),
    /// The file is not a store, or not a whole one.
    #[error("{path} {what}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong with it.
        what: String,
    },
}
