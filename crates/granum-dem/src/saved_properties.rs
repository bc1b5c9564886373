//! The properties of a simulation as a checkpoint has them: laws and parameters by name, until they are found among the laws
//! of the program that reads it.

use std::collections::BTreeMap;

use serde::Deserialize;

use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::kind::{AdhesionKind, NormalKind, RollingKind, TangentialKind};
use crate::contact::choice::parameters::ParameterValues;
use crate::contact::choice::registry::{Laws, unknown};
use crate::material::Material;
use crate::mixture::{Component, Mixture, PairRule};
use crate::properties::Properties;

type Values = BTreeMap<String, f64>;

/// [`Properties`], with names in the places of laws. The layout is that in which `Properties` are written.
#[derive(Deserialize)]
pub(crate) struct SavedProperties {
    material: Material,
    contact: SavedContact,
    mixture: SavedMixture,
}

/// [`ContactModel`]: normal law, tangential law, law of moments, law of adhesion, damping, parameters.
#[derive(Deserialize)]
struct SavedContact(String, String, String, String, f64, Values);

/// [`Mixture`].
#[derive(Deserialize)]
struct SavedMixture {
    components: Vec<SavedComponent>,
    pairs: Vec<SavedPair>,
    seed: u64,
}

/// [`Component`].
#[derive(Deserialize)]
struct SavedComponent {
    name: String,
    share: f64,
    material: Material,
    parameters: Values,
}

/// [`PairRule`].
#[derive(Deserialize)]
struct SavedPair {
    between: [String; 2],
    friction: Option<f64>,
    interface_energy: Option<f64>,
    parameters: Values,
}

impl SavedProperties {
    /// The properties, if all laws and parameters are known.
    pub(crate) fn among(self, laws: &Laws) -> Result<Properties, String> {
        let contact = self.contact.among(laws)?;
        let mut mixture = Mixture::default();
        mixture.seed = self.mixture.seed;
        for SavedComponent { name, share, material, parameters } in self.mixture.components {
            let parameters = ParameterValues::named(&parameters, laws)?;
            mixture.components.push(Component { name, share, material, parameters });
        }
        for SavedPair { between, friction, interface_energy, parameters } in self.mixture.pairs {
            let parameters = ParameterValues::named(&parameters, laws)?;
            mixture.pairs.push(PairRule { between, friction, interface_energy, parameters });
        }
        let mut properties = Properties::new(self.material, contact);
        properties.mixture = mixture;
        Ok(properties)
    }
}

impl SavedContact {
    fn among(self, laws: &Laws) -> Result<ContactModel, String> {
        let SavedContact(normal, tangential, rolling, adhesion, damping, parameters) = self;
        let missing =
            |what: &str, name: &str, known: Vec<&'static str>| unknown(what, name, known.into_iter());
        Ok(ContactModel {
            normal: laws.normal_named(&normal).ok_or_else(|| {
                missing("normal law", &normal, laws.normal().iter().map(NormalKind::name).collect())
            })?,
            tangential: laws.tangential_named(&tangential).ok_or_else(|| {
                let known = laws.tangential().iter().map(TangentialKind::name).collect();
                missing("tangential law", &tangential, known)
            })?,
            rolling: laws.rolling_named(&rolling).ok_or_else(|| {
                missing("law of moments", &rolling, laws.rolling().iter().map(RollingKind::name).collect())
            })?,
            adhesion: laws.adhesion_named(&adhesion).ok_or_else(|| {
                let known = laws.adhesion().iter().map(AdhesionKind::name).collect();
                missing("law of adhesion", &adhesion, known)
            })?,
            damping,
            parameters: ParameterValues::named(&parameters, laws)?,
        })
    }
}
