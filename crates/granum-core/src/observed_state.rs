//! What observers, sensors and sinks see of a computation, whoever makes it: granum's engine, another program, or a file.

use std::any::Any;

use serde::{Deserialize, Serialize};

use crate::assembly::{Assembly, Matrix};
use crate::parts::Parts;

/// Stress, strain and time at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MacroState {
    /// Stress, Pa, compression positive.
    pub stress: Matrix,
    /// Logarithmic strain, compression positive.
    pub strain: Matrix,
    /// Arc length of the strain path.
    pub arc_length: f64,
    /// Time, s.
    pub time: f64,
}

impl MacroState {
    /// The state of an assembly, with the stress computed from all its contacts, its bonds, and pairs that attract each other without
    /// touching.
    pub fn from_assembly(assembly: &Assembly) -> MacroState {
        let mut stress = [[0.0; 3]; 3];
        for contact in assembly.contacts.iter().chain(&assembly.apart) {
            let (force, branch) = (contact.force(), assembly.branch_of_bodies(contact));
            for r in 0..3 {
                for c in 0..3 {
                    stress[r][c] -= force[r] * branch[c];
                }
            }
        }
        for bond in &assembly.bonds {
            let (force, branch) = (bond.force(), assembly.branch_of_bond(bond));
            for r in 0..3 {
                for c in 0..3 {
                    stress[r][c] -= force[r] * branch[c];
                }
            }
        }
        let volume = assembly.volume();
        if volume > 0.0 {
            stress = stress.map(|row| row.map(|x| x / volume));
        }
        MacroState { stress, ..MacroState::without_stress(assembly) }
    }

    /// Strain and time of an assembly, with a stress of zero.
    pub fn without_stress(assembly: &Assembly) -> MacroState {
        MacroState {
            stress: [[0.0; 3]; 3],
            strain: assembly.strain,
            arc_length: assembly.arc_length,
            time: assembly.time,
        }
    }

    /// Mean stress p, Pa.
    pub fn mean_stress(&self) -> f64 {
        (self.stress[0][0] + self.stress[1][1] + self.stress[2][2]) / 3.0
    }
}

/// A state of grains that can be observed. It is only read, so that observation cannot disturb a computation.
///
/// An engine implements it for what it computes; observers, sensors and sinks then work with that engine as with any other.
///
/// ```
/// use std::any::Any;
/// use granum_core::assembly::Sphere;
/// use granum_core::{Assembly, MacroState, ObservedState, Part, Parts};
///
/// /// One sphere that falls freely, computed by nobody but its formula.
/// struct Falling {
///     time: f64,
/// }
///
/// impl ObservedState for Falling {
///     fn grains(&self) -> usize {
///         1
///     }
///     fn contacts(&self) -> usize {
///         0
///     }
///     fn step(&self) -> u64 {
///         0
///     }
///     fn macro_state(&self) -> MacroState {
///         MacroState { time: self.time, ..MacroState::default() }
///     }
///     fn parts(&self) -> Parts {
///         Parts::new(&[Part::Positions, Part::Radii, Part::Velocities, Part::Time])
///     }
///     fn assembly_into(&self, assembly: &mut Assembly) {
///         let (position, velocity) = ([0.0, 0.0, -4.905 * self.time.powi(2)], [0.0, 0.0, -9.81 * self.time]);
///         let sphere = Sphere { id: 1, position, velocity, radius: 1e-3, ..Sphere::default() };
///         *assembly = Assembly { time: self.time, ..Assembly::default() }.with_spheres([sphere]);
///     }
///     fn as_any(&self) -> &dyn Any {
///         self
///     }
/// }
///
/// assert_eq!(Falling { time: 2.0 }.assembly().bodies[0].position[2], -19.62);
/// ```
pub trait ObservedState {
    /// Number of grains.
    fn grains(&self) -> usize;
    /// Number of contacts that touch.
    fn contacts(&self) -> usize;
    /// Steps since the start of the phase.
    fn step(&self) -> u64;
    /// Stress, strain and time.
    fn macro_state(&self) -> MacroState;
    /// What is known of its assembly; the rest of it is zero.
    fn parts(&self) -> Parts;
    /// Makes an assembly that of this state; the memory of the assembly is used again.
    fn assembly_into(&self, assembly: &mut Assembly);
    /// Its own type, for those who know it and need more than what every state has.
    fn as_any(&self) -> &dyn Any;

    /// The assembly of this state.
    fn assembly(&self) -> Assembly {
        let mut assembly = Assembly::default();
        self.assembly_into(&mut assembly);
        assembly
    }

    /// Volume of the grains over that of the cell.
    fn solid_fraction(&self) -> f64 {
        let assembly = self.assembly();
        let cubes: f64 = assembly.bodies.iter().map(|body| body.equivalent_radius.powi(3)).sum();
        let volume = assembly.volume();
        if volume > 0.0 { 4.0 / 3.0 * std::f64::consts::PI * cubes / volume } else { 0.0 }
    }
}
