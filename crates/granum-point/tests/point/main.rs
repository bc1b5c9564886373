//! A material point as a finite-element program sees it: values, cuts of a path, trials, imposed stresses, rotations; of grains and of surrogates.

mod hybrid;
mod imposed;
mod objectivity;
mod sample;
mod shipped;
mod stiffness;
mod stored;
mod surrogate;
mod values;
