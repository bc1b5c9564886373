//! Which laws can be used together, and which parameters they then have.

use super::contact_model::ContactModel;
pub use super::contact_model::parameters_of;
use super::law_error::LawError;
use super::registry::{ADHESION, Laws, NORMAL, ROLLING, TANGENTIAL};
use crate::contact::law::NormalTraits;

/// The normal laws of which this holds, as a continuation of "it can be combined with".
fn normal_laws_with(laws: &Laws, holds: impl Fn(&NormalTraits) -> bool) -> String {
    let laws = laws.normal().iter().filter(|law| holds(&law.law().traits()));
    let names: Vec<String> = laws.map(|law| format!("{:?}", law.name())).collect();
    match names.is_empty() {
        true => "no normal law".into(),
        false => format!("contact.normal = {}", names.join(" or ")),
    }
}

/// Every set of granum's own laws that can be used together.
pub fn sets() -> Vec<ContactModel> {
    let mut sets = Vec::new();
    for normal in NORMAL {
        for tangential in TANGENTIAL {
            for rolling in ROLLING {
                for adhesion in ADHESION {
                    let plain = ContactModel::new(*normal, *tangential, 0.1);
                    let set = ContactModel { rolling: *rolling, adhesion: *adhesion, ..plain };
                    if check(&set).is_ok() {
                        sets.push(set);
                    }
                }
            }
        }
    }
    sets
}

/// Rejects laws that cannot be combined, and parameters that they do not have or that are out of bounds.
///
/// # Errors
/// The first violation that is found; what is suggested is one of granum's own laws.
pub fn check(contact: &ContactModel) -> Result<(), LawError> {
    check_among(contact, &Laws::standard())
}

/// The same as [`check`], where any of these laws can be suggested.
///
/// # Errors
/// The first violation that is found.
pub fn check_among(contact: &ContactModel, laws: &Laws) -> Result<(), LawError> {
    let traits = contact.normal.law().traits();
    let (tangential, adhesion) = (contact.tangential.law(), contact.adhesion.law());
    tangential.goes_with(&traits).map_err(|reason| LawError::Apart {
        slot: "tangential",
        law: contact.tangential.name(),
        reason,
        normal_laws: normal_laws_with(laws, |traits| tangential.goes_with(traits).is_ok()),
    })?;
    adhesion.goes_with(&traits).map_err(|reason| LawError::Apart {
        slot: "adhesion",
        law: contact.adhesion.name(),
        reason,
        normal_laws: normal_laws_with(laws, |traits| adhesion.goes_with(traits).is_ok()),
    })?;
    let used = parameters_of(contact);
    for (key, value) in contact.parameters.iter() {
        let Some(parameter) = used.iter().find(|p| p.key == key) else {
            let mut chosen = format!(
                "contact.normal = {:?}, contact.tangential = {:?} and contact.rolling = {:?}",
                contact.normal.name(),
                contact.tangential.name(),
                contact.rolling.name()
            );
            if contact.adhesion.law().acts() {
                let others = chosen.replace(" and ", ", ");
                chosen = format!("{others} and contact.adhesion = {:?}", contact.adhesion.name());
            }
            return Err(LawError::Unused { key, laws: chosen });
        };
        let [low, high] = parameter.bounds;
        if !(value >= low && value <= high) {
            return Err(LawError::OutOfBounds { key, value, low, high, unit: parameter.unit.symbol });
        }
    }
    Ok(())
}
