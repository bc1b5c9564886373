//! Speed of training.
use granum_nets::trainer::{Silent, Trainer, Traingdx};
use granum_nets::{Data, Network};
fn main() {
    let n = 280;
    let (mut x, mut t) = (vec![], vec![]);
    for r in 0..n {
        let (s, f) = (r as f64 / n as f64, (r % 7) as f64 / 7.0);
        x.extend([2.0 * s - 1.0, 2.0 * f - 1.0, (3.0 * s).sin() * f]);
        t.push(0.5 + 0.35 * (6.0 * s).sin() * (1.0 - f));
    }
    let Ok(data) = Data::new(x, 3, t) else { return };
    let Ok(mut network) = Network::new(&[3, 60, 60, 1], 1) else { return };
    let rule = Traingdx { epochs: 20_000, ..Default::default() };
    if let Ok(r) = rule.train(&mut network, &data, &mut Silent) {
        println!("traingdx 3-60-60-1: {:.0} epochs/s", r.epochs as f64 / r.seconds);
    }
}
