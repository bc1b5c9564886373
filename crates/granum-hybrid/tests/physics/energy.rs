//! Energy over whole tests.

use granum_dem::assembly::{Assembly, Contact as Pair};
use granum_dem::config::{Contact, Grains, Material, NormalKind, TangentialKind};
use granum_dem::gas::gas;
use granum_dem::simulation::Simulation;

use super::sample::{compress, prepared, properties};

fn kinetic(assembly: &Assembly) -> f64 {
    let square = |v: &[f64; 3]| v.iter().map(|x| x * x).sum::<f64>();
    let of = |g: &granum_dem::assembly::Grain| {
        0.5 * g.mass * (square(&g.velocity) + 0.4 * g.radius * g.radius * square(&g.spin))
    };
    assembly.grains.iter().map(of).sum()
}

fn stored(assembly: &Assembly, energy: fn(&Pair) -> f64) -> f64 {
    assembly.contacts.iter().map(energy).sum()
}

/// What became of the boundary's work since the start: kinetic, elastic normal, elastic tangential, friction, micro-slip,
/// damping, adhesion.
fn mechanisms(start: &Assembly, now: &Assembly) -> [f64; 7] {
    let tangential = stored(now, |c| c.tangential_energy) - stored(start, |c| c.tangential_energy);
    let e = &now.energy;
    [
        kinetic(now) - kinetic(start),
        stored(now, |c| c.normal_energy) - stored(start, |c| c.normal_energy),
        tangential,
        e.friction,
        e.tangential_work - tangential - e.friction,
        e.damping,
        e.adhesion,
    ]
}

/// The paper's laws over a whole test: at every state the mechanisms add up to the work of the boundary, losses only
/// grow, and adhesion is lost in whole breaks of a contact.
#[test]
fn the_ledger_closes_by_mechanism() {
    let material = Material::default();
    let grains = Grains { count: 200, material, ..Grains::default() };
    let mut s = prepared(&grains, &Contact::default());
    compress(&mut s, 0, 1e-3);
    let start = s.assembly();
    let mut states = Vec::new();
    while s.state().deviator_strain() < 0.05 {
        s.advance(1000).unwrap();
        states.push((s.assembly().energy.boundary_work, mechanisms(&start, &s.assembly())));
    }
    let whole = states[states.len() - 1].0;
    let gap = |&(work, parts): &(f64, [f64; 7])| (work - parts.iter().sum::<f64>()).abs() / whole;
    let worst = states.iter().map(gap).fold(0.0, f64::max);
    let shares = states[states.len() - 1].1.map(|part| part / whole);
    println!(
        "gap {worst:.2e}; kinetic, normal, tangential, friction, micro-slip, damping, adhesion: {shares:.5?}"
    );
    assert!(worst < 1e-4, "{worst}");
    for pair in states.windows(2) {
        for loss in [3, 5, 6] {
            assert!(pair[1].1[loss] >= pair[0].1[loss], "loss {loss} fell");
        }
    }
    assert!(shares[3] > 0.3 && shares[4] > 0.0 && shares[5] > 0.0 && shares[6] > 0.0, "{shares:?}");
    // 0.25741 N_c d_0 of the default material (table viii of the theory chapter).
    let breaks = s.assembly().energy.adhesion / 1.942085691e-13;
    assert!((breaks - breaks.round()).abs() < 1e-3 && breaks > 10.0, "{breaks}");
}

/// Kinetic and elastic energy, the velocities brought from half a step before to the time of the positions.
fn synchronous(s: &Simulation) -> f64 {
    let a = s.assembly();
    let half = 0.5 * a.time_step;
    let kinetic: f64 = (a.grains.iter())
        .map(|g| {
            let v: [f64; 3] = std::array::from_fn(|k| g.velocity[k] + half * g.force[k] / g.mass);
            0.5 * g.mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        })
        .sum();
    kinetic + stored(&a, |c| c.normal_energy)
}

/// A frictionless gas without dashpots keeps its energy over 10^6 steps: it neither drifts nor wanders.
#[test]
fn an_elastic_gas_keeps_its_energy_over_a_million_steps() {
    let grains = Grains { count: 16, ..Grains::default() };
    let (cell, sites) = gas(&grains, 0.3, 7).unwrap();
    let mut s = Simulation::new(cell, &sites, properties(0.0, 0.0)).unwrap();
    let velocities: Vec<[f64; 3]> =
        (0..16).map(|k| [k as f64 * 0.7, k as f64 * 1.3, k as f64 * 2.1].map(f64::sin)).collect();
    s.set_velocities(&velocities, &[]);
    s.fix_time_step(Some(1e-9));
    let start = synchronous(&s);
    let mut errors = Vec::new();
    let mut touching = 0;
    for _ in 0..1000 {
        s.advance(1000).unwrap();
        errors.push(synchronous(&s) / start - 1.0);
        touching += usize::from(s.state().contacts() > 0);
    }
    let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
    let drift = mean(&errors[900..]) - mean(&errors[..100]);
    let worst = errors.iter().fold(0.0f64, |m, e| m.max(e.abs()));
    println!("drift {drift:.2e}, worst {worst:.2e}, in contact at {touching} of 1000 looks");
    assert!(touching > 100);
    assert!(drift.abs() < 1e-4 && worst < 1e-3, "drift {drift}, worst {worst}");
}

/// Hertz without adhesion loses nothing to it; the law without micro-slip loses to friction and to shrinking contacts.
#[test]
fn without_adhesion_nothing_is_lost_to_it() {
    let mut s = super::sample::sample().clone();
    assert_eq!(s.properties().contact.normal, NormalKind::Hertz);
    assert_eq!(s.properties().contact.tangential, TangentialKind::NoSlip);
    compress(&mut s, 0, 2e-3);
    let start = s.assembly();
    while s.state().deviator_strain() < 0.02 {
        s.advance(500).unwrap();
    }
    let now = s.assembly();
    let parts = mechanisms(&start, &now);
    let work = now.energy.boundary_work;
    let gap = (work - parts.iter().sum::<f64>()) / work;
    println!("gap {gap:.2e}; shares {:.5?}", parts.map(|p| p / work));
    assert_eq!(parts[6], 0.0);
    assert!(gap.abs() < 1e-4, "{gap}");
}
