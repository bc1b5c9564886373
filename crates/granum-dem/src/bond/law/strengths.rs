//! The parameters that the laws of cylindrical bonds have in common.

use super::bond_law::BondShape;
use crate::contact::{LawParameter, Unit};

/// Young's modulus E_b.
pub(super) const MODULUS: LawParameter =
    LawParameter::new("modulus", Unit::STRESS, 1e9, [1.0, 1e15], "Young's modulus E_b of the bond.");
/// Poisson's ratio nu_b.
pub(super) const POISSONS_RATIO: LawParameter = LawParameter::new(
    "poissons_ratio",
    Unit::NUMBER,
    0.25,
    [-0.99, 0.5],
    "Poisson's ratio of the bond, from which its shear modulus E_b / 2 (1 + nu) follows.",
);
/// Strength in tension.
pub(super) const TENSILE_STRENGTH: LawParameter = LawParameter::new(
    "tensile_strength",
    Unit::STRESS,
    f64::INFINITY,
    [0.0, f64::INFINITY],
    "Largest tension sigma_c, bending included, that the bond carries; without a value it never ruptures in tension.",
);
/// Strength in shear without normal stress.
pub(super) const COHESION: LawParameter = LawParameter::new(
    "cohesion",
    Unit::STRESS,
    f64::INFINITY,
    [0.0, f64::INFINITY],
    "Largest shear stress c, twist included, that the bond carries without normal stress; without a value it never ruptures in shear.",
);
/// Angle of friction of the bond.
pub(super) const FRICTION_ANGLE: LawParameter = LawParameter::new(
    "friction_angle",
    Unit::ANGLE,
    0.0,
    [0.0, 1.55],
    "Angle phi_b by which compression raises the strength in shear: tau_c = c + sigma tan(phi_b).",
);
/// Share of the couples in the stresses.
pub(super) const MOMENT_FACTOR: LawParameter = LawParameter::new(
    "moment_factor",
    Unit::NUMBER,
    1.0,
    [0.0, 1.0],
    "Share beta of the couples in the stresses that rupture the bond.",
);

/// The shear modulus of a modulus and a Poisson's ratio, Pa.
pub(super) fn shear_modulus(modulus: f64, poissons_ratio: f64) -> f64 {
    0.5 * modulus / (1.0 + poissons_ratio)
}

/// The greatest tension, shear force, bending and twisting couple, each alone: `sigma_c A, c A, sigma_c I / r_b, c J / r_b`.
pub(super) fn single_modes(shape: &BondShape, tensile_strength: f64, cohesion: f64) -> [f64; 4] {
    let (area, by_radius) = (shape.area(), shape.second_moment() / shape.radius);
    [tensile_strength * area, cohesion * area, tensile_strength * by_radius, 2.0 * cohesion * by_radius]
}
