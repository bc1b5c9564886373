//! Random insertion of grains of any shape without overlap, from a seed.
//!
//! Each grain gets its orientation first and keeps it while a place is looked for, so that the orientations are those of the case whatever
//! their neighbours are. Grains whose spheres fill little of the ball around them cannot be placed as densely as spheres: where random
//! placing does not succeed, the cell is enlarged.

use granum_core::rotation::{Quaternion, about, matrix, product, to_space};
use granum_shape::RigidShape;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::assembly::Vector;
use crate::cell::Cell;
use crate::config::{Bedding, Grains};
use crate::initial_body::InitialBody;
use crate::observer::SimulationObserver;
use crate::random::unit;
use crate::random_insertion::{Boxes, InsertionError, Listen};

/// Number of attempts for one grain after which the cell is enlarged.
const TRIES: usize = 3000;
/// Factor on the solid fraction where there was no room, and the smallest one that is tried.
const LOOSER: f64 = 0.85;
const LOOSEST: f64 = 0.005;
/// The axis of the first principal stress, along which grains are deposited.
const VERTICAL: Vector = [1.0, 0.0, 0.0];

/// Grains of any shape, placed.
#[derive(Clone, Debug)]
pub struct PlacedGrains {
    /// The cell.
    pub cell: Cell,
    /// The different shapes.
    pub shapes: Vec<RigidShape>,
    /// The grains.
    pub bodies: Vec<InitialBody>,
    /// The material of each grain; empty where there is one.
    pub materials: Vec<u8>,
    /// The solid fraction at which they found room.
    pub solid_fraction: f64,
}

/// Places grains of any shape at random in a cubic cell, at this solid fraction or at the largest one below it at which they find room.
/// Materials are those that the grains have by their place ([`crate::mixture::Mixture::assign`]).
///
/// # Errors
/// If the grains cannot have these sizes or shapes, or there is no room for one of them; [`InsertionError::Stopped`] if the observer stops
/// it.
pub fn insert_bodies(
    grains: &Grains,
    bedding: Option<Bedding>,
    solid_fraction: f64,
    seed: u64,
    observer: &mut dyn SimulationObserver,
) -> Result<PlacedGrains, InsertionError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut diameters = grains.diameters(&mut rng)?;
    diameters.sort_unstable_by(|a, b| b.total_cmp(a));
    let materials = grains.mixture.assign(diameters.len(), seed);
    let assigned = grains.assign_shapes(&diameters, &materials)?;
    let body = |k: usize, rng: &mut ChaCha8Rng| InitialBody {
        id: k as u64 + 1,
        position: [0.0; 3],
        orientation: orientation(bedding, rng),
        shape: assigned.of_grains[k],
        scale: assigned.scales[k],
    };
    let mut bodies: Vec<InitialBody> = (0..diameters.len()).map(|k| body(k, &mut rng)).collect();
    let solid: f64 =
        bodies.iter().map(|b| b.scale * b.scale * b.scale * assigned.shapes[b.shape].volume).sum();
    let mut listen = Listen::new(observer, bodies.len());
    let (mut tried, mut most) = (solid_fraction, 0);
    while tried > LOOSEST {
        let length = libm::cbrt(solid / tried);
        match place(&mut bodies, &assigned.shapes, length, &mut rng, &mut listen)? {
            None => {
                let cell = Cell::cuboid([length; 3]);
                return Ok(PlacedGrains {
                    cell,
                    shapes: assigned.shapes,
                    bodies,
                    materials,
                    solid_fraction: tried,
                });
            }
            Some(placed) => most = most.max(placed),
        }
        tried *= LOOSER;
    }
    Err(InsertionError::NoRoom { placed: most, count: bodies.len(), solid_fraction })
}

/// Places the grains in their order; the number of those placed if one found no room.
fn place(
    bodies: &mut [InitialBody],
    shapes: &[RigidShape],
    length: f64,
    rng: &mut ChaCha8Rng,
    listen: &mut Listen,
) -> Result<Option<usize>, InsertionError> {
    let largest = bodies
        .iter()
        .flat_map(|body| shapes[body.shape].pieces.iter().map(|piece| body.scale * piece.radius))
        .fold(0.0, f64::max);
    let mut boxes = Boxes::new(length, 2.0 * largest);
    let mut pieces: Vec<(Vector, f64)> = Vec::new();
    for (k, body) in bodies.iter_mut().enumerate() {
        let rotation = matrix(&body.orientation);
        let shape = &shapes[body.shape];
        // In a cell that is not wider than the grain it would touch its own image.
        if length < 4.0 * body.scale * shape.reach() {
            return Ok(Some(k));
        }
        let mut found = false;
        for _ in 0..TRIES {
            listen.tell(k)?;
            body.position = [(); 3].map(|()| length * unit(rng));
            pieces.clear();
            pieces.extend(shape.pieces.iter().map(|piece| {
                let arm = to_space(&rotation, &piece.centre);
                let place = |a: usize| into(body.position[a] + body.scale * arm[a], length);
                ([place(0), place(1), place(2)], body.scale * piece.radius)
            }));
            if pieces.iter().all(|(centre, radius)| boxes.free(centre, *radius)) {
                found = true;
                break;
            }
        }
        if !found {
            return Ok(Some(k));
        }
        for (centre, radius) in &pieces {
            boxes.insert(*centre, *radius);
        }
    }
    Ok(None)
}

/// A coordinate in a cell of this length.
fn into(x: f64, length: f64) -> f64 {
    let inside = x - length * (x / length).floor();
    if inside < length { inside } else { 0.0 }
}

/// The orientation of a grain: uniform over all rotations, or as deposited in layers.
fn orientation(bedding: Option<Bedding>, rng: &mut ChaCha8Rng) -> Quaternion {
    match bedding {
        None => random_rotation(rng),
        Some(bedding) => deposited(bedding, rng),
    }
}

/// A rotation that is uniform over all rotations (Shoemake 1992).
fn random_rotation(rng: &mut ChaCha8Rng) -> Quaternion {
    let (share, a, b) = (unit(rng), std::f64::consts::TAU * unit(rng), std::f64::consts::TAU * unit(rng));
    let ((sa, ca), (sb, cb)) = (libm::sincos(a), libm::sincos(b));
    let (p, q) = ((1.0 - share).sqrt(), share.sqrt());
    [q * cb, p * sa, p * ca, q * sb]
}

/// The longest axis (the first of the body) in the plane of the layer, in any direction of it, and the shortest axis (the third) along its
/// normal; then turned by random angles about the other two axes, and with the layer.
fn deposited(bedding: Bedding, rng: &mut ChaCha8Rng) -> Quaternion {
    // Takes the axes 1, 2, 3 of the body to 2, 3, 1 of space: the normal of a layer is axis 1.
    let lying = [0.5, 0.5, 0.5, 0.5];
    let turned = about(&VERTICAL, std::f64::consts::TAU * unit(rng));
    let about_second = about(&[0.0, 1.0, 0.0], bedding.spread * normal(rng));
    let about_first = about(&[1.0, 0.0, 0.0], bedding.spread * normal(rng));
    let layer = about(&[0.0, 0.0, 1.0], bedding.tilt);
    product(&layer, &product(&turned, &product(&lying, &product(&about_second, &about_first))))
}

/// A number of the normal distribution (Box and Muller 1958).
fn normal(rng: &mut ChaCha8Rng) -> f64 {
    let (share, angle) = (1.0 - unit(rng), std::f64::consts::TAU * unit(rng));
    (-2.0 * libm::log(share)).sqrt() * libm::cos(angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::NoObserver;
    use granum_shape::{ShapeEntry, ShapeKind};

    fn grains(kind: ShapeKind, count: usize) -> Grains {
        Grains::default().with(|grains| {
            grains.count = count;
            grains.spread = 0.2;
            grains.shapes = vec![ShapeEntry::new(kind)];
        })
    }

    #[test]
    fn no_two_grains_overlap_and_the_volume_is_that_of_the_sizes() {
        let placed =
            insert_bodies(&grains(ShapeKind::TETRAPOD, 120), None, 0.25, 7, &mut NoObserver).unwrap();
        let length = placed.cell.edges[0][0];
        let pieces: Vec<(usize, Vector, f64)> = (placed.bodies.iter().enumerate())
            .flat_map(|(k, body)| {
                let rotation = matrix(&body.orientation);
                let piece = move |piece: &granum_shape::ShapePiece| {
                    let arm = to_space(&rotation, &piece.centre);
                    (
                        k,
                        std::array::from_fn(|a| body.position[a] + body.scale * arm[a]),
                        body.scale * piece.radius,
                    )
                };
                placed.shapes[body.shape].pieces.iter().map(piece).collect::<Vec<_>>()
            })
            .collect();
        for (k, (a, x, r)) in pieces.iter().enumerate() {
            for (b, y, s) in pieces[..k].iter().filter(|(b, ..)| b != a) {
                let square: f64 = (0..3)
                    .map(|c| {
                        let d = x[c] - y[c];
                        (d - length * (d / length).round()).powi(2)
                    })
                    .sum();
                assert!(square.sqrt() > r + s, "{a} and {b}");
            }
        }
        let solid: f64 = placed.bodies.iter().map(|b| std::f64::consts::PI / 6.0 * b.scale.powi(3)).sum();
        assert!((solid / placed.cell.volume() - placed.solid_fraction).abs() < 1e-9);
    }

    #[test]
    fn where_there_is_no_room_the_cell_is_larger() {
        let long = Grains {
            shapes: vec![ShapeEntry::new(ShapeKind::CAPSULE).with("aspect_ratio", 3.0)],
            ..grains(ShapeKind::SPHERE, 80)
        };
        let placed = insert_bodies(&long, None, 0.45, 3, &mut NoObserver).unwrap();
        assert!(placed.solid_fraction < 0.45 && placed.solid_fraction > 0.1, "{}", placed.solid_fraction);
    }

    #[test]
    fn random_orientations_have_no_direction_and_deposited_grains_lie() {
        let of = |bedding| {
            let placed =
                insert_bodies(&grains(ShapeKind::DIMER, 2000), bedding, 0.1, 5, &mut NoObserver).unwrap();
            let mut tensor = [[0.0; 3]; 3];
            for body in &placed.bodies {
                let u = to_space(&matrix(&body.orientation), &[1.0, 0.0, 0.0]);
                for r in 0..3 {
                    for c in 0..3 {
                        tensor[r][c] += u[r] * u[c] / placed.bodies.len() as f64;
                    }
                }
            }
            tensor
        };
        let random = of(None);
        for r in 0..3 {
            assert!((random[r][r] - 1.0 / 3.0).abs() < 0.03, "{random:?}");
        }
        let spread = 0.2;
        let lying = of(Some(Bedding { tilt: 0.0, spread }));
        // The mean of the squared sine of a normal angle.
        let golden = 0.5 * (1.0 - (-2.0f64 * spread * spread).exp());
        assert!(
            (lying[0][0] - golden).abs() < 0.006 && (lying[1][1] - lying[2][2]).abs() < 0.05,
            "{lying:?} {golden}"
        );
        // A layer on edge: its normal is axis 2.
        let on_edge = of(Some(Bedding { tilt: 0.5 * std::f64::consts::PI, spread }));
        assert!((on_edge[1][1] - golden).abs() < 0.006, "{on_edge:?}");
    }
}
