//! A read-only snapshot of a simulation at one instant, on which all sensors, reports and file formats are based.
//!
//! It is built from `&Simulation`, so that observation cannot disturb a run; it can equally be filled from the files of
//! another code.

use serde::{Deserialize, Serialize};

pub use crate::energy::EnergyBalance;
use crate::energy::is_zero;
use crate::geometry::determinant;
pub use crate::geometry::{Matrix, Vector};

/// One grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Grain {
    /// Its id, from 1 as in packing files.
    pub id: u64,
    /// Position of the centre, inside the cell, m.
    pub position: Vector,
    /// Fluctuating velocity v' (without the affine part `L x`), m/s.
    pub velocity: Vector,
    /// Spin, rad/s.
    pub spin: Vector,
    /// Radius R, m.
    pub radius: f64,
    /// Mass m, kg.
    pub mass: f64,
    /// Sum of the contact forces on the grain (dashpots included), N.
    pub force: Vector,
    /// Sum of the contact torques on the grain about its centre, N m.
    pub torque: Vector,
    /// Its material, as an index of [`Assembly::materials`]; 0 if there is one material.
    #[serde(default, skip_serializing_if = "is_first")]
    pub material: u32,
}

/// True for the first material, the only one of most assemblies.
fn is_first(material: &u32) -> bool {
    *material == 0
}

/// One contact between grains i and j that touch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Contact {
    /// Index (not id) of grain i in [`Assembly::grains`].
    pub i: usize,
    /// Index (not id) of grain j.
    pub j: usize,
    /// Branch vector `l` from the centre of i to the nearest image of the centre of j, m.
    pub branch: Vector,
    /// Unit normal n from i to j.
    pub normal: Vector,
    /// Approach alpha = R_i + R_j - D, m.
    pub approach: f64,
    /// Elastic normal force N, compression positive, what a law of adhesion adds included, N.
    pub normal_force: f64,
    /// Elastic tangential force T on i, N.
    pub tangential_force: Vector,
    /// Radius a of the contact area, m.
    pub radius: f64,
    /// True if the tangential force was at the friction limit in the last step.
    pub sliding: bool,
    /// Elastic energy of the normal approach, J (zero at alpha = 0).
    pub normal_energy: f64,
    /// Elastic energy of the tangential displacement, J: `T^2 / (16 G* a)` without slip.
    pub tangential_energy: f64,
    /// Elastic energy of rolling and twisting, J; zero without a moment law.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rolling_energy: f64,
    /// Energy of an additional law of adhesion, J.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub attraction_energy: f64,
}

impl Contact {
    /// Elastic force on grain i, N: `-N n + T`.
    #[inline]
    pub fn force(&self) -> Vector {
        let ([x, y, z], [a, b, c], n) = (self.tangential_force, self.normal, self.normal_force);
        [x - n * a, y - n * b, z - n * c]
    }
}

/// Where the liquid of wet grains is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Liquid {
    /// Volume of liquid in the films of all grains, m3.
    pub films: f64,
    /// Volume of liquid in all bridges, m3.
    pub bridges: f64,
    /// Number of bridges.
    pub count: usize,
}

/// A read-only snapshot of a simulation at one instant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Assembly {
    /// Time since the start of the phase, s.
    pub time: f64,
    /// Steps since the start of the phase.
    pub step: u64,
    /// Time step, s.
    pub time_step: f64,
    /// Edge matrix H of the periodic cell: column k is edge k, m.
    pub cell: Matrix,
    /// Velocity gradient L of the cell, 1/s (negative in compression).
    pub velocity_gradient: Matrix,
    /// Logarithmic strain of the cell since the start of the phase, compression positive.
    pub strain: Matrix,
    /// Arc length of the strain path over the same time.
    #[serde(default)]
    pub arc_length: f64,
    /// Target of the mean stress, Pa, where the servo has one.
    pub target_mean_stress: Option<f64>,
    /// The grains, in order of their ids.
    pub grains: Vec<Grain>,
    /// The contacts that touch, in order of the ids of their grains.
    pub contacts: Vec<Contact>,
    /// Pairs that act on each other without touching (by liquid bridges, say), in the same order: their force has a part in the
    /// stress, but they are no contacts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub apart: Vec<Contact>,
    /// Names of the materials, if there are several.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub materials: Vec<String>,
    /// Liquid in films and bridges, where a law of adhesion shares liquid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub liquid: Option<Liquid>,
    /// Energy by mechanism.
    pub energy: EnergyBalance,
}

impl Assembly {
    /// Volume V of the cell, m3.
    pub fn volume(&self) -> f64 {
        determinant(&self.cell).abs()
    }
}
