//! The checks of the fuzz targets on the stable toolchain: all stored inputs and findings, and some thousand reproducible
//! mutations of the seeds.

#[path = "../../../../fuzz/src/checks.rs"]
mod checks;
#[path = "../../../../fuzz/src/seeds.rs"]
mod seeds;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Number of mutations of the seeds of a target.
const MUTATIONS: usize = 12_000;
/// Time limit for one small input; it is generous, because the tests may run on a busy computer.
const LONGEST: Duration = Duration::from_secs(10);

/// Checks an input; an input that fails is stored for inspection.
fn check(target: &str, check: fn(&[u8]), name: &str, input: &[u8]) {
    let start = Instant::now();
    if catch_unwind(AssertUnwindSafe(|| check(input))).is_err() {
        let file = std::env::temp_dir().join(format!("granum-find-{target}"));
        std::fs::write(&file, input).unwrap();
        panic!("{target}: {name} is a find, kept as {}", file.display());
    }
    assert!(start.elapsed() < LONGEST, "{target}: {name} took {:?}", start.elapsed());
}

fn kept(folder: &str, target: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz").join(folder).join(target);
    let Ok(entries) = std::fs::read_dir(folder) else { return Vec::new() };
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// Pseudo-random numbers from a seed (xorshift of Marsaglia).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound.max(1) as u64) as usize
    }
}

/// Byte sequences that have a meaning in one of the formats.
const TOKENS: [&[u8]; 16] = [
    b"nan",
    b"inf",
    b"1e308",
    b"-1",
    b"0",
    b"1e-320",
    b"99999999999",
    b"\n",
    b",",
    b"\"",
    b"null",
    b"[]",
    b"{}",
    &[0xff; 8],
    &[0; 8],
    &[0xff, 0xff, 0xff, 0xff, 0x0f],
];

fn mutated(seed: &[u8], other: &[u8], random: &mut Random) -> Vec<u8> {
    let mut bytes = seed.to_vec();
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len());
        let end = (at + 1 + random.below(12)).min(bytes.len());
        match random.below(7) {
            0 if !bytes.is_empty() => bytes[at] ^= 1 << random.below(8),
            1 if !bytes.is_empty() => bytes[at] = random.below(256) as u8,
            2 => drop(bytes.drain(at..end)),
            3 => {
                let token = TOKENS[random.below(TOKENS.len())];
                let end = if random.below(2) == 0 { at } else { (at + token.len()).min(bytes.len()) };
                drop(bytes.splice(at..end, token.iter().copied()));
            }
            4 => {
                let from = random.below(other.len());
                let to = (from + random.below(40)).min(other.len());
                drop(bytes.splice(at..at, other[from..to].iter().copied()));
            }
            5 => bytes.extend_from_within(at..end),
            _ => bytes.truncate(if random.below(8) == 0 { at } else { bytes.len() }),
        }
    }
    bytes
}

/// Runs a target on its stored inputs and on mutations of its seeds.
fn replay(target: &str) {
    let (_, work) = checks::ALL.into_iter().find(|(name, _)| *name == target).unwrap();
    let mut inputs = Vec::new();
    for file in ["corpus", "regressions"].into_iter().flat_map(|folder| kept(folder, target)) {
        let bytes = std::fs::read(&file).unwrap();
        check(target, work, &file.display().to_string(), &bytes);
        inputs.push(bytes);
    }
    let seeds = seeds::for_target(target);
    assert!(!seeds.is_empty());
    for (name, bytes) in &seeds {
        check(target, work, name, bytes);
    }
    inputs.extend(seeds.into_iter().map(|(_, bytes)| bytes));
    let mut random = Random(0x9e37_79b9_7f4a_7c15);
    for k in 0..MUTATIONS {
        let (one, two) = (random.below(inputs.len()), random.below(inputs.len()));
        let input = mutated(&inputs[one], &inputs[two], &mut random);
        check(target, work, &format!("mutation {k}"), &input);
    }
}

#[test]
fn cases() {
    replay("case");
}

#[test]
fn packings() {
    replay("packing");
}

#[test]
fn models() {
    replay("model");
}

#[test]
fn checkpoints() {
    replay("checkpoint");
}

#[test]
fn tables_as_csv() {
    replay("csv");
}

#[test]
fn tables_as_parquet() {
    replay("parquet");
}

#[test]
fn meshes() {
    replay("mesh");
}

#[test]
fn bonds() {
    replay("bonds");
}

#[test]
fn stacks_of_images() {
    replay("voxels");
}

/// The checks accept the seeds; otherwise the mutations would only test the first stage of reading a file.
#[test]
fn seeds_are_good() {
    for (name, bytes) in seeds::for_target("checkpoint") {
        let bytes = checks::with_header(&bytes);
        let (_, beside) = granum_dem::simulation::Simulation::restore(&bytes).unwrap();
        let known = granum_run::laboratory::check_beside(&beside, &checks::tested());
        assert!(beside.is_empty() || known.is_ok(), "{name}: {known:?}");
    }
    for (name, bytes) in seeds::for_target("parquet") {
        let table = granum_io::formats::parquet::read_bytes(bytes, &name, None).unwrap();
        assert!(table.rows() == 3 || table.rows() == 6, "{name}");
    }
    for (name, bytes) in seeds::for_target("packing") {
        assert!(granum_io::formats::packing_csv::read_from(&bytes[..], &name).is_ok(), "{name}");
    }
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in seeds::for_target("mesh") {
        let path = folder.path().join(&name);
        std::fs::write(&path, &bytes[1..]).unwrap();
        let mesh = granum_shape::mesh::read(&path, &mut Vec::new()).unwrap();
        assert!((granum_shape::mesh::moments(&mesh).volume - 6.0).abs() < 1e-9, "{name}");
    }
    for (name, bytes) in seeds::for_target("voxels") {
        let path = folder.path().join(&name);
        std::fs::write(&path, &bytes).unwrap();
        assert_eq!(granum_shape::voxels::read(&path).unwrap().labels, [0, 1, 1, 2, 0, 1, 1, 2], "{name}");
    }
    for (name, bytes) in seeds::for_target("bonds") {
        let read = match bytes[0] {
            b'K' => granum_dem::simulation::Simulation::restore(&checks::header(
                granum_dem::checkpoint::VERSION,
                &bytes[1..],
            ))
            .is_ok(),
            b'J' => checks::snapshot_of_a_pair(&bytes[1..]).is_ok(),
            _ => {
                let path = folder.path().join("grains.data");
                std::fs::write(&path, &bytes[1..]).unwrap();
                granum_io::formats::read_packing(&path).is_ok()
            }
        };
        assert!(read, "{name}");
    }
    for (name, bytes) in seeds::for_target("csv") {
        assert!(granum_io::formats::csv::read_from(&bytes[..], &name, None).is_ok(), "{name}");
    }
    for (name, bytes) in seeds::for_target("model").into_iter().filter(|(_, bytes)| bytes[0] != b'T') {
        let text = String::from_utf8(bytes).unwrap();
        assert!(granum_nets::Model::from_json(&text, &name).is_ok(), "{name}");
    }
}
