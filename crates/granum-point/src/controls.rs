//! Controls of a live cell.

use granum_core::digest::Digest;
use granum_dem::config::LARGEST_OVERLAP;

use crate::error::PointError;

/// What happens to an increment that is larger than the largest one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BeyondLargest {
    /// It is divided into equal parts, as if the caller had asked for them one after the other.
    #[default]
    Divide,
    /// It is refused with [`PointError::TooLarge`].
    Refuse,
}

/// Controls of a live cell.
///
/// ```
/// use granum_point::Controls;
///
/// let controls = Controls::default().with(|controls| controls.inertial_number = 3e-4);
/// assert!(controls.check().is_ok());
/// assert!(Controls::default().with(|controls| controls.averaging = 1_000_000).check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Controls {
    /// Inertial number of the straining, `I = rate d sqrt(rho / p)`, with the size `sqrt(2/3 e:e)` of the strain.
    pub inertial_number: f64,
    /// Steps for which the cell is held after an increment, so that the motion of the grains dies down.
    pub relaxation: u64,
    /// The last steps of the relaxation over which the stress is averaged; zero for the stress of the last step.
    pub averaging: u64,
    /// The largest size of an increment that is carried out in one piece, `sqrt(2/3 e:e)`.
    pub largest_increment: f64,
    /// What happens to a larger one.
    pub beyond_largest: BeyondLargest,
    /// The size of an increment from which on it is refused in any case.
    pub absurd_increment: f64,
    /// Mean stress, Pa, whose strain rate is the smallest one: a sample without stress would otherwise never be strained. `None`: a
    /// hundredth of the mean stress of the sample at its start.
    pub least_mean_stress: Option<f64>,
    /// Largest number of steps of an increment.
    pub most_steps: u64,
    /// Largest overlap of grains over the sum of their radii.
    pub largest_overlap: f64,
}

impl Default for Controls {
    fn default() -> Self {
        Controls {
            inertial_number: 1e-3,
            relaxation: 50,
            averaging: 50,
            largest_increment: 0.02,
            beyond_largest: BeyondLargest::Divide,
            absurd_increment: 0.5,
            least_mean_stress: None,
            most_steps: 20_000_000,
            largest_overlap: LARGEST_OVERLAP,
        }
    }
}

impl Controls {
    /// The same with some fields changed.
    pub fn with(mut self, change: impl FnOnce(&mut Controls)) -> Controls {
        change(&mut self);
        self
    }

    /// Checks the values.
    ///
    /// # Errors
    /// [`PointError::Control`].
    pub fn check(&self) -> Result<(), PointError> {
        let within = |name, value: f64, [low, high]: [f64; 2], wanted| match (low..=high).contains(&value) {
            true => Ok(()),
            false => Err(PointError::Control { name, value, wanted }),
        };
        within("inertial number", self.inertial_number, [1e-6, 0.1], "from 1e-6 to 0.1")?;
        within("number of steps of relaxation", self.relaxation as f64, [0.0, 1e7], "at most 1e7")?;
        let relaxation = self.relaxation as f64;
        within(
            "number of averaged steps",
            self.averaging as f64,
            [0.0, relaxation],
            "at most that of the relaxation",
        )?;
        within("largest increment", self.largest_increment, [1e-9, 0.5], "from 1e-9 to 0.5")?;
        within(
            "absurd increment",
            self.absurd_increment,
            [self.largest_increment, 2.0],
            "from the largest increment to 2",
        )?;
        if let Some(stress) = self.least_mean_stress {
            within("least mean stress", stress, [1e-6, 1e12], "from 1e-6 to 1e12 Pa")?;
        }
        within("number of steps", self.most_steps as f64, [1.0, 1e12], "from 1 to 1e12")?;
        within("largest overlap", self.largest_overlap, [1e-6, 0.3], "from 1e-6 to 0.3")
    }

    /// Takes everything that determines a result into a digest; limits that only refuse do not.
    pub(crate) fn digest(&self, digest: &mut Digest) {
        let least = self.least_mean_stress.unwrap_or(f64::NAN);
        let steps = [self.relaxation as f64, self.averaging as f64];
        digest.numbers(&[self.inertial_number, steps[0], steps[1], self.largest_increment, least]);
    }
}
