//! Bonds as a file lists them, by the ids of their spheres, held against the spheres that the file has.

use std::collections::HashMap;
use std::path::Path;

use granum_core::assembly::Body;

use super::file_bond::FileBond;
use super::remark::Remark;
use super::result::Frame;
use crate::error::{Result, in_file};
use crate::packing::PackedBond;
use crate::shell::ShowPath;

/// The bonds of a file between spheres, which are given in the order of their ids.
///
/// # Errors
/// [`crate::Error::Input`] with the line of a bond that names a sphere that is not there, one sphere twice, or a pair that is bonded already.
pub(super) fn identify(path: &Path, spheres: &[Body], bonds: &[FileBond]) -> Result<Vec<PackedBond>> {
    let wrong =
        |bond: &FileBond, message: String, help: &str| Err(in_file(&path.shown(), bond.line, message, help));
    let mut lines: HashMap<[usize; 2], usize> = HashMap::with_capacity(bonds.len());
    let mut found = Vec::with_capacity(bonds.len());
    for bond in bonds {
        let ids = [bond.first, bond.second];
        let places = ids.map(|id| spheres.binary_search_by_key(&id, |sphere| sphere.id));
        let [Ok(i), Ok(j)] = places else {
            let missing = if places[0].is_err() { bond.first } else { bond.second };
            let message = format!(
                "the bond between the atoms {} and {} names the atom {missing}, which is not there",
                ids[0], ids[1]
            );
            return wrong(bond, message, "a bond joins two of the atoms of the file, by their ids");
        };
        if i == j {
            let message = format!("the bond joins the atom {} with itself", bond.first);
            return wrong(bond, message, "a bond joins two different atoms");
        }
        if let Some(before) = lines.insert([i.min(j), i.max(j)], bond.line) {
            let place = if before == 0 { String::new() } else { format!(" in line {before}") };
            let message = format!("the atoms {} and {} are bonded already{place}", ids[0], ids[1]);
            return wrong(bond, message, "each pair is listed once, with one type");
        }
        found.push(PackedBond { pieces: [i, j], kind: bond.kind });
    }
    Ok(found)
}

/// Takes bodies whose spheres are bonded to each other as what they are: spheres that move by themselves.
pub(super) fn release_bonded_bodies(frame: &mut Frame) {
    let of = &frame.clump_of;
    let body_of = |bond: &FileBond| {
        let [one, two] = [bond.first, bond.second].map(|id| of.get(&id).copied());
        one.filter(|_| one == two)
    };
    let mut bonded: Vec<u64> = frame.bonds.iter().filter_map(body_of).collect();
    bonded.sort_unstable();
    bonded.dedup();
    if bonded.is_empty() {
        return;
    }
    let before = of.len();
    frame.clump_of.retain(|_, body| bonded.binary_search(body).is_err());
    let (count, column) = (bonded.len(), &frame.clump_column);
    let noun = if count == 1 { "body has" } else { "bodies have" };
    frame.remarks.push(Remark::set_right(format!(
        "{count} {noun} bonds inside ({column}): the {} spheres are grains of their own, which the bonds hold together",
        before - frame.clump_of.len()
    )));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn body(id: u64) -> Body {
        Body { id, ..Body::default() }
    }

    fn bond(first: u64, second: u64, line: usize) -> FileBond {
        FileBond { first, second, kind: 1, line }
    }

    #[test]
    fn bonds_find_their_spheres_and_impossible_ones_are_refused_by_line() {
        let spheres = [body(3), body(5), body(9)];
        let found = identify(Path::new("a.data"), &spheres, &[bond(9, 3, 7), bond(3, 5, 8)]).unwrap();
        assert_eq!(found.iter().map(|bond| bond.pieces).collect::<Vec<_>>(), [[2, 0], [0, 1]]);
        let said =
            |bonds: &[FileBond]| identify(Path::new("a.data"), &spheres, bonds).unwrap_err().to_string();
        let told = said(&[bond(3, 4, 7)]);
        assert!(told.contains("a.data:7") && told.contains("names the atom 4, which is not there"), "{told}");
        assert!(said(&[bond(5, 5, 7)]).contains("joins the atom 5 with itself"));
        let told = said(&[bond(3, 5, 7), bond(5, 3, 9)]);
        assert!(told.contains("a.data:9") && told.contains("bonded already in line 7"), "{told}");
    }

    #[test]
    fn bodies_with_bonds_inside_are_released() {
        let clump_of = HashMap::from([(1, 7), (2, 7), (3, 8), (4, 8)]);
        let mut frame = Frame { clump_of, bonds: vec![bond(2, 1, 3), bond(2, 3, 4)], ..Frame::default() };
        release_bonded_bodies(&mut frame);
        assert_eq!(frame.clump_of, HashMap::from([(3, 8), (4, 8)]));
        assert!(frame.remarks[0].text.starts_with("1 body has bonds inside"), "{:?}", frame.remarks);
    }
}
