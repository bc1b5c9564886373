//! LAMMPS as an engine: granum prepares the sample, LAMMPS tests it, granum records what it finds.
//!
//! ```text
//! sample (granum) --> deck --> lmp --> events and dumps --> recorder --> run folder
//! ```
//!
//! The [deck](crate::lammps_deck) is run in the folder `lammps` of the run. It tells how far it is in the file `events`, and writes
//! all grains and contacts at the end of each row; the recorder observes those that are due, and they are removed. A file `request`
//! asks it to write a restart file or to stop. With each restart file the state of the recorder is written, so that a run goes on
//! from there, with what LAMMPS did until it ended if this process was killed before it.

mod events;
mod frame;
mod lammps_engine;
mod place;
mod program;
mod progress;
mod quality;
mod reading;
mod reasons;
mod run;
mod start;
mod unknown;

pub use lammps_engine::Lammps;
pub use program::NAME as LAMMPS;
pub use start::LammpsStart;
