//! Whether chains agree: the rank-normalised R-hat and the effective sample size of bulk and tails.
//!
//! Source: Vehtari, Gelman, Simpson, Carpenter, Bürkner, Rank-normalization, folding, and localization: an improved R-hat for assessing
//! convergence of MCMC, Bayesian Analysis 16 (2021), 667 to 718. The numbers are those of ArviZ, to rounding.

use granum_nets::normal::quantile;
use serde::{Deserialize, Serialize};

/// How well the chains of one quantity agree.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Agreement {
    /// R-hat: the larger of that of the ranks and that of the ranks of distances from the median. 1 if the chains agree.
    pub r_hat: f64,
    /// Effective sample size of the bulk: independent draws that would tell the mean of the ranks as well.
    pub bulk: f64,
    /// Effective sample size of the tails: the smaller one for the quantiles of 5 and 95 %.
    pub tail: f64,
}

impl Agreement {
    /// The agreement of chains of equal length, each with at least four draws; `None` for less.
    pub fn new(chains: &[Vec<f64>]) -> Option<Agreement> {
        let length = chains.first()?.len();
        if length < 4 || chains.iter().any(|chain| chain.len() != length) {
            return None;
        }
        let halves = halves(chains);
        let ranked = normal_ranks(&halves);
        let all = sorted(chains.iter().flatten().copied().collect());
        let median = quantile_of_sorted(&all, 0.5);
        let folded: Vec<Vec<f64>> =
            halves.iter().map(|chain| chain.iter().map(|x| (x - median).abs()).collect()).collect();
        let below = |share: f64| -> Vec<Vec<f64>> {
            let limit = quantile_of_sorted(&all, share);
            halves.iter().map(|chain| chain.iter().map(|x| f64::from(*x <= limit)).collect()).collect()
        };
        Some(Agreement {
            r_hat: r_hat(&ranked).max(r_hat(&normal_ranks(&folded))),
            bulk: effective(&ranked),
            tail: effective(&below(0.05)).min(effective(&below(0.95))),
        })
    }

    /// The smaller effective sample size.
    pub fn effective(&self) -> f64 {
        self.bulk.min(self.tail)
    }
}

/// The value below which a share of sorted values lies, with linear interpolation between them; NaN without values.
pub fn quantile_of_sorted(sorted: &[f64], share: f64) -> f64 {
    let Some(last) = sorted.len().checked_sub(1) else { return f64::NAN };
    let place = share.clamp(0.0, 1.0) * last as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(last);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

fn sorted(mut values: Vec<f64>) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values
}

/// Each chain as two: its first and its last half, without the draw in the middle of an odd number.
fn halves(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let half = chains.first().map_or(0, |chain| chain.len() / 2);
    chains.iter().flat_map(|chain| [chain[..half].to_vec(), chain[chain.len() - half..].to_vec()]).collect()
}

/// Each value replaced by the normal quantile of its rank among all; equal values share their mean rank.
fn normal_ranks(chains: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let values: Vec<f64> = chains.iter().flatten().copied().collect();
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut scores = vec![0.0; values.len()];
    let mut first = 0;
    while first < order.len() {
        let mut end = first + 1;
        while end < order.len() && values[order[end]] == values[order[first]] {
            end += 1;
        }
        let rank = 0.5 * (first + 1 + end) as f64;
        let score = quantile((rank - 0.375) / (values.len() as f64 + 0.25));
        order[first..end].iter().for_each(|place| scores[*place] = score);
        first = end;
    }
    let mut scores = scores.into_iter();
    chains.iter().map(|chain| scores.by_ref().take(chain.len()).collect()).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The variance over one less than the number of values.
fn variance(values: &[f64]) -> f64 {
    let mean = mean(values);
    values.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / (values.len() as f64 - 1.0)
}

/// The classic R-hat of Gelman and Rubin.
fn r_hat(chains: &[Vec<f64>]) -> f64 {
    let n = chains[0].len() as f64;
    let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
    let within = mean(&chains.iter().map(|chain| variance(chain)).collect::<Vec<_>>());
    let between = n * variance(&means);
    if within > 0.0 { ((between / within + n - 1.0) / n).sqrt() } else { f64::INFINITY }
}

/// The effective sample size by Geyer's initial monotone sequence of autocorrelations.
fn effective(chains: &[Vec<f64>]) -> f64 {
    let n = chains[0].len();
    let total = (n * chains.len()) as f64;
    let means: Vec<f64> = chains.iter().map(|chain| mean(chain)).collect();
    let covariance = |lag: usize| -> f64 {
        let of_chain = |(chain, mean): (&Vec<f64>, &f64)| -> f64 {
            let pairs = chain.iter().zip(&chain[lag..]);
            pairs.map(|(a, b)| (a - mean) * (b - mean)).sum::<f64>() / n as f64
        };
        chains.iter().zip(&means).map(of_chain).sum::<f64>() / chains.len() as f64
    };
    let within = covariance(0) * n as f64 / (n as f64 - 1.0);
    let spread = within * (n as f64 - 1.0) / n as f64 + variance(&means);
    // Values that are all the same carry no information about their agreement, and count as independent, as in ArviZ.
    if spread <= 0.0 || spread.is_nan() {
        return total;
    }
    let correlation = |lag: usize| 1.0 - (within - covariance(lag)) / spread;
    let mut correlations = vec![1.0, correlation(1)];
    let mut lag = 1;
    let mut even = 1.0;
    let mut pair = 1.0 + correlations[1];
    while lag + 3 < n && pair > 0.0 {
        even = correlation(lag + 1);
        let odd = correlation(lag + 2);
        pair = even + odd;
        if pair >= 0.0 {
            correlations.extend([even, odd]);
        }
        lag += 2;
    }
    // The last pair counts by its first part alone.
    let rest = if even > 0.0 || pair >= 0.0 { even } else { 0.0 };
    correlations.truncate(lag - 1);
    let last = correlations.len();
    for k in (2..last.saturating_sub(1)).step_by(2) {
        let before = correlations[k - 2] + correlations[k - 1];
        if correlations[k] + correlations[k + 1] > before {
            (correlations[k], correlations[k + 1]) = (0.5 * before, 0.5 * before);
        }
    }
    let time = -1.0 + 2.0 * correlations.iter().sum::<f64>() + rest;
    total / time.max(1.0 / libm::log10(total))
}

#[cfg(test)]
mod tests {
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;

    use super::*;
    use crate::draws::random::standard_normal;

    /// Chains x' = r x + sqrt(1 - r^2) z, whose effective sample size is (1 - r) / (1 + r) of their draws.
    fn autoregressive(chains: usize, draws: usize, r: f64, apart: f64) -> Vec<Vec<f64>> {
        let chain = |k: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(k as u64 + 11);
            let mut x = standard_normal(&mut random);
            let mut next = || {
                x = r * x + (1.0 - r * r).sqrt() * standard_normal(&mut random);
                x + apart * k as f64
            };
            (0..draws).map(|_| next()).collect()
        };
        (0..chains).map(chain).collect()
    }

    #[test]
    fn the_effective_sample_of_chains_with_a_known_memory() {
        for r in [0.0, 0.5, 0.9, -0.5] {
            let found = Agreement::new(&autoregressive(4, 20_000, r, 0.0)).unwrap();
            let expected = 80_000.0 * (1.0 - r) / (1.0 + r);
            assert!((found.bulk / expected - 1.0).abs() < 0.12, "{r}: {found:?} {expected}");
            assert!(found.r_hat < 1.003, "{r}: {found:?}");
        }
    }

    #[test]
    fn chains_that_do_not_agree_are_seen() {
        assert!(Agreement::new(&autoregressive(4, 1000, 0.0, 0.5)).unwrap().r_hat > 1.1);
        // The same means but other spreads: only the folded ranks tell.
        let mut chains = autoregressive(4, 1000, 0.0, 0.0);
        chains[0].iter_mut().for_each(|x| *x *= 4.0);
        assert!(Agreement::new(&chains).unwrap().r_hat > 1.05);
        // A chain that drifts is seen by its halves.
        let drift: Vec<Vec<f64>> = autoregressive(4, 1000, 0.0, 0.0)
            .into_iter()
            .map(|chain| chain.into_iter().enumerate().map(|(k, x)| x + k as f64 / 500.0).collect())
            .collect();
        assert!(Agreement::new(&drift).unwrap().r_hat > 1.1);
        assert!(Agreement::new(&[vec![1.0, 2.0, 3.0]]).is_none());
    }

    /// Golden: ArviZ 0.23, `az.rhat`, `az.ess` with methods bulk and tail, of these two short chains.
    #[test]
    fn the_numbers_are_those_of_arviz() {
        let chain = |a: f64| -> Vec<f64> {
            (0..40).map(|k| libm::sin(a * f64::from(k * k)) + 0.02 * f64::from(k)).collect()
        };
        let found = Agreement::new(&[chain(0.7), chain(1.3)]).unwrap();
        let expected = [1.099_651_443_397_374, 22.372_177_265_824_373, 43.894_853_757_867_445];
        for (found, expected) in [found.r_hat, found.bulk, found.tail].into_iter().zip(expected) {
            assert!((found / expected - 1.0).abs() < 1e-9, "{found} {expected}");
        }
    }
}
