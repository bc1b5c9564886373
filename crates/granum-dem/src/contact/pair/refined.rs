//! A pair on a prescribed path, with results that do not depend on the spacing of the rows of the path.
//!
//! The tangential laws are incremental: a long step uses the stiffness at its start throughout, neglects the growth of the slip
//! zone, and so gives too large a force and too little hysteresis. The straight line between two rows is therefore
//! divided into equal steps, doubled in number each time, until the forces at the rows no longer change.

use crate::contact::choice::contact_model::ContactModel;
use crate::contact::law::pair_properties::PairProperties;
use crate::contact::pair::path::{PairError, PairRow, PathRow, drive_pair_in_steps};

/// Largest number of steps between two rows.
const MOST_STEPS: usize = 1 << 20;
/// Largest number of steps of a whole path: this takes seconds.
const MOST_STEPS_OF_PATH: usize = 1 << 27;

/// Change of a force, over the largest force of the whole path, below which it is rounding that more steps do not remove.
const ROUNDING: f64 = 1e-10;

/// The result of [`drive_pair_refined`].
#[derive(Clone, Debug, PartialEq)]
pub struct RefinedPath {
    /// The forces at the rows of the path.
    pub rows: Vec<PairRow>,
    /// Number of equal steps from one row to the next.
    pub steps: usize,
    /// Largest change of a force compared with half as many steps, as a fraction of the largest force of its kind on the
    /// path; a change that is lost in the rounding of the largest force of the whole path counts as none.
    pub change: f64,
}

/// Runs a path with the laws of `contact`, dividing the distance between rows into 2, 4, 8 ... steps until no force at a row
/// changes by more than `tolerance` times the largest force of its kind (normal, tangential) on the path. Changes below 1e-10 of the
/// largest force of the whole path are rounding: on a purely normal path the tangential force is nothing else.
///
/// # Errors
/// As for [`crate::contact::pair::path::drive_pair`]; [`PairError::NotConverged`] if too many steps would be needed.
pub fn drive_pair_refined(
    contact: &ContactModel,
    pair: &PairProperties,
    path: &[PathRow],
    tolerance: f64,
) -> Result<RefinedPath, PairError> {
    let most = MOST_STEPS.min(MOST_STEPS_OF_PATH / path.len().max(1)).max(2);
    let mut steps = 1;
    let mut rows = drive_pair_in_steps(contact, pair, path, steps)?;
    loop {
        steps *= 2;
        let finer = drive_pair_in_steps(contact, pair, path, steps)?;
        let (row, change) = largest_change(&rows, &finer);
        if change <= tolerance {
            return Ok(RefinedPath { rows: finer, steps, change });
        }
        if 2 * steps > most {
            return Err(PairError::NotConverged { row: row + 1, steps, change, tolerance });
        }
        rows = finer;
    }
}

/// The row where a force changes most, and the change as a fraction of the largest force of its kind.
fn largest_change(coarse: &[PairRow], fine: &[PairRow]) -> (usize, f64) {
    let kinds: [fn(&PairRow) -> f64; 2] = [|row| row.normal_force, |row| row.tangential_force];
    let largest = kinds.map(|force| fine.iter().fold(0.0f64, |most, row| most.max(force(row).abs())));
    let rounding = ROUNDING * largest[0].max(largest[1]);
    let mut worst = (0, 0.0);
    for (force, largest) in kinds.into_iter().zip(largest) {
        for (k, (a, b)) in coarse.iter().zip(fine).enumerate() {
            let change = (force(a) - force(b)).abs();
            if change > rounding && change > worst.1 * largest {
                worst = (k, change / largest.max(f64::MIN_POSITIVE));
            }
        }
    }
    worst
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{Material, NormalKind, TangentialKind};

    const TOLERANCE: f64 = 1e-5;

    fn pair() -> PairProperties {
        let material = Material { interface_energy: 0.0, ..Material::default() };
        PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
    }

    fn row(normal_approach: f64, tangential_displacement: f64) -> PathRow {
        PathRow { normal_approach, tangential_displacement }
    }

    /// Mindlin and Deresiewicz 1953, at constant load: the curve of first loading relative to the limit mu N, with the
    /// displacement in units of that at which the contact slides.
    fn loading(displacement: f64) -> f64 {
        1.0 - (1.0 - displacement).max(0.0).powf(1.5)
    }

    #[test]
    fn the_loop_of_mindlin_and_deresiewicz_comes_of_its_turning_points_alone() {
        let p = pair();
        let approach = 1e-8;
        let radius = (p.effective_radius * approach).sqrt();
        let limit = p.friction * 4.0 / 3.0 * p.effective_modulus * radius * approach;
        // Tangential displacement at which the whole contact slides: 3 mu N / (16 G* a).
        let slides = 1.5 * limit / (8.0 * p.effective_shear_modulus * radius);
        let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ, 0.1);
        for amplitude in [0.1, 0.3, 0.6, 0.9] {
            let at = |share: f64| row(approach, share * amplitude * slides);
            let path = [row(approach, 0.0), at(1.0), at(0.0), at(-1.0), at(0.0), at(1.0)];
            let refined = drive_pair_refined(&contact, &p, &path, TOLERANCE).unwrap();
            // The curves of unloading and reloading, from the turning points, are the loading curve at twice the size.
            let top = loading(amplitude);
            let half = top - 2.0 * loading(0.5 * amplitude);
            let wanted = [0.0, top, half, -top, -half, top];
            for (k, (found, wanted)) in refined.rows.iter().zip(wanted).enumerate() {
                let miss = (found.tangential_force / limit - wanted).abs();
                assert!(
                    miss < 2e-5,
                    "amplitude {amplitude}, row {k}: misses by {miss} with {} steps",
                    refined.steps
                );
            }
            assert!(refined.change <= TOLERANCE && refined.steps > 2);
        }
    }

    #[test]
    fn rows_in_between_change_nothing() {
        let p = pair();
        for (normal, tangential) in [
            (NormalKind::HERTZ, TangentialKind::MINDLIN_DERESIEWICZ),
            (NormalKind::HERTZ, TangentialKind::NO_SLIP),
            (NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ),
            (NormalKind::JKR, TangentialKind::PEELING),
        ] {
            let material = Material { interface_energy: 0.1, ..Material::default() };
            let p = if normal == NormalKind::JKR {
                PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
            } else {
                p
            };
            let contact = ContactModel::new(normal, tangential, 0.1);
            let coarse = [row(1e-8, 0.0), row(1.5e-8, 2e-9), row(1e-8, 1e-9), row(2e-8, -2e-9)];
            let mut fine = Vec::new();
            let mut before = row(0.0, 0.0);
            for end in coarse {
                fine.extend((1..=7).map(|k| {
                    let share = f64::from(k) / 7.0;
                    let mix = |a: f64, b: f64| if k == 7 { b } else { a + share * (b - a) };
                    row(
                        mix(before.normal_approach, end.normal_approach),
                        mix(before.tangential_displacement, end.tangential_displacement),
                    )
                }));
                before = end;
            }
            let coarse = drive_pair_refined(&contact, &p, &coarse, TOLERANCE).unwrap();
            let fine = drive_pair_refined(&contact, &p, &fine, TOLERANCE).unwrap();
            let largest = fine.rows.iter().fold(0.0f64, |most, row| most.max(row.tangential_force.abs()));
            for (k, end) in coarse.rows.iter().enumerate() {
                let same = fine.rows[7 * k + 6];
                let miss = (same.tangential_force - end.tangential_force).abs() / largest;
                assert!(miss < 4e-5, "{normal:?} {tangential:?} row {k}: {miss}");
                assert_eq!(same.normal_force, end.normal_force);
            }
        }
    }

    /// Approach and separation of adhesive grains, without a tangential displacement: its force is rounding, and so are its changes.
    #[test]
    fn a_purely_normal_path_converges() {
        let material = Material { interface_energy: 0.1, ..Material::default() };
        let p = PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0);
        let force = 1.5 * std::f64::consts::PI * 0.1 * p.effective_radius;
        let length = (3.0 * force / p.effective_modulus).powf(2.0 / 3.0) / p.effective_radius.cbrt();
        let shares = [0.0, 0.2, 0.75, 3.3, 17.0, 3.3, 0.75, 0.2, -0.05, -0.2];
        let path = shares.map(|share| row(share * length, 0.0));
        for tangential in
            [TangentialKind::NO_SLIP, TangentialKind::MINDLIN_DERESIEWICZ, TangentialKind::PEELING]
        {
            let contact = ContactModel::new(NormalKind::JKR, tangential, 0.1);
            let refined = drive_pair_refined(&contact, &p, &path, TOLERANCE).unwrap();
            assert!(refined.steps <= 64, "{tangential:?}: {} steps", refined.steps);
            let largest = refined.rows.iter().fold(0.0f64, |most, row| most.max(row.normal_force));
            assert!(largest > 10.0 * force);
            for (k, row) in refined.rows.iter().enumerate() {
                assert!(row.tangential_force.abs() < 1e-12 * largest, "{tangential:?} {k}: {row:?}");
            }
        }
    }

    #[test]
    fn what_does_not_settle_is_told_and_nothing_is_nothing() {
        let contact = ContactModel { normal: NormalKind::HERTZ, ..ContactModel::default() };
        let path = [row(1e-8, 0.0), row(1e-8, 1e-9)];
        let error = drive_pair_refined(&contact, &pair(), &path, 0.0).unwrap_err().to_string();
        assert!(error.starts_with("row 2: ") && error.contains("steps"), "{error}");
        let none = drive_pair_refined(&contact, &pair(), &[], TOLERANCE).unwrap();
        assert!(none.rows.is_empty() && none.change == 0.0);
        let apart = drive_pair_refined(&contact, &pair(), &[row(-1e-8, 1e-9)], TOLERANCE).unwrap();
        assert_eq!(apart.rows, [PairRow::default()]);
    }
}
