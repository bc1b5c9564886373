//! Energy channels: energies that a law declares in addition to those which every law of its kind has, such as the energy lost by
//! plastic deformation.
//!
//! The engine adds up what a law puts into its channels. From the declaration follow the column of the series, the place in the
//! energy balance, and the name in reports.

use crate::contact::law::limits::LAW_CHANNELS;

/// What becomes of the energy in a channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EnergyFate {
    /// It is stored, and can be recovered.
    Stored,
    /// It is dissipated.
    Dissipated,
}

/// An energy channel of a law: energy that goes neither into the elastic energy of its contacts, nor into the losses that every
/// law of its kind has.
///
/// ```
/// use granum_dem::contact::{EnergyChannel, EnergyFate};
///
/// const LOST: EnergyChannel =
///     EnergyChannel::dissipated("crushing_loss", "crushing", "energy lost where asperities are crushed");
/// assert_eq!(LOST.fate, EnergyFate::Dissipated);
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub struct EnergyChannel {
    /// Name of its column in series: words in lower case, of which the last is `loss` where the energy is dissipated, and `energy`
    /// where it is stored.
    pub key: &'static str,
    /// Its name in reports, e.g. `plastic deformation`.
    pub label: &'static str,
    /// Its meaning, in a phrase that begins with "energy", e.g. `energy lost by plastic deformation of contacts`.
    pub meaning: &'static str,
    /// What becomes of the energy.
    pub fate: EnergyFate,
    /// Name of the sensor that measures it; the key unless it has another one.
    pub sensor: &'static str,
}

impl EnergyChannel {
    /// A channel of energy that is dissipated; the key ends with `_loss`.
    pub const fn dissipated(key: &'static str, label: &'static str, meaning: &'static str) -> EnergyChannel {
        EnergyChannel { key, label, meaning, fate: EnergyFate::Dissipated, sensor: key }
    }

    /// A channel of energy that is stored and can be recovered; the key ends with `_energy`.
    pub const fn stored(key: &'static str, label: &'static str, meaning: &'static str) -> EnergyChannel {
        EnergyChannel { key, label, meaning, fate: EnergyFate::Stored, sensor: key }
    }

    /// The same with another name of its sensor.
    pub(in crate::contact) const fn measured_by(self, sensor: &'static str) -> EnergyChannel {
        EnergyChannel { sensor, ..self }
    }

    /// True if the key has the form that it must have.
    pub(in crate::contact) fn has_good_key(&self) -> bool {
        let end = match self.fate {
            EnergyFate::Stored => "_energy",
            EnergyFate::Dissipated => "_loss",
        };
        let plain = |c: u8| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_';
        self.key.len() > end.len() && self.key.ends_with(end) && self.key.bytes().all(plain)
    }
}

/// Keys of energies that every simulation has, which no channel of a law can have.
pub const TAKEN_KEYS: [&str; 12] = [
    "kinetic_energy",
    "elastic_normal_energy",
    "elastic_tangential_energy",
    "elastic_rolling_energy",
    "attraction_energy",
    "friction_loss",
    "micro_slip_loss",
    "damping_loss",
    "adhesion_made_loss",
    "adhesion_broken_loss",
    "rolling_loss",
    "attraction_loss",
];

/// Energies that a law puts into its channels in a step, J, in the order of their declaration; zero at the call. For a stored energy
/// it is the change, which is negative where the energy is recovered.
pub type LawEnergies<R> = [R; LAW_CHANNELS];

/// Number of laws in a set: the normal, the tangential, the moment and the adhesion law, in this order.
pub const LAWS: usize = 4;

/// Energies in the channels of the laws of a set, in the order of the laws.
pub type SetEnergies<R> = [LawEnergies<R>; LAWS];

/// Number of channels of a law; one that declares more than there is room for is refused when it is compiled.
#[inline(always)]
pub(crate) const fn count(channels: &[EnergyChannel]) -> usize {
    assert!(channels.len() <= LAW_CHANNELS, "a law has more energy channels than LAW_CHANNELS");
    channels.len()
}
