//! Speed of training.
use granum_nets::trainer::{Silent, Trainer, Traingdx};
use granum_nets::{Data, Network};
fn main() {
    let n = 280;
    let mut x = vec![];
    let mut t = vec![];
    for r in 0..n {
        let s = r as f64 / n as f64;
        let f = (r % 7) as f64 / 7.0;
        x.extend([2.0 * s - 1.0, 2.0 * f - 1.0, (3.0 * s).sin() * f]);
        t.push(0.5 + 0.35 * (6.0 * s).sin() * (1.0 - f));
    }
    let data = Data::new(x, 3, t).unwrap();
    for h in [60, 25] {
        for isa in granum_simd::Isa::ALL {
            let epochs = if isa == granum_simd::Isa::Portable { 60 } else { 20000 };
            let mut net = Network::new(&[3, h, h, 1], 1).unwrap();
            let r =
                Traingdx { epochs, isa, ..Default::default() }.train(&mut net, &data, &mut Silent).unwrap();
            println!(
                "{h} {} {:.0} epochs/s err {:e} {:?}",
                isa.name(),
                r.epochs as f64 / r.seconds,
                r.error,
                r.termination
            );
        }
    }
}
