//! The check that all readers of grains share: values that cannot belong to one packing.
//!
//! A single damaged number, a place a million cells away or a radius larger than the cell, would make searches for neighbours run for
//! ever and every mean meaningless.

use granum_core::Cell;
use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{apply, determinant, invert};
use granum_core::quantity::format_number;

use super::lattice::reduced;
use crate::error::{Error, Result, in_file};

/// Largest ratio of the radii of two grains of one packing.
pub const WIDEST_RADII: f64 = 1e6;
/// Largest distance of a grain from the cell, in edges of the cell; without a cell from the median place, in spreads of the places.
pub const FARTHEST: f64 = 1e6;

/// Largest length of the branch of a contact along an edge of the cell, in edges: grains that touch are at most one apart, and programs
/// that give places in different images a few.
pub const LONGEST_BRANCH: f64 = 10.0;

/// A grain as a file has it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    pub(crate) id: u64,
    pub(crate) position: Vector,
    /// Radius, m; none where it is not known.
    pub(crate) radius: Option<f64>,
    /// Line in the file; 0 in files without lines.
    pub(crate) line: usize,
}

/// What of grains, contacts and their cell cannot belong to one packing, for a caller that knows where they came from.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{message}")]
pub struct Implausible {
    /// Where it is.
    pub at: ImplausiblePlace,
    /// What is wrong there.
    pub message: String,
    /// What would be right; empty where the message says it.
    pub help: String,
}

/// The place of what cannot be right; numbers of grains and contacts are those in their lists, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImplausiblePlace {
    /// The periodic cell.
    Cell,
    /// The place of a grain.
    Position(usize),
    /// The radius of a grain.
    Radius(usize),
    /// A contact.
    Contact(usize),
    /// All contacts together.
    Contacts,
}

impl Implausible {
    pub(crate) fn new(
        at: ImplausiblePlace,
        message: impl Into<String>,
        help: impl Into<String>,
    ) -> Implausible {
        Implausible { at, message: message.into(), help: help.into() }
    }

    /// The error of a file with these grains.
    fn of_grains(self, file: &str, grains: &[Found]) -> Error {
        let (ImplausiblePlace::Position(k) | ImplausiblePlace::Radius(k)) = self.at else {
            return Error::content(file.as_ref(), self.message);
        };
        let (id, line) = grains.get(k).map_or((0, 0), |grain| (grain.id, grain.line));
        in_file(file, line, format!("grain {id}: {}", self.message), &self.help)
    }

    /// The error of a file with contacts; `ids` gives those of the grains of a contact by its number.
    pub(crate) fn of_contacts(self, file: &str, ids: impl FnOnce(usize) -> [u64; 2]) -> Error {
        let ImplausiblePlace::Contact(k) = self.at else {
            return Error::content(file.as_ref(), self.message);
        };
        let [first, second] = ids(k);
        let message = format!("the contact of the grains {first} and {second} {}", self.message);
        Error::content(file.as_ref(), message)
    }
}

/// Checks the grains of one instant, whose cell has this corner and these edges, if it is known.
///
/// # Errors
/// [`Error::Input`] with the line of the first grain that cannot belong to the others ([`Error::Content`] in files without lines), and
/// [`Error::Content`] for the cell; as [`find`].
pub(crate) fn check(file: &str, cell: Option<(Vector, Matrix)>, grains: &[Found]) -> Result<()> {
    find(cell, grains).map_err(|found| found.of_grains(file, grains))
}

/// Checks the branches of contacts, each with the ids of its grains, in a cell with these edges.
///
/// # Errors
/// [`Error::Content`] as [`find_long`].
pub(crate) fn check_branches(
    file: &str,
    edges: &Matrix,
    contacts: impl Iterator<Item = ([u64; 2], Vector)> + Clone,
) -> Result<()> {
    let ids = |k| contacts.clone().nth(k).map_or([0, 0], |(ids, _)| ids);
    find_long(edges, contacts.clone().map(|(_, branch)| branch)).map_err(|found| found.of_contacts(file, ids))
}

/// Checks the grains of one instant, whose cell has this corner and these edges, if it is known.
///
/// # Errors
/// For a number that is not finite, a radius that is not positive or larger than half the cell, a place more than [`FARTHEST`] cells
/// away, radii that differ by more than [`WIDEST_RADII`], and a cell without a volume. A skewed cell is judged by the least skewed one of
/// its lattice.
pub(crate) fn find(cell: Option<(Vector, Matrix)>, grains: &[Found]) -> std::result::Result<(), Implausible> {
    grains.iter().enumerate().try_for_each(check_numbers)?;
    match &cell {
        Some((origin, edges)) => check_in_cell(origin, edges, grains)?,
        None => check_together(grains)?,
    }
    check_radii(grains)
}

/// Checks the branches of contacts in a cell with these edges. Without a cell, whose edges are zero, they must be finite.
///
/// # Errors
/// For a branch that is not finite or longer than [`LONGEST_BRANCH`] cells.
pub(crate) fn find_long(
    edges: &Matrix,
    branches: impl Iterator<Item = Vector>,
) -> std::result::Result<(), Implausible> {
    let inverse = invert(&reduced(edges));
    let is_cell = inverse.iter().flatten().all(|x| x.is_finite());
    for (k, branch) in branches.enumerate() {
        let square: f64 = branch.iter().map(|x| x * x).sum();
        let is_near = |step: &f64| step.abs() <= LONGEST_BRANCH;
        if square.is_finite() && (!is_cell || apply(&inverse, branch).iter().all(is_near)) {
            continue;
        }
        let [x, y, z] = branch;
        let message = format!(
            "has the branch ({x:e}, {y:e}, {z:e}) m between their centres, which is no distance of two grains that touch: it must be \
             finite, and at most 10 cells long"
        );
        return Err(Implausible::new(ImplausiblePlace::Contact(k), message, ""));
    }
    Ok(())
}

fn check_numbers((k, grain): (usize, &Found)) -> std::result::Result<(), Implausible> {
    if let Some(axis) = (0..3).find(|axis| !grain.position[*axis].is_finite()) {
        let message = format!("{} = {}", ["x", "y", "z"][axis], grain.position[axis]);
        return Err(Implausible::new(ImplausiblePlace::Position(k), message, "a finite number is needed"));
    }
    match grain.radius {
        Some(radius) if !(radius.is_finite() && radius > 0.0) => {
            let message = format!("radius = {radius} must be positive");
            Err(Implausible::new(ImplausiblePlace::Radius(k), message, "a finite length in m is needed"))
        }
        _ => Ok(()),
    }
}

fn check_in_cell(origin: &Vector, edges: &Matrix, grains: &[Found]) -> std::result::Result<(), Implausible> {
    let wrong_cell = |message: String| Err(Implausible::new(ImplausiblePlace::Cell, message, ""));
    if invert(edges).iter().flatten().any(|x| !x.is_finite()) {
        return wrong_cell(format!(
            "the cell has the volume {:e} m3; it must be positive",
            determinant(edges)
        ));
    }
    // A skewed cell repeats the same grains as a less skewed one, in which they are judged.
    let edges = &reduced(edges);
    let inverse = invert(edges);
    let narrow = Cell { edges: *edges }.heights().into_iter().fold(f64::INFINITY, f64::min);
    for (k, grain) in grains.iter().enumerate() {
        let place = apply(&inverse, std::array::from_fn(|a| grain.position[a] - origin[a]));
        let is_near = |axis: usize| place[axis].abs() <= FARTHEST;
        if let Some(axis) = (0..3).find(|axis| !is_near(*axis)) {
            let [x, y, z] = grain.position;
            let message = format!(
                "({x:e}, {y:e}, {z:e}) is {} cells away along edge {}",
                short(place[axis].abs()),
                ["a", "b", "c"][axis]
            );
            let help = "places are in m, and at most 1e6 cells away";
            return Err(Implausible::new(ImplausiblePlace::Position(k), message, help));
        }
        if let Some(radius) = grain.radius.filter(|radius| 2.0 * radius > narrow) {
            let message = format!("radius = {radius:e} m does not fit in the cell, {narrow:e} m wide");
            return Err(Implausible::new(ImplausiblePlace::Radius(k), message, "lengths are in m"));
        }
    }
    Ok(())
}

/// Without a cell: no grain is a million times farther from the median place than half of the grains are.
fn check_together(grains: &[Found]) -> std::result::Result<(), Implausible> {
    let usual = median(grains.iter().filter_map(|grain| grain.radius).collect()).unwrap_or(0.0);
    for axis in 0..3 {
        let Some(middle) = median(grains.iter().map(|grain| grain.position[axis]).collect()) else {
            return Ok(());
        };
        let away = |grain: &Found| (grain.position[axis] - middle).abs();
        let spread = median(grains.iter().map(away).collect()).unwrap_or(0.0).max(usual);
        if spread == 0.0 {
            continue;
        }
        if let Some(k) = grains.iter().position(|grain| away(grain) > FARTHEST * spread) {
            let name = ["x", "y", "z"][axis];
            let message = format!("{name} = {:e} m is far from all others", grains[k].position[axis]);
            let help = format!(
                "half of them are within {spread:e} m of {name} = {middle:e} m, and at most 1e6 times that can be right"
            );
            return Err(Implausible::new(ImplausiblePlace::Position(k), message, help));
        }
    }
    Ok(())
}

/// Of radii that differ too much, the one that is farthest from the median is wrong.
fn check_radii(grains: &[Found]) -> std::result::Result<(), Implausible> {
    let radii = || grains.iter().filter_map(|grain| grain.radius);
    let (smallest, largest) =
        radii().fold((f64::INFINITY, 0.0f64), |(low, high), r| (low.min(r), high.max(r)));
    if largest <= WIDEST_RADII * smallest || largest == 0.0 {
        return Ok(());
    }
    let usual = median(radii().collect()).unwrap_or(smallest);
    let wrong = if largest / usual > usual / smallest { largest } else { smallest };
    let Some(k) = grains.iter().position(|grain| grain.radius == Some(wrong)) else { return Ok(()) };
    let message = format!("radius = {wrong:e} m does not belong to the others, which are about {usual:e} m");
    let help = "the largest grain of a packing is at most 1e6 times the smallest; lengths are in m";
    Err(Implausible::new(ImplausiblePlace::Radius(k), message, help))
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Three digits.
fn short(value: f64) -> String {
    format!("{value:.2e}").parse().map_or_else(|_| value.to_string(), format_number)
}

#[cfg(test)]
mod tests {
    use super::*;

    const EDGES: Matrix = [[1e-3, 0.0, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]];

    fn grains() -> Vec<Found> {
        let place = |k: u64| [1e-4 * k as f64, 5e-5 * (k % 3) as f64, 3e-4];
        (1..8)
            .map(|k| Found { id: k, position: place(k), radius: Some(5e-5), line: k as usize + 2 })
            .collect()
    }

    fn message(cell: bool, change: impl FnOnce(&mut Found)) -> String {
        let mut grains = grains();
        change(&mut grains[3]);
        let cell = cell.then_some(([0.0; 3], EDGES));
        check("p.txt", cell, &grains).err().map_or_else(String::new, |error| error.to_string())
    }

    #[test]
    fn a_contact_across_the_world_is_refused() {
        let told = |edges: &Matrix, x: f64| {
            let contacts = [([1, 2], [1e-4, 0.0, 0.0]), ([4, 7], [0.0, x, 1e-4])];
            check_branches("p.vtp", edges, contacts.into_iter()).err().map(|error| error.to_string())
        };
        for x in [-1e308, 1.0, f64::NAN] {
            let found = told(&EDGES, x).unwrap();
            assert!(found.contains("p.vtp") && found.contains("the grains 4 and 7"), "{found}");
        }
        assert!(told(&[[0.0; 3]; 3], -1e308).is_some());
        assert_eq!((told(&EDGES, 1.9e-3), told(&[[0.0; 3]; 3], 1.0)), (None, None));
    }

    #[test]
    fn values_that_belong_to_no_packing_are_refused_by_line() {
        for cell in [true, false] {
            assert_eq!(message(cell, |_| {}), "");
            let found = message(cell, |grain| grain.position[0] = 1e9);
            assert!(found.starts_with("p.txt:6:") && found.contains("grain 4: "), "{found}");
            assert!(
                found.contains(if cell { "1e12 cells away" } else { "x = 1e9 m is far from all" }),
                "{found}"
            );
            let found = message(cell, |grain| grain.radius = Some(1e308));
            assert!(found.starts_with("p.txt:6:") && found.contains("radius = 1e308 m"), "{found}");
            let found = message(cell, |grain| grain.radius = Some(1e-12));
            assert!(found.contains("radius = 1e-12 m does not belong to the others"), "{found}");
            assert!(message(cell, |grain| grain.radius = Some(f64::NAN)).contains("radius = NaN"));
            assert!(message(cell, |grain| grain.position[2] = f64::INFINITY).contains("z = inf"));
            assert_eq!(message(cell, |grain| grain.radius = None), "");
        }
        assert!(message(true, |grain| grain.radius = Some(5.1e-4)).contains("does not fit in the cell"));
        // A grain outside the cell is at one of its images.
        assert_eq!(message(true, |grain| grain.position[0] = 900.0), "");
        // Sheared by sixty edges the lattice is that of the cube, into which the grains fit.
        let sheared = [[1e-3, 60e-3, 0.0], [0.0, 1e-3, 0.0], [0.0, 0.0, 1e-3]];
        assert!(check("p", Some(([0.0; 3], sheared)), &grains()).is_ok());
        let flat = check("p", Some(([0.0; 3], [[0.0; 3]; 3])), &grains()).unwrap_err().to_string();
        assert!(flat.contains("it must be positive"), "{flat}");
        assert!(check("p", None, &[]).is_ok());
    }
}
