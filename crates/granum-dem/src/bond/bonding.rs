//! What is to be bonded, and by what: the definition of one set of bonds.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::law::bond_law::BondStiffness;
use super::law::kind::BondKind;
use super::strength::StrengthScatter;
use crate::contact::LawParameter;

/// How wide bonds are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BondRadius {
    /// This share of the radius of the smaller of the two pieces.
    Share(f64),
    /// As a content of cement asks for: all bonds have the same share of the smaller radius.
    Cement {
        /// Mass of the cement over that of the grains.
        content: f64,
        /// Density of the cement, kg/m3.
        density: f64,
    },
}

/// Which pieces are joined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BondPlaces {
    /// Pieces of different grains that touch, or are nearer than a gap.
    #[default]
    Between,
    /// The touching pieces of each grain of several pieces, which becomes an agglomerate of spheres that move by themselves.
    Inside,
    /// The pairs that [`Simulation::list_pairs`](crate::simulation::Simulation::list_pairs) was given, as the file of a packing lists them.
    Listed,
}

/// Where a bond is attached to its two pieces, on the line between their centres. For pieces of one size all are the same.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum BondAttachment {
    /// Where they touch, or would: at distances `d R_i / (R_i + R_j)` and `d R_j / (R_i + R_j)` from the centres, which are d apart.
    #[default]
    Contact,
    /// Halfway between the centres, as `bpm/rotational` of LAMMPS attaches bonds.
    Middle,
}

impl BondAttachment {
    /// Distances of the point of attachment from the centres of two pieces of given radii, m, that are a distance apart, m.
    pub(super) fn arms(self, distance: f64, radii: [f64; 2]) -> [f64; 2] {
        let arm = match self {
            BondAttachment::Contact => distance * radii[0] / (radii[0] + radii[1]),
            BondAttachment::Middle => 0.5 * distance,
        };
        [arm, distance - arm]
    }
}

/// A set of bonds that is made at one moment. Bonds carry nothing when they are made, whatever forces there are: cement that sets under a load
/// changes no force.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Bonding {
    /// How stiff and how strong they are.
    pub law: BondKind,
    /// Values of the law's parameters, in SI units; the others have their defaults.
    pub parameters: BTreeMap<String, f64>,
    /// Which pieces they join.
    pub places: BondPlaces,
    /// How wide they are.
    pub radius: BondRadius,
    /// Of the listed pairs only those of this type; all if there is none.
    pub kind: Option<u32>,
    /// Largest distance of the surfaces of two pieces that are joined, over the mean diameter of the grains; 0: those that touch.
    pub largest_gap: f64,
    /// Where bonds are attached to their pieces.
    #[serde(default)]
    pub attachment: BondAttachment,
    /// Damping ratio zeta of the four motions of a bond: dashpots `2 zeta sqrt(m* k)`.
    pub damping: f64,
    /// How the strengths scatter.
    pub scatter: StrengthScatter,
    /// Seed of this scatter.
    pub seed: u64,
    /// Share of the bonds, drawn from the seed, that are left out.
    pub left_out: f64,
}

impl Default for Bonding {
    fn default() -> Bonding {
        Bonding {
            law: BondKind::PARALLEL,
            parameters: BTreeMap::new(),
            places: BondPlaces::Between,
            kind: None,
            radius: BondRadius::Share(0.5),
            largest_gap: 0.0,
            attachment: BondAttachment::Contact,
            damping: 0.0,
            scatter: StrengthScatter::None,
            seed: 1,
            left_out: 0.0,
        }
    }
}

impl Bonding {
    /// The same with some fields changed.
    ///
    /// ```
    /// use granum_dem::bond::{BondRadius, Bonding};
    ///
    /// let wide = Bonding::default().with(|bonding| bonding.radius = BondRadius::Share(1.0));
    /// assert_eq!(wide.radius, BondRadius::Share(1.0));
    /// ```
    pub fn with(mut self, change: impl FnOnce(&mut Bonding)) -> Bonding {
        change(&mut self);
        self
    }

    /// The value of a parameter of the law: the given one, or its default.
    fn value_of(&self, parameter: &LawParameter) -> f64 {
        self.parameters.get(parameter.key).copied().unwrap_or(parameter.default)
    }

    /// The values of the law's parameters, in the order of its description.
    pub fn values(&self) -> Vec<f64> {
        let parameters = self.law.law().description().parameters;
        parameters.iter().map(|p| self.value_of(p)).collect()
    }

    /// The value of a parameter of the law by its key, in SI units; none if the law has no such parameter.
    pub fn value(&self, key: &str) -> Option<f64> {
        let parameters = self.law.law().description().parameters;
        parameters.iter().find(|p| p.key == key).map(|p| self.value_of(p))
    }

    /// The dashpots of a bond, `2 zeta sqrt(m* k)` of its four stiffnesses, N s/m and N m s, from mass, kg, and moment of inertia, kg m2, of its two
    /// pieces: m* is the mass `m_i m_j / (m_i + m_j)` of stretch and shear, and the same of the moments of inertia for bending and twist.
    pub fn dashpots(&self, stiffness: &BondStiffness, pieces: [[f64; 2]; 2]) -> BondStiffness {
        let [mass, moment] = std::array::from_fn(|k| {
            let [x, y] = [pieces[0][k], pieces[1][k]];
            x * y / (x + y)
        });
        let dashpot = |inertia: f64, stiffness: f64| 2.0 * self.damping * (inertia * stiffness).sqrt();
        BondStiffness {
            normal: dashpot(mass, stiffness.normal),
            shear: dashpot(mass, stiffness.shear),
            bending: dashpot(moment, stiffness.bending),
            twisting: dashpot(moment, stiffness.twisting),
        }
    }

    /// What is wrong with it, if anything.
    pub(super) fn problem(&self) -> Option<String> {
        let parameters = self.law.law().description().parameters;
        if let Some(key) = self.parameters.keys().find(|key| parameters.iter().all(|p| p.key != key.as_str()))
        {
            return Some(format!("the law {:?} has no parameter {key}", self.law.name()));
        }
        for parameter in parameters {
            let value = self.value_of(parameter);
            let [low, high] = parameter.bounds;
            if !(low..=high).contains(&value) {
                return Some(format!(
                    "{} is {value} {}; it must be between {low} and {high}",
                    parameter.key, parameter.unit.symbol
                ));
            }
        }
        let within = |name: &str, value: f64, low: f64, high: f64| {
            let right = (low..=high).contains(&value);
            (!right).then(|| format!("{name} is {value}; it must be between {low} and {high}"))
        };
        let radius = match self.radius {
            BondRadius::Share(share) => within("the share of the radius", share, 1e-3, 1.0),
            BondRadius::Cement { content, density } => within("the content of cement", content, 1e-9, 1.0)
                .or_else(|| within("the density of the cement", density, 1e-9, 1e9)),
        };
        let scatter = match self.scatter {
            StrengthScatter::None => None,
            StrengthScatter::Normal(deviation) => {
                within("the standard deviation of the strength", deviation, 0.0, 1.0)
            }
            StrengthScatter::Weibull { modulus, reference_volume } => {
                let volume = reference_volume.unwrap_or(1.0);
                let positive = volume > 0.0 && volume.is_finite();
                let wrong =
                    (!positive).then(|| format!("the reference volume is {volume} m3; it must be positive"));
                within("Weibull's modulus", modulus, 0.1, 1e3).or(wrong)
            }
        };
        radius
            .or(scatter)
            .or_else(|| within("the largest gap", self.largest_gap, 0.0, 1.0))
            .or_else(|| within("the damping ratio", self.damping, 0.0, 1.0))
            .or_else(|| within("the share of bonds that are left out", self.left_out, 0.0, 1.0))
    }
}
