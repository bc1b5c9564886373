//! A read-only snapshot of a simulation at one instant, on which all sensors, reports and file formats are based.
//!
//! It is built from `&Simulation`, so that observation cannot disturb a run; it can equally be filled from the files of
//! another code.

use serde::{Deserialize, Serialize};

pub use crate::energy::EnergyBalance;
use crate::energy::is_zero;
use crate::geometry::determinant;
pub use crate::geometry::{Matrix, Vector};
pub use crate::rotation::Quaternion;
use crate::rotation::{matrix, to_body};

/// What moves: a grain, which is rigid and has one piece or several.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Body {
    /// Its id, from 1 as in packing files.
    pub id: u64,
    /// Its centre of mass, inside the cell, m.
    pub position: Vector,
    /// Fluctuating velocity v' of the centre (without the affine part `L x`), m/s.
    pub velocity: Vector,
    /// Spin, rad/s.
    pub spin: Vector,
    /// Its size: radius R of the sphere of the same volume, m. For a body of one piece this is the radius of the piece.
    pub equivalent_radius: f64,
    /// Mass m, kg.
    pub mass: f64,
    /// Sum of the contact forces on it (dashpots included), N.
    pub force: Vector,
    /// Sum of the contact torques on it about its centre, N m.
    pub torque: Vector,
    /// Its material, as an index of [`Assembly::materials`]; 0 if there is one material.
    #[serde(default, skip_serializing_if = "is_first")]
    pub material: u32,
    /// Its orientation and inertia, as an index of [`Assembly::rigid`], if it has several pieces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rigid: Option<u32>,
}

impl Default for Body {
    fn default() -> Body {
        Body::from(Sphere::default())
    }
}

/// What a body of several pieces has beyond a sphere.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rigid {
    /// The rotation from the principal axes of the body to those of space.
    pub orientation: Quaternion,
    /// Principal moments of inertia, kg m2.
    pub inertia: Vector,
}

/// What touches: a sphere that is fixed on a body. A contact is one between two pieces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Index (not id) of its body in [`Assembly::bodies`].
    pub body: usize,
    /// Its centre, inside the cell, m.
    pub position: Vector,
    /// Its radius, m.
    pub radius: f64,
    /// From the centre of its body to its own, m; zero if it is the only piece.
    pub arm: Vector,
}

/// A body of one piece, as it is in most files: the radius is that of both.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sphere {
    /// Its id, from 1 as in packing files.
    pub id: u64,
    /// Its centre, inside the cell, m.
    pub position: Vector,
    /// Fluctuating velocity v' (without the affine part `L x`), m/s.
    pub velocity: Vector,
    /// Spin, rad/s.
    pub spin: Vector,
    /// Radius R, m.
    pub radius: f64,
    /// Mass m, kg.
    pub mass: f64,
    /// Sum of the contact forces on it (dashpots included), N.
    pub force: Vector,
    /// Sum of the contact torques on it about its centre, N m.
    pub torque: Vector,
    /// Its material, as an index of [`Assembly::materials`]; 0 if there is one material.
    pub material: u32,
}

impl From<Sphere> for Body {
    fn from(sphere: Sphere) -> Body {
        Body {
            id: sphere.id,
            position: sphere.position,
            velocity: sphere.velocity,
            spin: sphere.spin,
            equivalent_radius: sphere.radius,
            mass: sphere.mass,
            force: sphere.force,
            torque: sphere.torque,
            material: sphere.material,
            rigid: None,
        }
    }
}

/// True for the first material, the only one of most assemblies.
fn is_first(material: &u32) -> bool {
    *material == 0
}

/// One contact between pieces i and j that touch, of two bodies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Index of piece i in [`Assembly::pieces`].
    pub i: usize,
    /// Index of piece j.
    pub j: usize,
    /// Branch vector `l` from the centre of piece i to the image of piece j that it touches, m. Stress and fabric of branches take that of
    /// the bodies ([`Assembly::branch_of_bodies`]), which is the same where both are spheres.
    pub branch: Vector,
    /// Unit normal n from i to j.
    pub normal: Vector,
    /// Approach alpha = R_i + R_j - D, m.
    pub approach: f64,
    /// Elastic normal force N, compression positive, what a law of adhesion adds included, N.
    pub normal_force: f64,
    /// Elastic tangential force T on i, N.
    pub tangential_force: Vector,
    /// Radius a of the contact area, m.
    pub radius: f64,
    /// True if the tangential force was at the friction limit in the last step.
    pub sliding: bool,
    /// Elastic energy of the normal approach, J (zero at alpha = 0).
    pub normal_energy: f64,
    /// Elastic energy of the tangential displacement, J: `T^2 / (16 G* a)` without slip.
    pub tangential_energy: f64,
    /// Elastic energy of rolling and twisting, J; zero without a moment law.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling_energy: f64,
    /// Energy of an additional law of adhesion, J.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub attraction_energy: f64,
}

impl Contact {
    /// Elastic force on grain i, N: `-N n + T`.
    #[inline]
    pub fn force(&self) -> Vector {
        let ([x, y, z], [a, b, c], n) = (self.tangential_force, self.normal, self.normal_force);
        [x - n * a, y - n * b, z - n * c]
    }
}

/// A bond between pieces i and j that holds: a beam of cement or rock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Bond {
    /// Its number, in the order in which bonds were made.
    pub id: u64,
    /// Index of piece i in [`Assembly::pieces`].
    pub i: usize,
    /// Index of piece j.
    pub j: usize,
    /// From the centre of piece i to the image of piece j that it joins, m.
    pub branch: Vector,
    /// Unit vector along the bond, from i to j.
    pub normal: Vector,
    /// Radius r_b, m.
    pub radius: f64,
    /// Length l when it was made, m.
    pub length: f64,
    /// Normal force, compression positive, N.
    pub normal_force: f64,
    /// Shear force on i, N.
    pub shear_force: Vector,
    /// Twisting couple on i about the normal, N m.
    pub twisting_couple: f64,
    /// Bending couple on i, N m.
    pub bending_couple: Vector,
    /// Elastic energy, J.
    pub energy: f64,
    /// How near it is to rupture: the larger of its two ratios of load to strength.
    pub utilisation: f64,
    /// Its type: the number, from 1, of the formation of bonds by which it was made; 0 where none is known.
    #[serde(default = "first_type", skip_serializing_if = "is_first_type")]
    pub kind: u32,
}

fn first_type() -> u32 {
    1
}

fn is_first_type(kind: &u32) -> bool {
    *kind == 1
}

impl Bond {
    /// Elastic force on piece i, N.
    #[inline]
    pub fn force(&self) -> Vector {
        std::array::from_fn(|k| self.shear_force[k] - self.normal_force * self.normal[k])
    }
}

/// How a bond ruptured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Rupture {
    /// By tension, with bending.
    Tension,
    /// By shear, with twist.
    Shear,
}

/// A bond that ruptured: a crack.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BrokenBond {
    /// Its number, in the order in which bonds were made.
    pub id: u64,
    /// Ids of the bodies that it joined.
    pub bodies: [u64; 2],
    /// How it ruptured.
    pub rupture: Rupture,
    /// The elastic energy that it had, J.
    pub energy: f64,
    /// Time since the start of the phase, s, and the number of the phase, from 0 where the first bonds were made.
    pub time: f64,
    /// See `time`.
    pub phase: u32,
    /// Where: shares of the edges of the cell. A crack stays there while the cell is deformed.
    pub place: Vector,
    /// Unit vector along the bond: the normal of the crack.
    pub normal: Vector,
    /// Radius of the bond, m.
    pub radius: f64,
}

/// Where the liquid of wet grains is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Liquid {
    /// Volume of liquid in the films of all grains, m3.
    pub films: f64,
    /// Volume of liquid in all bridges, m3.
    pub bridges: f64,
    /// Number of bridges.
    pub count: usize,
}

/// A read-only snapshot of a simulation at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Assembly {
    /// Time since the start of the phase, s.
    pub time: f64,
    /// Steps since the start of the phase.
    pub step: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Edge matrix H of the periodic cell: column k is edge k, m.
    pub cell: Matrix,
    /// Velocity gradient L of the cell, 1/s (negative in compression).
    pub velocity_gradient: Matrix,
    /// Logarithmic strain of the cell since the start of the phase, compression positive.
    pub strain: Matrix,
    /// Arc length of the strain path over the same time.
    #[serde(default)]
    pub arc_length: f64,
    /// Target of the mean stress, Pa, where the servo has one.
    pub target_mean_stress: Option<f64>,
    /// The bodies, in order of their ids.
    pub bodies: Vec<Body>,
    /// The pieces, body by body in the same order. If every body is a sphere, each piece has the index of its body.
    pub pieces: Vec<Piece>,
    /// Orientation and inertia of the bodies of several pieces; empty if every body is a sphere.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rigid: Vec<Rigid>,
    /// The contacts that touch, in order of their pieces.
    pub contacts: Vec<Contact>,
    /// Pairs that act on each other without touching (by liquid bridges, say), in the same order: their force has a part in the
    /// stress, but they are no contacts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub apart: Vec<Contact>,
    /// The bonds that hold, in the order of their numbers; empty without bonds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub bonds: Vec<Bond>,
    /// The bonds that ruptured, in the order in which they did.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub broken_bonds: Vec<BrokenBond>,
    /// Names of the materials, if there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<String>,
    /// Liquid in films and bridges, where a law of adhesion shares liquid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub liquid: Option<Liquid>,
    /// Energy by mechanism.
    pub energy: EnergyBalance,
}

impl Assembly {
    /// Volume V of the cell, m3.
    pub fn volume(&self) -> f64 {
        determinant(&self.cell).abs()
    }

    /// The same with these spheres as its bodies and pieces.
    pub fn with_spheres(mut self, spheres: impl IntoIterator<Item = Sphere>) -> Assembly {
        self.bodies.clear();
        self.pieces.clear();
        self.rigid.clear();
        for sphere in spheres {
            self.push_sphere(sphere);
        }
        self
    }

    /// Adds a sphere as the last body.
    pub fn push_sphere(&mut self, sphere: Sphere) {
        let Sphere { position, radius, .. } = sphere;
        self.pieces.push(Piece { body: self.bodies.len(), position, radius, arm: [0.0; 3] });
        self.bodies.push(sphere.into());
    }

    /// The bodies as spheres, if all of them are.
    pub fn spheres(&self) -> Option<Vec<Sphere>> {
        let sphere = |(body, piece): (&Body, &Piece)| Sphere {
            id: body.id,
            position: body.position,
            velocity: body.velocity,
            spin: body.spin,
            radius: piece.radius,
            mass: body.mass,
            force: body.force,
            torque: body.torque,
            material: body.material,
        };
        self.all_spheres().then(|| self.bodies.iter().zip(&self.pieces).map(sphere).collect())
    }

    /// Moves every position, of bodies and pieces.
    pub fn move_positions(&mut self, place: impl Fn(&Vector) -> Vector) {
        self.bodies.iter_mut().for_each(|body| body.position = place(&body.position));
        self.pieces.iter_mut().for_each(|piece| piece.position = place(&piece.position));
    }

    /// True if there are bonds, or were.
    pub fn is_bonded(&self) -> bool {
        !(self.bonds.is_empty() && self.broken_bonds.is_empty())
    }

    /// True if every body is a sphere, so that the index of a piece is that of its body.
    pub fn all_spheres(&self) -> bool {
        self.rigid.is_empty()
    }

    /// The body of a piece, as its index.
    pub fn body_of(&self, piece: usize) -> Option<usize> {
        self.pieces.get(piece).map(|piece| piece.body)
    }

    /// The bodies of a contact, as their indices; `None` if a piece does not exist.
    #[inline]
    pub fn bodies_of(&self, contact: &Contact) -> Option<[usize; 2]> {
        Some([self.pieces.get(contact.i)?.body, self.pieces.get(contact.j)?.body])
    }

    /// Twice the energy of rotation of a body, J: `2/5 m R^2 omega^2` of a sphere, `sum I_k omega_k^2` in the principal axes of others.
    pub fn rotation_doubled(&self, body: &Body) -> f64 {
        let Some(rigid) = body.rigid.and_then(|rigid| self.rigid.get(rigid as usize)) else {
            let square: f64 = body.spin.iter().map(|w| w * w).sum();
            return 0.4 * body.mass * body.equivalent_radius * body.equivalent_radius * square;
        };
        let spin = to_body(&matrix(&rigid.orientation), &body.spin);
        (0..3).map(|k| rigid.inertia[k] * spin[k] * spin[k]).sum()
    }

    /// Kinetic energy of the fluctuating motion and the spins, J: of spheres with the inertia `2/5 m R^2`, of other bodies with their principal
    /// moments.
    pub fn kinetic_energy(&self) -> f64 {
        let square = |v: &Vector| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let of = |body: &Body| match body.rigid {
            None => {
                let radius = body.equivalent_radius;
                0.5 * body.mass * (square(&body.velocity) + 0.4 * radius * radius * square(&body.spin))
            }
            Some(_) => 0.5 * (body.mass * square(&body.velocity) + self.rotation_doubled(body)),
        };
        self.bodies.iter().map(of).sum()
    }

    /// The branch vector of a contact between the centres of its bodies, m: `l + c_i - c_j` with the arms c of the pieces. The force of a
    /// contact times this vector, not that of the pieces, is its part in the stress.
    #[inline(always)]
    pub fn branch_of_bodies(&self, contact: &Contact) -> Vector {
        if self.all_spheres() {
            return contact.branch;
        }
        let (one, two) = (self.arm(contact.i), self.arm(contact.j));
        let [x, y, z] = contact.branch;
        [x + (one[0] - two[0]), y + (one[1] - two[1]), z + (one[2] - two[2])]
    }

    /// The branch vector of a bond between the centres of its bodies, m, as that of a contact.
    pub fn branch_of_bond(&self, bond: &Bond) -> Vector {
        let (one, two) = (self.arm(bond.i), self.arm(bond.j));
        std::array::from_fn(|a| bond.branch[a] + (one[a] - two[a]))
    }

    /// From the centre of its body to that of a piece, m; zero for a piece that does not exist.
    pub fn arm(&self, piece: usize) -> Vector {
        self.pieces.get(piece).map_or([0.0; 3], |piece| piece.arm)
    }

    /// The pairs of bodies that touch, each with the number of its contacts, in the order of the indices of the bodies. Two images of a body
    /// that touch another are one pair.
    pub fn pairs_of_bodies(&self) -> Vec<([usize; 2], usize)> {
        let mut pairs: Vec<[usize; 2]> = (self.contacts.iter())
            .filter_map(|contact| {
                let [i, j] = [self.body_of(contact.i)?, self.body_of(contact.j)?];
                Some([i.min(j), i.max(j)])
            })
            .collect();
        pairs.sort_unstable();
        pairs.chunk_by(|a, b| a == b).map(|equal| (equal[0], equal.len())).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_branch_of_bodies_joins_their_centres_and_pairs_are_counted_once() {
        let sphere = |id, x| Sphere { id, position: [x, 0.5, 0.5], radius: 0.25, ..Sphere::default() };
        let mut assembly = Assembly::default().with_spheres([sphere(1, 0.0), sphere(2, 0.5)]);
        let contact = Contact { i: 0, j: 1, branch: [0.5, 0.0, 0.0], ..Contact::default() };
        assembly.contacts = vec![contact; 2];
        assert!(assembly.all_spheres());
        assert_eq!(assembly.branch_of_bodies(&contact), [0.5, 0.0, 0.0]);
        assert_eq!(assembly.pairs_of_bodies(), [([0, 1], 2)]);
        // The second piece is on a body whose centre is farther away.
        assembly.rigid.push(Rigid { orientation: crate::rotation::IDENTITY, inertia: [1.0; 3] });
        assembly.bodies[1].rigid = Some(0);
        assembly.pieces[1].arm = [-0.125, 0.25, 0.0];
        assert!(!assembly.all_spheres());
        assert_eq!(assembly.branch_of_bodies(&contact), [0.625, -0.25, 0.0]);
    }
}
