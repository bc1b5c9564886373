//! Fewer states of a data set.

use crate::dataset::Dataset;
use crate::methods::networks::training_rows::every_nth;

/// At most `most` of the states of a data set. If there are too many, every n-th state of each run is taken, with a different
/// first state in each run, because neighbouring states contain nearly the same information.
pub fn thinned(dataset: &Dataset, most: usize) -> Dataset {
    let lengths: Vec<usize> = dataset.runs().iter().map(|run| run.rows()).collect();
    if lengths.iter().sum::<usize>() <= most {
        return dataset.clone();
    }
    let kept = every_nth(&lengths, most);
    let number = |name: &str| dataset.runs().iter().position(|run| run.name() == name).unwrap_or(0);
    dataset.select(|run, row| kept.binary_search(&(number(run.name()), row)).is_ok())
}
