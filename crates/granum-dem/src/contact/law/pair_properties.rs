//! The properties of a pair of spheres, from which the laws prepare their constants.

use crate::material::Material;

/// Properties of a pair of spheres (section 1 of the theory chapter of the book).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PairProperties {
    /// R_i + R_j, m.
    pub radius_sum: f64,
    /// R* = R_i R_j / (R_i + R_j), m.
    pub effective_radius: f64,
    /// m* = m_i m_j / (m_i + m_j), kg.
    pub effective_mass: f64,
    /// E*, Pa: 1/E* = (1 - nu_i^2)/E_i + (1 - nu_j^2)/E_j.
    pub effective_modulus: f64,
    /// G*, Pa: 1/G* = (2 - nu_i)/G_i + (2 - nu_j)/G_j.
    pub effective_shear_modulus: f64,
    /// Coefficient of friction mu.
    pub friction: f64,
    /// Interface energy Gamma (work of adhesion per area), J/m2.
    pub interface_energy: f64,
    /// Fraction zeta of critical damping.
    pub damping: f64,
    /// The smaller of the two radii, m.
    pub smaller_radius: f64,
    /// Rotational inertia against rolling, kg m2: `1/I_r = 1/(I_i + m_i R_i^2) + 1/(I_j + m_j R_j^2)` with `I = 2/5 m R^2`.
    pub rolling_inertia: f64,
}

impl PairProperties {
    /// The properties of two spheres of given materials and radii, m, with dashpots of a fraction of critical damping.
    ///
    /// Friction and interface energy of unlike materials are the geometric means of the two; moduli follow from contact
    /// mechanics: the compliances of the two sides are added.
    pub fn new(i: (&Material, f64), j: (&Material, f64), damping: f64) -> Self {
        let compliance = |m: &Material| (1.0 - m.poissons_ratio * m.poissons_ratio) / m.youngs_modulus;
        let shear_compliance =
            |m: &Material| (2.0 - m.poissons_ratio) * 2.0 * (1.0 + m.poissons_ratio) / m.youngs_modulus;
        let mass = |(m, r): (&Material, f64)| m.density * 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
        PairProperties {
            radius_sum: i.1 + j.1,
            effective_radius: i.1 * j.1 / (i.1 + j.1),
            effective_mass: mass(i) * mass(j) / (mass(i) + mass(j)),
            effective_modulus: 1.0 / (compliance(i.0) + compliance(j.0)),
            effective_shear_modulus: 1.0 / (shear_compliance(i.0) + shear_compliance(j.0)),
            friction: (i.0.friction * j.0.friction).sqrt(),
            interface_energy: (i.0.interface_energy * j.0.interface_energy).sqrt(),
            damping,
            smaller_radius: i.1.min(j.1),
            rolling_inertia: {
                let inertia = |side: (&Material, f64)| 1.4 * mass(side) * side.1 * side.1;
                inertia(i) * inertia(j) / (inertia(i) + inertia(j))
            },
        }
    }

    /// The properties of the same spheres as pieces of bodies of given masses, kg: those of a sphere's own mass are replaced. `radii` are
    /// those of the pieces, m.
    pub(crate) fn of_bodies(self, radii: [f64; 2], [a, b]: [f64; 2]) -> Self {
        let [i, j] = [1.4 * a * radii[0] * radii[0], 1.4 * b * radii[1] * radii[1]];
        PairProperties { effective_mass: a * b / (a + b), rolling_inertia: i * j / (i + j), ..self }
    }
}
