//! Grain-steps per second of the engine, by law and threads, on the shipped packing sheared at constant volume: the same
//! packing, strain rate and time step as the decks of other programs in benches/peers.
//!
//! `cargo bench -p granum-dem --bench step`

use std::time::Instant;

use granum_dem::Isa;
use granum_dem::cell::Cell;
use granum_dem::config::{Contact, Material, NormalKind, TangentialKind};
use granum_dem::servo::Control;
use granum_dem::simulation::{Hardware, Properties, Simulation, Site};

const PACKING: &str = include_str!("../../../data/packing-5000.csv");
const TIME_STEP: f64 = 3e-8;
const STRAIN_RATE: f64 = 27.5;
const WARM_UP: u64 = 500;
const STEPS: u64 = 3000;
const REPEATS: usize = 3;

/// The shipped packing, its cell's corner at the origin.
fn packing() -> (Cell, Vec<Site>) {
    let head = PACKING.lines().next().unwrap_or_default();
    let bound = |name: &str| -> f64 {
        let from = head.find(name).map_or(0, |at| at + name.len() + 1);
        head[from..].split_whitespace().next().and_then(|x| x.parse().ok()).unwrap_or(f64::NAN)
    };
    let low = ["xlo", "ylo", "zlo"].map(bound);
    let high = ["xhi", "yhi", "zhi"].map(bound);
    let sites = PACKING
        .lines()
        .skip(2)
        .filter_map(|line| {
            let f: Vec<f64> = line.split(',').filter_map(|x| x.parse().ok()).collect();
            let [id, x, y, z, radius] = f[..] else { return None };
            Some(Site { id: id as u64, position: [x - low[0], y - low[1], z - low[2]], radius })
        })
        .collect();
    (Cell::cuboid([0, 1, 2].map(|k| high[k] - low[k])), sites)
}

/// Best rate of a few repeats, grain-steps per second.
fn rate(normal: NormalKind, tangential: TangentialKind, hardware: Hardware) -> f64 {
    let (cell, sites) = packing();
    let contact = Contact { normal, tangential, damping: 0.1 };
    let properties = Properties { material: Material::default(), contact };
    let Ok(mut simulation) = Simulation::new(cell, &sites, properties) else { return f64::NAN };
    simulation.set_hardware(hardware);
    simulation.fix_time_step(Some(TIME_STEP));
    let mut control = Control::fixed();
    control.rate[0][0] = STRAIN_RATE;
    control.rate[1][1] = -0.5 * STRAIN_RATE;
    control.rate[2][2] = -0.5 * STRAIN_RATE;
    simulation.set_control(control);
    let mut best = 0.0f64;
    if simulation.advance(WARM_UP).is_err() {
        return f64::NAN;
    }
    for _ in 0..REPEATS {
        let start = Instant::now();
        if simulation.advance(STEPS).is_err() {
            return f64::NAN;
        }
        best = best.max(sites.len() as f64 * STEPS as f64 / start.elapsed().as_secs_f64());
    }
    best
}

fn main() {
    // `cargo test` may run benches as tests: then one law is enough.
    let all = std::env::args().any(|a| a == "--bench");
    let laws = [
        ("hertz, no-slip", NormalKind::Hertz, TangentialKind::NoSlip),
        ("hertz, mindlin-deresiewicz", NormalKind::Hertz, TangentialKind::MindlinDeresiewicz),
        ("jkr, mindlin-deresiewicz", NormalKind::Jkr, TangentialKind::MindlinDeresiewicz),
    ];
    println!("{:<28} {:>8} {:>8} {:>22}", "law", "threads", "isa", "M grain-steps/s");
    for (name, normal, tangential) in laws.into_iter().take(if all { 3 } else { 1 }) {
        for isa in Isa::ALL.into_iter().filter(|i| i.available() && *i != Isa::Portable) {
            for threads in [1, 2] {
                let r = rate(normal, tangential, Hardware { threads, isa });
                println!("{name:<28} {threads:>8} {:>8} {:>22.1}", isa.name(), r / 1e6);
            }
        }
    }
}
