//! The contacts in the cells of points of a finite-element computation, as a table for drawing force chains.
//!
//! ```sh
//! cargo run --release -p granum-c --example point_contacts -- states.granum contacts.csv 31001 45002
//! ```
//!
//! `states.granum` is the file that a host's script saved; the numbers are names of points. The state of a point is the one that the host
//! accepted last. Each row has the name of the point, the stresses xx, yy and xy of its cell (Pa, compression positive) and its widths (m), the place of the first grain within the cell and the
//! branch to the second grain (m), the normal force (N, compression positive) and the diameter of the first grain (m).

use std::error::Error;
use std::fmt::Write;
use std::path::Path;

use granum_core::geometry::{apply, invert};
use granum_point::{State, Store};

/// The rows of a state.
fn rows(name: u64, state: &State, table: &mut String) -> Result<(), Box<dyn Error>> {
    let assembly = state.observed().ok_or("this point has no grains")?.assembly();
    let inverse = invert(&assembly.cell);
    let widths = [0, 1, 2].map(|k| assembly.cell[k][k]);
    let stress = state.stress();
    let [xx, yy, xy] = [stress[0][0], stress[1][1], stress[0][1]];
    for contact in &assembly.contacts {
        let Some([first, _]) = assembly.bodies_of(contact) else { continue };
        let body = &assembly.bodies[first];
        let inside = apply(&inverse, body.position).map(|s| s - s.floor());
        let [x, y, z] = apply(&assembly.cell, inside);
        let [bx, by, bz] = assembly.branch_of_bodies(contact);
        let [wx, wy, wz] = widths;
        let (force, diameter) = (contact.normal_force, 2.0 * body.equivalent_radius);
        writeln!(
            table,
            "{name},{xx:e},{yy:e},{xy:e},{wx:e},{wy:e},{wz:e},{x:e},{y:e},{z:e},{bx:e},{by:e},{bz:e},{force:e},{diameter:e}"
        )?;
    }
    Ok(())
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [states, place, names @ ..] = &arguments[..] else {
        return Err("usage: point_contacts STATES CONTACTS.csv NAME...".into());
    };
    let store = Store::load(Path::new(states))?;
    let mut table = String::from(
        "name,stress_xx,stress_yy,stress_xy,width_x,width_y,width_z,x,y,z,branch_x,branch_y,branch_z,normal_force,diameter\n",
    );
    for name in names {
        let name = name.parse()?;
        rows(name, &store.accepted(name)?.0, &mut table)?;
    }
    std::fs::write(place, table)?;
    Ok(())
}
