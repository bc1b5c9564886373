//! Physical properties of whole samples that are small enough for a test. `VALIDATION.md` lists them.

mod elastic;
mod energy;
mod lammps;
mod sample;
mod symmetry;
mod time_step;
mod two_ways;
