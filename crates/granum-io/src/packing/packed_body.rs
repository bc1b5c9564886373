//! One grain of a packing that has several pieces.

use granum_core::assembly::{Assembly, Body, Quaternion, Vector};

/// One grain of a packing that has several pieces. Its centre of mass and the radius of the sphere of its volume are those of its
/// [`PackedGrain`](super::PackedGrain).
#[derive(Clone, Debug, PartialEq)]
pub struct PackedBody {
    /// Its place among the grains of the packing, from 0.
    pub grain: usize,
    /// The rotation from its principal axes to those of space: w, x, y, z.
    pub orientation: Quaternion,
    /// Principal moments of inertia over the mass, m2.
    pub inertia_over_mass: Vector,
    /// Its pieces.
    pub pieces: Vec<PackedPiece>,
}

/// A sphere that is fixed on a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackedPiece {
    /// From the centre of mass of the grain to its own, in the axes of space, m.
    pub arm: Vector,
    /// Radius, m.
    pub radius: f64,
}

impl PackedBody {
    /// Largest distance of its surface from its centre of mass, m.
    pub fn reach(&self) -> f64 {
        let far = |piece: &PackedPiece| granum_core::geometry::length(&piece.arm) + piece.radius;
        self.pieces.iter().map(far).fold(0.0, f64::max)
    }

    /// The grains of an assembly that have several pieces.
    pub(crate) fn of_assembly(assembly: &Assembly) -> Vec<PackedBody> {
        let mut bodies: Vec<PackedBody> = Vec::new();
        let mut place = vec![None; assembly.bodies.len()];
        for (grain, body) in assembly.bodies.iter().enumerate() {
            if let Some(packed) = packed(assembly, grain, body) {
                place[grain] = Some(bodies.len());
                bodies.push(packed);
            }
        }
        for piece in &assembly.pieces {
            if let Some(at) = place.get(piece.body).copied().flatten() {
                bodies[at].pieces.push(PackedPiece { arm: piece.arm, radius: piece.radius });
            }
        }
        bodies
    }
}

/// A body without its pieces; none for a sphere.
fn packed(assembly: &Assembly, grain: usize, body: &Body) -> Option<PackedBody> {
    let rigid = assembly.rigid.get(body.rigid? as usize)?;
    let inertia_over_mass = rigid.inertia.map(|moment| moment / body.mass);
    Some(PackedBody { grain, orientation: rigid.orientation, inertia_over_mass, pieces: Vec::new() })
}
