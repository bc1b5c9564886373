//! Which DEM runs a reproduction makes, and what each is for.

use granum_dem::config::Rate;
use granum_io::Case;
use granum_learn::antony2006::reproduction::ReproductionOptions;

/// Seeds of the paper's own protocol: one run trains, two judge. Not 1 to 3 nor 101 to 124: samples of those seeds were looked
/// at when defaults of the training were chosen, so they can no longer judge it.
const PAPER: [(Role, u64); 3] = [(Role::Training, 11), (Role::Unseen, 12), (Role::Unseen, 13)];
/// First seed of the further training runs and of the further unseen runs.
const MORE: (u64, u64) = (21, 91);
/// Grains of the further runs at full size: with the time that is left, many small runs tell more than few large ones.
const FEWER_GRAINS: u64 = 2000;
/// Further training runs and unseen runs by default, at full size and in the quick version.
const FULL: (usize, usize) = (8, 4);
const QUICK: (usize, usize) = (4, 3);

/// What a run is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// It trains networks.
    Training,
    /// No network sees it.
    Unseen,
}

impl Role {
    pub fn name(self) -> &'static str {
        match self {
            Role::Training => "training",
            Role::Unseen => "unseen",
        }
    }
}

/// One run to make.
#[derive(Clone, Debug)]
pub struct Planned {
    /// Name of its folder.
    pub name: String,
    pub role: Role,
    pub seed: u64,
    pub case: Case,
}

/// All runs of a reproduction.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The paper's first.
    pub runs: Vec<Planned>,
    /// Which of them teach and judge networks that learn from more than one run.
    pub many: Vec<usize>,
}

impl Plan {
    pub fn new(options: &ReproductionOptions) -> Plan {
        let case = case(options.quick);
        let mut runs: Vec<Planned> =
            PAPER.iter().map(|&(role, seed)| planned("", role, seed, &case)).collect();
        let (training, unseen) = if options.quick { QUICK } else { FULL };
        let training = options.training_runs.unwrap_or(training);
        if training == 0 {
            return Plan { runs, many: Vec::new() };
        }
        let (prefix, small) = if options.quick { ("", case) } else { ("small-", smaller(case)) };
        // The runs of the quick version are all of one case: those of the paper's protocol serve here too.
        let mut many: Vec<usize> = if options.quick { (0..runs.len()).collect() } else { Vec::new() };
        for (role, count, first) in [(Role::Training, training, MORE.0), (Role::Unseen, unseen, MORE.1)] {
            let there = many.iter().filter(|&&k| runs[k].role == role).count();
            for k in 0..count.saturating_sub(there) {
                many.push(runs.len());
                runs.push(planned(prefix, role, first + k as u64, &small));
            }
        }
        Plan { runs, many }
    }

    /// Number of runs of the paper's own protocol; they come first.
    pub fn paper(&self) -> usize {
        PAPER.len()
    }

    /// Names of the folders of the runs.
    pub fn names(&self) -> Vec<String> {
        self.runs.iter().map(|run| run.name.clone()).collect()
    }
}

fn planned(prefix: &str, role: Role, seed: u64, case: &Case) -> Planned {
    let mut case = case.clone();
    case.preparation.seed = seed;
    Planned { name: format!("{prefix}{}-{seed}", role.name()), role, seed, case }
}

/// The paper's case, or a small and fast one like it.
fn case(quick: bool) -> Case {
    let mut case = Case::default();
    if quick {
        case.grains.count = 1000;
        case.shear.rate = Rate::InertialNumber(1e-3);
        case.preparation.inertial_number = 2e-3;
        case.preparation.solid_fraction_tolerance = 0.008;
        case.recording.states = 60;
        case.recording.looks = 10;
    }
    case
}

/// The same with fewer grains and as fast as is still quasi-static.
fn smaller(mut case: Case) -> Case {
    case.grains.count = FEWER_GRAINS as _;
    case.shear.rate = Rate::InertialNumber(1e-3);
    case
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_has_its_own_name_and_seed() {
        for quick in [false, true] {
            let plan = Plan::new(&ReproductionOptions { quick, ..Default::default() });
            let mut names = plan.names();
            names.sort();
            names.dedup();
            assert_eq!(names.len(), plan.runs.len());
            let role = |role| plan.many.iter().filter(|&&k| plan.runs[k].role == role).count();
            let wanted = if quick { QUICK } else { FULL };
            assert_eq!((role(Role::Training), role(Role::Unseen)), wanted);
        }
    }

    #[test]
    fn no_further_runs_on_request() {
        let options = ReproductionOptions { training_runs: Some(0), ..Default::default() };
        assert_eq!(Plan::new(&options).runs.len(), PAPER.len());
        let options = ReproductionOptions { training_runs: Some(16), ..Default::default() };
        assert_eq!(Plan::new(&options).runs.len(), PAPER.len() + 16 + FULL.1);
    }
}
