//! A material point as a finite-element program sees it: values, cuts of a path, trials, imposed stresses, rotations.

mod imposed;
mod objectivity;
mod sample;
mod stiffness;
mod stored;
mod values;
