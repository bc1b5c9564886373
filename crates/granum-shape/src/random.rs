//! Random numbers that are the same on every machine: SplitMix64 (Steele, Lea and Flood 2014).

/// A sequence of random numbers.
#[derive(Clone, Debug)]
pub(crate) struct Random(u64);

impl Random {
    /// The sequence of a seed and of up to two further numbers, such as that of a shape.
    pub(crate) fn new(seed: u64, first: u64, second: u64) -> Random {
        let mut mixed = Random(seed);
        for number in [first, second] {
            mixed.0 = mixed.whole() ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15);
        }
        mixed
    }

    /// 64 random bits.
    pub(crate) fn whole(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Evenly distributed, above 0 and below 1.
    pub(crate) fn even(&mut self) -> f64 {
        ((self.whole() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
    }

    /// Normally distributed with mean 0 and deviation 1 (Box and Muller).
    pub(crate) fn normal(&mut self) -> f64 {
        let radius = (-2.0 * libm::log(self.even())).sqrt();
        radius * libm::cos(std::f64::consts::TAU * self.even())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first numbers of the seed 1234567 as published with the algorithm; moments of the two distributions.
    #[test]
    fn numbers_are_the_published_ones_and_have_their_moments() {
        let mut random = Random(1_234_567);
        assert_eq!([random.whole(), random.whole()], [6_457_827_717_110_365_317, 3_203_168_211_198_807_973]);
        let mut random = Random::new(1, 2, 3);
        let count = 20_000;
        let even: f64 = (0..count).map(|_| random.even()).sum::<f64>() / f64::from(count);
        assert!((even - 0.5).abs() < 0.01, "{even}");
        let normal: Vec<f64> = (0..count).map(|_| random.normal()).collect();
        let mean = |power: i32| normal.iter().map(|x| x.powi(power)).sum::<f64>() / f64::from(count);
        assert!(mean(1).abs() < 0.03 && (mean(2) - 1.0).abs() < 0.04 && (mean(4) - 3.0).abs() < 0.2);
        assert_ne!(Random::new(1, 2, 3).whole(), Random::new(1, 3, 2).whole());
    }
}
