//! Local solid fraction: the volume of each grain over that of its cell in the radical Voronoi tessellation (the power diagram;
//! Gellatly and Finney 1982), in which a point belongs to the grain with the smallest `|x - c|^2 - R^2`.
//!
//! The cell of a grain is bounded by the planes at `h = (D^2 + R_i^2 - R_j^2) / 2D` along the branches of length D to its
//! neighbours. Its volume is the sum over its faces of area times h over 3 (Gauss), where each face is a large square in its
//! plane that is clipped by all other planes: each face is computed independently, so that the method is robust where planes
//! nearly meet in one point. A neighbour that is farther away than the corners of the cell allow cannot cut it; the search
//! distance is increased until this is the case for all neighbours beyond it.
//!
//! The cell of a grain of several pieces is that of its pieces together, without the faces between them, and its solid volume is that of
//! the union of the pieces. Towards one neighbour it can have several faces.
//!
//! The volumes add up to that of the periodic cell; `voronoi_gap` is the relative difference, which is due to rounding only.

use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::{cross, dot};
use granum_core::{Assembly, Part};
use granum_dem::config::Recording;

use crate::neighbours::{Neighbours, TOO_MUCH_WORK, most_work};
use crate::ratio::{mean, ratio};
use crate::{Bins, Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Distance up to which neighbours are searched first, over the largest radius.
const FIRST_REACH: f64 = 4.0;

/// The sensor.
pub struct LocalSolidFraction;

impl Sensor for LocalSolidFraction {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "local_solid_fraction",
            "solid fraction of each grain's cell in the radical Voronoi tessellation",
        )
        .speaking_of(Subject::Bodies)
        .columns([
            SensorColumn::new("local_solid_fraction", "1", "mean over the grains"),
            SensorColumn::new("local_solid_fraction_deviation", "1", "standard deviation over the grains"),
            SensorColumn::new("voronoi_faces", "1", "mean number of faces of a cell"),
            SensorColumn::new(
                "voronoi_gap",
                "1",
                "sum of the volumes over that of the periodic cell, less 1",
            ),
        ])
        .needing(&[Part::Cell, Part::Positions, Part::Radii])
    }

    fn histograms(&self, _: &Recording) -> Vec<Bins> {
        vec![Bins::new("local_solid_fractions", "solid_fraction", "1").width(0.01).range(0.0, 1.0)]
    }

    /// The first reach; the search widens where much of the cell is empty, and gives up where that takes too long.
    fn reach(&self, assembly: &Assembly) -> f64 {
        FIRST_REACH * assembly.pieces.iter().fold(0.0, |largest, piece| piece.radius.max(largest))
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let Assembly { bodies, pieces, .. } = observation.assembly;
        let positions: Vec<Vector> = pieces.iter().map(|piece| piece.position).collect();
        let radii: Vec<f64> = pieces.iter().map(|piece| piece.radius).collect();
        let owners: Vec<usize> = pieces.iter().map(|piece| piece.body).collect();
        let mut work = Work(most_work(pieces.len()));
        let cell = &observation.assembly.cell;
        let Some(cells) = tessellation(cell, &positions, &radii, &owners, &mut work) else {
            return values.give_up(TOO_MUCH_WORK);
        };
        let solid = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
        // A small grain amid large ones may have no cell at all.
        let fractions: Vec<f64> = (of_bodies(observation.assembly, &cells).iter().zip(bodies))
            .filter(|(volume, _)| **volume > 0.0)
            .map(|(volume, body)| solid(body.equivalent_radius) / volume)
            .collect();
        let of = |sum: f64| mean(sum + 0.0, fractions.len());
        let average = of(fractions.iter().sum());
        let square = of(fractions.iter().map(|x| (x - average) * (x - average)).sum());
        let faces: usize = cells.iter().map(|cell| cell.faces).sum();
        let volume: f64 = cells.iter().map(|cell| cell.volume).sum();
        let gap = if volume > 0.0 { ratio(volume, observation.volume) - 1.0 } else { 0.0 };
        values.extend([average, square.sqrt(), mean(faces as f64, bodies.len()), gap]);
        values.count(0, fractions);
    }
}

/// The volume that belongs to each body, m3: that of the cells of its pieces.
fn of_bodies(assembly: &Assembly, cells: &[VoronoiCell]) -> Vec<f64> {
    let mut volumes = vec![0.0; if cells.is_empty() { 0 } else { assembly.bodies.len() }];
    for (piece, cell) in assembly.pieces.iter().zip(cells) {
        volumes[piece.body] += cell.volume;
    }
    volumes
}

/// The cell of a sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VoronoiCell {
    /// Its volume, m3.
    pub volume: f64,
    /// Number of its faces.
    pub faces: usize,
}

/// The cells of the radical Voronoi tessellation of spheres in a periodic cell; empty without a volume or spheres with a radius.
///
/// ```
/// use granum_sensors::local_solid_fraction::radical_voronoi;
///
/// let cell = [[2.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
/// let cells = radical_voronoi(&cell, &[[0.5, 0.5, 0.5], [1.5, 0.5, 0.5]], &[0.5, 0.4]);
/// // The planes are at a distance of (1 + 0.25 - 0.16) / 2 = 0.545 from the larger sphere.
/// assert!((cells[0].volume - 1.09).abs() < 1e-12 && (cells[1].volume - 0.91).abs() < 1e-12);
/// assert_eq!(cells[0].faces, 6);
/// ```
pub fn radical_voronoi(cell: &Matrix, centres: &[Vector], radii: &[f64]) -> Vec<VoronoiCell> {
    tessellation(cell, centres, radii, &[], &mut Work(f64::INFINITY)).unwrap_or_default()
}

/// Steps of work that are left.
struct Work(f64);

impl Work {
    /// Takes steps; `None` if there are not as many left.
    fn take(&mut self, steps: f64) -> Option<()> {
        self.0 -= steps;
        (self.0 >= 0.0).then_some(())
    }
}

/// As [`radical_voronoi`]; `None` if it would take more work. Faces between spheres of one owner do not count.
fn tessellation(
    cell: &Matrix,
    centres: &[Vector],
    radii: &[f64],
    owners: &[usize],
    work: &mut Work,
) -> Option<Vec<VoronoiCell>> {
    let largest = radii.iter().fold(0.0f64, |largest, radius| largest.max(*radius));
    let mut cells = vec![None; centres.len().min(radii.len())];
    let mut reach = FIRST_REACH * largest;
    // Beyond the sum of the edges even a single sphere has all of its images as neighbours.
    for _ in 0..40 {
        let Some(neighbours) = Neighbours::new(cell, centres, reach) else { return Some(Vec::new()) };
        let open: Vec<usize> = (0..cells.len()).filter(|&i| cells[i].is_none()).collect();
        work.take(neighbours.work(open.iter().copied(), work.0))?;
        for i in open {
            let planes = planes_of(i, &neighbours, radii, owners);
            cells[i] = cell_of(&planes, reach, [radii[i], largest], work)?;
        }
        if cells.iter().all(Option::is_some) {
            break;
        }
        reach *= 1.5;
    }
    Some(cells.into_iter().map(Option::unwrap_or_default).collect())
}

/// A plane `x . normal = height`; the cell lies below it.
#[derive(Clone, Copy)]
struct Plane {
    normal: Vector,
    height: f64,
    /// True if it is between two spheres of one owner.
    inner: bool,
}

/// The planes between a grain and its neighbours, the nearest first.
fn planes_of(i: usize, neighbours: &Neighbours, radii: &[f64], owners: &[usize]) -> Vec<Plane> {
    let mut planes = Vec::new();
    neighbours.each_of(i, |j, branch, distance| {
        // Spheres with one centre have no plane between them.
        if distance > 0.0 {
            let (own, other) = (radii[i], radii[j]);
            let height = 0.5 * (distance * distance + own * own - other * other) / distance;
            let inner = i != j && owners.get(i).is_some_and(|owner| owners.get(j) == Some(owner));
            planes.push(Plane { normal: branch.map(|x| x / distance), height, inner });
        }
    });
    planes.sort_by(|a, b| a.height.total_cmp(&b.height));
    planes
}

/// Planes of which a first, larger cell is made.
const NEAREST: usize = 20;

/// Work of cutting a face by a plane, in steps.
const STEPS_OF_A_CUT: f64 = 10.0;

/// Planes that are taken at once, without a try of fewer.
const MANY: usize = 8 * NEAREST;

/// The cell below all planes, which are sorted by distance; `Some(None)` if a sphere beyond the reach might cut it, `None` if it would
/// take more work.
fn cell_of(
    planes: &[Plane],
    reach: f64,
    [own, largest]: [f64; 2],
    work: &mut Work,
) -> Option<Option<VoronoiCell>> {
    let mut count = planes.len().min(NEAREST);
    let (mut found, mut farthest) = intersection(&planes[..count], reach, work)?;
    // Planes beyond all corners of the cell of the nearest planes cannot cut it.
    loop {
        let near = planes.iter().position(|plane| plane.height > farthest).unwrap_or(planes.len());
        if near <= count {
            break;
        }
        // Where the nearest planes close no cell, as for a grain at the side of a cluster, nearly all planes are near; their number
        // squared is the cost.
        count = if near <= MANY { near } else { near.min(4 * count) };
        (found, farthest) = intersection(&planes[..count], reach, work)?;
    }
    // The nearest plane that a sphere beyond the reach can give.
    let nearest = 0.5 * (reach * reach + own * own - largest * largest) / reach;
    Some((farthest <= nearest).then_some(found))
}

/// The part of space below some planes, and the distance of its farthest corner; `None` if it would take more work.
fn intersection(planes: &[Plane], reach: f64, work: &mut Work) -> Option<(VoronoiCell, f64)> {
    let mut found = VoronoiCell::default();
    let mut farthest = if planes.len() < 4 { f64::INFINITY } else { 0.0f64 };
    let mut face = Vec::new();
    let mut clipped = Vec::new();
    for (k, plane) in planes.iter().enumerate() {
        square(plane, 4.0 * reach, &mut face);
        for other in planes.iter().enumerate().filter(|(m, _)| *m != k).map(|(_, other)| other) {
            work.take(STEPS_OF_A_CUT)?;
            clip(&face, other, &mut clipped);
            std::mem::swap(&mut face, &mut clipped);
            if face.is_empty() {
                break;
            }
        }
        let area = area(&face, &plane.normal);
        if area > 0.0 {
            found.volume += area * plane.height / 3.0;
            // Rounding leaves slivers where more than three planes meet in a point.
            found.faces += usize::from(area > 1e-12 * reach * reach && !plane.inner);
            farthest = face.iter().fold(farthest, |far, x| far.max(dot(x, x).sqrt()));
        }
    }
    Some((found, farthest))
}

/// A square in the plane with corners at a distance `size` along two directions of it.
fn square(plane: &Plane, size: f64, corners: &mut Vec<Vector>) {
    let n = &plane.normal;
    // The axis that is least along the normal gives a first direction in the plane.
    let axis = (0..3).min_by(|&a, &b| n[a].abs().total_cmp(&n[b].abs())).unwrap_or(0);
    let mut u: Vector =
        std::array::from_fn(|a| if a == axis { 1.0 - n[axis] * n[a] } else { -n[axis] * n[a] });
    let length = dot(&u, &u).sqrt();
    u = u.map(|x| x / length);
    let v = cross(n, &u);
    let corner = |a: f64, b: f64| std::array::from_fn(|k| plane.height * n[k] + size * (a * u[k] + b * v[k]));
    corners.clear();
    corners.extend([corner(1.0, 1.0), corner(-1.0, 1.0), corner(-1.0, -1.0), corner(1.0, -1.0)]);
}

/// The part of a convex polygon that lies below a plane (Sutherland and Hodgman 1974).
fn clip(polygon: &[Vector], plane: &Plane, below: &mut Vec<Vector>) {
    below.clear();
    let Some(last) = polygon.last() else { return };
    let above = |x: &Vector| dot(x, &plane.normal) - plane.height;
    let (mut from, mut height) = (last, above(last));
    for to in polygon {
        let next = above(to);
        if (height <= 0.0) != (next <= 0.0) {
            let share = height / (height - next);
            below.push(std::array::from_fn(|a| from[a] + share * (to[a] - from[a])));
        }
        if next <= 0.0 {
            below.push(*to);
        }
        (from, height) = (to, next);
    }
}

/// Area of a polygon in a plane.
fn area(polygon: &[Vector], normal: &Vector) -> f64 {
    let Some(first) = polygon.first() else { return 0.0 };
    let arm = |x: &Vector| -> Vector { std::array::from_fn(|a| x[a] - first[a]) };
    let triangle = |pair: &[Vector]| dot(&cross(&arm(&pair[0]), &arm(&pair[1])), normal);
    0.5 * polygon.windows(2).map(triangle).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::clumps::{self, Clump};
    use crate::lattice;
    use crate::sensor::measured;
    use granum_core::geometry::{apply, determinant};
    use granum_core::rotation::IDENTITY;
    use granum_core::{Part, Parts};
    use proptest::prelude::*;

    fn left_out(assembly: &Assembly) -> Option<String> {
        let parts = Parts::new(&[Part::Cell, Part::Positions, Part::Radii]);
        let measured = crate::Sensors::standard().measure(assembly, parts);
        let found = measured.left_out.iter().find(|left_out| left_out.sensor == "local_solid_fraction");
        found.map(ToString::to_string)
    }

    /// A damaged cell: grains of a millimetre in a slab of 671 m. The search would look at all their images up to that distance.
    #[test]
    fn a_cell_that_is_nearly_empty_is_left_out_with_the_reason() {
        let mut assembly = lattice::simple_cubic(4, 1e-3, 0.0, 0.0);
        assert_eq!(left_out(&assembly), None);
        assembly.cell[0][0] = 671.0;
        assert!(left_out(&assembly).is_some_and(|reason| reason.contains("leave so much of the cell empty")));
    }

    /// A block of grains amid nothing, and rows of grains along three edges of a cell, no layer of which is empty: the tessellation took
    /// hours. It ends with the work that it is given; the limit of the sensor is the same.
    #[test]
    fn clusters_in_empty_cells_end_with_their_work() {
        let cell = [[0.3, 0.0, 0.0], [0.0, 0.3, 0.0], [0.0, 0.0, 0.3]];
        let block: Vec<Vector> =
            lattice::simple_cubic(10, 1e-3, 0.0, 0.0).bodies.iter().map(|grain| grain.position).collect();
        let row =
            |k: usize| std::array::from_fn(|axis| if axis == k % 3 { 9e-4 * (k / 3) as f64 } else { 0.15 });
        let rows: Vec<Vector> = (0..1000).map(row).collect();
        for centres in [block, rows] {
            let mut work = Work(1e6);
            assert!(tessellation(&cell, &centres, &[5e-4; 1000], &[], &mut work).is_none());
            assert!(work.0 > -1e5, "{}", work.0);
        }
        let lattice = lattice::simple_cubic(10, 1e-3, 0.0, 0.0);
        let positions: Vec<Vector> = lattice.bodies.iter().map(|grain| grain.position).collect();
        let mut work = Work(20_000.0 * 1000.0);
        assert!(tessellation(&lattice.cell, &positions, &[5e-4; 1000], &[], &mut work).is_some());
        // The limit is several times what equal grains need.
        assert!(work.0 > 10_000.0 * 1000.0, "{}", work.0);
    }

    /// A sheet of grains in a wide cell, whose nearest neighbours close no cell.
    #[test]
    fn grains_of_a_cluster_in_a_wide_cell_have_their_cells() {
        let cell = [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]];
        // No two distances are the same.
        let shift = |k: usize| 0.3 * ((k * 7919 % 1000) as f64 / 1000.0);
        let centre = |k: usize| {
            [2.0 * (k % 30) as f64 + shift(k), 2.0 * (k / 30) as f64 + shift(k + 1), 5.0 + shift(k + 2)]
        };
        let centres: Vec<Vector> = (0..150).map(centre).collect();
        let cells = radical_voronoi(&cell, &centres, &[0.5; 150]);
        let volume: f64 = cells.iter().map(|cell| cell.volume).sum();
        assert!((volume / 1e6 - 1.0).abs() < 1e-9, "{volume}");
    }

    /// Cubes with 6 faces and rhombic dodecahedra with 12: the local solid fraction is that of the lattice, pi/6 and
    /// pi/sqrt(18), without scatter, in cells of one cube and of many.
    #[test]
    fn lattices_have_cubes_and_rhombic_dodecahedra() {
        let pi = std::f64::consts::PI;
        for n in [1, 3] {
            let cubes = measured(&LocalSolidFraction, &lattice::simple_cubic(n, 1e-4, 0.0, 0.0));
            let dodecahedra = measured(&LocalSolidFraction, &lattice::face_centred_cubic(n, 1e-4, 0.0, 0.0));
            for (row, exact) in
                [(cubes, [pi / 6.0, 0.0, 6.0, 0.0]), (dodecahedra, [pi / 18f64.sqrt(), 0.0, 12.0, 0.0])]
            {
                for (value, exact) in row.iter().zip(exact) {
                    assert!((value - exact).abs() < 1e-12, "{n}: {row:?}");
                }
            }
        }
    }

    /// The radical planes divide the edge of a body-centred lattice of two sizes as their formula says; the volume by counting
    /// points.
    #[test]
    fn cells_of_unequal_spheres_hold_the_points_nearest_by_power() {
        let mut assembly = lattice::random_contacts(30, 4);
        assembly.cell = [[1.0, 0.4, -0.2], [0.0, 0.9, 0.3], [0.0, 0.0, 1.2]];
        let centres: Vec<Vector> =
            assembly.bodies.iter().map(|grain| apply(&assembly.cell, grain.position)).collect();
        let radii: Vec<f64> = (0..30).map(|k| 0.05 + 0.01 * f64::from(k % 10)).collect();
        let cells = radical_voronoi(&assembly.cell, &centres, &radii);
        let steps = 40;
        let mut counts = vec![0u32; centres.len()];
        for point in 0..steps * steps * steps {
            let place = [point % steps, point / steps % steps, point / steps / steps]
                .map(|k| (f64::from(k) + 0.5) / f64::from(steps));
            let x = apply(&assembly.cell, place);
            let power = |i: usize| {
                let mut least = f64::INFINITY;
                for image in 0..27 {
                    let shift = apply(
                        &assembly.cell,
                        [image % 3 - 1, image / 3 % 3 - 1, image / 9 - 1].map(f64::from),
                    );
                    let square: f64 = (0..3).map(|a| (centres[i][a] + shift[a] - x[a]).powi(2)).sum();
                    least = least.min(square - radii[i] * radii[i]);
                }
                least
            };
            let nearest = (0..centres.len()).min_by(|&a, &b| power(a).total_cmp(&power(b))).unwrap();
            counts[nearest] += 1;
        }
        for (cell, count) in cells.iter().zip(counts) {
            let share = cell.volume / determinant(&assembly.cell);
            let counted = f64::from(count) / f64::from(steps * steps * steps);
            assert!((share - counted).abs() < 2e-3, "{share} {counted}");
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]
        #[test]
        fn volumes_add_up_to_the_cell(
            seed in 0u64..1000,
            count in 1usize..40,
            skew in prop::array::uniform3(-1.5..1.5f64),
            edges in prop::array::uniform3(0.3..2.0f64),
            scatter in 0.0..0.25f64,
        ) {
            let assembly = lattice::random_contacts(count, seed);
            let cell = [[edges[0], skew[0], skew[1]], [0.0, edges[1], skew[2]], [0.0, 0.0, edges[2]]];
            let centres: Vec<Vector> = assembly.bodies.iter().map(|grain| apply(&cell, grain.position)).collect();
            let radii: Vec<f64> = (0..count).map(|k| 0.02 + scatter * (k as f64 * 0.618).fract()).collect();
            let cells = radical_voronoi(&cell, &centres, &radii);
            let sum: f64 = cells.iter().map(|cell| cell.volume).sum();
            prop_assert!((sum / determinant(&cell) - 1.0).abs() < 1e-9, "{} {}", sum, determinant(&cell));
            prop_assert!(cells.iter().all(|cell| cell.volume >= -1e-12));
        }
    }

    #[test]
    fn without_grains_or_a_volume_everything_is_zero() {
        assert_eq!(measured(&LocalSolidFraction, &Assembly::default()), [0.0; 4]);
        assert!(radical_voronoi(&[[0.0; 3]; 3], &[[0.0; 3]], &[1.0]).is_empty());
    }

    /// Two dimers in a row along x, each in a half of a box with edges of 4, 1 and 1: five faces on each side of a dimer, none within it.
    #[test]
    fn a_clump_has_one_cell_without_the_faces_within_it() {
        let mut assembly =
            Assembly { cell: [[4.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], ..Assembly::default() };
        for x in [1.0, 3.0] {
            let (inertia, centres) = ([0.1, 0.35, 0.35], &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]]);
            let position = [x, 0.5, 0.5];
            clumps::push(&mut assembly, &Clump { position, orientation: IDENTITY, inertia, centres });
        }
        let row = measured(&LocalSolidFraction, &assembly);
        let fraction = 4.0 / 3.0 * std::f64::consts::PI * 0.6f64.powi(3) / 2.0;
        for (value, exact) in row.iter().zip([fraction, 0.0, 10.0, 0.0]) {
            assert!((value - exact).abs() < 1e-12, "{row:?}");
        }
    }
}
