//! The DEM runs of a reproduction and their roles.

use granum_antony2006::reproduction::ReproductionOptions;
use granum_dem::config::Rate;
use granum_io::Case;
use granum_learn::runs::RunRole;

/// Seeds of the protocol of the paper: one training run and two unseen runs. Seeds 1 to 3 and 101 to 124 are excluded, since
/// samples with these seeds were used to choose the defaults of the training and can no longer serve to evaluate it.
const PAPER: [(RunRole, u64); 3] = [(RunRole::Training, 11), (RunRole::Unseen, 12), (RunRole::Unseen, 13)];
/// First seeds of the additional training runs and of the additional unseen runs.
const MORE: (u64, u64) = (21, 91);
/// Number of grains of the additional runs at full size: for the same computing time, many small runs give more information
/// than a few large ones.
const FEWER_GRAINS: u64 = 2000;
/// Default numbers of additional training and unseen runs, at full size and in the quick version.
const FULL: (usize, usize) = (8, 4);
const QUICK: (usize, usize) = (4, 3);

/// A run of a reproduction.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Name of its folder.
    pub name: String,
    pub role: RunRole,
    pub seed: u64,
    pub case: Case,
}

/// All runs of a reproduction.
#[derive(Clone, Debug)]
pub struct ReproductionPlan {
    /// The runs; those of the protocol of the paper come first.
    pub runs: Vec<Planned>,
    /// Indices of the runs that serve to train and evaluate networks with more than one training run.
    pub many: Vec<usize>,
}

impl ReproductionPlan {
    pub fn new(options: &ReproductionOptions) -> ReproductionPlan {
        let mut case = case(options.quick);
        case.grains.count = options.grains.map_or(case.grains.count, |grains| grains as _);
        let mut runs: Vec<Planned> =
            PAPER.iter().map(|&(role, seed)| planned("", role, seed, &case)).collect();
        let (training, unseen) = if options.quick { QUICK } else { FULL };
        let training = options.training_runs.unwrap_or(training);
        if training == 0 {
            return ReproductionPlan { runs, many: Vec::new() };
        }
        let (prefix, small) = if options.quick { ("", case) } else { ("small-", smaller(case)) };
        // All runs of the quick version have the same case, so that those of the protocol of the paper can be used here as
        // well.
        let mut many: Vec<usize> = if options.quick { (0..runs.len()).collect() } else { Vec::new() };
        for (role, count, first) in [(RunRole::Training, training, MORE.0), (RunRole::Unseen, unseen, MORE.1)]
        {
            let there = many.iter().filter(|&&k| runs[k].role == role).count();
            for k in 0..count.saturating_sub(there) {
                many.push(runs.len());
                runs.push(planned(prefix, role, first + k as u64, &small));
            }
        }
        ReproductionPlan { runs, many }
    }

    /// Number of runs of the protocol of the paper, which come first.
    pub fn paper(&self) -> usize {
        PAPER.len()
    }

    /// Names of the run folders.
    pub fn names(&self) -> Vec<String> {
        self.runs.iter().map(|run| run.name.clone()).collect()
    }
}

fn planned(prefix: &str, role: RunRole, seed: u64, case: &Case) -> Planned {
    let mut case = case.clone();
    case.preparation.seed = seed;
    Planned { name: format!("{prefix}{}-{seed}", role.name()), role, seed, case }
}

/// The case of the paper, or a similar one that is small and fast.
fn case(quick: bool) -> Case {
    let mut case = Case::default();
    if quick {
        case = case.with_shear(|shear| shear.rate = Rate::InertialNumber(1e-3));
        case.grains.count = 1000;
        case.preparation.inertial_number = 2e-3;
        case.preparation.solid_fraction_tolerance = 0.008;
        case.recording.states = 60;
        case.recording.observations_per_state = 10;
    }
    case
}

/// The same case with fewer grains, and with the largest strain rate that is still quasi-static.
fn smaller(mut case: Case) -> Case {
    case.grains.count = case.grains.count.min(FEWER_GRAINS as _);
    case.with_shear(|shear| shear.rate = Rate::InertialNumber(1e-3))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_has_its_own_name_and_seed() {
        for quick in [false, true] {
            let plan = ReproductionPlan::new(&ReproductionOptions { quick, ..Default::default() });
            let mut names = plan.names();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), plan.runs.len());
            let role = |role| plan.many.iter().filter(|&&k| plan.runs[k].role == role).count();
            let wanted = if quick { QUICK } else { FULL };
            assert_eq!((role(RunRole::Training), role(RunRole::Unseen)), wanted);
        }
    }

    #[test]
    fn no_further_runs_on_request() {
        let options = ReproductionOptions { training_runs: Some(0), ..Default::default() };
        assert_eq!(ReproductionPlan::new(&options).runs.len(), PAPER.len());
        let options = ReproductionOptions { training_runs: Some(16), ..Default::default() };
        assert_eq!(ReproductionPlan::new(&options).runs.len(), PAPER.len() + 16 + FULL.1);
    }
}
