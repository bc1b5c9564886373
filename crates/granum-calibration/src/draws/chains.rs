//! Draws from a posterior by several chains that learn from each other's past: differential evolution with an archive and snooker
//! steps, without gradients.
//!
//! A chain proposes a step along the difference of two earlier states of all chains, so that steps have the size and the direction of the
//! posterior without being told; one in ten steps goes along the line through an earlier state (snooker), and one in ten has the full
//! length of a difference, from one mode to another. Often only some of the parameters move. Between two extensions of the archive the
//! chains are independent of each other, so that the result depends on neither threads nor machine.
//!
//! Source: ter Braak, Vrugt, Differential Evolution Markov Chain with snooker updater and fewer chains, Statistics and Computing 18
//! (2008), 435 to 446; moves of some of the parameters: Vrugt and others, International Journal of Nonlinear Sciences and Numerical
//! Simulation 10 (2009), 273 to 290.

use granum_core::observer::{Flow, Observer, Progress};
use granum_core::parallel;
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use crate::draws::diagnostics::Agreement;
use crate::draws::random::{index, standard_normal, stream, unit};
use crate::error::{CalibrationError, Result};

/// Generations between two extensions of the archive.
const BLOCK: usize = 20;
/// A state of each chain goes into the archive every so many generations.
const ARCHIVED: usize = 10;
/// Share of snooker steps.
const SNOOKER: f64 = 0.1;
/// Share of steps with the full length of a difference.
const FULL: f64 = 0.1;

/// The logarithm of a density over shares of priors: over the unit cube, in which the prior is uniform.
pub trait LogDensity: Sync {
    /// The names of the parameters.
    fn names(&self) -> &[String];
    /// The logarithm of the likelihood at a point of the unit cube, up to a constant; minus infinity where it is zero.
    fn log_density(&self, shares: &[f64]) -> f64;
}

/// How draws are made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct ChainOptions {
    /// Number of chains (4).
    pub chains: usize,
    /// Most draws of a chain, those included that are discarded (100,000).
    pub most_draws: usize,
    /// Largest R-hat that is accepted (1.01).
    pub most_r_hat: f64,
    /// Smallest effective sample size, of bulk and tails of every parameter, that is accepted (400).
    pub least_effective: f64,
    /// Seed.
    pub seed: u64,
    /// Threads; 0: as many as the machine has. The draws do not depend on them.
    pub threads: usize,
}

impl Default for ChainOptions {
    fn default() -> Self {
        ChainOptions {
            chains: 4,
            most_draws: 100_000,
            most_r_hat: 1.01,
            least_effective: 400.0,
            seed: 1,
            threads: 0,
        }
    }
}

/// What the chains drew once they agreed: the last half of all draws.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Draws {
    /// The names of the parameters.
    pub names: Vec<String>,
    /// For each parameter and chain, the shares of the prior that were drawn.
    pub shares: Vec<Vec<Vec<f64>>>,
    /// For each chain, the logarithms of the likelihood.
    pub log_densities: Vec<Vec<f64>>,
    /// For each parameter, how well the chains agree.
    pub agreement: Vec<Agreement>,
    /// Share of the proposed steps that were taken.
    pub accepted: f64,
    /// Draws of each chain that were discarded at the start.
    pub discarded: usize,
}

impl Draws {
    /// The points of all chains, one after another.
    pub fn points(&self) -> Vec<Vec<f64>> {
        let chains = self.log_densities.len();
        let draws = self.log_densities.first().map_or(0, Vec::len);
        let point =
            |chain: usize, draw: usize| self.shares.iter().map(|shares| shares[chain][draw]).collect();
        (0..chains)
            .flat_map(|chain| (0..draws).map(move |draw| (chain, draw)))
            .map(|(c, d)| point(c, d))
            .collect()
    }
}

/// A chain: its states and their logarithmic densities.
#[derive(Clone)]
struct Chain {
    random: ChaCha8Rng,
    point: Vec<f64>,
    log_density: f64,
    points: Vec<Vec<f64>>,
    log_densities: Vec<f64>,
    accepted: usize,
}

/// Draws from the posterior until the chains agree.
///
/// # Errors
/// If they do not agree after the most draws that are allowed, if the density is zero wherever they could begin, or if the observer
/// stops them.
pub fn draw(density: &dyn LogDensity, options: &ChainOptions, observer: &mut dyn Observer) -> Result<Draws> {
    let dimension = density.names().len();
    if dimension == 0 || options.chains < 2 {
        return Err(CalibrationError::Input("draws need at least one free parameter and two chains".into()));
    }
    let mut archive = initial_points(dimension, options);
    let mut chains = begin(density, &archive, options)?;
    let mut check_at = 1000.min(options.most_draws);
    loop {
        let done = chains[0].points.len();
        if done >= check_at {
            let kept = kept(&chains);
            let agreement = agreements(&kept);
            let (worst, agrees) = judge(&agreement, options);
            let all = Progress::new("inference", "draws", done as u64)
                .out_of(options.most_draws as u64)
                .with("R-hat", agreement[worst].r_hat, "")
                .with("effective draws", agreement[worst].effective(), "");
            if observer.progress(&all) == Flow::Stop {
                return Err(CalibrationError::Stopped);
            }
            if agrees {
                return Ok(drawn(density, &chains, kept, agreement));
            }
            if done >= options.most_draws {
                return Err(CalibrationError::NotConverged {
                    parameter: density.names()[worst].clone(),
                    draws: done,
                    r_hat: agreement[worst].r_hat,
                    most_r_hat: options.most_r_hat,
                    effective: agreement[worst].effective(),
                    least_effective: options.least_effective,
                });
            }
            check_at = (done + done / 2).min(options.most_draws);
        }
        let block = BLOCK.min(options.most_draws - done).max(1);
        chains = parallel::map(chains.len(), options.threads, |k| {
            let mut chain = chains[k].without_past();
            (0..block).for_each(|_| chain.step(density, &archive));
            Ok::<_, CalibrationError>(chain)
        })?
        .into_iter()
        .zip(chains)
        .map(|(block, before)| block.with_past(before))
        .collect();
        for chain in &chains {
            archive.extend(chain.points[done..].iter().skip(ARCHIVED - 1).step_by(ARCHIVED).cloned());
        }
    }
}

/// Points that fill the unit cube evenly, from which the chains begin and learn first.
fn initial_points(dimension: usize, options: &ChainOptions) -> Vec<Vec<f64>> {
    let mut random = stream(options.seed, 0);
    let count = (10 * dimension).max(2 * options.chains);
    (0..count).map(|_| (0..dimension).map(|_| unit(&mut random)).collect()).collect()
}

/// Each chain begins at the best of its share of the initial points.
fn begin(density: &dyn LogDensity, points: &[Vec<f64>], options: &ChainOptions) -> Result<Vec<Chain>> {
    let densities = parallel::map(points.len(), options.threads, |k| {
        let value = density.log_density(&points[k]);
        if value.is_nan() {
            let message =
                format!("the likelihood at the shares {:?} of the priors is not a number", points[k]);
            return Err(CalibrationError::Input(message));
        }
        Ok(value)
    })?;
    let first = |chain: usize| {
        let own = (0..points.len()).filter(|k| k % options.chains == chain);
        own.max_by(|a, b| densities[*a].total_cmp(&densities[*b])).unwrap_or(0)
    };
    let chain = |k: usize| {
        let at = first(k);
        if densities[at] == f64::NEG_INFINITY {
            let message = "the likelihood is zero at every point from which the chains could begin; widen the errors or the priors";
            return Err(CalibrationError::Input(message.into()));
        }
        Ok(Chain {
            random: stream(options.seed, k as u64 + 1),
            point: points[at].clone(),
            log_density: densities[at],
            points: Vec::new(),
            log_densities: Vec::new(),
            accepted: 0,
        })
    };
    (0..options.chains).map(chain).collect()
}

impl Chain {
    /// This chain in its present state, without its past.
    fn without_past(&self) -> Chain {
        Chain {
            random: self.random.clone(),
            point: self.point.clone(),
            log_density: self.log_density,
            points: Vec::new(),
            log_densities: Vec::new(),
            accepted: self.accepted,
        }
    }

    /// This chain, continued from the state of another to which its past belongs.
    fn with_past(mut self, before: Chain) -> Chain {
        let (points, log_densities) = (before.points, before.log_densities);
        self.points.splice(..0, points);
        self.log_densities.splice(..0, log_densities);
        self
    }

    fn step(&mut self, density: &dyn LogDensity, archive: &[Vec<f64>]) {
        let snooker = unit(&mut self.random) < SNOOKER;
        let (proposed, factor) =
            if snooker { self.along_a_line(archive) } else { (self.along_a_difference(archive), 0.0) };
        let inside = proposed.iter().all(|x| (0.0..=1.0).contains(x));
        let limit = libm::log(unit(&mut self.random));
        if inside {
            let found = density.log_density(&proposed);
            if found - self.log_density + factor > limit {
                (self.point, self.log_density) = (proposed, found);
                self.accepted += 1;
            }
        }
        self.points.push(self.point.clone());
        self.log_densities.push(self.log_density);
    }

    /// A step of some of the parameters along the difference of two states of the archive, reflected at the faces of the cube.
    fn along_a_difference(&mut self, archive: &[Vec<f64>]) -> Vec<f64> {
        let random = &mut self.random;
        let dimension = self.point.len();
        let [a, b] = two_of(random, archive.len());
        let share = [1.0 / 3.0, 2.0 / 3.0, 1.0][index(random, 3)];
        let mut moves: Vec<bool> = (0..dimension).map(|_| unit(random) < share).collect();
        if !moves.contains(&true) {
            moves[index(random, dimension)] = true;
        }
        let moved = moves.iter().filter(|moves| **moves).count() as f64;
        let length =
            if unit(random) < FULL { 1.0 } else { 2.38 / (2.0 * moved).sqrt() * (0.9 + 0.2 * unit(random)) };
        let mut next = self.point.clone();
        for k in (0..dimension).filter(|k| moves[*k]) {
            let step = length * (archive[a][k] - archive[b][k]) + 1e-4 * standard_normal(random);
            next[k] = reflected(next[k] + step);
        }
        next
    }

    /// A step along the line through this state and one of the archive, by the difference of two others projected onto it, and the
    /// logarithm of the factor of its acceptance.
    fn along_a_line(&mut self, archive: &[Vec<f64>]) -> (Vec<f64>, f64) {
        let random = &mut self.random;
        let through = &archive[index(random, archive.len())];
        let [a, b] = two_of(random, archive.len());
        let line: Vec<f64> = self.point.iter().zip(through).map(|(x, z)| x - z).collect();
        let squared: f64 = line.iter().map(|x| x * x).sum();
        if squared < 1e-30 {
            return (self.point.clone(), 0.0);
        }
        let apart: f64 = (0..line.len()).map(|k| (archive[a][k] - archive[b][k]) * line[k]).sum();
        let length = (1.2 + unit(random)) * apart / squared;
        let next = self.point.iter().zip(&line).map(|(x, step)| x + length * step).collect();
        (next, (line.len() as f64 - 1.0) * libm::log((1.0 + length).abs()))
    }
}

/// Two different places below `count`, which is at least two.
fn two_of(random: &mut ChaCha8Rng, count: usize) -> [usize; 2] {
    let first = index(random, count);
    let second = index(random, count - 1);
    [first, if second >= first { second + 1 } else { second }]
}

/// A coordinate reflected at 0 and at 1 until it lies between them.
fn reflected(x: f64) -> f64 {
    let within = x.rem_euclid(2.0);
    if within > 1.0 { 2.0 - within } else { within }
}

/// The last half of the draws, for each parameter and chain.
fn kept(chains: &[Chain]) -> Vec<Vec<Vec<f64>>> {
    let half = chains[0].points.len() / 2;
    let of_chain = |chain: &Chain, k: usize| chain.points[half..].iter().map(|point| point[k]).collect();
    (0..chains[0].point.len()).map(|k| chains.iter().map(|chain| of_chain(chain, k)).collect()).collect()
}

fn agreements(kept: &[Vec<Vec<f64>>]) -> Vec<Agreement> {
    let none = Agreement { r_hat: f64::INFINITY, bulk: 0.0, tail: 0.0 };
    kept.iter().map(|chains| Agreement::new(chains).unwrap_or(none)).collect()
}

/// The parameter whose chains agree least, and whether all agree.
fn judge(agreement: &[Agreement], options: &ChainOptions) -> (usize, bool) {
    let fails = |a: &Agreement| !(a.r_hat <= options.most_r_hat && a.effective() >= options.least_effective);
    let badness = |a: &Agreement| {
        ((a.r_hat - 1.0) / (options.most_r_hat - 1.0))
            .max(options.least_effective / a.effective().max(1e-300))
    };
    let worst = (0..agreement.len())
        .max_by(|a, b| badness(&agreement[*a]).total_cmp(&badness(&agreement[*b])))
        .unwrap_or(0);
    (worst, !agreement.iter().any(fails))
}

fn drawn(
    density: &dyn LogDensity,
    chains: &[Chain],
    shares: Vec<Vec<Vec<f64>>>,
    agreement: Vec<Agreement>,
) -> Draws {
    let length = chains[0].points.len();
    let accepted: usize = chains.iter().map(|chain| chain.accepted).sum();
    Draws {
        names: density.names().to_vec(),
        shares,
        log_densities: chains.iter().map(|chain| chain.log_densities[length / 2..].to_vec()).collect(),
        agreement,
        accepted: accepted as f64 / (length * chains.len()) as f64,
        discarded: length / 2,
    }
}

#[cfg(test)]
mod tests {
    use granum_core::observer::NoObserver;

    use super::*;

    /// Densities of which everything is known.
    struct Known {
        names: Vec<String>,
        log_density: fn(&[f64]) -> f64,
    }

    impl LogDensity for Known {
        fn names(&self) -> &[String] {
            &self.names
        }
        fn log_density(&self, shares: &[f64]) -> f64 {
            (self.log_density)(shares)
        }
    }

    fn known(dimension: usize, log_density: fn(&[f64]) -> f64) -> Known {
        Known { names: (0..dimension).map(|k| format!("x{k}")).collect(), log_density }
    }

    fn moments(draws: &Draws, k: usize) -> [f64; 2] {
        let values: Vec<f64> = draws.shares[k].iter().flatten().copied().collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let square = values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len() as f64;
        [mean, square.sqrt()]
    }

    /// A normal distribution in a narrow valley: deviations 0.05 each, correlation 0.99.
    #[test]
    fn a_narrow_valley_is_drawn_as_it_is() {
        let valley = known(3, |x| {
            let [a, b] = [(x[0] - 0.4) / 0.05, (x[1] - 0.6) / 0.05];
            -0.5 * (a * a - 2.0 * 0.99 * a * b + b * b) / (1.0 - 0.99 * 0.99)
        });
        let options = ChainOptions { least_effective: 800.0, ..ChainOptions::default() };
        let draws = draw(&valley, &options, &mut NoObserver).unwrap();
        for (k, [mean, deviation]) in [[0.4, 0.05], [0.6, 0.05], [0.5, 0.288_675]].into_iter().enumerate() {
            let [found_mean, found_deviation] = moments(&draws, k);
            assert!((found_mean - mean).abs() < 0.12 * deviation, "{k}: {found_mean}");
            assert!((found_deviation / deviation - 1.0).abs() < 0.12, "{k}: {found_deviation}");
        }
        assert!(draws.accepted > 0.05 && draws.points().len() == 4 * draws.log_densities[0].len());
        // Any number of threads draws the same.
        let again = draw(&valley, &ChainOptions { threads: 1, ..options }, &mut NoObserver).unwrap();
        assert_eq!(again, draws);
    }

    /// Two modes with shares of one to three; a bound cuts a distribution off.
    #[test]
    fn modes_and_bounds_have_their_shares() {
        let modes = known(2, |x| {
            let peak = |at: f64| (-0.5 * ((x[0] - at) / 0.04).powi(2)).exp();
            (peak(0.2) + 3.0 * peak(0.8)).max(1e-300).ln() - x[1] / 0.2
        });
        let options = ChainOptions { least_effective: 1000.0, ..ChainOptions::default() };
        let draws = draw(&modes, &options, &mut NoObserver).unwrap();
        let points = draws.points();
        let right = points.iter().filter(|point| point[0] > 0.5).count() as f64 / points.len() as f64;
        assert!((right - 0.75).abs() < 0.05, "{right}");
        // The mean of an exponential distribution of length 0.2, cut off at 1.
        let mean = 0.2 - 1.0 / ((1.0f64 / 0.2).exp() - 1.0);
        assert!((moments(&draws, 1)[0] - mean).abs() < 0.02, "{}", moments(&draws, 1)[0]);
    }

    #[test]
    fn what_does_not_converge_is_an_error() {
        // Two modes so far apart and so narrow that no step finds the way.
        let far = known(6, |x| {
            let peak = |at: f64| -> f64 { x.iter().map(|x| -0.5 * ((x - at) / 0.002).powi(2)).sum() };
            peak(0.1).max(peak(0.9) + 0.1)
        });
        let options = ChainOptions { most_draws: 2000, ..ChainOptions::default() };
        let message = draw(&far, &options, &mut NoObserver).unwrap_err().to_string();
        assert!(message.contains("do not agree after 2000 draws") && message.contains("R-hat"), "{message}");
        let nowhere = known(1, |_| f64::NEG_INFINITY);
        assert!(
            draw(&nowhere, &options, &mut NoObserver)
                .unwrap_err()
                .to_string()
                .contains("zero at every point")
        );
        let wrong = known(1, |_| f64::NAN);
        assert!(draw(&wrong, &options, &mut NoObserver).unwrap_err().to_string().contains("not a number"));
    }
}
