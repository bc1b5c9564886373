//! Gradient boosted regression trees (Friedman 2001).
//!
//! The prediction is the mean of the targets and a sum of trees. Each tree is fitted to what the sum before it leaves over, and enters with a
//! factor smaller than one, so that many trees share the work:
//!
//! ```text
//! y = mean + sum_t rate * tree_t(x)
//! ```
//!
//! A tree asks in every node whether one input exceeds a threshold, and gives the mean of the rows that reach its leaf, shrunk as if there were
//! `shrinkage` further rows with the value zero. The split of a node is the one that reduces the sum of squares most. Thresholds are
//! quantiles of the input over the rows ([`Bins`]), so that a split costs one pass over the rows of its node.

use serde::{Deserialize, Serialize};

/// Most intervals into which the values of an input are divided.
const MOST_BINS: usize = 64;

/// How trees are grown.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct Growth {
    /// Most questions from the root of a tree to a leaf.
    pub depth: usize,
    /// Fewest rows of a leaf.
    pub least_rows: usize,
    /// Factor with which each tree enters.
    pub rate: f64,
    /// Number of further rows with the value zero in each leaf.
    pub shrinkage: f64,
}

/// A tree: its nodes from the root on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tree {
    /// For each node the input that it asks for; the number of inputs for a leaf.
    input: Vec<usize>,
    /// The threshold of a node, or the value of a leaf.
    value: Vec<f64>,
    /// The node for rows whose input does not exceed the threshold; the one after it is for the others.
    next: Vec<usize>,
}

impl Tree {
    /// Its value at a row of inputs.
    pub fn at(&self, row: &[f64]) -> f64 {
        let mut node = 0;
        while let Some(x) = row.get(self.input[node]) {
            node = self.next[node] + usize::from(*x > self.value[node]);
        }
        self.value[node]
    }

    /// Number of its nodes, the root first.
    pub fn nodes(&self) -> usize {
        self.input.len()
    }

    /// What a node asks for; `None` for a leaf.
    pub fn question(&self, node: usize) -> Option<Question> {
        let [input, next] = [self.input[node], self.next[node]];
        // The nodes after a node come after it, and a leaf has none.
        (next > node).then(|| Question { input, limit: self.value[node], next })
    }

    /// The value of a leaf, or the threshold of another node.
    pub fn value(&self, node: usize) -> f64 {
        self.value[node]
    }

    /// Most questions from the root to a leaf.
    pub fn depth(&self) -> usize {
        let mut depths = vec![0; self.nodes()];
        for node in 0..self.nodes() {
            let below = depths[node] + 1;
            if let Some(question) = self.question(node) {
                depths[question.next..question.next + 2].fill(below);
            }
        }
        depths.into_iter().max().unwrap_or(0)
    }

    /// True if it can be evaluated for so many inputs.
    pub fn is_sound(&self, inputs: usize) -> bool {
        let nodes = self.input.len();
        let node = |k: usize| {
            self.value[k].is_finite()
                && (self.input[k] == inputs
                    || (self.input[k] < inputs && self.next[k] > k && self.next[k] + 1 < nodes))
        };
        nodes > 0 && self.value.len() == nodes && self.next.len() == nodes && (0..nodes).all(node)
    }
}

/// The question of a node: whether an input exceeds a threshold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// The input.
    pub input: usize,
    /// The threshold.
    pub limit: f64,
    /// The node for rows whose input does not exceed it; the one after it is for the others.
    pub next: usize,
}

/// The inputs of rows, each as the number of the interval in which it is.
pub struct Bins {
    /// For each input the thresholds between its intervals.
    thresholds: Vec<Vec<f64>>,
    /// For each input the interval of each row.
    bins: Vec<Vec<u8>>,
}

impl Bins {
    /// The intervals of rows in row-major order with so many inputs: between neighbouring values, or between quantiles if there are more
    /// than 64 values.
    pub fn new(rows: &[f64], inputs: usize) -> Bins {
        let column = |k: usize| rows.iter().skip(k).step_by(inputs).copied();
        let thresholds: Vec<Vec<f64>> = (0..inputs).map(|k| thresholds(column(k).collect())).collect();
        let bin = |thresholds: &Vec<f64>, x: f64| thresholds.partition_point(|limit| *limit < x) as u8;
        let bins = thresholds.iter().enumerate().map(|(k, own)| column(k).map(|x| bin(own, x)).collect());
        Bins { bins: bins.collect(), thresholds }
    }

    /// The trees that are fitted to the targets of some rows, one after another. After each, `follow` is given the tree; the growth ends
    /// if it returns false.
    pub fn grow(
        &self,
        targets: &[f64],
        rows: &[usize],
        growth: &Growth,
        mut follow: impl FnMut(&Tree) -> bool,
    ) {
        let mut left = targets.to_vec();
        loop {
            let mut own = rows.to_vec();
            let tree = self.tree(&mut own, &mut left, growth);
            if !follow(&tree) {
                return;
            }
        }
    }

    /// The next tree, whose values are subtracted from what is left over.
    fn tree(&self, rows: &mut [usize], left: &mut [f64], growth: &Growth) -> Tree {
        let mut tree = Tree::default();
        let inputs = self.bins.len();
        let leaf = |tree: &mut Tree| {
            tree.input.push(inputs);
            tree.value.push(0.0);
            tree.next.push(0);
        };
        leaf(&mut tree);
        // Nodes that are still to be divided: their number, their rows as a range, and their depth.
        let mut open = vec![(0, 0, rows.len(), 0)];
        while let Some((node, from, to, depth)) = open.pop() {
            let own = &mut rows[from..to];
            let split = if depth < growth.depth { self.split(own, left, growth) } else { None };
            let Some(Split { input, bin }) = split else {
                let sum: f64 = own.iter().map(|row| left[*row]).sum();
                let value = growth.rate * sum / (own.len() as f64 + growth.shrinkage);
                tree.value[node] = value;
                own.iter().for_each(|row| left[*row] -= value);
                continue;
            };
            // The order of rows within a part is kept, so that sums do not depend on anything else.
            let (low, high): (Vec<usize>, Vec<usize>) =
                own.iter().partition(|row| self.bins[input][**row] <= bin);
            let middle = from + low.len();
            own[..low.len()].copy_from_slice(&low);
            own[low.len()..].copy_from_slice(&high);
            let next = tree.input.len();
            (tree.input[node], tree.value[node], tree.next[node]) =
                (input, self.thresholds[input][usize::from(bin)], next);
            leaf(&mut tree);
            leaf(&mut tree);
            open.push((next + 1, middle, to, depth + 1));
            open.push((next, from, middle, depth + 1));
        }
        tree
    }

    /// The split of a node that reduces the sum of squares most, the first of several; `None` if none does.
    fn split(&self, rows: &[usize], left: &[f64], growth: &Growth) -> Option<Split> {
        let least = growth.least_rows.max(1);
        if rows.len() < 2 * least {
            return None;
        }
        let all: f64 = rows.iter().map(|row| left[*row]).sum();
        let gain = |sum: f64, count: usize| sum * sum / (count as f64 + growth.shrinkage);
        let mut best: Option<(f64, Split)> = None;
        let unsplit = gain(all, rows.len());
        for (input, bins) in self.bins.iter().enumerate() {
            let (mut sums, mut counts) = ([0.0; MOST_BINS], [0usize; MOST_BINS]);
            for row in rows {
                let bin = usize::from(bins[*row]);
                sums[bin] += left[*row];
                counts[bin] += 1;
            }
            let (mut sum, mut count) = (0.0, 0);
            for bin in 0..self.thresholds[input].len() {
                sum += sums[bin];
                count += counts[bin];
                if count < least || rows.len() - count < least || counts[bin] == 0 {
                    continue;
                }
                let gained = gain(sum, count) + gain(all - sum, rows.len() - count) - unsplit;
                if gained > best.as_ref().map_or(1e-12 * unsplit.abs(), |(most, _)| *most) {
                    best = Some((gained, Split { input, bin: bin as u8 }));
                }
            }
        }
        best.map(|(_, split)| split)
    }
}

/// The rows up to a bin of an input go one way, the others another.
struct Split {
    input: usize,
    bin: u8,
}

/// The thresholds between the intervals of a column.
fn thresholds(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    let all = values.len();
    let mut distinct = values.clone();
    distinct.dedup();
    let between = |a: f64, b: f64| {
        let middle = 0.5 * a + 0.5 * b;
        // Between two neighbouring numbers there is no third.
        if middle < b { middle } else { a }
    };
    if distinct.len() <= MOST_BINS {
        return distinct.windows(2).map(|pair| between(pair[0], pair[1])).collect();
    }
    let mut limits: Vec<f64> = (1..MOST_BINS)
        .filter_map(|k| {
            let place = distinct.partition_point(|x| *x < values[k * all / MOST_BINS]);
            (place > 0).then(|| between(distinct[place - 1], distinct[place]))
        })
        .collect();
    limits.dedup();
    limits
}

#[cfg(test)]
mod tests {
    use super::*;

    const GROWTH: Growth = Growth { depth: 4, least_rows: 5, rate: 0.2, shrinkage: 0.0 };

    fn rows(count: u32) -> Vec<f64> {
        // Two inputs with low-discrepancy values between 0 and 1.
        (0..count)
            .flat_map(|k| [0.754_877_666_2, 0.569_840_291].map(|a| (f64::from(k) * a).fract()))
            .collect()
    }

    #[test]
    fn trees_learn_a_step_and_an_interaction() {
        let rows = rows(800);
        let law = |row: &[f64]| f64::from(u8::from(row[0] > 0.3)) + row[0] * row[1];
        let targets: Vec<f64> = rows.chunks(2).map(law).collect();
        let bins = Bins::new(&rows, 2);
        let mut trees = Vec::new();
        bins.grow(&targets, &(0..800).collect::<Vec<_>>(), &GROWTH, |tree| {
            trees.push(tree.clone());
            trees.len() < 80
        });
        assert!(trees.iter().all(|tree| tree.is_sound(2)));
        let at = |row: &[f64]| trees.iter().map(|tree| tree.at(row)).sum::<f64>();
        let square: f64 = rows.chunks(2).zip(&targets).map(|(row, y)| (at(row) - y).powi(2)).sum();
        // The step lies between two of the 63 thresholds: of the twelve rows between them some are on the wrong side.
        assert!((square / 800.0).sqrt() < 0.05, "{}", (square / 800.0).sqrt());
        for row in [[0.29, 0.5], [0.32, 0.5], [0.9, 0.1]] {
            assert!((at(&row) - law(&row)).abs() < 0.06, "{row:?} {} {}", at(&row), law(&row));
        }
    }

    /// The first tree of one question, by hand.
    #[test]
    fn a_stump_is_that_by_hand() {
        let (rows, targets) = ([0.0, 1.0, 2.0, 3.0], [-1.0, -1.0, 0.0, 2.0]);
        let growth = Growth { depth: 1, least_rows: 1, rate: 0.5, shrinkage: 0.0 };
        let mut first = None;
        Bins::new(&rows, 1).grow(&targets, &[0, 1, 2, 3], &growth, |tree| {
            first = Some(tree.clone());
            false
        });
        // The squares of the sums over the counts: 3 questions give 1 + 1/3, 2 + 2, 4/3 + 4.
        let tree = first.unwrap();
        assert_eq!((tree.value[0], tree.at(&[2.4]), tree.at(&[2.6])), (2.5, -1.0 / 3.0, 1.0));
        assert!(!Tree { next: vec![0; 3], ..tree.clone() }.is_sound(1));
        assert!(!Tree { value: vec![f64::NAN; 3], ..tree }.is_sound(1));
    }

    #[test]
    fn many_values_are_divided_at_quantiles() {
        let limits = thresholds((0..1000).map(f64::from).collect());
        assert_eq!((limits.len(), limits[0]), (63, 14.5));
        assert_eq!(thresholds(vec![2.0, 1.0, 2.0]), [1.5]);
        assert!(thresholds(vec![3.0; 9]).is_empty());
        // Most values are the same.
        assert!(thresholds((0..1000).map(|k| f64::from(k.max(900))).collect()).len() < 10);
    }
}
