//! A check of bytes of the Thrift compact protocol before the decoder reads them: the decoder allocates and iterates over
//! any number of elements that they claim, and interprets a field by its number, whatever its type.

/// Largest nesting depth; the metadata of Parquet need less than ten.
const DEEPEST: usize = 32;

/// What ends a check.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Flaw {
    /// The bytes end inside the structure.
    TooShort,
    /// It is not a structure of Parquet.
    Wrong,
}

/// The type of a field.
#[derive(Clone, Copy, Debug)]
pub(super) enum FieldType {
    Flag,
    I8,
    I16,
    I32,
    I64,
    Double,
    Bytes,
    List(&'static FieldType),
    Struct(Fields),
}

/// The fields of a structure with their numbers. Others are skipped according to the type that they declare.
pub(super) type Fields = &'static [(i16, FieldType)];

impl FieldType {
    /// True for the type code found in the bytes.
    fn is(self, wire_type: u8) -> bool {
        match self {
            FieldType::Flag => matches!(wire_type, 1 | 2),
            FieldType::I8 => wire_type == 3,
            FieldType::I16 => wire_type == 4,
            FieldType::I32 => wire_type == 5,
            FieldType::I64 => wire_type == 6,
            FieldType::Double => wire_type == 7,
            FieldType::Bytes => wire_type == 8,
            FieldType::List(_) => wire_type == 9,
            FieldType::Struct(_) => wire_type == 12,
        }
    }
}

/// Walks through one structure; returns its number of bytes. `note` is called for every whole number, with the fields that
/// lead to it.
pub(super) fn walk(bytes: &[u8], fields: Fields, note: &mut dyn FnMut(&[i16], i64)) -> Result<usize, Flaw> {
    let mut walker = Walker { rest: bytes, path: Vec::new(), note };
    walker.structure(fields, 0)?;
    Ok(bytes.len() - walker.rest.len())
}

struct Walker<'a> {
    rest: &'a [u8],
    path: Vec<i16>,
    note: &'a mut dyn FnMut(&[i16], i64),
}

impl Walker<'_> {
    fn structure(&mut self, fields: Fields, depth: usize) -> Result<(), Flaw> {
        if depth > DEEPEST {
            return Err(Flaw::Wrong);
        }
        let mut last = 0i16;
        loop {
            let head = self.byte()?;
            if head == 0 {
                return Ok(());
            }
            let id = match head >> 4 {
                0 => i16::try_from(self.whole()?).map_err(|_| Flaw::Wrong)?,
                step => last.checked_add(i16::from(step)).ok_or(Flaw::Wrong)?,
            };
            // The decoder would use the last of two values; no writer writes two.
            if id <= last {
                return Err(Flaw::Wrong);
            }
            last = id;
            let known = fields.iter().find(|(number, _)| *number == id).map(|(_, kind)| *kind);
            self.path.push(id);
            self.value(head & 15, known, depth)?;
            self.path.pop();
        }
    }

    fn value(&mut self, wire_type: u8, known: Option<FieldType>, depth: usize) -> Result<(), Flaw> {
        if known.is_some_and(|kind| !kind.is(wire_type)) {
            return Err(Flaw::Wrong);
        }
        match wire_type {
            1 | 2 => Ok(()),
            3 => self.skip(1),
            4..=6 => {
                let value = self.whole()?;
                (self.note)(&self.path, value);
                Ok(())
            }
            7 => self.skip(8),
            8 => {
                let length = self.variable()?;
                self.skip(length)
            }
            9 | 10 => self.list(known, depth),
            12 => self
                .structure(if let Some(FieldType::Struct(fields)) = known { fields } else { &[] }, depth + 1),
            13 => self.skip(16),
            // The format has no maps.
            _ => Err(Flaw::Wrong),
        }
    }

    fn list(&mut self, known: Option<FieldType>, depth: usize) -> Result<(), Flaw> {
        let head = self.byte()?;
        let size = if head >> 4 == 15 { self.variable()? } else { u64::from(head >> 4) };
        // No list here contains booleans, and the decoder would iterate over any number of them without consuming a byte.
        if matches!(head & 15, 1 | 2) || depth > DEEPEST {
            return Err(Flaw::Wrong);
        }
        if size > self.rest.len() as u64 {
            return Err(Flaw::TooShort);
        }
        let element = if let Some(FieldType::List(element)) = known { Some(*element) } else { None };
        for _ in 0..size {
            self.value(head & 15, element, depth + 1)?;
        }
        Ok(())
    }

    fn byte(&mut self) -> Result<u8, Flaw> {
        let (first, rest) = self.rest.split_first().ok_or(Flaw::TooShort)?;
        self.rest = rest;
        Ok(*first)
    }

    fn skip(&mut self, count: u64) -> Result<(), Flaw> {
        let count = usize::try_from(count).map_err(|_| Flaw::TooShort)?;
        self.rest = self.rest.get(count..).ok_or(Flaw::TooShort)?;
        Ok(())
    }

    /// Seven bits in each byte, the lowest first.
    fn variable(&mut self) -> Result<u64, Flaw> {
        let mut value = 0u64;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            value |= u64::from(byte & 127) << shift;
            if byte < 128 {
                return Ok(value);
            }
        }
        Err(Flaw::Wrong)
    }

    /// Zigzag: 0, -1, 1, -2...
    fn whole(&mut self) -> Result<i64, Flaw> {
        let value = self.variable()?;
        Ok((value >> 1) as i64 ^ -((value & 1) as i64))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(bytes: &[u8]) -> Result<Vec<(Vec<i16>, i64)>, Flaw> {
        let mut found = Vec::new();
        walk(bytes, &[], &mut |path, value| found.push((path.to_vec(), value)))?;
        Ok(found)
    }

    #[test]
    fn numbers_come_with_their_fields() {
        // 1: i32 -3, 3: struct { 1: i64 150 }, 4: text "ab", 5: [i32 1, i32 -1].
        let bytes = [0x15, 5, 0x2c, 0x16, 0xac, 2, 0, 0x18, 2, b'a', b'b', 0x19, 0x25, 2, 1, 0, 99];
        let found = numbers(&bytes).unwrap();
        assert_eq!(found, [(vec![1], -3), (vec![3, 1], 150), (vec![5], 1), (vec![5], -1)]);
        assert_eq!(walk(&bytes, &[], &mut |_, _| {}), Ok(bytes.len() - 1));
        for cut in 0..bytes.len() - 1 {
            assert_eq!(numbers(&bytes[..cut]), Err(Flaw::TooShort), "{cut}");
        }
    }

    #[test]
    fn a_known_field_has_its_type() {
        const FIELDS: Fields =
            &[(1, FieldType::I32), (2, FieldType::List(&FieldType::Struct(&[(1, FieldType::Flag)])))];
        let take = |bytes: &[u8]| walk(bytes, FIELDS, &mut |_, _| {});
        assert_eq!(take(&[0x15, 2, 0x19, 0x1c, 0x11, 0, 0x18, 0, 0]), Ok(9));
        for wrong in [&[0x16, 2, 0][..], &[0x29, 0x15, 2, 0], &[0x29, 0x1c, 0x15, 2, 0, 0], &[0x2c, 0, 0]] {
            assert_eq!(take(wrong), Err(Flaw::Wrong), "{wrong:?}");
        }
    }

    #[test]
    fn claims_beyond_the_bytes_are_refused() {
        // A list of 2^28 structures, a text of 2^28 bytes, 2^28 booleans, a map, a repeated field.
        assert_eq!(numbers(&[0x19, 0xfc, 0x80, 0x80, 0x80, 0x80, 1, 0, 0]), Err(Flaw::TooShort));
        assert_eq!(numbers(&[0x18, 0x80, 0x80, 0x80, 0x80, 1, 0, 0]), Err(Flaw::TooShort));
        assert_eq!(numbers(&[0x19, 0xf1, 0x80, 0x80, 0x80, 0x80, 1, 0, 0]), Err(Flaw::Wrong));
        assert_eq!(numbers(&[0x1b, 1, 0x55, 1, 1, 0]), Err(Flaw::Wrong));
        assert_eq!(numbers(&[0x15, 2, 0x05, 2, 4, 0]), Err(Flaw::Wrong));
        // Endlessly nested structures.
        assert_eq!(numbers(&[0x1c; 100]), Err(Flaw::Wrong));
        assert_eq!(numbers(&[0x19; 100]), Err(Flaw::Wrong));
    }
}
