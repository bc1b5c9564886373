//! The types that a program, another language or another thread holds own their data and can be sent.

use crate::lammps_deck::LammpsDeck;
use crate::queue::{Outcome, Queue, QueuedRun, RunList};
use crate::runs_table::{RunEntry, RunsTable};
use crate::stiffness::{Probes, Probing, Stiffness};
use crate::{
    Engine, EngineError, EngineRun, Engines, Laboratory, LaboratoryError, PlannedRun, Resources, RunKind,
    RunRegistry, RunResult, Source, Task,
};

fn is_owned_and_can_be_sent<T: Send + 'static>() {}

fn is_shared_by_threads<T: Send + Sync + 'static>() {}

#[test]
fn public_types_own_their_data_and_can_be_sent() {
    is_shared_by_threads::<Laboratory>();
    is_shared_by_threads::<RunRegistry>();
    is_shared_by_threads::<Engines>();
    is_shared_by_threads::<Box<dyn Engine>>();
    is_shared_by_threads::<Resources>();
    is_shared_by_threads::<Source>();
    is_shared_by_threads::<RunKind>();
    is_shared_by_threads::<Task>();
    is_shared_by_threads::<LaboratoryError>();
    is_shared_by_threads::<EngineError>();
    is_owned_and_can_be_sent::<EngineRun>();
    is_owned_and_can_be_sent::<PlannedRun>();
    is_owned_and_can_be_sent::<RunResult>();
    is_shared_by_threads::<Queue>();
    is_shared_by_threads::<QueuedRun>();
    is_shared_by_threads::<RunList>();
    is_shared_by_threads::<Outcome>();
    is_shared_by_threads::<RunEntry>();
    is_shared_by_threads::<RunsTable>();
    is_shared_by_threads::<LammpsDeck>();
    is_owned_and_can_be_sent::<Probes>();
    is_shared_by_threads::<Probing>();
    is_shared_by_threads::<Stiffness>();
    // Of the crates below that a user of this one holds.
    is_shared_by_threads::<granum_io::Case>();
    is_shared_by_threads::<granum_io::case::Vocabulary>();
    is_shared_by_threads::<granum_io::Formats>();
    is_shared_by_threads::<granum_io::Packing>();
    is_shared_by_threads::<granum_io::Run>();
    is_shared_by_threads::<granum_io::RunFolder>();
    is_shared_by_threads::<granum_io::RunRecord>();
    is_shared_by_threads::<granum_sensors::Sensors>();
    is_shared_by_threads::<granum_sensors::Record>();
    is_shared_by_threads::<granum_sensors::RecordedState>();
    is_owned_and_can_be_sent::<granum_sensors::Recorder>();
    is_shared_by_threads::<granum_core::Assembly>();
    is_owned_and_can_be_sent::<granum_dem::simulation::Simulation>();
    is_owned_and_can_be_sent::<granum_dem::preparation::Preparing>();
    is_shared_by_threads::<granum_dem::preparation::SampleSpecification>();
}
