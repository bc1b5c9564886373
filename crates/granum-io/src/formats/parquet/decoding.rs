//! How values are decoded: so many at a time, and with errors that say what to do.

use parquet::errors::ParquetError;

/// Number of rows of a group, and of values decoded at a time.
pub(super) const GROUP: usize = 1 << 17;

/// An error of the parquet crate, explained with what to do.
pub(super) fn explain(error: &ParquetError) -> String {
    let text = error.to_string();
    let lower = text.to_lowercase();
    if lower.contains("codec") || lower.contains("compression") || lower.contains("disabled feature") {
        return format!(
            "is compressed by an unsupported method ({text}); write it uncompressed or with snappy or gzip"
        );
    }
    format!("is not a Parquet file or is damaged ({text})")
}
