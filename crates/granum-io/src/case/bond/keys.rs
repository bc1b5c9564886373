//! The keys of a table `[[bond]]`, but for those of the law.

use granum_core::quantity::Dimension;
use granum_dem::bond::BondKind;
use granum_dem::contact::LawParameter;

/// What a key can be.
#[derive(Clone, Copy, Debug)]
pub(super) enum KeyKind {
    /// A number with a dimension, between bounds.
    Number(Dimension, [f64; 2]),
    /// A whole number of at least this.
    Count(u64),
    /// One of these words, with their meanings.
    Word(&'static [[&'static str; 2]]),
    /// The name of a law.
    Law,
}

/// A key of a table `[[bond]]`.
pub(super) struct BondKey {
    pub(super) key: &'static str,
    pub(super) kind: KeyKind,
    /// The default as a case file has it; `None`: the key is not in use unless it is given.
    pub(super) default: Option<&'static str>,
    pub(super) help: &'static str,
}

const fn key(key: &'static str, kind: KeyKind, default: Option<&'static str>, help: &'static str) -> BondKey {
    BondKey { key, kind, default, help }
}

const NUMBER: Dimension = Dimension::NUMBER;
/// A volume.
const VOLUME: Dimension = Dimension::of_powers([0, 3, 0]);

/// The keys, in the order in which they are written.
pub(super) const KEYS: &[BondKey] = &[
    key("law", KeyKind::Law, Some("parallel"), "How stiff and how strong bonds are."),
    key(
        "places",
        KeyKind::Word(&[
            ["between", "pieces of different grains that touch, or are nearer than largest_gap"],
            [
                "inside",
                "the touching pieces of each grain, which becomes an agglomerate of spheres that can come apart",
            ],
            [
                "file",
                "the pairs that the packing of the run lists, as the section Bonds of a LAMMPS data file does",
            ],
        ]),
        Some("between"),
        "Which pieces are joined.",
    ),
    key(
        "type",
        KeyKind::Count(1),
        None,
        "Only the pairs of this type of the packing; without it those of all types. Only with places = \"file\".",
    ),
    key(
        "before_stage",
        KeyKind::Count(1),
        Some("1"),
        "Number of the stage before which bonds are made; before the first the sample carries the stress of its preparation.",
    ),
    key(
        "radius",
        KeyKind::Number(NUMBER, [1e-3, 1.0]),
        Some("0.5"),
        "Radius of a bond over that of the smaller of its two pieces.",
    ),
    key(
        "cement_content",
        KeyKind::Number(NUMBER, [1e-9, 1.0]),
        None,
        "Mass of the cement over that of the grains, from which the radius follows; in place of radius.",
    ),
    key(
        "cement_density",
        KeyKind::Number(Dimension::DENSITY, [1.0, 1e5]),
        Some("3100"),
        "Density of the cement; only together with cement_content.",
    ),
    key(
        "largest_gap",
        KeyKind::Number(NUMBER, [0.0, 1.0]),
        Some("0"),
        "Largest distance of two surfaces that are joined, over the mean diameter; 0: those that touch.",
    ),
    key(
        "attachment",
        KeyKind::Word(&[
            ["contact", "where the pieces touch, at the distances of their radii from their centres"],
            ["middle", "halfway between their centres, as LAMMPS attaches bonds"],
        ]),
        // Not in use unless it is given, so that cases from before there was this key stay what they were.
        None,
        "Where a bond is attached to its two pieces: where they touch, unless it is given. For pieces of one size both are the same.",
    ),
    key(
        "damping",
        KeyKind::Number(NUMBER, [0.0, 1.0]),
        Some("0"),
        "Damping ratio of the four motions of a bond.",
    ),
    key(
        "scatter",
        KeyKind::Word(&[
            ["none", "all bonds are equally strong"],
            ["normal", "normally distributed, with strength_deviation"],
            ["weibull", "after Weibull, with weibull_modulus"],
        ]),
        Some("none"),
        "How the strengths of bonds scatter.",
    ),
    key(
        "strength_deviation",
        KeyKind::Number(NUMBER, [0.0, 1.0]),
        Some("0.2"),
        "Standard deviation of the strength over its mean; only with scatter = \"normal\".",
    ),
    key(
        "weibull_modulus",
        KeyKind::Number(NUMBER, [0.1, 1e3]),
        Some("4"),
        "Modulus m of Weibull's distribution; only with scatter = \"weibull\".",
    ),
    key(
        "reference_volume",
        KeyKind::Number(VOLUME, [1e-30, 1e3]),
        None,
        "Volume of a bond that has the given strength; others have it times (V/V0)^(-1/m). Only with scatter = \"weibull\".",
    ),
    key(
        "left_out",
        KeyKind::Number(NUMBER, [0.0, 0.99]),
        Some("0"),
        "Share of the bonds, drawn at random, that are left out.",
    ),
    key("seed", KeyKind::Count(0), Some("1"), "Seed of the scatter and of what is left out."),
];

/// The key of the list with this name.
pub(super) fn known(name: &str) -> Option<&'static BondKey> {
    KEYS.iter().find(|key| key.key == name)
}

/// The parameter of a law with this key.
pub(super) fn parameter(law: BondKind, name: &str) -> Option<&'static LawParameter> {
    law.law().description().parameters.iter().find(|parameter| parameter.key == name)
}

/// The dimension of a parameter of a law.
pub(super) fn dimension(parameter: &LawParameter) -> Dimension {
    match parameter.unit.symbol {
        "rad" => Dimension::ANGLE,
        _ => Dimension::of_powers(parameter.unit.powers),
    }
}
