//! The energy balance of a phase, to which every step adds.

use std::collections::BTreeMap;

use granum_core::energy::MechanismEnergies;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::assembly::EnergyBalance;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::law::energy_channel::SetEnergies;
use crate::contact_sums::ContactSums;

/// Energies since the start of a phase, J.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Ledger {
    /// The energies that every simulation has.
    pub(crate) balance: EnergyBalance,
    /// The energies in the channels of the laws.
    pub(crate) channels: SetEnergies<f64>,
}

impl Ledger {
    /// Adds the work and the losses of a step of length `dt`, s.
    pub(crate) fn add(&mut self, dt: f64, sums: &ContactSums) {
        self.balance.boundary_work += 0.5 * dt * sums.boundary_power;
        self.balance.add(&sums.mechanisms);
        for (total, energy) in self.channels.iter_mut().flatten().zip(sums.channels.iter().flatten()) {
            *total += energy;
        }
    }

    /// The balance with the channels of the laws by their keys.
    pub(crate) fn named(&self, laws: &ContactModel) -> EnergyBalance {
        let mut channels = BTreeMap::new();
        for (declared, energies) in laws.channels().into_iter().zip(&self.channels) {
            for (channel, energy) in declared.iter().zip(energies) {
                // Two laws of a set can share a channel.
                if *energy != 0.0 {
                    *channels.entry(channel.key.to_string()).or_insert(0.0) += energy;
                }
            }
        }
        EnergyBalance { channels, ..self.balance.clone() }
    }

    /// The channels if they contain more than the row of numbers that [`Ledger::serialize`] writes.
    pub(crate) fn further_channels(&self) -> Option<&SetEnergies<f64>> {
        self.channels.iter().flatten().skip(1).any(|energy| *energy != 0.0).then_some(&self.channels)
    }
}

/// Rows of numbers: a checkpoint has no field names, so that no field can be omitted. Of the channels they contain the first one of
/// the normal law; a checkpoint has the others at its end, if there are any. The order is that of the mechanisms, but that the loss of
/// attractions comes before the channel, and couples last.
impl Serialize for Ledger {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let MechanismEnergies {
            tangential_work,
            friction,
            micro_slip,
            damping,
            adhesion_made,
            adhesion_broken,
            rolling_work,
            rolling,
            attraction_loss,
        } = self.balance.mechanisms();
        let first = self.channels[0][0];
        let lost = [friction, micro_slip, damping, adhesion_made, adhesion_broken, attraction_loss, first];
        ([self.balance.boundary_work, tangential_work], lost, [rolling_work, rolling]).serialize(to)
    }
}

impl<'d> Deserialize<'d> for Ledger {
    fn deserialize<D: Deserializer<'d>>(from: D) -> Result<Ledger, D::Error> {
        let ([boundary_work, tangential_work], lost, [rolling_work, rolling]) =
            <([f64; 2], [f64; 7], [f64; 2])>::deserialize(from)?;
        let [friction, micro_slip, damping, adhesion_made, adhesion_broken, attraction_loss, first] = lost;
        let mut ledger = Ledger::default();
        ledger.balance.boundary_work = boundary_work;
        ledger.balance.add(&MechanismEnergies {
            tangential_work,
            friction,
            micro_slip,
            damping,
            adhesion_made,
            adhesion_broken,
            rolling_work,
            rolling,
            attraction_loss,
        });
        ledger.channels[0][0] = first;
        Ok(ledger)
    }
}
