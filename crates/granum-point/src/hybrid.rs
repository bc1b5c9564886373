//! A surrogate that answers while it knows, and grains where it does not.
//!
//! A state begins as one of the surrogate. Where an answer of the surrogate is not to be trusted ([`Trust`]), the grains of the sample follow the whole path of
//! the state, and answer from there on. The stress then changes from what the surrogate said to what the grains say: by its error.

use std::sync::Arc;

use granum_core::digest::Digest;
use granum_core::geometry::Matrix;
use granum_core::observer::Flow;
use granum_dem::simulation::Simulation;

use crate::controls::Controls;
use crate::error::PointError;
use crate::increment::Pace;
use crate::path_so_far::{PathPart, parts};
use crate::state::Matter;
use crate::straining::{AveragedStress, relax, strain};
use crate::surrogate_model::SurrogateModel;

/// When the answer of a surrogate counts. An answer from outside of what it was trained on never does.
///
/// ```
/// use granum_point::Trust;
///
/// assert!(Trust { largest_deviation: 0.1 }.check().is_ok() && Trust { largest_deviation: -1.0 }.check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trust {
    /// Largest standard deviation of a component of the stress, over the mean stress, up to which an answer counts.
    pub largest_deviation: f64,
}

impl Trust {
    /// Checks the values.
    ///
    /// # Errors
    /// [`PointError::Control`].
    pub fn check(&self) -> Result<(), PointError> {
        let value = self.largest_deviation;
        if (0.0..=1e3).contains(&value) {
            return Ok(());
        }
        Err(PointError::Control { name: "largest trusted deviation", value, wanted: "from 0 to 1000" })
    }

    /// True if an answer with this stress counts.
    fn counts(&self, stress: &AveragedStress, least_mean_stress: f64) -> bool {
        let mean = (stress.mean[0][0] + stress.mean[1][1] + stress.mean[2][2]) / 3.0;
        let largest = stress.deviation.iter().flatten().fold(0.0, |most: f64, own| most.max(*own));
        largest <= self.largest_deviation * mean.max(least_mean_stress)
    }
}

/// What answers of a hybrid point.
pub(crate) struct Hybrid {
    pub(crate) surrogate: SurrogateModel,
    /// The grains before any increment.
    pub(crate) sample: Simulation,
    pub(crate) trust: Trust,
}

/// A part of an increment, and how it is carried out.
pub(crate) struct Part<'a> {
    /// Logarithmic strain in the axes of the cell.
    pub(crate) strain: &'a Matrix,
    pub(crate) pace: Pace,
    pub(crate) least_mean_stress: f64,
    pub(crate) controls: &'a Controls,
}

/// The stress after a part, and the number of steps that it took.
pub(crate) type Followed = (AveragedStress, u64);

impl Part<'_> {
    /// Strains grains by this part.
    ///
    /// # Errors
    /// As [`strain`] and [`relax`].
    pub(crate) fn strain_grains(
        &self,
        simulation: &mut Simulation,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<Followed, PointError> {
        let before = simulation.state().step();
        strain(simulation, self.strain, self.pace, self.least_mean_stress, self.controls, watch)?;
        let averaged = relax(simulation, self.controls)?;
        Ok((averaged, simulation.state().step() - before))
    }
}

impl Hybrid {
    /// Takes everything that determines a result into a digest.
    ///
    /// # Errors
    /// If the surrogate or the grains cannot be written.
    pub(crate) fn digest(&self, digest: &mut Digest) -> Result<(), PointError> {
        digest.text("hybrid");
        self.surrogate.digest(digest)?;
        digest.bytes(&self.sample.checkpoint("")?);
        digest.numbers(&[self.trust.largest_deviation]);
        Ok(())
    }

    /// Follows a part of an increment from what a state consists of and the path that led to it.
    ///
    /// # Errors
    /// [`PointError`]; matter and path are then of no use.
    pub(crate) fn follow(
        &self,
        matter: &mut Matter,
        path: &mut Option<Arc<PathPart>>,
        part: &Part,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<Followed, PointError> {
        // Grains that were brought to an imposed stress have no path from the start.
        let was_imposed = path.is_none() && matches!(matter, Matter::Grains(_));
        let followed = match matter {
            Matter::Grains(simulation) => part.strain_grains(simulation, watch)?,
            Matter::Surrogate(state) => {
                let (next, stress) = self.surrogate.strained(state, part.strain)?;
                if next.outside.is_empty() && self.trust.counts(&stress, part.least_mean_stress) {
                    *state = next;
                    if watch(1.0) == Flow::Stop {
                        return Err(PointError::Stopped);
                    }
                    (stress, 1)
                } else {
                    let (mut simulation, steps) = self.grains_after(path, part, watch)?;
                    let (stress, more) = part.strain_grains(&mut simulation, watch)?;
                    *matter = Matter::Grains(Box::new(simulation));
                    (stress, steps + more)
                }
            }
        };
        if was_imposed {
            return Ok(followed);
        }
        let (strain, pace, stress) = (*part.strain, part.pace, followed.0.mean);
        *path = Some(Arc::new(PathPart { before: path.take(), strain, pace, stress }));
        Ok(followed)
    }

    /// The grains at the end of a path, which they follow from their start; the path then has their stresses.
    ///
    /// # Errors
    /// As [`Part::strain_grains`].
    pub(crate) fn grains_after(
        &self,
        path: &mut Option<Arc<PathPart>>,
        last: &Part,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<(Simulation, u64), PointError> {
        let mut simulation = self.sample.clone();
        let (mut followed, mut steps) = (None, 0);
        let mut stop = |_| if watch(0.0) == Flow::Stop { Flow::Stop } else { Flow::Continue };
        for own in parts(path.as_ref()) {
            let part = Part { strain: &own.strain, pace: own.pace, ..*last };
            let (stress, made) = part.strain_grains(&mut simulation, &mut stop)?;
            steps += made;
            followed = Some(Arc::new(PathPart {
                before: followed,
                strain: own.strain,
                pace: own.pace,
                stress: stress.mean,
            }));
        }
        *path = followed;
        Ok((simulation, steps))
    }
}
