//! What grains of any two materials have in common: the properties of their contacts that do not depend on the radii.

use crate::contact::choice::check::parameters_of;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::parameters::ParameterValues;
use crate::contact::law::description::Mixing;
use crate::contact::law::pair_properties::PairProperties;
use crate::material::Material;
use crate::mixture::{Component, Mixture};

/// The properties of contacts between two materials that do not depend on the radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MaterialPair {
    pub(crate) materials: [Material; 2],
    friction: f64,
    interface_energy: f64,
    /// The laws with the parameters of the pair.
    pub(crate) contact: ContactModel,
}

impl MaterialPair {
    /// What grains of two components have in common.
    fn new(contact: &ContactModel, mixture: &Mixture, a: usize, b: usize) -> MaterialPair {
        let (x, y) = (&mixture.components[a], &mixture.components[b]);
        let rule = mixture.rule(&x.name, &y.name);
        let mut parameters = ParameterValues::NONE;
        for parameter in parameters_of(contact) {
            let of = |own: &Component| {
                own.parameters.given(parameter.key).unwrap_or_else(|| contact.parameters.value(parameter))
            };
            let value = rule
                .and_then(|rule| rule.parameters.given(parameter.key))
                .unwrap_or_else(|| parameter.mixing.mix(of(x), of(y)));
            // There is room for all parameters that laws have.
            let _ = parameters.set(parameter.key, value);
        }
        let mixed = |of: fn(&Material) -> f64| Mixing::Geometric.mix(of(&x.material), of(&y.material));
        MaterialPair {
            materials: [x.material, y.material],
            friction: rule.and_then(|rule| rule.friction).unwrap_or_else(|| mixed(|m| m.friction)),
            interface_energy: rule
                .and_then(|rule| rule.interface_energy)
                .unwrap_or_else(|| mixed(|m| m.interface_energy)),
            contact: ContactModel { parameters, ..*contact },
        }
    }

    /// The properties of a pair of such grains of given radii, m.
    pub(crate) fn pair(&self, radii: [f64; 2]) -> PairProperties {
        let [a, b] = &self.materials;
        let pair = PairProperties::new((a, radii[0]), (b, radii[1]), self.contact.damping);
        PairProperties { friction: self.friction, interface_energy: self.interface_energy, ..pair }
    }
}

/// What grains of any two materials of a simulation have in common.
#[derive(Clone, Debug)]
pub(crate) struct PairTable {
    count: usize,
    rows: Vec<MaterialPair>,
}

impl PairTable {
    /// Of one material or a mixture. Materials that are alike in everything are one.
    pub(crate) fn new(material: &Material, contact: &ContactModel, mixture: &Mixture) -> PairTable {
        let one =
            |material: &Material, contact: ContactModel, friction: f64, interface_energy: f64| PairTable {
                count: 1,
                rows: vec![MaterialPair { materials: [*material; 2], friction, interface_energy, contact }],
            };
        let count = mixture.components.len();
        if count == 0 {
            return one(material, *contact, material.friction, material.interface_energy);
        }
        let all = (0..count).flat_map(|a| (0..count).map(move |b| [a, b]));
        let rows: Vec<MaterialPair> = all.map(|[a, b]| MaterialPair::new(contact, mixture, a, b)).collect();
        if rows.iter().all(|row| *row == rows[0]) {
            return PairTable { count: 1, rows: vec![rows[0]] };
        }
        PairTable { count, rows }
    }

    /// True if there is one material, or several with equal properties.
    pub(crate) fn is_one(&self) -> bool {
        self.count == 1
    }

    /// What grains of two materials have in common.
    pub(crate) fn between(&self, a: u8, b: u8) -> &MaterialPair {
        let place = |material: u8| if self.count == 1 { 0 } else { material as usize };
        &self.rows[place(a) * self.count + place(b)]
    }

    /// Largest distance at which grains of a radius, m, act on each other without touching, m.
    pub(crate) fn range(&self, radius: f64) -> f64 {
        if !self.rows[0].contact.adhesion.law().acts() {
            return 0.0;
        }
        let range = |materials: &MaterialPair| {
            let constants = materials.contact.constants(&materials.pair([radius; 2]));
            materials.contact.range(&constants)
        };
        self.rows.iter().map(range).fold(0.0, f64::max)
    }

    /// Largest gap at which grains of a radius, m, that have touched separate, m.
    pub(crate) fn reach(&self, radius: f64) -> f64 {
        let reach = |materials: &MaterialPair| {
            let constants = materials.contact.constants(&materials.pair([radius; 2]));
            -materials.contact.breaking_overlap(&constants)
        };
        self.rows.iter().map(reach).fold(0.0, f64::max)
    }

    /// Of every pair of materials.
    pub(crate) fn all(&self) -> &[MaterialPair] {
        &self.rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{NormalKind, RollingKind, TangentialKind};
    use crate::mixture::{MixtureError, PairRule};

    fn hertz() -> ContactModel {
        ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1)
    }

    /// Glass on a polymer: `1/E* = sum of (1 - nu^2)/E`, friction and energy by geometric means.
    #[test]
    fn pairs_have_the_moduli_of_the_theory_and_mixed_surfaces() {
        let glass = Material { friction: 0.5, interface_energy: 0.6, ..Material::default() };
        let polymer = Material {
            youngs_modulus: 3e9,
            poissons_ratio: 0.35,
            friction: 0.2,
            interface_energy: 0.06,
            ..Material::default()
        };
        let mixture =
            Mixture::new([Component::new("glass", 0.5, glass), Component::new("polymer", 0.5, polymer)]);
        let contact = ContactModel { normal: NormalKind::JKR, ..hertz() };
        let table = PairTable::new(&glass, &contact, &mixture);
        for [a, b] in [[0, 1], [1, 0]] {
            let pair = table.between(a, b).pair([5e-5; 2]);
            assert!(
                (pair.effective_modulus / 3.2733224223e9 - 1.0).abs() < 1e-10,
                "{}",
                pair.effective_modulus
            );
            assert!((pair.effective_shear_modulus / 6.4593522192e8 - 1.0).abs() < 1e-10);
            assert!((pair.friction - 0.3162277660).abs() < 1e-10);
            assert!((pair.interface_energy - 0.1897366596).abs() < 1e-10);
            // k_t / k_n of a contact without slip.
            let ratio = 4.0 * pair.effective_shear_modulus / pair.effective_modulus;
            assert!((ratio - 0.7893328412).abs() < 1e-10, "{ratio}");
        }
        assert_eq!(
            table.between(0, 0).pair([5e-5; 2]),
            PairProperties::new((&glass, 5e-5), (&glass, 5e-5), 0.1)
        );
    }

    fn soft_and_hard() -> Mixture {
        let hard = Material { interface_energy: 0.0, ..Material::default() };
        let soft = Material { youngs_modulus: 3e9, ..hard };
        Mixture::new([Component::new("soft", 0.5, soft), Component::new("hard", 0.5, hard)])
    }

    #[test]
    fn rules_for_pairs_come_first() {
        let mut contact = hertz();
        contact.rolling = RollingKind::ELASTIC_PLASTIC;
        let mut mixture = soft_and_hard();
        mixture.components[0].parameters.set("rolling_friction", 0.4).unwrap();
        let mut rule =
            PairRule { between: ["soft".into(), "hard".into()], friction: Some(0.7), ..PairRule::default() };
        let of = |mixture: &Mixture| {
            let materials = *PairTable::new(&Material::default(), &contact, mixture).between(1, 0);
            (materials.friction, materials.contact.parameters.given("rolling_friction").unwrap())
        };
        // The root of 0.4 and of the default 0.1.
        assert_eq!(of(&mixture), (0.3, (0.4f64 * 0.1).sqrt()));
        rule.parameters.set("rolling_friction", 0.9).unwrap();
        let mixture = mixture.with_pair(rule.clone());
        assert_eq!(of(&mixture), (0.7, 0.9));
        mixture.check(&contact).unwrap();
        assert!(matches!(mixture.clone().with_pair(rule).check(&contact), Err(MixtureError::PairTwice(..))));
        assert_eq!(of(&mixture.with_surface(0.2, 0.0)).0, 0.2);
    }

    #[test]
    fn materials_that_are_alike_are_one() {
        let material = Material::default();
        let mixture = Mixture::new([Component::new("a", 0.5, material), Component::new("b", 0.5, material)]);
        assert!(PairTable::new(&material, &hertz(), &mixture).is_one());
        let rule = PairRule { between: ["a".into(), "b".into()], friction: Some(0.1), ..PairRule::default() };
        assert!(!PairTable::new(&material, &hertz(), &mixture.with_pair(rule)).is_one());
    }
}
