//! What is thought of the parameters of a covariance before any row is seen.
//!
//! Each logarithm has a normal distribution, for inputs and outputs with a standard deviation of one. It decides what few rows cannot,
//! and keeps terms small that rows do not support.

use super::covariance::{EACH, SHARED};

/// The prior of the parameters of the covariance of a process.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Prior {
    /// For about a hundred rows or more, which decide by themselves how long and how straight functions are.
    #[default]
    Wide,
    /// For few rows: lengths are closer to their typical value, and straight lines are flat, since few rows cannot tell the slopes of inputs apart
    /// that vary together, and steep ones of opposite sign go wrong outside of the rows.
    Narrow,
}

/// Mean and standard deviation of the logarithm of a parameter.
#[derive(Clone, Copy)]
struct Normal {
    typical: f64,
    deviation: f64,
}

const LENGTH: Normal = Normal { typical: 1.098_612_288_668_11, deviation: 1.3 }; // ln 3
const WEIGHT: Normal = Normal { typical: -1.203_972_804_325_936, deviation: 1.5 }; // ln 0.3
const SLOPE: Normal = Normal { typical: -std::f64::consts::LN_10, deviation: 1.5 }; // ln 0.1
const OF_PAIRS: Normal = Normal { typical: 0.0, deviation: 1.5 }; // ln 1
const OF_PRODUCT: Normal = Normal { typical: -1.203_972_804_325_936, deviation: 1.5 }; // ln 0.3
const OF_CONSTANT: Normal = Normal { typical: -1.203_972_804_325_936, deviation: 1.0 }; // ln 0.3
const OF_NOISE: Normal = Normal { typical: -2.995_732_273_553_991, deviation: 2.5 }; // ln 0.05

const NARROW_LENGTH: Normal = Normal { deviation: 0.7, ..LENGTH };
const NARROW_SLOPE: Normal = Normal { typical: SLOPE.typical - 2.0, ..SLOPE };

impl Prior {
    /// Mean and standard deviation of each logarithm, in the order of the covariance, for so many inputs.
    pub(super) fn of_logarithms(self, inputs: usize) -> Vec<[f64; 2]> {
        let (length, slope) = match self {
            Prior::Wide => (LENGTH, SLOPE),
            Prior::Narrow => (NARROW_LENGTH, NARROW_SLOPE),
        };
        let pair = |normal: Normal| [normal.typical, normal.deviation];
        let each = [length, WEIGHT, slope].map(pair);
        let shared: [[f64; 2]; SHARED] = [OF_PAIRS, OF_PRODUCT, OF_CONSTANT, OF_NOISE].map(pair);
        let each: [[f64; 2]; EACH] = each;
        each.iter().flat_map(|pair| std::iter::repeat_n(*pair, inputs)).chain(shared).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_narrow_prior_differs_in_lengths_and_slopes_alone() {
        let (wide, narrow) = (Prior::Wide.of_logarithms(3), Prior::Narrow.of_logarithms(3));
        assert_eq!(wide.len(), 3 * EACH + SHARED);
        let differs: Vec<usize> = (0..wide.len()).filter(|k| wide[*k] != narrow[*k]).collect();
        assert_eq!(differs, [0, 1, 2, 6, 7, 8]);
        assert!(narrow[0][1] < wide[0][1] && narrow[6][0] < wide[6][0]);
    }
}
