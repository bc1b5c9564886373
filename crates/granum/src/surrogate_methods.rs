//! The methods of surrogates that this program knows.

use granum_antony2006::MappingMethod;
use granum_learn::networks::NetworkSettings;
use granum_learn::{Result, SurrogateMethods};

/// The methods of the library, and that of the paper.
pub fn surrogate_methods() -> SurrogateMethods {
    SurrogateMethods::standard().with(MappingMethod::default())
}

/// The same methods with the given settings of their networks.
///
/// # Errors
/// If there is no trainer of the given name.
pub fn surrogate_methods_with(settings: &NetworkSettings) -> Result<SurrogateMethods> {
    Ok(SurrogateMethods::with_networks(settings)?.with(MappingMethod::with_networks(settings)?))
}
