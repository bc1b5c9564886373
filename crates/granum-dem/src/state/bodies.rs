//! The bodies of a state: spheres, which are rows, and clumps.

use super::State;
use crate::clump::clumps::NO_CLUMP;
use crate::particle_row::ParticleRow;
use granum_shape::equivalent_radius;

/// Where the data of a body are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum BodyPlace {
    /// A sphere: its row.
    Sphere(usize),
    /// A clump: its place among the clumps.
    Clump(usize),
}

impl State {
    /// The bodies in the order of their ids, which is the same before and after a restart: the order in memory changes when pieces are
    /// sorted in space.
    pub(crate) fn bodies_in_order(&self) -> Vec<BodyPlace> {
        let ids = &self.ids;
        if !self.has_clumps() {
            return self.rows_in_order().into_iter().map(BodyPlace::Sphere).collect();
        }
        let clump_of = self.clumps.of_rows(ids.len());
        let mut bodies: Vec<(u64, BodyPlace)> = (ids.iter().enumerate())
            .filter(|(row, _)| clump_of[*row] == NO_CLUMP)
            .map(|(row, id)| (*id, BodyPlace::Sphere(row)))
            .collect();
        bodies
            .extend(self.clumps.bodies.iter().enumerate().map(|(k, clump)| (clump.id, BodyPlace::Clump(k))));
        bodies.sort_unstable_by_key(|(id, _)| *id);
        bodies.into_iter().map(|(_, body)| body).collect()
    }

    /// The rows in the order of their ids, where each has one of its own.
    pub(crate) fn rows_in_order(&self) -> Vec<usize> {
        let n = self.pieces();
        let ids = &self.ids[..n];
        // Mostly the ids are 1..=n, and each of them is the place of its grain.
        let mut order = vec![usize::MAX; n];
        for (g, &id) in ids.iter().enumerate() {
            match order.get_mut((id as usize).wrapping_sub(1)) {
                Some(place) if *place == usize::MAX => *place = g,
                _ => {
                    order = (0..n).collect();
                    order.sort_unstable_by_key(|&g| ids[g]);
                    return order;
                }
            }
        }
        order
    }

    /// The pieces in the order in which an assembly lists them: body by body, in the order of the ids of the bodies, and on a body in the
    /// order of its shape.
    pub(crate) fn pieces_in_order(&self, bodies: &[BodyPlace]) -> Vec<usize> {
        let mut rows = Vec::with_capacity(self.pieces());
        for body in bodies {
            match body {
                BodyPlace::Sphere(row) => rows.push(*row),
                BodyPlace::Clump(k) => {
                    let pieces = self.clumps.pieces_of(&self.clumps.bodies[*k]);
                    rows.extend(pieces.iter().map(|piece| piece.row as usize));
                }
            }
        }
        rows
    }

    /// Radius of the sphere of the volume of a body, m.
    pub(crate) fn equivalent_radius(&self, body: BodyPlace) -> f64 {
        match body {
            BodyPlace::Sphere(row) => self.particles[row].radius(),
            BodyPlace::Clump(k) => equivalent_radius(self.clumps.bodies[k].volume),
        }
    }

    /// The row of a body, or that of its first piece.
    pub(crate) fn row_of(&self, body: BodyPlace) -> usize {
        match body {
            BodyPlace::Sphere(row) => row,
            BodyPlace::Clump(k) => self.clumps.pieces_of(&self.clumps.bodies[k])[0].row as usize,
        }
    }
}
