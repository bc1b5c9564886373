//! Savkoor and Briggs (1977) peeling, followed by Mindlin-Deresiewicz.

use super::*;

/// Approach under a load on the stable branch, m.
fn approach_of(pair: &PairProperties, load: f64) -> f64 {
    let c = Jkr::prepare(pair, &[]);
    let unit = 1.5 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius;
    let s = 0.5 * (1.0 + (1.0 + load).sqrt());
    let radius = (3.0 * unit * pair.effective_radius / pair.effective_modulus).cbrt();
    let h = s.cbrt() * (s - 2.0 / 3.0);
    let alpha = h * radius * radius / pair.effective_radius;
    assert!((Jkr::evaluate(&c, alpha, true).force / unit - load).abs() < 1e-8 * load.abs().max(1.0));
    alpha
}

/// The largest force before the first slip and the force long afterwards, over the pull-off force.
fn shear(friction: f64, load: f64) -> (f64, f64) {
    let pair = PairProperties { friction, ..spheres(0.6) };
    let unit = 1.5 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius;
    let approach = approach_of(&pair, load);
    let mut bench = Bench::new((NormalKind::JKR, TangentialKind::PEELING), pair);
    bench.step(approach, [0.0; 2]);
    let mut peak = 0.0f64;
    let step = 2e-5 * pair.friction * (load + 2.0) * unit / (8.0 * pair.effective_shear_modulus * 5e-7);
    let mut last = 0.0;
    for _ in 0..400_000 {
        last = tangential(&bench.step(approach, [step, 0.0]))[0] / unit;
        if bench.memory.history[8] != 0.0 {
            peak = peak.max(last);
            break;
        }
        peak = peak.max(last);
    }
    for _ in 0..400_000 {
        last = tangential(&bench.step(approach, [step, 0.0]))[0] / unit;
    }
    (peak, last)
}

fn critical(load: f64) -> f64 {
    // 4 ((N N_c + N_c^2) G* / E*)^(1/2), G*/E* = 0.2058824 at nu = 0.3.
    4.0 * ((load + 1.0) * (0.7 / 3.4)).sqrt()
}

/// At the mean load of the paper's sample the first slip needs a force of 3.55 N_c, the sliding after it 1.45 N_c.
#[test]
fn first_slip_needs_the_peeling_force() {
    let (peak, after) = shear(0.3, 2.829421);
    println!(
        "N 2.83 N_c: peak before the drop {peak:.4} N_c (T_c {:.4}), sliding {after:.4}",
        critical(2.829421)
    );
    assert!((critical(2.829421) - 3.55).abs() < 0.005);
    assert!((peak / critical(2.829421) - 1.0).abs() < 1e-3, "{peak}");
    assert!((after / (0.3 * 4.829421) - 1.0).abs() < 1e-10, "{after}");
}

/// T_c = T_s at these loads: at lower loads the force drops, at higher loads it increases to T_s.
#[test]
fn drop_and_hold_meet_where_the_table_says() {
    for (friction, load) in [(0.3, 33.572), (0.1, 326.41), (0.5, 10.086)] {
        assert!((critical(load) / (friction * (load + 2.0)) - 1.0f64).abs() < 2e-5, "{friction}");
        let (below, below_after) = shear(friction, 0.9 * load);
        let (above, above_after) = shear(friction, 1.1 * load);
        println!(
            "mu {friction}: below {below:.3} then {below_after:.3}, above {above:.3} then {above_after:.3} N_c"
        );
        assert!(below > below_after * (1.0 + 1e-3));
        assert!(above < above_after * (1.0 - 1e-3));
        assert!((above_after / (friction * (1.1 * load + 2.0)) - 1.0).abs() < 1e-10);
    }
}

/// During peeling nothing is lost to slip, and the force returns along the same curve.
#[test]
fn peeling_is_reversible() {
    let pair = spheres(0.6);
    let approach = approach_of(&pair, 2.0);
    let mut bench = Bench::new((NormalKind::JKR, TangentialKind::PEELING), pair);
    bench.step(approach, [0.0; 2]);
    let (n, step) = (20_000, 1e-14);
    let (mut work, mut stored) = (0.0, 0.0f64);
    for k in 0..2 * n {
        let out = bench.step(approach, [if k < n { step } else { -step }, 0.0]);
        work += out.tangential_work;
        stored = stored.max(work);
        assert!(!out.sliding && out.friction_loss == 0.0);
    }
    assert!(work.abs() < 1e-3 * stored, "{work} {stored}");
}

/// The radius that carries the tangential force: equation of Savkoor and Briggs, then that of N + 2 N_c.
#[test]
fn the_contact_shrinks_as_it_peels() {
    let pair = spheres(0.6);
    let unit = 1.5 * std::f64::consts::PI * pair.interface_energy * pair.effective_radius;
    let approach = approach_of(&pair, 2.0);
    let mut bench = Bench::new((NormalKind::JKR, TangentialKind::PEELING), pair);
    bench.step(approach, [0.0; 2]);
    for _ in 0..40_000 {
        let before = tangential(&bench.step(approach, [0.0; 2]))[0] / unit;
        let out = bench.step(approach, [2e-13, 0.0]);
        let fresh = bench.memory.history[8] == 0.0;
        let root = if fresh { (12.0 - before * before * 0.25 * 3.4 / 0.7f64).max(0.0).sqrt() } else { 0.0 };
        let radius =
            (3.0 * pair.effective_radius * unit * (4.0 + root) / (4.0 * pair.effective_modulus)).cbrt();
        let found = out.tangential_stiffness / (8.0 * pair.effective_shear_modulus);
        if fresh {
            assert!((found / radius - 1.0).abs() < 1e-7, "{found} {radius}");
        }
    }
    let out = bench.step(approach, [2e-13, 0.0]);
    assert_eq!(bench.memory.history[8], 2.0);
    let radius = (3.0 * pair.effective_radius * unit * 4.0 / (4.0 * pair.effective_modulus)).cbrt();
    assert!((out.tangential_stiffness / (8.0 * pair.effective_shear_modulus * radius) - 1.0).abs() < 1e-9);
}
