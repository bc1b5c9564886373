//! Two grains on a prescribed path: the contact law by itself, evaluated by the same function as in the engine.
//!
//! The centres keep a fixed direction n, at the distance `R_i + R_j - normal_approach`. Grain j is translated along a fixed
//! direction t perpendicular to n, without rolling and without spin; the tangential displacement of its surface relative to
//! that of grain i is zero before the first row. Between rows the pair moves in a straight line, in one step or in several.
//! Internally n is oblique to all axes, so that no error remains hidden by an alignment with them.

use granum_simd::{Isa, Kernel, Lanes, dispatch, mul_add};
use serde::{Deserialize, Serialize};

use crate::contact::choice::check::check;
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::choice::law_error::LawError;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::interaction::{PairMotion, interact};
use crate::contact::evaluation::memory::Memory;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::slot::columns::One;
use crate::contact::slot::slots::{Open, Slots};
use granum_simd::vectors::dot;

/// One row of a path: the relative position of the pair at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PathRow {
    /// Approach alpha of the grains, m; negative if they are separated.
    pub normal_approach: f64,
    /// Tangential displacement of grain j relative to grain i, m.
    pub tangential_displacement: f64,
}

impl PathRow {
    /// The position after `step` of `steps` equal steps on the straight line to `end`; after the last one it is exactly
    /// `end`.
    fn towards(&self, end: &PathRow, step: usize, steps: usize) -> PathRow {
        if step == steps {
            return *end;
        }
        let share = step as f64 / steps as f64;
        let mix = |from: f64, to: f64| mul_add(share, to - from, from);
        PathRow {
            normal_approach: mix(self.normal_approach, end.normal_approach),
            tangential_displacement: mix(self.tangential_displacement, end.tangential_displacement),
        }
    }
}

/// The response of the contact at the end of a step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct PairRow {
    /// Elastic normal force N, compression positive, N.
    pub normal_force: f64,
    /// Elastic tangential force against the direction of the path, N: positive when it resists a growing displacement.
    pub tangential_force: f64,
    /// Radius a of the contact area, m; zero for separated grains.
    pub contact_radius: f64,
}

/// Reasons why a path cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PairError {
    /// The laws cannot be combined.
    #[error(transparent)]
    Law(#[from] LawError),
    /// A number of the path is not finite.
    #[error("row {row}: {column} is {value}; it must be a finite number of metres")]
    NotFinite {
        /// Row number, from 1.
        row: usize,
        /// Name of the column.
        column: &'static str,
        /// The value found.
        value: f64,
    },
    /// The grains would pass through each other.
    #[error(
        "row {row}: normal_approach is {value} m; it must stay below half the sum of the radii, {limit} m"
    )]
    TooDeep {
        /// Row number, from 1.
        row: usize,
        /// The value found.
        value: f64,
        /// Half of R_i + R_j, m.
        limit: f64,
    },
    /// The forces still depend on the length of the steps.
    #[error(
        "row {row}: with {steps} steps per row its force still changes by {change:.1e} of the largest force of the \
         path; at most {tolerance:.1e} is allowed; insert more rows before it"
    )]
    NotConverged {
        /// Number of the row whose force changes most, from 1.
        row: usize,
        /// Largest number of steps per row that was tried.
        steps: usize,
        /// Change compared with half as many steps, as a fraction of the largest force of its kind.
        change: f64,
        /// Tolerance for the change.
        tolerance: f64,
    },
}

/// Runs a path with the laws of `contact`, each row in one step (the damping does not matter, since the returned forces are
/// elastic). The caller is responsible for steps of suitable length; [`crate::contact::pair::refined::drive_pair_refined`] accepts any
/// rows.
///
/// # Errors
/// If the laws cannot be combined, a number is not finite, or the grains would pass through each other.
pub fn drive_pair(
    contact: &ContactModel,
    pair: &PairProperties,
    path: &[PathRow],
) -> Result<Vec<PairRow>, PairError> {
    drive_pair_in_steps(contact, pair, path, 1)
}

/// The same as [`drive_pair`], with the straight line to each row divided into a given number of equal steps.
pub(super) fn drive_pair_in_steps(
    contact: &ContactModel,
    pair: &PairProperties,
    path: &[PathRow],
    steps: usize,
) -> Result<Vec<PairRow>, PairError> {
    check(contact)?;
    let limit = 0.5 * pair.radius_sum;
    for (n, row) in path.iter().enumerate() {
        let columns = [
            ("normal_approach", row.normal_approach),
            ("tangential_displacement", row.tangential_displacement),
        ];
        for (column, value) in columns {
            if !value.is_finite() {
                return Err(PairError::NotFinite { row: n + 1, column, value });
            }
        }
        if row.normal_approach >= limit {
            return Err(PairError::TooDeep { row: n + 1, value: row.normal_approach, limit });
        }
    }
    let isa = Isa::detect();
    Ok(dispatch(
        isa,
        Steps {
            contact,
            constants: contact.constants(pair),
            path,
            steps,
            laws: Open::new(&Slots::new(contact, isa)),
        },
    ))
}

/// The steps of a path in scalar arithmetic, compiled for the fused operations of the processor.
struct Steps<'a> {
    contact: &'a ContactModel,
    constants: PairConstants<f64>,
    path: &'a [PathRow],
    steps: usize,
    laws: Open<'a, One>,
}

/// Unit normal `(1, 2, 3) / sqrt 14`, and the direction of the path perpendicular to it.
fn directions() -> ([f64; 3], [f64; 3]) {
    let normal = [1.0, 2.0, 3.0].map(|x| x / 14f64.sqrt());
    let along = [4.0, 1.0, -2.0].map(|x| x / 21f64.sqrt());
    (normal, along)
}

impl Kernel for Steps<'_> {
    type Output = Vec<PairRow>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Vec<PairRow> {
        let (normal, along) = directions();
        let mut memory = Memory::<f64>::new();
        let mut before = PathRow::default();
        let mut rows = Vec::with_capacity(self.path.len());
        for row in self.path {
            let start = before;
            let mut found = PairRow::default();
            for step in 1..=self.steps {
                let end = start.towards(row, step, self.steps);
                let distance = self.constants.radius_sum - end.normal_approach;
                let slip = end.tangential_displacement - before.tangential_displacement;
                let opening = before.normal_approach - end.normal_approach;
                let kinematics = PairMotion {
                    branch: [distance * normal[0], distance * normal[1], distance * normal[2]],
                    velocity: [
                        mul_add(slip, along[0], opening * normal[0]),
                        mul_add(slip, along[1], opening * normal[1]),
                        mul_add(slip, along[2], opening * normal[2]),
                    ],
                    rolling: [0.0; 3],
                    mean_spin: [0.0; 3],
                    relative_spin: [0.0; 3],
                };
                self.contact.wet(&self.constants, end.normal_approach, &mut memory);
                // Each step takes one second: the path has no rate.
                let out = interact(&self.laws, &self.constants, &kinematics, 1.0, &mut memory);
                found = PairRow {
                    normal_force: out.normal_force,
                    tangential_force: dot(out.elastic, along),
                    contact_radius: out.radius,
                };
                before = end;
            }
            rows.push(found);
        }
        rows
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Material, NormalKind, TangentialKind};

    fn pair() -> PairProperties {
        let material = Material { interface_energy: 0.0, ..Material::default() };
        PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
    }

    fn contact(tangential: TangentialKind) -> ContactModel {
        ContactModel::new(NormalKind::HERTZ, tangential, 0.1)
    }

    #[test]
    fn answers_hertz_and_no_slip_by_hand() {
        let p = pair();
        let approach = 1e-8;
        let path = [(approach, 0.0), (approach, 1e-10), (approach, 3e-10), (-1e-9, 3e-10)].map(
            |(normal_approach, tangential_displacement)| PathRow { normal_approach, tangential_displacement },
        );
        let rows = drive_pair(&contact(TangentialKind::NO_SLIP), &p, &path).unwrap();
        let radius = (p.effective_radius * approach).sqrt();
        let force = 4.0 / 3.0 * p.effective_modulus * radius * approach;
        let stiffness = 8.0 * p.effective_shear_modulus * radius;
        for (row, displacement) in rows.iter().zip([0.0, 1e-10, 3e-10]) {
            assert!((row.normal_force / force - 1.0).abs() < 1e-11);
            assert!((row.contact_radius / radius - 1.0).abs() < 1e-11);
            assert!((row.tangential_force - stiffness * displacement).abs() < 1e-11 * stiffness * 1e-9);
        }
        assert_eq!(rows[3], PairRow::default());
    }

    #[test]
    fn slides_in_both_directions() {
        let p = pair();
        let path: Vec<PathRow> = (0..400)
            .map(|k| PathRow {
                normal_approach: 1e-8,
                tangential_displacement: 1e-10 * if k < 100 { k } else { 200 - k } as f64,
            })
            .collect();
        for tangential in [TangentialKind::NO_SLIP, TangentialKind::MINDLIN_DERESIEWICZ] {
            let rows = drive_pair(&contact(tangential), &p, &path).unwrap();
            let limit = p.friction * rows[99].normal_force;
            assert!((rows[99].tangential_force / limit - 1.0).abs() < 1e-12);
            assert!((rows[399].tangential_force / limit + 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn refuses_what_cannot_be_run() {
        let bad = |normal_approach, tangential_displacement| {
            let path = [PathRow::default(), PathRow { normal_approach, tangential_displacement }];
            drive_pair(&contact(TangentialKind::NO_SLIP), &pair(), &path).unwrap_err().to_string()
        };
        assert!(bad(f64::NAN, 0.0).starts_with("row 2: normal_approach is NaN"));
        assert!(bad(0.0, f64::INFINITY).starts_with("row 2: tangential_displacement is inf"));
        assert!(bad(6e-5, 0.0).contains("below half the sum of the radii"));
        let peeling = drive_pair(&contact(TangentialKind::PEELING), &pair(), &[]);
        assert!(matches!(peeling, Err(PairError::Law(LawError::Apart { .. }))));
    }
}
