//! The properties of the grains of a simulation and of their contacts: one or several materials, and a contact law.

use serde::Serialize;

use crate::config::{Grains, Mixture, Preparation};
use crate::contact::choice::check::check;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::kind::{NormalKind, RollingKind};
use crate::contact::law::pair_properties::PairProperties;
use crate::material::Material;
use crate::mixture::MixtureError;
use crate::pair_table::{MaterialPair, PairTable};
use crate::simulation_error::SimulationError;

/// Key of the coefficient of rolling friction.
const ROLLING_FRICTION: &str = "rolling_friction";

/// Material of the grains and their contact laws.
///
/// ```
/// use granum_dem::config::{ContactModel, Material};
/// use granum_dem::simulation::Properties;
///
/// let properties = Properties::new(Material::default(), ContactModel::default());
/// assert!(properties.mixture.is_empty());
/// assert_eq!(properties.with_surface(0.1, 0.0).material.friction, 0.1);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Properties {
    /// Properties of the solid and its surface, if there is one material.
    pub material: Material,
    /// Contact law.
    pub contact: ContactModel,
    /// Several materials, which replace the one; empty if there is one material.
    pub mixture: Mixture,
}

/// Largest distance at which adhesion may still hold two spheres, over their radius: the theory is limited to small
/// contacts.
pub const LARGEST_REACH: f64 = 0.5;

impl Properties {
    /// One material and a contact law.
    pub fn new(material: Material, contact: ContactModel) -> Properties {
        Properties { material, contact, mixture: Mixture::default() }
    }

    /// Those of grains that may be of several materials, with a contact law; which grain is of which is drawn from the seed.
    pub fn for_grains(grains: &Grains, contact: &ContactModel, seed: u64) -> Properties {
        Properties {
            material: grains.material,
            contact: contact.with_all_parameters(),
            mixture: grains.mixture.clone().with_seed(seed),
        }
    }

    /// The same with several materials in place of the one.
    pub fn with_mixture(mut self, mixture: Mixture) -> Properties {
        self.mixture = mixture;
        self.mixture.sort();
        self
    }

    /// The same with one coefficient of friction and one interface energy for all contacts.
    pub fn with_surface(&self, friction: f64, interface_energy: f64) -> Properties {
        Properties {
            material: Material { friction, interface_energy, ..self.material },
            contact: self.contact,
            mixture: self.mixture.with_surface(friction, interface_energy),
        }
    }

    /// The properties during compaction with a coefficient of friction: with the interface energy of a preparation, for which
    /// contacts that have none by their law (`hertz`) follow JKR, and with its rolling friction.
    pub fn while_compacting(&self, preparation: &Preparation, friction: f64) -> Properties {
        let mut properties = self.with_surface(friction, preparation.interface_energy);
        let contact = &mut properties.contact;
        if preparation.interface_energy > 0.0 && contact.normal == NormalKind::HERTZ {
            contact.normal = NormalKind::JKR;
        }
        let Some(rolling_friction) = preparation.rolling_friction else { return properties };
        if contact.rolling == RollingKind::NONE {
            contact.rolling = RollingKind::ELASTIC_PLASTIC;
        }
        // A key of a law of granum; there is room for the parameters of all laws.
        let _ = contact.parameters.set(ROLLING_FRICTION, rolling_friction);
        for component in &mut properties.mixture.components {
            component.parameters.unset(ROLLING_FRICTION);
        }
        for rule in &mut properties.mixture.pairs {
            rule.parameters.unset(ROLLING_FRICTION);
        }
        properties
    }

    /// The same with the densities of all grains multiplied by a factor.
    pub fn with_densities(&self, factor: f64) -> Properties {
        Properties {
            material: Material { density: self.material.density * factor, ..self.material },
            contact: self.contact,
            mixture: self.mixture.with_densities(factor),
        }
    }

    /// The properties of two spheres of named materials and given radii, m.
    ///
    /// # Errors
    /// If there is no such material.
    pub fn pair(&self, names: [&str; 2], radii: [f64; 2]) -> Result<PairProperties, MixtureError> {
        let mut places = [0u8; 2];
        for (place, name) in places.iter_mut().zip(names) {
            let known = self.mixture.components.iter().map(|component| component.name.as_str());
            let found = self.mixture.position(name).ok_or_else(|| MixtureError::UnknownName {
                name: name.to_string(),
                known: known.collect::<Vec<_>>().join(", "),
            })?;
            *place = found as u8;
        }
        Ok(self.table().between(places[0], places[1]).pair(radii))
    }

    /// True if an interface energy attracts any two grains.
    pub(crate) fn attracts(&self) -> bool {
        let mixture = &self.mixture;
        let of_one = mixture.is_empty() && self.material.interface_energy > 0.0;
        let of_component = mixture.components.iter().any(|c| c.material.interface_energy > 0.0);
        of_one
            || of_component
            || mixture.pairs.iter().any(|rule| rule.interface_energy.is_some_and(|g| g > 0.0))
    }

    /// The properties of contacts between any two materials.
    pub(crate) fn table(&self) -> PairTable {
        PairTable::new(&self.material, &self.contact, &self.mixture)
    }

    /// Density of the grains of a material, or of all grains if there is one material, kg/m3.
    pub(crate) fn density_of(&self, material: Option<u8>) -> f64 {
        let component = material.and_then(|k| self.mixture.components.get(k as usize));
        component.map_or(self.material.density, |component| component.material.density)
    }

    /// Isotropic stress, Pa, at which grains of a diameter, m, overlap by a share of it, estimated from a contact that carries
    /// `p d^2`: of the softest materials `F(share d) / d^2`, where F is the force of a first loading. Without a positive force, as where
    /// adhesion outweighs it, infinite.
    ///
    /// # Errors
    /// If the laws cannot be combined.
    pub fn stress_at_overlap(&self, diameter: f64, share: f64) -> Result<f64, SimulationError> {
        check(&self.contact)?;
        let force = |common: &MaterialPair| {
            let constants = common.contact.constants(&common.pair([0.5 * diameter; 2]));
            common.contact.normal_contact(&constants, share * diameter).force
        };
        let table = self.table();
        let least = table.all().iter().map(force).filter(|force| *force > 0.0).fold(f64::INFINITY, f64::min);
        Ok(least / (diameter * diameter))
    }

    /// Largest gap at which two equal spheres that have touched separate, m: zero without adhesion.
    ///
    /// # Errors
    /// If the laws cannot be combined.
    pub fn adhesion_reach(&self, radius: f64) -> Result<f64, SimulationError> {
        check(&self.contact)?;
        let mut largest = 0.0;
        for common in self.table().all() {
            let constants = common.contact.constants(&common.pair([radius; 2]));
            let reach = -common.contact.breaking_overlap(&constants);
            // NaN must not pass.
            if reach.is_nan() || reach > largest {
                largest = reach;
            }
            if reach.is_nan() {
                break;
            }
        }
        Ok(largest)
    }
}

/// Refuses an assignment of grains to materials that do not exist.
pub(crate) fn check_assignment(
    materials: &[u8],
    grains: usize,
    mixture: &Mixture,
) -> Result<(), SimulationError> {
    let kinds = mixture.components.len();
    let wanted = if kinds == 0 { 0 } else { grains };
    let wrong = |what: String| Err(SimulationError::Assignment { what });
    if materials.len() != wanted {
        return wrong(format!(
            "materials are given for {} grains, but there are {grains} grains and {kinds} materials; each grain needs \
             one",
            materials.len()
        ));
    }
    match materials.iter().find(|k| **k as usize >= kinds) {
        Some(k) => wrong(format!(
            "a grain has the material index {k}, but there are {kinds} materials, counted from \
                                  0"
        )),
        None => Ok(()),
    }
}

/// Rejects laws that cannot be combined, an impossible material, and adhesion beyond the range of the theory.
pub(crate) fn check_properties(properties: &Properties, radius: f64) -> Result<(), SimulationError> {
    properties.material.check().map_err(|(name, value, right)| SimulationError::Material {
        name,
        value,
        right,
    })?;
    check(&properties.contact)?;
    properties.mixture.check(&properties.contact)?;
    let reach = properties.adhesion_reach(radius)?;
    if reach.is_nan() || reach > LARGEST_REACH * radius {
        return Err(SimulationError::Adhesion { radius, reach });
    }
    Ok(())
}
