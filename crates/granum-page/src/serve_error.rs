//! Why a folder cannot be served.

use std::net::SocketAddr;
use std::path::PathBuf;

/// Why a folder cannot be served.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The folder cannot be read.
    #[error("{}: cannot read the folder: {source}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The address cannot be used.
    #[error(
        "cannot listen at {address}: {source}; choose another port with --port, or a free one with --port 0"
    )]
    Address {
        /// The address.
        address: SocketAddr,
        /// Why.
        source: std::io::Error,
    },
    /// The system gives no random numbers.
    #[error("the system gives no random numbers for the address ({0})")]
    Random(String),
    /// The server cannot be started or has ended.
    #[error("the server cannot go on: {0}")]
    Server(#[from] std::io::Error),
}
