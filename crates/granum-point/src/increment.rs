//! An increment of deformation: a rotation, then a logarithmic strain.

use granum_core::digest::Digest;
use granum_core::geometry::{Matrix, determinant};
use granum_dem::invariants;
use granum_dem::servo::PLACES;

use crate::error::PointError;
use crate::matrix_functions::{UNIT, difference_from_rotation, exponential, polar};

/// Largest difference of a rotation from an orthogonal matrix.
const ROTATION_TOLERANCE: f64 = 1e-6;

/// How fast an increment is carried out.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Pace {
    /// At the inertial number of the controls.
    #[default]
    OfControls,
    /// At this inertial number.
    InertialNumber(f64),
    /// In this time of the grains, s.
    Duration(f64),
}

/// An increment of deformation.
///
/// The sample is first rotated as a rigid body and then strained: `F = exp(-strain) rotation`, with the strain in the axes of space.
/// The strain is logarithmic (Hencky), so that equal increments one after the other add up, however a path is cut.
///
/// ```
/// use granum_point::Increment;
///
/// // Simple shear by an angle of 0.1: the deformation gradient of a tenth of it, ten times, is that of the whole.
/// let whole = Increment::from_velocity_gradient(&[[0.0, 0.1, 0.0], [0.0; 3], [0.0; 3]], 1.0)?;
/// assert!((whole.size() - 0.1 / 3f64.sqrt()).abs() < 1e-4 && !whole.is_zero());
/// # Ok::<(), granum_point::PointError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Increment {
    /// Logarithmic strain in the axes of space, compression positive; a symmetric tensor.
    pub(crate) strain: Matrix,
    /// Rotation before the strain.
    pub(crate) rotation: Matrix,
    /// How fast it is carried out.
    pub(crate) pace: Pace,
}

impl Increment {
    /// No deformation.
    pub fn zero() -> Increment {
        Increment { strain: [[0.0; 3]; 3], rotation: UNIT, pace: Pace::OfControls }
    }

    /// A logarithmic strain without rotation, compression positive; only the symmetric part of the tensor counts.
    pub fn from_strain(strain: &Matrix) -> Increment {
        // The sum with zero makes a minus zero a zero.
        let symmetric = |r: usize, c: usize| 0.5 * (strain[r][c] + strain[c][r]) + 0.0;
        Increment {
            strain: std::array::from_fn(|r| std::array::from_fn(|c| symmetric(r, c))),
            ..Increment::zero()
        }
    }

    /// A logarithmic strain by its components xx, yy, zz, yz, zx, xy, compression positive, shear strains as angles, without rotation.
    pub fn from_components(components: [f64; 6]) -> Increment {
        let mut strain = [[0.0; 3]; 3];
        for (k, [r, c]) in PLACES.into_iter().enumerate() {
            strain[r][c] += 0.5 * components[k];
            strain[c][r] += 0.5 * components[k];
        }
        Increment::from_strain(&strain)
    }

    /// The deformation gradient of an increment, `F = V R`: R is the rotation and the strain `-ln V`.
    ///
    /// # Errors
    /// [`PointError::NotFinite`], and [`PointError::Deformation`] if the determinant is not positive.
    pub fn from_deformation_gradient(deformation: &Matrix) -> Result<Increment, PointError> {
        if !deformation.iter().flatten().all(|x| x.is_finite()) {
            return Err(PointError::NotFinite { what: "the deformation gradient of an increment" });
        }
        let determinant = determinant(deformation);
        if !(determinant > 0.0 && determinant.is_finite()) {
            return Err(PointError::Deformation { determinant });
        }
        if *deformation == UNIT {
            return Ok(Increment::zero());
        }
        let (logarithm, rotation) = polar(deformation);
        let strain = Increment::from_strain(&logarithm.map(|row| row.map(|x| -x)));
        strain.after_rotation(&rotation)
    }

    /// A constant velocity gradient, 1/s, that acts for a time, s: the deformation gradient is the exponential of their product.
    ///
    /// # Errors
    /// As [`Increment::from_deformation_gradient`].
    pub fn from_velocity_gradient(gradient: &Matrix, duration: f64) -> Result<Increment, PointError> {
        let product = gradient.map(|row| row.map(|rate| duration * rate));
        if !product.iter().flatten().all(|x| x.is_finite()) {
            return Err(PointError::NotFinite { what: "the velocity gradient of an increment" });
        }
        Increment::from_deformation_gradient(&exponential(&product))
    }

    /// The same strain after a rotation of the sample.
    ///
    /// # Errors
    /// [`PointError::Rotation`] if the matrix is no rotation.
    pub fn after_rotation(self, rotation: &Matrix) -> Result<Increment, PointError> {
        if !rotation.iter().flatten().all(|x| x.is_finite()) {
            return Err(PointError::NotFinite { what: "the rotation of an increment" });
        }
        let difference = difference_from_rotation(rotation);
        if difference > ROTATION_TOLERANCE {
            return Err(PointError::Rotation { difference });
        }
        Ok(Increment { rotation: rotation.map(|row| row.map(|x| x + 0.0)), ..self })
    }

    /// The same increment at another inertial number than that of the controls.
    pub fn at_inertial_number(self, inertial_number: f64) -> Increment {
        Increment { pace: Pace::InertialNumber(inertial_number), ..self }
    }

    /// The same increment in a time of the grains, s. Grains of 0.1 mm under 100 kPa take about 1e-5 s for what quasi-static loading
    /// does in a strain of 1e-3; a time of the order of a second therefore needs more steps than any point permits.
    pub fn in_time(self, duration: f64) -> Increment {
        Increment { pace: Pace::Duration(duration), ..self }
    }

    /// The strain, logarithmic and compression positive, in the axes of space.
    pub fn strain(&self) -> &Matrix {
        &self.strain
    }

    /// The rotation before the strain.
    pub fn rotation(&self) -> &Matrix {
        &self.rotation
    }

    /// The size of the strain, `sqrt(2/3 e:e)` of all of it.
    pub fn size(&self) -> f64 {
        invariants::length(&self.strain)
    }

    /// True if nothing is deformed or rotated.
    pub fn is_zero(&self) -> bool {
        self.strain == [[0.0; 3]; 3] && self.rotation == UNIT
    }

    /// Refuses numbers that are not finite, and a pace that is not positive.
    pub(crate) fn check(&self) -> Result<(), PointError> {
        if !self.strain.iter().flatten().all(|x| x.is_finite()) {
            return Err(PointError::NotFinite { what: "the strain of an increment" });
        }
        let (name, value, wanted) = match self.pace {
            Pace::OfControls => return Ok(()),
            Pace::InertialNumber(number) => ("inertial number of an increment", number, "from 1e-6 to 0.1"),
            Pace::Duration(time) => ("duration of an increment", time, "positive"),
        };
        let possible = match self.pace {
            Pace::InertialNumber(number) => (1e-6..=0.1).contains(&number),
            _ => value > 0.0 && value.is_finite(),
        };
        if possible { Ok(()) } else { Err(PointError::Control { name, value, wanted }) }
    }

    /// Takes everything that determines the result into a digest.
    pub(crate) fn digest(&self, digest: &mut Digest) {
        let flat: Vec<f64> = self.strain.iter().chain(&self.rotation).flatten().copied().collect();
        digest.numbers(&flat);
        match self.pace {
            Pace::OfControls => digest.numbers(&[]),
            Pace::InertialNumber(number) => digest.numbers(&[1.0, number]),
            Pace::Duration(time) => digest.numbers(&[2.0, time]),
        }
    }
}

#[cfg(test)]
mod tests {
    use granum_core::geometry::multiply;

    use super::*;

    /// The deformation gradients of parts of a constant velocity gradient multiply to that of the whole.
    #[test]
    fn a_velocity_gradient_can_be_cut() {
        let gradient = [[0.0, 0.3, 0.0], [0.0, -0.1, 0.05], [0.0, 0.0, 0.2]];
        let deformation = |part: &Increment| {
            multiply(&exponential(&part.strain.map(|row| row.map(|x| -x))), &part.rotation)
        };
        let part = deformation(&Increment::from_velocity_gradient(&gradient, 0.1).unwrap());
        let whole = deformation(&Increment::from_velocity_gradient(&gradient, 1.0).unwrap());
        let product = (0..10).fold(UNIT, |product, _| multiply(&part, &product));
        for k in 0..9 {
            assert!((product[k / 3][k % 3] - whole[k / 3][k % 3]).abs() < 1e-14, "{product:?} {whole:?}");
        }
    }

    #[test]
    fn what_is_no_deformation_is_refused_by_name() {
        let message = |result: Result<Increment, PointError>| result.unwrap_err().to_string();
        let mirror = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        assert!(message(Increment::from_deformation_gradient(&mirror)).contains("determinant -1e0"));
        assert!(message(Increment::zero().after_rotation(&mirror)).contains("rotation"));
        let infinite = [[f64::INFINITY, 0.0, 0.0], [0.0; 3], [0.0; 3]];
        assert!(message(Increment::from_velocity_gradient(&infinite, 1.0)).contains("finite"));
        assert!(Increment::from_components([f64::NAN, 0.0, 0.0, 0.0, 0.0, 0.0]).check().is_err());
        assert!(Increment::zero().in_time(-1.0).check().is_err());
        assert!(Increment::zero().at_inertial_number(1e-3).check().is_ok());
    }

    #[test]
    fn components_are_engineering_strains() {
        let increment = Increment::from_components([0.0, 0.0, 0.0, 1e-3, 0.0, 0.0]);
        assert_eq!(increment.strain[1][2], 5e-4);
        assert_eq!(increment.strain[2][1], 5e-4);
        assert!(Increment::from_deformation_gradient(&UNIT).unwrap().is_zero());
    }
}
