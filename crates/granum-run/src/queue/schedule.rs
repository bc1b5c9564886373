//! The order in which the runs of a queue begin: the longest first, and each after the one that it waits for.

/// The state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Waiting,
    Running,
    /// It ended, and those that wait for it may begin if it is finished.
    Over {
        finished: bool,
    },
}

/// What a thread does next.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Next {
    /// Execute this run.
    Run(usize),
    /// Give up this run, since the one that it waits for is not finished.
    GiveUp(usize),
    /// Wait until a run ends.
    Wait,
    /// Every run is over or running, and none waits for one that runs.
    Nothing,
}

/// The runs of a queue that are to be executed.
#[derive(Clone, Debug)]
pub(super) struct Schedule {
    state: Vec<State>,
    after: Vec<Option<usize>>,
    /// The runs in the order in which they should begin.
    order: Vec<usize>,
    /// So many of them, the first ones, wait no more.
    begun: usize,
}

impl Schedule {
    /// A schedule of runs with their work and the run that each waits for. A run counts with the longest of those that wait for it.
    pub(super) fn new(work: &[f64], after: Vec<Option<usize>>) -> Schedule {
        let mut way = work.to_vec();
        for (mut run, own) in work.iter().enumerate() {
            let mut sum = *own;
            // There is no circle, but the number of steps is bounded in any case.
            for _ in 0..after.len() {
                let Some(before) = after[run] else { break };
                sum += work[before];
                way[before] = way[before].max(sum);
                run = before;
            }
        }
        let mut order: Vec<usize> = (0..work.len()).collect();
        order.sort_by(|a, b| way[*b].total_cmp(&way[*a]));
        Schedule { state: vec![State::Waiting; work.len()], after, order, begun: 0 }
    }

    /// The next action of a thread; a run that is returned counts as running.
    pub(super) fn next(&mut self) -> Next {
        let mut left = false;
        while self.order.get(self.begun).is_some_and(|run| self.state[*run] != State::Waiting) {
            self.begun += 1;
        }
        for k in self.begun..self.order.len() {
            let run = self.order[k];
            if self.state[run] != State::Waiting {
                continue;
            }
            left = true;
            match self.after[run].map(|before| self.state[before]) {
                None | Some(State::Over { finished: true }) => {
                    self.state[run] = State::Running;
                    return Next::Run(run);
                }
                Some(State::Over { finished: false }) => {
                    self.state[run] = State::Running;
                    return Next::GiveUp(run);
                }
                Some(State::Waiting | State::Running) => {}
            }
        }
        if left { Next::Wait } else { Next::Nothing }
    }

    /// A run ended.
    pub(super) fn over(&mut self, run: usize, finished: bool) {
        self.state[run] = State::Over { finished };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_longest_way_begins_first_and_a_run_waits_for_its_sample() {
        // A sample of work 1 with a test of work 5, and single runs of work 4 and 2.
        let mut schedule = Schedule::new(&[2.0, 5.0, 4.0, 1.0], vec![None, Some(3), None, None]);
        assert_eq!(schedule.next(), Next::Run(3));
        assert_eq!(schedule.next(), Next::Run(2));
        assert_eq!(schedule.next(), Next::Run(0));
        assert_eq!(schedule.next(), Next::Wait);
        schedule.over(0, true);
        assert_eq!(schedule.next(), Next::Wait);
        schedule.over(3, true);
        assert_eq!(schedule.next(), Next::Run(1));
        assert_eq!(schedule.next(), Next::Nothing);
    }

    #[test]
    fn runs_of_equal_work_begin_in_their_order() {
        let mut schedule = Schedule::new(&[1.0; 3], vec![None; 3]);
        let all: Vec<Next> = (0..4).map(|_| schedule.next()).collect();
        assert_eq!(all, [Next::Run(0), Next::Run(1), Next::Run(2), Next::Nothing]);
    }

    #[test]
    fn what_waits_for_a_failed_run_is_given_up() {
        let mut schedule = Schedule::new(&[1.0; 3], vec![None, Some(0), Some(1)]);
        assert_eq!(schedule.next(), Next::Run(0));
        schedule.over(0, false);
        assert_eq!(schedule.next(), Next::GiveUp(1));
        schedule.over(1, false);
        assert_eq!(schedule.next(), Next::GiveUp(2));
        schedule.over(2, false);
        assert_eq!(schedule.next(), Next::Nothing);
    }
}
