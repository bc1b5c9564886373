//! The stress tensor of an assembly and its parts; the formulas are those of the sensor of the stress.

use granum_core::assembly::{Assembly, Matrix};

use crate::ratio::ratio;
use crate::tensor::{add_dyad, deviator, scaled, trace};

/// Stress of an assembly, Pa, compression positive.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Stress {
    /// Part of the normal forces of strong contacts.
    pub strong_normal: Matrix,
    /// Part of the tangential forces of strong contacts.
    pub strong_tangential: Matrix,
    /// Part of the normal forces of weak contacts.
    pub weak_normal: Matrix,
    /// Part of the tangential forces of weak contacts.
    pub weak_tangential: Matrix,
    /// Part of the bonds.
    pub bonds: Matrix,
    /// Part of the fluctuating motion of the grains; not included in [`Stress::tensor`].
    pub kinetic: Matrix,
}

impl Stress {
    /// Computes the stress; all zero for a cell without a volume. Users find it in [`Observation::stress`](crate::Observation::stress).
    ///
    /// The network is strong where the normal force exceeds `mean_normal_force`, N; `volume` is that of the cell, m3.
    pub(crate) fn from_assembly(assembly: &Assembly, mean_normal_force: f64, volume: f64) -> Self {
        let mut stress = Stress::default();
        if volume == 0.0 {
            return stress;
        }
        let mut sums = [[[[0.0; 3]; 3]; 2]; 2];
        // Compiled with wide instructions where the processor has them; nothing here is a fused product.
        granum_simd::wide(
            #[inline(always)]
            || {
                for contact in &assembly.contacts {
                    let branch = assembly.branch_of_bodies(contact);
                    // An index instead of a branch, which no processor could predict.
                    let [normal, tangential] =
                        &mut sums[usize::from(contact.normal_force > mean_normal_force)];
                    add_dyad(normal, contact.normal_force, &contact.normal, &branch);
                    add_dyad(tangential, -1.0, &contact.tangential_force, &branch);
                }
            },
        );
        let [weak, strong] = sums;
        [stress.weak_normal, stress.weak_tangential] = weak;
        [stress.strong_normal, stress.strong_tangential] = strong;
        // Pairs that act on each other without touching: tension, and so weak.
        for pair in &assembly.apart {
            add_dyad(
                &mut stress.weak_normal,
                pair.normal_force,
                &pair.normal,
                &assembly.branch_of_bodies(pair),
            );
        }
        for bond in &assembly.bonds {
            add_dyad(&mut stress.bonds, -1.0, &bond.force(), &assembly.branch_of_bond(bond));
        }
        // Rotation has no part in it: inside a rigid body the centripetal stress balances it.
        for body in &assembly.bodies {
            add_dyad(&mut stress.kinetic, body.mass, &body.velocity, &body.velocity);
        }
        let per_volume = 1.0 / volume;
        Stress {
            strong_normal: scaled(&stress.strong_normal, per_volume),
            strong_tangential: scaled(&stress.strong_tangential, per_volume),
            weak_normal: scaled(&stress.weak_normal, per_volume),
            weak_tangential: scaled(&stress.weak_tangential, per_volume),
            bonds: scaled(&stress.bonds, per_volume),
            kinetic: scaled(&stress.kinetic, per_volume),
        }
    }

    /// The stress tensor of all elastic forces of contacts and bonds.
    pub fn tensor(&self) -> Matrix {
        let parts = [&self.strong_normal, &self.strong_tangential, &self.weak_normal, &self.weak_tangential];
        let contacts: Matrix =
            std::array::from_fn(|i| std::array::from_fn(|j| parts.iter().map(|part| part[i][j]).sum()));
        // Without bonds nothing is added, so that signs of zeros stay.
        if self.bonds == [[0.0; 3]; 3] {
            return contacts;
        }
        std::array::from_fn(|i| std::array::from_fn(|j| contacts[i][j] + self.bonds[i][j]))
    }

    /// Mean stress p.
    pub fn mean(&self) -> f64 {
        trace(&self.tensor()) / 3.0
    }

    /// Deviator stress q.
    pub fn deviator(&self) -> f64 {
        deviator(&self.tensor())
    }

    /// q/p, 0 where p is 0.
    pub fn ratio(&self) -> f64 {
        ratio(self.deviator(), self.mean())
    }
}
