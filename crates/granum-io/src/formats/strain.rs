//! Strain and strain rate of a series of cells, as far as the cells say them.

use granum_core::assembly::Matrix;
use granum_core::geometry::{apply, invert, multiply};
use granum_core::{Part, Parts};

use super::result::ObservedAssembly;

/// Terms of the series of the logarithm; the last is below 1e-18 for a stretch by a factor of three in one interval.
const TERMS: usize = 60;

const ONE: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Adds the logarithmic strain since the first observation, and the velocity gradient where times are known: the mean over the
/// intervals before and after an observation. Cells that a program flipped by a lattice vector are unflipped first.
///
/// Velocities of grains are those against the homogeneous deformation. Where the cell keeps its shape they are what the file
/// has; where it changes, the gradient at the very instant is not in the file, and velocities are not among the known parts.
pub(crate) fn add_strains(observations: &mut [ObservedAssembly]) {
    let cells: Vec<Matrix> = observations.iter().map(|o| o.assembly.cell).collect();
    if observations.len() < 2 || !observations.iter().all(|o| o.parts.has(Part::Cell)) {
        return;
    }
    let times = observations.iter().all(|o| o.parts.has(Part::Time));
    let steps: Vec<Matrix> = cells.windows(2).map(|pair| velocity_times_time(&pair[0], &pair[1])).collect();
    let moves = steps.iter().flatten().flatten().any(|x| x.abs() > 1e-12);
    let (mut strain, mut arc_length) = ([[0.0; 3]; 3], 0.0);
    for k in 0..observations.len() {
        if k > 0 {
            let change = &steps[k - 1];
            let mut square = 0.0;
            for a in 0..3 {
                for b in 0..3 {
                    let part = -0.5 * (change[a][b] + change[b][a]);
                    strain[a][b] += part;
                    square += part * part;
                }
            }
            arc_length += (2.0 / 3.0 * square).sqrt();
        }
        observations[k].assembly.strain = strain;
        observations[k].assembly.arc_length = arc_length;
        observations[k].parts = observations[k].parts.with(Part::Strain);
        if moves {
            observations[k].parts = without(observations[k].parts, Part::Velocities);
        }
    }
    if times {
        add_rates(observations, &steps);
    }
}

fn add_rates(observations: &mut [ObservedAssembly], steps: &[Matrix]) {
    let times: Vec<f64> = observations.iter().map(|o| o.assembly.time).collect();
    if times.windows(2).any(|pair| pair[1] <= pair[0]) {
        return;
    }
    for (k, observation) in observations.iter_mut().enumerate() {
        let (first, last) = (k.saturating_sub(1), (k + 1).min(steps.len()));
        let time = times[last] - times[first];
        let gradient =
            |a: usize, b: usize| steps[first..last].iter().map(|step| step[a][b]).sum::<f64>() / time;
        observation.assembly.velocity_gradient =
            std::array::from_fn(|a| std::array::from_fn(|b| gradient(a, b)));
        observation.parts = observation.parts.with(Part::StrainRate);
    }
}

/// The parts without one of them.
fn without(parts: Parts, gone: Part) -> Parts {
    let rest: Vec<Part> = Part::ALL.into_iter().filter(|part| *part != gone && parts.has(*part)).collect();
    Parts::new(&rest)
}

/// The logarithm of the deformation gradient from one cell to the next: the velocity gradient times the time, were it constant.
fn velocity_times_time(before: &Matrix, after: &Matrix) -> Matrix {
    logarithm(&multiply(&unflipped(before, after), &invert(before)))
}

/// The cell `after`, of which each edge is replaced by the equivalent one that is nearest to that of `before`.
fn unflipped(before: &Matrix, after: &Matrix) -> Matrix {
    let mut edges = *after;
    // Edge b may be flipped by edge a, and edge c by both.
    for (edge, by) in [(1, 0), (2, 1), (2, 0)] {
        let column = |m: &Matrix, k: usize| [m[0][k], m[1][k], m[2][k]];
        let moved = apply(
            &invert(&edges),
            std::array::from_fn(|a| column(&edges, edge)[a] - column(before, edge)[a]),
        );
        let times = libm::round(moved[by]);
        for row in &mut edges {
            row[edge] -= times * row[by];
        }
    }
    edges
}

/// `ln F = 2 (Z + Z^3/3 + Z^5/5 ...)` with `Z = (F - 1)(F + 1)^-1`, for deformation gradients of one interval.
fn logarithm(f: &Matrix) -> Matrix {
    let plus = |sign: f64| std::array::from_fn(|a| std::array::from_fn(|b| f[a][b] + sign * ONE[a][b]));
    let z: Matrix = multiply(&plus(-1.0), &invert(&plus(1.0)));
    let square = multiply(&z, &z);
    let (mut power, mut sum) = (z, [[0.0; 3]; 3]);
    for k in 0..TERMS {
        for a in 0..3 {
            for b in 0..3 {
                sum[a][b] += 2.0 * power[a][b] / (2 * k + 1) as f64;
            }
        }
        power = multiply(&power, &square);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_of_a_stretch_is_that_of_its_factors() {
        let found = logarithm(&[[0.5, 0.0, 0.0], [0.0, 1.1, 0.0], [0.0, 0.0, 3.0]]);
        for (k, factor) in [0.5f64, 1.1, 3.0].into_iter().enumerate() {
            assert!((found[k][k] - factor.ln()).abs() < 1e-14, "{}", found[k][k]);
        }
        // A simple shear: L t has the one entry gamma.
        let shear = logarithm(&[[1.0, 0.3, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert!((shear[0][1] - 0.3).abs() < 1e-15 && shear[1][0].abs() < 1e-15 && shear[0][0].abs() < 1e-15);
    }

    #[test]
    fn a_flip_of_the_cell_is_no_strain() {
        let before = [[2.0, 0.98, 0.0], [0.0, 2.0, 0.9], [0.0, 0.0, 2.0]];
        let after = [[2.0, 1.02 - 2.0, -0.98], [0.0, 2.0, 1.1 - 2.0], [0.0, 0.0, 2.0]];
        let found = unflipped(&before, &after);
        assert!((found[0][1] - 1.02).abs() < 1e-15 && (found[1][2] - 1.1).abs() < 1e-15, "{found:?}");
        assert!((found[0][2] - 0.04).abs() < 1e-12, "{found:?}");
    }

    #[test]
    fn strains_add_up_and_velocities_of_a_moving_cell_are_not_known() {
        let parts = Parts::new(&[Part::Cell, Part::Time, Part::Velocities]);
        let at = |k: f64| {
            let mut assembly = granum_core::Assembly { time: 2.0 * k, ..Default::default() };
            assembly.cell = [[(-0.1 * k).exp(), 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, (0.05 * k).exp()]];
            ObservedAssembly::new(assembly, parts, [0.0; 3])
        };
        let mut series: Vec<ObservedAssembly> = (0..4).map(|k| at(f64::from(k))).collect();
        add_strains(&mut series);
        let last = &series[3];
        assert!((last.assembly.strain[0][0] - 0.3).abs() < 1e-14);
        assert!((last.assembly.strain[2][2] + 0.15).abs() < 1e-14);
        assert!((series[1].assembly.velocity_gradient[0][0] + 0.05).abs() < 1e-14);
        assert!(
            last.parts.has(Part::Strain)
                && last.parts.has(Part::StrainRate)
                && !last.parts.has(Part::Velocities)
        );
        let mut single = vec![at(0.0)];
        add_strains(&mut single);
        assert!(!single[0].parts.has(Part::Strain) && single[0].parts.has(Part::Velocities));
    }
}
