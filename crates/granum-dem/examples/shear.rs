use granum_dem::{config::*, path::axisymmetric::*, path::*, preparation::*, simulation::*};
struct W {
    t: std::time::Instant,
    next: f64,
    n: usize,
}
impl Watcher for W {
    fn next_look(&self) -> f64 {
        self.next
    }
    fn look(&mut self, sim: &Simulation) {
        let s = sim.state();
        let st = s.stress();
        let e = s.energy();
        println!(
            "ed {:.5} q/p {:.4} p {:.1} sf {:.5} Z {:.3} unb {:.2e} dt {:.2e} servo rms {:.2e} max {:.2e} near {} reb {} W {:.3e} T {:.3e} fr {:.2e} damp {:.2e} ad {:.2e} {:.1}s",
            s.deviator_strain(),
            (st[0][0] - 0.5 * (st[1][1] + st[2][2])) / s.mean_stress(),
            s.mean_stress(),
            s.solid_fraction(),
            2.0 * s.contacts() as f64 / self.n as f64,
            s.unbalanced_force(),
            s.time_step(),
            s.servo_error().rms(),
            s.servo_error().largest,
            sim.near_pairs(),
            sim.rebuilds(),
            e.boundary_work,
            e.tangential_work,
            e.friction,
            e.damping,
            e.adhesion,
            self.t.elapsed().as_secs_f64()
        );
        self.next += 0.01;
        if (s.deviator_strain() - 0.01).abs() < 1e-4 {}
    }
    fn progress(&mut self, _: &Progress) -> Flow {
        Flow::Continue
    }
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: usize = args[1].parse().unwrap();
    let inertial: f64 = args[4].parse().unwrap();
    let grains = Grains { count: n, ..Default::default() };
    let contact = Contact::default();
    let p = Preparation {
        seed: args[2].parse().unwrap(),
        friction: Some(args[3].parse().unwrap()),
        ..Default::default()
    };
    let recipe = Recipe {
        grains: &grains,
        contact: &contact,
        preparation: &p,
        time_step_factor: 0.2,
        hardware: Hardware::default(),
    };
    let t = std::time::Instant::now();
    let sample = prepare(&recipe, &mut |_| Flow::Continue).unwrap();
    println!(
        "{:?} settled {} met {}  {:.1}s",
        sample.trials,
        sample.settled,
        sample.solid_fraction_met,
        t.elapsed().as_secs_f64()
    );
    let mut sim = sample.simulation;
    let path = AxisymmetricCompression::new(
        &Shear { rate: Rate::InertialNumber(inertial), ..Default::default() },
        &sim,
        20e3,
    );
    start(&path, &mut sim);
    let mut w = W { t: std::time::Instant::now(), next: 0.0, n };
    follow(&path, &mut sim, &mut w).unwrap();
    println!("steps {}", sim.state().step());
}
