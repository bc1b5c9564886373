//! Search for the procedure of compaction that meets a target solid fraction.
//!
//! All procedures lie on one line, from those of the densest to those of the loosest samples, with a position x:
//!
//! - `-1 <= x < 0`: compaction without friction, then `-20 x` strain cycles ([`MOST_CYCLES`] at the dense end);
//! - `0 <= x <= mu`: compaction with the friction x, up to the friction mu of the grains;
//! - `mu < x <= mu + 2`: compaction with the friction of the grains at a mean stress that is smaller than the target by the factor
//!   `10^(x - mu)`; the relaxation brings the sample to the target. More friction than that of the grains makes no looser sample,
//!   since the structure that it supports collapses at the relaxation.
//!
//! The solid fraction decreases along this line. If the preparation prescribes the cycles or the stress of the compaction, the part of
//! the line that varies them is not used.

use serde::{Deserialize, Serialize};

use super::Trial;
use crate::config::Preparation;

/// Number of strain cycles at the dense end of the line.
const MOST_CYCLES: f64 = 20.0;
/// Decades of the mean stress at the loose end.
const MOST_DECADES: f64 = 2.0;

/// How a trial compacts the grains.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Procedure {
    /// Coefficient of friction.
    pub friction: f64,
    /// Mean stress, Pa.
    pub mean_stress: f64,
    /// Number of cycles of axial strain.
    pub cycles: u64,
}

impl Procedure {
    /// The trial of this procedure, without a result.
    pub(super) fn trial(self, position: f64) -> Trial {
        let Procedure { friction, mean_stress, cycles } = self;
        Trial { position, friction, mean_stress, cycles, solid_fraction: f64::NAN }
    }
}

/// The procedures that a search may choose from.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<'a> {
    preparation: &'a Preparation,
    /// Friction of the grains.
    friction: f64,
    /// The ends of the line.
    ends: [f64; 2],
}

impl<'a> Line<'a> {
    /// For a preparation of grains with this friction.
    pub(super) fn new(preparation: &'a Preparation, friction: f64) -> Line<'a> {
        let dense = if preparation.cycles == 0 { -1.0 } else { 0.0 };
        let loose = if preparation.compaction_stress.is_none() { friction + MOST_DECADES } else { friction };
        Line { preparation, friction, ends: [dense, loose] }
    }

    /// The procedure at a position.
    pub(super) fn procedure(&self, x: f64) -> Procedure {
        let p = self.preparation;
        let cycles = if x < 0.0 { (-MOST_CYCLES * x).ceil() as u64 } else { p.cycles };
        let stress = p.compaction_stress.unwrap_or(p.mean_stress);
        let decades = (x - self.friction).max(0.0);
        let mean_stress = if decades > 0.0 { stress * libm::pow(10.0, -decades) } else { stress };
        Procedure { friction: x.clamp(0.0, self.friction), mean_stress, cycles }
    }

    /// The position of the next trial: the first from the usual behaviour of spheres, the following by a secant through the two
    /// nearest trials.
    pub(super) fn next(&self, trials: &[Trial], target: f64) -> f64 {
        let table = self.usual();
        let usual = |x: f64| interpolate(&table.map(|(x, s)| (s, x)), x);
        let next = match trials {
            [] => usual(target),
            // The usual curve, shifted to pass through the first trial.
            [only] => usual(target - (only.solid_fraction - interpolate(&table, only.position))),
            _ => {
                let next = secant(trials, target, trials.len() > SECANTS);
                // A step of limited size may return to where it came from; the target lies between trials on both sides of it.
                if is_tried(trials, next) { secant(trials, target, true) } else { next }
            }
        };
        next.clamp(self.ends[0], self.ends[1])
    }

    /// Usual solid fractions of equal spheres along the line.
    fn usual(&self) -> [(f64, f64); 8] {
        const BY_FRICTION: [(f64, f64); 6] =
            [(0.0, 0.633), (0.06, 0.613), (0.1, 0.605), (0.2, 0.588), (0.3, 0.578), (1.0, 0.55)];
        let own = self.friction;
        let at_own = interpolate(&BY_FRICTION, own);
        // Points beyond the friction of the grains move to it; they are then of no effect.
        let [a, b, c, d, e, f] = BY_FRICTION.map(|(x, s)| if x < own { (x, s) } else { (own, at_own) });
        [(-1.0, 0.638), a, b, c, d, e, f, (own + MOST_DECADES, at_own - 0.012)]
    }
}

/// Number of trials after which the search interpolates between trials on both sides of the target: a secant through two trials
/// that are close together would follow their scatter.
const SECANTS: usize = 3;

fn secant(trials: &[Trial], target: f64, between: bool) -> f64 {
    let mut near: Vec<&Trial> = trials.iter().collect();
    near.sort_by(|a, b| (a.solid_fraction - target).abs().total_cmp(&(b.solid_fraction - target).abs()));
    let (a, mut b) = (near[0], near[1]);
    if between {
        let other_side = |t: &&&Trial| (t.solid_fraction < target) != (a.solid_fraction < target);
        b = near.iter().find(other_side).copied().unwrap_or(b);
    }
    let slope = (b.position - a.position) / (b.solid_fraction - a.solid_fraction);
    let step = slope * (target - a.solid_fraction);
    let bound = 0.1 + 0.5 * a.position.abs();
    let step = if step.is_finite() { step.clamp(-bound, bound) } else { 0.01 };
    a.position + step
}

/// True if the search returned to a procedure that it has already tried (an end was reached).
pub(super) fn repeats(trials: &[Trial]) -> bool {
    trials.split_last().is_some_and(|(last, before)| is_tried(before, last.position))
}

pub(super) fn is_tried(trials: &[Trial], position: f64) -> bool {
    trials.iter().any(|trial| (trial.position - position).abs() < 1e-6)
}

/// The position of the densest trial that is looser than the target.
pub(super) fn looser(trials: &[Trial], target: f64) -> Option<f64> {
    let looser = trials.iter().filter(|trial| trial.solid_fraction < target);
    looser.max_by(|a, b| a.solid_fraction.total_cmp(&b.solid_fraction)).map(|trial| trial.position)
}

/// The position of a trial that came closer to the target than the last one.
pub(super) fn closer(trials: &[Trial], target: f64) -> Option<f64> {
    let distance = |trial: &Trial| (trial.solid_fraction - target).abs();
    let best = trials.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)))?;
    (distance(best) < distance(trials.last()?)).then_some(best.position)
}

/// Linear interpolation in a table sorted by its first column in ascending or descending order, constant beyond its ends.
fn interpolate(table: &[(f64, f64)], x: f64) -> f64 {
    let (first, last) = (table[0], table[table.len() - 1]);
    let rising = last.0 > first.0;
    if (x <= first.0) == rising {
        return first.1;
    }
    if (x >= last.0) == rising {
        return last.1;
    }
    table
        .windows(2)
        .find(|w| (x - w[0].0) * (x - w[1].0) <= 0.0 && w[0].0 != w[1].0)
        .map_or(last.1, |w| w[0].1 + (w[1].1 - w[0].1) * (x - w[0].0) / (w[1].0 - w[0].0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn interpolation_runs_both_ways() {
        let up = [(0.0, 1.0), (1.0, 3.0)];
        let down = [(1.0, 3.0), (0.0, 1.0)];
        for table in [&up, &down] {
            assert_eq!(interpolate(table, -1.0), 1.0);
            assert_eq!(interpolate(table, 0.5), 2.0);
            assert_eq!(interpolate(table, 2.0), 3.0);
        }
    }

    /// Tries procedures until the search ends; returns the best difference from the target, and the trials.
    fn search(line: &Line, solid_fraction_at: impl Fn(f64) -> f64, target: f64) -> (f64, Vec<Trial>) {
        let mut trials = Vec::new();
        for _ in 0..7 {
            let position = line.next(&trials, target);
            trials.push(Trial {
                solid_fraction: solid_fraction_at(position),
                ..line.procedure(position).trial(position)
            });
        }
        (trials.iter().map(|t| (t.solid_fraction - target).abs()).fold(1.0, f64::min), trials)
    }

    #[test]
    fn the_search_converges_on_a_smooth_curve_in_all_its_parts() {
        let preparation = Preparation::default();
        let line = Line::new(&preparation, 0.5);
        let solid_fraction_at =
            |x: f64| 0.63 - 0.02 * x.min(0.0) - 0.14 * x.clamp(0.0, 0.5) - 0.004 * (x - 0.5).max(0.0);
        for (target, within) in [(0.61, 1e-4), (0.645, 1e-3), (0.553, 1e-3)] {
            let (best, trials) = search(&line, solid_fraction_at, target);
            assert!(best < within, "{target}: {trials:?}");
        }
    }

    fn trial(position: f64, solid_fraction: f64) -> Trial {
        let preparation = Preparation::default();
        Trial { solid_fraction, ..Line::new(&preparation, 0.4).procedure(position).trial(position) }
    }

    /// A curve that falls steeply beyond its second trial: the secant through the nearest two trials, with its bounded step,
    /// leads back to the third.
    #[test]
    fn a_search_that_returns_to_a_trial_goes_on_between_those_on_both_sides() {
        let preparation = Preparation::default();
        let line = Line::new(&preparation, 0.4);
        let target = 0.6468;
        let mut trials = vec![trial(-0.3, 0.6619), trial(0.03, 0.6529)];
        trials.push(trial(line.next(&trials, target), 0.6255));
        assert!((trials[2].position - 0.145).abs() < 1e-12, "{trials:?}");
        let next = line.next(&trials, target);
        assert!(0.04 < next && next < 0.07, "{next}");
    }

    #[test]
    fn the_closest_trial_is_found_if_the_last_is_not_it() {
        let trials = [trial(0.1, 0.62), trial(0.2, 0.60), trial(0.3, 0.58)];
        assert_eq!(closer(&trials, 0.604), Some(0.2));
        assert_eq!((closer(&trials, 0.57), closer(&[], 0.6)), (None, None));
    }

    #[test]
    fn the_ends_are_the_densest_and_the_loosest_procedure() {
        let preparation = Preparation::default().with(|p| p.mean_stress = 100e3);
        let line = Line::new(&preparation, 0.5);
        let dense = line.procedure(-1.0);
        assert_eq!((dense.friction, dense.mean_stress, dense.cycles), (0.0, 100e3, 20));
        let loose = line.procedure(2.5);
        assert_eq!((loose.friction, loose.mean_stress.round(), loose.cycles), (0.5, 1000.0, 0));
        // What a preparation prescribes is not varied.
        let fixed = preparation.with(|p| (p.cycles, p.compaction_stress) = (3, Some(2e3)));
        let line = Line::new(&fixed, 0.5);
        for target in [0.3, 0.8] {
            let found = line.procedure(line.next(&[], target));
            assert_eq!((found.mean_stress, found.cycles), (2e3, 3));
        }
    }
}
