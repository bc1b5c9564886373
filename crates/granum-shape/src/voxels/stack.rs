//! A stack of images.

/// A stack of images.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LabelledStack {
    /// Numbers of voxels along x (along the rows of an image), y (down its columns) and z (from image to image).
    pub size: [usize; 3],
    /// The label of each voxel, x running fastest and z slowest.
    pub labels: Vec<u32>,
}
