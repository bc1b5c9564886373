//! Equal spheres in a row: a cylinder with round ends, if there are many.

use crate::entry::ShapeEntry;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};

/// Equal spheres in a row. Between two of them a seam remains, whose slope `tan(chi)`, `sin(chi) = c/2d` for centres at the distance c and
/// spheres of the diameter d, acts as friction: 0.26 for three spheres at the aspect ratio 2, below 0.05 for 11.
pub struct Capsule;

const ASPECT_RATIO: ShapeParameter = ShapeParameter {
    key: "aspect_ratio",
    default: 1.5,
    bounds: [1.01, 6.0],
    whole: false,
    meaning: "Length over thickness.",
};

/// Number of spheres, which several families have.
pub(crate) const PIECES: ShapeParameter = ShapeParameter {
    key: "pieces",
    default: 3.0,
    bounds: [2.0, 200.0],
    whole: true,
    meaning: "Number of spheres: more of them are smoother and take longer.",
};

impl ShapeFamily for Capsule {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "capsule",
            help: "equal spheres in a row: a cylinder with round ends",
            parameters: &[ASPECT_RATIO, PIECES],
            takes_spheres: false,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let (ratio, pieces) = (given.value(&ASPECT_RATIO), given.value(&PIECES));
        let apart = (ratio - 1.0) / (pieces - 1.0);
        let first = -0.5 * (ratio - 1.0);
        let sphere = |k: usize| ([first + k as f64 * apart, 0.0, 0.0], 0.5);
        if apart > 1.0 {
            let least = (ratio - 1.0).ceil() + 1.0;
            let message = format!(
                "is {pieces}: the spheres of a capsule of aspect_ratio = {ratio} would not touch; it must be at least {least}"
            );
            return Err(ShapeError::new("pieces", message));
        }
        Ok(vec![(0..pieces as usize).map(sphere).collect()])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::ShapeKind;
    use crate::union_of_spheres::ShapeOfSpheres;

    #[test]
    fn it_is_as_long_as_it_says_and_hangs_together() {
        let capsule = ShapeEntry::new(ShapeKind::CAPSULE).with("aspect_ratio", 2.0);
        let [spheres] = &Capsule.shapes(&capsule).unwrap()[..] else { panic!("one shape") };
        assert_eq!(spheres.len(), 3);
        assert_eq!((spheres[0].0[0], spheres[2].0[0]), (-0.5, 0.5));
        let apart = capsule.with("aspect_ratio", 5.0);
        assert!(Capsule.shapes(&apart).unwrap_err().to_string().contains("must be at least 5"));
    }

    /// Two moments of a capsule are equal. Their integrals differ a little, in either order.
    #[test]
    fn capsules_of_every_length_are_possible_bodies() {
        for k in 0..=995 {
            let ratio = 1.01 + 0.002 * f64::from(k);
            let capsule = ShapeEntry::new(ShapeKind::CAPSULE).with("aspect_ratio", ratio);
            let [spheres] = &Capsule.shapes(&capsule).unwrap()[..] else { panic!("one shape") };
            let shape = ShapeOfSpheres::new(spheres).unwrap().shape;
            assert_eq!(shape.fault(), None, "aspect ratio {ratio}");
        }
    }
}
