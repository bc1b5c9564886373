//! Several materials in one sample: their properties, their shares of the grains, and the rules for contacts between them.
//!
//! The properties of a pair of materials follow from those of the two: elastic moduli from contact mechanics, where the
//! compliances of both are added (they are never averaged), all others by the rule of [`Mixing`](crate::contact::Mixing) of
//! the property, unless a [`PairRule`] gives the value. The materials are assigned to the grains at random from a seed, with
//! exact numbers of grains; the assignment does not depend on the order in which the materials are named.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

use crate::contact::choice::check::check;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::law_error::LawError;
use crate::contact::choice::parameters::ParameterValues;
use crate::material::Material;

/// Most materials of a sample.
pub const MOST_MATERIALS: usize = 32;

/// One material of several.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Component {
    /// Its name.
    pub name: String,
    /// Share of the grains, by number.
    pub share: f64,
    /// Its properties.
    pub material: Material,
    /// Values of contact laws' parameters that are its own; for the others those of [`ContactModel::parameters`] stand.
    pub parameters: ParameterValues,
}

impl Component {
    /// A material of this name, share and properties, with no parameters of its own.
    pub fn new(name: impl Into<String>, share: f64, material: Material) -> Component {
        Component { name: name.into(), share, material, parameters: ParameterValues::NONE }
    }
}

/// Values for pairs of grains of two materials, in place of what follows from the two.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairRule {
    /// The names of the two; both the same for grains of one material among themselves.
    pub between: [String; 2],
    /// Coefficient of friction mu.
    pub friction: Option<f64>,
    /// Interface energy Gamma, J/m2.
    pub interface_energy: Option<f64>,
    /// Parameters of contact laws.
    pub parameters: ParameterValues,
}

/// Several materials. If it is empty, all grains have the one material of the case.
///
/// ```
/// use granum_dem::config::{Component, ContactModel, Material, Mixture, PairRule};
/// use granum_dem::simulation::Properties;
///
/// let glass = Material::default().with(|material| material.friction = 0.5);
/// let steel = glass.with(|material| {
///     material.friction = 0.125;
///     material.density = 7800.0;
///     material.youngs_modulus = 210e9;
/// });
/// let mixture = Mixture::new([Component::new("glass", 0.75, glass), Component::new("steel", 0.25, steel)]);
/// assert_eq!(mixture.assign(8, 1).iter().filter(|k| **k == 1).count(), 2);
/// let properties = Properties::new(glass, ContactModel::default()).with_mixture(mixture);
/// assert_eq!(properties.pair(["glass", "steel"], [5e-5, 5e-5])?.friction, 0.25);
/// # Ok::<(), granum_dem::mixture::MixtureError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Mixture {
    /// The materials, by name.
    pub components: Vec<Component>,
    /// Values for pairs of them, by names.
    pub pairs: Vec<PairRule>,
    /// Seed of the draw that says which grain is of which material.
    #[serde(default)]
    pub seed: u64,
}

/// Materials that are inconsistent.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MixtureError {
    /// Two materials of one name.
    #[error("two materials are called {0:?}; names must differ")]
    NameTwice(String),
    /// An empty name.
    #[error("a material has no name; give each one")]
    NoName,
    /// A rule for a material that does not exist.
    #[error("a pair names the material {name:?}, which does not exist; there are {known}")]
    UnknownName {
        /// The name.
        name: String,
        /// The existing names.
        known: String,
    },
    /// Two rules for one pair.
    #[error("two rules for the pair of {0:?} and {1:?}; keep one")]
    PairTwice(String, String),
    /// Shares that do not sum to one.
    #[error("the shares of the materials sum to {0}; they must be positive and sum to 1")]
    Shares(f64),
    /// Too many materials.
    #[error("there are {0} materials; at most {MOST_MATERIALS} are possible")]
    TooMany(usize),
    /// A property with an impossible value.
    #[error("{name} of {of} is {value}; it must be {right}")]
    Property {
        /// The material or the pair.
        of: String,
        /// The property.
        name: &'static str,
        /// Its value, in SI units.
        value: f64,
        /// The permitted values.
        right: &'static str,
    },
    /// A parameter of a contact law with an impossible value.
    #[error("{of}: {error}")]
    Law {
        /// The material or the pair.
        of: String,
        /// What is wrong.
        error: LawError,
    },
}

/// How far the shares may be from one.
const ROUNDING: f64 = 1e-9;

impl Mixture {
    /// Materials without rules for pairs, with the seed 1.
    pub fn new(components: impl IntoIterator<Item = Component>) -> Mixture {
        let mut mixture =
            Mixture { components: components.into_iter().collect(), pairs: Vec::new(), seed: 1 };
        mixture.sort();
        mixture
    }

    /// The same with a rule for a pair of materials.
    pub fn with_pair(mut self, rule: PairRule) -> Mixture {
        self.pairs.push(rule);
        self.sort();
        self
    }

    /// Sets the seed.
    pub fn with_seed(mut self, seed: u64) -> Mixture {
        self.seed = seed;
        self
    }

    /// Puts materials and rules in the order of their names, in which the order of naming is lost.
    pub fn sort(&mut self) {
        self.components.sort_by(|a, b| a.name.cmp(&b.name));
        for rule in &mut self.pairs {
            rule.between.sort();
        }
        self.pairs.sort_by(|a, b| a.between.cmp(&b.between));
    }

    /// True where the grains have one material.
    pub fn is_empty(&self) -> bool {
        self.components.is_empty()
    }

    /// The place of a material among the components.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.components.iter().position(|component| component.name == name)
    }

    /// The rule for two materials.
    pub fn rule(&self, a: &str, b: &str) -> Option<&PairRule> {
        self.pairs.iter().find(|rule| {
            let [x, y] = rule.between.each_ref().map(String::as_str);
            [x, y] == [a, b] || [x, y] == [b, a]
        })
    }

    /// The material of each grain, as its place among the components: as many of each as its share of so many grains comes to
    /// (by the largest remainders), in an order drawn from the seed. Empty without materials.
    pub fn assign(&self, grains: usize, seed: u64) -> Vec<u8> {
        if self.is_empty() {
            return Vec::new();
        }
        let wanted = |component: &Component| component.share * grains as f64;
        let mut counts: Vec<usize> = self.components.iter().map(|c| wanted(c).floor() as usize).collect();
        let mut by_remainder: Vec<usize> = (0..counts.len()).collect();
        // Equal remainders are ordered by name: the components are in this order, and the sort is stable.
        by_remainder.sort_by(|&a, &b| {
            let rest = |k: usize| wanted(&self.components[k]).fract();
            rest(b).total_cmp(&rest(a))
        });
        let missing = grains.saturating_sub(counts.iter().sum());
        for &k in by_remainder.iter().cycle().take(missing) {
            counts[k] += 1;
        }
        let each = counts.iter().enumerate().flat_map(|(k, count)| std::iter::repeat_n(k as u8, *count));
        let mut materials: Vec<u8> = each.take(grains).collect();
        // A stream of its own: the places of the grains are those of one material.
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(1);
        for k in (1..materials.len()).rev() {
            let other = (rng.next_u64() % (k as u64 + 1)) as usize;
            materials.swap(k, other);
        }
        materials
    }

    /// The same materials, all with one coefficient of friction and one interface energy, also between different ones.
    pub fn with_surface(&self, friction: f64, interface_energy: f64) -> Mixture {
        let mut mixture = self.clone();
        for component in &mut mixture.components {
            component.material = Material { friction, interface_energy, ..component.material };
        }
        for rule in &mut mixture.pairs {
            (rule.friction, rule.interface_energy) = (None, None);
        }
        mixture
    }

    /// The same materials with densities multiplied by a factor.
    pub fn with_densities(&self, factor: f64) -> Mixture {
        let mut mixture = self.clone();
        mixture.components.iter_mut().for_each(|component| component.material.density *= factor);
        mixture
    }

    /// Refuses inconsistent names, shares and rules, and impossible values.
    ///
    /// # Errors
    /// The first violation that is found.
    pub fn check(&self, contact: &ContactModel) -> Result<(), MixtureError> {
        if self.is_empty() && self.pairs.is_empty() {
            return Ok(());
        }
        if self.components.len() > MOST_MATERIALS {
            return Err(MixtureError::TooMany(self.components.len()));
        }
        let names = || self.components.iter().map(|component| component.name.as_str());
        for (k, component) in self.components.iter().enumerate() {
            if component.name.is_empty() {
                return Err(MixtureError::NoName);
            }
            if names().take(k).any(|name| name == component.name) {
                return Err(MixtureError::NameTwice(component.name.clone()));
            }
            component.material.check().map_err(|(name, value, right)| MixtureError::Property {
                of: format!("the material {:?}", component.name),
                name,
                value,
                right,
            })?;
        }
        let sum: f64 = self.components.iter().map(|component| component.share).sum();
        let positive = self.components.iter().all(|component| component.share > 0.0);
        if !(positive && (sum - 1.0).abs() <= ROUNDING) {
            return Err(MixtureError::Shares(sum));
        }
        for (k, rule) in self.pairs.iter().enumerate() {
            if let Some(name) = rule.between.iter().find(|name| self.position(name).is_none()) {
                let known = names().collect::<Vec<_>>().join(", ");
                return Err(MixtureError::UnknownName { name: name.clone(), known });
            }
            let [a, b] = &rule.between;
            if self.pairs[..k].iter().any(|other| other.between == [a, b].map(String::clone))
                || self.pairs[..k].iter().any(|other| other.between == [b, a].map(String::clone))
            {
                return Err(MixtureError::PairTwice(a.clone(), b.clone()));
            }
            for (name, value) in [("friction", rule.friction), ("interface_energy", rule.interface_energy)] {
                if let Some(value) = value.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                    let of = format!("the pair of {a:?} and {b:?}");
                    return Err(MixtureError::Property { of, name, value, right: "zero or positive" });
                }
            }
        }
        self.check_parameters(contact)
    }

    fn check_parameters(&self, contact: &ContactModel) -> Result<(), MixtureError> {
        let components = self.components.iter().map(|c| (format!("the material {:?}", c.name), c.parameters));
        let pairs = self.pairs.iter().map(|rule| {
            let [a, b] = &rule.between;
            (format!("the pair of {a:?} and {b:?}"), rule.parameters)
        });
        for (of, parameters) in components.chain(pairs) {
            check(&ContactModel { parameters, ..*contact })
                .map_err(|error| MixtureError::Law { of, error })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{NormalKind, TangentialKind};

    fn hertz() -> ContactModel {
        ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1)
    }

    fn two(shares: [f64; 2]) -> Mixture {
        let material = Material { interface_energy: 0.0, ..Material::default() };
        Mixture::new([
            Component::new("soft", shares[0], Material { youngs_modulus: 3e9, ..material }),
            Component::new("hard", shares[1], material),
        ])
    }

    #[test]
    fn numbers_of_grains_are_exact_and_the_order_of_naming_does_not_matter() {
        let count = |of: &[u8], k: u8| of.iter().filter(|m| **m == k).count();
        for (shares, grains, wanted) in [([0.3, 0.7], 10, 3), ([0.5, 0.5], 7, 3), ([0.001, 0.999], 100, 0)] {
            let drawn = two(shares).assign(grains, 5);
            // By name "hard" comes first: "soft" is 1.
            assert_eq!((count(&drawn, 1), drawn.len()), (wanted, grains), "{shares:?}");
        }
        let [mut a, b] = [two([0.3, 0.7]), two([0.3, 0.7])];
        a.components.reverse();
        a.sort();
        assert_eq!(a.assign(100, 7), b.assign(100, 7));
        assert_ne!(b.assign(100, 7), b.assign(100, 8));
        assert!(Mixture::default().assign(5, 1).is_empty());
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let said = |mixture: &Mixture| mixture.check(&hertz()).unwrap_err().to_string();
        assert_eq!(
            said(&two([0.5, 0.4])),
            "the shares of the materials sum to 0.9; they must be positive and sum to 1"
        );
        let mut twice = two([0.5, 0.5]);
        twice.components[1].name = "hard".into();
        assert!(said(&twice).contains("two materials are called \"hard\""));
        let rule = PairRule { between: ["hard".into(), "sott".into()], ..PairRule::default() };
        assert!(
            said(&two([0.5, 0.5]).with_pair(rule))
                .contains("\"sott\", which does not exist; there are hard, soft")
        );
        let mut bad = two([0.5, 0.5]);
        bad.components[0].material.density = 0.0;
        assert_eq!(said(&bad), "density of the material \"hard\" is 0; it must be positive");
        let mut unused = two([0.5, 0.5]);
        unused.components[0].parameters.set("rolling_friction", 0.1).unwrap();
        assert!(said(&unused).contains("the material \"hard\": contact.rolling_friction has no effect"));
    }
}
