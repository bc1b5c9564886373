//! How long answers took: a histogram of times with a fixed memory, whatever their number.

use std::time::Duration;

/// Parts of an octave: a time is known to within a part of 1/64.
const PARTS: u32 = 64;
/// Octaves above one nanosecond; the last ends after half an hour.
const OCTAVES: u32 = 41;

/// Times, counted in parts of octaves of nanoseconds.
#[derive(Clone, Debug)]
pub struct Latency {
    counts: Vec<u64>,
    all: u64,
    largest: Duration,
}

impl Default for Latency {
    fn default() -> Latency {
        Latency { counts: vec![0; (PARTS * OCTAVES) as usize], all: 0, largest: Duration::ZERO }
    }
}

impl Latency {
    /// Counts a time.
    pub fn add(&mut self, time: Duration) {
        let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX).max(1);
        let octave = nanoseconds.ilog2();
        let within = ((u128::from(nanoseconds) * u128::from(PARTS)) >> octave) as u32 - PARTS;
        let place = (octave * PARTS + within).min(PARTS * OCTAVES - 1);
        self.counts[place as usize] += 1;
        self.all += 1;
        self.largest = self.largest.max(time);
    }

    /// The time that a share (0 to 1) of all did not exceed, at most a part in 64 too long.
    pub fn quantile(&self, share: f64) -> Duration {
        let wanted = (share * self.all as f64).ceil().max(1.0) as u64;
        let mut counted = 0;
        for (place, count) in self.counts.iter().enumerate() {
            counted += count;
            if counted >= wanted {
                let (octave, within) = (place as u32 / PARTS, place as u32 % PARTS);
                let end = (u128::from(PARTS + within + 1) << octave).div_ceil(u128::from(PARTS));
                return Duration::from_nanos(u64::try_from(end).unwrap_or(u64::MAX)).min(self.largest);
            }
        }
        self.largest
    }

    /// Number of times, their median, the times that 99 % and 99.9 % did not exceed, and the largest.
    pub fn text(&self) -> String {
        let microseconds = |time: Duration| format!("{:.1}", time.as_secs_f64() * 1e6);
        let [median, most, nearly_all] = [0.5, 0.99, 0.999].map(|share| microseconds(self.quantile(share)));
        format!(
            "{} lines, microseconds from a line read to its answer written: median {median}, 99 % within {most}, 99.9 % within {nearly_all}, \
             largest {}",
            self.all,
            microseconds(self.largest)
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_those_of_the_times() {
        let mut latency = Latency::default();
        (1..=10_000u64).for_each(|k| latency.add(Duration::from_nanos(100 * k)));
        for share in [0.001, 0.1, 0.5, 0.99, 0.999, 1.0] {
            let (found, exact) = (latency.quantile(share).as_nanos() as f64, 1e6 * share);
            assert!(found >= exact && found <= exact * (1.0 + 1.0 / 64.0) + 1.0, "{share}: {found} {exact}");
        }
        assert!(latency.text().starts_with("10000 lines"), "{}", latency.text());
        assert!(latency.text().ends_with("largest 1000.0"), "{}", latency.text());
    }

    #[test]
    fn no_time_is_too_short_or_too_long() {
        let mut latency = Latency::default();
        assert_eq!(latency.quantile(0.5), Duration::ZERO);
        latency.add(Duration::ZERO);
        latency.add(Duration::from_secs(1 << 40));
        assert!(latency.quantile(1.0).as_secs() > 1000);
        assert_eq!(latency.quantile(0.1), Duration::from_nanos(2).min(latency.largest));
    }
}
