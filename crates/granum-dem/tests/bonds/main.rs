//! Bonds in the engine: single bonds up to rupture, vibrations, cement that sets under a load, energies, the same bits on threads and after a
//! restart in the middle of a cascade, and what users of other programs ran into.

mod packings;
mod samples;
mod single;
mod time_step;
