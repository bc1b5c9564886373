//! The energy balance over whole tests.

use granum_core::assembly::{Assembly, Contact as Pair};
use granum_dem::config::{ContactModel, Grains, Material, NormalKind, TangentialKind};
use granum_dem::random_insertion::random_insertion;
use granum_dem::servo::CellControl;
use granum_dem::simulation::Simulation;

use super::sample::{compress, prepared, properties};

fn kinetic(assembly: &Assembly) -> f64 {
    assembly.kinetic_energy()
}

fn stored(assembly: &Assembly, energy: fn(&Pair) -> f64) -> f64 {
    assembly.contacts.iter().map(energy).sum()
}

/// The work of the boundary since the start, split by mechanism: kinetic energy, elastic energy of the normal forces,
/// elastic energy of the tangential forces, friction, micro-slip, damping, adhesion.
fn mechanisms(start: &Assembly, now: &Assembly) -> [f64; 8] {
    let tangential = stored(now, |c| c.tangential_energy) - stored(start, |c| c.tangential_energy);
    let e = &now.energy;
    [
        kinetic(now) - kinetic(start),
        stored(now, |c| c.normal_energy) - stored(start, |c| c.normal_energy),
        tangential,
        e.friction,
        e.micro_slip,
        e.damping,
        e.adhesion_made,
        e.adhesion_broken,
    ]
}

const NAMES: [&str; 8] = [
    "kinetic",
    "normal",
    "tangential",
    "friction",
    "micro-slip",
    "damping",
    "adhesion made",
    "adhesion broken",
];

/// A whole test with the laws of the paper: at every state the mechanisms add up to the work of the boundary, losses only
/// grow, and the loss to adhesion is an integer multiple of the loss in making or breaking one contact.
#[test]
fn the_energy_balance_closes_by_mechanism() {
    let material = Material::default();
    let grains = Grains::default().with(|grains| {
        grains.count = 200;
        grains.material = material;
    });
    let mut s = prepared(&grains, &ContactModel::default());
    compress(&mut s, 0, 1e-3);
    let start = s.assembly();
    let mut states = Vec::new();
    while s.state().deviator_strain() < 0.05 {
        s.advance(1000).unwrap();
        let now = s.assembly();
        states.push((now.energy.boundary_work, mechanisms(&start, &now), now.energy.tangential_work));
    }
    let (whole, last, _) = states[states.len() - 1];
    // First the work of the tangential forces as a whole is used, then its split into mechanisms.
    let (mut worst, mut worst_split) = (0.0f64, 0.0f64);
    for (work, parts, tangential) in &states {
        let others: f64 = [0, 1, 5, 6, 7].map(|k: usize| parts[k]).iter().sum();
        worst = worst.max(((work - others - tangential) / whole).abs());
        worst_split = worst_split.max(((tangential - parts[2] - parts[3] - parts[4]) / whole).abs());
    }
    println!("gap {worst:.2e}, of the tangential parts {worst_split:.2e}");
    for (name, part) in NAMES.iter().zip(last) {
        println!("{name}: {:.5}", part / whole);
    }
    assert!(worst < 1e-4, "{worst}");
    assert!(worst_split < 5e-4, "{worst_split}");
    for pair in states.windows(2) {
        for loss in 3..8 {
            assert!(pair[1].1[loss] >= pair[0].1[loss], "{} fell", NAMES[loss]);
        }
    }
    assert!(last[3] > 0.3 * whole && last[4..].iter().all(|loss| *loss > 0.0), "{last:?}");
    // 0.25741 N_c d_0 of the default material (table viii of the theory chapter), in its two parts.
    let unit = 1.942085691e-13 / 0.257413510958529;
    for (lost, each) in [(last[6], 0.2329547905963464), (last[7], 0.02445872036218242)] {
        let count = lost / (each * unit);
        assert!((count - count.round()).abs() < 1e-3 && count > 10.0, "{count}");
    }
}

/// Kinetic and elastic energy; the velocities, which are half a step behind, are advanced to the time of the positions.
fn synchronous(s: &Simulation) -> f64 {
    let a = s.assembly();
    let half = 0.5 * a.time_step;
    let kinetic: f64 = (a.bodies.iter())
        .map(|g| {
            let v: [f64; 3] = std::array::from_fn(|k| g.velocity[k] + half * g.force[k] / g.mass);
            0.5 * g.mass * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
        })
        .sum();
    kinetic + stored(&a, |c| c.normal_energy)
}

/// A frictionless granular gas without dashpots conserves its energy over 10^6 steps, with neither drift nor random walk.
#[test]
fn an_elastic_gas_keeps_its_energy_over_a_million_steps() {
    let grains = Grains::default().with(|grains| grains.count = 16);
    let (cell, spheres) = random_insertion(&grains, 0.3, 7).unwrap();
    let mut s = Simulation::new(cell, &spheres, properties(0.0, 0.0)).unwrap();
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
    println!("drift {drift:.2e}, worst {worst:.2e}, in contact at {touching} of 1000 observations");
    assert!(touching > 100);
    assert!(drift.abs() < 1e-4 && worst < 1e-3, "drift {drift}, worst {worst}");
}

/// Hertz contacts lose no energy to adhesion; the law without micro-slip loses energy to friction and to shrinking contacts.
#[test]
fn without_adhesion_nothing_is_lost_to_it() {
    let mut s = super::sample::sample().clone();
    assert_eq!(s.properties().contact.normal, NormalKind::HERTZ);
    assert_eq!(s.properties().contact.tangential, TangentialKind::NO_SLIP);
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
    assert_eq!(parts[6..], [0.0; 2]);
    assert!(gap.abs() < 1e-4, "{gap}");
}

/// A test at twice the stress of the sample: the servo compresses the cell within a few steps, and the energy balance still
/// closes.
#[test]
fn a_jump_of_the_stress_is_accounted_for() {
    let mut s = super::sample::sample().clone();
    let target = 2.0 * s.state().mean_stress();
    s.set_control(CellControl::constant_mean_stress(0, 100.0, target, 3000.0));
    let start = s.assembly();
    let gap = |s: &Simulation| {
        let parts = mechanisms(&start, &s.assembly());
        let now = s.assembly().energy;
        let others: f64 = [0, 1, 5, 6, 7].map(|k: usize| parts[k]).iter().sum();
        (now.boundary_work - now.tangential_work - others) / now.boundary_work
    };
    // The velocity gradient jumps in the first steps; an error there would later be hidden by the much larger work.
    s.advance(11).unwrap();
    let early = gap(&s);
    assert!(early.abs() < 2e-3, "{early}");
    s.advance(2000).unwrap();
    assert!((s.state().mean_stress() / target - 1.0).abs() < 0.1, "{}", s.state().mean_stress());
    let gap = gap(&s);
    println!("gap {gap:.2e} after a jump of the stress");
    assert!(gap.abs() < 2e-4, "{gap}");
}
