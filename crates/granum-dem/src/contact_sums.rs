//! Sums over contacts, which the stages of a step collect.

use granum_core::energy::MechanismEnergies;
use serde::{Deserialize, Serialize};

use crate::contact::law::energy_channel::{LAWS, SetEnergies};
use crate::contact::law::limits::LAW_CHANNELS;

/// Sums over the contacts of a block (or of all blocks).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub struct ContactSums {
    /// `- sum of (elastic force on i)_a (branch)_b`, J: the stress times the volume.
    pub virial: [f64; 9],
    /// Energy by mechanism in this step, J.
    pub mechanisms: MechanismEnergies,
    /// Energies in the channels of the laws in this step, J. A checkpoint has the first only: the ledger has them all.
    #[serde(with = "first_channel")]
    pub channels: SetEnergies<f64>,
    /// Power that the deformation of the cell supplies to the contacts, W.
    pub boundary_power: f64,
    /// `sum of k_n D^2`, J.
    pub stiffness: f64,
    /// `sum of |N|` of the elastic normal forces, N.
    pub normal_force: f64,
    /// Largest `k_t / m` of a contact, with the smaller mass of the two, 1/s2.
    pub fastest: f64,
}

/// The first channel of the normal law, as a number.
mod first_channel {
    use super::{Deserialize, LAW_CHANNELS, LAWS, Serialize, SetEnergies};
    use serde::{Deserializer, Serializer};

    pub(super) fn serialize<S: Serializer>(channels: &SetEnergies<f64>, to: S) -> Result<S::Ok, S::Error> {
        channels[0][0].serialize(to)
    }

    pub(super) fn deserialize<'d, D: Deserializer<'d>>(from: D) -> Result<SetEnergies<f64>, D::Error> {
        let mut channels = [[0.0; LAW_CHANNELS]; LAWS];
        channels[0][0] = f64::deserialize(from)?;
        Ok(channels)
    }
}

impl ContactSums {
    /// Total of the sums of blocks, added in the order of the blocks.
    pub(crate) fn total(blocks: &[ContactSums]) -> ContactSums {
        let mut t = ContactSums::default();
        for c in blocks {
            for a in 0..9 {
                t.virial[a] += c.virial[a];
            }
            t.mechanisms.add(&c.mechanisms);
            for (to, from) in t.channels.iter_mut().flatten().zip(c.channels.iter().flatten()) {
                *to += from;
            }
            t.boundary_power += c.boundary_power;
            t.stiffness += c.stiffness;
            t.normal_force += c.normal_force;
            t.fastest = t.fastest.max(c.fastest);
        }
        t
    }
}
