//! Damaged meshes and images: whatever the bytes are, a file is a body or is refused by its name.

use std::path::Path;

use proptest::prelude::*;
use proptest::sample::Index;

use crate::mesh::tests::{binary_stl, ellipsoid, obj, ply, text_stl};
use crate::voxels::tests::{stack, write};
use crate::{mesh, voxels};

/// A change of some bytes of a file.
#[derive(Clone, Debug)]
enum Damage {
    /// A byte becomes another.
    Byte(Index, u8),
    /// The file ends here.
    End(Index),
    /// Bytes from here on are missing.
    Missing(Index, usize),
    /// Some bytes come again.
    Again(Index, usize),
    /// A word or a number of eight bytes stands here.
    Word(Index, &'static [u8]),
}

const WORDS: [&[u8]; 12] = [
    b"nan",
    b"-1",
    b"1e400",
    b"1e308",
    b"99999999999999999999",
    b"\n",
    b" 4294967295 ",
    b"end_header\n",
    b"f 1 1 1\n",
    &[0xff; 8],
    &[0; 8],
    &[0, 0, 0, 0, 0, 0, 0xf0, 0x7f],
];

fn damage() -> impl Strategy<Value = Damage> {
    let place = || any::<Index>();
    prop_oneof![
        (place(), any::<u8>()).prop_map(|(at, byte)| Damage::Byte(at, byte)),
        place().prop_map(Damage::End),
        (place(), 1usize..40).prop_map(|(at, count)| Damage::Missing(at, count)),
        (place(), 1usize..400).prop_map(|(at, count)| Damage::Again(at, count)),
        (place(), prop::sample::select(&WORDS[..])).prop_map(|(at, word)| Damage::Word(at, word)),
    ]
}

fn damaged(whole: &[u8], all: &[Damage]) -> Vec<u8> {
    let mut bytes = whole.to_vec();
    for damage in all.iter().filter(|_| !whole.is_empty()) {
        if bytes.is_empty() {
            break;
        }
        let end = |at: usize, count: usize| (at + count).min(bytes.len());
        match damage {
            Damage::Byte(at, byte) => {
                let at = at.index(bytes.len());
                bytes[at] = *byte;
            }
            Damage::End(at) => bytes.truncate(at.index(bytes.len())),
            Damage::Missing(at, count) => {
                let at = at.index(bytes.len());
                let end = end(at, *count);
                drop(bytes.drain(at..end));
            }
            Damage::Again(at, count) => {
                let at = at.index(bytes.len());
                let again = bytes[at..end(at, *count)].to_vec();
                drop(bytes.splice(at..at, again));
            }
            Damage::Word(at, word) => {
                let at = at.index(bytes.len());
                let end = end(at, word.len());
                drop(bytes.splice(at..end, word.iter().copied()));
            }
        }
    }
    bytes
}

fn write_bytes(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap();
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_mesh_is_a_body_or_is_refused_by_its_name(
        kind in 0usize..4,
        damage in prop::collection::vec(damage(), 1..4),
    ) {
        let grain = ellipsoid([1.0, 0.75, 0.5], 1);
        let (name, whole) = match kind {
            0 => ("grain.stl", text_stl(&grain).into_bytes()),
            1 => ("grain.stl", binary_stl(&grain)),
            2 => ("grain.obj", obj(&grain).into_bytes()),
            _ => ("grain.ply", ply(&grain).into_bytes()),
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        write_bytes(&path, &damaged(&whole, &damage));
        match mesh::read(&path, &mut Vec::new()) {
            Ok(read) => {
                let found = mesh::moments(&read);
                prop_assert!(found.volume > 0.0 && found.volume.is_finite(), "a volume of {}", found.volume);
                prop_assert!(found.surface > 0.0 && found.centre.iter().all(|x| x.is_finite()));
            }
            Err(why) => {
                prop_assert_eq!(why.key, "file");
                prop_assert!(why.message.contains(name), "{}", why.message);
            }
        }
    }

    #[test]
    fn damaged_images_are_a_stack_or_are_refused_by_their_name(damage in prop::collection::vec(damage(), 1..4)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.tif");
        let ball = stack([9, 9, 9], [1.0; 3], |p| u32::from(p.iter().all(|x| (x - 4.5).abs() < 3.0)));
        write(&ball, &path, 8);
        let whole = std::fs::read(&path).unwrap();
        write_bytes(&path, &damaged(&whole, &damage));
        match voxels::read(&path) {
            Ok(read) => prop_assert_eq!(read.labels.len(), read.size.iter().product::<usize>()),
            Err(why) => {
                prop_assert_eq!(why.key, "file");
                prop_assert!(why.message.contains("grains.tif"), "{}", why.message);
            }
        }
    }
}
