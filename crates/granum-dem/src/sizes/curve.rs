//! A sieve curve as measured in a laboratory: the share of the mass that is finer than a diameter.

use libm::{cbrt, log};

use super::{Grains, SizeDescription, SizeDistribution, SizeError, Sizes};

/// Points (diameter, share of the mass that is finer). Between two points the mass is uniform in the logarithm of the diameter, as
/// on the paper on which such curves are drawn. An interval from a to b with the mass share w has a number of grains proportional
/// to `w (a^-3 - b^-3) / (3 ln(b/a))`, and its quantile at the share u of its grains is `(a^-3 - u (a^-3 - b^-3))^(-1/3)`.
/// Grains finer than the first point are left out.
pub struct SieveCurve;

/// Part of a curve between two points, within the cuts.
#[derive(Clone, Copy)]
struct Interval {
    /// Ends, m.
    ends: [f64; 2],
    /// Share of the mass of the whole curve.
    mass: f64,
    /// Grains, in an arbitrary unit.
    number: f64,
}

/// `d^-3` relative to a length near the diameters, so that the powers stay near one.
fn inverse_cube(diameter: f64, length: f64) -> f64 {
    let x = length / diameter;
    x * x * x
}

fn intervals(sizes: &Sizes) -> Vec<Interval> {
    let low = sizes.smallest.unwrap_or(0.0);
    let high = sizes.largest.unwrap_or(f64::INFINITY);
    let length = sizes.curve.first().map_or(1.0, |point| point[0]);
    let pairs = sizes.curve.windows(2);
    let cut = pairs.filter_map(|pair| {
        let [[a, below_a], [b, below_b]] = [pair[0], pair[1]];
        let [from, to] = [a.max(low), b.min(high)];
        if from >= to || below_b <= below_a {
            return None;
        }
        let mass = (below_b - below_a) * log(to / from) / log(b / a);
        let cubes = inverse_cube(from, length) - inverse_cube(to, length);
        Some(Interval { ends: [from, to], mass, number: mass * cubes / (3.0 * log(to / from)) })
    });
    cut.collect()
}

/// Share of the mass outside the cuts.
pub(super) fn mass_left_out(sizes: &Sizes) -> f64 {
    1.0 - intervals(sizes).iter().map(|interval| interval.mass).sum::<f64>()
}

/// Refuses curves that are none.
///
/// # Errors
/// What is wrong and what would be right; `None` for the whole curve, otherwise the number of the point, from 0.
pub fn check_curve(curve: &[[f64; 2]]) -> Result<(), (Option<usize>, String)> {
    for (k, [diameter, finer]) in curve.iter().enumerate() {
        if !(diameter.is_finite() && *diameter > 0.0) {
            return Err((Some(k), format!("has the diameter {diameter} m; it must be positive")));
        }
        if !(0.0..=1.0).contains(finer) {
            return Err((Some(k), format!("has {} % finer; it must be from 0 % to 100 %", 100.0 * finer)));
        }
        let Some([before, less]) = k.checked_sub(1).map(|k| curve[k]) else { continue };
        if *diameter <= before || *finer < less {
            let message = "does not rise above the point before: diameters must rise, and the share that is finer must not fall";
            return Err((Some(k), message.into()));
        }
    }
    match curve {
        [] | [_] => {
            Err((None, "needs at least two points, each a diameter and the share that is finer".into()))
        }
        [.., [_, last]] if (last - 1.0).abs() > 1e-9 => {
            Err((None, format!("ends at {} % finer; the last point must have 100 %", 100.0 * last)))
        }
        _ => Ok(()),
    }
}

impl SizeDistribution for SieveCurve {
    fn description(&self) -> &'static SizeDescription {
        &SizeDescription {
            name: "sieve-curve",
            help: "the sieve curve of sieve_curve, by mass",
            parameters: &[],
            has_mean: false,
            can_be_cut: true,
        }
    }

    fn check(&self, grains: &Grains) -> Result<(), SizeError> {
        if grains.sizes.curve.is_empty() {
            let message = "= \"sieve-curve\" needs grains.sieve_curve: a CSV of diameters and per cent finer, or a list of points";
            return Err(SizeError::new("distribution", message));
        }
        check_curve(&grains.sizes.curve).map_err(|(point, why)| {
            let which = point.map_or_else(String::new, |k| format!("point {} ", k + 1));
            SizeError::new("sieve_curve", format!("{which}{why}"))
        })?;
        match intervals(&grains.sizes).is_empty() {
            false => Ok(()),
            true => Err(SizeError::new("smallest", "and grains.largest leave nothing of the sieve curve")),
        }
    }

    fn share_below(&self, grains: &Grains, diameter: f64) -> f64 {
        // The cuts are in the intervals already.
        let intervals = intervals(&grains.sizes);
        let length = grains.sizes.curve.first().map_or(1.0, |point| point[0]);
        let below = |interval: &Interval| {
            let [a, b] = interval.ends;
            let [from, to] = [a, b].map(|x| inverse_cube(x, length));
            let at = inverse_cube(diameter.clamp(a, b), length);
            interval.number * (from - at) / (from - to)
        };
        let all: f64 = intervals.iter().map(|interval| interval.number).sum();
        intervals.iter().map(below).sum::<f64>() / all
    }

    fn quantile(&self, grains: &Grains, share: f64) -> f64 {
        let intervals = intervals(&grains.sizes);
        let length = grains.sizes.curve.first().map_or(1.0, |point| point[0]);
        let all: f64 = intervals.iter().map(|interval| interval.number).sum();
        let mut left = share * all;
        for (k, interval) in intervals.iter().enumerate() {
            if left > interval.number && k + 1 < intervals.len() {
                left -= interval.number;
                continue;
            }
            let [a, b] = interval.ends;
            let [from, to] = [a, b].map(|x| inverse_cube(x, length));
            let inverse = from - (left / interval.number).clamp(0.0, 1.0) * (from - to);
            return (length / cbrt(inverse)).clamp(a, b);
        }
        f64::NAN
    }
}
