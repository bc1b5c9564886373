//! A surrogate that answers while it knows, and grains where it does not.
//!
//! A state begins as one of the surrogate. Where an answer of the surrogate is not to be trusted ([`Trust`]), the grains of the sample follow the whole path of
//! the state, and answer from there on. The stress then changes from what the surrogate said to what the grains say: by its error. Or they are brought to the stress
//! that the surrogate said last, so that a field stays in equilibrium; then it is the strain that changes.

use std::sync::Arc;

use granum_core::digest::Digest;
use granum_core::geometry::Matrix;
use granum_core::observer::Flow;
use granum_dem::simulation::Simulation;

use crate::answer_cache::AnswerCache;
use crate::controls::Controls;
use crate::error::PointError;
use crate::imposed_stress::impose;
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
/// assert!(Trust::up_to(0.1).check().is_ok() && Trust::up_to(-1.0).check().is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trust {
    /// Largest standard deviation of a component of the stress, over the mean stress, up to which an answer counts.
    pub largest_deviation: f64,
    /// True if grains that take over are brought to the last stress of the surrogate after they have followed its path, where they can carry it: the stress goes on
    /// and the strain of the grains is another one. False leaves them at the stress that the path has led them to.
    pub keeps_stress: bool,
}

impl Trust {
    /// Answers count up to this deviation, and grains take over with the stress of their path.
    pub fn up_to(largest_deviation: f64) -> Trust {
        Trust { largest_deviation, keeps_stress: false }
    }

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
    /// Grains at the ends of paths that they have followed last. A host that looks for equilibrium asks for many increments after one path.
    remembered: AnswerCache<PathKey, Arc<FollowedPath>>,
}

/// How many grains are remembered at the ends of paths: for the points of a field that change over in one step.
const REMEMBERED: usize = 32;

/// The end of a path, none before any increment, and the mean stress from which on its pace is that of a stress. A path that is kept here cannot be another one
/// at the same place.
struct PathKey(Option<Arc<PathPart>>, f64);

impl PartialEq for PathKey {
    fn eq(&self, other: &PathKey) -> bool {
        let is_same = match (&self.0, &other.0) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (None, None) => true,
            _ => false,
        };
        is_same && self.1.to_bits() == other.1.to_bits()
    }
}

/// Grains that have followed a path.
struct FollowedPath {
    grains: Simulation,
    /// The path with their stresses.
    path: Option<Arc<PathPart>>,
    steps: u64,
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
    pub(crate) fn new(surrogate: SurrogateModel, sample: Simulation, trust: Trust) -> Hybrid {
        Hybrid { surrogate, sample, trust, remembered: AnswerCache::new(REMEMBERED) }
    }

    /// Takes everything that determines a result into a digest.
    ///
    /// # Errors
    /// If the surrogate or the grains cannot be written.
    pub(crate) fn digest(&self, digest: &mut Digest) -> Result<(), PointError> {
        digest.text("hybrid");
        self.surrogate.digest(digest)?;
        digest.bytes(&self.sample.checkpoint("")?);
        digest.numbers(&[self.trust.largest_deviation]);
        if self.trust.keeps_stress {
            digest.text("keeps the stress");
        }
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
                    let (mut simulation, steps) = self.taken_over(path, part, watch)?;
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

    /// The grains that take over at the end of a path, from memory if they did so before.
    fn taken_over(
        &self,
        path: &mut Option<Arc<PathPart>>,
        last: &Part,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<(Simulation, u64), PointError> {
        let key = PathKey(path.clone(), last.least_mean_stress);
        let known = match self.remembered.get(&key) {
            Some(known) => known,
            None => {
                let stress = path.as_ref().map(|end| end.stress);
                let (mut grains, mut steps) = self.grains_after(path, last, watch)?;
                if let Some(stress) = stress.filter(|_| self.trust.keeps_stress) {
                    steps += keep_stress(&mut grains, path, &stress, last)?;
                }
                let known = Arc::new(FollowedPath { grains, path: path.clone(), steps });
                self.remembered.put(key, Arc::clone(&known));
                known
            }
        };
        *path = known.path.clone();
        Ok((known.grains.clone(), known.steps))
    }
}

/// Brings grains to a stress, by strains that become a part of their path; leaves them as they are if they do not carry it. Returns the number of steps.
///
/// # Errors
/// If the engine fails.
fn keep_stress(
    grains: &mut Simulation,
    path: &mut Option<Arc<PathPart>>,
    stress: &Matrix,
    last: &Part,
) -> Result<u64, PointError> {
    let mut brought = grains.clone();
    let reached = match impose(&mut brought, stress, last.least_mean_stress, last.controls) {
        Ok(reached) => reached.mean,
        Err(PointError::StressNotReached { .. }) => return Ok(0),
        Err(error) => return Err(error),
    };
    let steps = brought.state().step() - grains.state().step();
    let [now, before] = [brought.state().strain(), grains.state().strain()];
    let strain = std::array::from_fn(|i| std::array::from_fn(|j| now[i][j] - before[i][j]));
    *path = Some(Arc::new(PathPart { before: path.take(), strain, pace: Pace::OfControls, stress: reached }));
    *grains = brought;
    Ok(steps)
}
