//! Adds the forces of the contacts of a batch to the force rows of their grains.

use granum_simd::{LANES, Lanes};

use super::laws::Couples;
use super::views::Views;

/// The forces and torques of a batch on its grains.
#[derive(Clone, Copy)]
pub(super) struct Push<L, C> {
    pub(super) batch: usize,
    /// Force on i, N.
    pub(super) force: [L; 3],
    /// Torque over radius, N.
    pub(super) moment: [L; 3],
    /// Additional torque of the couples.
    pub(super) couples: C,
}

impl<L: Lanes, C: Couples<L>> Push<L, C> {
    #[inline(always)]
    pub(super) fn none() -> Self {
        Push { batch: 0, force: [L::zero(); 3], moment: [L::zero(); 3], couples: C::none() }
    }

    /// Adds the forces and torques to the force rows of the grains.
    #[inline(always)]
    pub(super) fn add(&self, v: &Views) {
        let ([fx, fy, fz], [mx, my, mz], zero) = (self.force, self.moment, L::zero());
        // SAFETY: lists are only read in this stage.
        let (i, target) = unsafe { (&v.first.read()[self.batch], &v.target.read()[self.batch]) };
        L::check(i, v.forces.len());
        L::check(target, v.forces.len());
        // The force on j is opposite to that on i; the moments are equal.
        let sign = L::load(&[-1.0, -1.0, -1.0, 1.0, 1.0, 1.0, 1.0, 1.0]);
        match self.couples.moments() {
            None => {
                let rows = L::transpose([fx, fy, fz, zero, mx, my, mz, zero]);
                for l in 0..LANES {
                    // SAFETY: the indices were checked to be rows; the rows that the pairs of a block refer to belong to the
                    // thread that works on it.
                    unsafe {
                        let on_i = v.forces.at(i[l]);
                        (L::load(&on_i.0) + rows[l]).store(&mut on_i.0);
                        let on_j = v.forces.at(target[l]);
                        rows[l].mul_add(sign, L::load(&on_j.0)).store(&mut on_j.0);
                    }
                }
            }
            Some([[ix, iy, iz], [jx, jy, jz]]) => {
                let on_first = L::transpose([fx, fy, fz, zero, mx + ix, my + iy, mz + iz, zero]);
                let on_second = L::transpose([fx, fy, fz, zero, mx + jx, my + jy, mz + jz, zero]);
                for l in 0..LANES {
                    // SAFETY: as above.
                    unsafe {
                        let on_i = v.forces.at(i[l]);
                        (L::load(&on_i.0) + on_first[l]).store(&mut on_i.0);
                        let on_j = v.forces.at(target[l]);
                        on_second[l].mul_add(sign, L::load(&on_j.0)).store(&mut on_j.0);
                    }
                }
            }
        }
    }
}
