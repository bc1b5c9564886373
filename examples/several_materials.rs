//! A sample of two materials: how the contacts of each pair of materials share the load.

use std::collections::BTreeMap;

use granum::prelude::*;

// ANCHOR: case
const CASE: &str = "
[grains]
count = 150
material.interface_energy = 0
[contact]
normal = \"hertz\"
tangential = \"no-slip\"
[preparation]
solid_fraction = \"none\"
friction = 0.3
unbalanced_force = 0.02
[[material]]
name = \"glass\"
share = 0.5
[[material]]
name = \"rubber\"
youngs_modulus = \"50 MPa\"
poissons_ratio = 0.49
[[pair]]
between = [\"glass\", \"rubber\"]
friction = 0.7
";
// ANCHOR_END: case

/// The contacts of a pair of materials.
#[derive(Default)]
struct Contacts {
    count: usize,
    force: f64,
    approach: f64,
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    // ANCHOR: sample
    let case = Case::parse(CASE, "case")?;
    let planned = Laboratory::here().plan(RunKind::Sample, &case, &Source::Case, &mut NoObserver)?;
    let sample = planned.in_memory(&mut NoObserver)?;
    let assembly = sample.simulation()?.assembly();
    // ANCHOR_END: sample

    // ANCHOR: pairs
    let material = |grain: usize| assembly.materials[assembly.bodies[grain].material as usize].as_str();
    let mut pairs: BTreeMap<[&str; 2], Contacts> = BTreeMap::new();
    for contact in &assembly.contacts {
        let mut names = [material(contact.i), material(contact.j)];
        names.sort_unstable();
        let pair = pairs.entry(names).or_default();
        pair.count += 1;
        pair.force += contact.normal_force;
        pair.approach += contact.approach;
    }
    println!("pair              contacts  mean force (mN)  mean overlap (nm)");
    for ([one, other], pair) in &pairs {
        let count = pair.count as f64;
        let (force, approach) = (1e3 * pair.force / count, 1e9 * pair.approach / count);
        println!("{:<18} {:>7} {force:>16.4} {approach:>18.1}", format!("{one}, {other}"), pair.count);
    }
    // ANCHOR_END: pairs
    let mean =
        |names: [&str; 2]| pairs.get(&names).map_or(f64::NAN, |pair| pair.approach / pair.count as f64);
    assert_eq!(assembly.bodies.iter().filter(|grain| grain.material == 0).count(), 75);
    assert!(mean(["rubber", "rubber"]) > 10.0 * mean(["glass", "glass"]));
    Ok(())
}
