//! What the eight numbers of a row of a piece are: x, y, z, R, v'_x, v'_y, v'_z, and the mass m of its body.

use granum_simd::Row8;

use crate::assembly::Vector;

/// A row as the data of a piece.
pub(crate) trait ParticleRow {
    /// Its centre, m.
    fn position(&self) -> Vector;
    /// Its radius, m.
    fn radius(&self) -> f64;
    /// Its fluctuating velocity, m/s.
    fn velocity(&self) -> Vector;
    /// Mass of its body, kg.
    fn mass(&self) -> f64;
    /// Gives it a fluctuating velocity, m/s.
    fn set_velocity(&mut self, velocity: &Vector);
    /// Gives its body a mass, kg.
    fn set_mass(&mut self, mass: f64);
}

impl ParticleRow for Row8 {
    #[inline(always)]
    fn position(&self) -> Vector {
        [self.0[0], self.0[1], self.0[2]]
    }
    #[inline(always)]
    fn radius(&self) -> f64 {
        self.0[3]
    }
    #[inline(always)]
    fn velocity(&self) -> Vector {
        [self.0[4], self.0[5], self.0[6]]
    }
    #[inline(always)]
    fn mass(&self) -> f64 {
        self.0[7]
    }
    #[inline(always)]
    fn set_velocity(&mut self, velocity: &Vector) {
        self.0[4..7].copy_from_slice(velocity);
    }
    #[inline(always)]
    fn set_mass(&mut self, mass: f64) {
        self.0[7] = mass;
    }
}
