//! A user-defined contact law with a parameter: spheres on an elastic foundation (Winkler), whose pressure at each point is
//! proportional to the local displacement.
//!
//! With the foundation modulus `kappa E*/R*`: contact radius `a = sqrt(2 R* alpha)`, force `N = pi kappa E* alpha^2`,
//! stiffness `dN/dalpha = 2 pi kappa E* alpha` (Johnson 1985, section 4.3).

use std::f64::consts::PI;

use granum::dem::contact::{Description, LAW_CONSTANTS, Normal, NormalLaw, PairProperties, Parameter, Unit};
use granum::prelude::*;
use granum::simd::Real;

#[derive(Clone, Copy)]
struct Foundation;

impl NormalLaw for Foundation {
    const DESCRIPTION: Description = Description::new(
        "elastic-foundation",
        "elastic foundation",
        "spheres on an elastic foundation (Winkler)",
        &[Parameter::new(
            "foundation_modulus",
            Unit::NUMBER,
            1.0,
            [0.01, 100.0],
            "Modulus of the foundation over E*/R*",
        )],
    );

    fn prepare(pair: &PairProperties, parameters: &[f64]) -> [f64; LAW_CONSTANTS] {
        let mut c = [0.0; LAW_CONSTANTS];
        c[0] = PI * parameters[0] * pair.effective_modulus;
        c[1] = 2.0 * pair.effective_radius;
        c
    }

    #[inline(always)]
    fn evaluate<R: Real>(c: &[R; LAW_CONSTANTS], overlap: R, _touched: R::Mask) -> Normal<R> {
        let alpha = overlap.max(R::zero());
        let force = c[0] * alpha * alpha;
        let stiffness = (c[0] + c[0]) * alpha;
        let radius = (c[1] * alpha).sqrt();
        Normal {
            force,
            radius,
            stiffness,
            root_stiffness: stiffness.sqrt(),
            tangential_measure: radius,
            root_tangential_measure: radius.sqrt(),
            friction_load: force,
            touching: alpha.gt(R::zero()),
        }
    }

    fn loaded(pair: &PairProperties, parameters: &[f64], load: f64) -> Normal<f64> {
        let constants = Self::prepare(pair, parameters);
        Self::evaluate(&constants, (load / constants[0]).sqrt(), true)
    }

    fn energy<R: Real>(c: &[R; LAW_CONSTANTS], overlap: R) -> R {
        let alpha = overlap.max(R::zero());
        c[0] * alpha * alpha * alpha / R::splat(3.0)
    }
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // Case files that are read with this registry can refer to the law by its name.
    let registry = Registry::standard().with_law(NormalKind::new(&Foundation))?;
    let case = registry.parse_case(
        "grains.count = 150\ngrains.material.interface_energy = 0\ncontact.normal = \"elastic-foundation\"\n\
         contact.tangential = \"no-slip\"\npreparation.solid_fraction = \"none\"\npreparation.unbalanced_force = 0.01\n\
         shear.deviator_strain = 0.03\nshear.inertial_number = 0.005\nrecording.states = 6",
        "case",
    )?;
    let test = Laboratory::here().with_registry(registry).test(&case)?;
    let ratio = test.record.series.column("stress_ratio")?;
    println!("q/p: {ratio:.3?}");
    assert!(ratio.iter().any(|ratio| *ratio > 0.3));
    Ok(())
}
