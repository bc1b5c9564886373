//! Symmetric tensors by the orthonormal components of their deviators, and how rotations act on these.

use crate::input_use::SplitMix;

/// Number of components of a deviator.
pub(crate) const COMPONENTS: usize = 5;

type Matrix = [[f64; 3]; 3];

/// The components of a deviator in the basis `diag(2, -1, -1) / sqrt(6)`, `diag(0, 1, -1) / sqrt(2)`, yz, zx, xy (the last three with their
/// transposes, over `sqrt(2)`), and a third of the trace, of a tensor `[xx, yy, zz, yz, zx, xy]`.
pub(crate) fn parts([xx, yy, zz, yz, zx, xy]: [f64; 6]) -> ([f64; COMPONENTS], f64) {
    let (r6, r2) = (6f64.sqrt(), 2f64.sqrt());
    ([(2.0 * xx - yy - zz) / r6, (yy - zz) / r2, r2 * yz, r2 * zx, r2 * xy], (xx + yy + zz) / 3.0)
}

/// The tensor `[xx, yy, zz, yz, zx, xy]` of the components of its deviator and a third of its trace.
pub(super) fn whole(c: [f64; COMPONENTS], mean: f64) -> [f64; 6] {
    let (r6, r2) = (6f64.sqrt(), 2f64.sqrt());
    let (half, other) = (c[0] / r6, c[1] / r2);
    [2.0 * half + mean, other - half + mean, -other - half + mean, c[2] / r2, c[3] / r2, c[4] / r2]
}

fn matrix(c: [f64; COMPONENTS]) -> Matrix {
    let [xx, yy, zz, yz, zx, xy] = whole(c, 0.0);
    [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]
}

/// A rotation, as a matrix that acts on the components of deviators.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Rotation([[f64; COMPONENTS]; COMPONENTS]);

impl Rotation {
    /// From a rotation of vectors.
    fn of_vectors(r: Matrix) -> Rotation {
        let mut own = [[0.0; COMPONENTS]; COMPONENTS];
        for column in 0..COMPONENTS {
            let mut unit = [0.0; COMPONENTS];
            unit[column] = 1.0;
            let t = matrix(unit);
            let turned = |i: usize, j: usize| {
                (0..3)
                    .flat_map(|a| (0..3).map(move |b| (a, b)))
                    .map(|(a, b)| r[i][a] * t[a][b] * r[j][b])
                    .sum()
            };
            let six = [turned(0, 0), turned(1, 1), turned(2, 2), turned(1, 2), turned(2, 0), turned(0, 1)];
            for (row, value) in parts(six).0.into_iter().enumerate() {
                own[row][column] = value;
            }
        }
        Rotation(own)
    }

    /// A rotation of uniform density, from a unit quaternion.
    pub fn random(random: &mut SplitMix) -> Rotation {
        let [w, x, y, z] = loop {
            let q: [f64; 4] =
                std::array::from_fn(|_| (random.next() >> 11) as f64 / (1u64 << 52) as f64 - 1.0);
            let norm = q.iter().map(|c| c * c).sum::<f64>().sqrt();
            if norm > 0.01 && norm <= 1.0 {
                break q.map(|c| c / norm);
            }
        };
        Rotation::of_vectors([
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ])
    }

    /// The 24 rotations that permute and mirror the axes. Mirrors add nothing: minus one leaves tensors as they are.
    pub fn of_axes() -> Vec<Rotation> {
        let orders = [[0, 1, 2], [1, 2, 0], [2, 0, 1], [0, 2, 1], [2, 1, 0], [1, 0, 2]];
        let mut found = Vec::new();
        for (k, order) in orders.into_iter().enumerate() {
            let even = k < 3;
            for signs in 0..8u32 {
                if (signs.count_ones() % 2 == 0) == even {
                    let mut r = [[0.0; 3]; 3];
                    for (row, column) in order.into_iter().enumerate() {
                        r[row][column] = if signs >> row & 1 == 1 { -1.0 } else { 1.0 };
                    }
                    found.push(Rotation::of_vectors(r));
                }
            }
        }
        found
    }

    /// Its factors for the components, row by row.
    pub fn rows(&self) -> &[[f64; COMPONENTS]; COMPONENTS] {
        &self.0
    }

    /// The opposite rotation.
    pub fn inverse(&self) -> Rotation {
        Rotation(std::array::from_fn(|i| std::array::from_fn(|j| self.0[j][i])))
    }

    /// Turns `count` deviators of a row: from `first` on the first component of each, then the second of each, and so on.
    pub fn turn(&self, row: &mut [f64], first: usize, count: usize) {
        for tensor in 0..count {
            let at = |c: usize| first + c * count + tensor;
            let before: [f64; COMPONENTS] = std::array::from_fn(|c| row[at(c)]);
            for (c, factors) in self.0.iter().enumerate() {
                row[at(c)] = factors.iter().zip(&before).map(|(factor, value)| factor * value).sum();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tensors_come_back_from_their_parts() {
        let six = [3.0, -1.0, 0.5, 0.2, -0.7, 0.9];
        let (c, mean) = parts(six);
        let back = whole(c, mean);
        assert!(back.iter().zip(six).all(|(ours, exact)| (ours - exact).abs() < 1e-14));
        let norm: f64 = c.iter().map(|c| c * c).sum();
        let deviator: f64 = [3.0 - mean, -1.0 - mean, 0.5 - mean].iter().map(|c| c * c).sum();
        assert!((norm - deviator - 2.0 * (0.04 + 0.49 + 0.81)).abs() < 1e-13);
    }

    #[test]
    fn rotations_keep_norms_and_those_of_the_axes_permute() {
        let random = &mut SplitMix(3);
        let row = [0.4, -0.3, 0.1, 0.8, -0.6];
        let norm = |row: &[f64]| row.iter().map(|c| c * c).sum::<f64>();
        for rotation in Rotation::of_axes().into_iter().chain((0..20).map(|_| Rotation::random(random))) {
            let mut turned = row;
            rotation.turn(&mut turned, 0, 1);
            assert!((norm(&turned) - norm(&row)).abs() < 1e-14);
            rotation.inverse().turn(&mut turned, 0, 1);
            assert!(turned.iter().zip(row).all(|(ours, exact)| (ours - exact).abs() < 1e-14));
        }
        let axes = Rotation::of_axes();
        assert_eq!(axes.len(), 24);
        assert!((0..24).all(|k| !axes[..k].contains(&axes[k])));
        // Each turns diag(1, 2, 3) into a diagonal with the same numbers.
        for rotation in axes {
            let (mut c, mean) = parts([1.0, 2.0, 3.0, 0.0, 0.0, 0.0]);
            rotation.turn(&mut c, 0, 1);
            let mut six = whole(c, mean);
            six[..3].sort_by(f64::total_cmp);
            let exact = [1.0, 2.0, 3.0, 0.0, 0.0, 0.0];
            assert!(six.iter().zip(exact).all(|(ours, exact)| (ours - exact).abs() < 1e-13), "{six:?}");
        }
    }

    /// The mean over random rotations of any deviator vanishes.
    #[test]
    fn random_rotations_have_no_direction() {
        let random = &mut SplitMix(1);
        let mut sum = [0.0; COMPONENTS];
        for _ in 0..4000 {
            let mut row = [0.4, -0.3, 0.1, 0.8, -0.6];
            Rotation::random(random).turn(&mut row, 0, 1);
            (0..COMPONENTS).for_each(|c| sum[c] += row[c] / 4000.0);
        }
        assert!(sum.iter().all(|mean| mean.abs() < 0.03), "{sum:?}");
    }
}
