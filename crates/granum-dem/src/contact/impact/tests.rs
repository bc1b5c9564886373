//! Collisions compared with analytical solutions.

use super::collision::*;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::kind::{AdhesionKind, NormalKind, TangentialKind};
use crate::contact::evaluation::memory::Memory;
use crate::contact::law::pair_properties::PairProperties;
use crate::material::Material;

const DIAMETER: f64 = 1e-4;

fn contact(normal: NormalKind, tangential: TangentialKind, damping: f64) -> ContactModel {
    ContactModel::new(normal, tangential, damping)
}

fn smooth() -> Material {
    Material { interface_energy: 0.0, ..Material::default() }
}

#[test]
fn hertz_contact_time_is_analytic() {
    let hertz = contact(NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ, 0.0);
    let impact = collide(&hertz, &smooth(), DIAMETER, 0.1, 0.0).unwrap();
    // 2.86826569919533 (m*^2 / R* E*^2 v)^(1/5) for the glass spheres of the default material.
    assert!((impact.contact_time / 4.791886436e-7 - 1.0).abs() < 1e-9, "{}", impact.contact_time);
    assert!((impact.restitution - 1.0).abs() < 1e-9);
    assert!(impact.spin_out.abs() * DIAMETER < 1e-12 && impact.psi1 == 0.0 && !impact.sticks);
}

/// Thornton and Ning (1998): `e = (1 - (v_s / v)^2)^(1/2)` above the sticking velocity.
#[test]
fn adhesive_grains_rebound_or_stick() {
    let material = Material::default();
    let jkr = contact(NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ, 0.0);
    let pair = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0);
    let force = 1.5 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius;
    let radius = (3.0 * force * pair.effective_radius / pair.effective_modulus).cbrt();
    let length = radius * radius / pair.effective_radius;
    let sticking = 0.7175144750575 * (force * length / pair.effective_mass).sqrt();
    let table = [
        (1.0005, 0.0316109),
        (1.01, 0.1403708),
        (1.1, 0.4165978),
        (1.25, 0.6),
        (1.5, 0.7453560),
        (2.0, 0.8660254),
        (3.0, 0.9428090),
        (5.0, 0.9797959),
        (10.0, 0.9949874),
    ];
    for (ratio, printed) in table {
        let impact = collide(&jkr, &material, DIAMETER, ratio * sticking, 0.0).unwrap();
        let exact = (1.0f64 - 1.0 / (ratio * ratio)).sqrt();
        assert!((exact - printed).abs() < 6e-8);
        let error = impact.restitution - exact;
        println!(
            "v/v_s {ratio}: e {:.10}, off by {error:.1e}, {:.1e} s a step",
            impact.restitution, impact.time_step
        );
        // A relative error of the energy is amplified by 1 / e.
        assert!(error.abs() * exact < 1e-9, "{ratio}: {} {exact}", impact.restitution);
    }
    let stuck = collide(&jkr, &material, DIAMETER, 0.999 * sticking, 0.0).unwrap();
    assert!(stuck.sticks && stuck.restitution == 0.0 && stuck.contact_time.is_infinite());
}

#[test]
fn adhesive_contact_times() {
    let material = Material::default();
    let pair = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0);
    let jkr = contact(NormalKind::JKR, TangentialKind::NO_SLIP, 0.0);
    let unit = (pair.effective_mass * 1.067344605e-8 / 7.068583471e-5).sqrt();
    for (ratio, time) in [(1.5, 2.327835), (2.0, 2.080056), (5.0, 1.557234)] {
        let impact = collide(&jkr, &material, DIAMETER, ratio * 2.366148196e-2, 0.0).unwrap();
        assert!((impact.contact_time / unit / time - 1.0).abs() < 2e-6, "{}", impact.contact_time / unit);
    }
}

/// Wet grains separate when their bridge ruptures and lose the energy of the bridge at rupture: `v'^2 = v^2 - 2 E_c/m*`.
#[test]
fn wet_grains_lose_what_their_bridge_held() {
    let pair = PairProperties::new((&smooth(), 0.5 * DIAMETER), (&smooth(), 0.5 * DIAMETER), 0.0);
    for (normal, adhesion) in [
        (NormalKind::HERTZ, AdhesionKind::CAPILLARY_BRIDGE),
        (NormalKind::HOOKE, AdhesionKind::CAPILLARY_BRIDGE),
        (NormalKind::HERTZ, AdhesionKind::CAPILLARY_BRIDGE_FILMS),
    ] {
        let wet = ContactModel { adhesion, ..contact(normal, TangentialKind::NO_SLIP, 0.0) };
        let constants = wet.constants(&pair);
        let apart = wet.range(&constants);
        let mut bridged = Memory { adhesion: [1.0, 0.0, 0.0, 0.0], ..Memory::new() };
        wet.wet(&constants, 0.0, &mut bridged);
        let held = wet.adhesion.law().energy(&constants.adhesion, -apart, &bridged.adhesion);
        let least = (2.0 * held / pair.effective_mass).sqrt();
        for times in [1.2, 5.0] {
            let impact = collide(&wet, &smooth(), DIAMETER, times * least, 0.0).unwrap();
            let expected = (1.0f64 - 1.0 / (times * times)).sqrt();
            assert!((impact.restitution / expected - 1.0).abs() < 1e-5, "{normal}: {}", impact.restitution);
        }
        let slow = collide(&wet, &smooth(), DIAMETER, 0.9 * least, 0.0).unwrap();
        assert!(slow.sticks, "{normal}: {slow:?}");
    }
}

/// Restitution of Hertz spheres with `zeta = (5/6)^(1/2) beta`, `beta = -ln e / (pi^2 + ln^2 e)^(1/2)`.
#[test]
fn damping_gives_the_restitution() {
    for restitution in [0.9f64, 0.7, 0.5, 0.3] {
        let log = restitution.ln();
        let beta = -log / (std::f64::consts::PI.powi(2) + log * log).sqrt();
        let hertz = contact(NormalKind::HERTZ, TangentialKind::NO_SLIP, (5.0f64 / 6.0).sqrt() * beta);
        let impact = collide(&hertz, &smooth(), DIAMETER, 0.1, 0.0).unwrap();
        println!("e {restitution}: {:.7}", impact.restitution);
        assert!((impact.restitution - restitution).abs() < 1e-6, "{}", impact.restitution);
    }
}

#[test]
fn gross_slip_does_not_depend_on_the_law() {
    let material = smooth();
    for tangential in [TangentialKind::MINDLIN_DERESIEWICZ, TangentialKind::NO_SLIP] {
        let law = contact(NormalKind::HERTZ, tangential, 0.0);
        let impact = collide(&law, &material, DIAMETER, 1e-4, 75.0).unwrap();
        assert!((impact.psi2 - (impact.psi1 - 4.0 * 1.441_176_470_588)).abs() < 1e-4);
        // The impulse mu J_n spins both grains: 2.5 mu (1 + e) m* v_n / (m R).
        let spin = 2.5 * 0.3 * impact.normal_velocity_in / 5e-5;
        assert!((impact.spin_out / spin - 1.0).abs() < 1e-4, "{} {spin}", impact.spin_out);
    }
}

#[test]
fn an_impact_that_no_step_settles_is_answered_with_its_uncertainty() {
    // The grains barely separate after many oscillations of the bond: those of the paper near their sticking velocity.
    let law = ContactModel::default();
    let impact = collide(&law, &Material::default(), DIAMETER, 0.09, 5.0).unwrap();
    assert!(impact.uncertainty > AGREEMENT, "{}", impact.uncertainty);
    let clear = collide(&law, &Material::default(), DIAMETER, 1.0, 30.0).unwrap();
    assert!(clear.uncertainty < AGREEMENT, "{}", clear.uncertainty);
}

/// Grains that graze each other have passed before the time of a central impact is over, and are told from those whose overlap is
/// nothing but rounding.
#[test]
fn a_grazing_impact_is_resolved_or_called_uncertain() {
    let hertz = contact(NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ, 0.1);
    for angle in [89.9, 89.99] {
        let impact = collide(&hertz, &smooth(), DIAMETER, 0.1, angle).unwrap();
        println!("{angle} deg: {:.6} uncertain by {:.1e}", impact.restitution, impact.uncertainty);
        assert!(impact.uncertainty < 3e-4, "{angle}: {}", impact.uncertainty);
        assert!(impact.restitution > 0.5 && impact.restitution < 1.0, "{angle}: {}", impact.restitution);
    }
    let lost = collide(&hertz, &smooth(), DIAMETER, 0.1, 89.999_999_99).unwrap();
    assert!(lost.uncertainty > AGREEMENT, "{} {}", lost.uncertainty, lost.restitution);
}

#[test]
fn refuses_what_is_no_collision() {
    let hertz = contact(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.0);
    let run = |speed, angle| collide(&hertz, &smooth(), DIAMETER, speed, angle).unwrap_err().to_string();
    assert!(run(0.0, 10.0).starts_with("speed is 0 m/s"));
    assert!(run(f64::NAN, 10.0).starts_with("speed is NaN"));
    assert!(run(0.1, 90.0).starts_with("angle is 90 degrees"));
    assert!(run(0.1, -1.0).starts_with("angle is -1 degrees"));
}
