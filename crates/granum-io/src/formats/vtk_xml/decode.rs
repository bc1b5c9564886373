//! Numbers from the arrays of a VTK XML file: text, base64 or raw bytes, plain or in blocks compressed with zlib.
//!
//! Binary arrays begin with a header of unsigned integers: plain ones with the number of their bytes; compressed ones with the
//! number of blocks, the size of a block and of the last one (0 if it is whole) before compression, and the compressed size of
//! each block.

use std::cell::Cell;

/// How the bytes of an array stand in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Raw,
    Base64,
}

/// What the head of a file says of its arrays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) big_endian: bool,
    /// Bytes of a number of a header: 4 or 8.
    pub(super) header: usize,
    pub(super) compressed: bool,
}

/// Type of the numbers of an array.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct NumberType {
    bytes: usize,
    class: Class,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Class {
    Signed,
    Unsigned,
    Float,
}

impl NumberType {
    /// `Float64`, `Int8` and the like.
    pub(super) fn named(name: &str) -> Option<NumberType> {
        let at = name.find(|c: char| c.is_ascii_digit())?;
        let class = match &name[..at] {
            "Int" => Class::Signed,
            "UInt" => Class::Unsigned,
            "Float" => Class::Float,
            _ => return None,
        };
        let bytes = match (&name[at..], class) {
            ("8", Class::Signed | Class::Unsigned) => 1,
            ("16", Class::Signed | Class::Unsigned) => 2,
            ("32", _) => 4,
            ("64", _) => 8,
            _ => return None,
        };
        Some(NumberType { bytes, class })
    }

    /// The number that a word is, rounded to this type: text and bytes of one array are the same numbers.
    pub(super) fn parse(self, word: &str) -> Option<f64> {
        match (self.class, self.bytes) {
            (Class::Float, 4) => word.parse::<f32>().ok().map(f64::from),
            _ => word.parse().ok(),
        }
    }

    fn number(self, bytes: &[u8], big_endian: bool) -> f64 {
        let bits = unsigned(bytes, big_endian);
        let unused = 64 - 8 * self.bytes as u32;
        match (self.class, self.bytes) {
            (Class::Unsigned, _) => bits as f64,
            (Class::Signed, _) => (((bits << unused) as i64) >> unused) as f64,
            (Class::Float, 4) => f64::from(f32::from_bits(bits as u32)),
            (Class::Float, _) => f64::from_bits(bits),
        }
    }
}

/// The unsigned integer that these bytes, at most eight, are.
fn unsigned(bytes: &[u8], big_endian: bool) -> u64 {
    let step = |sum: u64, byte: &u8| sum << 8 | u64::from(*byte);
    if big_endian { bytes.iter().fold(0, step) } else { bytes.iter().rev().fold(0, step) }
}

/// The numbers of the array whose header begins at `at`.
///
/// # Errors
/// What is wrong with it, as the end of a sentence about the array.
pub(super) fn binary(
    data: &[u8],
    at: usize,
    encoding: Encoding,
    layout: Layout,
    kind: NumberType,
    room: &Cell<usize>,
) -> Result<Vec<f64>, String> {
    let bytes = if layout.compressed {
        compressed(data, at, encoding, layout, room)?
    } else {
        let size = header(data, at, encoding, layout, 1)?[0];
        take_room(room, size)?;
        // Header and data are one stretch of base64.
        let mut all = encoding.take(data, at, size.checked_add(layout.header).ok_or_else(cut)?)?;
        all.split_off(layout.header)
    };
    if bytes.len() % kind.bytes != 0 {
        return Err(format!("has {} bytes, which are no whole number of values", bytes.len()));
    }
    Ok(bytes.chunks_exact(kind.bytes).map(|value| kind.number(value, layout.big_endian)).collect())
}

/// Room in bytes for the unpacked arrays of a file of so many bytes: 64 times its size and 32 MiB. Numbers of grains, packed, are
/// smaller by a factor below ten; more is claimed by files that are made to fill the memory.
pub(super) fn room(bytes: usize) -> Cell<usize> {
    Cell::new(bytes.saturating_mul(64).saturating_add(32 << 20))
}

/// Takes so many bytes of the room, before they are allocated.
fn take_room(room: &Cell<usize>, bytes: usize) -> Result<(), String> {
    match room.get().checked_sub(bytes) {
        Some(left) => room.set(left),
        None => return Err(format!("claims {bytes} bytes, far more than a file of this size can hold")),
    }
    Ok(())
}

fn compressed(
    data: &[u8],
    at: usize,
    encoding: Encoding,
    layout: Layout,
    room: &Cell<usize>,
) -> Result<Vec<u8>, String> {
    let blocks = header(data, at, encoding, layout, 3)?[0];
    let length = blocks.checked_add(3).filter(|length| *length <= data.len()).ok_or_else(cut)?;
    let head = header(data, at, encoding, layout, length)?;
    let (block, last) = (head[1], head[2]);
    let sizes = &head[3..];
    let total = sizes.iter().try_fold(0_usize, |sum, size| sum.checked_add(*size)).ok_or_else(cut)?;
    // The header is a stretch of base64 of its own.
    let body = encoding.take(data, at + encoding.length(length * layout.header), total)?;
    take_room(room, blocks.saturating_sub(1).saturating_mul(block).saturating_add(last.max(block)))?;
    let (mut bytes, mut start) = (Vec::new(), 0);
    for (k, size) in sizes.iter().enumerate() {
        let whole = if k + 1 == blocks && last != 0 { last } else { block };
        let packed = &body[start..start + size];
        let plain = miniz_oxide::inflate::decompress_to_vec_zlib_with_limit(packed, whole)
            .map_err(|_| "is damaged: a compressed block cannot be unpacked".to_string())?;
        if plain.len() != whole {
            return Err(format!("is damaged: a block has {} bytes instead of {whole}", plain.len()));
        }
        bytes.extend(plain);
        start += size;
    }
    Ok(bytes)
}

/// The first numbers of a header.
fn header(
    data: &[u8],
    at: usize,
    encoding: Encoding,
    layout: Layout,
    count: usize,
) -> Result<Vec<usize>, String> {
    let bytes = encoding.take(data, at, count.checked_mul(layout.header).ok_or_else(cut)?)?;
    let number = |bytes: &[u8]| usize::try_from(unsigned(bytes, layout.big_endian)).map_err(|_| cut());
    bytes.chunks_exact(layout.header).map(number).collect()
}

fn cut() -> String {
    "is cut or damaged: the file ends before it".to_string()
}

impl Encoding {
    /// The length in the file of that many bytes.
    fn length(self, bytes: usize) -> usize {
        match self {
            Encoding::Raw => bytes,
            Encoding::Base64 => bytes.div_ceil(3) * 4,
        }
    }

    /// That many bytes from a place in the file on.
    fn take(self, data: &[u8], at: usize, bytes: usize) -> Result<Vec<u8>, String> {
        // Checked before it is multiplied: a damaged header may claim any size.
        if bytes > data.len() {
            return Err(cut());
        }
        let end = at.checked_add(self.length(bytes)).ok_or_else(cut)?;
        match self {
            Encoding::Raw => Ok(data.get(at..end).ok_or_else(cut)?.to_vec()),
            Encoding::Base64 => {
                // The last group may lack its padding where the data end.
                let text = data.get(at..end.min(data.len())).ok_or_else(cut)?;
                let mut found = base64(text)?;
                if found.len() < bytes {
                    return Err(cut());
                }
                found.truncate(bytes);
                Ok(found)
            }
        }
    }
}

fn base64(text: &[u8]) -> Result<Vec<u8>, String> {
    let digit = |byte: u8| match byte {
        b'A'..=b'Z' => Ok(byte - b'A'),
        b'a'..=b'z' => Ok(byte - b'a' + 26),
        b'0'..=b'9' => Ok(byte - b'0' + 52),
        b'+' => Ok(62),
        b'/' => Ok(63),
        other => Err(format!("is damaged: {:?} is no base64", char::from(other))),
    };
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3);
    for group in text.chunks(4) {
        let digits: Vec<u8> = group
            .iter()
            .take_while(|byte| **byte != b'=')
            .map(|byte| digit(*byte))
            .collect::<Result<_, _>>()?;
        let bits =
            digits.iter().fold(0_u32, |sum, digit| sum << 6 | u32::from(*digit)) << (6 * (4 - digits.len()));
        bytes.extend(bits.to_be_bytes()[1..].iter().take((digits.len() * 6) / 8));
    }
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        assert_eq!(base64(b"Zm9vYmE=").unwrap(), b"fooba");
        assert_eq!(base64(b"Zm9vYg==").unwrap(), b"foob");
        assert_eq!(base64(b"Zm9vYmFy").unwrap(), b"foobar");
        assert!(base64(b"Zm9*").unwrap_err().contains("'*' is no base64"));
    }

    #[test]
    fn numbers_of_every_type_are_read() {
        let number = |name: &str, bytes: &[u8], big| NumberType::named(name).unwrap().number(bytes, big);
        assert_eq!(number("Int16", &[0xFE, 0xFF], false), -2.0);
        assert_eq!(number("UInt16", &[0xFE, 0xFF], false), 65534.0);
        assert_eq!(number("Float32", &[0x3F, 0x80, 0, 0], true), 1.0);
        assert_eq!(number("Int64", &(-3_i64).to_le_bytes(), false), -3.0);
        assert_eq!(number("Float64", &2.5_f64.to_be_bytes(), true), 2.5);
        assert!(NumberType::named("Float16").is_none() && NumberType::named("String").is_none());
    }

    /// Zeros are packed a thousand times smaller: two megabytes are two gigabytes.
    #[test]
    fn more_than_there_is_room_for_is_refused_before_it_is_unpacked() {
        let packed = miniz_oxide::deflate::compress_to_vec_zlib(&vec![0; 1 << 20], 9);
        let blocks = 3000_u32;
        let head = [blocks, 1 << 20, 0].into_iter().chain((0..blocks).map(|_| packed.len() as u32));
        let mut bytes: Vec<u8> = head.flat_map(u32::to_le_bytes).collect();
        (0..blocks).for_each(|_| bytes.extend(&packed));
        let layout = Layout { big_endian: false, header: 4, compressed: true };
        let kind = NumberType::named("Float64").unwrap();
        let room = room(bytes.len());
        let error = binary(&bytes, 0, Encoding::Raw, layout, kind, &room).unwrap_err();
        assert!(error.starts_with("claims 3145728000 bytes, far more"), "{error}");
        // Its own size is not a reason: a single block has room.
        bytes[..4].copy_from_slice(&1_u32.to_le_bytes());
        bytes.drain(16..12 + 4 * blocks as usize);
        assert_eq!(binary(&bytes, 0, Encoding::Raw, layout, kind, &room).unwrap().len(), 1 << 17);
    }

    proptest! {
        #[test]
        fn any_bytes_give_numbers_or_a_message(
            bytes in proptest::collection::vec(any::<u8>(), 0..60),
            at in 0_usize..70,
            raw: bool, compressed: bool, wide: bool,
        ) {
            let layout = Layout { big_endian: false, header: if wide { 8 } else { 4 }, compressed };
            let encoding = if raw { Encoding::Raw } else { Encoding::Base64 };
            let _ = binary(&bytes, at, encoding, layout, NumberType::named("Float64").unwrap(), &room(bytes.len()));
        }
    }
}
