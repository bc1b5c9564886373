//! Normal laws compared with analytical solutions: the JKR table, Hertz, energies, limits, unlike grains.

use super::*;
use proptest::prelude::*;

const PULL_OFF: f64 = 7.068583471e-5;
const RADIUS: f64 = 5.165618563e-7;
const LENGTH: f64 = 1.067344605e-8;

/// Approach over d_0, radius over a_0, force over N_c, stiffness over 2 E* a (40-digit roots).
#[allow(clippy::excessive_precision)]
const JKR: [(f64, f64, f64, f64); 15] = [
    (-0.275160604074552224, 0.302853432138689943, -0.555555555555555556, f64::NEG_INFINITY),
    (-0.27, 0.362384558497366075, -0.682241526588583842, -5.47463093988),
    (-0.2, 0.537268343598665388, -0.954894842218966163, -0.467501353717),
    (-0.132283420997349956, 0.629960524947436582, -1.0, 0.0),
    (-0.1, 0.66654407488631669, -0.99219218622140964, 0.117031124356),
    (0.0, 0.763142828368887912, -0.888888888888888889, 1.0 / 3.0),
    (0.1, 0.844095943140854638, -0.69637571125091343, 0.452514292268),
    (1.0 / 3.0, 1.0, 0.0, 0.6),
    (0.5, 1.09424624133001203, 0.662292895022718152, 0.659162454631),
    (1.0, 1.3299736417598827, 3.27484759556083434, 0.756178181898),
    (2.0, 1.69337906600564624, 10.6089092329875628, 0.836354700512),
    (5.0, 2.45873056413851008, 44.0341138513440469, 0.909634083995),
    (20.0, 4.62973592590624544, 357.096580751186898, 0.965969217084),
    (100.0, 10.1054078066621161, 3999.33100932636162, 0.989569453646),
    (-0.2, 0.0990455512648090028, -0.120797939438139321, f64::NAN),
];

/// d_0, a_0 and N_c of the law, computed from the definitions of its constants.
fn units(pair: &PairProperties) -> (f64, f64, f64) {
    let force = 1.5 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius;
    let radius = (3.0 * force * pair.effective_radius / pair.effective_modulus).cbrt();
    (radius * radius / pair.effective_radius, radius, force)
}

#[test]
fn jkr_units_are_those_of_the_table() {
    let (length, radius, force) = units(&spheres(0.6));
    assert!((length / LENGTH - 1.0).abs() < 1e-9);
    assert!((radius / RADIUS - 1.0).abs() < 1e-9);
    assert!((force / PULL_OFF - 1.0).abs() < 1e-9);
    let c = Jkr::prepare(&spheres(0.6), &[]);
    assert!((Jkr::breaking_overlap(&c) / -2.936911864e-9 - 1.0).abs() < 1e-9);
    let lost = Jkr::losses(&c).made + Jkr::losses(&c).broken;
    assert!((lost / 1.942085691e-13 - 1.0).abs() < 1e-9);
}

#[test]
fn jkr_follows_the_table() {
    let pair = spheres(0.6);
    let (length, unit_radius, unit_force) = units(&pair);
    let c = Jkr::prepare(&pair, &[]);
    let mut worst = [0.0f64; 3];
    for (h, radius, force, stiffness) in JKR {
        if stiffness.is_nan() {
            // The solution on the unstable branch also satisfies the equations; the law takes the other one.
            let x = radius.sqrt();
            assert!((x.powi(4) - 2.0 / 3.0 * x - h).abs() < 1e-15);
            assert!((4.0 * x.powi(3) * (x.powi(3) - 1.0) - force).abs() < 1e-15);
            let n = Jkr::evaluate(&c, h * length, true);
            assert!(n.radius > 5.0 * radius * unit_radius);
            continue;
        }
        // Slightly inside the breaking point, where rounding decides which pairs touch.
        let inside = if stiffness.is_infinite() { h + 1e-15 } else { h };
        let n = Jkr::evaluate(&c, inside * length, true);
        assert!(n.touching);
        worst[0] = worst[0].max((n.radius / unit_radius / radius - 1.0).abs());
        worst[1] = worst[1].max((n.force / unit_force - force).abs() / force.abs().max(1.0));
        if stiffness > 0.1 {
            let found = n.stiffness / (2.0 * pair.effective_modulus * n.radius);
            worst[2] = worst[2].max((found - stiffness).abs());
        } else {
            // The law keeps it positive for the dashpot.
            assert!((n.stiffness / (0.2 * pair.effective_modulus * n.radius) - 1.0).abs() < 1e-12);
        }
        assert!((n.root_stiffness * n.root_stiffness / n.stiffness - 1.0).abs() < 1e-14);
        assert!((n.root_tangential_measure * n.root_tangential_measure / n.radius - 1.0).abs() < 1e-14);
    }
    println!(
        "JKR table, largest errors: radius {:.1e}, force {:.1e}, stiffness {:.1e}",
        worst[0], worst[1], worst[2]
    );
    // The error of the radius at the breaking point is the square root of the 1e-15 above.
    assert!(worst[0] < 2e-7 && worst[1] < 1e-7 && worst[2] < 1e-11, "{worst:?}");
}

/// The force over the whole range, compared with that at a chosen x and its exact approach.
#[test]
fn jkr_inversion_is_accurate() {
    let pair = spheres(0.6);
    let (length, _, unit_force) = units(&pair);
    let c = Jkr::prepare(&pair, &[]);
    let least = 6f64.powf(-1.0 / 3.0);
    let mut worst = [0.0f64; 4];
    for k in 0..200_000 {
        let x = least + 10f64.powf(-6.0 + 9.0 * k as f64 / 199_999.0);
        let h = x * (x * x * x - 2.0 / 3.0);
        let s = x * x * x;
        let force = 4.0 * s * (s - 1.0);
        let n = Jkr::evaluate(&c, h * length, true);
        let error = (n.force / unit_force - force).abs() / force.abs().max(1.0);
        // The rounding error of h itself (1e-16 of its terms) is multiplied by dN/dh.
        let t = h + 0.275160604074552;
        let band = if t < 1e-6 {
            0
        } else if t < 1e-3 {
            1
        } else if h < 64.0 {
            2
        } else {
            3
        };
        worst[band] = worst[band].max(error);
    }
    println!(
        "JKR force over max(N_c, N): to 1e-6 of the break {:.1e}, to 1e-3 {:.1e}, to 64 {:.1e}, beyond {:.1e}",
        worst[0], worst[1], worst[2], worst[3]
    );
    assert!(worst[0] < 2e-10 && worst[1] < 2e-12 && worst[2] < 1e-13 && worst[3] < 1e-14, "{worst:?}");
}

#[test]
fn a_contact_is_made_at_zero_and_broken_at_the_end() {
    let pair = spheres(0.6);
    let c = Jkr::prepare(&pair, &[]);
    let end = Jkr::breaking_overlap(&c);
    for (approach, touched, touching) in [
        (1e-15, false, true),
        (0.0, false, false),
        (-1e-12, false, false),
        (-1e-12, true, true),
        (end * (1.0 - 1e-9), true, true),
        (end * (1.0 + 1e-9), true, false),
        (end * (1.0 - 1e-9), false, false),
    ] {
        let n = Jkr::evaluate(&c, approach, touched);
        assert_eq!(n.touching, touching, "{approach} {touched}");
        if !touching {
            assert_eq!((n.force, n.radius, n.friction_load, n.stiffness), (0.0, 0.0, 0.0, 0.0));
        }
    }
    let made = Jkr::evaluate(&c, 1e-18, false);
    assert!((made.force / PULL_OFF + 8.0 / 9.0).abs() < 1e-8);
}

/// Integral of the force by three-point Gauss quadrature on fine intervals.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    let n = 4000;
    let (h, offset) = ((to - from) / n as f64, 0.6f64.sqrt() / 2.0);
    (0..n)
        .map(|k| {
            let middle = from + (k as f64 + 0.5) * h;
            h * (5.0 * f(middle - offset * h) + 8.0 * f(middle) + 5.0 * f(middle + offset * h)) / 18.0
        })
        .sum()
}

#[test]
fn energies_are_integrals_of_the_force() {
    let pair = spheres(0.6);
    let (h, j) = (Hertz::prepare(&pair, &[]), Jkr::prepare(&pair, &[]));
    // The energy that the surfaces release at first contact is lost before any force can absorb it.
    let made = Jkr::losses(&j).made;
    for approach in [1e-10, 1e-8, 5e-7] {
        let hertz = integral(0.0, approach, |a| Hertz::evaluate(&h, a, true).force);
        assert!((Hertz::energy(&h, approach) / hertz - 1.0).abs() < 1e-6);
        let jkr = integral(0.0, approach, |a| Jkr::evaluate(&j, a, true).force);
        assert!(((Jkr::energy(&j, approach) + made) / jkr - 1.0).abs() < 1e-8);
    }
    let end = Jkr::breaking_overlap(&j);
    // The stiffness is infinite at the breaking point: the square root of the distance is the integration variable.
    let jkr = integral(0.0, 1.0, |u| Jkr::evaluate(&j, end * (1.0 - u * u), true).force * 2.0 * u * end);
    // From first contact to breaking the bond is in tension: the work against it is the loss by making and breaking the
    // contact.
    assert!(((made + Jkr::losses(&j).broken) / jkr - 1.0).abs() < 1e-8);
    assert!((Jkr::energy(&j, end * (1.0 - 1e-12)) / Jkr::losses(&j).broken - 1.0).abs() < 1e-6);
}

#[test]
fn states_of_the_sample_have_their_stiffness() {
    let pair = spheres(0.6);
    let c = Jkr::prepare(&pair, &[]);
    // Force, radius, approach over the diameter, k_n, k_t.
    for (force, radius, approach, normal, tangential) in [
        (0.0, 5.16562e-7, 3.557815352e-5, 2.384132e4, 3.272338e4),
        (2e-4, 6.70387e-7, 9.87e-5, 3.846436e4, 4.246798e4),
        (1e-3, 9.37754e-7, 2.56e-4, 6.158565e4, 5.940525e4),
    ] {
        // The printed approach has three digits: Newton iterations for the force.
        let mut alpha = approach * 1e-4;
        for _ in 0..20 {
            let n = Jkr::evaluate(&c, alpha, true);
            alpha -= (n.force - force) / n.stiffness;
        }
        let n = Jkr::evaluate(&c, alpha, true);
        assert!((alpha / (approach * 1e-4) - 1.0).abs() < 3e-3);
        assert!((n.radius / radius - 1.0).abs() < 1e-5);
        assert!((n.stiffness / normal - 1.0).abs() < 1e-6);
        assert!((8.0 * pair.effective_shear_modulus * n.radius / tangential - 1.0).abs() < 1e-6);
    }
    let h = Hertz::prepare(&pair, &[]);
    let alpha = (0.75 * 2e-4 / (pair.effective_modulus * pair.effective_radius.sqrt())).powf(2.0 / 3.0);
    let n = Hertz::evaluate(&h, alpha, false);
    assert!((n.force / 2e-4 - 1.0).abs() < 1e-12 && (n.radius / 4.60258e-7 - 1.0).abs() < 1e-5);
    assert!((n.stiffness / 3.540448e4 - 1.0).abs() < 1e-6);
}

/// Thornton (1991): both forms of the sliding force, their jump and crossing.
#[test]
fn friction_load_of_adhesive_contacts() {
    let pair = spheres(0.6);
    let (length, _, unit) = units(&pair);
    let c = Jkr::prepare(&pair, &[]);
    let at = |s: f64| {
        let x = s.cbrt();
        let n = Jkr::evaluate(&c, length * x * (s - 2.0 / 3.0), true);
        (n.force / unit, n.friction_load / unit)
    };
    let zone = |force: f64| {
        let first = force + 2.0 + (4.0 * force + 4.0).sqrt();
        first * (1.0 - (first - force) / (3.0 * first)).powf(1.5)
    };
    for s in [0.6, 0.7, 0.8, 0.9, 0.918, 0.919, 1.0, 2.0, 30.0] {
        let (force, load) = at(s);
        let expected = if force < -0.3 { zone(force) } else { force + 2.0 };
        assert!((load / expected - 1.0).abs() < 1e-12, "{s}: {load} {expected}");
    }
    assert!(((zone(-0.3) / 1.7 - 1.0).abs() - 0.0089).abs() < 5e-5);
    assert!((zone(-0.32523) - (2.0 - 0.32523)).abs() < 1e-5);
    // Without a zone in compression there is no friction.
    assert_eq!(at(0.3).1, 0.0);
    assert!(at(0.34).1 > 0.0);
}

proptest! {
    /// Without adhesion JKR is Hertz, from the smallest overlap to the largest.
    #[test]
    fn jkr_without_adhesion_is_hertz(exponent in -14.0f64..-1.0) {
        let pair = spheres(0.0);
        let (h, j) = (Hertz::prepare(&pair, &[]), Jkr::prepare(&pair, &[]));
        let alpha = 10f64.powf(exponent) * pair.effective_radius;
        let (a, b) = (Hertz::evaluate(&h, alpha, false), Jkr::evaluate(&j, alpha, false));
        prop_assert!((b.force / a.force - 1.0).abs() < 1e-11);
        prop_assert!((b.radius / a.radius - 1.0).abs() < 1e-11);
        prop_assert!((b.stiffness / a.stiffness - 1.0).abs() < 1e-11);
        prop_assert!((b.friction_load / a.friction_load - 1.0).abs() < 1e-11);
        prop_assert!((Jkr::energy(&j, alpha) / Hertz::energy(&h, alpha) - 1.0).abs() < 1e-11);
        prop_assert!(!Jkr::evaluate(&j, -alpha, true).touching);
        prop_assert_eq!(Jkr::losses(&j).made + Jkr::losses(&j).broken, 0.0);
    }

    #[test]
    fn weak_adhesion_tends_to_hertz(exponent in -9.0f64..-3.0) {
        let pair = spheres(10f64.powf(exponent));
        let (h, j) = (Hertz::prepare(&pair, &[]), Jkr::prepare(&pair, &[]));
        let (a, b) = (Hertz::evaluate(&h, 1e-7, false), Jkr::evaluate(&j, 1e-7, false));
        let (_, _, unit) = units(&pair);
        // N_1 = N + 2 N_c + (4 N N_c + 4 N_c^2)^(1/2) at the same radius: differences of the order of (N N_c)^(1/2).
        prop_assert!((b.force - a.force).abs() < 6.0 * (a.force * unit).sqrt());
    }
}

#[test]
fn unlike_grains_and_materials() {
    let stiff = Material::default();
    let soft = Material {
        youngs_modulus: 1e9,
        poissons_ratio: 0.45,
        density: 1000.0,
        friction: 0.6,
        interface_energy: 0.1,
    };
    let pair = PairProperties::new((&stiff, 5e-5), (&soft, 2e-4), 0.1);
    let compliance = (1.0 - 0.09) / 70e9 + (1.0 - 0.2025) / 1e9;
    let shear = 1.7 * 2.6 / 70e9 + 1.55 * 2.9 / 1e9;
    assert!((pair.effective_modulus * compliance - 1.0).abs() < 1e-14);
    assert!((pair.effective_shear_modulus * shear - 1.0).abs() < 1e-14);
    assert!(
        (pair.effective_radius / 4e-5 - 1.0).abs() < 1e-14 && (pair.radius_sum / 2.5e-4 - 1.0).abs() < 1e-14
    );
    let mass = |density: f64, radius: f64| density * 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
    let (a, b) = (mass(2650.0, 5e-5), mass(1000.0, 2e-4));
    assert!((pair.effective_mass * (1.0 / a + 1.0 / b) - 1.0).abs() < 1e-14);
    assert!((pair.friction - 0.18f64.sqrt()).abs() < 1e-15);
    assert!((pair.interface_energy - 0.06f64.sqrt()).abs() < 1e-15);
    assert_eq!(pair, PairProperties { ..PairProperties::new((&soft, 2e-4), (&stiff, 5e-5), 0.1) });
    // Equal spheres: section 1's closed forms.
    let equal = spheres(0.6);
    assert!((equal.effective_modulus / 3.846153846e10 - 1.0).abs() < 1e-9);
    assert!((equal.effective_shear_modulus / 7.918552036e9 - 1.0).abs() < 1e-9);
    assert!((equal.effective_mass / (1.387536755e-9 / 2.0) - 1.0).abs() < 1e-9);
    assert_eq!((equal.friction, equal.interface_energy), (0.3, 0.6));
    let mut bench = Bench::new((NormalKind::HERTZ, TangentialKind::NO_SLIP), pair);
    let out = bench.step(1e-8, [0.0; 2]);
    let force = 4.0 / 3.0 * pair.effective_modulus * (pair.effective_radius * 1e-8f64).sqrt() * 1e-8;
    assert!((out.normal_force / force - 1.0).abs() < 1e-11);
}
