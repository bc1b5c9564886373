use granum_dem::{Isa, cell::Cell, config::*, servo::Control, simulation::*};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let text = std::fs::read_to_string("/work/shared/data/packing-5000.csv").unwrap();
    let head = text.lines().next().unwrap();
    let get = |k: &str| -> f64 {
        let p = head.find(&format!("{k}=")).unwrap();
        head[p + 4..].split_whitespace().next().unwrap().parse().unwrap()
    };
    let lo = [get("xlo"), get("ylo"), get("zlo")];
    let hi = [get("xhi"), get("yhi"), get("zhi")];
    let l: [f64; 3] = std::array::from_fn(|a| hi[a] - lo[a]);
    let mut sites = vec![];
    for line in text.lines().skip(2) {
        let f: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        sites.push(Site {
            id: f[0] as u64,
            position: [f[1] - lo[0], f[2] - lo[1], f[3] - lo[2]],
            radius: f[4],
        });
    }
    let normal = if args[1].contains('h') { NormalKind::Hertz } else { NormalKind::Jkr };
    let tangential =
        if args[1].contains('n') { TangentialKind::NoSlip } else { TangentialKind::MindlinDeresiewicz };
    let steps: u64 = args[2].parse().unwrap();
    let threads: usize = args[3].parse().unwrap();
    let isa = args.get(4).and_then(|n| Isa::from_name(n)).unwrap_or(Isa::detect());
    let mut sim = Simulation::new(
        Cell::cuboid(l),
        &sites,
        Properties { material: Material::default(), contact: Contact { normal, tangential, damping: 0.1 } },
    )
    .unwrap();
    sim.set_hardware(Hardware { threads, isa });
    sim.fix_time_step(Some(3e-8));
    println!(
        "p0 {} Z {} unbalanced {} sf {}",
        sim.state().mean_stress(),
        2.0 * sim.state().contacts() as f64 / 5000.0,
        sim.state().unbalanced_force(),
        sim.state().solid_fraction()
    );
    let mut c = Control::fixed();
    c.rate[0][0] = 27.5;
    c.rate[1][1] = -13.75;
    c.rate[2][2] = -13.75;
    sim.set_control(c);
    sim.advance(500).unwrap();
    for _ in 0..3 {
        let r = sim.rebuilds();
        let t = std::time::Instant::now();
        sim.advance(steps).unwrap();
        let s = t.elapsed().as_secs_f64();
        println!(
            "{:.2} M grain-steps/s  p {:.1} Z {:.3} near {:.3} rebuilds {} energy {:?}",
            5000.0 * steps as f64 / s / 1e6,
            sim.state().mean_stress(),
            2.0 * sim.state().contacts() as f64 / 5000.0,
            2.0 * sim.near_pairs() as f64 / 5000.0,
            sim.rebuilds() - r,
            sim.state().energy()
        );
    }
}
