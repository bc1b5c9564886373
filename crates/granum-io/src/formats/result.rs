//! Results of other programs: grains, contacts and cells at one or several instants, as they are in a file, before several files are
//! [joined](super::join::join) to [assemblies](granum_core::Assembly).

use std::any::Any;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

use granum_core::assembly::{Assembly, Body, Bond, Matrix, Sphere, Vector};
use granum_core::geometry::dot;
use granum_core::{MacroState, ObservedState, Part, Parts, Table};

use super::atoms::atoms;
use super::file_bond::FileBond;
use super::remark::Remark;
use crate::error::{Error, Result};
use crate::packing::{PackedBody, PackedBond};
use crate::shell::ShowPath;
use crate::snapshot::{contacts_table, grains_table};

/// A format of results: grains, and possibly contacts, at one or several instants.
///
/// Lengths, times and forces are in SI units, or in a consistent system of units, which is not converted.
///
/// ```
/// use std::path::Path;
/// use granum_core::Part;
/// use granum_io::formats::{Formats, Frame, ReadOptions, ResultFormat};
///
/// /// One grain per line: x y z r.
/// struct Bare;
///
/// impl ResultFormat for Bare {
///     fn name(&self) -> &'static str {
///         "bare"
///     }
///     fn extensions(&self) -> &'static [&'static str] {
///         &["bare"]
///     }
///     fn recognises(&self, head: &[u8]) -> bool {
///         head.starts_with(b"bare")
///     }
///     fn read(&self, _: &Path, _: &ReadOptions) -> granum_io::Result<Vec<Frame>> {
///         let mut frame = Frame::default();
///         frame.knows(&[Part::Positions, Part::Radii]);
///         Ok(vec![frame])
///     }
/// }
///
/// let formats = Formats::standard().with_result(Bare)?;
/// assert!(formats.results().any(|format| format.name() == "bare"));
/// # Ok::<(), granum_core::RegistrationError>(())
/// ```
pub trait ResultFormat: Send + Sync {
    /// Its name, e.g. "LAMMPS dump".
    fn name(&self) -> &'static str;
    /// The extensions of its files, in lower case and without the dot; none for files that have no usual extension.
    fn extensions(&self) -> &'static [&'static str];
    /// True if a file with this beginning is of this format, whatever its name.
    fn recognises(&self, head: &[u8]) -> bool;
    /// Reads every instant of a file.
    ///
    /// # Errors
    /// If the file cannot be read or is not of this format, with file and line.
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>>;
    /// True if [`ReadOptions::columns`] can name the columns of its files.
    fn names_columns(&self) -> bool {
        false
    }
    /// True if a file holds one instant only.
    fn holds_one_instant(&self) -> bool {
        false
    }
    /// True if [`ResultFormat::write`] writes this format.
    fn is_written(&self) -> bool {
        false
    }
    /// True if [`ResultFormat::write`] writes the bonds between grains as well; where others are given such, they leave them out.
    fn holds_bonds(&self) -> bool {
        false
    }
    /// True if [`ResultFormat::write`] writes grains of several pieces as what they are; other formats are never given such.
    fn holds_bodies(&self) -> bool {
        false
    }
    /// Writes observations, under a temporary name that is then renamed.
    ///
    /// # Errors
    /// If the format is only read, holds one instant and is given several, or the file cannot be written.
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        let _ = observations;
        Err(Error::content(path, format!("granum reads {} but does not write it", self.name())))
    }
}

/// What a file does not say of itself.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ReadOptions {
    /// Names of the columns of a file whose own header has none of use, as a LAMMPS dump of `c_1[1] c_1[2]`.
    pub columns: Option<Vec<String>>,
    /// True if a file that names others may name files outside its own folder.
    pub outside: bool,
}

impl ReadOptions {
    /// Options by which the columns of a file have these names.
    pub fn with_columns(columns: Option<Vec<String>>) -> ReadOptions {
        ReadOptions { columns, ..ReadOptions::default() }
    }

    /// The same options; files may name others outside their own folders if `outside` is true.
    pub fn with_outside(self, outside: bool) -> ReadOptions {
        ReadOptions { outside, ..self }
    }
}

/// A periodic cell: its corner and its edges.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameCell {
    /// Corner, m.
    pub origin: Vector,
    /// Edge matrix: column k is edge k, m.
    pub edges: Matrix,
}

impl FrameCell {
    /// A cuboid between two corners, m.
    pub fn between(low: Vector, high: Vector) -> FrameCell {
        let length = |a: usize| high[a] - low[a];
        let edges = [[length(0), 0.0, 0.0], [0.0, length(1), 0.0], [0.0, 0.0, length(2)]];
        FrameCell { origin: low, edges }
    }
}

/// What one file says of one instant: grains, contacts or a cell, or all of them.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct Frame {
    /// Number of the time step, where the file has it.
    pub step: Option<u64>,
    /// Time, s, where the file has it.
    pub time: Option<f64>,
    /// The periodic cell; none where the file has none, or where its boundaries are not all periodic.
    pub cell: Option<FrameCell>,
    /// The grains with the ids of the file, in any order; empty for a file of contacts.
    pub grains: Vec<Sphere>,
    /// The line of each grain in the file, from 1, for messages; empty for files without lines.
    pub lines: Vec<usize>,
    /// The contacts, by the ids of their grains; none where the file has no list of them.
    pub contacts: Option<Vec<FileContact>>,
    /// The file of the contacts, where it is not that of the grains.
    pub contacts_file: Option<PathBuf>,
    /// Centres by whose place in this list, from 0, the contacts name their grains instead of ids, in files that have no ids; else
    /// empty.
    pub centres: Vec<Vector>,
    /// What of the grains is known.
    pub parts: Parts,
    /// Names of the materials, to which [`Sphere::material`] refers; empty where there is only one.
    pub materials: Vec<String>,
    /// True if the file has no ids and grains are numbered from 1 in their order, so that contacts may count from 0.
    pub counts_from_one: bool,
    /// Largest error of the distance of two places by rounding, m; none where the numbers of the places show their digits.
    pub rounding: Option<f64>,
    /// The body (clump, molecule) of each sphere that is a part of one of several spheres, by the id of the sphere; where the file says of
    /// every sphere what its body is, of all of them. Empty if no body has several.
    pub clump_of: HashMap<u64, u64>,
    /// What the file calls the bodies, for messages, as the column `mol`.
    pub clump_column: String,
    /// True if the masses of the spheres of a body add up to its mass, as in files that granum writes; otherwise each is density times volume of
    /// the sphere.
    pub masses_add_up: bool,
    /// The bonds that the file lists, by the ids of their spheres.
    pub bonds: Vec<FileBond>,
    /// What was set right in the file, or is doubtful.
    pub remarks: Vec<Remark>,
}

impl Frame {
    /// The grains and the cell of a packing.
    pub(crate) fn of_packing(packing: &crate::Packing) -> Frame {
        let ObservedAssembly { assembly, parts, origin, .. } = ObservedAssembly::of_packing(packing);
        let cell = FrameCell { origin, edges: assembly.cell };
        let materials = assembly.materials.clone();
        let mut frame = Frame { cell: Some(cell), parts, materials, ..Frame::default() };
        if !assembly.all_spheres() {
            frame.add_pieces(&assembly, origin);
            return frame;
        }
        // Places in a file count from its own origin.
        frame.grains = assembly.spheres().unwrap_or_default();
        for (grain, packed) in frame.grains.iter_mut().zip(&packing.grains) {
            grain.position = packed.position;
        }
        frame
    }

    /// Adds the pieces of an assembly as spheres, numbered from 1, with the bodies to which they belong.
    fn add_pieces(&mut self, assembly: &Assembly, origin: Vector) {
        for atom in atoms(assembly) {
            self.grains.push(Sphere {
                id: atom.id,
                position: std::array::from_fn(|a| origin[a] + atom.position[a]),
                radius: atom.radius,
                material: atom.material,
                ..Sphere::default()
            });
            self.clump_of.insert(atom.id, atom.body);
        }
        self.clump_column = "body".into();
    }

    /// Notes that these parts of the grains are known.
    pub fn knows(&mut self, parts: &[Part]) {
        self.parts = parts.iter().fold(self.parts, |set, part| set.with(*part));
    }
}

/// A contact as a file has it. What is `None` is not in the file; branch and normal then follow from the places of the grains.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FileContact {
    /// Id of the first grain.
    pub first: u64,
    /// Id of the second grain.
    pub second: u64,
    /// Vector from the centre of the first to that of the second, m.
    pub branch: Option<Vector>,
    /// Unit normal from the first to the second.
    pub normal: Option<Vector>,
    /// Whole force on the first grain, N.
    pub force: Option<Vector>,
    /// Normal force, compression positive, N; follows from `force` where that is given.
    pub normal_force: Option<f64>,
    /// Tangential force on the first grain, N; follows from `force` where that is given.
    pub tangential_force: Option<Vector>,
    /// Overlap, m.
    pub approach: Option<f64>,
    /// Elastic energies of the normal and of the tangential displacement, J.
    pub energies: Option<[f64; 2]>,
    /// Whether the grains slide on each other.
    pub sliding: Option<bool>,
}

impl FileContact {
    /// Normal force, compression positive, and tangential force on the first grain, where they are known, for this unit normal.
    pub(super) fn forces(&self, normal: &Vector) -> (Option<f64>, Option<Vector>) {
        let Some(force) = self.force else { return (self.normal_force, self.tangential_force) };
        let compression = -dot(&force, normal);
        let tangential = std::array::from_fn(|a| force[a] + compression * normal[a]);
        (Some(compression), Some(tangential))
    }
}

/// An assembly of another program at one instant, and which of its parts are known.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedAssembly {
    /// The assembly; a corner of its cell is at the origin.
    pub assembly: Assembly,
    /// Which of its parts are known.
    pub parts: Parts,
    /// Corner of the cell in the file, m.
    pub origin: Vector,
    /// The line of each grain in its file, from 1, for messages; empty where there are no lines.
    pub lines: Vec<usize>,
    /// What was set right in the data, or is doubtful in them.
    pub remarks: Vec<Remark>,
    /// The clump (molecule, body) of each sphere that belongs to one of several grains, by the id of the grain.
    pub clump_of: HashMap<u64, u64>,
    /// True if the contacts were computed from the overlaps of the grains, since the data have none.
    pub contacts_are_computed: bool,
    /// The pairs of pieces that the file lists as bonded, of whose bonds nothing else is known: [`Assembly::bonds`] has those of which it is.
    pub listed_bonds: Vec<PackedBond>,
}

impl ObservedAssembly {
    /// An assembly of which these parts are known, in a cell with this corner, m.
    pub fn new(assembly: Assembly, parts: Parts, origin: Vector) -> ObservedAssembly {
        ObservedAssembly {
            assembly,
            parts,
            origin,
            lines: Vec::new(),
            remarks: Vec::new(),
            clump_of: HashMap::new(),
            contacts_are_computed: false,
            listed_bonds: Vec::new(),
        }
    }

    /// The pairs of pieces that are bonded: those of the assembly's bonds, or else those that the file lists.
    pub fn bonded_pairs(&self) -> Vec<PackedBond> {
        match &self.assembly.bonds[..] {
            [] => self.listed_bonds.clone(),
            bonds => {
                let listed = |bond: &Bond| PackedBond { pieces: [bond.i, bond.j], kind: bond.kind.max(1) };
                bonds.iter().map(listed).collect()
            }
        }
    }

    /// The bonded pairs of its packing, in which the pieces follow each other grain by grain.
    fn packed_bonds(&self) -> Vec<PackedBond> {
        let pieces = &self.assembly.pieces;
        let mut order: Vec<usize> = (0..pieces.len()).collect();
        order.sort_by_key(|piece| pieces[*piece].body);
        let mut place = vec![0; pieces.len()];
        order.into_iter().enumerate().for_each(|(at, piece)| place[piece] = at);
        let mut bonds = self.bonded_pairs();
        bonds.retain(|bond| bond.pieces.iter().all(|piece| *piece < place.len()));
        bonds.iter_mut().for_each(|bond| bond.pieces = bond.pieces.map(|piece| place[piece]));
        bonds
    }

    /// An assembly of granum, of which everything is known.
    pub fn complete(assembly: Assembly) -> ObservedAssembly {
        ObservedAssembly::new(assembly, Parts::all(), [0.0; 3])
    }

    /// The same with ids from 1, where a program numbers its grains from 0.
    pub fn numbered_from_one(mut self) -> ObservedAssembly {
        let grains = &mut self.assembly.bodies;
        if grains.first().is_some_and(|grain| grain.id == 0) {
            grains.iter_mut().for_each(|grain| grain.id += 1);
        }
        self
    }

    /// The periodic cell with its corner, if it is known.
    pub fn frame_cell(&self) -> Option<FrameCell> {
        let known = self.parts.has(Part::Cell);
        known.then_some(FrameCell { origin: self.origin, edges: self.assembly.cell })
    }

    /// What is known of its grains as a table.
    ///
    /// # Errors
    /// As [`grains_table`].
    pub fn grains_table(&self) -> Result<Table> {
        Ok(known_columns(&grains_table(&self.assembly)?, self.parts))
    }

    /// What is known of its contacts as a table.
    ///
    /// # Errors
    /// [`Error::Rule`] if there are no contacts among what is known; and as [`contacts_table`].
    pub fn contacts_table(&self) -> Result<Table> {
        if !self.parts.has(Part::Contacts) {
            return Err(Error::Rule(format!("these data have no {}", Part::Contacts.name())));
        }
        Ok(known_columns(&contacts_table(&self.assembly)?, self.parts))
    }

    /// The packing of its grains, numbered from 1; `path` is the file for messages.
    ///
    /// # Errors
    /// If cell or radii are not known, and as for [`crate::Packing::checked`].
    pub fn packing(&self, path: &Path) -> Result<crate::Packing> {
        if let [missing, ..] = self.parts.missing(&[Part::Cell, Part::Positions, Part::Radii])[..] {
            let help = match missing {
                Part::Cell => {
                    "`granum export FILE --cell \"A, B, C\" -o packing.csv` gives it one, and so does in a CSV the line \"# periodic box, \
                     m: xlo=0 ylo=0 zlo=0 xhi=1e-3 yhi=1e-3 zhi=1e-3\" before the names of the columns"
                }
                _ => "a packing needs a periodic cell, and places and radii of grains",
            };
            return Err(Error::content(path, format!("has no {}; {help}", missing.name())));
        }
        let grain = |(k, grain): (usize, &Body)| {
            let position = std::array::from_fn(|a| self.origin[a] + grain.position[a]);
            let line = self.lines.get(k).copied().unwrap_or(0);
            (crate::packing::PackedGrain { id: grain.id, position, radius: grain.equivalent_radius }, line)
        };
        let grains = self.assembly.bodies.iter().enumerate().map(grain).collect();
        let file = path.shown();
        let packing = crate::Packing::numbered_from_one(
            &file,
            self.origin,
            self.assembly.cell,
            grains,
            PackedBody::of_assembly(&self.assembly),
        )?;
        let packing = crate::Packing { bonds: self.packed_bonds(), remarks: self.remarks.clone(), ..packing };
        if self.assembly.materials.is_empty() {
            return Ok(packing);
        }
        let names = self.assembly.materials.clone();
        let of = self.assembly.bodies.iter().map(|grain| grain.material as u8).collect();
        Ok(crate::Packing { materials: crate::packing::PackedMaterials { names, of }, ..packing })
    }

    /// Refuses grains of several pieces for a file whose grains are spheres: written as spheres they would be other grains.
    ///
    /// # Errors
    /// If some grain has several pieces.
    pub fn check_spheres(&self, path: &Path) -> Result<()> {
        if self.assembly.all_spheres() {
            return Ok(());
        }
        let message = "the grains of this file would be spheres, and some of those to be written have several pieces; a snapshot of granum \
                       holds them";
        Err(Error::content(path, message))
    }

    /// As [`ObservedAssembly::of_packing`], and masses are known if there is a density, kg/m3.
    pub(super) fn of_packing_with(packing: &crate::Packing, density: Option<f64>) -> ObservedAssembly {
        let mut found = ObservedAssembly::of_packing(packing);
        let Some(density) = density else { return found };
        for body in &mut found.assembly.bodies {
            body.mass = density * 4.0 / 3.0 * std::f64::consts::PI * body.equivalent_radius.powi(3);
        }
        // They are those of the density one.
        for rigid in &mut found.assembly.rigid {
            rigid.inertia = rigid.inertia.map(|moment| density * moment);
        }
        found.parts = found.parts.with(Part::Masses);
        found
    }

    /// A packing, of which cell, places and radii are known.
    pub fn of_packing(packing: &crate::Packing) -> ObservedAssembly {
        let spheres = packing.grains.iter().enumerate().map(|(k, grain)| Sphere {
            id: grain.id,
            position: packing.from_corner(grain),
            radius: grain.radius,
            material: packing.materials.of.get(k).map_or(0, |material| u32::from(*material)),
            ..Sphere::default()
        });
        let mut assembly = Assembly {
            cell: packing.cell,
            materials: packing.materials.names.clone(),
            ..Assembly::default()
        }
        .with_spheres(spheres);
        packing.add_bodies(&mut assembly);
        let parts = Parts::new(&[Part::Cell, Part::Positions, Part::Radii]);
        ObservedAssembly::new(assembly, parts, packing.origin)
    }
}

impl ObservedState for ObservedAssembly {
    fn grains(&self) -> usize {
        self.assembly.bodies.len()
    }
    fn contacts(&self) -> usize {
        self.assembly.contacts.len()
    }
    fn step(&self) -> u64 {
        self.assembly.step
    }
    fn macro_state(&self) -> MacroState {
        MacroState::from_assembly(&self.assembly)
    }
    fn parts(&self) -> Parts {
        self.parts
    }
    fn assembly_into(&self, assembly: &mut Assembly) {
        assembly.clone_from(&self.assembly);
    }
    fn as_any(&self) -> &dyn Any {
        self
    }
}

/// Those columns of a table of grains or contacts that show what is known: what is not known is zero in an assembly.
pub fn known_columns(table: &Table, parts: Parts) -> Table {
    table.columns_where(|column| part_of_column(&column.name).is_none_or(|part| parts.has(part)))
}

/// The part of an assembly that a column of its tables of grains and contacts shows.
fn part_of_column(name: &str) -> Option<Part> {
    let part = match name.trim_end_matches("_x").trim_end_matches("_y").trim_end_matches("_z") {
        "velocity" => Part::Velocities,
        "spin" => Part::Spins,
        "mass" | "principal_inertia_1" | "principal_inertia_2" | "principal_inertia_3" => Part::Masses,
        "force" | "torque" => Part::ResultantForces,
        "radius" => Part::Radii,
        "approach" => Part::Overlaps,
        "normal_force" => Part::NormalForces,
        "tangential_force" => Part::TangentialForces,
        "sliding" => Part::Sliding,
        // No format but granum's own has the area of contact; it goes with the energies.
        "contact_radius" | "normal_energy" | "tangential_energy" | "rolling_energy" => Part::ContactEnergies,
        _ => return None,
    };
    Some(part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_no_column_of_what_is_not_known() {
        let assembly = Assembly { ..Assembly::default() }.with_spheres(vec![Sphere {
            id: 1,
            radius: 0.5,
            ..Sphere::default()
        }]);
        let known = Parts::new(&[Part::Positions, Part::Radii]);
        let observed = ObservedAssembly::new(assembly.clone(), known, [0.0; 3]);
        let names: Vec<String> = observed.grains_table().unwrap().names().map(String::from).collect();
        assert_eq!(names, ["id", "position_x", "position_y", "position_z", "radius"]);
        assert!(observed.contacts_table().unwrap_err().to_string().contains("these data have no contacts"));
        let complete = ObservedAssembly::complete(assembly);
        assert_eq!(complete.grains_table().unwrap(), grains_table(&complete.assembly).unwrap());
    }
}
