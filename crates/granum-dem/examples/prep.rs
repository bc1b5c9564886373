use granum_dem::{config::*, preparation::*, simulation::*};
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let n: usize = args[1].parse().unwrap();
    let grains = Grains { count: n, ..Default::default() };
    let contact = Contact::default();
    let p = Preparation {
        seed: args[2].parse().unwrap(),
        friction: args.get(3).map(|x| x.parse().unwrap()),
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
    let mut k = 0;
    let sample = prepare(&recipe, &mut |x| {
        let s = x.simulation.state();
        k += 1;
        if k % 10 == 0 {
            println!(
                "{} {} {:?} step {} p {:.1} sf {:.5} Z {:.3} unb {:.2e} dt {:.2e} {:.1}s near {}",
                x.trial,
                k,
                x.phase,
                s.step(),
                s.mean_stress(),
                s.solid_fraction(),
                2.0 * s.contacts() as f64 / n as f64,
                s.unbalanced_force(),
                s.time_step(),
                t.elapsed().as_secs_f64(),
                x.simulation.near_pairs()
            );
        }
        Flow::Continue
    })
    .unwrap();
    println!(
        "{:?} settled {} met {}  {:.1}s",
        sample.trials,
        sample.settled,
        sample.solid_fraction_met,
        t.elapsed().as_secs_f64()
    );
}
