//! The types of all crates that a program, another language or another thread holds own their data and can be sent; those of runs are
//! asserted in `granum-run`.

use granum_antony2006::{MappingMethod, PaperData, PaperSummary, StudyReport};
use granum_campaign::data_set::{Collected, DataSet, DataSetRun, DataSetSummary};
use granum_campaign::execution::{
    CampaignEstimate, CampaignProgress, ChildProcesses, NoCampaignObserver, Pilot, PilotOptions, Summary,
};
use granum_campaign::plan::{Condition, Expression, Plan, PlanRun, PlannedRuns, RunValue};
use granum_campaign::{Campaign, CampaignRun, CampaignStatus, PlanDifference, RunState};
use granum_learn::networks::{NetworkMapping, NetworkSettings, SubModelNetworks};
use granum_learn::study::{Member, StoredStudy, Study, StudyDefinition, StudyPlan, StudyScores};
use granum_learn::surrogate::{Content, RunInputs};
use granum_learn::{
    Dataset, FitSpec, LearnError, Prediction, RunStates, Split, Surrogate, SurrogateMethod, SurrogateMethods,
};
use granum_nets::{
    Data, DataError, Ensemble, Gru, Model, ModelDefinition, ModelError, Network, NetworkError,
    SequenceDefinition, SequenceModel,
};
use granum_report::{Document, RunReport};

use crate::Registry;

fn is_shared_by_threads<T: Send + Sync + 'static>() {}

/// Asserts it for a list of types.
macro_rules! shared {
    ($($type:ty),* $(,)?) => { $(is_shared_by_threads::<$type>();)* };
}

#[test]
fn public_types_own_their_data_and_can_be_sent() {
    shared!(Registry);
    shared!(Campaign, CampaignRun, CampaignStatus, PlanDifference, RunState);
    shared!(Plan, PlanRun, PlannedRuns, RunValue, Condition, Expression);
    shared!(
        Summary,
        CampaignEstimate,
        CampaignProgress,
        ChildProcesses,
        NoCampaignObserver,
        Pilot,
        PilotOptions
    );
    shared!(DataSet, DataSetRun, DataSetSummary, Collected);
    shared!(Dataset, RunStates, Split, FitSpec, LearnError, Prediction, RunInputs, Content);
    shared!(SurrogateMethods, Box<dyn SurrogateMethod>, Box<dyn Surrogate>);
    shared!(Study, StudyDefinition, StudyPlan, StudyScores, StoredStudy, Member);
    shared!(NetworkMapping, NetworkSettings, SubModelNetworks);
    shared!(Data, DataError, Ensemble, Gru, Model, ModelDefinition, ModelError, Network, NetworkError);
    shared!(SequenceDefinition, SequenceModel);
    shared!(MappingMethod, PaperData, PaperSummary, StudyReport);
    shared!(Document, RunReport);
}
