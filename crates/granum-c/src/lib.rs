//! Material points of granum for programs in C, C++ and Fortran.
//!
//! [`point_functions`], [`state_functions`] and [`store_functions`] are the C interface of `include/granum.h`: opaque handles, an error
//! code from each function, and a message for each error. [`umat`](mod@umat) and [`user_mod`](mod@user_mod) are the interfaces of user materials of Abaqus and PLAXIS,
//! which other finite-element programs call as well; `host/` knows what their conventions are. No panic of Rust crosses into the caller.
//!
//! In the C interface compression is positive and stresses are in pascals, in the order xx, yy, zz, yz, zx, xy with shear strains as
//! angles, as in all of granum. In the two interfaces of user materials tension is positive and the order is that of the host.
#![allow(
    clippy::missing_safety_doc,
    reason = "the contract of all functions is one: pointers are valid for what they stand for, or null where it says so"
)]

mod failure;
pub mod host;
pub mod point_functions;
pub mod point_handles;
pub mod state_functions;
pub mod store_functions;
pub mod umat;
pub mod user_mod;
