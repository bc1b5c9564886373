//! Elastic moduli of a sample, compared with effective-medium theory.

use granum_core::assembly::Matrix;
use granum_dem::config::{ContactModel, Grains};
use granum_dem::servo::CellControl;
use granum_dem::simulation::Simulation;
use granum_run::stiffness::{Probing, degradation, measure};

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
        let mut control = CellControl::fixed();
        for a in 0..3 {
            control.rate[a][a] = strain[a] / time;
        }
        s.set_control(control);
        s.advance(steps).unwrap();
        s.set_control(CellControl::fixed());
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

/// The 6 x 6 stiffness of a sample that was compressed isotropically: symmetric and nearly isotropic, its moduli those of the
/// probes above; grains that follow the strain of the cell give the effective medium.
#[test]
fn the_tensor_of_a_sample_has_the_moduli_of_single_probes() {
    let found = measure(sample(), &Probing::default()).unwrap();
    let [k, g] = effective_medium(sample());
    let (tensor, affine) = (&found.tensor, &found.affine);
    println!(
        "K {:.4e} ({:.4} of {k:.4e}), G {:.4e} ({:.4} of {g:.4e}), affine {:.5} {:.5}, anisotropy {:.4}, asymmetry {:.1e}, unsettled {:.1e}",
        tensor.bulk_modulus(),
        tensor.bulk_modulus() / k,
        tensor.shear_modulus(),
        tensor.shear_modulus() / g,
        affine.bulk_modulus() / k,
        affine.shear_modulus() / g,
        tensor.anisotropy().unwrap(),
        tensor.asymmetry(),
        found.unsettled,
    );
    assert!(found.settled);
    assert!(
        (affine.bulk_modulus() / k - 1.0).abs() < 2e-3 && (affine.shear_modulus() / g - 1.0).abs() < 5e-3
    );
    let s = response([1e-7; 3]);
    let bulk = (s[0][0] + s[1][1] + s[2][2]) / 9e-7;
    assert!((tensor.bulk_modulus() / bulk - 1.0).abs() < 0.01, "{bulk}");
    // Voigt's average over the sides of the cell and over single axes differ by the anisotropy of 300 grains.
    assert!((0.4..0.75).contains(&(tensor.shear_modulus() / g)));
    assert!(tensor.asymmetry() < 1e-3 && tensor.anisotropy().unwrap() < 0.2);
}

/// The secant modulus starts at the elastic one and falls with the strain.
#[test]
fn the_shear_modulus_falls_with_the_strain() {
    let curve = degradation(sample(), &[1e-6, 1e-5, 1e-4, 1e-3], &Probing::default()).unwrap();
    println!("{curve:?}");
    let elastic = measure(sample(), &Probing::default()).unwrap().tensor.shear_modulus();
    assert!(curve.windows(2).all(|pair| pair[1].shear_modulus < pair[0].shear_modulus));
    assert!((0.7..1.1).contains(&(curve[0].shear_modulus / elastic)), "{elastic}");
    assert!(curve[3].shear_modulus < 0.5 * elastic);
}

/// With adhesion and micro-slip (JKR, Mindlin and Deresiewicz) the elastic response has the bounds of the effective medium too.
#[test]
fn contacts_with_micro_slip_and_adhesion_have_an_elastic_response() {
    let grains = Grains::default().with(|grains| grains.count = 150);
    let sample = super::sample::prepared(&grains, &ContactModel::default());
    let found = measure(&sample, &Probing::default()).unwrap();
    let (tensor, affine) = (&found.tensor, &found.affine);
    println!(
        "JKR, Mindlin-Deresiewicz: K {:.4e} ({:.4} of affine), G {:.4e} ({:.4}), asymmetry {:.1e}, unsettled {:.1e}",
        tensor.bulk_modulus(),
        tensor.bulk_modulus() / affine.bulk_modulus(),
        tensor.shear_modulus(),
        tensor.shear_modulus() / affine.shear_modulus(),
        tensor.asymmetry(),
        found.unsettled,
    );
    assert!(found.settled);
    assert!((0.8..1.0).contains(&(tensor.bulk_modulus() / affine.bulk_modulus())));
    assert!((0.3..0.9).contains(&(tensor.shear_modulus() / affine.shear_modulus())));
}
