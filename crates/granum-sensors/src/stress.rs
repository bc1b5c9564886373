//! Stress from the contacts.
//!
//! `sigma_ij = -(1/V) sum_c f_i l_j`, with f the elastic force on grain i of the contact and l the branch vector from i to j
//! (Drescher and de Josselin de Jong 1972; dashpots are excluded); of grains of several pieces it joins their centres of mass.
//! With `f = -N n + T` it splits into a normal part
//! `(1/V) sum N n_i l_j` and a tangential part `-(1/V) sum T_i l_j`, and each sum into strong (`N > <N>`) and weak contacts
//! (Radjai et al. 1998). The kinetic part `(1/V) sum m v'_i v'_j` is reported separately and not added: in quasi-static
//! shear it is below 1e-5 of p.
//!
//! `p = tr(sigma)/3`, `q = sigma_1 - sigma_3`, with axes 2 and 3 averaged. The contributions to q are divided by p, so that
//! normal + tangential = strong + weak = q/p.

use granum_core::Part;
use granum_core::assembly::{Matrix, Vector};

use crate::ratio::ratio;
pub use crate::stress_tensor::Stress;
use crate::tensor::{deviator, trace};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct StressSensor;

impl Sensor for StressSensor {
    fn description(&self) -> SensorDescription {
        SensorDescription::new(
            "stress",
            "stress tensor of the elastic contact forces and the parts of its deviator",
        )
        .speaking_of(Subject::Contacts)
        .columns([
            SensorColumn::new("stress_11", "Pa", "sigma_11, compression positive"),
            SensorColumn::new("stress_12", "Pa", "sigma_12"),
            SensorColumn::new("stress_13", "Pa", "sigma_13"),
            SensorColumn::new("stress_21", "Pa", "sigma_21"),
            SensorColumn::new("stress_22", "Pa", "sigma_22"),
            SensorColumn::new("stress_23", "Pa", "sigma_23"),
            SensorColumn::new("stress_31", "Pa", "sigma_31"),
            SensorColumn::new("stress_32", "Pa", "sigma_32"),
            SensorColumn::new("stress_33", "Pa", "sigma_33"),
            SensorColumn::new("mean_stress", "Pa", "p = (sigma_1 + sigma_2 + sigma_3) / 3"),
            SensorColumn::new("deviator_stress", "Pa", "q = sigma_1 - sigma_3, axes 2 and 3 averaged"),
            SensorColumn::new("stress_ratio", "1", "q/p"),
            SensorColumn::new("normal_stress_ratio", "1", "part of q/p carried by normal forces"),
            SensorColumn::new("tangential_stress_ratio", "1", "part of q/p carried by tangential forces"),
            SensorColumn::new("strong_stress_ratio", "1", "part of q/p carried by strong contacts, N > <N>"),
            SensorColumn::new("weak_stress_ratio", "1", "part of q/p carried by weak contacts, N <= <N>"),
            SensorColumn::new(
                "kinetic_mean_stress",
                "Pa",
                "mean stress of the fluctuating motion, not part of p",
            )
            .needing(&[Part::Masses, Part::Velocities]),
        ])
        .needing(&[Part::Cell, Part::Contacts, Part::NormalForces, Part::TangentialForces])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let stress = &observation.stress;
        let tensor: [Vector; 3] = stress.tensor();
        let p = stress.mean();
        let share = |a: &Matrix, b: &Matrix| ratio(deviator(a) + deviator(b), p);
        values.extend(tensor.into_iter().flatten());
        values.extend([
            p,
            stress.deviator(),
            stress.ratio(),
            share(&stress.strong_normal, &stress.weak_normal),
            share(&stress.strong_tangential, &stress.weak_tangential),
            share(&stress.strong_normal, &stress.strong_tangential),
            share(&stress.weak_normal, &stress.weak_tangential),
            trace(&stress.kinetic) / 3.0,
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice;
    use crate::tensor::{add_dyad, scaled};
    use granum_core::assembly::Assembly;
    use proptest::prelude::*;

    fn stress(assembly: &Assembly) -> Stress {
        Observation::new(assembly).stress
    }

    /// Lattices of equal spheres: SC `p = N/L^2`, FCC `p = 2 sqrt(2) N/L^2`, `L = d (1 - eps)`, with the Hertz and JKR
    /// forces for d = 0.1 mm, E = 70 GPa, nu = 0.3, Gamma = 0.6 J/m2 (theory chapter, a pair of the paper's spheres).
    #[test]
    fn lattices_have_their_analytic_pressure() {
        let d = 1e-4;
        for (strain, force, simple, face_centred) in [
            (1e-5, 8.108404257e-6, 810.8566, Some(2293.449)),
            (1e-4, 2.564102564e-4, 25646.15, Some(72538.28)),
            (1e-3, 8.108404257e-3, 812464.5, Some(2297997.0)),
            (1e-5, -5.023644056e-5, -5023.745, None),
            (1e-4, 2.049927176e-4, 20503.37, None),
            (1e-3, 8.060346847e-3, 807649.2, None),
        ] {
            let s = stress(&lattice::simple_cubic(3, d, strain, force));
            assert!((s.mean() / simple - 1.0).abs() < 2e-7, "{strain}: {}", s.mean());
            assert!(s.ratio().abs() < 1e-12);
            let s = stress(&lattice::face_centred_cubic(3, d, strain, force));
            let exact = 2.0 * 2f64.sqrt() * force / (d * (1.0 - strain)).powi(2);
            assert!((s.mean() / exact - 1.0).abs() < 1e-12);
            if let Some(tabulated) = face_centred {
                assert!((s.mean() / tabulated - 1.0).abs() < 2e-7, "{strain}: {}", s.mean());
            }
        }
    }

    /// Stress from the grains: `sigma = (1/V) sum_grains sum_contacts (x_c - x_g) (-f)`, with contact points computed from
    /// the radii; and from sections: the mean traction on planes normal to an axis.
    #[test]
    fn contacts_grains_and_sections_agree() {
        let assembly = lattice::random_contacts(300, 0x5eed);
        let tensor = stress(&assembly).tensor();
        let scale = trace(&tensor).abs();
        let mut by_grain = [[0.0; 3]; 3];
        for (g, grain) in assembly.pieces.iter().enumerate() {
            for contact in &assembly.contacts {
                let total = assembly.pieces[contact.i].radius + assembly.pieces[contact.j].radius;
                let arm = contact.branch.map(|l| l * grain.radius / total);
                let force = contact.force();
                if contact.i == g {
                    add_dyad(&mut by_grain, -1.0, &force, &arm);
                }
                if contact.j == g {
                    // The other grain feels the opposite force with the opposite lever arm.
                    add_dyad(&mut by_grain, -1.0, &force, &arm);
                }
            }
        }
        let by_grain = scaled(&by_grain, 1.0 / assembly.volume());
        let by_section = traction_on_planes(&assembly, 20_000);
        for i in 0..3 {
            for j in 0..3 {
                assert!((tensor[i][j] - by_grain[i][j]).abs() < 1e-12 * scale);
                assert!((tensor[i][j] - by_section[i][j]).abs() < 1e-3 * scale, "{tensor:?} {by_section:?}");
            }
        }
    }

    fn traction_on_planes(assembly: &Assembly, planes: usize) -> Matrix {
        let mut tensor = [[0.0; 3]; 3];
        for axis in 0..3 {
            let edge = assembly.cell[axis][axis];
            let area = assembly.volume() / edge;
            for contact in &assembly.contacts {
                let start = assembly.pieces[contact.i].position[axis] / edge * planes as f64;
                let end = start + contact.branch[axis] / edge * planes as f64;
                // Planes at integer coordinates, since the cell is periodic.
                let crossed = end.floor() - start.floor();
                let force = contact.force();
                for i in 0..3 {
                    tensor[i][axis] -= force[i] * crossed / (area * planes as f64);
                }
            }
        }
        tensor
    }

    proptest! {
        #[test]
        fn stress_turns_with_the_assembly(seed in 0u64..1000, axis in prop::array::uniform3(-1.0..1.0f64)) {
            prop_assume!(axis.iter().map(|x| x * x).sum::<f64>() > 0.01);
            let assembly = lattice::random_contacts(60, seed);
            let q = lattice::rotation(axis, 1.3);
            let before = stress(&assembly);
            let after = stress(&lattice::rotated(&assembly, &q));
            let expected = lattice::conjugate(&q, &before.tensor());
            for i in 0..3 {
                for j in 0..3 {
                    let error = (after.tensor()[i][j] - expected[i][j]).abs();
                    prop_assert!(error < 1e-9 * before.mean().abs().max(1.0));
                }
            }
            prop_assert!((after.mean() / before.mean() - 1.0).abs() < 1e-9);
        }

        #[test]
        fn parts_sum_to_the_whole(seed in 0u64..1000) {
            let assembly = lattice::random_contacts(80, seed);
            let row = crate::measure_row(&assembly);
            let value = |name: &str| row[crate::column_index(name).unwrap()];
            let whole = value("stress_ratio");
            prop_assert!((value("normal_stress_ratio") + value("tangential_stress_ratio") - whole).abs() < 1e-12);
            prop_assert!((value("strong_stress_ratio") + value("weak_stress_ratio") - whole).abs() < 1e-12);
            prop_assert!(value("kinetic_mean_stress") >= 0.0);
        }
    }
}
