//! The methods of surrogates that this program knows.

use granum_antony2006::MappingMethod;
use granum_learn::SurrogateMethods;

/// The methods of the library, and that of the paper.
pub fn surrogate_methods() -> SurrogateMethods {
    SurrogateMethods::standard().with(MappingMethod::default())
}
