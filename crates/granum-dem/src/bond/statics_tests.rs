//! Small displacements of bonded spheres against the theory of beams: a cantilever, and a triangle.

use granum_core::rotation::about;
use granum_simd::vectors::cross;

use super::law::beam::BeamBond;
use super::law::bond_law::{BondLaw, BondShape, BondStiffness};
use super::law::parallel::ParallelBond;
use super::motion::{Ends, frame_along, in_space, strained};

pub(super) const LENGTH: f64 = 0.1e-3;
pub(super) const SHAPE: BondShape = BondShape { radius: 20e-6, length: LENGTH };

/// Spheres at rest, and the bonds between them.
pub(super) struct Frame {
    pub(super) places: Vec<[f64; 3]>,
    pub(super) bonds: Vec<[usize; 2]>,
    pub(super) stiffness: BondStiffness,
}

/// Force, couple about the centre of each end, and the components `f` and `m` of a bond whose ends moved by a displacement and a small
/// rotation each.
type Loads = ([[f64; 6]; 2], [f64; 3], [f64; 3]);

impl Frame {
    fn bond(&self, k: usize, moved: &[[f64; 6]]) -> Loads {
        let [i, j] = self.bonds[k];
        let rest: [f64; 3] = std::array::from_fn(|a| self.places[j][a] - self.places[i][a]);
        let turn = |sphere: usize| {
            let [_, _, _, x, y, z] = moved[sphere];
            about(&[x, y, z], (x * x + y * y + z * z).sqrt())
        };
        let frame = frame_along(&rest);
        let length = (rest[0] * rest[0] + rest[1] * rest[1] + rest[2] * rest[2]).sqrt();
        let ends = Ends {
            orientations: [turn(i), turn(j)],
            frames: [frame; 2],
            arms: [0.5 * length; 2],
            branch: std::array::from_fn(|a| rest[a] + moved[j][a] - moved[i][a]),
        };
        let s = strained(&ends);
        let (k, u, phi) = (&self.stiffness, s.displacement, s.rotation);
        let f = [k.normal * u[0], k.shear * u[1], k.shear * u[2]];
        let m = [k.twisting * phi[0], k.bending * phi[1], k.bending * phi[2]];
        let (force, couple) = (in_space(&s.axes, &f), in_space(&s.axes, &m));
        let mut on = [[0.0; 6]; 2];
        for (side, sign) in [(0, 1.0), (1, -1.0)] {
            let turning = cross(s.levers[side], force);
            for a in 0..3 {
                on[side][a] = sign * force[a];
                on[side][3 + a] = sign * (couple[a] + turning[a]);
            }
        }
        (on, f, m)
    }

    /// Forces on all spheres, N, and couples, N m.
    fn loads(&self, moved: &[[f64; 6]]) -> Vec<f64> {
        let mut all = vec![0.0; 6 * self.places.len()];
        for k in 0..self.bonds.len() {
            let (on, ..) = self.bond(k, moved);
            for (side, sphere) in self.bonds[k].into_iter().enumerate() {
                for a in 0..6 {
                    all[6 * sphere + a] += on[side][a];
                }
            }
        }
        all
    }

    /// The degrees of freedom of the spheres that are not held, and the stiffness between them, from central differences.
    pub(super) fn matrix(&self, held: &[usize]) -> (Vec<usize>, Vec<Vec<f64>>) {
        let count = self.places.len();
        let free: Vec<usize> = (0..6 * count).filter(|k| !held.contains(&(k / 6))).collect();
        let mut matrix = vec![vec![0.0; free.len()]; free.len()];
        for (c, &of) in free.iter().enumerate() {
            let step = if of % 6 < 3 { 1e-6 * LENGTH } else { 1e-6 };
            let loads = |sign: f64| {
                let mut moved = vec![[0.0; 6]; count];
                moved[of / 6][of % 6] = sign * step;
                self.loads(&moved)
            };
            let (plus, minus) = (loads(1.0), loads(-1.0));
            for (r, &row) in free.iter().enumerate() {
                matrix[r][c] = -(plus[row] - minus[row]) / (2.0 * step);
            }
        }
        (free, matrix)
    }

    /// Displacements and rotations under a force on one sphere, with some spheres held.
    pub(super) fn displaced(&self, held: &[usize], loaded: usize, force: [f64; 3]) -> Vec<[f64; 6]> {
        let (free, mut matrix) = self.matrix(held);
        for (row, of) in matrix.iter_mut().zip(&free) {
            row.push(if of / 6 == loaded && of % 6 < 3 { force[of % 6] } else { 0.0 });
        }
        let solution = solve(matrix);
        let mut moved = vec![[0.0; 6]; self.places.len()];
        for (value, of) in solution.into_iter().zip(free) {
            moved[of / 6][of % 6] = value;
        }
        moved
    }
}

/// Solves linear equations, given with their right sides, by elimination with pivots.
pub(super) fn solve(mut rows: Vec<Vec<f64>>) -> Vec<f64> {
    let n = rows.len();
    for k in 0..n {
        let pivot = (k..n).max_by(|a, b| rows[*a][k].abs().total_cmp(&rows[*b][k].abs())).unwrap();
        rows.swap(k, pivot);
        for r in k + 1..n {
            let factor = rows[r][k] / rows[k][k];
            for c in k..=n {
                let above = rows[k][c];
                rows[r][c] -= factor * above;
            }
        }
    }
    let mut x = vec![0.0; n];
    for k in (0..n).rev() {
        let known: f64 = (k + 1..n).map(|c| rows[k][c] * x[c]).sum();
        x[k] = (rows[k][n] - known) / rows[k][k];
    }
    x
}

pub(super) fn cantilever(bonds: usize, stiffness: BondStiffness) -> Frame {
    let places = (0..=bonds).map(|k| [k as f64 * LENGTH, 0.0, 0.0]).collect();
    Frame { places, bonds: (0..bonds).map(|k| [k, k + 1]).collect(), stiffness }
}

pub(super) fn parallel() -> BondStiffness {
    ParallelBond.stiffness(&SHAPE, &[1e9, 0.25, 0.0])
}

#[test]
fn a_cantilever_bends_as_springs_in_series_and_as_timoshenkos_beam() {
    let beam = BeamBond.stiffness(&SHAPE, &[1e9, 0.25, 1.0]);
    let springs = [2.188_380_467_5e-3, 2.029_225_524_4e-2, 0.329_251_788_52, 2.647_940_365_7];
    let exact = [2.851_526_063_7e-3, 2.161_854_643_7e-2, 0.332_567_516_50, 2.654_571_821_7];
    for (golden, stiffness) in [(springs, parallel()), (exact, beam)] {
        for (bonds, golden) in [1, 2, 5, 10].into_iter().zip(golden) {
            let force = 1e-6;
            let moved = cantilever(bonds, stiffness).displaced(&[0], bonds, [0.0, force, 0.0]);
            let (deflection, slope) = (moved[bonds][1] / force, moved[bonds][5] / force);
            assert!((deflection / golden - 1.0).abs() < 1e-7, "{bonds}: {deflection} {golden}");
            // The slope of the end is exact with both: P L^2 / 2 E I.
            let length = bonds as f64 * LENGTH;
            let right = 0.5 * length * length / (1e9 * SHAPE.second_moment());
            assert!((slope / right - 1.0).abs() < 1e-7, "{bonds}: {slope} {right}");
        }
    }
}

#[test]
fn a_triangle_carries_a_force_on_its_apex_as_computed() {
    let height = 0.75f64.sqrt() * LENGTH;
    let places = vec![[0.0; 3], [LENGTH, 0.0, 0.0], [0.5 * LENGTH, height, 0.0]];
    let frame = Frame { places, bonds: vec![[0, 2], [1, 2]], stiffness: parallel() };
    // So small that second orders are below the tolerance.
    let force = 1e-8;
    let near =
        |found: f64, right: f64, scale: f64| assert!((found - right).abs() < 1e-7 * scale, "{found} {right}");
    let down = frame.displaced(&[0, 1], 2, [0.0, -force, 0.0]);
    near(-down[2][1] / force, 4.681_027_738_0e-5, 4.7e-5);
    let (_, f, m) = frame.bond(0, &down);
    near(f[0] / force, -0.509_426_708, 1.0);
    near((f[1].abs() + f[2].abs()) / force, 0.117_647_059, 1.0);
    near(m.iter().map(|x| x.abs()).sum::<f64>() / force, 0.0, LENGTH);
    let along = frame.displaced(&[0, 1], 2, [force, 0.0, 0.0]);
    near(along[2][0] / force, 1.435_003_585_3e-4, 1.4e-4);
    near(along[2][5] / force, -2.259_544_653_4, 2.3);
    for (bond, sign) in [(0, 1.0), (1, -1.0)] {
        let (_, f, m) = frame.bond(bond, &along);
        near(f[0] / force, sign * 0.901_639_344, 1.0);
        near((f[1].abs() + f[2].abs()) / force, 0.056_788_551, 1.0);
        near(m.iter().map(|x| x.abs()).sum::<f64>() / force, 2.839_427_55e-6, LENGTH);
    }
    // The greatest tension, with bending, of the nearer bond.
    let (_, f, m) = frame.bond(0, &along);
    let stress = f[0] / SHAPE.area() + m[1].hypot(m[2]) * SHAPE.radius / SHAPE.second_moment();
    near(20e6 / (stress / force), 1.710_263_097_3e-2, 1.7e-2);
}

#[test]
fn couples_follow_the_half_angle() {
    // At rupture in bending the angle is 2 atan(0.05), and in twist 2 atan(0.09375).
    let frame = cantilever(1, parallel());
    for (axis, angle, couple) in
        [(5, 0.099_916_8f64, 1.256_637_061_4e-7), (3, 0.186_953_6, 1.884_955_592_2e-7)]
    {
        let mut moved = vec![[0.0; 6]; 2];
        moved[1][axis] = angle;
        // The end turns about the middle of the bond, so that nothing is sheared.
        if axis == 5 {
            moved[1][0] = -0.5 * LENGTH * (1.0 - angle.cos());
            moved[1][1] = 0.5 * LENGTH * angle.sin();
        }
        let (_, _, m) = frame.bond(0, &moved);
        let found = m.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((found / couple - 1.0).abs() < 1e-6, "{found} {couple}");
    }
}
