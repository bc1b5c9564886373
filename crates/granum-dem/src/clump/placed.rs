//! Bodies of given shapes as the rows and clumps of a simulation.

use std::collections::HashSet;

use granum_core::rotation::{matrix, normalized, to_space};
use granum_shape::RigidShape;

use super::clumps::{Clump, ClumpPiece, Clumps};
use super::time_step;
use crate::cell::Cell;
use crate::initial_body::InitialBody;
use crate::initial_sphere::InitialSphere;
use crate::properties::Properties;
use crate::simulation_error::SimulationError;

/// Bodies as rows, of which those of clumps are known.
pub(crate) struct PlacedBodies {
    pub(crate) rows: Vec<InitialSphere>,
    /// The material of each row; empty where there is one material.
    pub(crate) materials: Vec<u8>,
    pub(crate) clumps: Clumps,
}

impl PlacedBodies {
    /// Bodies in a cell; masses follow from the densities of their materials.
    pub(crate) fn place(
        cell: &Cell,
        shapes: &[RigidShape],
        bodies: &[InitialBody],
        materials: &[u8],
        properties: &Properties,
    ) -> Result<PlacedBodies, SimulationError> {
        check(cell, shapes, bodies)?;
        let shares: Vec<f64> = shapes.iter().map(time_step::time_step_share).collect();
        let mut placed = PlacedBodies { rows: Vec::new(), materials: Vec::new(), clumps: Clumps::default() };
        for (k, body) in bodies.iter().enumerate() {
            let (shape, material) = (&shapes[body.shape], materials.get(k).copied());
            placed
                .materials
                .extend(material.iter().flat_map(|m| std::iter::repeat_n(*m, shape.pieces.len())));
            if let Some(radius) = shape.as_sphere() {
                let radius = body.scale * radius;
                placed.rows.push(InitialSphere { id: body.id, position: body.position, radius });
            } else {
                let density = properties.density_of(material);
                placed.add_clump(body, shape, density, shares[body.shape]);
            }
        }
        Ok(placed)
    }

    fn add_clump(&mut self, body: &InitialBody, shape: &RigidShape, density: f64, time_step_share: f64) {
        let (scale, square) = (body.scale, body.scale * body.scale);
        let volume = square * scale * shape.volume;
        let mass = density * volume;
        let first = self.clumps.pieces.len() as u32;
        let orientation = normalized(&body.orientation);
        let rotation = matrix(&orientation);
        for piece in &shape.pieces {
            let centre = piece.centre.map(|x| scale * x);
            let arm = to_space(&rotation, &centre);
            let position = std::array::from_fn(|a| body.position[a] + arm[a]);
            let row = self.rows.len() as u32;
            self.clumps.pieces.push(ClumpPiece { centre, radius: scale * piece.radius, row, image: [0; 3] });
            self.rows.push(InitialSphere { id: body.id, position, radius: scale * piece.radius });
        }
        self.clumps.bodies.push(Clump {
            id: body.id,
            centre: body.position,
            velocity: [0.0; 3],
            orientation,
            momentum: [0.0; 3],
            mass,
            inertia: shape.inertia_over_mass.map(|moment| mass * square * moment),
            volume,
            time_step_share,
            pieces: [first, self.clumps.pieces.len() as u32],
        });
    }
}

fn check(cell: &Cell, shapes: &[RigidShape], bodies: &[InitialBody]) -> Result<(), SimulationError> {
    let height = cell.heights().into_iter().fold(f64::INFINITY, f64::min);
    let mut ids = HashSet::with_capacity(bodies.len());
    for body in bodies {
        let wrong = |what: String| SimulationError::Grain { id: body.id, what };
        let Some(shape) = shapes.get(body.shape) else {
            return Err(wrong(format!(
                "its shape is number {}, and there are {} shapes, counted from 0",
                body.shape,
                shapes.len()
            )));
        };
        if let Some(fault) = shape.fault() {
            return Err(wrong(fault));
        }
        if !ids.insert(body.id) {
            return Err(wrong("its id occurs twice; ids must differ".into()));
        }
        if body.position.iter().chain(&body.orientation).any(|x| !x.is_finite()) {
            return Err(wrong(format!(
                "its position {:?} or its orientation {:?} is not finite",
                body.position, body.orientation
            )));
        }
        if body.orientation == [0.0; 4] {
            return Err(wrong("its orientation has no length; no rotation is [1, 0, 0, 0]".into()));
        }
        if !(body.scale > 0.0 && body.scale.is_finite()) {
            return Err(wrong(format!("the scale of its shape is {}; it must be positive", body.scale)));
        }
        // Two images of a body must not touch the same piece of another.
        let diameter = 2.0 * body.scale * shape.reach();
        if shape.as_sphere().is_none() && height < 2.0 * diameter {
            return Err(SimulationError::ThinForClumps { height, diameter });
        }
    }
    Ok(())
}
