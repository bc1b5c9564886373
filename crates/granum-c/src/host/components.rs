//! Tensors as lists of their components xx, yy, zz, yz, zx, xy.

use granum_core::geometry::Matrix;

/// Row and column of each component.
pub(crate) const PLACES: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [1, 2], [2, 0], [0, 1]];

/// The symmetric tensor of six components.
pub fn tensor_from(components: &[f64; 6]) -> Matrix {
    let mut tensor = [[0.0; 3]; 3];
    for (value, [r, c]) in components.iter().zip(PLACES) {
        (tensor[r][c], tensor[c][r]) = (*value, *value);
    }
    tensor
}

/// The six components of a tensor; its two shear entries are averaged.
pub fn components_of(tensor: &Matrix) -> [f64; 6] {
    PLACES.map(|[r, c]| 0.5 * (tensor[r][c] + tensor[c][r]))
}
