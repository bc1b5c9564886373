//! A material point whose sample is a live cell of the engine.

use granum_core::digest::Digest;
use granum_core::geometry::{Matrix, multiply};
use granum_core::observer::Flow;
use granum_core::parallel;
use granum_dem::observer::NoObserver;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::{Case, RunKind};
use granum_run::stiffness::Tensor;
use granum_run::{Laboratory, Source};

use crate::answer::Answer;
use crate::answer_cache::AnswerCache;
use crate::controls::{BeyondLargest, Controls};
use crate::error::PointError;
use crate::identity::Identity;
use crate::imposed_stress::{impose, largest_difference};
use crate::increment::Increment;
use crate::matrix_functions::{UNIT, transposed};
use crate::recipe::Recipe;
use crate::rotated::{stiffness_to_space, to_cell};
use crate::secant;
use crate::state::{Content, State};
use crate::straining::{relax, strain};
use crate::tangent::{self, Tangent};

/// Number of answers that are remembered.
const ANSWERS: usize = 16;
/// Number of stiffnesses that are remembered.
const STIFFNESSES: usize = 64;
/// Share of the mean stress of a sample whose strain rate is the smallest one.
const LEAST_SHARE: f64 = 0.01;
/// Difference from an imposed stress, over its scale, up to which a state counts as having it.
const SAME_STRESS: f64 = 1e-6;

/// A material point: a sample of grains, and how it is strained.
///
/// It has no state of its own: states are values that the caller holds. It can be asked from any number of threads at the same time,
/// and answers with the same bits on each.
pub struct MaterialPoint {
    controls: Controls,
    least_mean_stress: f64,
    start: State,
    answers: AnswerCache<Identity, Answer>,
    stiffnesses: AnswerCache<(Identity, [u64; 2]), Tensor>,
}

impl MaterialPoint {
    /// A material point whose sample is a simulation, for example the end of a preparation or of a test. Its grains are relaxed in their
    /// cell as after an increment; what happened to them before remains in their contacts.
    ///
    /// # Errors
    /// [`PointError::Control`] if a control is not possible, and if the engine fails.
    pub fn new(mut simulation: Simulation, controls: Controls) -> Result<MaterialPoint, PointError> {
        controls.check()?;
        // Points work in parallel, each on one thread.
        simulation.set_hardware(Hardware::default());
        simulation.set_global_damping(0.0);
        simulation.set_control(CellControl::fixed());
        simulation.reset_phase(0.0);
        let mean_stress = simulation.state().mean_stress();
        let averaged = relax(&mut simulation, &controls)?;
        let mut digest = Digest::new();
        digest.text(concat!("granum-point ", env!("CARGO_PKG_VERSION")));
        controls.digest(&mut digest);
        digest.bytes(&simulation.checkpoint("")?);
        let secant = tangent::affine(&simulation)?;
        let start = State::new(Content {
            identity: Identity::new(digest),
            simulation,
            rotation: UNIT,
            stress: averaged.mean,
            noise: averaged.deviation,
            secant,
        });
        let least = controls.least_mean_stress.unwrap_or(LEAST_SHARE * mean_stress);
        Ok(MaterialPoint {
            controls,
            // A sample without any stress gets a strain rate that is small for sand under its own weight.
            least_mean_stress: if least > 0.0 { least } else { 1.0 },
            start,
            answers: AnswerCache::new(ANSWERS),
            stiffnesses: AnswerCache::new(STIFFNESSES),
        })
    }

    /// A material point whose sample is prepared as a case says, with the bonds that the case makes before its first stage; its test is not used.
    ///
    /// # Errors
    /// [`PointError::Sample`] if the sample cannot be made, and as [`MaterialPoint::new`].
    pub fn from_case(case: &Case, controls: Controls) -> Result<MaterialPoint, PointError> {
        let sample = || {
            let plan = Laboratory::here().plan(RunKind::Sample, case, &Source::Case, &mut NoObserver)?;
            Ok(plan.in_memory(&mut NoObserver)?.simulation()?.clone())
        };
        let mut sample = sample().map_err(Box::new)?;
        for bond in case.bonds.iter().filter(|bond| bond.before_stage() == 1) {
            sample.bond(&bond.bonding(case.vocabulary.laws()))?;
        }
        MaterialPoint::new(sample, controls)
    }

    /// The state of the sample before any increment.
    pub fn start(&self) -> State {
        self.start.clone()
    }

    /// The controls.
    pub fn controls(&self) -> &Controls {
        &self.controls
    }

    /// The mean stress, Pa, whose strain rate is the smallest one.
    pub fn least_mean_stress(&self) -> f64 {
        self.least_mean_stress
    }

    /// The answer to an increment. A zero increment gives the state itself.
    ///
    /// # Errors
    /// [`PointError`]; the state that was asked is then as it was, and no other was made.
    pub fn advance(&self, state: &State, increment: &Increment) -> Result<Answer, PointError> {
        self.advance_watched(state, increment, &mut |_| Flow::Continue)
    }

    /// As [`MaterialPoint::advance`], with a watcher that is told the share that is done, and can stop it.
    ///
    /// # Errors
    /// As [`MaterialPoint::advance`], and [`PointError::Stopped`].
    pub fn advance_watched(
        &self,
        state: &State,
        increment: &Increment,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<Answer, PointError> {
        increment.check()?;
        let parts = self.parts(increment)?;
        if increment.is_zero() {
            return Ok(Answer { state: state.clone(), steps: 0 });
        }
        let identity = Recipe::Advance(*increment).follows(&state.identity());
        if let Some(answer) = self.answers.get(&identity) {
            return Ok(answer);
        }
        let answer = self.compute(state, increment, parts, identity, watch)?;
        self.answers.put(identity, answer.clone());
        Ok(answer)
    }

    /// The answers to many increments of many states, on up to `threads` threads (0: as many as the machine has), in the order of the
    /// questions and with the same bits on any number of threads.
    pub fn advance_all(
        &self,
        questions: &[(State, Increment)],
        threads: usize,
    ) -> Vec<Result<Answer, PointError>> {
        let answer = |k: usize| {
            let (state, increment) = &questions[k];
            Ok::<_, std::convert::Infallible>(self.advance(state, increment))
        };
        parallel::map(questions.len(), threads, answer).unwrap_or_default()
    }

    /// The state brought to a stress that its caller imposes, Pa, in the axes of space and compression positive, by a servo on all six
    /// components. Each component is then within a thousandth of the largest of them.
    ///
    /// # Errors
    /// [`PointError::StressNotReached`] if the sample cannot carry the stress, and if the engine fails.
    pub fn at_stress(&self, state: &State, stress: &Matrix) -> Result<Answer, PointError> {
        if !stress.iter().flatten().all(|x| x.is_finite()) {
            return Err(PointError::NotFinite { what: "an imposed stress" });
        }
        let content = state.content();
        let target = to_cell(&content.rotation, stress);
        let scale = stress.iter().flatten().fold(self.least_mean_stress, |scale, x| scale.max(x.abs()));
        if largest_difference(&content.stress, &target) <= SAME_STRESS * scale {
            return Ok(Answer { state: state.clone(), steps: 0 });
        }
        let identity = Recipe::Impose(*stress).follows(&content.identity);
        if let Some(answer) = self.answers.get(&identity) {
            return Ok(answer);
        }
        let mut simulation = content.simulation.clone();
        let before = simulation.state().step();
        let averaged = impose(&mut simulation, &target, self.least_mean_stress, &self.controls)?;
        let steps = simulation.state().step() - before;
        let secant = tangent::affine(&simulation)?;
        let answer = Answer {
            state: State::new(Content {
                identity,
                simulation,
                rotation: content.rotation,
                stress: averaged.mean,
                noise: averaged.deviation,
                secant,
            }),
            steps,
        };
        self.answers.put(identity, answer.clone());
        Ok(answer)
    }

    /// The stiffness of a state in the axes of space, Pa: stress `d_sigma_i = C_ij d_eps_j` by components xx, yy, zz, yz, zx, xy,
    /// compression positive, with shear strains as angles. It is not symmetric in general.
    ///
    /// # Errors
    /// [`PointError::Stiffness`] if the sample carries no load and the elastic stiffness is asked for, and if the engine fails.
    pub fn tangent(&self, state: &State, tangent: Tangent) -> Result<Tensor, PointError> {
        let content = state.content();
        let key = (content.identity, tangent.key());
        if let Some(stiffness) = self.stiffnesses.get(&key) {
            return Ok(stiffness);
        }
        let in_cell = match tangent {
            Tangent::Secant => content.secant,
            Tangent::Affine => tangent::affine(&content.simulation)?,
            Tangent::Elastic => tangent::elastic(&content.simulation)?,
            Tangent::Probes { strain } => {
                tangent::probed(&content.simulation, strain, self.least_mean_stress, &self.controls)?
            }
        };
        let stiffness = stiffness_to_space(&content.rotation, &in_cell);
        self.stiffnesses.put(key, stiffness);
        Ok(stiffness)
    }

    /// The number of equal parts in which an increment is carried out.
    fn parts(&self, increment: &Increment) -> Result<u32, PointError> {
        let (size, controls) = (increment.size(), &self.controls);
        let too_large = |limit: f64| Err(PointError::TooLarge { size, limit });
        if size.is_nan() || size > controls.absurd_increment {
            return too_large(controls.absurd_increment);
        }
        if size <= controls.largest_increment {
            return Ok(1);
        }
        match controls.beyond_largest {
            BeyondLargest::Divide => Ok((size / controls.largest_increment).ceil() as u32),
            BeyondLargest::Refuse => too_large(controls.largest_increment),
        }
    }

    fn compute(
        &self,
        state: &State,
        increment: &Increment,
        parts: u32,
        identity: Identity,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<Answer, PointError> {
        let from = state.content();
        let rotation = followed(&increment.rotation, &from.rotation);
        let mut content = Content {
            identity,
            simulation: from.simulation.clone(),
            rotation,
            stress: from.stress,
            noise: from.noise,
            secant: from.secant,
        };
        let before = content.simulation.state().step();
        if increment.strain != [[0.0; 3]; 3] {
            let count = f64::from(parts);
            let part = to_cell(&rotation, &increment.strain.map(|row| row.map(|x| x / count)));
            for k in 0..parts {
                let mut watch_part = |share: f64| watch((f64::from(k) + share) / count);
                let (least, controls) = (self.least_mean_stress, &self.controls);
                strain(&mut content.simulation, &part, increment.pace, least, controls, &mut watch_part)?;
                let averaged = relax(&mut content.simulation, controls)?;
                content.secant = secant::updated(&content.secant, &part, &content.stress, &averaged.mean);
                (content.stress, content.noise) = (averaged.mean, averaged.deviation);
            }
        }
        let steps = content.simulation.state().step() - before;
        Ok(Answer { state: State::new(content), steps })
    }

    /// Carries out a recipe, for example of the path that a store remembers.
    ///
    /// # Errors
    /// As [`MaterialPoint::advance`] and [`MaterialPoint::at_stress`].
    pub fn follow(&self, state: &State, recipe: &Recipe) -> Result<Answer, PointError> {
        match recipe {
            Recipe::Advance(increment) => self.advance(state, increment),
            Recipe::Impose(stress) => self.at_stress(state, stress),
        }
    }
}

/// One rotation after another, brought back to a rotation to rounding (one step of Newton's iteration).
fn followed(second: &Matrix, first: &Matrix) -> Matrix {
    if *second == UNIT {
        return *first;
    }
    let product = multiply(second, first);
    let square = multiply(&transposed(&product), &product);
    let correction: Matrix =
        std::array::from_fn(|r| std::array::from_fn(|c| 1.5 * UNIT[r][c] - 0.5 * square[r][c]));
    multiply(&product, &correction)
}
