//! A material point: a live cell of the engine, or a surrogate in its place.

use std::collections::BTreeMap;
use std::sync::Arc;

use granum_core::digest::Digest;
use granum_core::geometry::{Matrix, multiply};
use granum_core::observer::Flow;
use granum_core::parallel;
use granum_dem::observer::NoObserver;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Simulation};
use granum_io::{Case, RunKind};
use granum_learn::surrogate::Surrogate;
use granum_run::stiffness::Tensor;
use granum_run::{Laboratory, Source};
use granum_sensors::Sensors;

use crate::answer::Answer;
use crate::answer_cache::AnswerCache;
use crate::controls::{BeyondLargest, Controls};
use crate::error::PointError;
use crate::hybrid::{Followed, Hybrid, Part, Trust};
use crate::identity::Identity;
use crate::imposed_on_surrogate;
use crate::imposed_stress::{impose, largest_difference};
use crate::increment::{Increment, Pace};
use crate::matrix_functions::{UNIT, transposed};
use crate::path_so_far::PathPart;
use crate::recipe::Recipe;
use crate::rotated::{stiffness_to_space, to_cell};
use crate::secant;
use crate::state::{Content, Matter, State};
use crate::straining::{AveragedStress, relax};
use crate::surrogate_model::SurrogateModel;
use crate::tangent::{self, Tangent};

/// Number of answers that are remembered.
const ANSWERS: usize = 16;
/// Number of stiffnesses that are remembered.
const STIFFNESSES: usize = 64;
/// Share of the mean stress of a sample whose strain rate is the smallest one.
const LEAST_SHARE: f64 = 0.01;
/// Difference from an imposed stress, over its scale, up to which a state counts as having it.
const SAME_STRESS: f64 = 1e-6;

/// Strain of the differences from which the first secant stiffness of a surrogate follows.
const FIRST_PROBE: f64 = 1e-4;

/// What answers.
enum Model {
    /// The grains of the states.
    Grains,
    Surrogate(SurrogateModel),
    /// A surrogate while it knows, and grains where it does not.
    Hybrid(Box<Hybrid>),
}

impl Model {
    /// The surrogate, if there is one.
    fn surrogate(&self) -> Option<&SurrogateModel> {
        match self {
            Model::Grains => None,
            Model::Surrogate(model) => Some(model),
            Model::Hybrid(hybrid) => Some(&hybrid.surrogate),
        }
    }
}

/// A material point: a sample of grains, or a surrogate of one, and how it is strained.
///
/// It has no state of its own: states are values that the caller holds. It can be asked from any number of threads at the same time,
/// and answers with the same bits on each.
pub struct MaterialPoint {
    model: Model,
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
    pub fn new(simulation: Simulation, controls: Controls) -> Result<MaterialPoint, PointError> {
        controls.check()?;
        let mean_stress = simulation.state().mean_stress();
        let (simulation, averaged) = at_rest(simulation, &controls)?;
        let mut digest = Digest::new();
        digest.text(concat!("granum-point ", env!("CARGO_PKG_VERSION")));
        controls.digest(&mut digest);
        digest.bytes(&simulation.checkpoint("")?);
        let secant = tangent::affine(&simulation)?;
        let start = Content {
            identity: Identity::new(digest),
            matter: Matter::Grains(Box::new(simulation)),
            rotation: UNIT,
            stress: averaged.mean,
            noise: averaged.deviation,
            secant,
            path: None,
        };
        Ok(MaterialPoint::from_start(Model::Grains, controls, start, mean_stress))
    }

    /// A material point whose stress a surrogate with memory predicts from strains, for example one of the methods `path-...`. `sample` has the values of its
    /// inputs that are no strains, by name. Its inputs are the six logarithmic strains since the start, of which the first row has none, in axes that rotate
    /// with the sample; its outputs are the six stresses, Pa, and any others ([`State::value`]).
    ///
    /// Of the controls the largest and the absurd increment and the least mean stress count. A surrogate knows no time, so that the pace of an increment
    /// changes nothing. Its answer depends on how a path is cut: increments should be about as long as those between its training states.
    ///
    /// ```
    /// use granum_core::observer::NoObserver;
    /// use granum_core::{Column, Table};
    /// use granum_learn::surrogate::{FitSpec, Recurrent, SurrogateMethod};
    /// use granum_learn::{Dataset, RunStates};
    /// use granum_nets::trainer::Adam;
    /// use granum_point::{Controls, Increment, MaterialPoint, Tangent};
    ///
    /// // An elastic body, for want of grains.
    /// let strains = ["axial_strain", "lateral_strain_2", "lateral_strain_3", "shear_strain_yz", "shear_strain_zx", "shear_strain_xy"];
    /// let stresses = ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"];
    /// let run = |seed: u32| {
    ///     let strain = |k: u32| (0..20).map(move |i| 1e-3 * f64::from(i) * (f64::from(7 * seed + k)).sin());
    ///     let columns = strains.into_iter().zip(0..).map(|(name, k)| Column::new(name, "1", strain(k).collect()));
    ///     let stress = |k: u32| strain(k).map(|strain| 1e5 + 1e7 * strain).collect();
    ///     let columns = columns.chain(stresses.into_iter().zip(0..).map(|(name, k)| Column::new(name, "Pa", stress(k))));
    ///     RunStates::new(&format!("run-{seed}"), Table::new(columns.collect())?)
    /// };
    /// let dataset = Dataset::new((0..6).map(run).collect::<granum_learn::Result<_>>()?)?;
    /// let mut method = Recurrent::default();
    /// (method.hidden, method.networks, method.trainer) = (6, 1, Adam { epochs: 20, ..Adam::default() }.into());
    /// let surrogate = method.fit(&dataset, &FitSpec::new(strains, stresses), &mut NoObserver)?;
    ///
    /// let point = MaterialPoint::from_surrogate(surrogate.into(), &Default::default(), Controls::default())?;
    /// let compressed = point.advance(&point.start(), &Increment::from_components([1e-3, 0.0, 0.0, 0.0, 0.0, 0.0]))?;
    /// let stiffness = point.tangent(&compressed.state, Tangent::Probes { strain: 1e-5 })?;
    /// assert!(stiffness.0[0][0].is_finite() && compressed.state.simulation().is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    /// [`PointError::Control`], [`PointError::NoMaterial`] if it is not a surrogate of this kind, and [`PointError::Surrogate`] if it has no answer without strain.
    pub fn from_surrogate(
        surrogate: Arc<dyn Surrogate>,
        sample: &BTreeMap<String, f64>,
        controls: Controls,
    ) -> Result<MaterialPoint, PointError> {
        controls.check()?;
        let model = SurrogateModel::new(surrogate, sample)?;
        let mut digest = Digest::new();
        digest.text(concat!("granum-point ", env!("CARGO_PKG_VERSION")));
        controls.digest(&mut digest);
        model.digest(&mut digest)?;
        let start = start_of(&model, Identity::new(digest))?;
        let mean_stress = mean_of(&start.stress);
        Ok(MaterialPoint::from_start(Model::Surrogate(model), controls, start, mean_stress))
    }

    /// A material point that a surrogate answers for while it knows, and the grains of a sample where it does not: where the standard deviation of a stress is larger than
    /// `trust` allows, or an input or the path is outside of what the surrogate was trained on. The grains then follow the path of the state from the start on, and
    /// answer from there; the stress changes by the error that the surrogate had. A state tells who answered ([`State::is_live`]), and its path is a test from which a
    /// surrogate can learn ([`State::path`]).
    ///
    /// The values of inputs `sample.X` that are not given are measured on the sample.
    ///
    /// # Errors
    /// As [`MaterialPoint::new`] and [`MaterialPoint::from_surrogate`].
    pub fn hybrid(
        surrogate: Arc<dyn Surrogate>,
        sample: &BTreeMap<String, f64>,
        simulation: Simulation,
        trust: Trust,
        controls: Controls,
    ) -> Result<MaterialPoint, PointError> {
        controls.check()?;
        trust.check()?;
        let mean_stress = simulation.state().mean_stress();
        let (simulation, _) = at_rest(simulation, &controls)?;
        let values = with_measured(surrogate.as_ref(), sample, &simulation);
        let method = surrogate.method().to_string();
        let hybrid = Hybrid::new(SurrogateModel::new(surrogate, &values)?, simulation, trust);
        let mut digest = Digest::new();
        digest.text(concat!("granum-point ", env!("CARGO_PKG_VERSION")));
        controls.digest(&mut digest);
        hybrid.digest(&mut digest)?;
        let start = start_of(&hybrid.surrogate, Identity::new(digest))?;
        if start.noise == [[0.0; 3]; 3] {
            let reason =
                "it does not say how sure it is, by which a hybrid point decides: train several networks";
            return Err(PointError::NoMaterial { method, reason: reason.into() });
        }
        Ok(MaterialPoint::from_start(Model::Hybrid(Box::new(hybrid)), controls, start, mean_stress))
    }

    /// A point whose first state has a mean stress, Pa.
    fn from_start(model: Model, controls: Controls, start: Content, mean_stress: f64) -> MaterialPoint {
        let least = controls.least_mean_stress.unwrap_or(LEAST_SHARE * mean_stress);
        MaterialPoint {
            model,
            controls,
            // A sample without any stress gets a strain rate that is small for sand under its own weight.
            least_mean_stress: if least > 0.0 { least } else { 1.0 },
            start: State::new(start),
            answers: AnswerCache::new(ANSWERS),
            stiffnesses: AnswerCache::new(STIFFNESSES),
        }
    }

    /// A material point whose sample is prepared as a case says, with the bonds that the case makes before its first stage; its test is not used.
    ///
    /// # Errors
    /// As [`MaterialPoint::sample_of_case`] and [`MaterialPoint::new`].
    pub fn from_case(case: &Case, controls: Controls) -> Result<MaterialPoint, PointError> {
        MaterialPoint::new(MaterialPoint::sample_of_case(case)?, controls)
    }

    /// The sample of a case, with the bonds that the case makes before its first stage.
    ///
    /// # Errors
    /// [`PointError::Sample`] if the sample cannot be made.
    pub fn sample_of_case(case: &Case) -> Result<Simulation, PointError> {
        let sample = || {
            let plan = Laboratory::here().plan(RunKind::Sample, case, &Source::Case, &mut NoObserver)?;
            Ok(plan.in_memory(&mut NoObserver)?.simulation()?.clone())
        };
        let mut sample = sample().map_err(Box::new)?;
        for bond in case.bonds.iter().filter(|bond| bond.before_stage() == 1) {
            sample.bond(&bond.bonding(case.vocabulary.laws()))?;
        }
        Ok(sample)
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

    /// The state brought to a stress that its caller imposes, Pa, in the axes of space and compression positive: grains by a servo on all six
    /// components, a surrogate by strains of up to 1e-3 that Newton's method chooses. Each component is then within a thousandth of the largest of them.
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
        let answer = match self.own_matter(content)? {
            Matter::Grains(before) => {
                self.imposed_on_grains(content, Simulation::clone(before), &target, identity)?
            }
            Matter::Surrogate(_) => self.imposed_on_surrogate(content, &target, identity)?,
        };
        self.answers.put(identity, answer.clone());
        Ok(answer)
    }

    /// Grains that are brought to a stress in the axes of the cell. They were not strained along a path from the start, along which others could follow.
    fn imposed_on_grains(
        &self,
        content: &Content,
        mut simulation: Simulation,
        stress: &Matrix,
        identity: Identity,
    ) -> Result<Answer, PointError> {
        let before = simulation.state().step();
        let averaged = impose(&mut simulation, stress, self.least_mean_stress, &self.controls)?;
        let steps = simulation.state().step() - before;
        let secant = tangent::affine(&simulation)?;
        let (matter, rotation) = (Matter::Grains(Box::new(simulation)), content.rotation);
        let (stress, noise) = (averaged.mean, averaged.deviation);
        let state = State::new(Content { identity, matter, rotation, stress, noise, secant, path: None });
        Ok(Answer { state, steps })
    }

    /// A surrogate that is strained until it has a stress in the axes of the cell; of a hybrid point its grains, where it is not to be trusted on the way or does not
    /// reach the stress.
    fn imposed_on_surrogate(
        &self,
        content: &Content,
        stress: &Matrix,
        identity: Identity,
    ) -> Result<Answer, PointError> {
        let (mut matter, mut path, mut steps) = (content.matter.clone(), content.path.clone(), 0);
        let mut follow = |strain: &Matrix| {
            let part = self.part(strain, Pace::OfControls);
            let (reached, made) = self.follow_part(&mut matter, &mut path, &part, &mut |_| Flow::Continue)?;
            steps += made;
            // Grains are brought to a stress in another way.
            if matches!(matter, Matter::Grains(_)) { Err(PointError::Stopped) } else { Ok(reached) }
        };
        let from = AveragedStress { mean: content.stress, deviation: content.noise };
        let first = match (&content.matter, self.model.surrogate()) {
            (Matter::Surrogate(state), Some(model)) => tangent::probed_surrogate(model, state, FIRST_PROBE)?,
            _ => return Err(other_kind(&self.model)),
        };
        let least = self.least_mean_stress;
        match (imposed_on_surrogate::impose(&from, first, stress, least, &mut follow), &self.model) {
            (Ok((reached, secant, _)), _) => {
                let (rotation, stress, noise) = (content.rotation, reached.mean, reached.deviation);
                let state = State::new(Content { identity, matter, rotation, stress, noise, secant, path });
                Ok(Answer { state, steps })
            }
            (Err(PointError::Stopped | PointError::StressNotReached { .. }), Model::Hybrid(hybrid)) => {
                let part = self.part(&[[0.0; 3]; 3], Pace::OfControls);
                let path = &mut content.path.clone();
                let (grains, made) = hybrid.grains_after(path, &part, &mut |_| Flow::Continue)?;
                let answer = self.imposed_on_grains(content, grains, stress, identity)?;
                Ok(Answer { steps: answer.steps + made, ..answer })
            }
            (Err(error), _) => Err(error),
        }
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
        let in_cell = match (tangent, self.own_matter(content)?) {
            (Tangent::Secant, _) => content.secant,
            (Tangent::Affine, Matter::Grains(simulation)) => tangent::affine(simulation)?,
            (Tangent::Elastic, Matter::Grains(simulation)) => tangent::elastic(simulation)?,
            (Tangent::Probes { strain }, Matter::Grains(simulation)) => {
                tangent::probed(simulation, strain, self.least_mean_stress, &self.controls)?
            }
            (Tangent::Probes { strain }, Matter::Surrogate(state)) => match self.model.surrogate() {
                Some(model) => tangent::probed_surrogate(model, state, strain)?,
                None => return Err(other_kind(&self.model)),
            },
            (Tangent::Affine | Tangent::Elastic, Matter::Surrogate(_)) => {
                let what = "the affine or elastic stiffness";
                return Err(PointError::NoGrains { what, instead: "ask for probes or for the secant" });
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

    /// What a state consists of, if it is of the kind of this point.
    fn own_matter<'a>(&self, content: &'a Content) -> Result<&'a Matter, PointError> {
        match (&self.model, &content.matter) {
            (Model::Grains | Model::Hybrid(_), Matter::Grains(_))
            | (Model::Surrogate(_) | Model::Hybrid(_), Matter::Surrogate(_)) => Ok(&content.matter),
            _ => Err(other_kind(&self.model)),
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
        let mut content = Content {
            identity,
            matter: self.own_matter(from)?.clone(),
            rotation: followed(&increment.rotation, &from.rotation),
            stress: from.stress,
            noise: from.noise,
            secant: from.secant,
            path: from.path.clone(),
        };
        let mut steps = 0;
        if increment.strain != [[0.0; 3]; 3] {
            let count = f64::from(parts);
            let part = to_cell(&content.rotation, &increment.strain.map(|row| row.map(|x| x / count)));
            for k in 0..parts {
                let mut watch_part = |share: f64| watch((f64::from(k) + share) / count);
                let own = self.part(&part, increment.pace);
                let (averaged, made) =
                    self.follow_part(&mut content.matter, &mut content.path, &own, &mut watch_part)?;
                steps += made;
                content.secant = secant::updated(&content.secant, &part, &content.stress, &averaged.mean);
                (content.stress, content.noise) = (averaged.mean, averaged.deviation);
            }
        }
        Ok(Answer { state: State::new(content), steps })
    }

    /// A part of an increment with the controls of this point.
    fn part<'a>(&'a self, strain: &'a Matrix, pace: Pace) -> Part<'a> {
        Part { strain, pace, least_mean_stress: self.least_mean_stress, controls: &self.controls }
    }

    /// Strains what a state consists of by a part of an increment: the stress after it, and the number of steps.
    fn follow_part(
        &self,
        matter: &mut Matter,
        path: &mut Option<Arc<PathPart>>,
        part: &Part,
        watch: &mut dyn FnMut(f64) -> Flow,
    ) -> Result<Followed, PointError> {
        match (&self.model, matter) {
            (Model::Hybrid(hybrid), matter) => hybrid.follow(matter, path, part, watch),
            (Model::Grains, Matter::Grains(simulation)) => part.strain_grains(simulation, watch),
            (Model::Surrogate(model), Matter::Surrogate(state)) => {
                let (next, stress) = model.strained(state, part.strain)?;
                *state = next;
                if watch(1.0) == Flow::Stop { Err(PointError::Stopped) } else { Ok((stress, 1)) }
            }
            _ => Err(other_kind(&self.model)),
        }
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

/// Why a state cannot be that of a point.
fn other_kind(model: &Model) -> PointError {
    match model {
        Model::Grains => PointError::OtherKind { state: "a surrogate", point: "grains" },
        Model::Surrogate(_) => PointError::OtherKind { state: "grains", point: "a surrogate" },
        Model::Hybrid(_) => PointError::OtherKind { state: "another kind", point: "a surrogate and grains" },
    }
}

/// A sample that is held and relaxed as after an increment, with the stress after it.
fn at_rest(
    mut simulation: Simulation,
    controls: &Controls,
) -> Result<(Simulation, AveragedStress), PointError> {
    // Points work in parallel, each on one thread.
    simulation.set_hardware(Hardware::default());
    simulation.set_global_damping(0.0);
    simulation.set_control(CellControl::fixed());
    simulation.reset_phase(0.0);
    let averaged = relax(&mut simulation, controls)?;
    Ok((simulation, averaged))
}

fn mean_of(stress: &Matrix) -> f64 {
    (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0
}

/// What the first state of a surrogate consists of.
fn start_of(model: &SurrogateModel, identity: Identity) -> Result<Content, PointError> {
    let (state, AveragedStress { mean, deviation }) = model.start()?;
    let secant = tangent::probed_surrogate(model, &state, FIRST_PROBE)?;
    let matter = Matter::Surrogate(state);
    Ok(Content { identity, matter, rotation: UNIT, stress: mean, noise: deviation, secant, path: None })
}

/// The values that are given, with those of the inputs `sample.X` that are not given as they are measured on the sample.
fn with_measured(
    surrogate: &dyn Surrogate,
    given: &BTreeMap<String, f64>,
    simulation: &Simulation,
) -> BTreeMap<String, f64> {
    let sensors = Sensors::standard();
    let measured = sensors.for_clumps(simulation.state().has_clumps()).measure_state(simulation);
    let mut values = given.clone();
    for name in surrogate.columns().input_names() {
        let column = name.strip_prefix("sample.").filter(|_| !values.contains_key(&name));
        let value = column.and_then(|column| match column {
            "void_ratio" => Some(1.0 / simulation.state().solid_fraction() - 1.0),
            column => measured.value(column),
        });
        values.extend(value.map(|value| (name.clone(), value)));
    }
    values
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
