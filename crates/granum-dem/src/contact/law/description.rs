//! Description of a contact law: its name, and its parameters with their units, bounds and mixing rules.

use crate::contact::law::elementary::{arc_cosine, cosine};

/// SI unit of a parameter, with its powers of kilogram, metre and second.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// Symbol of the SI unit; empty for a pure number.
    pub symbol: &'static str,
    /// Powers of mass, length and time.
    pub powers: [i8; 3],
}

impl Unit {
    /// A pure number.
    pub const NUMBER: Unit = Unit { symbol: "", powers: [0, 0, 0] };
    /// A stress, Pa.
    pub const STRESS: Unit = Unit { symbol: "Pa", powers: [1, -1, -2] };
    /// A stiffness, N/m.
    pub const STIFFNESS: Unit = Unit { symbol: "N/m", powers: [1, 0, -2] };
    /// A length, m.
    pub const LENGTH: Unit = Unit { symbol: "m", powers: [0, 1, 0] };
    /// A time, s.
    pub const TIME: Unit = Unit { symbol: "s", powers: [0, 0, 1] };
    /// An energy, J.
    pub const ENERGY: Unit = Unit { symbol: "J", powers: [1, 2, -2] };
    /// An angle, rad.
    pub const ANGLE: Unit = Unit { symbol: "rad", powers: [0, 0, 0] };
}

/// How the value of a property between two materials follows from the values of the two, where a case gives none for the pair.
///
/// ```
/// use granum_dem::contact::Mixing;
///
/// assert_eq!(Mixing::Geometric.mix(0.5, 0.125), 0.25);
/// assert_eq!(Mixing::Harmonic.mix(1.0, 3.0), 1.5);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum Mixing {
    /// The root of the product: friction, energies of interfaces.
    #[default]
    Geometric,
    /// The mean.
    Arithmetic,
    /// `2 / (1/a + 1/b)`: springs in series.
    Harmonic,
    /// The root of the mean of the squares: rms roughness.
    Quadratic,
    /// The smaller of the two.
    Smaller,
    /// The angle whose cosine is the mean of the two cosines.
    Cosine,
}

impl Mixing {
    /// The value of a pair. It does not depend on the order of the two, and for equal materials it is their common value.
    pub fn mix(self, a: f64, b: f64) -> f64 {
        if a == b {
            return a;
        }
        match self {
            Mixing::Geometric => (a * b).sqrt(),
            Mixing::Arithmetic => 0.5 * (a + b),
            Mixing::Harmonic if a == 0.0 || b == 0.0 => 0.0,
            Mixing::Harmonic => 2.0 / (1.0 / a + 1.0 / b),
            Mixing::Quadratic => (0.5 * (a * a + b * b)).sqrt(),
            Mixing::Smaller => a.min(b),
            Mixing::Cosine => arc_cosine(0.5 * (cosine(a) + cosine(b))),
        }
    }

    /// The rule in words, as a continuation of "of a pair".
    pub fn help(self) -> &'static str {
        match self {
            Mixing::Geometric => "the geometric mean",
            Mixing::Arithmetic => "the mean",
            Mixing::Harmonic => "the harmonic mean",
            Mixing::Quadratic => "the root of the mean square",
            Mixing::Smaller => "the smaller one",
            Mixing::Cosine => "the angle of the mean cosine",
        }
    }
}

/// A parameter of a law: the key `contact.<key>` of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LawParameter {
    /// Key, e.g. `rolling_friction`.
    pub key: &'static str,
    /// SI unit.
    pub unit: Unit,
    /// Default value, in SI units.
    pub default: f64,
    /// Smallest and largest value, in SI units.
    pub bounds: [f64; 2],
    /// Its meaning, in one or two sentences.
    pub meaning: &'static str,
    /// True for a parameter that matters only with a normal law that has no contact area.
    pub without_area: bool,
    /// How the value between two materials follows from those of the two.
    pub mixing: Mixing,
}

impl LawParameter {
    /// A parameter between two bounds with a default, all in SI units. Between two materials it is the root of the product of
    /// the two values ([`Mixing::Geometric`]).
    pub const fn new(
        key: &'static str,
        unit: Unit,
        default: f64,
        bounds: [f64; 2],
        meaning: &'static str,
    ) -> LawParameter {
        LawParameter { key, unit, default, bounds, meaning, without_area: false, mixing: Mixing::Geometric }
    }

    /// The same with another rule for its value between two materials.
    pub const fn mixed_by(self, mixing: Mixing) -> LawParameter {
        LawParameter { mixing, ..self }
    }

    /// The same for a parameter that matters only with a normal law that has no contact area.
    pub const fn without_contact_area(self) -> LawParameter {
        LawParameter { without_area: true, ..self }
    }
}

/// Description of a law.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct LawDescription {
    /// Name in case files and messages, e.g. `jkr`.
    pub name: &'static str,
    /// Name in reports, e.g. `JKR`.
    pub label: &'static str,
    /// What it describes, in a few words.
    pub help: &'static str,
    /// Its parameters.
    pub parameters: &'static [LawParameter],
}

impl LawDescription {
    /// A law of that name (in case files and messages), label (in reports), help (in a few words) and parameters.
    pub const fn new(
        name: &'static str,
        label: &'static str,
        help: &'static str,
        parameters: &'static [LawParameter],
    ) -> LawDescription {
        LawDescription { name, label, help, parameters }
    }
}
