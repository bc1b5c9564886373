//! The bonds of a snapshot, where there are any: a file of their own, `NAME.bonds`, in JSON.

use std::path::Path;

use granum_core::assembly::{Assembly, Bond, BrokenBond};
use serde::{Deserialize, Serialize};

use crate::atomic::write_atomically;
use crate::error::{Error, Result};

/// End of the name of the file.
pub(crate) const FILE: &str = "bonds";
/// Largest file that is read, bytes: some million bonds.
const LARGEST: u64 = 1 << 31;

/// What the file holds: the bonds that hold and those that ruptured.
#[derive(Serialize, Deserialize)]
struct Bonds {
    bonds: Vec<Bond>,
    broken_bonds: Vec<BrokenBond>,
}

/// Writes the bonds of an assembly; without any, the file of an earlier snapshot is removed.
pub(super) fn write(path: &Path, assembly: &Assembly) -> Result<()> {
    if !assembly.is_bonded() {
        let _ = std::fs::remove_file(path);
        return Ok(());
    }
    let bonds = Bonds { bonds: assembly.bonds.clone(), broken_bonds: assembly.broken_bonds.clone() };
    write_atomically(path, |file| serde_json::to_writer(file, &bonds).map_err(std::io::Error::from))
}

/// Reads the bonds of a snapshot, if it has any.
pub(super) fn read(path: &Path, assembly: &mut Assembly) -> Result<()> {
    if !path.is_file() {
        return Ok(());
    }
    let text = crate::text::read_small(path, LARGEST)?;
    let damaged = |error: serde_json::Error| Error::content(path, format!("is damaged: {error}"));
    let bonds: Bonds = serde_json::from_str(&text).map_err(damaged)?;
    let pieces = assembly.pieces.len();
    if let Some(bond) = bonds.bonds.iter().find(|bond| bond.i.max(bond.j) >= pieces) {
        let message =
            format!("the bond {} joins pieces that the snapshot does not have; there are {pieces}", bond.id);
        return Err(Error::content(path, message));
    }
    (assembly.bonds, assembly.broken_bonds) = (bonds.bonds, bonds.broken_bonds);
    Ok(())
}

#[cfg(test)]
mod tests {
    use granum_core::assembly::Sphere;

    use super::*;
    use crate::snapshot::{read_snapshot, write_snapshot};

    #[test]
    fn bonds_are_read_as_they_were_written_and_impossible_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let sphere =
            |id, x| Sphere { id, position: [x, 0.5, 0.5], radius: 0.1, mass: 1.0, ..Sphere::default() };
        let cell = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut bonded =
            Assembly { cell, ..Assembly::default() }.with_spheres([sphere(1, 0.3), sphere(2, 0.5)]);
        bonded.bonds = vec![Bond { id: 3, i: 0, j: 1, energy: 0.1 + 0.2, ..Bond::default() }];
        write_snapshot(folder.path(), "start", &bonded).unwrap();
        assert_eq!(read_snapshot(folder.path(), "start").unwrap(), bonded);
        let path = folder.path().join("start.bonds");
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, text.replace("\"j\":1", "\"j\":7")).unwrap();
        let refused = read_snapshot(folder.path(), "start").unwrap_err().to_string();
        assert!(refused.contains("start.bonds") && refused.contains("the bond 3 joins pieces"), "{refused}");
        // A snapshot without bonds leaves none behind.
        bonded.bonds.clear();
        write_snapshot(folder.path(), "start", &bonded).unwrap();
        assert_eq!(read_snapshot(folder.path(), "start").unwrap(), bonded);
    }
}
