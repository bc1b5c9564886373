//! Search for the friction during compaction that meets a target solid fraction: with less friction the sample becomes
//! denser.

use super::Trial;

/// True if the search returned to a friction that it has already tried (a bound was reached).
pub(super) fn repeats(trials: &[Trial]) -> bool {
    let last = trials[trials.len() - 1].friction;
    trials[..trials.len() - 1].iter().any(|t| (t.friction - last).abs() < 1e-6)
}

/// The next friction to try: the first from the usual behaviour of monodisperse Hertz spheres, the following by a secant
/// through the two nearest trials.
pub(super) fn next_friction(trials: &[Trial], target: f64) -> f64 {
    const USUAL: [(f64, f64); 6] =
        [(0.0, 0.633), (0.06, 0.613), (0.1, 0.605), (0.2, 0.588), (0.3, 0.578), (1.0, 0.55)];
    let usual = |x: f64| interpolate(&USUAL.map(|(f, s)| (s, f)), x);
    match trials {
        [] => usual(target),
        [only] => {
            // The usual curve, shifted to pass through the first trial.
            let shift = only.solid_fraction - interpolate(&USUAL, only.friction);
            usual(target - shift)
        }
        _ => {
            let mut near: Vec<&Trial> = trials.iter().collect();
            near.sort_by(|a, b| {
                (a.solid_fraction - target).abs().total_cmp(&(b.solid_fraction - target).abs())
            });
            let (a, b) = (near[0], near[1]);
            let slope = (b.friction - a.friction) / (b.solid_fraction - a.solid_fraction);
            let step = slope * (target - a.solid_fraction);
            let bound = 0.1 + 0.5 * a.friction;
            let step = if step.is_finite() { step.clamp(-bound, bound) } else { 0.01 };
            (a.friction + step).clamp(0.0, 2.0)
        }
    }
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
        .find(|w| (x - w[0].0) * (x - w[1].0) <= 0.0)
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

    #[test]
    fn the_search_converges_on_a_smooth_curve() {
        let answer = |friction: f64| 0.63 - 0.3 * friction + 0.4 * friction * friction;
        let mut trials = Vec::new();
        for _ in 0..5 {
            let friction = next_friction(&trials, 0.61);
            trials.push(Trial { friction, solid_fraction: answer(friction) });
        }
        let best = trials.iter().map(|t| (t.solid_fraction - 0.61).abs()).fold(1.0, f64::min);
        assert!(best < 1e-4, "{trials:?}");
    }
}
