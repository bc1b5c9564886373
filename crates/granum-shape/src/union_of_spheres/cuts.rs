//! Where the exposed arcs of a sphere begin, end or join: the heights between which they change smoothly.

use granum_core::assembly::Vector;
use granum_core::geometry::{cross, dot, length};

/// A point counts as covered if it is deeper in another sphere than this share of its radius: doubtful points stay.
const DEEPER: f64 = 1e-9;

/// The other spheres that meet the surface of a sphere.
pub(crate) fn neighbours(spheres: &[(Vector, f64)], k: usize) -> Vec<(Vector, f64)> {
    let (centre, radius) = &spheres[k];
    let meets = |(j, (other, larger)): (usize, &(Vector, f64))| {
        let d: Vector = std::array::from_fn(|a| other[a] - centre[a]);
        let sum = radius + larger;
        (j != k && dot(&d, &d) < sum * sum).then_some((*other, *larger))
    };
    spheres.iter().enumerate().filter_map(meets).collect()
}

/// The heights at which a sphere is cut: its poles, the exposed extremes of the circles in which others meet it, and the exposed points at
/// which two others do. An arc that begins beneath another one changes nothing.
pub(crate) fn cuts((centre, radius): (&Vector, f64), neighbours: &[(Vector, f64)]) -> Vec<f64> {
    let (low, high) = (centre[2] - radius, centre[2] + radius);
    let mut cuts = vec![low, high];
    let mut add = |point: &Vector, but: [usize; 2]| {
        if point[2] > low && point[2] < high && !is_covered(point, neighbours, but) {
            cuts.push(point[2]);
        }
    };
    for (j, (other, larger)) in neighbours.iter().enumerate() {
        let Some(circle) = seam((centre, radius), (other, *larger)) else { continue };
        for point in extremes(&circle).into_iter().flatten() {
            add(&point, [j, j]);
        }
        for (k, (third, third_radius)) in neighbours.iter().enumerate().skip(j + 1) {
            for point in triple_points(&circle, third, *third_radius).into_iter().flatten() {
                add(&point, [j, k]);
            }
        }
    }
    cuts.sort_by(f64::total_cmp);
    cuts.dedup();
    cuts
}

/// True if a point is inside one of the spheres but two.
pub(crate) fn is_covered(point: &Vector, spheres: &[(Vector, f64)], but: [usize; 2]) -> bool {
    spheres.iter().enumerate().any(|(k, (centre, radius))| {
        let d: Vector = std::array::from_fn(|a| point[a] - centre[a]);
        let inner = radius * (1.0 - DEEPER);
        !but.contains(&k) && dot(&d, &d) < inner * inner
    })
}

/// A circle in which two spheres meet: its middle, its axis and its radius.
pub(crate) type Circle = (Vector, Vector, f64);

/// The circle in which two spheres meet: its middle, its axis and its radius.
pub(crate) fn seam((a, r): (&Vector, f64), (b, s): (&Vector, f64)) -> Option<Circle> {
    let d: Vector = std::array::from_fn(|k| b[k] - a[k]);
    let distance = length(&d);
    if distance >= r + s || distance <= (r - s).abs() {
        return None;
    }
    let axis = d.map(|x| x / distance);
    let along = 0.5 * (distance + (r * r - s * s) / distance);
    let radius = (r * r - along * along).max(0.0).sqrt();
    Some((std::array::from_fn(|k| a[k] + along * axis[k]), axis, radius))
}

/// The lowest and the highest point of a circle; none if all of it is at one height.
fn extremes((middle, axis, radius): &Circle) -> Option<[Vector; 2]> {
    let rise = (1.0 - axis[2] * axis[2]).max(0.0).sqrt();
    if rise == 0.0 {
        return None;
    }
    let up: Vector = [-axis[2] * axis[0] / rise, -axis[2] * axis[1] / rise, (1.0 - axis[2] * axis[2]) / rise];
    Some([-1.0, 1.0].map(|side| std::array::from_fn(|a| middle[a] + side * radius * up[a])))
}

/// The two points of a circle that are on a third sphere.
pub(crate) fn triple_points(
    (middle, axis, seam): &Circle,
    third: &Vector,
    radius: f64,
) -> Option<[Vector; 2]> {
    let d: Vector = std::array::from_fn(|k| third[k] - middle[k]);
    let along = dot(&d, axis);
    let flat: Vector = std::array::from_fn(|k| d[k] - along * axis[k]);
    let across = length(&flat);
    if across == 0.0 {
        return None;
    }
    // Of the points at the angle phi from `flat`: seam^2 + d^2 - 2 seam across cos(phi) = radius^2.
    let cosine = (seam * seam + dot(&d, &d) - radius * radius) / (2.0 * seam * across);
    if cosine.abs() >= 1.0 {
        return None;
    }
    let sine = (1.0 - cosine * cosine).sqrt();
    let u = flat.map(|x| x / across);
    let v = cross(axis, &u);
    let point = |side: f64| std::array::from_fn(|a| middle[a] + seam * (cosine * u[a] + side * sine * v[a]));
    Some([point(1.0), point(-1.0)])
}
