//! The shape of rigid bodies.

use granum_core::assembly::Vector;

use crate::principal_axes::EQUAL;

/// A sphere that is fixed on a body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapePiece {
    /// Its centre in the principal axes of the body, from the body's centre of mass, m.
    pub centre: Vector,
    /// Its radius, m.
    pub radius: f64,
}

/// The shape of a rigid body: spheres in its principal axes. Volume and inertia are those of the union of the spheres: a sum over them would
/// count what they share twice.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidShape {
    /// The spheres of which it is made.
    pub pieces: Vec<ShapePiece>,
    /// Volume of the union of the spheres, m3.
    pub volume: f64,
    /// Principal moments of inertia over the mass, m2: the first axis has the smallest, the third the largest.
    pub inertia_over_mass: Vector,
}

impl RigidShape {
    /// A sphere of a radius, m.
    pub fn sphere(radius: f64) -> RigidShape {
        RigidShape {
            pieces: vec![ShapePiece { centre: [0.0; 3], radius }],
            volume: 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3),
            inertia_over_mass: [0.4 * radius * radius; 3],
        }
    }

    /// The radius of the only piece, if there is one and it is in the centre: such a body is a sphere.
    pub fn as_sphere(&self) -> Option<f64> {
        match self.pieces[..] {
            [ShapePiece { centre, radius }] if centre == [0.0; 3] => Some(radius),
            _ => None,
        }
    }

    /// Radius of the sphere of equal volume, m.
    pub fn equivalent_radius(&self) -> f64 {
        self.as_sphere().unwrap_or_else(|| equivalent_radius(self.volume))
    }

    /// Largest distance of its surface from its centre, m.
    pub fn reach(&self) -> f64 {
        self.pieces.iter().map(|p| granum_core::geometry::length(&p.centre) + p.radius).fold(0.0, f64::max)
    }

    /// The same shape with all lengths multiplied by a factor.
    pub fn scaled(&self, factor: f64) -> RigidShape {
        let piece = |piece: &ShapePiece| ShapePiece {
            centre: piece.centre.map(|x| factor * x),
            radius: factor * piece.radius,
        };
        RigidShape {
            pieces: self.pieces.iter().map(piece).collect(),
            volume: self.volume * factor * factor * factor,
            inertia_over_mass: self.inertia_over_mass.map(|moment| moment * factor * factor),
        }
    }

    /// What is impossible about it and what would be right.
    pub fn fault(&self) -> Option<String> {
        let positive = |x: f64| x > 0.0 && x.is_finite();
        if self.pieces.is_empty() {
            return Some("its shape has no pieces; a body needs at least one".into());
        }
        for (k, piece) in self.pieces.iter().enumerate() {
            if !positive(piece.radius) {
                return Some(format!(
                    "the radius of its piece {k} is {} m; it must be positive",
                    piece.radius
                ));
            }
            if piece.centre.iter().any(|x| !x.is_finite()) {
                return Some(format!("the centre {:?} of its piece {k} is not finite", piece.centre));
            }
            if self.pieces[..k].contains(piece) {
                return Some(format!(
                    "its piece {k} occurs twice; equal pieces would touch everything twice"
                ));
            }
        }
        if !positive(self.volume) {
            return Some(format!("its volume is {} m3; it must be positive", self.volume));
        }
        let [a, b, c] = self.inertia_over_mass;
        // Equal moments may differ by rounding, and keep the order of the given axes as far as that.
        let rounding = EQUAL * (a + b + c);
        if a > b + rounding || b > c + rounding {
            return Some(format!(
                "its principal moments of inertia over its mass are {:?} m2; they must rise from the first axis to the third",
                self.inertia_over_mass
            ));
        }
        // The moments of a body obey the triangle inequality.
        let possible = a + b >= c && b + c >= a && c + a >= b;
        if !(positive(a) && positive(b) && positive(c) && possible) {
            return Some(format!(
                "its principal moments of inertia over its mass are {:?} m2; they must be positive, and none larger than the sum of the \
                 others",
                self.inertia_over_mass
            ));
        }
        None
    }
}

/// Radius of the sphere of a volume, m3.
pub fn equivalent_radius(volume: f64) -> f64 {
    granum_simd::cbrt(volume / (4.0 / 3.0 * std::f64::consts::PI))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sphere_is_known_as_one_and_impossible_shapes_are_named() {
        let sphere = RigidShape::sphere(0.5);
        assert_eq!((sphere.as_sphere(), sphere.equivalent_radius(), sphere.reach()), (Some(0.5), 0.5, 0.5));
        assert_eq!(sphere.fault(), None);
        let dimer = dimer();
        assert_eq!((dimer.as_sphere(), dimer.fault()), (None, None));
        assert!((2.0 * dimer.equivalent_radius() - 1.1905507890).abs() < 1e-9);
        assert_eq!(dimer.reach(), 0.75);
        let fault = |change: fn(&mut RigidShape)| {
            let mut shape = dimer.clone();
            change(&mut shape);
            shape.fault().expect("refused")
        };
        assert!(fault(|s| s.pieces.clear()).contains("no pieces"));
        assert!(fault(|s| s.pieces[1].radius = 0.0).contains("piece 1 is 0 m"));
        assert!(fault(|s| s.pieces[1] = s.pieces[0]).contains("occurs twice"));
        assert!(fault(|s| s.volume = f64::NAN).contains("volume is NaN"));
        assert!(fault(|s| s.inertia_over_mass = [1.0, 1.0, 3.0]).contains("sum of the others"));
        assert!(fault(|s| s.pieces[0].centre[2] = f64::INFINITY).contains("not finite"));
    }

    /// Two spheres of diameter 1 at the distance 0.5.
    fn dimer() -> RigidShape {
        let piece = |x: f64| ShapePiece { centre: [x, 0.0, 0.0], radius: 0.5 };
        RigidShape {
            pieces: vec![piece(-0.25), piece(0.25)],
            volume: 0.8835729338221,
            inertia_over_mass: [0.10625, 0.184375, 0.184375],
        }
    }
}
