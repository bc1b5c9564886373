//! Labelled stacks of images: the voxels of each grain have a number of their own, and those of the background have 0.

mod grains;
mod read;
mod stack;

pub(crate) use grains::grains;
pub use read::read;
pub use stack::LabelledStack;

#[cfg(test)]
pub(crate) mod tests;
