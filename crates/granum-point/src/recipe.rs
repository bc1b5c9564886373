//! What is done to a state: from the state and the recipe follows the next state, bit by bit.

use granum_core::digest::Digest;
use granum_core::geometry::Matrix;

use crate::identity::Identity;
use crate::increment::Increment;

/// What is done to a state. From the state and the recipe follows the next state, bit by bit ([`crate::MaterialPoint::follow`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Recipe {
    /// It is deformed.
    Advance(Increment),
    /// It is brought to a stress, Pa, in the axes of space.
    Impose(Matrix),
}

impl Recipe {
    /// The identity of the state that follows from another.
    pub(crate) fn follows(&self, from: &Identity) -> Identity {
        let mut digest = Digest::new();
        digest.bytes(from.bytes());
        match self {
            Recipe::Advance(increment) => {
                digest.text("advance");
                increment.digest(&mut digest);
            }
            Recipe::Impose(stress) => {
                digest.text("impose");
                let flat: Vec<f64> = stress.iter().flatten().copied().collect();
                digest.numbers(&flat);
            }
        }
        Identity::new(digest)
    }
}
