//! Bodies of the spheres that a file says to be parts of one molecule, clump or body: each is one rigid grain.
//!
//! Its pieces are taken together across the faces of the cell: from sphere to sphere that touch, always by the nearest image, which in a sheared
//! cell is not that of each axis by itself. Image flags are not needed for that, and wrong ones do no harm. Centre, volume and inertia
//! are those of the union of the spheres, in which what several of them share counts once. The mass is the density of its spheres times that
//! volume, or the sum of their masses where the file says that they add up. Its velocity is the mean of those of its spheres, less that of
//! their turning about its centre where spins are known; its spin is the mean of theirs; force and torque about its centre are their sums.
//!
//! A body has the number that the file gives it if every sphere has one there, and otherwise the id of its first sphere.

use std::collections::BTreeMap;
use std::path::Path;

use granum_core::assembly::{Assembly, Body, Contact, Piece, Rigid, Sphere, Vector};
use granum_core::geometry::{apply, cross, invert, length};
use granum_core::{Cell, Part};
use granum_shape::{ShapeOfSpheres, equivalent_radius};

use super::quaternion::of_matrix;
use super::remark::Remark;
use super::result::ObservedAssembly;
use crate::error::{Result, in_file};
use crate::packing::lattice::{Images, reduced};
use crate::shell::ShowPath;

/// A gap between two spheres up to this share of the sum of their radii is rounding.
const ROUNDING: f64 = 1e-6;

/// What a file says of its bodies beside their spheres.
pub(super) struct BodiesOfFile<'a> {
    /// The file, for messages.
    pub(super) path: &'a Path,
    /// What it calls the bodies, for messages.
    pub(super) column: &'a str,
    /// True if the masses of the spheres of a body add up to its mass.
    pub(super) masses_add_up: bool,
    /// Largest error of the distance of two places by rounding, m.
    pub(super) rounding: f64,
}

impl BodiesOfFile<'_> {
    /// The same assembly with the spheres of each body as the pieces of one grain.
    ///
    /// # Errors
    /// [`crate::Error::Input`] with the line of the first sphere of a body whose spheres do not touch, are equal, or that is larger than half the cell.
    pub(super) fn put_together(&self, observed: ObservedAssembly) -> Result<ObservedAssembly> {
        if observed.clump_of.is_empty() {
            return Ok(observed);
        }
        let groups = groups(&observed);
        if !observed.parts.has(Part::Radii) {
            return Ok(self.without_radii(observed, &groups));
        }
        let Some(spheres) = observed.assembly.spheres() else { return Ok(observed) };
        let cell = CellOfBodies::new(&observed);
        let mut gathered = Gathered::default();
        for (id, members) in &groups {
            let own: Vec<Sphere> = members.iter().map(|k| spheres[*k]).collect();
            let line = members.first().and_then(|k| observed.lines.get(*k)).copied();
            gathered.lines.extend(line);
            match own[..] {
                [sphere] => gathered.push_sphere(Sphere { id: *id, ..sphere }, members[0]),
                _ => {
                    let wrong = |(message, help): (String, &str)| {
                        let message = format!("body {id} ({}): {message}", self.column_shown());
                        in_file(&self.path.shown(), line.unwrap_or(0), message, help)
                    };
                    let body = self.body(&own, observed.parts.has(Part::Spins), &cell).map_err(wrong)?;
                    gathered.push_body(*id, body, &own, members);
                }
            }
        }
        Ok(self.gathered(observed, gathered, &groups))
    }

    /// The same assembly, whose spheres remain grains of their own; they are counted in a remark.
    pub(super) fn taken_apart(&self, mut observed: ObservedAssembly) -> ObservedAssembly {
        if !observed.clump_of.is_empty() {
            let groups = groups(&observed);
            observed.remarks.push(Remark::doubtful(format!(
                "{}: each is taken as a grain of its own, so that volumes in which they overlap count twice, and numbers of contacts are those of \
                 spheres",
                self.counted(&groups)
            )));
        }
        observed
    }

    fn column_shown(&self) -> String {
        // Some formats have no columns.
        if self.column.starts_with("of ") { self.column.into() } else { format!("column {}", self.column) }
    }

    /// `2 spheres are parts of 1 body (column mol)`.
    fn counted(&self, groups: &Groups) -> String {
        let several = || groups.iter().filter(|(_, members)| members.len() > 1);
        let (bodies, spheres) =
            (several().count(), several().map(|(_, members)| members.len()).sum::<usize>());
        let noun = if bodies == 1 { "body" } else { "bodies" };
        format!("{spheres} spheres are parts of {bodies} {noun} ({})", self.column_shown())
    }

    fn without_radii(&self, mut observed: ObservedAssembly, groups: &Groups) -> ObservedAssembly {
        observed.remarks.push(Remark::doubtful(format!(
            "{}, which cannot be put together without radii: each sphere is taken as a grain of its own",
            self.counted(groups)
        )));
        observed
    }

    /// The body of these spheres, or what is wrong and what would be right.
    fn body(
        &self,
        own: &[Sphere],
        spins: bool,
        cell: &CellOfBodies,
    ) -> std::result::Result<GatheredBody, (String, &'static str)> {
        let places = cell.together(own, self.rounding)?;
        let spheres: Vec<(Vector, f64)> =
            places.iter().zip(own).map(|(place, s)| (*place, s.radius)).collect();
        let union = ShapeOfSpheres::new(&spheres)
            .map_err(|message| (message, "spheres are counted from 0 in the order of their ids"))?;
        let arms: Vec<Vector> = places.iter().map(|place| minus(place, &union.centre)).collect();
        cell.check_size(&arms, own)?;
        let volume_of_spheres: f64 = own.iter().map(|s| volume(s.radius)).sum();
        let sum: f64 = own.iter().map(|sphere| sphere.mass).sum();
        let mass = if self.masses_add_up { sum } else { sum / volume_of_spheres * union.shape.volume };
        // The density one stands for an unknown one, so that the ratios of the moments are known.
        let weight = if mass > 0.0 { mass } else { union.shape.volume };
        let mut body = Body {
            position: cell.wrapped(&union.centre),
            equivalent_radius: equivalent_radius(union.shape.volume),
            mass: weight,
            material: own.first().map_or(0, |sphere| sphere.material),
            ..Body::default()
        };
        add_motion(&mut body, own, &arms, spins);
        let rigid = Rigid {
            orientation: of_matrix(&union.axes),
            inertia: union.shape.inertia_over_mass.map(|moment| weight * moment),
        };
        Ok(GatheredBody { body, rigid, arms })
    }

    /// The observation with the bodies instead of the spheres. Contacts name the pieces; those inside a body are none.
    fn gathered(&self, observed: ObservedAssembly, gathered: Gathered, groups: &Groups) -> ObservedAssembly {
        let Gathered { bodies, pieces, rigid, piece_of, lines } = gathered;
        let ObservedAssembly { assembly, mut remarks, .. } = observed;
        let mut place = vec![0; piece_of.len()];
        piece_of.iter().enumerate().for_each(|(piece, sphere)| place[*sphere] = piece);
        let before = assembly.contacts.len();
        let contact = |contact: Contact| Contact { i: place[contact.i], j: place[contact.j], ..contact };
        let between = |contact: &Contact| pieces[contact.i].body != pieces[contact.j].body;
        let contacts: Vec<Contact> = assembly.contacts.into_iter().map(contact).filter(between).collect();
        let inside = before - contacts.len();
        let mass = if self.masses_add_up { "" } else { ", mass" };
        remarks.push(Remark::set_right(format!(
            "{}: each body is one rigid grain, of which centre{mass} and inertia are those of the union of its spheres",
            self.counted(groups)
        )));
        if inside > 0 {
            let are = if inside == 1 { "is" } else { "are" };
            remarks.push(Remark::set_right(format!(
                "{inside} of the {before} contacts {are} inside a body and {are} left out"
            )));
        }
        let assembly = Assembly { bodies, pieces, rigid, contacts, ..assembly };
        let mut listed_bonds = observed.listed_bonds;
        listed_bonds.iter_mut().for_each(|bond| bond.pieces = bond.pieces.map(|sphere| place[sphere]));
        ObservedAssembly { assembly, remarks, lines, listed_bonds, clump_of: Default::default(), ..observed }
    }
}

/// The places of the spheres of each body in the list of all, by the id that the body gets.
type Groups = BTreeMap<u64, Vec<usize>>;

fn groups(observed: &ObservedAssembly) -> Groups {
    let (bodies, clump_of) = (&observed.assembly.bodies, &observed.clump_of);
    let all = clump_of.len() == bodies.len();
    let mut first: BTreeMap<u64, u64> = BTreeMap::new();
    let mut groups = Groups::new();
    for (k, sphere) in bodies.iter().enumerate() {
        let id = match clump_of.get(&sphere.id) {
            Some(clump) if all => *clump,
            Some(clump) => *first.entry(*clump).or_insert(sphere.id),
            None => sphere.id,
        };
        groups.entry(id).or_default().push(k);
    }
    groups
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    std::array::from_fn(|k| a[k] - b[k])
}

fn volume(radius: f64) -> f64 {
    4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius
}

/// Adds the means of velocity and spin and the sums of force and torque about the centre.
fn add_motion(body: &mut Body, own: &[Sphere], arms: &[Vector], spins: bool) {
    let share = 1.0 / own.len() as f64;
    for sphere in own.iter().filter(|_| spins) {
        body.spin = std::array::from_fn(|a| body.spin[a] + share * sphere.spin[a]);
    }
    for (sphere, arm) in own.iter().zip(arms) {
        let turning = cross(&body.spin, arm);
        let torque = cross(arm, &sphere.force);
        for a in 0..3 {
            body.velocity[a] += share * (sphere.velocity[a] - turning[a]);
            body.force[a] += sphere.force[a];
            body.torque[a] += sphere.torque[a] + torque[a];
        }
    }
}

struct GatheredBody {
    body: Body,
    rigid: Rigid,
    arms: Vec<Vector>,
}

/// Bodies and pieces as far as they are put together.
#[derive(Default)]
struct Gathered {
    bodies: Vec<Body>,
    pieces: Vec<Piece>,
    rigid: Vec<Rigid>,
    /// The place of the sphere of each piece in the list of spheres.
    piece_of: Vec<usize>,
    /// The line of the first sphere of each body.
    lines: Vec<usize>,
}

impl Gathered {
    fn push_sphere(&mut self, sphere: Sphere, place: usize) {
        let Sphere { position, radius, .. } = sphere;
        self.pieces.push(Piece { body: self.bodies.len(), position, radius, arm: [0.0; 3] });
        self.piece_of.push(place);
        self.bodies.push(sphere.into());
    }

    fn push_body(&mut self, id: u64, of: GatheredBody, own: &[Sphere], places: &[usize]) {
        let GatheredBody { body, rigid, arms } = of;
        for ((sphere, arm), place) in own.iter().zip(arms).zip(places) {
            let Sphere { position, radius, .. } = *sphere;
            self.pieces.push(Piece { body: self.bodies.len(), position, radius, arm });
            self.piece_of.push(*place);
        }
        let rigid_at = self.rigid.len() as u32;
        self.rigid.push(rigid);
        self.bodies.push(Body { id, rigid: Some(rigid_at), ..body });
    }
}

/// The cell as bodies see it; nothing has an image where there is none.
struct CellOfBodies {
    edges: granum_core::assembly::Matrix,
    images: Option<Images>,
    /// The least height of the least skewed cell of the lattice, m.
    height: f64,
}

impl CellOfBodies {
    fn new(observed: &ObservedAssembly) -> CellOfBodies {
        let edges = observed.assembly.cell;
        let known = observed.parts.has(Part::Cell);
        let heights = Cell { edges: reduced(&edges) }.heights();
        CellOfBodies {
            edges,
            images: known.then(|| Images::new(&edges)),
            height: if known { heights.into_iter().fold(f64::INFINITY, f64::min) } else { f64::INFINITY },
        }
    }

    /// The places of the spheres of a body beside each other: from the first to those that touch it, and so on.
    fn together(
        &self,
        own: &[Sphere],
        rounding: f64,
    ) -> std::result::Result<Vec<Vector>, (String, &'static str)> {
        let mut places: Vec<Option<Vector>> = vec![None; own.len()];
        let mut found: Vec<(usize, Vector)> = own.first().map(|s| (0, s.position)).into_iter().collect();
        places.iter_mut().take(1).zip(&found).for_each(|(place, (_, first))| *place = Some(*first));
        let mut at = 0;
        while let Some((k, place)) = found.get(at).copied() {
            at += 1;
            for (other, sphere) in own.iter().enumerate() {
                if places[other].is_some() {
                    continue;
                }
                let apart = minus(&sphere.position, &own[k].position);
                let branch = self.images.as_ref().map_or(apart, |images| images.nearest(apart));
                let reach = own[k].radius + sphere.radius;
                if length(&branch) <= reach * (1.0 + ROUNDING) + rounding {
                    let next = std::array::from_fn(|a| place[a] + branch[a]);
                    places[other] = Some(next);
                    found.push((other, next));
                }
            }
        }
        let apart = places.iter().position(Option::is_none).and_then(|k| own.get(k));
        match apart {
            Some(sphere) => Err((
                format!(
                    "its spheres do not hang together: sphere {} touches none of those that lead to sphere {}",
                    sphere.id,
                    own.first().map_or(0, |first| first.id)
                ),
                "the spheres of a rigid body overlap or touch; are the column and the cell right?",
            )),
            None => Ok(places.into_iter().flatten().collect()),
        }
    }

    /// Refuses a body that is so large that its images cannot be told apart.
    fn check_size(&self, arms: &[Vector], own: &[Sphere]) -> std::result::Result<(), (String, &'static str)> {
        let reach = arms.iter().zip(own).map(|(arm, s)| length(arm) + s.radius).fold(0.0, f64::max);
        if 2.0 * reach <= 0.5 * self.height {
            return Ok(());
        }
        let message = format!(
            "it is {:e} m long about its centre, more than half the width of the cell, {:e} m",
            2.0 * reach,
            self.height
        );
        Err((
            message,
            "a body must be at most half as large as the cell, or two images of it could touch one grain",
        ))
    }

    /// A place inside the cell.
    fn wrapped(&self, place: &Vector) -> Vector {
        if self.images.is_none() {
            return *place;
        }
        let shift = apply(&invert(&self.edges), *place).map(f64::floor);
        let moved = apply(&self.edges, shift);
        if shift == [0.0; 3] { *place } else { minus(place, &moved) }
    }
}

#[cfg(test)]
mod tests;
