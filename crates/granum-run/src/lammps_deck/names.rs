//! The files in the folder of a deck.

/// Name of the script in the folder of a deck.
pub const SCRIPT: &str = "in.granum";
/// Name of the sample.
pub const DATA: &str = "packing.data";
/// Name of the curve that the script writes.
pub const CURVE: &str = "curve.csv";
/// Of grains of several pieces: masses, centres and inertia; the weights of the pieces; these times the masses.
pub(super) const BODIES: &str = "bodies.txt";
pub(super) const WEIGHTS: &str = "weights.txt";
pub(super) const SHARES: &str = "shares.txt";

/// How stiff and how strong bonds are.
pub(super) const BONDS: &str = "bonds.txt";

/// The lines that a deck writes for the program that follows it.
pub(crate) const EVENTS: &str = "events";
/// What the program asks for.
pub(crate) const REQUEST: &str = "request";
/// The commands that write a restart file.
pub(crate) const SAVE: &str = "save.granum";
/// The beginnings of the names of restart files, of the numbers beside them, and of the dumps of grains and contacts; the number of the
/// step follows.
pub(crate) const RESTART: &str = "restart.";
pub(crate) const STATE: &str = "state.";
pub(crate) const GRAINS: &str = "grains.";
pub(crate) const CONTACTS: &str = "contacts.";
