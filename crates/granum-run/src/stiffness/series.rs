//! The stiffness at chosen states of a test, as a table.

use granum_core::{Column, ObservedState, Table};
use granum_dem::invariants::signed_von_mises;
use granum_dem::observer::{Flow, SimulationObserver, SimulationProgress};
use granum_dem::servo::COMPONENTS;
use granum_dem::simulation::Simulation;

use super::probing::{Probing, Stiffness, StiffnessError, measure};

/// The stiffness of a state, with quantities that characterise the state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probed {
    /// Deviator strain since the start of the phase.
    pub deviator_strain: f64,
    /// Axial strain since then.
    pub axial_strain: f64,
    /// Volumetric strain since then, positive in compaction.
    pub volumetric_strain: f64,
    /// Void ratio.
    pub void_ratio: f64,
    /// Coordination number.
    pub coordination_number: f64,
    /// The stiffness.
    pub stiffness: Stiffness,
}

impl Probed {
    /// Measures the stiffness of a simulation, on copies of it.
    ///
    /// # Errors
    /// As [`measure`].
    pub fn from_simulation(simulation: &Simulation, probing: &Probing) -> Result<Probed, StiffnessError> {
        let stiffness = measure(simulation, probing)?;
        let state = simulation.state();
        let strain = state.strain();
        Ok(Probed {
            deviator_strain: state.deviator_strain(),
            axial_strain: strain[0][0],
            volumetric_strain: strain[0][0] + strain[1][1] + strain[2][2],
            void_ratio: 1.0 / state.solid_fraction() - 1.0,
            coordination_number: 2.0 * state.contacts() as f64 / state.grains() as f64,
            stiffness,
        })
    }
}

/// An observer that measures the stiffness at chosen values of the measure by which a stage is recorded (the deviator strain in
/// the test of `[shear]`).
///
/// ```
/// use granum_run::stiffness::{Probes, Probing};
/// use granum_run::SimulationObserver;
///
/// let mut probes = Probes::new(1, vec![0.0, 0.01], Probing::default());
/// assert_eq!(probes.next_observation(), f64::INFINITY, "no stage has begun");
/// probes.stage(1);
/// assert_eq!(probes.next_observation(), 0.0);
/// ```
#[derive(Clone, Debug)]
pub struct Probes {
    /// The stage, from 1.
    number: usize,
    /// True while this stage is in progress.
    is_on: bool,
    due: Vec<f64>,
    probing: Probing,
    found: Vec<Probed>,
    failed: Option<StiffnessError>,
}

impl Probes {
    /// Measures in the stage of that number, from 1, at these values.
    pub fn new(stage: usize, mut at: Vec<f64>, probing: Probing) -> Probes {
        at.sort_by(f64::total_cmp);
        Probes { number: stage, is_on: false, due: at, probing, found: Vec::new(), failed: None }
    }

    /// What was measured.
    ///
    /// # Errors
    /// The error that ended the test.
    pub fn finish(self) -> Result<Vec<Probed>, StiffnessError> {
        self.failed.map_or(Ok(self.found), Err)
    }

    /// The values that have not been reached yet.
    pub fn due(&self) -> &[f64] {
        &self.due
    }
}

impl SimulationObserver for Probes {
    fn stage(&mut self, number: usize) {
        self.is_on = number == self.number;
    }

    fn next_observation(&self) -> f64 {
        let due = self.due.first().copied().unwrap_or(f64::INFINITY);
        if self.is_on && self.failed.is_none() { due } else { f64::INFINITY }
    }

    fn observe(&mut self, state: &dyn ObservedState) {
        // Probes are made on copies of the simulation, which only granum's engine has.
        let Some(simulation) = state.as_any().downcast_ref::<Simulation>() else { return };
        if self.due.is_empty() {
            return;
        }
        self.due.remove(0);
        match Probed::from_simulation(simulation, &self.probing) {
            Ok(probed) => self.found.push(probed),
            Err(error) => self.failed = Some(error),
        }
    }

    fn progress(&mut self, _: &SimulationProgress) -> Flow {
        if self.failed.is_some() { Flow::Stop } else { Flow::Continue }
    }
}

/// The measured stiffnesses as a table, one row per state: strains, void ratio, coordination number, stress, moduli, and the
/// tensor as `c_xx_xx` to `c_xy_xy` (stress component, strain component).
pub fn table(rows: &[Probed]) -> Table {
    let column = |name: &str, unit: &str, value: &dyn Fn(&Probed) -> f64| {
        Column::new(name, unit, rows.iter().map(value).collect())
    };
    let young =
        |row: &Probed, axis: usize| row.stiffness.tensor.youngs_moduli().map_or(f64::NAN, |e| e[axis]);
    let stress = |row: &Probed| row.stiffness.stress;
    let mut columns = vec![
        column("deviator_strain", "", &|row| row.deviator_strain),
        column("axial_strain", "", &|row| row.axial_strain),
        column("volumetric_strain", "", &|row| row.volumetric_strain),
        column("void_ratio", "", &|row| row.void_ratio),
        column("coordination_number", "", &|row| row.coordination_number),
        column("mean_stress", "Pa", &|row| granum_dem::invariants::mean(&stress(row))),
        column("von_mises_stress", "Pa", &|row| signed_von_mises(&stress(row))),
        column("bulk_modulus", "Pa", &|row| row.stiffness.tensor.bulk_modulus()),
        column("shear_modulus", "Pa", &|row| row.stiffness.tensor.shear_modulus()),
        column("affine_bulk_modulus", "Pa", &|row| row.stiffness.affine.bulk_modulus()),
        column("affine_shear_modulus", "Pa", &|row| row.stiffness.affine.shear_modulus()),
        column("youngs_modulus_x", "Pa", &|row| young(row, 0)),
        column("youngs_modulus_y", "Pa", &|row| young(row, 1)),
        column("youngs_modulus_z", "Pa", &|row| young(row, 2)),
        column("anisotropy", "", &|row| row.stiffness.tensor.anisotropy().unwrap_or(f64::NAN)),
        column("asymmetry", "", &|row| row.stiffness.tensor.asymmetry()),
        column("unsettled", "", &|row| row.stiffness.unsettled),
    ];
    for (i, stress) in COMPONENTS.iter().enumerate() {
        for (j, strain) in COMPONENTS.iter().enumerate() {
            columns.push(column(&format!("c_{stress}_{strain}"), "Pa", &|row| row.stiffness.tensor.0[i][j]));
        }
    }
    // All columns have one value for each row, so that this cannot fail.
    Table::new(columns).unwrap_or_default()
}
