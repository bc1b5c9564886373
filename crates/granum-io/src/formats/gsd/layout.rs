//! The container: a header, an index of chunks, a list of their names, and the chunks.

use std::cell::Cell;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use granum_core::input::LARGEST_INPUT;

use crate::error::{Error, Result};

/// The first bytes of every file.
pub(super) const MAGIC: [u8; 8] = [0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65, 0xDF, 0x65];

const HEADER: usize = 256;
const ENTRY: usize = 32;
const NAME: usize = 64;
/// All numbers that are read of a file have at most this many times its bytes, and so many more: frames may share chunks of the first
/// one, but a file that names one chunk a million times is no sample of grains.
const MOST_TIMES: u64 = 64;
const FREE: u64 = 32 << 20;

/// The type of the numbers of a chunk.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum ChunkType {
    U32,
    U64,
    I32,
    F32,
    F64,
}

impl ChunkType {
    fn code(self) -> u8 {
        match self {
            ChunkType::U32 => 3,
            ChunkType::U64 => 4,
            ChunkType::I32 => 7,
            ChunkType::F32 => 9,
            ChunkType::F64 => 10,
        }
    }
}

/// Size in bytes of the numbers of a type by its code, and how they are read.
fn decode(code: u8, bytes: &[u8]) -> Option<Vec<f64>> {
    macro_rules! read {
        ($kind:ty) => {
            bytes
                .chunks_exact(size_of::<$kind>())
                .filter_map(|b| Some(<$kind>::from_le_bytes(b.try_into().ok()?) as f64))
                .collect()
        };
    }
    Some(match code {
        1 => read!(u8),
        2 => read!(u16),
        3 => read!(u32),
        4 => read!(u64),
        5 => read!(i8),
        6 => read!(i16),
        7 => read!(i32),
        8 => read!(i64),
        9 => read!(f32),
        10 => read!(f64),
        _ => return None,
    })
}

fn width(code: u8) -> Option<u64> {
    Some(match code {
        1 | 5 | 11 => 1,
        2 | 6 => 2,
        3 | 7 | 9 => 4,
        4 | 8 | 10 => 8,
        _ => return None,
    })
}

/// One chunk of the index.
struct Entry {
    rows: u64,
    columns: u64,
    location: u64,
    code: u8,
}

/// An opened file.
pub(super) struct File {
    path: PathBuf,
    bytes: Vec<u8>,
    /// Chunks by frame and name.
    chunks: BTreeMap<(u64, String), Entry>,
    frames: u64,
    /// Bytes that may still be read of its chunks.
    left: Cell<u64>,
}

impl File {
    pub(super) fn open(path: &Path) -> Result<File> {
        let bytes = granum_core::input::read(path, LARGEST_INPUT).map_err(Error::file("read", path))?;
        let left = Cell::new(MOST_TIMES.saturating_mul(bytes.len() as u64).saturating_add(FREE));
        let mut file = File { path: path.to_path_buf(), bytes, chunks: BTreeMap::new(), frames: 0, left };
        file.read_index()?;
        Ok(file)
    }

    /// Number of frames.
    pub(super) fn frames(&self) -> u64 {
        self.frames
    }

    fn damaged(&self, what: &str) -> Error {
        Error::content(&self.path, format!("is no GSD file or is damaged: {what}"))
    }

    fn number(&self, at: u64) -> Result<u64> {
        let at = usize::try_from(at).unwrap_or(usize::MAX);
        let bytes = self.bytes.get(at..at.saturating_add(8)).and_then(|bytes| bytes.try_into().ok());
        bytes.map(u64::from_le_bytes).ok_or_else(|| self.damaged("it ends too early"))
    }

    fn part(&self, from: u64, length: u64) -> Result<&[u8]> {
        let end = from.checked_add(length).and_then(|end| usize::try_from(end).ok());
        let part = end.and_then(|end| self.bytes.get(usize::try_from(from).ok()?..end));
        part.ok_or_else(|| self.damaged("a part lies beyond its end"))
    }

    fn read_index(&mut self) -> Result<()> {
        if !self.bytes.starts_with(&MAGIC) || self.bytes.len() < HEADER {
            return Err(self.damaged("it does not begin as one"));
        }
        let (index, entries, list, names) =
            (self.number(8)?, self.number(16)?, self.number(24)?, self.number(32)?);
        let version = (self.number(40)? >> 32) as u32 >> 16;
        if version > 2 {
            return Err(self.damaged(&format!("version {version} of the layout is not known")));
        }
        let list = self.part(list, names.saturating_mul(NAME as u64))?;
        let text = |bytes: &[u8]| {
            String::from_utf8_lossy(bytes.split(|b| *b == 0).next().unwrap_or(&[])).into_owned()
        };
        let names: Vec<String> = if version < 2 {
            list.chunks(NAME).map(text).collect()
        } else {
            list.split(|b| *b == 0).map(text).take_while(|name| !name.is_empty()).collect()
        };
        let index = self.part(index, entries.saturating_mul(ENTRY as u64))?.to_vec();
        for entry in index.chunks_exact(ENTRY) {
            let long = |at: usize| entry[at..at + 8].try_into().map(u64::from_le_bytes).unwrap_or(0);
            let location = long(16);
            // The index has free places at its end.
            if location == 0 {
                break;
            }
            let columns = entry[24..28].try_into().map(u32::from_le_bytes).unwrap_or(0);
            let name = entry[28..30].try_into().map(u16::from_le_bytes).unwrap_or(0);
            let Some(name) = names.get(usize::from(name)) else {
                return Err(self.damaged("a chunk has no name"));
            };
            let chunk = Entry { rows: long(8), columns: u64::from(columns), location, code: entry[30] };
            self.chunks.insert((long(0), name.clone()), chunk);
            self.frames = self.frames.max(long(0).saturating_add(1));
        }
        if self.frames > self.chunks.len() as u64 {
            return Err(self.damaged("it has more frames than chunks"));
        }
        Ok(())
    }

    /// The numbers of a chunk of a frame, or else of the first frame; none if neither has it.
    pub(super) fn numbers(&self, frame: u64, name: &str) -> Result<Option<Vec<f64>>> {
        let chunk = |frame: u64| self.chunks.get(&(frame, name.to_string()));
        let Some(chunk) = chunk(frame).or_else(|| chunk(0)) else { return Ok(None) };
        let Some(width) = width(chunk.code) else {
            return Err(self.damaged("the type of a chunk is not known"));
        };
        let length = chunk.rows.saturating_mul(chunk.columns).saturating_mul(width);
        let Some(left) = self.left.get().checked_sub(length) else {
            return Err(self.damaged("its frames hold far more numbers than its bytes"));
        };
        self.left.set(left);
        let bytes = self.part(chunk.location, length)?;
        decode(chunk.code, bytes).map(Some).ok_or_else(|| self.damaged("a chunk holds no numbers"))
    }
}

/// Puts a file together in memory.
pub(super) struct Writer {
    data: Vec<u8>,
    names: Vec<String>,
    /// Frame, rows, columns, place in `data`, name and type of each chunk.
    entries: Vec<(u64, u64, u32, usize, u16, u8)>,
    frame: u64,
}

impl Writer {
    pub(super) fn new() -> Writer {
        Writer { data: Vec::new(), names: Vec::new(), entries: Vec::new(), frame: 0 }
    }

    /// Adds a chunk of rows of `columns` numbers to the present frame.
    pub(super) fn chunk(&mut self, name: &str, kind: ChunkType, columns: u32, values: &[f64]) {
        let known = self.names.iter().position(|known| known == name);
        let id = known.unwrap_or_else(|| {
            self.names.push(name.to_string());
            self.names.len() - 1
        });
        let place = self.data.len();
        for value in values {
            match kind {
                ChunkType::U32 => self.data.extend((*value as u32).to_le_bytes()),
                ChunkType::U64 => self.data.extend((*value as u64).to_le_bytes()),
                ChunkType::I32 => self.data.extend((*value as i32).to_le_bytes()),
                ChunkType::F32 => self.data.extend((*value as f32).to_le_bytes()),
                ChunkType::F64 => self.data.extend(value.to_le_bytes()),
            }
        }
        let rows = values.len() as u64 / u64::from(columns.max(1));
        self.entries.push((self.frame, rows, columns, place, id as u16, kind.code()));
    }

    pub(super) fn end_frame(&mut self) {
        self.frame += 1;
    }

    /// The bytes of the file: header, names, index, chunks.
    pub(super) fn finish(mut self) -> Vec<u8> {
        // Readers search the index, whose entries must stand in the order of frames and, in a frame, of names.
        self.entries.sort_by_key(|entry| (entry.0, entry.4));
        let mut list: Vec<u8> = self.names.iter().flat_map(|name| name.bytes().chain([0])).collect();
        list.push(0);
        list.resize(list.len().div_ceil(NAME) * NAME, 0);
        let (names_at, index_at) = (HEADER, HEADER + list.len());
        // One free place marks the end of the index.
        let places = self.entries.len() + 1;
        let data_at = index_at + places * ENTRY;
        let mut file = Vec::with_capacity(data_at + self.data.len());
        file.extend(MAGIC);
        for number in [index_at as u64, places as u64, names_at as u64, (list.len() / NAME) as u64] {
            file.extend(number.to_le_bytes());
        }
        // Schema hoomd 1.4, layout 2.0: major number in the upper half.
        file.extend((1u32 << 16 | 4).to_le_bytes());
        file.extend((2u32 << 16).to_le_bytes());
        for text in ["granum", "hoomd"] {
            let mut bytes = text.as_bytes().to_vec();
            bytes.resize(NAME, 0);
            file.extend(bytes);
        }
        file.resize(HEADER, 0);
        file.extend(list);
        for (frame, rows, columns, place, name, code) in &self.entries {
            file.extend(frame.to_le_bytes());
            file.extend(rows.to_le_bytes());
            file.extend(((data_at + place) as u64).to_le_bytes());
            file.extend(columns.to_le_bytes());
            file.extend(name.to_le_bytes());
            file.extend([*code, 0]);
        }
        file.resize(data_at, 0);
        file.extend(self.data);
        file
    }
}
