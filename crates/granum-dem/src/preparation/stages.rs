//! Stages of a preparation, between its compaction and its relaxation: the strain cycles of the procedure, if it has any, then the
//! loading paths of the specification.
//!
//! They are stages as those of a test are and are executed by the same functions ([`loading::begin`], [`loading::follow`]), but
//! with the properties of the compaction and with the global damping of the preparation. Nothing is recorded.

use super::{
    PhaseState, PreparationError, PreparationState, Preparing, Procedure, SampleSpecification, StageFault,
    damp_globally,
};
use crate::config::Preparation;
use crate::loading::{self, Constraint, Control, Drive, Ending, Measure, Speed, Start, Target, Turns, Until};
use crate::observer::{Flow, Phase, SimulationObserver, SimulationProgress, Work};

/// Arc length of strain after which a stage of the specification ends that has no limit of its own.
const MOST_ARC_LENGTH: f64 = 1.0;

/// The strain cycles of a procedure: the axial strain is brought to the amplitude, to its negative, and so on, at constant mean
/// stress. The strain rate changes sign at the first step at which a turning point is reached.
pub(super) fn strain_cycles(p: &Preparation, procedure: Procedure) -> loading::Stage {
    let speed = Speed::InertialNumber { number: p.inertial_number, at: Some(procedure.mean_stress) };
    let (lateral, fixed) = (Drive::Rate(-0.5), Drive::Fixed);
    let mean_stress = Constraint::mean_stress(Target::held(procedure.mean_stress));
    let control = Control::new(speed, [Drive::Rate(1.0), lateral, lateral, fixed, fixed, fixed])
        .with(mean_stress.moving([0.0, 1.0, 1.0, 0.0, 0.0, 0.0]));
    let ends = vec![Until::Reversals(procedure.cycles.saturating_mul(2))];
    loading::Stage::new("cycles", control, ends).with(|stage| {
        stage.turns = Some(Turns { measure: Measure::Strain(0), high: p.cycle_strain, low: -p.cycle_strain });
        // The axial strain rate is prescribed, so that every turning point is certain to be reached.
        stage.most_arc_length = None;
    })
}

impl PreparationState {
    /// Number of stages before those of the specification.
    fn own_stages(&self) -> usize {
        self.procedure.map_or(0, |procedure| usize::from(procedure.cycles > 0))
    }

    /// The stage of this index.
    fn stage_at(&self, specification: &SampleSpecification, index: usize) -> Option<loading::Stage> {
        let own = self.own_stages();
        if index < own {
            return Some(strain_cycles(&specification.preparation, self.procedure?));
        }
        let mut stage = specification.stages.get(index - own)?.clone();
        stage.most_arc_length.get_or_insert(MOST_ARC_LENGTH);
        Some(stage)
    }

    /// The phase of the stage of this index.
    pub(super) fn phase_of_stage(&self, index: usize) -> Phase {
        if index < self.own_stages() { Phase::Cycles } else { Phase::PreparationStage }
    }

    fn fault(
        &self,
        specification: &SampleSpecification,
        index: usize,
        stage: loading::Stage,
        fault: StageFault,
    ) -> PreparationError {
        let number = index + 1 - self.own_stages().min(index);
        PreparationError::Stage { number, count: specification.stages.len(), name: stage.name, fault }
    }
}

impl Preparing {
    /// Begins the stage of this index; after the last one the relaxation.
    pub(super) fn begin_stage(
        &mut self,
        specification: &SampleSpecification,
        index: usize,
    ) -> Result<(), PreparationError> {
        let (s, progress) = (&mut self.simulation, &mut self.progress);
        let Some(stage) = progress.stage_at(specification, index) else {
            return self.relax(specification, index > 0);
        };
        if stage.start == Start::Back {
            return Err(progress.fault(specification, index, stage, StageFault::SavedState));
        }
        let first = index == 0 || index == progress.own_stages();
        if first || stage.resets {
            progress.count(s);
            s.reset_phase(0.0);
        }
        let friction = progress.procedure.map(|procedure| procedure.friction);
        let properties = friction.map_or_else(
            || specification.properties(),
            |friction| specification.properties().while_compacting(&specification.preparation, friction),
        );
        let properties = properties.with_densities(stage.density_scaling);
        if *s.properties() != properties {
            s.set_properties(properties)?;
        }
        match loading::begin(&stage, s) {
            Ok(begun) => progress.stage = PhaseState::Loading { index, progress: Box::new(begun) },
            Err(error) => return Err(progress.fault(specification, index, stage, error.into())),
        }
        damp_globally(s, specification);
        Ok(())
    }

    /// Continues the present stage to its end, at which the next one begins, or until the observer stops it.
    pub(super) fn follow_stage(
        &mut self,
        specification: &SampleSpecification,
        observer: &mut dyn SimulationObserver,
    ) -> Result<Flow, PreparationError> {
        let PhaseState::Loading { index, .. } = self.progress.stage else { return Ok(Flow::Continue) };
        let Some(stage) = self.progress.stage_at(specification, index) else {
            self.relax(specification, true)?;
            return Ok(Flow::Continue);
        };
        let phase = self.progress.phase();
        let mut observer = InPreparation {
            phase,
            trial: self.progress.trial(),
            steps: self.progress.steps,
            time: self.progress.time,
            stage: (phase == Phase::PreparationStage).then_some(stage.name.as_str()),
            observer,
        };
        let PhaseState::Loading { progress, .. } = &mut self.progress.stage else {
            return Ok(Flow::Continue);
        };
        match loading::follow(&stage, progress, &mut self.simulation, &mut observer)? {
            Ending::Stopped => return Ok(Flow::Stop),
            Ending::Complete(reason) if !reason.is_asked_for() => {
                let fault = StageFault::CutShort(reason);
                return Err(self.progress.fault(specification, index, stage, fault));
            }
            Ending::Complete(_) => {}
        }
        self.begin_stage(specification, index + 1)?;
        Ok(Flow::Continue)
    }
}

/// Passes on the progress of a stage as that of the preparation. A preparation records no states.
pub(super) struct InPreparation<'a> {
    pub(super) phase: Phase,
    pub(super) trial: usize,
    /// Steps and time, s, of the phases before.
    pub(super) steps: u64,
    pub(super) time: f64,
    /// Name of the stage, if the specification gives it.
    pub(super) stage: Option<&'a str>,
    pub(super) observer: &'a mut dyn SimulationObserver,
}

impl<'a> InPreparation<'a> {
    /// The progress of the preparation at that of a stage.
    fn announced<'b>(&self, progress: &SimulationProgress<'b>) -> SimulationProgress<'b>
    where
        'a: 'b,
    {
        SimulationProgress {
            phase: self.phase,
            trial: self.trial,
            stage: self.stage,
            // The share of the whole preparation that is complete is not known.
            fraction: None,
            steps: self.steps.saturating_add(progress.steps),
            time: self.time + progress.time,
            ..*progress
        }
    }
}

impl SimulationObserver for InPreparation<'_> {
    fn progress(&mut self, progress: &SimulationProgress) -> Flow {
        self.observer.progress(&self.announced(progress))
    }

    fn work(&mut self, work: &Work) -> Flow {
        match work {
            Work::Steps(progress) => self.observer.work(&Work::Steps(&self.announced(progress))),
            other => self.observer.work(other),
        }
    }

    fn work_every(&self) -> u64 {
        self.observer.work_every()
    }

    fn warn(&mut self, text: &str) {
        self.observer.warn(text);
    }
}
