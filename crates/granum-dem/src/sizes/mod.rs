//! Size distributions of the grains.
//!
//! A distribution gives the share of the grains, **by number**, that are smaller than a diameter, and its inverse. A sample of N
//! grains has the N quantiles at the shares `(i + 1/2) / N`, so that it reproduces the distribution as closely as N grains can; the seed
//! of the preparation determines the positions of the grains, not their sizes. (The default, `uniform`, draws each radius at random
//! instead.)
//!
//! A distribution can be cut at a smallest and a largest diameter ([`Sizes::smallest`], [`Sizes::largest`]): the shares between the
//! cuts are then scaled to one. Curves by mass are turned into shares by number, since a grain of diameter d has a mass
//! proportional to d³.
//!
//! A new distribution needs a file and a line in [`SizeKind`] and [`ALL`].

mod curve;
mod equal;
mod fractal;
mod grains;
mod lognormal;
pub(crate) mod normal;
mod two_sizes;
mod uniform;
mod weibull;

use std::collections::BTreeMap;
use std::fmt;

use rand_chacha::ChaCha8Rng;
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

pub use curve::{SieveCurve, check_curve};
pub use equal::Equal;
pub use fractal::Fractal;
pub use grains::Grains;
pub use lognormal::Lognormal;
pub use normal::Normal;
pub use two_sizes::TwoSizes;
pub use uniform::Uniform;
pub use weibull::Weibull;

/// Largest ratio of the largest to the smallest grain of a sample.
pub const LARGEST_RATIO: f64 = 50.0;

/// A parameter of a distribution, a pure number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeParameter {
    /// Key in the section `[grains]` of a case file.
    pub key: &'static str,
    /// Default value.
    pub default: f64,
    /// Smallest and largest value.
    pub bounds: [f64; 2],
    /// Its meaning, in one or two sentences.
    pub meaning: &'static str,
}

/// Description of a distribution.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SizeDescription {
    /// Name in case files, e.g. `lognormal`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub help: &'static str,
    /// Its parameters.
    pub parameters: &'static [SizeParameter],
    /// True if `grains.diameter` is its mean (before a cut); otherwise the cuts or the curve decide.
    pub has_mean: bool,
    /// True if it can be cut at a smallest and a largest diameter.
    pub can_be_cut: bool,
}

/// Reasons why grains cannot have these sizes.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("grains.{key} {message}")]
pub struct SizeError {
    /// The key in the section `[grains]` that is wrong.
    pub key: &'static str,
    /// What is wrong and what would be right, continuing the key.
    pub message: String,
}

impl SizeError {
    /// An error about a key.
    pub fn new(key: &'static str, message: impl Into<String>) -> SizeError {
        SizeError { key, message: message.into() }
    }
}

/// A size distribution.
pub trait SizeDistribution: Sync {
    /// Its name, meaning and parameters.
    fn description(&self) -> &'static SizeDescription;

    /// Share of the grains, by number, whose diameter is below `diameter`, m, before any cut.
    fn share_below(&self, grains: &Grains, diameter: f64) -> f64;

    /// The diameter, m, below which a share of the grains lies, before any cut: the inverse of
    /// [`SizeDistribution::share_below`].
    fn quantile(&self, grains: &Grains, share: f64) -> f64;

    /// Refuses grains for which the distribution is not defined.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    fn check(&self, _grains: &Grains) -> Result<(), SizeError> {
        Ok(())
    }

    /// The diameters of the grains, m; unless overridden the quantiles at `(i + 1/2) / N` between the cuts, which use no random
    /// numbers.
    fn diameters(&self, grains: &Grains, _random: &mut ChaCha8Rng) -> Vec<f64> {
        let [low, high] = grains::shares_between_cuts(self, grains);
        let count = grains.count;
        let share = |k: usize| low + (high - low) * ((k as f64 + 0.5) / count as f64);
        (0..count).map(|k| self.quantile(grains, share(k))).collect()
    }
}

/// The choice of a distribution. Its name identifies it in files.
#[derive(Clone, Copy)]
pub struct SizeKind(&'static dyn SizeDistribution);

macro_rules! kinds {
    ($($name:ident = $type:ident,)*) => {
        impl SizeKind {
            $(
                #[doc = concat!("[`", stringify!($type), "`].")]
                pub const $name: SizeKind = SizeKind(&$type);
            )*
        }

        /// All distributions that a name in a case file can stand for.
        pub const ALL: &[SizeKind] = &[$(SizeKind::$name,)*];
    };
}

kinds! {
    UNIFORM = Uniform,
    EQUAL = Equal,
    NORMAL = Normal,
    LOGNORMAL = Lognormal,
    TWO_SIZES = TwoSizes,
    WEIBULL = Weibull,
    FRACTAL = Fractal,
    SIEVE_CURVE = SieveCurve,
}

impl SizeKind {
    /// A distribution of the caller's own, which a program can use without a name in case files.
    pub const fn new(distribution: &'static dyn SizeDistribution) -> SizeKind {
        SizeKind(distribution)
    }

    /// The distribution.
    pub fn distribution(&self) -> &'static dyn SizeDistribution {
        self.0
    }

    /// Its name in case files.
    pub fn name(&self) -> &'static str {
        self.0.description().name
    }

    /// The distribution of a name.
    pub fn named(name: &str) -> Option<SizeKind> {
        ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

/// The parameters of all distributions, each key once.
pub fn parameters() -> Vec<&'static SizeParameter> {
    let mut all: Vec<&'static SizeParameter> = Vec::new();
    for parameter in ALL.iter().flat_map(|kind| kind.0.description().parameters) {
        if all.iter().all(|known| known.key != parameter.key) {
            all.push(parameter);
        }
    }
    all
}

impl PartialEq for SizeKind {
    fn eq(&self, other: &SizeKind) -> bool {
        self.name() == other.name()
    }
}

impl Eq for SizeKind {}

impl Default for SizeKind {
    fn default() -> Self {
        SizeKind::UNIFORM
    }
}

impl fmt::Debug for SizeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for SizeKind {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}

impl<'d> Deserialize<'d> for SizeKind {
    fn deserialize<D: Deserializer<'d>>(from: D) -> Result<SizeKind, D::Error> {
        let name = String::deserialize(from)?;
        SizeKind::named(&name)
            .ok_or_else(|| D::Error::custom(format!("no size distribution is called {name:?}")))
    }
}

/// How large the grains are, beside their mean diameter and [`Grains::spread`].
///
/// ```
/// use granum_dem::config::Grains;
/// use granum_dem::sizes::{SizeKind, Sizes};
///
/// let mut grains = Grains::default();
/// (grains.count, grains.diameter) = (1000, 1e-3);
/// grains.sizes = Sizes::new(SizeKind::LOGNORMAL).with("size_deviation", 0.3);
/// assert!((grains.mean_diameter()? / 1e-3 - 1.0).abs() < 1e-3);
/// let [smallest, largest] = grains.size_range()?;
/// assert!(largest / smallest > 5.0);
/// # Ok::<(), granum_dem::sizes::SizeError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Sizes {
    /// The distribution.
    pub distribution: SizeKind,
    /// Values given to its parameters; the others have their defaults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f64>,
    /// Smallest diameter, m: smaller grains are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallest: Option<f64>,
    /// Largest diameter, m: larger grains are left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
    /// Points of a sieve curve: a diameter, m, and the share of the mass that is finer, both rising.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub curve: Vec<[f64; 2]>,
}

impl Sizes {
    /// A distribution with its defaults, without cuts.
    pub fn new(distribution: SizeKind) -> Sizes {
        Sizes { distribution, ..Sizes::default() }
    }

    /// The same with a value for a parameter.
    pub fn with(mut self, key: &str, value: f64) -> Sizes {
        self.values.insert(key.to_string(), value);
        self
    }

    /// The same cut at a smallest and a largest diameter, m.
    pub fn between(mut self, smallest: f64, largest: f64) -> Sizes {
        (self.smallest, self.largest) = (Some(smallest), Some(largest));
        self
    }

    /// The same with a sieve curve.
    pub fn with_curve(mut self, curve: Vec<[f64; 2]>) -> Sizes {
        self.curve = curve;
        self
    }

    /// True where the sizes are those of [`Grains::spread`].
    pub fn is_standard(&self) -> bool {
        *self == Sizes::default()
    }

    /// The value of a parameter.
    pub fn value(&self, parameter: &SizeParameter) -> f64 {
        self.values.get(parameter.key).copied().unwrap_or(parameter.default)
    }
}

#[cfg(test)]
mod tests;
