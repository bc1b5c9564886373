//! HDF5, written: groups, arrays of doubles, and lists of texts as attributes. Nothing of this is read here.
//!
//! The file has the layout of HDF5 1.8 (superblock 2, object headers 2, links in the header of their group, contiguous arrays), which every
//! later version reads. Nothing in it depends on time or machine: equal trees give equal bytes. Source: HDF5 File Format Specification,
//! version 3.0 (The HDF Group).

mod checksum;

use std::io::Write;
use std::path::Path;

use self::checksum::lookup3;
use crate::atomic::write_atomically;
use crate::error::{Error, Result};

const SIGNATURE: &[u8] = b"\x89HDF\r\n\x1a\n";
/// Length of the superblock.
const SUPERBLOCK: usize = 48;
/// An address that is not there.
const NOWHERE: u64 = u64::MAX;
/// Longest name of a group, an array or an attribute.
const LONGEST_NAME: usize = 255;
/// A header of an object holds messages of at most so many bytes.
const LONGEST_MESSAGE: usize = u16::MAX as usize;
/// Smallest size of a collection of texts.
const SMALLEST_HEAP: usize = 4096;

/// A group or an array.
#[derive(Clone, Debug, PartialEq)]
pub enum Node {
    /// Named groups and arrays.
    Group(Group),
    /// Numbers.
    Array(Array),
}

/// Named groups and arrays, with attributes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Group {
    /// Names with lists of texts.
    pub attributes: Vec<(String, Vec<String>)>,
    /// What is in the group.
    pub children: Vec<(String, Node)>,
}

/// Numbers in any number of dimensions, the last one running fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Array {
    /// Size in each dimension.
    pub shape: Vec<usize>,
    /// The numbers, as many as the product of the sizes.
    pub values: Vec<f64>,
}

/// Writes a file under a temporary name and renames it.
///
/// # Errors
/// [`Error::Rule`] for a name that is empty, too long or no ASCII text, an attribute that is too long, or an array whose values do not
/// fill its shape; [`Error::File`] if the file cannot be written.
pub fn write(path: &Path, root: &Group) -> Result<()> {
    let bytes = encode(root)?;
    write_atomically(path, |file| file.write_all(&bytes))
}

fn encode(root: &Group) -> Result<Vec<u8>> {
    let mut file = vec![0; SUPERBLOCK];
    let address = put_group(&mut file, root)?;
    let mut head = SIGNATURE.to_vec();
    // Version, sizes of addresses and of lengths, flags.
    head.extend([2, 8, 8, 0]);
    for address in [0, NOWHERE, file.len() as u64, address] {
        head.extend(address.to_le_bytes());
    }
    head.extend(lookup3(&head).to_le_bytes());
    file[..SUPERBLOCK].copy_from_slice(&head);
    Ok(file)
}

/// Adds a group with all that is in it; returns the address of its header.
fn put_group(file: &mut Vec<u8>, group: &Group) -> Result<u64> {
    let mut links = Vec::new();
    for (name, child) in &group.children {
        let address = match child {
            Node::Group(inner) => put_group(file, inner)?,
            Node::Array(array) => put_array(file, name, array)?,
        };
        links.push((name, address));
    }
    let mut messages = Vec::new();
    let mut info = vec![0, 0];
    info.extend(NOWHERE.to_le_bytes());
    info.extend(NOWHERE.to_le_bytes());
    put_message(&mut messages, 0x02, &info)?;
    put_message(&mut messages, 0x0a, &[0, 0])?;
    for (name, address) in links {
        check_name(name)?;
        let mut link = vec![1, 0, name.len() as u8];
        link.extend(name.as_bytes());
        link.extend(address.to_le_bytes());
        put_message(&mut messages, 0x06, &link)?;
    }
    for (name, texts) in &group.attributes {
        let attribute = attribute(file, name, texts)?;
        put_message(&mut messages, 0x0c, &attribute)?;
    }
    Ok(put_header(file, &messages))
}

fn put_array(file: &mut Vec<u8>, name: &str, array: &Array) -> Result<u64> {
    let count: usize = array.shape.iter().product();
    if count != array.values.len() || array.shape.is_empty() || array.shape.len() > 32 {
        let (shape, values) = (&array.shape, array.values.len());
        return Err(Error::Rule(format!("the array {name} of shape {shape:?} has {values} values")));
    }
    align(file);
    let address = if count == 0 { NOWHERE } else { file.len() as u64 };
    array.values.iter().for_each(|value| file.extend(value.to_le_bytes()));
    let mut messages = Vec::new();
    put_message(&mut messages, 0x01, &dataspace(&array.shape))?;
    put_message(&mut messages, 0x03, &double())?;
    // Version 3; space is allocated late, and the fill value is written if it is set, which it is not.
    put_message(&mut messages, 0x05, &[3, 0x0a])?;
    let mut layout = vec![3, 1];
    layout.extend(address.to_le_bytes());
    layout.extend((8 * count as u64).to_le_bytes());
    put_message(&mut messages, 0x08, &layout)?;
    Ok(put_header(file, &messages))
}

/// Every object begins at a multiple of eight bytes.
fn align(file: &mut Vec<u8>) {
    file.resize(file.len().next_multiple_of(8), 0);
}

fn put_message(messages: &mut Vec<u8>, kind: u8, body: &[u8]) -> Result<()> {
    if body.len() > LONGEST_MESSAGE {
        return Err(Error::Rule("an attribute is too long for a file of HDF5".into()));
    }
    messages.push(kind);
    messages.extend((body.len() as u16).to_le_bytes());
    messages.push(0);
    messages.extend(body);
    Ok(())
}

/// Adds the header of an object; returns its address.
fn put_header(file: &mut Vec<u8>, messages: &[u8]) -> u64 {
    align(file);
    let address = file.len();
    file.extend(b"OHDR");
    // Version 2; the length of the messages has four bytes.
    file.extend([2, 0x02]);
    file.extend((messages.len() as u32).to_le_bytes());
    file.extend(messages);
    let sum = lookup3(&file[address..]);
    file.extend(sum.to_le_bytes());
    address as u64
}

fn dataspace(shape: &[usize]) -> Vec<u8> {
    // Version 2, rank, no largest sizes, a simple space.
    let mut bytes = vec![2, shape.len() as u8, 0, 1];
    shape.iter().for_each(|size| bytes.extend((*size as u64).to_le_bytes()));
    bytes
}

/// The type of a little-endian double.
fn double() -> Vec<u8> {
    let mut bytes = vec![0x11, 0x20, 63, 0];
    bytes.extend(8u32.to_le_bytes());
    bytes.extend([0, 0, 64, 0, 52, 11, 0, 52]);
    bytes.extend(1023u32.to_le_bytes());
    bytes
}

/// The type of a text of any length in UTF-8.
fn text() -> Vec<u8> {
    let mut bytes = vec![0x19, 0x01, 0x01, 0];
    bytes.extend(16u32.to_le_bytes());
    // Made of characters of one byte.
    bytes.extend([0x13, 0x10, 0, 0]);
    bytes.extend(1u32.to_le_bytes());
    bytes
}

/// A list of texts as an attribute. The texts themselves are in a collection of their own.
fn attribute(file: &mut Vec<u8>, name: &str, texts: &[String]) -> Result<Vec<u8>> {
    check_name(name)?;
    align(file);
    let heap = file.len() as u64;
    let mut objects = Vec::new();
    for (k, text) in texts.iter().enumerate() {
        objects.extend((k as u16 + 1).to_le_bytes());
        // Number of references, reserved.
        objects.extend([1, 0, 0, 0, 0, 0]);
        objects.extend((text.len() as u64).to_le_bytes());
        objects.extend(text.as_bytes());
        align(&mut objects);
    }
    // Free space has a head of 16 bytes, or is none at all.
    let size = (16 + objects.len() + 16).max(SMALLEST_HEAP);
    file.extend(b"GCOL");
    file.extend([1, 0, 0, 0]);
    file.extend((size as u64).to_le_bytes());
    file.extend(&objects);
    let free = size - 16 - objects.len();
    file.extend([0; 8]);
    file.extend((free as u64).to_le_bytes());
    file.resize(heap as usize + size, 0);
    let (kind, space) = (text(), dataspace(&[texts.len()]));
    let mut bytes = vec![3, 0];
    for length in [name.len() + 1, kind.len(), space.len()] {
        bytes.extend((length as u16).to_le_bytes());
    }
    // The name is ASCII.
    bytes.push(0);
    bytes.extend(name.as_bytes());
    bytes.push(0);
    bytes.extend(kind);
    bytes.extend(space);
    for (k, text) in texts.iter().enumerate() {
        bytes.extend((text.len() as u32).to_le_bytes());
        bytes.extend(heap.to_le_bytes());
        bytes.extend((k as u32 + 1).to_le_bytes());
    }
    Ok(bytes)
}

fn check_name(name: &str) -> Result<()> {
    let plain =
        !name.is_empty() && name.is_ascii() && !name.contains(['/', '\0']) && name.len() <= LONGEST_NAME;
    if plain { Ok(()) } else { Err(Error::Rule(format!("{name:?} cannot be a name in a file of HDF5"))) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tree() -> Group {
        let array = Array { shape: vec![2, 3], values: vec![0.0, 1.0, 2.0, -3.5, f64::NAN, 1e300] };
        let inner = Group { children: vec![("inputs".into(), Node::Array(array))], ..Group::default() };
        Group {
            attributes: vec![("outputs".into(), vec!["void_ratio".into(), String::new(), "a b".into()])],
            children: vec![("100000".into(), Node::Group(inner))],
        }
    }

    /// What the format's specification says of the parts of a file. A test of the program reads such a file with h5py.
    #[test]
    fn the_parts_of_a_file_are_where_they_say() {
        let bytes = encode(&tree()).unwrap();
        assert_eq!(encode(&tree()).unwrap(), bytes);
        let number = |at: usize| u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize;
        assert_eq!(&bytes[..8], SIGNATURE);
        assert_eq!(number(28), bytes.len());
        assert_eq!(bytes[44..48], lookup3(&bytes[..44]).to_le_bytes());
        let root = number(36);
        assert_eq!(&bytes[root..root + 4], b"OHDR");
        let length = u32::from_le_bytes(bytes[root + 6..root + 10].try_into().unwrap()) as usize;
        let end = root + 10 + length;
        assert_eq!(bytes[end..end + 4], lookup3(&bytes[root..end]).to_le_bytes());
        assert_eq!(end + 4, bytes.len());
    }

    #[test]
    fn what_cannot_be_written_is_refused() {
        let with = |name: &str, array: Array| {
            encode(&Group { children: vec![(name.into(), Node::Array(array))], ..Group::default() })
        };
        let message = |name: &str, array: Array| with(name, array).unwrap_err().to_string();
        let one = || Array { shape: vec![1], values: vec![1.0] };
        assert!(message("a/b", one()).contains("\"a/b\" cannot be a name"));
        let short = Array { shape: vec![2, 2], values: vec![1.0] };
        assert!(message("x", short).contains("array x of shape [2, 2] has 1 values"));
        assert!(with("x", Array { shape: vec![0, 4], values: Vec::new() }).is_ok());
    }
}
