//! The grains of a packing that have several pieces, as the bodies of an assembly.

use granum_core::assembly::{Assembly, Piece, Rigid, Vector};
use granum_core::geometry::{apply, invert};

use super::Packing;

impl Packing {
    /// Makes of the grains of an assembly those bodies that have several pieces, with the masses of the density one, since their own are not
    /// known.
    pub(crate) fn add_bodies(&self, assembly: &mut Assembly) {
        if self.bodies.is_empty() {
            return;
        }
        let inverse = invert(&assembly.cell);
        let cell = assembly.cell;
        let wrapped = |place: Vector| -> Vector {
            let back = apply(&cell, apply(&inverse, place).map(f64::floor));
            std::array::from_fn(|a| place[a] - back[a])
        };
        let spheres = std::mem::take(&mut assembly.pieces);
        let mut bodies = self.bodies.iter().peekable();
        for (at, sphere) in spheres.into_iter().enumerate() {
            let Some(packed) = bodies.next_if(|body| body.grain == at) else {
                assembly.pieces.push(sphere);
                continue;
            };
            let body = &mut assembly.bodies[at];
            body.mass = 4.0 / 3.0 * std::f64::consts::PI * body.equivalent_radius.powi(3);
            body.rigid = Some(assembly.rigid.len() as u32);
            let inertia = packed.inertia_over_mass.map(|moment| body.mass * moment);
            assembly.rigid.push(Rigid { orientation: packed.orientation, inertia });
            let centre = body.position;
            assembly.pieces.extend(packed.pieces.iter().map(|piece| Piece {
                body: at,
                position: wrapped(std::array::from_fn(|a| centre[a] + piece.arm[a])),
                radius: piece.radius,
                arm: piece.arm,
            }));
        }
    }
}
