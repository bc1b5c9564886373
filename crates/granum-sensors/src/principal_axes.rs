//! The long and the short axis of a grain of several pieces: those of its least and of its largest moment of inertia.

use granum_core::assembly::{Assembly, Body, Rigid, Vector};
use granum_core::rotation::{matrix, to_body, to_space};

/// Relative difference of two moments up to which they count as equal.
const EQUAL: f64 = 1e-6;

/// Which axis of a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// That of the least moment of inertia.
    Long,
    /// That of the largest moment of inertia.
    Short,
}

/// Which of the principal axes it is; `None` if there is no single one, as for a sphere, the short axis of a grain of
/// revolution that is long, or the long axis of one that is flat.
fn single(inertia: &Vector, axis: Axis) -> Option<usize> {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| inertia[a].total_cmp(&inertia[b]));
    let [least, middle, largest] = order.map(|k| inertia[k]);
    let (at, gap) = match axis {
        Axis::Long => (order[0], middle - least),
        Axis::Short => (order[2], largest - middle),
    };
    (gap > EQUAL * largest).then_some(at)
}

fn rigid<'a>(assembly: &'a Assembly, body: &Body) -> Option<&'a Rigid> {
    assembly.rigid.get(body.rigid? as usize)
}

/// The direction of an axis of a body, a unit vector in space; `None` if it has no single one.
///
/// ```
/// use granum_core::Assembly;
/// use granum_core::assembly::Sphere;
/// use granum_sensors::principal_axes::{Axis, direction};
///
/// let assembly = Assembly::default().with_spheres([Sphere::default()]);
/// assert_eq!(direction(&assembly, &assembly.bodies[0], Axis::Long), None);
/// ```
pub fn direction(assembly: &Assembly, body: &Body, axis: Axis) -> Option<Vector> {
    let rigid = rigid(assembly, body)?;
    let mut unit = [0.0; 3];
    unit[single(&rigid.inertia, axis)?] = 1.0;
    Some(to_space(&matrix(&rigid.orientation), &unit))
}

/// The squares of the parts of a vector along and across the long axis of a body; `None` if it has no single one.
pub(crate) fn along_and_across(assembly: &Assembly, body: &Body, vector: &Vector) -> Option<[f64; 2]> {
    let rigid = rigid(assembly, body)?;
    let along = single(&rigid.inertia, Axis::Long)?;
    let squares = to_body(&matrix(&rigid.orientation), vector).map(|x| x * x);
    Some([squares[along], squares[(along + 1) % 3] + squares[(along + 2) % 3]])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_are_single_where_the_moments_differ() {
        let both = |inertia: Vector| [Axis::Long, Axis::Short].map(|axis| single(&inertia, axis));
        assert_eq!(both([2.0, 1.0, 3.0]), [Some(1), Some(2)]);
        assert_eq!(both([0.35, 0.1, 0.35]), [Some(1), None]);
        assert_eq!(both([0.35, 0.6, 0.35]), [None, Some(1)]);
        assert_eq!(both([0.4, 0.4 * (1.0 + 1e-9), 0.4]), [None, None]);
    }
}
