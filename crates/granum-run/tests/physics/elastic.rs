//! Elastic moduli of a sample, compared with effective-medium theory.

use granum_core::assembly::Matrix;
use granum_dem::servo::Control;
use granum_dem::simulation::Simulation;

use super::sample::sample;

/// Change of the stress, Pa, in a small strain, compression positive; the relaxation that also takes place without strain is
/// subtracted.
fn response(strain: [f64; 3]) -> Matrix {
    let end = |strain: [f64; 3]| {
        let mut s = sample().clone();
        let steps = 4000;
        let time = steps as f64 * s.state().time_step();
        s.fix_time_step(Some(s.state().time_step()));
        // As in a preparation, the damping is slow compared with the vibrations of a contact.
        s.set_global_damping(1e-3 / s.state().time_step());
        let mut control = Control::fixed();
        for a in 0..3 {
            control.rate[a][a] = strain[a] / time;
        }
        s.set_control(control);
        s.advance(steps).unwrap();
        s.set_control(Control::fixed());
        s.advance(12_000).unwrap();
        s.state().stress()
    };
    let (still, strained) = (end([0.0; 3]), end(strain));
    std::array::from_fn(|i| std::array::from_fn(|j| strained[i][j] - still[i][j]))
}

/// Bulk and shear modulus of effective-medium theory (Walton 1987, no slip), from the stiffness of every contact:
/// `K = sum k_n D^2 / 9 V` and `G = sum (k_n + 3/2 k_t) D^2 / 15 V`.
fn effective_medium(s: &Simulation) -> [f64; 2] {
    let material = s.properties().material;
    let (e, nu) = (material.youngs_modulus, material.poissons_ratio);
    let normal = 2.0 * 0.5 * e / (1.0 - nu * nu);
    let tangential = 8.0 * 0.5 * e / (2.0 * (1.0 + nu) * (2.0 - nu));
    let a = s.assembly();
    let sum: f64 = a.contacts.iter().map(|c| c.radius * c.branch.iter().map(|x| x * x).sum::<f64>()).sum();
    let v = a.volume();
    [normal * sum / (9.0 * v), (normal + 1.5 * tangential) * sum / (15.0 * v)]
}

#[test]
fn moduli_are_below_those_of_the_effective_medium() {
    let e = 1e-7;
    let s = response([e; 3]);
    let bulk = (s[0][0] + s[1][1] + s[2][2]) / (9.0 * e);
    let s = response([e, -0.5 * e, -0.5 * e]);
    let shear = (s[0][0] - 0.5 * (s[1][1] + s[2][2])) / (3.0 * e);
    let s = response([2.0 * e, -e, -e]);
    let twice = (s[0][0] - 0.5 * (s[1][1] + s[2][2])) / (6.0 * e);
    let [k, g] = effective_medium(sample());
    let z = 2.0 * sample().assembly().contacts.len() as f64 / 300.0;
    println!(
        "Z {z:.3}: K {bulk:.4e} of {k:.4e} ({:.3}), G {shear:.4e} of {g:.4e} ({:.3}), twice the strain {:.4}",
        bulk / k,
        shear / g,
        twice / shear
    );
    assert!((sample().state().bulk_modulus() / k - 1.0).abs() < 1e-3);
    assert!((0.85..1.0).contains(&(bulk / k)), "{}", bulk / k);
    assert!((0.4..0.75).contains(&(shear / g)), "{}", shear / g);
    assert!((twice / shear - 1.0).abs() < 0.02, "{}", twice / shear);
}
