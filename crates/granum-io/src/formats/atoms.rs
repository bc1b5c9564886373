//! The spheres of an assembly as most formats hold grains: a row a sphere. Of a body of several pieces each piece is one, with the body that
//! it is a part of.

use granum_core::assembly::{Assembly, Body, Quaternion, Vector};
use granum_core::geometry::{apply, cross};
use granum_core::rotation::IDENTITY;

/// One sphere: a grain, or a piece of one.
#[derive(Clone, Copy, Debug)]
pub(super) struct Atom {
    /// Its id: that of its grain, or where some grain has several pieces the number of the piece, from 1.
    pub(super) id: u64,
    /// The id of its grain.
    pub(super) body: u64,
    /// Its centre, inside the cell, m.
    pub(super) position: Vector,
    /// The centre of mass of its grain, m.
    pub(super) centre: Vector,
    /// From the centre of its grain to its own, m.
    pub(super) arm: Vector,
    /// Its radius, m.
    pub(super) radius: f64,
    /// Its share of the mass of its grain, by volume, kg: the masses of the pieces of a grain add up to that of the grain, so that each is less
    /// than density times volume where pieces overlap.
    pub(super) mass: f64,
    /// The mass of its grain, kg.
    pub(super) body_mass: f64,
    /// Its fluctuating velocity, that of the rotation of its grain included, m/s.
    pub(super) velocity: Vector,
    /// The spin of its grain, rad/s.
    pub(super) spin: Vector,
    /// The force on its grain, N, if that is one sphere.
    pub(super) force: Vector,
    /// The torque on its grain, N m, if that is one sphere.
    pub(super) torque: Vector,
    /// Its material.
    pub(super) material: u32,
    /// The orientation of its grain: w, x, y, z.
    pub(super) orientation: Quaternion,
}

impl Atom {
    /// Mass over volume of the sphere, kg/m3.
    pub(super) fn density(&self) -> f64 {
        self.mass / (4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3))
    }

    /// The velocity with the homogeneous part `L X` of the centre of its grain, m/s.
    pub(super) fn whole_velocity(&self, assembly: &Assembly) -> Vector {
        let affine = apply(&assembly.velocity_gradient, self.centre);
        std::array::from_fn(|a| self.velocity[a] + affine[a])
    }

    /// Its place beside the centre of its grain, wherever the faces of the cell are, m.
    pub(super) fn unwrapped(&self) -> Vector {
        std::array::from_fn(|a| self.centre[a] + self.arm[a])
    }
}

/// The spheres of an assembly, in the order of its pieces.
pub(super) fn atoms(assembly: &Assembly) -> Vec<Atom> {
    if assembly.all_spheres() {
        return assembly.bodies.iter().map(sphere).collect();
    }
    let mut cubes = vec![0.0; assembly.bodies.len()];
    for piece in &assembly.pieces {
        if let Some(sum) = cubes.get_mut(piece.body) {
            *sum += piece.radius.powi(3);
        }
    }
    let piece = |(k, piece): (usize, &granum_core::assembly::Piece)| {
        let body = assembly.bodies.get(piece.body)?;
        let turning = cross(&body.spin, &piece.arm);
        let rigid = body.rigid.and_then(|rigid| assembly.rigid.get(rigid as usize));
        Some(Atom {
            id: k as u64 + 1,
            position: piece.position,
            arm: piece.arm,
            radius: piece.radius,
            mass: body.mass * (piece.radius.powi(3) / cubes[piece.body]),
            velocity: std::array::from_fn(|a| body.velocity[a] + turning[a]),
            force: [0.0; 3],
            torque: [0.0; 3],
            orientation: rigid.map_or(IDENTITY, |rigid| rigid.orientation),
            ..sphere(body)
        })
    };
    assembly.pieces.iter().enumerate().filter_map(piece).collect()
}

/// A grain that is one sphere.
fn sphere(body: &Body) -> Atom {
    Atom {
        id: body.id,
        body: body.id,
        position: body.position,
        centre: body.position,
        arm: [0.0; 3],
        radius: body.equivalent_radius,
        mass: body.mass,
        body_mass: body.mass,
        velocity: body.velocity,
        spin: body.spin,
        force: body.force,
        torque: body.torque,
        material: body.material,
        orientation: IDENTITY,
    }
}
