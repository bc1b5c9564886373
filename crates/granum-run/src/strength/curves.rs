//! The curves of a test as a laboratory draws them: which q, and from which state strains and pore pressures count.
//!
//! In a test that is axisymmetric about one axis, `q = sigma_a - (sigma_b + sigma_c) / 2` with the axial stress `sigma_a` and the two
//! lateral stresses, negative in extension. In every other test q_vM is the von Mises stress `sqrt(3/2 s:s)` of the recorded
//! mean stress tensor, which has no sign.

use std::borrow::Cow;
use std::ops::Range;

use granum_core::geometry::Matrix;
use granum_dem::invariants;
use granum_dem::loading::{Measure, Stage};
use granum_sensors::Record;

use super::symmetry;

/// Share of the mean stress at the start of a test (of an undrained part: at its start) that a state must carry for its stress
/// ratio and friction angle to count. Below it a sample has liquefied (r_u above 0.95), and ratios of its stresses are noise.
pub const CARRIES_STRESS: f64 = 0.05;
/// Share of the largest mean stress of a test below which it starts without stress.
const NO_STRESS: f64 = 1e-3;

/// Columns of the normal strains, by axis.
const STRAINS: [&str; 3] = ["axial_strain", "lateral_strain_2", "lateral_strain_3"];
/// Columns of the normal stresses, by axis.
const STRESSES: [&str; 3] = ["stress_11", "stress_22", "stress_33"];

/// The curves of a test.
pub struct Curves<'a> {
    record: &'a Record,
    stages: &'a [Stage],
    /// Index of the stage of each row.
    stage_of: Vec<usize>,
    /// First row of each stage or of a later one.
    first_rows: Vec<usize>,
    /// For each stage the one at which its strains begin to count.
    reset_at: Vec<usize>,
    /// For each stage the first of the undrained part to which it belongs.
    undrained_at: Vec<Option<usize>>,
    axis: Option<usize>,
}

impl<'a> Curves<'a> {
    /// The curves of a record whose test has these stages ([`granum_io::Case::test_stages`]).
    pub fn new(record: &'a Record, stages: &'a [Stage]) -> Curves<'a> {
        let number = |value: &f64| (*value as usize).saturating_sub(1);
        let stage_of: Vec<usize> = match record.series.values("stage") {
            Some(numbers) => numbers.iter().map(number).collect(),
            None => vec![0; record.series.rows()],
        };
        let mut first_rows = vec![stage_of.len(); stages.len() + 1];
        for (row, stage) in stage_of.iter().enumerate().rev() {
            if let Some(first) = first_rows.get_mut(*stage) {
                *first = row;
            }
        }
        for stage in (0..stages.len()).rev() {
            first_rows[stage] = first_rows[stage].min(first_rows[stage + 1]);
        }
        Curves {
            record,
            stages,
            stage_of,
            first_rows,
            reset_at: reset_at(stages),
            undrained_at: undrained_at(stages),
            axis: symmetry::axis(stages),
        }
    }

    /// The axis about which the whole test is axisymmetric; `None` for a general test.
    pub fn axis(&self) -> Option<usize> {
        self.axis
    }

    /// Number of recorded states.
    pub fn rows(&self) -> usize {
        self.stage_of.len()
    }

    /// A column; nothing if it was not recorded.
    pub fn column(&self, name: &str) -> &'a [f64] {
        self.record.series.values(name).unwrap_or(&[])
    }

    pub(super) fn at(&self, name: &str, row: usize) -> f64 {
        self.column(name).get(row).copied().unwrap_or(f64::NAN)
    }

    /// The stage of a row.
    pub(super) fn stage(&self, row: usize) -> Option<&'a Stage> {
        self.stages.get(*self.stage_of.get(row)?)
    }

    /// True if the stages of these rows space their states by the deviator strain `eps_1 - eps_3`, as that of the section `[shear]`
    /// does: their strains are then told by this measure, and else as deviatoric strains.
    pub(super) fn go_by_deviator_strain(&self, rows: &Range<usize>) -> bool {
        let mut stages = rows.clone().filter_map(|row| self.stage(row));
        stages.all(|stage| stage.record.measure == Measure::AxialDeviatorStrain)
    }

    /// Index of the stage of a row.
    pub(super) fn stage_index(&self, row: usize) -> usize {
        self.stage_of.get(row).copied().unwrap_or(0)
    }

    fn each(&self, value: impl Fn(usize) -> f64) -> Vec<f64> {
        (0..self.rows()).map(value).collect()
    }

    /// Stress tensor of a row, Pa.
    pub(super) fn stress(&self, row: usize) -> Matrix {
        const NAMES: [[&str; 3]; 3] = [
            ["stress_11", "stress_12", "stress_13"],
            ["stress_21", "stress_22", "stress_23"],
            ["stress_31", "stress_32", "stress_33"],
        ];
        NAMES.map(|names| names.map(|name| self.at(name, row)))
    }

    /// Strain tensor of a row since another one.
    pub(super) fn strain(&self, row: usize, since: usize) -> Matrix {
        let change = |name: &str| {
            let column = self.column(name);
            if column.is_empty() { 0.0 } else { self.at(name, row) - self.at(name, since) }
        };
        let [yz, zx, xy] =
            ["shear_strain_yz", "shear_strain_zx", "shear_strain_xy"].map(|name| 0.5 * change(name));
        let [x, y, z] = STRAINS.map(change);
        [[x, xy, zx], [xy, y, yz], [zx, yz, z]]
    }

    /// Mean stress p, Pa.
    pub fn mean_stress(&self) -> &'a [f64] {
        self.column("mean_stress")
    }

    /// The deviator stress of every row, Pa: q of an axisymmetric test, q_vM of a general one.
    pub fn deviator_stress(&self) -> Cow<'a, [f64]> {
        match self.axis {
            Some(0) if !self.column("deviator_stress").is_empty() => {
                Cow::Borrowed(self.column("deviator_stress"))
            }
            Some(axis) => Cow::Owned(self.each(|row| symmetry::axial_deviator(&self.stress(row), axis))),
            None => Cow::Owned(self.von_mises_stress()),
        }
    }

    /// Axial less mean lateral stress of every row, Pa, with x as the axis of a general test.
    pub fn axial_deviator(&self) -> Vec<f64> {
        self.each(|row| symmetry::axial_deviator(&self.stress(row), self.axis.unwrap_or(0)))
    }

    /// Von Mises stress `sqrt(3/2 s:s)` of the mean stress tensor of every row, Pa, which has no sign.
    pub fn von_mises_stress(&self) -> Vec<f64> {
        self.each(|row| invariants::signed_von_mises(&self.stress(row)).abs())
    }

    /// The ratio of [`Curves::deviator_stress`] to the mean stress, of every row.
    pub fn stress_ratio(&self) -> Cow<'a, [f64]> {
        match self.axis {
            Some(0) if !self.column("stress_ratio").is_empty() => Cow::Borrowed(self.column("stress_ratio")),
            _ => {
                let (q, p) = (self.deviator_stress(), self.mean_stress());
                Cow::Owned(q.iter().zip(p).map(|(q, p)| q / p).collect())
            }
        }
    }

    /// Mobilised friction angle of every row, degrees, never negative: `sin(phi) = |sigma_a - sigma_r| / (sigma_a + sigma_r)` with the
    /// mean lateral stress sigma_r of an axisymmetric test, and `(sigma_1 - sigma_3) / (sigma_1 + sigma_3)` of the principal
    /// stresses of a general one.
    pub fn friction_angle(&self) -> Vec<f64> {
        self.each(|row| {
            let sine = match self.axis {
                Some(axis) => {
                    let [b, c] = symmetry::others(axis).map(|k| self.at(STRESSES[k], row));
                    let (axial, lateral) = (self.at(STRESSES[axis], row), 0.5 * (b + c));
                    (axial - lateral).abs() / (axial + lateral)
                }
                None => invariants::mobilised_friction(&self.stress(row)),
            };
            libm::asin(sine.clamp(-1.0, 1.0)).to_degrees()
        })
    }

    /// Void ratio of every row.
    pub fn void_ratio(&self) -> Vec<f64> {
        self.column("solid_fraction").iter().map(|solid| (1.0 - solid) / solid).collect()
    }

    /// Strain along the axis of the test (x for a general one) since a row, of every row.
    pub fn axial_strain(&self, since: usize) -> Vec<f64> {
        let name = STRAINS[self.axis.unwrap_or(0)];
        self.each(|row| self.at(name, row) - self.at(name, since))
    }

    /// Volumetric strain since a row, of every row.
    pub fn volumetric_strain(&self, since: usize) -> Vec<f64> {
        self.each(|row| self.at("volumetric_strain", row) - self.at("volumetric_strain", since))
    }

    /// Deviatoric strain `sqrt(2/3 e:e)` of the strain since a row, of every row.
    pub fn deviatoric_strain(&self, since: usize) -> Vec<f64> {
        self.each(|row| invariants::deviatoric_strain(&self.strain(row, since)))
    }

    /// The row at which strains of a row begin to count: the first of the last stage that resets them.
    pub fn counted_from(&self, row: usize) -> usize {
        let reset = self.reset_at.get(self.stage_index(row)).copied().unwrap_or(0);
        self.first_rows.get(reset).copied().unwrap_or(0).min(row)
    }

    /// The row at the start of the undrained part of the test to which a row belongs: of all successive stages that keep the volume,
    /// since the pore pressure of a sample that is not drained between them goes on. `None` for a drained row.
    pub fn undrained_from(&self, row: usize) -> Option<usize> {
        let first = (*self.undrained_at.get(self.stage_index(row))?)?;
        self.first_rows.get(first).copied()
    }

    /// Ratio `r_u = 1 - p/p_0` of the excess pore pressure that a saturated sample under constant total mean stress would show,
    /// with p_0 at the start of the undrained part; NaN in drained rows.
    pub fn pore_pressure_ratio(&self) -> Vec<f64> {
        let p = self.mean_stress();
        self.each(|row| match self.undrained_from(row).and_then(|start| Some(p.get(row)? / p.get(start)?)) {
            Some(share) => 1.0 - share,
            None => f64::NAN,
        })
    }

    /// Decrease of a stress since the start of the undrained part, Pa; NaN in drained rows.
    pub fn lost_while_undrained(&self, column: &str) -> Vec<f64> {
        self.each(|row| match self.undrained_from(row) {
            Some(start) => self.at(column, start) - self.at(column, row),
            None => f64::NAN,
        })
    }

    /// The rows of the test proper: those of the last count of strain in which the sample is sheared, without the isotropic stages and
    /// the rest before, and without marks, probes and compressions without lateral stress. Where nothing is sheared, the last count with two rows or more.
    pub fn test_rows(&self) -> Range<usize> {
        let is_unconfined = |stage: &Stage| symmetry::unconfined_axis(stage).is_some();
        let shears = |row: usize| {
            self.stage(row).is_none_or(|stage| {
                !stage.is_mark() && !stage.settling && !symmetry::is_isotropic(stage) && !is_unconfined(stage)
            })
        };
        let mut end = self.rows();
        while end > 0 {
            let start = self.counted_from(end - 1);
            let rows = start..end;
            let first = rows.clone().find(|row| shears(*row));
            let last = rows.clone().rev().find(|row| shears(*row));
            if let (Some(first), Some(last)) = (first, last)
                && last > first
            {
                return first..last + 1;
            }
            end = start;
        }
        let mut end = self.rows();
        while end > 0 {
            let start = self.counted_from(end - 1);
            if end - start >= 2 {
                return start..end;
            }
            end = start;
        }
        0..self.rows()
    }

    /// True for the rows that carry stress: at least [`CARRIES_STRESS`] of the mean stress at the start of the undrained part, or of
    /// the test; of the largest mean stress of the test where it starts without stress.
    pub fn carry_stress(&self, rows: &Range<usize>) -> Vec<bool> {
        let p = self.mean_stress();
        let at = |row: usize| p.get(row).copied().unwrap_or(f64::NAN);
        let largest = rows.clone().map(at).fold(0.0, f64::max);
        rows.clone()
            .map(|row| {
                let start = at(self.undrained_from(row).unwrap_or(rows.start));
                let start = if start > NO_STRESS * largest { start } else { largest };
                at(row) > 0.0 && at(row) >= CARRIES_STRESS * start
            })
            .collect()
    }

    /// Of the rows that carry stress the one with the stress ratio of the largest magnitude.
    pub fn peak_row(&self, rows: &Range<usize>) -> Option<usize> {
        let ratios = self.stress_ratio();
        let strong = rows
            .clone()
            .zip(self.carry_stress(rows))
            .filter(|(row, carries)| *carries && ratios[*row].is_finite());
        strong.map(|(row, _)| row).max_by(|a, b| ratios[*a].abs().total_cmp(&ratios[*b].abs()))
    }

    /// True if the rows shear the sample so that they tell its strength: neither isotropic alone, nor oedometric, nor probes.
    pub(super) fn tells_strength(&self, rows: &Range<usize>) -> bool {
        let mut stages = rows.clone().filter_map(|row| self.stage(row));
        let oedometric = stages
            .clone()
            .any(|stage| symmetry::is_oedometric(stage) || symmetry::unconfined_axis(stage).is_some());
        // A probe records nothing but its start.
        let recorded = |stage: &Stage| stage.record != granum_dem::loading::RecordedStates::default();
        rows.len() >= 2
            && !oedometric
            && stages.any(|stage| !symmetry::is_isotropic(stage) && recorded(stage))
    }
}

/// For each stage the one at which its strains begin to count.
fn reset_at(stages: &[Stage]) -> Vec<usize> {
    let mut reset = 0;
    let mut found = Vec::with_capacity(stages.len());
    for (k, stage) in stages.iter().enumerate() {
        if stage.resets {
            reset = k;
        }
        found.push(reset);
    }
    found
}

/// For each stage the first of the undrained part to which it belongs: successive stages that keep the volume, of which one at
/// least is driven, since a sample whose cell stands still is neither drained nor undrained.
fn undrained_at(stages: &[Stage]) -> Vec<Option<usize>> {
    let keeps = |stage: &Stage| stage.is_mark() || symmetry::keeps_volume(&stage.control) && !stage.settling;
    let mut found = vec![None; stages.len()];
    let mut first = 0;
    while first < stages.len() {
        let count = stages[first..].iter().take_while(|stage| keeps(stage)).count();
        let part = first..first + count;
        if stages[part.clone()].iter().any(|stage| !stage.is_mark() && symmetry::is_driven(stage)) {
            found[part].fill(Some(first));
        }
        first += count.max(1);
    }
    found
}
