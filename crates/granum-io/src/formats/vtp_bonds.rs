//! Bonds and cracks in VTK PolyData (`.vtp`) for ParaView: bonds that hold as lines from centre to centre, cut at the faces of the cell as those
//! of [contacts](super::vtp), and bonds that ruptured as vertices where they ruptured. A crack stays at its place in the cell while this
//! deforms.
//!
//! Arrays of both kinds of cells (cell data): `broken` (0 or 1), `rupture` (0: holds, 1: by tension, 2: by shear), `bond_id`, `first_grain` and
//! `second_grain` (ids of the grains), `bond_radius`, `normal` (along the bond: the normal of the crack), `energy` (of a crack what it had), and
//! what only bonds that hold have, zero for cracks: `bond_length`, `normal_force` (compression positive), `shear_force`, `force` (magnitude),
//! `twisting_couple`, `bending_couple`, `utilisation`; and what only cracks have: `rupture_time`, `rupture_phase`. Point data: `broken`,
//! `bond_radius` and `normal`, by which the filter Glyph draws discs (a cylinder, oriented by `normal`) and the filter Tube bonds. Field data as in
//! [files of grains](super::vtp). The format is chosen by its name, `vtp-bonds`; it holds no grains, and none are read of it.

use std::fmt::Write as _;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Assembly, Bond, BrokenBond, Rupture, Vector};
use granum_core::geometry::{apply, length};

use super::result::{Frame, ObservedAssembly, ReadOptions, ResultFormat};
use super::vtk_xml::VtkXml;
use super::vtp::{BEGINNING, array, cells, fields, lines_in_cell, write_one};
use crate::error::{Error, Result};

/// The format.
pub struct VtpBonds;

impl ResultFormat for VtpBonds {
    fn name(&self) -> &'static str {
        "VTP bonds"
    }
    fn extensions(&self) -> &'static [&'static str] {
        // The extension is that of the files of grains.
        &[]
    }
    fn recognises(&self, _: &[u8]) -> bool {
        false
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        VtkXml.read(path, options)
    }
    fn holds_one_instant(&self) -> bool {
        true
    }
    fn is_written(&self) -> bool {
        true
    }
    fn holds_bodies(&self) -> bool {
        true
    }
    fn holds_bonds(&self) -> bool {
        true
    }
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        let known = |one: &ObservedAssembly| one.assembly.is_bonded() && one.parts.has(Part::Cell);
        if !observations.iter().all(known) {
            let message = "cannot be written: these data have no bonds, neither such that hold nor such that ruptured; those of a run are in its \
                           snapshots (`granum export RUN --snapshot end --to vtp-bonds -o bonds.vtp`)";
            return Err(Error::content(path, message));
        }
        write_one(path, observations, text)
    }
}

/// An array: its name, its number of components, the values of a bond that holds, and those of a crack.
type Quantity = (&'static str, usize, fn(&Assembly, &Bond) -> Vec<f64>, fn(&BrokenBond) -> Vec<f64>);

const QUANTITIES: [Quantity; 17] = [
    ("broken", 1, |_, _| vec![0.0], |_| vec![1.0]),
    ("rupture", 1, |_, _| vec![0.0], |crack| vec![kind(crack)]),
    ("bond_id", 1, |_, bond| vec![bond.id as f64], |crack| vec![crack.id as f64]),
    ("first_grain", 1, |assembly, bond| vec![grain(assembly, bond.i)], |crack| vec![crack.bodies[0] as f64]),
    ("second_grain", 1, |assembly, bond| vec![grain(assembly, bond.j)], |crack| vec![crack.bodies[1] as f64]),
    ("bond_radius", 1, |_, bond| vec![bond.radius], |crack| vec![crack.radius]),
    ("normal", 3, |_, bond| bond.normal.to_vec(), |crack| crack.normal.to_vec()),
    ("energy", 1, |_, bond| vec![bond.energy], |crack| vec![crack.energy]),
    ("bond_length", 1, |_, bond| vec![bond.length], |_| vec![0.0]),
    ("normal_force", 1, |_, bond| vec![bond.normal_force], |_| vec![0.0]),
    ("shear_force", 3, |_, bond| bond.shear_force.to_vec(), |_| vec![0.0; 3]),
    ("force", 1, |_, bond| vec![length(&bond.force())], |_| vec![0.0]),
    ("twisting_couple", 1, |_, bond| vec![bond.twisting_couple], |_| vec![0.0]),
    ("bending_couple", 3, |_, bond| bond.bending_couple.to_vec(), |_| vec![0.0; 3]),
    ("utilisation", 1, |_, bond| vec![bond.utilisation], |_| vec![0.0]),
    ("rupture_time", 1, |_, _| vec![0.0], |crack| vec![crack.time]),
    ("rupture_phase", 1, |_, _| vec![0.0], |crack| vec![f64::from(crack.phase)]),
];

fn kind(crack: &BrokenBond) -> f64 {
    match crack.rupture {
        Rupture::Tension => 1.0,
        Rupture::Shear => 2.0,
    }
}

/// The id of the grain of a piece.
fn grain(assembly: &Assembly, piece: usize) -> f64 {
    let body = assembly.body_of(piece).and_then(|body| assembly.bodies.get(body));
    body.map_or(0.0, |body| body.id as f64)
}

fn text(observation: &ObservedAssembly) -> String {
    let assembly = &observation.assembly;
    let (bonds, cracks) = (&assembly.bonds, &assembly.broken_bonds);
    let drawn = lines_in_cell(assembly, bonds.iter().map(|bond| (bond.i, bond.branch)));
    let moved = |v: &Vector| -> Vector { std::array::from_fn(|a| v[a] + observation.origin[a]) };
    // A crack names shares of the edges of the cell.
    let inside = |crack: &BrokenBond| apply(&assembly.cell, crack.place.map(|share| share - share.floor()));
    let mut points: Vec<Vector> = cracks.iter().map(|crack| moved(&inside(crack))).collect();
    points.extend(drawn.iter().flat_map(|line| [moved(&line.from), moved(&line.to)]));
    let (n, lines) = (cracks.len(), drawn.len());
    let mut xml = String::from(BEGINNING);
    fields(&mut xml, observation);
    let _ = writeln!(
        xml,
        "<Piece NumberOfPoints=\"{}\" NumberOfVerts=\"{n}\" NumberOfLines=\"{lines}\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">",
        points.len()
    );
    // A value for each point, of which a line has two, or for each cell.
    let values = |(_, _, whole, broken): &Quantity, ends: usize| -> Vec<f64> {
        let of_line = drawn.iter().map(|line| whole(assembly, &bonds[line.contact]));
        cracks.iter().flat_map(broken).chain(of_line.flat_map(|values| values.repeat(ends))).collect()
    };
    xml.push_str("<PointData>\n");
    for quantity in QUANTITIES.iter().filter(|(name, ..)| ["broken", "bond_radius", "normal"].contains(name))
    {
        array(&mut xml, quantity.0, quantity.1, &values(quantity, 2));
    }
    xml.push_str("</PointData>\n<CellData>\n");
    for quantity in &QUANTITIES {
        array(&mut xml, quantity.0, quantity.1, &values(quantity, 1));
    }
    xml.push_str("</CellData>\n<Points>\n");
    array(&mut xml, "Points", 3, &points.into_iter().flatten().collect::<Vec<f64>>());
    xml.push_str("</Points>\n");
    cells(&mut xml, "Verts", 0, n, 1);
    cells(&mut xml, "Lines", n, lines, 2);
    xml.push_str("</Piece>\n</PolyData>\n</VTKFile>\n");
    xml
}

#[cfg(test)]
mod tests {
    use granum_core::assembly::Sphere;

    use super::*;
    use crate::formats::{Formats, JoinOptions};

    /// The numbers of an array of a section.
    fn numbers(xml: &str, section: &str, name: &str) -> Vec<f64> {
        let from = xml.split(&format!("<{section}>")).nth(1).unwrap_or_default();
        let from = from.split(&format!("Name=\"{name}\"")).nth(1).unwrap_or_default();
        let text = from.split('>').nth(1).unwrap_or_default().split('<').next().unwrap_or_default();
        text.split_whitespace().map(|word| word.parse().unwrap()).collect()
    }

    /// A bond across a face is two lines, a crack a point at its place in the cell.
    #[test]
    fn bonds_are_lines_inside_the_cell_and_cracks_points() {
        let sphere = |id, x| Sphere { id, position: [x, 1.0, 1.0], radius: 0.5, ..Sphere::default() };
        let cell = [[4.0, 0.0, 0.0], [0.0, 4.0, 0.0], [0.0, 0.0, 4.0]];
        let mut assembly =
            Assembly { cell, ..Assembly::default() }.with_spheres([sphere(11, 3.5), sphere(12, 0.5)]);
        let (branch, normal) = ([1.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        let bond = Bond { id: 5, j: 1, branch, normal, radius: 0.25, length: 1.0, ..Bond::default() };
        assembly.bonds = vec![Bond { normal_force: -3.0, shear_force: [0.0, 4.0, 0.0], ..bond }];
        assembly.broken_bonds = vec![BrokenBond {
            id: 2,
            bodies: [12, 11],
            rupture: Rupture::Shear,
            energy: 7.0,
            time: 0.5,
            phase: 1,
            place: [0.25, -0.25, 0.5],
            normal: [0.0, 0.0, 1.0],
            radius: 0.125,
        }];
        let written = ObservedAssembly { origin: [10.0, 0.0, 0.0], ..ObservedAssembly::complete(assembly) };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bonds.vtp");
        let formats = Formats::standard();
        formats.write_assemblies(&path, Some("vtp-bonds"), vec![written.clone()], &path).unwrap();
        let xml = std::fs::read_to_string(&path).unwrap();
        assert!(xml.contains("NumberOfPoints=\"5\" NumberOfVerts=\"1\" NumberOfLines=\"2\""), "{xml}");
        let of = |name: &str| numbers(&xml, "CellData", name);
        assert_eq!(of("broken"), [1.0, 0.0, 0.0]);
        assert_eq!(of("rupture"), [2.0, 0.0, 0.0]);
        assert_eq!((of("first_grain"), of("second_grain")), (vec![12.0, 11.0, 11.0], vec![11.0, 12.0, 12.0]));
        assert_eq!((of("force"), of("energy")), (vec![0.0, 5.0, 5.0], vec![7.0, 0.0, 0.0]));
        assert_eq!(of("normal")[..6], [0.0, 0.0, 1.0, 1.0, 0.0, 0.0]);
        assert_eq!(numbers(&xml, "PointData", "bond_radius"), [0.125, 0.25, 0.25, 0.25, 0.25]);
        let points = numbers(&xml, "Points", "Points");
        assert_eq!(points[..9], [11.0, 3.0, 2.0, 13.5, 1.0, 1.0, 14.0, 1.0, 1.0]);
        assert_eq!(points[9..], [10.0, 1.0, 1.0, 10.5, 1.0, 1.0]);
        // It holds no grains, and none are read of it.
        let files = [(path.clone(), ReadOptions::default())];
        let told = formats.read_results(&files, &JoinOptions::default()).unwrap_err().to_string();
        assert!(told.contains("has no grains"), "{told}");
        // Without bonds there is nothing to write.
        let mut bare = written;
        (bare.assembly.bonds, bare.assembly.broken_bonds) = (Vec::new(), Vec::new());
        let told =
            formats.write_assemblies(&path, Some("vtp-bonds"), vec![bare], &path).err().unwrap().to_string();
        assert!(told.contains("these data have no bonds"), "{told}");
    }
}
