//! Speed of grains of several spheres beside that of spheres: `clump_speed [GRAINS [STEPS [KIND]]]`.
//!
//! A sample is compacted, then compressed along axis 1 at constant mean stress. Prints the time of a step, of a grain and of a contact.

use std::time::Instant;

use granum_dem::config::{ContactModel, Grains, Material, NormalKind, Preparation, TangentialKind};
use granum_dem::observer::NoObserver;
use granum_dem::preparation::{SampleSpecification, prepare};
use granum_dem::servo::CellControl;
use granum_dem::shape::{ShapeEntry, ShapeKind};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let count: usize = given.first().map_or(Ok(1000), |text| text.parse())?;
    let steps: u64 = given.get(1).map_or(Ok(5000), |text| text.parse())?;
    let wanted = given.get(2).map(String::as_str);
    for (name, kind, spread) in [
        ("equal spheres", ShapeKind::SPHERE, 0.0),
        ("spheres of several sizes", ShapeKind::SPHERE, 0.1),
        ("dimers", ShapeKind::DIMER, 0.1),
        ("capsules of three spheres", ShapeKind::CAPSULE, 0.1),
        ("tetrapods", ShapeKind::TETRAPOD, 0.1),
    ] {
        if wanted.is_some_and(|wanted| wanted != kind.name()) {
            continue;
        }
        let grains = Grains::default().with(|grains| {
            (grains.count, grains.spread, grains.diameter) = (count, spread, 1e-3);
            grains.material = Material::default().with(|material| {
                (material.youngs_modulus, material.interface_energy) = (5e9, 0.0);
            });
            if kind != ShapeKind::SPHERE {
                grains.shapes = vec![ShapeEntry::new(kind)];
            }
        });
        let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
        let preparation = Preparation::default().with(|p| (p.solid_fraction, p.mean_stress) = (None, 100e3));
        let sample = prepare(&SampleSpecification::new(&grains, &contact, &preparation), &mut NoObserver)?;
        let mut s = sample.simulation;
        let rate = s.strain_rate(1e-3, 100e3);
        s.set_control(CellControl::constant_mean_stress(0, rate, 100e3, 10.0 * rate));
        s.advance(steps / 10)?;
        let (begin, rebuilds) = (Instant::now(), s.rebuilds());
        s.advance(steps)?;
        let time = begin.elapsed().as_secs_f64() / steps as f64;
        let contacts = s.state().contacts();
        println!(
            "{name}: {:.1} us a step, {:.0} ns a grain, {:.1} ns a contact; {contacts} contacts, {} near pairs, {} lists",
            1e6 * time,
            1e9 * time / count as f64,
            1e9 * time / contacts as f64,
            s.near_pairs(),
            s.rebuilds() - rebuilds
        );
    }
    Ok(())
}
