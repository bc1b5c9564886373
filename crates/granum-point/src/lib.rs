//! A material point: a sample of grains, or a surrogate of one, that a program strains step by step, and that answers with stress, stiffness and sensors.
//!
//! ```text
//! State + Increment --> MaterialPoint --> Answer { State, stress, noise }
//! ```
//!
//! States are values ([`State`]): [`MaterialPoint::advance`] makes a new one and leaves the old one as it was. The same increment from
//! the same state gives the same bits, whatever was asked in between and on any number of threads. A [`Store`] keeps the states of many
//! points under numbers that a finite-element program can carry in its state variables, and writes all of them to one file.
//!
//! Behind a point is a live cell of the engine, or a surrogate with memory from six strains to six stresses ([`MaterialPoint::from_surrogate`]), which answers in
//! 10 to 200 microseconds where a cell of 300 grains takes 2 milliseconds; or both ([`MaterialPoint::hybrid`]), the surrogate while it knows and the grains where it does
//! not. Stores, tickets, refusals and everything else that a program sees of a point are the same for all.
//!
//! Compression is positive and the unit is the pascal, as in all of granum. Programs with tension positive convert once, at their border.
//!
//! ```
//! use granum_io::Case;
//! use granum_point::{Controls, Increment, MaterialPoint};
//!
//! let case = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05";
//! let point = MaterialPoint::from_case(&Case::parse(case, "case")?, Controls::default())?;
//! let start = point.start();
//! let answer = point.advance(&start, &Increment::from_components([1e-4, 0.0, 0.0, 0.0, 0.0, 0.0]))?;
//! assert!(answer.stress()[0][0] > start.stress()[0][0], "an axial compression raises the axial stress");
//! let again = point.advance(&start, &Increment::from_components([1e-4, 0.0, 0.0, 0.0, 0.0, 0.0]))?;
//! assert_eq!(again.stress(), answer.stress());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod answer;
mod answer_cache;
mod controls;
mod error;
mod hybrid;
mod identity;
mod imposed_on_surrogate;
mod imposed_stress;
mod increment;
mod material_point;
mod matrix_functions;
mod path_so_far;
mod recipe;
mod rotated;
mod secant;
mod state;
mod store;
mod store_error;
mod store_file;
mod straining;
mod surrogate_model;
mod surrogate_state;
mod tangent;

pub use answer::Answer;
pub use controls::{BeyondLargest, Controls};
pub use error::PointError;
pub use hybrid::Trust;
pub use identity::Identity;
pub use increment::{Increment, Pace};
pub use material_point::MaterialPoint;
pub use recipe::Recipe;
pub use state::State;
pub use store::{Store, StoredAnswer};
pub use store_error::StoreError;
pub use tangent::Tangent;
