//! Checks of the sizes given in a Parquet file against its actual size before the decoder uses them: the decoder allocates
//! the memory that a damaged header claims, gigabytes for a file of a few hundred bytes.

use std::io::Read;

use parquet::basic::Compression;
use parquet::file::metadata::{ColumnChunkMetaData, ParquetMetaData};
use parquet::file::reader::ChunkReader;

use super::format::{FILE_METADATA, PAGE_HEADER};
use super::thrift::{Flaw, walk};

/// Largest expansion factor of snappy: a copy of 64 bytes takes three.
const SNAPPY: u64 = 32;
/// Largest expansion factor of deflate, the compression of gzip: 258 bytes take two bits.
const GZIP: u64 = 1032;
/// Additional size permitted for a page, bytes.
const FREE_BYTES: u64 = 1024;
/// Largest length of the header of a page of numbers.
const LONGEST_HEADER: u64 = 1 << 16;
/// A length that is sufficient for most headers.
const SHORT_HEADER: u64 = 256;

const DAMAGED: &str = "is not a Parquet file or is damaged";

/// Checks the metadata at the end of a file byte by byte.
pub(super) fn check_footer(reader: &impl ChunkReader) -> Result<(), String> {
    let bytes = reader.len();
    let read = |start: u64, length: u64| {
        let length = usize::try_from(length).map_err(|_| DAMAGED.to_string())?;
        reader.get_bytes(start, length).map_err(|error| format!("{DAMAGED} ({error})"))
    };
    let Some(end) = bytes.checked_sub(8) else {
        return Err(format!("{DAMAGED} (it has only {bytes} bytes)"));
    };
    let tail = read(end, 8)?;
    let &[a, b, c, d, ref mark @ ..] = tail.as_ref() else { return Err(DAMAGED.into()) };
    let length = u64::from(u32::from_le_bytes([a, b, c, d]));
    if mark != b"PAR1" || length > end {
        return Err(format!("{DAMAGED} (its last bytes are not those of a Parquet file)"));
    }
    let footer = read(end - length, length)?;
    match walk(&footer, FILE_METADATA, &mut |_, _| {}) {
        Ok(_) => Ok(()),
        Err(_) => Err(format!("{DAMAGED} (its metadata cannot be decoded)")),
    }
}

/// Checks that the requested columns are inside the file and do not overlap, and that their pages claim no more than they
/// can hold.
pub(super) fn check_columns(
    reader: &impl ChunkReader,
    metadata: &ParquetMetaData,
    wanted: &[usize],
) -> Result<(), String> {
    let bytes = reader.len();
    let mut total = 0u64;
    for group in metadata.row_groups() {
        for column in wanted.iter().filter_map(|at| group.columns().get(*at)) {
            let (start, length) =
                place(column, bytes).ok_or_else(|| format!("{DAMAGED} (a column lies outside the file)"))?;
            total = total.saturating_add(length);
            if total > bytes {
                return Err(format!("{DAMAGED} (its columns are longer than the file)"));
            }
            check_pages(reader, start, length, column.compression())
                .map_err(|why| format!("column {}: {DAMAGED} ({why})", column.column_descr().name()))?;
        }
    }
    Ok(())
}

/// Start and length of a column in the file; the decoder panics if they are negative.
fn place(column: &ColumnChunkMetaData, bytes: u64) -> Option<(u64, u64)> {
    let data = u64::try_from(column.data_page_offset()).ok()?;
    let start = match column.dictionary_page_offset() {
        Some(dictionary) => u64::try_from(dictionary).ok()?,
        None => data,
    };
    let length = u64::try_from(column.compressed_size()).ok()?;
    (data <= bytes && start.checked_add(length)? <= bytes).then_some((start, length))
}

/// The sizes in the header of a page.
#[derive(Default)]
struct Header {
    length: u64,
    plain_size: i64,
    size: i64,
    dictionary_values: i64,
}

fn check_pages(
    reader: &impl ChunkReader,
    start: u64,
    length: u64,
    compression: Compression,
) -> Result<(), String> {
    let mut at = start;
    let end = start + length;
    while at < end {
        let header = read_header(reader, at, end - at)?;
        at += header.length;
        let size = u64::try_from(header.size).ok().filter(|size| *size <= end - at);
        let size =
            size.ok_or_else(|| format!("a page of {} bytes does not fit in its column", header.size))?;
        let most = match compression {
            Compression::UNCOMPRESSED => size,
            Compression::GZIP(_) => size.saturating_mul(GZIP) + FREE_BYTES,
            _ => size * SNAPPY + FREE_BYTES,
        };
        if !u64::try_from(header.plain_size).is_ok_and(|plain| plain <= most) {
            return Err(format!("a page of {size} bytes claims {} bytes uncompressed", header.plain_size));
        }
        // A boolean takes one bit.
        if !u64::try_from(header.dictionary_values).is_ok_and(|values| values <= 8 * most) {
            return Err(format!("a page of {size} bytes claims {} values", header.dictionary_values));
        }
        at += size;
    }
    Ok(())
}

fn read_header(reader: &impl ChunkReader, at: u64, left: u64) -> Result<Header, String> {
    let mut bytes = Vec::new();
    for most in [SHORT_HEADER, LONGEST_HEADER] {
        let input = reader.get_read(at).map_err(|error| error.to_string())?;
        bytes.clear();
        input.take(most.min(left)).read_to_end(&mut bytes).map_err(|error| error.to_string())?;
        let mut header = Header::default();
        let mut note = |path: &[i16], value: i64| match path {
            [2] => header.plain_size = value,
            [3] => header.size = value,
            [7, 1] => header.dictionary_values = value,
            _ => {}
        };
        match walk(&bytes, PAGE_HEADER, &mut note) {
            Ok(length) => return Ok(Header { length: length as u64, ..header }),
            Err(Flaw::TooShort) if most < left => {}
            Err(_) => break,
        }
    }
    Err("the header of a page cannot be decoded".into())
}
