//! Grains of several pieces: what LAMMPS needs to move them as granum does.
//!
//! `fix rigid/small` takes mass, centre and inertia of each body from a file, here those of the union of its pieces. In a cell that is
//! strained it has three gaps, which the script closes:
//!
//! - A body that crosses a face keeps the velocity of the side that it has left (`fix deform remap v` changes the velocities of atoms, and
//!   those of bodies overwrite them). A force of one step, `-M Hdot n / dt`, gives it that of the side where it is.
//! - Pieces beyond a face get the velocity of their body as if they were beside it. `fix move` corrects it before forces are computed.
//! - The stress of the pair forces is `sum F (x) l` with branches between pieces. That of the bodies is less by `sum F (x) c` over the pieces
//!   with their arms c, which is taken away before the servo sees it.
//!
//! The centre of a body is a weighted mean of its pieces: of all weights with the sum one and the right mean those nearest to equal ones.
//! Forces on bodies are given to pieces in these shares, so that they have no moment.

use granum_core::assembly::{Assembly, Body, Matrix, Vector};
use granum_core::geometry::{apply, invert};
use granum_core::rotation::matrix;

use super::deck_error::DeckError;
use super::formula::number;
use super::names::{DATA, SHARES, WEIGHTS};

/// The bodies of a sample as files of a deck.
#[derive(Clone, Debug)]
pub(super) struct Bodies {
    /// For `fix rigid/small infile`: number, mass, centre, inertia, velocity, angular momentum and image of each body.
    pub(super) infile: String,
    /// The weights of the pieces, by atom.
    pub(super) weights: String,
    /// These weights times the mass of the body, kg, by atom.
    pub(super) shares: String,
    /// Number of atoms.
    pub(super) atoms: usize,
    /// Largest distance of two points of a body, m.
    pub(super) extent: f64,
    /// Mean radius of the pieces, m.
    pub(super) piece_radius: f64,
}

impl Bodies {
    /// The bodies of a sample whose atoms are its pieces, in their order; the corner of its cell is at `origin`. None if all are spheres.
    pub(super) fn new(assembly: &Assembly, origin: Vector) -> Result<Option<Bodies>, DeckError> {
        if assembly.all_spheres() {
            return Ok(None);
        }
        let mut arms: Vec<Vec<(usize, Vector, f64)>> = vec![Vec::new(); assembly.bodies.len()];
        for (k, piece) in assembly.pieces.iter().enumerate() {
            if let Some(of_body) = arms.get_mut(piece.body) {
                of_body.push((k, piece.arm, piece.radius));
            }
        }
        let atoms = assembly.pieces.len();
        let mut weights = vec![0.0; atoms];
        let mut shares = vec![0.0; atoms];
        let mut infile = format!("{}\n", assembly.bodies.len());
        let mut extent = 0.0f64;
        for (body, arms) in assembly.bodies.iter().zip(&arms) {
            infile += &line(assembly, body, origin)?;
            let only: Vec<Vector> = arms.iter().map(|(_, arm, _)| *arm).collect();
            for ((k, arm, radius), weight) in arms.iter().zip(weights_of(&only)) {
                weights[*k] = weight;
                shares[*k] = weight * body.mass;
                extent = extent.max(2.0 * (arm.iter().map(|x| x * x).sum::<f64>().sqrt() + radius));
            }
        }
        let sum = assembly.pieces.iter().map(|piece| piece.radius).sum::<f64>();
        Ok(Some(Bodies {
            infile,
            weights: by_atom(&weights),
            shares: by_atom(&shares),
            atoms,
            extent,
            piece_radius: sum / atoms.max(1) as f64,
        }))
    }

    /// The commands that read the sample.
    pub(super) fn read(&self) -> String {
        format!(
            "fix molecules all property/atom mol ghost yes\n\
             read_data {DATA} fix molecules NULL Molecules\n\
             # Of each piece its weight in the centre of its body, and that times the mass of the body.\n\
             fix parts all property/atom d_weight d_share\n\
             variable read_weight atomfile {WEIGHTS}\nset group all d_weight v_read_weight\n\
             variable read_share atomfile {SHARES}\nset group all d_share v_read_share\n"
        )
    }

    /// The commands that move the bodies, after those of the forces. `skin` is that of the lists of neighbours, m.
    pub(super) fn motion(&self, skin: f64) -> String {
        let cutoff = number(self.extent + skin);
        format!("comm_modify vel yes cutoff {cutoff}\n") + MOTION
    }

    /// The stress of the contacts between the centres of bodies.
    pub(super) fn stress(&self) -> String {
        let mut text = String::from(
            "\n# Stress of the contacts, Pa, with branches between the centres of bodies: those between pieces, less forces times arms.\n\
             compute stress all pressure NULL pair\n",
        );
        let mut columns = String::new();
        for (k, (r, c)) in [(0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2)].into_iter().enumerate() {
            let force = ["fx", "fy", "fz"][c];
            text +=
                &format!("variable couple{} atom (c_late[{}]-c_centre[{}])*{force}\n", k + 1, r + 3, r + 1);
            columns += &format!(" v_couple{}", k + 1);
        }
        text += &format!("compute couples all reduce sum{columns}\nfix stress all ave/time 1 1 1");
        for of in ["c_stress", "c_couples"] {
            for k in 1..=6 {
                text += &format!(" {of}[{k}]");
            }
        }
        text += "\n";
        for (name, k) in [("s11", 1), ("s22", 2), ("s33", 3), ("s12", 4), ("s13", 5), ("s23", 6)] {
            text += &format!("variable {name} equal f_stress[{k}]-f_stress[{}]/vol\n", k + 6);
        }
        text
    }

    /// Contacts of bodies, and the resultant forces on them.
    pub(super) fn contacts(&self, grains: usize, half: &str) -> String {
        let each = number(self.atoms as f64 / grains.max(1) as f64);
        format!(
            "\n# Contacts: twice their number over that of the grains, and the same of the grains with two contacts or more.\n\
             compute contacts all contact/atom\n\
             variable of_bodies atom c_contacts*{each}\n\
             compute coordination all reduce ave v_of_bodies\n\
             compute hits all reduce/chunk bodies sum c_contacts\n\
             compute hit all chunk/spread/atom bodies c_hits\n\
             compute sizes all property/chunk bodies count\n\
             compute size all chunk/spread/atom bodies c_sizes\n\
             variable none atom (c_hit==0)/c_size\n\
             variable one atom (c_hit==1)/c_size\n\
             compute loose all reduce sum v_none v_one\n\
             variable mechanical equal ({grains}*c_coordination-c_loose[2])/({grains}-c_loose[1]-c_loose[2]+1e-9)\n\
             variable touches atom (c_hit>0)/c_size\n\
             compute touching all reduce sum v_touches\n\
             # Mean resultant force of the grains that touch over the mean normal force 3 p V / (N_c d) of the contacts.\n\
             variable force_x atom fx\nvariable force_y atom fy\nvariable force_z atom fz\n\
             compute forces_x all reduce/chunk bodies sum v_force_x\n\
             compute forces_y all reduce/chunk bodies sum v_force_y\n\
             compute forces_z all reduce/chunk bodies sum v_force_z\n\
             compute resultant all chunk/spread/atom bodies c_forces_x c_forces_y c_forces_z\n\
             variable net atom sqrt(c_resultant[1]^2+c_resultant[2]^2+c_resultant[3]^2)/c_size\n\
             compute net all reduce sum v_net\n\
             variable unbalanced equal c_net/(v_touching+1e-9)*{half}*v_coordination/(3*v_p*vol)\n"
        )
    }
}

/// The places of bodies, and the corrections of `fix rigid/small` in a cell that is strained. What is used before the lists of neighbours are made
/// and what is used after them are apart, since atoms can change their order between.
const MOTION: &str = "\
fix move all rigid/small molecule infile bodies.txt reinit no

# Centres of the bodies, and by how many edges of the cell they are from where they are counted (n_x, n_y, n_z).
compute bodies all chunk/atom molecule
compute late all property/atom d_weight d_share xu yu zu
variable part_x atom c_late[1]*c_late[3]
variable part_y atom c_late[1]*c_late[4]
variable part_z atom c_late[1]*c_late[5]
# One sum each: the version named above does not clear those of several values.
compute parts_x all reduce/chunk bodies sum v_part_x
compute parts_y all reduce/chunk bodies sum v_part_y
compute parts_z all reduce/chunk bodies sum v_part_z
compute centre all chunk/spread/atom bodies c_parts_x c_parts_y c_parts_z
variable at_z atom (c_centre[3]-zlo)/lz
variable at_y atom (c_centre[2]-ylo-yz*v_at_z)/ly
variable at_x atom (c_centre[1]-xlo-xy*v_at_y-xz*v_at_z)/lx
variable n_x atom floor(v_at_x)
variable n_y atom floor(v_at_y)
variable n_z atom floor(v_at_z)
variable b_x atom c_centre[1]-v_n_x*lx-v_n_y*xy-v_n_z*xz
variable b_y atom c_centre[2]-v_n_y*ly-v_n_z*yz
variable b_z atom c_centre[3]-v_n_z*lz
# Rates of the lengths and tilts of the cell, which the stages set.
variable rate_x equal 0
variable rate_y equal 0
variable rate_z equal 0
variable rate_xy equal 0
variable rate_yz equal 0
fix before all store/state 1 v_n_x v_n_y v_n_z
# A body that has crossed a face gets the velocity of the side where it is, by a force of one step.
variable cross_x atom c_late[2]*((f_before[1]-v_n_x)*v_rate_x+(f_before[2]-v_n_y)*v_rate_xy)/dt
variable cross_y atom c_late[2]*((f_before[2]-v_n_y)*v_rate_y+(f_before[3]-v_n_z)*v_rate_yz)/dt
variable cross_z atom c_late[2]*(f_before[3]-v_n_z)*v_rate_z/dt
fix cross all addforce v_cross_x v_cross_y v_cross_z
# A piece beyond a face gets the velocity of its place; places stay as they are.
compute early all property/atom ix iy iz xu yu zu
variable stay_x atom c_early[4]-f_beyond[1]
variable stay_y atom c_early[5]-f_beyond[2]
variable stay_z atom c_early[6]-f_beyond[3]
variable go_x atom vx-(c_early[1]-f_before[1])*v_rate_x-(c_early[2]-f_before[2])*v_rate_xy
variable go_y atom vy-(c_early[2]-f_before[2])*v_rate_y-(c_early[3]-f_before[3])*v_rate_yz
variable go_z atom vz-(c_early[3]-f_before[3])*v_rate_z
fix beyond all move variable v_stay_x v_stay_y v_stay_z v_go_x v_go_y v_go_z
";

/// The line of a body.
fn line(assembly: &Assembly, body: &Body, origin: Vector) -> Result<String, DeckError> {
    let Some(rigid) = body.rigid.and_then(|rigid| assembly.rigid.get(rigid as usize)) else {
        let why = format!(
            "grain {} is one sphere among grains of several pieces, which `fix rigid/small` does not move; give it two pieces",
            body.id
        );
        return Err(DeckError::Sample(why));
    };
    let turn = matrix(&rigid.orientation);
    let inertia =
        |r: usize, c: usize| (0..3).map(|k| turn[r][k] * rigid.inertia[k] * turn[c][k]).sum::<f64>();
    let numbers = [
        body.mass,
        origin[0] + body.position[0],
        origin[1] + body.position[1],
        origin[2] + body.position[2],
        inertia(0, 0),
        inertia(1, 1),
        inertia(2, 2),
        inertia(0, 1),
        inertia(0, 2),
        inertia(1, 2),
    ];
    let text: Vec<String> = numbers.iter().map(|value| number(*value)).collect();
    // At rest, as the data file has no velocities either.
    Ok(format!("{} {} 0 0 0 0 0 0 0 0 0\n", body.id, text.join(" ")))
}

/// A file of a variable of style `atomfile`.
fn by_atom(values: &[f64]) -> String {
    let lines: Vec<String> =
        values.iter().enumerate().map(|(k, value)| format!("{} {}\n", k + 1, number(*value))).collect();
    format!("{}\n{}", values.len(), lines.concat())
}

/// Weights with the sum one by which the mean of the arms is zero, those nearest to equal ones: `1/n - (c - m) . S^-1 m` with the plain mean m of
/// the arms and `S = sum (c - m) (x) (c - m)`, for arms in a line or in a plane within that.
fn weights_of(arms: &[Vector]) -> Vec<f64> {
    let count = arms.len() as f64;
    let equal = vec![1.0 / count; arms.len()];
    let mean: Vector = std::array::from_fn(|k| arms.iter().map(|arm| arm[k]).sum::<f64>() / count);
    let sides: Vec<Vector> = arms.iter().map(|arm| std::array::from_fn(|k| arm[k] - mean[k])).collect();
    let squares: Matrix =
        std::array::from_fn(|r| std::array::from_fn(|c| sides.iter().map(|side| side[r] * side[c]).sum()));
    let trace = squares[0][0] + squares[1][1] + squares[2][2];
    if mean.iter().map(|x| x * x).sum::<f64>() <= 1e-24 * trace || trace <= 0.0 {
        return equal;
    }
    // A small part of the trace makes the matrix of a line or a plane invertible; what it leaves is solved for again.
    let scaled: Matrix = std::array::from_fn(|r| std::array::from_fn(|c| squares[r][c] / trace));
    let softened: Matrix =
        std::array::from_fn(|r| std::array::from_fn(|c| scaled[r][c] + if r == c { 1e-6 } else { 0.0 }));
    let inverse = invert(&softened);
    let mut factor = [0.0; 3];
    for _ in 0..5 {
        let done = apply(&scaled, factor);
        let more = apply(&inverse, std::array::from_fn(|k| mean[k] / trace - done[k]));
        factor = std::array::from_fn(|k| factor[k] + more[k]);
    }
    let along = |side: &Vector| (0..3).map(|k| side[k] * factor[k]).sum::<f64>();
    equal.iter().zip(&sides).map(|(weight, side)| weight - along(side)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pieces in a line, in a plane and in space, whose plain mean is not the centre.
    #[test]
    fn weights_add_up_and_have_their_mean_at_the_centre() {
        let line = vec![[-1e-4, 0.0, 0.0], [3e-4, 0.0, 0.0]];
        let plane = vec![[1e-4, 2e-4, 0.0], [-3e-4, 1e-4, 0.0], [1e-4, -4e-4, 0.0]];
        let space = vec![
            [1e-4, 0.0, 0.0],
            [-1e-4, 0.0, 1e-5],
            [0.0, 2e-4, -1e-4],
            [0.0, -1e-4, 2e-4],
            [0.0, 1e-5, 0.0],
        ];
        let even = vec![[-1e-4, 0.0, 0.0], [0.0; 3], [1e-4, 0.0, 0.0]];
        for arms in [&line, &plane, &space, &even] {
            let weights = weights_of(arms);
            assert!((weights.iter().sum::<f64>() - 1.0).abs() < 1e-12, "{weights:?}");
            for axis in 0..3 {
                let mean: f64 = arms.iter().zip(&weights).map(|(arm, weight)| weight * arm[axis]).sum();
                assert!(mean.abs() < 1e-15, "{arms:?}: {weights:?} {mean}");
            }
        }
        let weights = weights_of(&line);
        assert!((weights[0] - 0.75).abs() < 1e-9 && (weights[1] - 0.25).abs() < 1e-9, "{weights:?}");
        assert_eq!(weights_of(&even), [1.0 / 3.0; 3]);
    }
}
