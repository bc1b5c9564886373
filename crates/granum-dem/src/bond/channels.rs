//! The energies of bonds, as channels of a balance.

use crate::contact::EnergyChannel;

/// What bonds lose: in their dashpots, and what was stored in those that ruptured by tension and by shear.
pub const BOND_CHANNELS: [EnergyChannel; 3] = [
    EnergyChannel::dissipated(
        "bond_damping_loss",
        "damping of bonds",
        "energy lost in the dashpots of bonds",
    ),
    EnergyChannel::dissipated(
        "bond_tension_loss",
        "bonds ruptured by tension",
        "energy that was stored in bonds that ruptured by tension",
    ),
    EnergyChannel::dissipated(
        "bond_shear_loss",
        "bonds ruptured by shear",
        "energy that was stored in bonds that ruptured by shear",
    ),
];
