//! Dumps of grains as `dump custom` of LAMMPS writes them, which LAMMPS (`read_dump`), OVITO and others read.
//!
//! The columns are `id type x y z`, then what is known of `radius`, `mass`, `vx vy vz`, `omegax omegay omegaz` and, of spheres alone, `fx fy fz
//! tqx tqy tqz`. Where grains have several pieces each piece is an atom, and there are further columns: `mol`, the id of the body; `ix iy iz`, the
//! images by which the unwrapped pieces of a body lie together; `body_mass`, to which the masses of a molecule add up; and the orientation of
//! the body, `quatw quati quatj quatk`, the rotation from its principal axes to those of the file. Velocities include the homogeneous part. The
//! cell is rotated as for a [data file](super::lammps_data).

use std::io::Write;

use granum_core::Part;
use granum_core::assembly::{Matrix, Quaternion, Vector};
use granum_core::geometry::{apply, invert};
use granum_core::rotation::product;

use super::atoms::{Atom, atoms};
use super::lammps_data::{restricted, wrapped};
use super::quaternion::of_matrix;
use super::result::ObservedAssembly;

/// A column, or several, with the part of an assembly that they need.
type Columns = (Part, &'static str, fn(&Row) -> Vec<f64>);

/// An atom in the cell that is written.
struct Row {
    atom: Atom,
    velocity: Vector,
    spin: Vector,
    orientation: Quaternion,
    force: Vector,
    torque: Vector,
}

const COLUMNS: [Columns; 4] = [
    (Part::Radii, "radius", |row| vec![row.atom.radius]),
    (Part::Masses, "mass", |row| vec![row.atom.mass]),
    (Part::Velocities, "vx vy vz", |row| row.velocity.to_vec()),
    (Part::Spins, "omegax omegay omegaz", |row| row.spin.to_vec()),
];
const OF_SPHERES: [Columns; 1] =
    [(Part::ResultantForces, "fx fy fz tqx tqy tqz", |row| [row.force, row.torque].concat())];
const OF_BODIES: [Columns; 2] = [
    (Part::Masses, "body_mass", |row| vec![row.atom.body_mass]),
    (Part::Positions, "quatw quati quatj quatk", |row| row.orientation.to_vec()),
];

/// Writes one instant, whose cell is known.
pub(super) fn write_frame(file: &mut impl Write, observation: &ObservedAssembly) -> std::io::Result<()> {
    let (assembly, parts) = (&observation.assembly, observation.parts);
    let (turn, edges) = restricted(&assembly.cell);
    let (inverse, origin) = (invert(&edges), apply(&turn, observation.origin));
    let (atoms, has_bodies) = (atoms(assembly), !assembly.all_spheres());
    write_head(file, observation, atoms.len(), &origin, &edges)?;
    let further: &[Columns] = if has_bodies { &OF_BODIES } else { &OF_SPHERES };
    let columns: Vec<&Columns> =
        COLUMNS.iter().chain(further).filter(|(part, _, _)| parts.has(*part)).collect();
    let (molecule, images) = if has_bodies { (" mol", " ix iy iz") } else { ("", "") };
    write!(file, "ITEM: ATOMS id{molecule} type x y z{images}")?;
    columns.iter().try_for_each(|(_, names, _)| write!(file, " {names}"))?;
    writeln!(file)?;
    let turning = of_matrix(&turn);
    for atom in atoms {
        let row = Row {
            atom,
            velocity: apply(&turn, atom.whole_velocity(assembly)),
            spin: apply(&turn, atom.spin),
            orientation: product(&turning, &atom.orientation),
            force: apply(&turn, atom.force),
            torque: apply(&turn, atom.torque),
        };
        let place = if has_bodies { atom.unwrapped() } else { atom.position };
        let (inside, flags) = wrapped(&edges, &inverse, &apply(&turn, place));
        let [x, y, z]: Vector = std::array::from_fn(|a| origin[a] + inside[a]);
        let kind = atom.material + 1;
        match has_bodies {
            true => write!(file, "{} {} {kind} {x:?} {y:?} {z:?}", atom.id, atom.body)?,
            false => write!(file, "{} {kind} {x:?} {y:?} {z:?}", atom.id)?,
        }
        if has_bodies {
            flags.iter().try_for_each(|flag| write!(file, " {flag}"))?;
        }
        for (_, _, values) in &columns {
            values(&row).iter().try_for_each(|value| write!(file, " {value:?}"))?;
        }
        writeln!(file)?;
    }
    Ok(())
}

/// Time, step, number of atoms and box; the bounds of a tilted box are those of the cuboid around it.
fn write_head(
    file: &mut impl Write,
    observation: &ObservedAssembly,
    count: usize,
    origin: &Vector,
    edges: &Matrix,
) -> std::io::Result<()> {
    let assembly = &observation.assembly;
    if observation.parts.has(Part::Time) {
        writeln!(file, "ITEM: TIME\n{:?}", assembly.time)?;
    }
    writeln!(file, "ITEM: TIMESTEP\n{}\nITEM: NUMBER OF ATOMS\n{count}", assembly.step)?;
    let (xy, xz, yz) = (edges[0][1], edges[0][2], edges[1][2]);
    let tilted = [xy, xz, yz] != [0.0; 3];
    writeln!(file, "ITEM: BOX BOUNDS {}pp pp pp", if tilted { "xy xz yz " } else { "" })?;
    let least = |values: &[f64]| values.iter().copied().fold(0.0, f64::min);
    let most = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let spread: [&[f64]; 3] = [&[xy, xz, xy + xz], &[yz], &[]];
    for (a, tilt) in [xy, xz, yz].into_iter().enumerate() {
        let (low, high) = (origin[a] + least(spread[a]), origin[a] + edges[a][a] + most(spread[a]));
        match tilted {
            true => writeln!(file, "{low:?} {high:?} {tilt:?}")?,
            false => writeln!(file, "{low:?} {high:?}")?,
        }
    }
    Ok(())
}
