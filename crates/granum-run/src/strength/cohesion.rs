//! Whether grains attract each other, so that their strength at zero stress is not zero.

use std::collections::BTreeMap;

use granum_dem::contact::AdhesionKind;
use granum_io::Case;
use granum_io::case::ParameterValue;

/// What a friction angle of cohesive grains is, and what says more.
pub const SECANT_REMARK: &str = "the grains attract each other: their friction angles are those of secants through the origin, which grow \
                                 as the stress falls; the envelope q = M p + c of tests at several stresses tells friction and cohesion \
                                 apart";

/// Name of the measure that says that grains attract each other.
pub const COHESIVE: &str = "cohesive";

/// Keys of what attracts grains by their normal law: an energy of their surfaces, or a stiffness of cohesion.
const ENERGY: &str = "interface_energy";
const COHESION: &str = "contact.cohesion_ratio";

/// True if the contact laws of a case make grains attract each other.
///
/// ```
/// use granum_io::Case;
/// use granum_run::strength::is_cohesive;
///
/// let grains = |text: &str| Case::parse(text, "case.toml");
/// assert!(is_cohesive(&grains("contact.normal = 'jkr'\ngrains.material.interface_energy = '10 mJ/m2'\n")?));
/// assert!(!is_cohesive(&grains("contact.normal = 'jkr'\ngrains.material.interface_energy = 0\n")?));
/// assert!(!is_cohesive(&grains("contact.normal = 'hertz'\ngrains.material.interface_energy = 0\n")?));
/// # Ok::<(), granum_io::Error>(())
/// ```
pub fn is_cohesive(case: &Case) -> bool {
    if case.contact.adhesion != AdhesionKind::NONE {
        return true;
    }
    if !case.contact.normal.law().traits().adhesive {
        return false;
    }
    let parameters = case.parameters();
    let positive = |value: &ParameterValue| matches!(value, ParameterValue::Number(number) if *number > 0.0);
    // A law that has a stiffness of cohesion does not use the energy of surfaces.
    match parameters.iter().find(|parameter| parameter.key == COHESION) {
        Some(parameter) => positive(&parameter.value),
        None => parameters.iter().any(|parameter| {
            let of_test = !parameter.key.starts_with("preparation.");
            of_test && parameter.key.ends_with(ENERGY) && positive(&parameter.value)
        }),
    }
}

/// The measure [`COHESIVE`] of a test of this case; nothing where grains do not attract each other.
pub fn cohesion_of(case: &Case) -> BTreeMap<String, f64> {
    if is_cohesive(case) { BTreeMap::from([(COHESIVE.to_owned(), 1.0)]) } else { BTreeMap::new() }
}
