//! A packing as what is known of it: grains that overlap touch, and with a case its contact law gives the forces.

use granum_core::{Part, Parts};
use granum_dem::config::{ContactModel, Material, NormalKind, TangentialKind};
use granum_dem::simulation::Properties;
use granum_io::formats::ObservedAssembly;
use granum_io::{Case, Packing};

use crate::engine::native::simulation;
use crate::task::laboratory_error::LaboratoryError;

/// What is known of a packing without a contact law.
const OF_PACKING: [Part; 5] = [Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::Overlaps];
/// What a contact law gives of grains without friction, along whose contacts nothing acts.
const WITHOUT_FRICTION: [Part; 4] =
    [Part::TangentialForces, Part::ResultantForces, Part::Sliding, Part::ContactEnergies];

/// The assembly of a packing, and what of it is known: places, radii, contacts and overlaps; with a case masses and normal forces as well,
/// and all forces if its grains have no friction. Of grains with friction the tangential forces depend on a history that a packing does
/// not have.
///
/// # Errors
/// As [`simulation`].
pub fn observed_packing(packing: &Packing, case: Option<&Case>) -> Result<ObservedAssembly, LaboratoryError> {
    let mut parts = Parts::new(&OF_PACKING);
    let properties = match case {
        Some(case) => {
            parts = parts.with(Part::Masses).with(Part::NormalForces);
            if case.grains.material.friction == 0.0 && case.grains.mixture.is_empty() {
                parts = WITHOUT_FRICTION.into_iter().fold(parts, Parts::with);
            }
            case.properties()
        }
        None => {
            let material = Material::default().with(|material| material.interface_energy = 0.0);
            Properties::new(material, ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1))
        }
    };
    let assembly = simulation(packing, properties)?.assembly();
    let mut found = ObservedAssembly::new(assembly, parts, packing.origin);
    (found.remarks, found.contacts_are_computed) = (packing.remarks.clone(), true);
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_io::packing::PackedGrain;

    /// Two grains of 1 mm whose overlap is 0.05 mm.
    fn pair() -> Packing {
        let grain = |id: u64, x: f64| (PackedGrain { id, position: [x, 5e-3, 5e-3], radius: 1e-3 }, 1);
        let cell = [[0.01, 0.0, 0.0], [0.0, 0.01, 0.0], [0.0, 0.0, 0.01]];
        Packing::checked("pair.csv", [0.0; 3], cell, vec![grain(1, 4e-3), grain(2, 5.95e-3)]).unwrap()
    }

    #[test]
    fn forces_are_known_with_a_case_and_all_of_them_without_friction() {
        let alone = observed_packing(&pair(), None).unwrap();
        assert_eq!(alone.assembly.contacts.len(), 1);
        assert!(alone.parts.has(Part::Overlaps) && !alone.parts.has(Part::NormalForces));
        let rough = observed_packing(&pair(), Some(&Case::default())).unwrap();
        assert!(rough.parts.has(Part::NormalForces) && !rough.parts.has(Part::TangentialForces));
        assert!(rough.assembly.contacts[0].normal_force > 0.0);
        let mut smooth = Case::default();
        smooth.grains.material.friction = 0.0;
        assert!(observed_packing(&pair(), Some(&smooth)).unwrap().parts.has(Part::Sliding));
    }
}
