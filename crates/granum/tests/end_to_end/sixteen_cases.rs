//! Sixteen cases of spheres of all kinds, two of grains of other shapes, two with bonds that rupture, and one that names a mesh, an image, a
//! sieve curve and a history in files beside it, keep the bits of their runs, from one version to the next and from one machine to another.
//!
//! The cases lie beside this file; `digests.txt` has the digest of each run. A change that must alter them says so in CHANGELOG.md, with the
//! reason, and writes the file anew: the test prints what it should hold.

use super::{digest, done};

/// The files that one of the cases names.
const FILES: [(&str, &[u8]); 4] = [
    ("files-of-the-case.obj", include_bytes!("sixteen_cases/files-of-the-case.obj")),
    ("files-of-the-case.tif", include_bytes!("sixteen_cases/files-of-the-case.tif")),
    ("files-of-the-case-sieve.csv", include_bytes!("sixteen_cases/files-of-the-case-sieve.csv")),
    ("files-of-the-case-history.csv", include_bytes!("sixteen_cases/files-of-the-case-history.csv")),
];

/// The name of each case and its text.
macro_rules! cases {
    ($($name:literal,)*) => {
        [$(($name, include_str!(concat!("sixteen_cases/", $name, ".toml")))),*]
    };
}

const CASES: [(&str, &str); 21] = cases![
    "bridges-of-constant-volume",
    "bridges-that-share-films",
    "cemented-grains",
    "contacts-that-peel",
    "drained-cycles-with-twisting",
    "drained-triaxial",
    "elastic-plastic-grains",
    "files-of-the-case",
    "grains-of-three-shapes",
    "grains-that-crush",
    "history-of-strains",
    "mean-stress-of-the-paper",
    "powder-at-constant-mean-stress",
    "powder-oedometer",
    "simple-shear",
    "sticky-dimers-in-layers",
    "true-triaxial",
    "two-materials",
    "undrained-cycles-with-rolling",
    "undrained-triaxial",
    "van-der-waals",
];

#[test]
fn sixteen_cases_keep_their_bits() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    for (name, content) in FILES {
        std::fs::write(place.join(name), content).unwrap();
    }
    let mut digests = String::new();
    for (name, text) in CASES {
        let file = format!("{name}.toml");
        std::fs::write(place.join(&file), text).unwrap();
        done(place, &["run", &file, "--out", name]);
        digests += &format!("{}  {name}\n", digest(place, name));
    }
    assert_eq!(digests, include_str!("sixteen_cases/digests.txt"), "digests.txt should be\n{digests}");
}
