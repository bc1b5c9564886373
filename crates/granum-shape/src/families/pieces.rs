//! Spheres that are given as a list.

use crate::entry::ShapeEntry;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, Spheres};

/// Spheres that are given as a list.
pub struct Pieces;

impl ShapeFamily for Pieces {
    fn description(&self) -> &'static ShapeDescription {
        &ShapeDescription {
            name: "pieces",
            help: "the spheres of the list `spheres`",
            parameters: &[],
            takes_spheres: true,
            takes_file: false,
        }
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        let spheres: Spheres =
            given.spheres.iter().map(|[x, y, z, radius]| ([*x, *y, *z], *radius)).collect();
        if spheres.is_empty() {
            let message = "is missing: kind = \"pieces\" needs a list of them, e.g. spheres = [[-0.5, 0, 0, 1], [0.5, 0, 0, 1]]";
            return Err(ShapeError::new("spheres", message));
        }
        if let Some(apart) = islands(&spheres) {
            let message = format!(
                "are two bodies: sphere {apart} does not touch those before it, directly or by others"
            );
            return Err(ShapeError::new("spheres", message));
        }
        Ok(vec![spheres])
    }
}

/// A sphere that is not connected to the first one, if there is one.
pub(crate) fn islands(spheres: &[([f64; 3], f64)]) -> Option<usize> {
    connected(spheres).iter().position(|is| !is)
}

/// True for each sphere that touches the first one, directly or by others.
pub(crate) fn connected(spheres: &[([f64; 3], f64)]) -> Vec<bool> {
    let touch = |a: usize, b: usize| {
        let ((p, r), (q, s)) = (&spheres[a], &spheres[b]);
        let square: f64 = (0..3).map(|k| (p[k] - q[k]) * (p[k] - q[k])).sum();
        square <= (r + s) * (r + s) * (1.0 + 1e-9)
    };
    let mut connected = vec![false; spheres.len()];
    let mut open = Vec::new();
    if let Some(first) = connected.first_mut() {
        *first = true;
        open.push(0);
    }
    while let Some(a) = open.pop() {
        for b in 0..spheres.len() {
            if !connected[b] && touch(a, b) {
                connected[b] = true;
                open.push(b);
            }
        }
    }
    connected
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::family::ShapeKind;

    #[test]
    fn two_bodies_and_equal_spheres_are_refused() {
        let entry = |spheres: &[[f64; 4]]| ShapeEntry {
            spheres: spheres.to_vec(),
            ..ShapeEntry::new(ShapeKind::PIECES)
        };
        let said = |spheres: &[[f64; 4]]| entry(spheres).shapes().unwrap_err().to_string();
        assert!(said(&[[0.0, 0.0, 0.0, 1.0], [3.0, 0.0, 0.0, 0.5]]).contains("sphere 1 does not touch"));
        assert!(said(&[[0.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]).contains("are equal"));
        assert!(said(&[[0.0, 0.0, 0.0, -1.0]]).contains("must be positive"));
        assert_eq!(entry(&[[0.0, 0.0, 0.0, 1.0], [1.5, 0.0, 0.0, 0.5]]).shapes().unwrap().len(), 1);
    }
}
