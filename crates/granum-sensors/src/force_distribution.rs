//! Distribution of the contact normal forces: moments, tail and histogram.
//!
//! `f = N/<N>`, with the mean over all contacts, tension negative. `<f^2>` is 1 for equal forces. In the range f > 1 an
//! exponential, `beta exp(-beta (f - 1))`, and a half-Gaussian, `exp(-f^2 / 2 s^2) / integral_1^inf`, are fitted by maximum
//! likelihood (Antony 2001 found the half-Gaussian under shear); the difference of their log-likelihoods per strong contact
//! shows which of them fits better.
//!
//! Every contact of two grains of several pieces counts; [`crate::pair_forces`] takes those of a pair together.
//!
//! Without contacts, or where `<N>` is not positive, f is undefined and every moment is 0.

use crate::numerics::{ln, mills_ratio};
use crate::ratio::mean;
use crate::{
    Bins, Histogram, Memory, Observation, Sensor, SensorColumn, SensorDescription, SensorParameter, Subject,
    Values,
};
use granum_core::Part;
use granum_core::quantity::Dimension;
use granum_dem::config::Recording;

/// The sensor.
pub struct ForceDistribution;

impl Sensor for ForceDistribution {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("force_distribution", "moments and tail of the distribution of f = N/<N>")
            .speaking_of(Subject::Contacts)
            .columns([
                SensorColumn::new("mean_normal_force", "N", "<N> over all contacts, tension negative"),
                SensorColumn::new("mean_square_force", "1", "<f^2>, f = N/<N>"),
                SensorColumn::new("tensile_fraction", "1", "contacts in tension over all contacts"),
                SensorColumn::new(
                    "exponential_decay",
                    "1",
                    "beta of beta exp(-beta (f - 1)) fitted to f > 1",
                ),
                SensorColumn::new("half_gaussian_width", "1", "s of exp(-f^2 / 2 s^2) fitted to f > 1"),
                SensorColumn::new(
                    "exponential_advantage",
                    "1",
                    "log-likelihood per contact with f > 1, exponential minus half-Gaussian",
                ),
            ])
            .parameters([BIN_WIDTH, LARGEST_FORCE])
            .needing(&[Part::Contacts, Part::NormalForces])
    }

    fn histograms(&self, recording: &Recording) -> Vec<Bins> {
        let [width, largest] = bins_of(recording);
        vec![bins(width, largest)]
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let contacts = &observation.assembly.contacts;
        let tensile = contacts.iter().filter(|contact| contact.normal_force < 0.0).count();
        let mut squares = 0.0;
        let (mut tail, mut tail_sum, mut tail_squares) = (0, 0.0, 0.0);
        if observation.mean_normal_force > 0.0 {
            for contact in contacts {
                let f = contact.normal_force / observation.mean_normal_force;
                squares += f * f;
                // No branch, which no processor could predict; adding zero changes no sum.
                let in_tail = f > 1.0;
                tail += usize::from(in_tail);
                tail_sum += if in_tail { f } else { 0.0 };
                tail_squares += if in_tail { f * f } else { 0.0 };
            }
        }
        let fit = TailFit::new(mean(tail_sum, tail), mean(tail_squares, tail));
        values.extend([
            observation.mean_normal_force,
            mean(squares, contacts.len()),
            mean(tensile as f64, contacts.len()),
            fit.exponential_decay,
            fit.half_gaussian_width,
            fit.exponential_likelihood - fit.half_gaussian_likelihood,
        ]);
        if let Some(histogram) = values.histogram(0) {
            count(observation, histogram);
        }
    }
}

/// Width of a bin of f, also of the overlaps.
pub const BIN_WIDTH: SensorParameter =
    SensorParameter::new("bin_width", Dimension::NUMBER, 0.25, [0.001, 10.0], "Width of a bin of f = N/<N>.");

/// Largest f with a bin of its own, also of the overlaps.
pub const LARGEST_FORCE: SensorParameter = SensorParameter::new(
    "largest_force",
    Dimension::NUMBER,
    6.0,
    [0.1, 1000.0],
    "Largest f with a bin of its own; larger forces are counted separately.",
);

/// The values of [`BIN_WIDTH`] and [`LARGEST_FORCE`].
pub fn bins_of(recording: &Recording) -> [f64; 2] {
    [BIN_WIDTH, LARGEST_FORCE].map(|parameter| parameter.value(recording).unwrap_or_default())
}

/// The bins of f from [`SMALLEST_FORCE`] on.
pub fn bins(width: f64, largest_force: f64) -> Bins {
    Bins::new(FORCES, "force", "1").width(width).range(SMALLEST_FORCE, largest_force)
}

/// Counts `f = N/<N>` of every contact; nothing where `<N>` is not positive.
fn count(observation: &Observation, histogram: &mut Histogram) {
    if observation.mean_normal_force.is_nan() || observation.mean_normal_force <= 0.0 {
        return;
    }
    let per_bin = 1.0 / (observation.mean_normal_force * histogram.bin_width);
    for contact in &observation.assembly.contacts {
        histogram.add_in_widths(contact.normal_force * per_bin);
    }
}

/// Name of the histogram of f.
pub const FORCES: &str = "forces";

/// Smallest f with its own bin; the tension of adhesive contacts is at most the pull-off force, a fraction of `<N>` in a
/// confined sample.
pub const SMALLEST_FORCE: f64 = -2.0;

/// Fits to the tail f > 1 of a distribution of forces.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TailFit {
    /// Decay beta of the exponential.
    pub exponential_decay: f64,
    /// Width s of the half-Gaussian.
    pub half_gaussian_width: f64,
    /// Log-likelihood per contact of the exponential.
    pub exponential_likelihood: f64,
    /// Log-likelihood per contact of the half-Gaussian.
    pub half_gaussian_likelihood: f64,
}

impl TailFit {
    /// Fits by maximum likelihood from the means of f and f^2 over the contacts with f > 1; all 0 unless the mean of
    /// f exceeds 1.
    pub fn new(mean: f64, mean_square: f64) -> Self {
        let excess = mean - 1.0;
        if excess.is_nan() || excess <= 1e-9 || mean_square <= 1.0 {
            return TailFit::default();
        }
        let decay = 1.0 / excess;
        let x = inverse_width(mean_square);
        let width = 1.0 / x;
        // Logarithm of the normalised density: -(f^2 - 1)/2s^2 - ln(s R(1/s)), with R Mills' ratio.
        let half_gaussian = -0.5 * (mean_square - 1.0) * x * x - ln(width * mills_ratio(x));
        TailFit {
            exponential_decay: decay,
            half_gaussian_width: width,
            exponential_likelihood: ln(decay) - 1.0,
            half_gaussian_likelihood: half_gaussian,
        }
    }
}

/// The solution x = 1/s of `<f^2> = s^2 (1 + x/R(x))`, R Mills' ratio with `R' = x R - 1`, by Newton's method with a
/// bracket: the right-hand side decreases from infinity to 1.
fn inverse_width(mean_square: f64) -> f64 {
    let (mut low, mut high) = (0.0, 20.0);
    let mut x = 1.0;
    for _ in 0..40 {
        let ratio = mills_ratio(x);
        let excess = 1.0 + x / ratio - mean_square * x * x;
        if excess > 0.0 {
            low = x;
        } else {
            high = x;
        }
        let slope = (1.0 - x * (x * ratio - 1.0) / ratio) / ratio - 2.0 * mean_square * x;
        let newton = x - excess / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-12 * x {
            return next;
        }
        x = next;
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::sensor::measured;
    use proptest::prelude::*;

    /// Contacts whose forces are the quantiles of a distribution, so that means become integrals.
    fn assembly_of(forces: impl Iterator<Item = f64>) -> granum_core::assembly::Assembly {
        let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 1e-4);
        let contact = assembly.contacts[0];
        assembly.contacts =
            forces.map(|normal_force| granum_core::assembly::Contact { normal_force, ..contact }).collect();
        assembly
    }

    /// The histogram of an assembly.
    fn counted(assembly: &granum_core::assembly::Assembly, bin_width: f64, largest_force: f64) -> Histogram {
        let recording = Recording::default().with(|recording| {
            recording.parameters =
                [(BIN_WIDTH.key.into(), bin_width), (LARGEST_FORCE.key.into(), largest_force)].into();
        });
        let mut histogram = ForceDistribution.histograms(&recording)[0].empty();
        count(&Observation::new(assembly), &mut histogram);
        histogram
    }

    #[test]
    fn exponential_forces_have_their_moments_and_win_the_tail() {
        let n = 200_000;
        let assembly = assembly_of((0..n).map(|k| -2e-4 * (1.0 - (k as f64 + 0.5) / n as f64).ln()));
        let row = measured(&ForceDistribution, &assembly);
        assert!((row[0] / 2e-4 - 1.0).abs() < 1e-4);
        assert!((row[1] - 2.0).abs() < 1e-3, "<f^2> {}", row[1]);
        assert!((row[3] - 1.0).abs() < 2e-3, "beta {}", row[3]);
        assert!(row[5] > 0.02, "advantage {}", row[5]);
    }

    #[test]
    fn half_gaussian_forces_win_the_tail_with_their_width() {
        // Density ~ exp(-f^2 / 2 s^2) for f > 0: <N> = s sqrt(2/pi), hence s = sqrt(pi/2) in units of <N>.
        let n = 100_000;
        let forces = inverse_half_gaussian(n);
        let assembly = assembly_of(forces.into_iter());
        let row = measured(&ForceDistribution, &assembly);
        let exact = (0.5 * std::f64::consts::PI).sqrt();
        assert!((row[4] / exact - 1.0).abs() < 2e-3, "s {} {exact}", row[4]);
        assert!((row[1] - 0.5 * std::f64::consts::PI).abs() < 1e-3);
        assert!(row[5] < -0.01, "advantage {}", row[5]);
    }

    /// Quantiles of the half-normal distribution, by stepwise integration of its density.
    fn inverse_half_gaussian(n: usize) -> Vec<f64> {
        let h = 1e-5;
        let density = |x: f64| (2.0 / std::f64::consts::PI).sqrt() * (-0.5 * x * x).exp();
        let (mut x, mut cumulative) = (0.0, 0.0);
        (0..n)
            .map(|k| {
                let wanted = (k as f64 + 0.5) / n as f64;
                while cumulative < wanted && x < 6.0 {
                    cumulative += h * density(x + 0.5 * h);
                    x += h;
                }
                x
            })
            .collect()
    }

    #[test]
    fn a_lattice_has_all_its_forces_at_one() {
        let assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 3e-4);
        let histogram = counted(&assembly, 0.3, 6.0);
        assert_eq!(histogram.bins(), 27);
        assert_eq!(histogram.first_bin, -7);
        let bin = (0..histogram.bins()).find(|&b| histogram.counts[b] > 0).unwrap();
        assert!((histogram.centre(bin) - 1.05).abs() < 1e-12);
        assert_eq!(histogram.total(), 81);
        assert!((histogram.density(bin) - 1.0 / 0.3).abs() < 1e-12);
    }

    #[test]
    fn negative_forces_fall_into_bins_below_zero_and_ends_are_counted_apart() {
        let assembly = assembly_of([-0.3, 0.1, 0.2, 4.0, -4.0, 6.0].into_iter());
        let observation = Observation::new(&assembly);
        assert!((observation.mean_normal_force - 1.0).abs() < 1e-15);
        let histogram = counted(&assembly, 0.25, 5.0);
        assert_eq!((histogram.below, histogram.above), (1, 1));
        assert_eq!(histogram.counts[6], 1, "-0.3 lies in [-0.5, -0.25)");
        assert_eq!(histogram.counts[8], 2, "0.1 and 0.2 lie in [0, 0.25)");
        assert_eq!(histogram.total(), 6);
    }

    #[test]
    fn tension_on_the_whole_adds_nothing() {
        let assembly = assembly_of([-1.0, -2.0].into_iter());
        let histogram = counted(&assembly, 0.25, 5.0);
        assert_eq!(histogram.total(), 0);
        assert_eq!(histogram.density(3), 0.0);
    }

    proptest! {
        #[test]
        fn density_integrates_to_one_with_mean_one(seed in 0u64..500, width in 0.02..0.5f64) {
            let assembly = lattice::random_contacts(200, seed);
            let histogram = counted(&assembly, width, 50.0);
            let integral: f64 = (0..histogram.bins()).map(|b| histogram.density(b) * width).sum();
            let first: f64 = (0..histogram.bins()).map(|b| histogram.centre(b) * histogram.density(b) * width).sum();
            prop_assert!((integral - 1.0).abs() < 1e-12);
            prop_assert!((first - 1.0).abs() < 0.5 * width + 1e-12);
        }

        #[test]
        fn fits_are_the_best_of_their_family(mean in 1.05..3.0f64, spread in 0.05..3.0f64) {
            let mean_square = mean * mean + spread;
            let fit = TailFit::new(mean, mean_square);
            let exponential = |beta: f64| beta.ln() - beta * (mean - 1.0);
            let gaussian = |s: f64| -0.5 * (mean_square - 1.0) / (s * s) - (s * mills_ratio(1.0 / s)).ln();
            prop_assert!((exponential(fit.exponential_decay) - fit.exponential_likelihood).abs() < 1e-9);
            prop_assert!((gaussian(fit.half_gaussian_width) - fit.half_gaussian_likelihood).abs() < 1e-9);
            for factor in [0.9, 1.1] {
                prop_assert!(exponential(fit.exponential_decay * factor) < fit.exponential_likelihood);
                prop_assert!(gaussian(fit.half_gaussian_width * factor) < fit.half_gaussian_likelihood + 1e-9);
            }
        }
    }
}
