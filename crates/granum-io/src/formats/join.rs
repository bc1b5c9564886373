//! Assemblies from the frames of one or several files: contacts are assigned to grains by step, time or order, and quantities that are
//! not in a file but follow from the geometry (branch, normal, overlap, strain) are added.

use std::path::{Path, PathBuf};

use granum_core::assembly::{Assembly, Contact, Sphere, Vector};
use granum_core::geometry::{apply, dot, invert};
use granum_core::{Part, Parts};

use super::bodies::BodiesOfFile;
use super::contact_table::{ContactOptions, ContactTable};
use super::remark::Remark;
use super::result::{FileContact, Frame, FrameCell, ObservedAssembly};
use super::strain::add_strains;
use super::{file_bonds, ids, places, rounding};
use crate::error::{Error, Result, in_file};
use crate::packing::lattice::{self, Images};
use crate::packing::plausible::{self, Found, Implausible, ImplausiblePlace};
use crate::shell::ShowPath;

/// What the files do not say.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct JoinOptions {
    /// The periodic cell of files that have none.
    pub cell: Option<FrameCell>,
    /// Density of the grains, kg/m3, of files that have no masses.
    pub density: Option<f64>,
    /// Time step, s, of files that have steps but no times.
    pub time_step: Option<f64>,
    /// What cannot be decided of tables of contacts.
    pub contacts: ContactOptions,
    /// True if each sphere is a grain of its own, whatever the file says of bodies.
    pub separate_spheres: bool,
    /// True if the masses of the spheres of a body add up to its mass also in files that do not say so, as dumps of LAMMPS are that began with a
    /// data file of granum.
    pub masses_add_up: bool,
}

impl JoinOptions {
    /// Options with this cell, density (kg/m3) and time step (s).
    pub fn new(cell: Option<FrameCell>, density: Option<f64>, time_step: Option<f64>) -> JoinOptions {
        JoinOptions { cell, density, time_step, ..JoinOptions::default() }
    }

    /// The same; each sphere is a grain of its own if `separate` is true, as it should be where molecules are not rigid.
    pub fn with_separate_spheres(self, separate: bool) -> JoinOptions {
        JoinOptions { separate_spheres: separate, ..self }
    }

    /// The same; the masses of the spheres of a body add up to its mass if `add_up` is true.
    pub fn with_masses_that_add_up(self, add_up: bool) -> JoinOptions {
        JoinOptions { masses_add_up: add_up, ..self }
    }

    /// The same with these answers to what cannot be decided of tables of contacts.
    pub fn with_contacts(self, contacts: ContactOptions) -> JoinOptions {
        JoinOptions { contacts, ..self }
    }
}

/// The observations that the frames of these files make up, in the order of the frames of grains.
///
/// A frame of contacts belongs to the frame of grains of the same step, or else of the same time, or else of the same position in
/// the order of the files. The cell of a frame with neither grains nor contacts is assigned in the same way to frames without a cell.
///
/// # Errors
/// If there are no grains, if no frame of grains belongs to a frame of contacts, or if a contact refers to a grain that does not
/// exist.
pub fn join(files: Vec<(PathBuf, Vec<Frame>)>, options: &JoinOptions) -> Result<Vec<ObservedAssembly>> {
    let mut grains: Vec<(PathBuf, Frame)> = Vec::new();
    let mut others: Vec<(PathBuf, Vec<Frame>)> = Vec::new();
    for (path, frames) in files {
        let (with, without): (Vec<Frame>, Vec<Frame>) =
            frames.into_iter().partition(|frame| !frame.grains.is_empty());
        grains.extend(with.into_iter().map(|frame| (path.clone(), frame)));
        if !without.is_empty() {
            others.push((path, without));
        }
    }
    if grains.is_empty() {
        let path = others.first().map_or_else(PathBuf::new, |(path, _)| path.clone());
        return Err(Error::content(&path, "has no grains: give the file of the grains beside it"));
    }
    // Several files of one frame each stand for one another's instants in their order, as contacts-1.vtk, contacts-2.vtk.
    if others.len() > 1 && others.iter().all(|(_, frames)| frames.len() == 1) {
        others = by_kind(others);
    }
    if grains.iter().all(|(_, frame)| frame.step.is_some()) && has_own_file_each(&grains) {
        // Names sort as run.1000, run.200.
        grains.sort_by_key(|(_, frame)| frame.step);
    }
    for (path, frames) in others {
        attach(&mut grains, &path, frames)?;
    }
    let mut found = Vec::with_capacity(grains.len());
    for (path, frame) in grains {
        found.push(observation(&path, frame, options)?);
    }
    add_strains(&mut found);
    found.iter_mut().for_each(take_usual_cell);
    Ok(found)
}

/// True if no two frames are of one file.
fn has_own_file_each(frames: &[(PathBuf, Frame)]) -> bool {
    let mut paths: Vec<&PathBuf> = frames.iter().map(|(path, _)| path).collect();
    paths.sort_unstable();
    paths.windows(2).all(|pair| pair[0] != pair[1])
}

/// Files of one frame each as two lists: those of contacts, and those of cells alone.
fn by_kind(files: Vec<(PathBuf, Vec<Frame>)>) -> Vec<(PathBuf, Vec<Frame>)> {
    let mut kinds: Vec<(PathBuf, Vec<Frame>)> = Vec::new();
    for (path, frames) in files {
        for frame in frames {
            let same = |other: &Frame| other.contacts.is_some() == frame.contacts.is_some();
            match kinds.iter_mut().find(|(_, known)| known.first().is_some_and(same)) {
                Some((_, known)) => known.push(frame),
                None => kinds.push((path.clone(), vec![frame])),
            }
        }
    }
    kinds
}

/// Gives the contacts or cells of one file to the frames of grains.
fn attach(grains: &mut [(PathBuf, Frame)], path: &Path, frames: Vec<Frame>) -> Result<()> {
    let (count, all) = (frames.len(), grains.len());
    for (place, frame) in frames.into_iter().enumerate() {
        let same_step = |known: &Frame| frame.step.is_some() && known.step == frame.step;
        let same_time = |known: &Frame| match (known.time, frame.time) {
            (Some(a), Some(b)) => (a - b).abs() <= 1e-9 * a.abs().max(b.abs()),
            _ => false,
        };
        let steps = frame.step.is_some() && grains.iter().any(|(_, known)| known.step.is_some());
        let times = frame.time.is_some() && grains.iter().any(|(_, known)| known.time.is_some());
        let at = if steps {
            grains.iter().position(|(_, known)| same_step(known))
        } else if times {
            grains.iter().position(|(_, known)| same_time(known))
        } else if count == 1 && frame.contacts.is_none() {
            // One cell for all.
            grains.iter_mut().for_each(|(_, known)| known.cell = known.cell.or(frame.cell));
            continue;
        } else {
            (count == all).then_some(place)
        };
        let Some(at) = at else { return Err(no_partner(path, &frame, place, count, all)) };
        let known = &mut grains[at].1;
        known.cell = known.cell.or(frame.cell);
        known.time = known.time.or(frame.time);
        if frame.contacts.is_some() {
            if known.contacts.is_some() {
                let message =
                    "the grains of this instant have contacts already, of another file: give one of the two";
                return Err(Error::content(path, message));
            }
            known.contacts = frame.contacts;
            known.contacts_file = Some(path.to_path_buf());
            known.centres = frame.centres;
        }
    }
    Ok(())
}

fn no_partner(path: &Path, frame: &Frame, place: usize, count: usize, all: usize) -> Error {
    let what = match (frame.step, frame.time) {
        (Some(step), _) => format!("there are no grains of step {step} for its contacts"),
        (None, Some(time)) => format!("there are no grains of the time {time} s for its contacts"),
        _ => format!(
            "its instant {} of {count} cannot be identified among {all} of the grains: give as many of both",
            place + 1
        ),
    };
    Error::content(path, what)
}

/// One observation: grains in the order of their ids, wrapped into the cell, and their contacts.
fn observation(path: &Path, frame: Frame, options: &JoinOptions) -> Result<ObservedAssembly> {
    let Frame { step, time, grains, lines, contacts, centres, mut parts, materials, .. } = frame;
    let (mut grains, lines) = in_order(path, grains, lines)?;
    let cell = frame.cell.or(options.cell).map(right_handed);
    check_plausible(path, &grains, &lines, cell.as_ref(), parts)?;
    let rounding =
        frame.rounding.unwrap_or_else(|| rounding::of_places(grains.iter().map(|grain| grain.position)));
    if let Some(cell) = &cell {
        wrap(&mut grains, cell);
        parts = parts.with(Part::Cell);
    }
    if let Some(density) = options.density.filter(|_| !parts.has(Part::Masses) && parts.has(Part::Radii)) {
        let mass = |radius: f64| density * 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
        grains.iter_mut().for_each(|grain| grain.mass = mass(grain.radius));
        parts = parts.with(Part::Masses);
    }
    let time = time.or_else(|| Some(step? as f64 * options.time_step?));
    if time.is_some() {
        parts = parts.with(Part::Time);
    }
    let mut assembly = Assembly {
        time: time.unwrap_or(0.0),
        step: step.unwrap_or(0),
        time_step: options.time_step.unwrap_or(0.0),
        cell: cell.map_or([[0.0; 3]; 3], |cell| cell.edges),
        materials,
        ..Assembly::default()
    }
    .with_spheres(grains);
    let mut remarks = frame.remarks;
    if frame.cell.is_some() && options.cell.is_some() {
        remarks.push(Remark::set_right(
            "the file has its own cell, and the one that is given beside it is not used",
        ));
    }
    let clump_of = frame.clump_of;
    if let Some(mut pairs) = contacts {
        let path = frame.contacts_file.as_deref().unwrap_or(path);
        let images = Images::new(&assembly.cell);
        if frame.counts_from_one {
            ids::count_from_one(&assembly, parts, &images, &mut pairs, &mut remarks);
        }
        if !centres.is_empty() {
            let corner = cell.map_or([0.0; 3], |cell| cell.origin);
            pairs = places::identify(path, &assembly, corner, &centres, pairs)?;
        }
        let body_of = |grain: usize| clump_of.get(&assembly.bodies[grain].id).copied();
        let answers = options.contacts;
        let table = ContactTable {
            assembly: &assembly,
            parts,
            images,
            rounding,
            body_of: &body_of,
            options: answers,
        };
        let (connected, known) = add_contacts(path, &table, pairs, &mut remarks)?;
        (assembly.contacts, parts) = (connected, known);
    }
    let listed_bonds = file_bonds::identify(path, &assembly.bodies, &frame.bonds)?;
    let origin = cell.map_or([0.0; 3], |cell| cell.origin);
    let found = ObservedAssembly {
        lines,
        remarks,
        clump_of,
        listed_bonds,
        ..ObservedAssembly::new(assembly, parts, origin)
    };
    let (column, masses_add_up) = (frame.clump_column.as_str(), frame.masses_add_up || options.masses_add_up);
    let bodies = BodiesOfFile { path, column, masses_add_up, rounding };
    if options.separate_spheres { Ok(bodies.taken_apart(found)) } else { bodies.put_together(found) }
}

/// The same lattice with edges that span a positive volume.
fn right_handed(cell: FrameCell) -> FrameCell {
    FrameCell { edges: lattice::right_handed(&cell.edges), ..cell }
}

/// Gives an assembly whose cell is so skewed that searches suffer the least skewed cell of the same lattice.
fn take_usual_cell(observed: &mut ObservedAssembly) {
    let assembly = &mut observed.assembly;
    let known = observed.parts.has(Part::Cell);
    let largest = assembly.pieces.iter().map(|piece| piece.radius).fold(0.0, f64::max);
    if let Some(edges) = lattice::less_skewed(&assembly.cell, largest).filter(|_| known) {
        assembly.cell = edges;
        let place = wrapping(&FrameCell { origin: [0.0; 3], edges });
        assembly.move_positions(place);
    }
}

/// The check that all readers of grains share.
fn check_plausible(
    path: &Path,
    grains: &[Sphere],
    lines: &[usize],
    cell: Option<&FrameCell>,
    parts: Parts,
) -> Result<()> {
    let found = |(k, grain): (usize, &Sphere)| Found {
        id: grain.id,
        position: grain.position,
        radius: parts.has(Part::Radii).then_some(grain.radius),
        line: lines.get(k).copied().unwrap_or(0),
    };
    let found: Vec<Found> = grains.iter().enumerate().map(found).collect();
    let file = path.shown();
    plausible::check(&file, cell.map(|cell| (cell.origin, cell.edges)), &found)
}

/// The grains in the order of their ids, and the line of each; every id must be there once.
fn in_order(path: &Path, grains: Vec<Sphere>, mut lines: Vec<usize>) -> Result<(Vec<Sphere>, Vec<usize>)> {
    let has_lines = lines.len() == grains.len();
    lines.resize(grains.len(), 0);
    let mut rows: Vec<(Sphere, usize)> = grains.into_iter().zip(lines).collect();
    rows.sort_by_key(|(grain, line)| (grain.id, *line));
    if let Some([(first, line), (_, second)]) = rows.windows(2).find(|rows| rows[0].0.id == rows[1].0.id) {
        let file = path.shown();
        let where_first = if has_lines { format!(" in line {line}") } else { String::new() };
        let message = format!("grain {} is already given{where_first}", first.id);
        return Err(in_file(&file, *second, message, "each grain has an id of its own"));
    }
    let (grains, lines): (Vec<Sphere>, Vec<usize>) = rows.into_iter().unzip();
    Ok((grains, if has_lines { lines } else { Vec::new() }))
}

/// Moves the grains so that a corner of the cell is at the origin and each of them is inside.
pub(super) fn wrap(grains: &mut [Sphere], cell: &FrameCell) {
    let place = wrapping(cell);
    grains.iter_mut().for_each(|grain| grain.position = place(&grain.position));
}

/// The place inside a cell whose corner is at the origin of a place in a file.
fn wrapping(cell: &FrameCell) -> impl Fn(&Vector) -> Vector + use<> {
    let (inverse, FrameCell { origin, edges }) = (invert(&cell.edges), *cell);
    move |position| {
        let from_corner: Vector = std::array::from_fn(|a| position[a] - origin[a]);
        let shift = apply(&inverse, from_corner).map(f64::floor);
        let moved = apply(&edges, shift);
        // A grain inside keeps the bits of its place.
        if shift == [0.0; 3] { from_corner } else { std::array::from_fn(|a| from_corner[a] - moved[a]) }
    }
}

/// The contacts of a file, which names their grains by ids, held against the grains; and what is then known.
fn add_contacts(
    path: &Path,
    table: &ContactTable,
    pairs: Vec<FileContact>,
    remarks: &mut Vec<Remark>,
) -> Result<(Vec<Contact>, Parts)> {
    let grains = &table.assembly.bodies;
    let index = |id: u64| {
        grains.binary_search_by_key(&id, |grain| grain.id).map_err(|_| {
            Error::content(path, format!("a contact names the grain {id}, which is not among the grains"))
        })
    };
    let places = |pair: &FileContact| Ok([index(pair.first)?, index(pair.second)?]);
    let places: Vec<[usize; 2]> = pairs.iter().map(places).collect::<Result<_>>()?;
    let file = path.shown();
    let ids: Vec<[u64; 2]> = pairs.iter().map(|pair| [pair.first, pair.second]).collect();
    let held = table.hold(pairs, places).map_err(|found| found.of_contacts(&file, |k| ids[k]))?;
    remarks.extend(held.remarks);
    let ids = |k: usize| [held.pairs[k].first, held.pairs[k].second];
    connect(table.assembly, table.parts, &held.pairs, &held.places)
        .map_err(|found| found.of_contacts(&file, ids))
}

/// Contacts between grains at these places in the list of grains, whose branches are known, and what is then known.
///
/// # Errors
/// For a contact whose grains are at one place, or whose branch is no distance of two grains that touch.
pub(super) fn connect(
    assembly: &Assembly,
    mut parts: Parts,
    pairs: &[FileContact],
    places: &[[usize; 2]],
) -> std::result::Result<(Vec<Contact>, Parts), Implausible> {
    let pieces = &assembly.pieces;
    let radii = parts.has(Part::Radii);
    let mut contacts = Vec::with_capacity(pairs.len());
    for (k, (pair, [i, j])) in pairs.iter().zip(places.iter().copied()).enumerate() {
        let (one, two) = (&pieces[i], &pieces[j]);
        let branch = pair.branch.unwrap_or_default();
        let length = dot(&branch, &branch).sqrt();
        if length == 0.0 {
            let message = "has both grains at one place";
            return Err(Implausible::new(ImplausiblePlace::Contact(k), message, ""));
        }
        let normal = pair.normal.unwrap_or_else(|| branch.map(|x| x / length));
        let (normal_force, tangential_force) = pair.forces(&normal);
        let [normal_energy, tangential_energy] = pair.energies.unwrap_or_default();
        let geometric = if radii { one.radius + two.radius - length } else { 0.0 };
        contacts.push(Contact {
            i,
            j,
            branch,
            normal,
            approach: pair.approach.unwrap_or(geometric),
            normal_force: normal_force.unwrap_or(0.0),
            tangential_force: tangential_force.unwrap_or([0.0; 3]),
            normal_energy,
            tangential_energy,
            sliding: pair.sliding.unwrap_or(false),
            ..Contact::default()
        });
    }
    plausible::find_long(&assembly.cell, contacts.iter().map(|contact| contact.branch))?;
    // A part is known where every contact has it.
    let every = |known: &dyn Fn(&FileContact) -> bool| pairs.iter().all(known);
    parts = parts.with(Part::Contacts);
    let known = [
        (Part::Overlaps, radii || every(&|pair| pair.approach.is_some())),
        (Part::NormalForces, every(&|pair| pair.force.or(pair.normal_force.map(|_| [0.0; 3])).is_some())),
        (Part::TangentialForces, every(&|pair| pair.force.or(pair.tangential_force).is_some())),
        (Part::ContactEnergies, every(&|pair| pair.energies.is_some())),
        (Part::Sliding, every(&|pair| pair.sliding.is_some())),
    ];
    for (part, known) in known {
        if known {
            parts = parts.with(part);
        }
    }
    Ok((contacts, parts))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(step: u64, places: &[Vector]) -> Frame {
        let grain = |(k, position): (usize, &Vector)| Sphere {
            id: 10 - k as u64,
            position: *position,
            radius: 0.5,
            ..Sphere::default()
        };
        let mut frame = Frame { step: Some(step), ..Frame::default() };
        frame.grains = places.iter().enumerate().map(grain).collect();
        frame.cell = Some(FrameCell::between([-1.0; 3], [3.0; 3]));
        frame.knows(&[Part::Positions, Part::Radii]);
        frame
    }

    fn contacts(step: u64, pair: FileContact) -> Frame {
        Frame { step: Some(step), contacts: Some(vec![pair]), ..Frame::default() }
    }

    #[test]
    fn contacts_find_their_grains_by_step_and_across_the_boundary() {
        let grains =
            vec![frame(5, &[[0.0; 3], [1.0, 0.0, 0.0]]), frame(7, &[[2.9, 0.0, 0.0], [-0.2, 0.0, 3.0]])];
        let pair =
            FileContact { first: 10, second: 9, force: Some([-3.0, 0.5, 0.0]), ..FileContact::default() };
        let files = vec![("c".into(), vec![contacts(7, pair)]), ("g".into(), grains)];
        let found = join(files, &JoinOptions::default()).unwrap();
        assert_eq!(found.len(), 2);
        assert!(!found[0].parts.has(Part::Contacts) && found[1].parts.has(Part::TangentialForces));
        let contact = found[1].assembly.contacts[0];
        // The order of ids: grain 9 is the first.
        assert_eq!((contact.i, contact.j), (1, 0));
        assert!((contact.branch[0] - 0.9).abs() < 1e-12, "{:?}", contact.branch);
        assert!((contact.branch[2] + 1.0).abs() < 1e-12, "{:?}", contact.branch);
        let total = contact.force();
        assert!((total[0] + 3.0).abs() < 1e-12 && (total[1] - 0.5).abs() < 1e-12 && total[2].abs() < 1e-12);
        assert!(dot(&contact.tangential_force, &contact.normal).abs() < 1e-12);
        // Grains are wrapped, and the corner of the cell is the origin.
        assert!((found[1].assembly.bodies[0].position[2]).abs() < 1e-12);
        assert_eq!(found[0].origin, [-1.0; 3]);
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        let grains = || vec![("g".into(), vec![frame(5, &[[0.0; 3], [1.0, 0.0, 0.0]])])];
        let message = |files| join(files, &JoinOptions::default()).unwrap_err().to_string();
        let pair = FileContact { first: 10, second: 9, ..FileContact::default() };
        let mut files: Vec<(PathBuf, Vec<Frame>)> = grains();
        files.push(("c".into(), vec![contacts(6, pair)]));
        assert_eq!(message(files), "c: there are no grains of step 6 for its contacts");
        let mut files: Vec<(PathBuf, Vec<Frame>)> = grains();
        files.push(("c".into(), vec![contacts(5, FileContact { second: 4, ..pair })]));
        assert!(message(files).contains("a contact names the grain 4"));
        let only = vec![("c".into(), vec![contacts(5, pair)])];
        assert_eq!(message(only), "c: has no grains: give the file of the grains beside it");
    }
}
