//! Carries out again what a finite-element program has accepted, and compares: the same stresses and the same grains, to the bit.
//!
//! ```sh
//! cargo run --release -p granum-c --example replay_points -- granum-materials.toml states.granum
//! ```
//!
//! The file of states has the path of each point: the increments of the steps that the host accepted, and the stresses that it imposed. The
//! last step may not have been accepted by a further call yet; it is then among the trials and not in the path.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use granum_c::host::Session;
use granum_point::{Recipe, Store};

/// Everything that a state has, as bits.
fn bits(state: &granum_point::State) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut bytes = state.simulation().ok_or("this point has no grains")?.checkpoint("")?;
    bytes.extend(state.stress().iter().flatten().flat_map(|x| x.to_le_bytes()));
    Ok(bytes)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [configuration, states] = &arguments[..] else {
        return Err("usage: replay_points CONFIGURATION STATES".into());
    };
    let session = Session::open(Path::new(configuration))?;
    let store = Store::load(Path::new(states))?;
    let began = Instant::now();
    let (mut increments, mut imposed, mut different) = (0, 0, 0);
    for name in store.names() {
        let point = session.point(1, name)?;
        let (accepted, path) = store.accepted(name)?;
        let mut state = point.start();
        for recipe in &path {
            match recipe {
                Recipe::Advance(_) => increments += 1,
                Recipe::Impose(_) => imposed += 1,
            }
            state = point.follow(&state, recipe)?.state;
        }
        if state.identity() != accepted.identity() || bits(&state)? != bits(&accepted)? {
            println!("point {name} differs: {:?} and {:?}", state.stress(), accepted.stress());
            different += 1;
        }
    }
    println!(
        "{} points, {increments} increments and {imposed} imposed stresses carried out again in {:.1} s; {different} points differ",
        store.len(),
        began.elapsed().as_secs_f64()
    );
    if different > 0 || increments == 0 {
        Err("what was replayed is not what the host had".into())
    } else {
        Ok(())
    }
}
