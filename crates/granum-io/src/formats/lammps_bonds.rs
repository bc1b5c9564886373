//! The section `Bonds` of a LAMMPS data file: rows `id type atom1 atom2`.

use std::collections::HashSet;
use std::io::Write;
use std::path::Path;

use super::atoms::Atom;
use super::file_bond::FileBond;
use super::words::Words;
use crate::error::{Error, Result};
use crate::packing::PackedBond;

/// What the header says of bonds.
#[derive(Default)]
pub(super) struct BondHeader {
    /// Their number, where the header has it.
    pub(super) bonds: Option<usize>,
    /// The number of their types, where the header has it.
    pub(super) types: Option<usize>,
}

/// Reads the rows after the heading.
pub(super) fn read(words: &mut Words, header: &BondHeader) -> Result<Vec<FileBond>> {
    let Some(count) = header.bonds else {
        return Err(words.error(
            "the section Bonds needs a line \"N bonds\" before the sections, which says how many follow",
        ));
    };
    let mut bonds = Vec::with_capacity(count.min(1 << 20));
    while bonds.len() < count {
        words.need("a bond")?;
        let length = words.words().take_while(|word| !word.starts_with('#')).count();
        if length == 0 {
            continue;
        }
        if length != 4 {
            let message = format!("the row has {length} words; a bond has id type atom1 atom2, 4 in all");
            return Err(words.error(message));
        }
        let kind = words.whole(1, "type of the bond")?;
        let most = header.types.map_or(u64::from(u32::MAX), |types| types as u64);
        if !(1..=most).contains(&kind) {
            return Err(words.word_error(
                1,
                format!("type of the bond = {kind} must be from 1 to {most}, the number of bond types"),
            ));
        }
        bonds.push(FileBond {
            first: words.whole(2, "atom1")?,
            second: words.whole(3, "atom2")?,
            kind: kind as u32,
            line: words.line_number(),
        });
    }
    Ok(bonds)
}

/// Refuses bonds that the rows cannot tell apart: a row names two atoms and no image of the cell.
pub(super) fn check(path: &Path, bonds: &[PackedBond]) -> Result<()> {
    let mut seen = HashSet::with_capacity(bonds.len());
    for bond in bonds {
        let [i, j] = bond.pieces;
        if !seen.insert([i.min(j), i.max(j)]) {
            let message = format!(
                "the spheres {} and {} are bonded twice, across different faces of the cell, which a LAMMPS data file cannot say: take a larger \
                 cell",
                i + 1,
                j + 1
            );
            return Err(Error::content(path, message));
        }
    }
    Ok(())
}

/// Writes the numbers of bonds and of their types.
pub(super) fn write_header(file: &mut dyn Write, bonds: &[PackedBond]) -> std::io::Result<()> {
    let types = bonds.iter().map(|bond| bond.kind).max().unwrap_or(1);
    writeln!(file, "{} bonds\n{types} bond types", bonds.len())
}

/// Writes the section.
pub(super) fn write(file: &mut dyn Write, bonds: &[PackedBond], atoms: &[Atom]) -> std::io::Result<()> {
    writeln!(file, "\nBonds\n")?;
    for (k, bond) in bonds.iter().enumerate() {
        if let [Some(one), Some(two)] = bond.pieces.map(|piece| atoms.get(piece)) {
            writeln!(file, "{} {} {} {}", k + 1, bond.kind.max(1), one.id, two.id)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use granum_core::Part;
    use granum_core::assembly::{Assembly, Bond, Piece, Rigid, Sphere};

    use super::*;
    use crate::formats::{Formats, JoinOptions, ObservedAssembly, ReadOptions};

    const HEAD: &str = "a comment\n\n4 atoms\n1 atom types\n3 bonds\n2 bond types\n\n0 10 xlo xhi\n0 10 ylo yhi\n0 10 zlo zhi\n";

    fn read(path: &Path) -> Result<ObservedAssembly> {
        let files = [(path.to_path_buf(), ReadOptions::default())];
        Ok(Formats::standard().read_results(&files, &JoinOptions::default())?.remove(0))
    }

    fn read_text(text: &str) -> Result<ObservedAssembly> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bonded.data");
        std::fs::write(&path, text).unwrap();
        read(&path)
    }

    /// Four spheres in a row, of which the second and third are one molecule.
    fn row(bonds: &str) -> String {
        format!(
            "{HEAD}\nAtoms # bpm/sphere\n\n7 1 1 1.0 2.0 1.5 5 5\n8 2 1 1.0 2.0 2.5 5 5\n9 2 1 1.0 2.0 3.5 5 5\n10 3 1 1.0 2.0 0.5 5 5\n\
             \nBonds\n\n{bonds}"
        )
    }

    #[test]
    fn pairs_are_read_and_molecules_with_bonds_inside_are_no_bodies() {
        let found = read_text(&row("1 1 7 8\n2 2 9 8 # a remark\n\n3 1 10 7\n")).unwrap();
        let bond = |pieces, kind| PackedBond { pieces, kind };
        assert_eq!(found.listed_bonds, [bond([0, 1], 1), bond([2, 1], 2), bond([3, 0], 1)]);
        assert!(found.assembly.all_spheres() && found.assembly.bodies.len() == 4);
        let packing = found.packing(Path::new("bonded.data")).unwrap();
        assert_eq!(packing.bonds, found.listed_bonds);
        // A molecule without bonds inside is a rigid grain, and its spheres are numbered as pieces.
        let rigid = read_text(&row("1 1 7 8\n2 2 9 10\n3 1 10 7\n")).unwrap();
        assert_eq!((rigid.assembly.bodies.len(), rigid.assembly.pieces.len()), (3, 4));
        assert_eq!(rigid.listed_bonds, [bond([0, 1], 1), bond([2, 3], 2), bond([3, 0], 1)]);
    }

    #[test]
    fn what_is_wrong_with_bonds_is_said_with_its_line() {
        let said = |text: String| read_text(&text).unwrap_err().to_string();
        let told = said(row("1 1 7 8\n2 2 9 8\n3 1 10 12\n"));
        assert!(told.contains("bonded.data:23") && told.contains("names the atom 12"), "{told}");
        assert!(said(row("1 1 7 8\n2 2 8 7\n3 1 10 7\n")).contains("bonded already in line 21"));
        assert!(said(row("1 1 7 8\n2 2 8 8\n3 1 10 7\n")).contains("joins the atom 8 with itself"));
        assert!(
            said(row("1 1 7 8\n2 3 9 8\n3 1 10 7\n")).contains("type of the bond = 3 must be from 1 to 2")
        );
        assert!(
            said(row("1 1 7 8\n2 1 9 8 10\n3 1 10 7\n"))
                .contains("the row has 5 words; a bond has id type atom1 atom2")
        );
        assert!(said(row("1 1 7 8\n")).contains("the file ends where a bond should follow"));
        assert!(said(row("").replace("3 bonds\n", "")).contains("needs a line \"N bonds\""));
        assert!(
            said(row("").replace("\nBonds\n\n", "")).contains("announces 3 bonds, but has no section Bonds")
        );
    }

    /// Two spheres and a dimer in a sheared cell come back with their bonds.
    #[test]
    fn a_bonded_assembly_comes_back_with_the_same_pairs() {
        let sphere =
            |id, x| Sphere { id, position: [x, 4.0, 4.0], radius: 0.5, mass: 1.0, ..Sphere::default() };
        let cell = [[8.0, 1.0, 0.0], [0.0, 8.0, 0.0], [0.0, 0.0, 8.0]];
        let mut assembly = Assembly { cell, ..Assembly::default() }.with_spheres([
            sphere(1, 2.0),
            sphere(2, 3.5),
            sphere(3, 5.0),
        ]);
        assembly.bodies[1].rigid = Some(0);
        assembly.rigid =
            vec![Rigid { orientation: granum_core::rotation::IDENTITY, inertia: [0.1, 0.3, 0.3] }];
        let piece =
            |x: f64| Piece { body: 1, position: [3.5 + x, 4.0, 4.0], radius: 0.5, arm: [x, 0.0, 0.0] };
        assembly.pieces.splice(1..2, [piece(-0.5), piece(0.5)]);
        assembly.pieces[3].body = 2;
        let bond = |id, i, j| Bond { id, i, j, ..Bond::default() };
        assembly.bonds = vec![bond(0, 0, 1), bond(1, 3, 2)];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bonded.data");
        let parts = granum_core::Parts::new(&[Part::Cell, Part::Positions, Part::Radii, Part::Masses]);
        let written = ObservedAssembly::new(assembly, parts, [0.0; 3]);
        let formats = Formats::standard();
        formats.write_assemblies(&path, None, vec![written.clone()], &path).unwrap();
        let found = read(&path).unwrap();
        assert_eq!(found.bonded_pairs(), written.bonded_pairs());
        assert_eq!((found.assembly.bodies.len(), found.assembly.pieces.len()), (3, 4));
        // Types stay what they are through another file; a pair that is bonded across two faces cannot be said.
        let mut again = found.clone();
        again.listed_bonds[1].kind = 4;
        formats.write_assemblies(&path, None, vec![again.clone()], &path).unwrap();
        assert_eq!(read(&path).unwrap().listed_bonds, again.listed_bonds);
        again.listed_bonds.push(PackedBond { pieces: [1, 0], kind: 1 });
        let told = formats.write_assemblies(&path, None, vec![again], &path).err().unwrap().to_string();
        assert!(told.contains("the spheres 2 and 1 are bonded twice"), "{told}");
    }
}
