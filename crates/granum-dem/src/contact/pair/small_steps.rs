//! Tangential steps of zero, and of the size of rounding, between two curves of a law with memory.
//!
//! A law that asks whether a step goes on or back must not let the last digit of a displacement answer: paths that differ by less than
//! anything that counts give the same force.

use granum_simd::cbrt;

use super::path::{PairRow, PathRow};
use super::refined::drive_pair_refined;
use crate::config::{Material, NormalKind, TangentialKind};
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::law::pair_properties::PairProperties;

const TOLERANCE: f64 = 1e-5;

fn pair(interface_energy: f64) -> PairProperties {
    let material = Material { interface_energy, friction: 0.3, ..Material::default() };
    PairProperties::new((&material, 5e-5), (&material, 5e-5), 0.0)
}

fn drive(tangential: TangentialKind, path: &[(f64, f64)]) -> Vec<PairRow> {
    let path: Vec<PathRow> = path
        .iter()
        .map(|&(normal_approach, tangential_displacement)| PathRow {
            normal_approach,
            tangential_displacement,
        })
        .collect();
    let contact = ContactModel::new(NormalKind::HERTZ, tangential, 0.1);
    drive_pair_refined(&contact, &pair(0.0), &path, TOLERANCE).unwrap().rows
}

/// The force on the loading curve at held shear while the limit falls from one value to another:
/// `dT = (1 - theta) dL` with `theta^3 = 1 - T/L`, by steps of fourth order; it slides where it reaches the limit.
fn held_shear(mut force: f64, from: f64, to: f64) -> f64 {
    let steps = 20_000;
    let step = (to - from) / f64::from(steps);
    let slope = |force: f64, limit: f64| 1.0 - cbrt((1.0 - force / limit).max(0.0));
    for k in 0..steps {
        let limit = from + f64::from(k) * step;
        let a = slope(force, limit);
        let b = slope(force + 0.5 * step * a, limit + 0.5 * step);
        let c = slope(force + 0.5 * step * b, limit + 0.5 * step);
        let d = slope(force + step * c, limit + step);
        force = (force + step / 6.0 * (a + 2.0 * b + 2.0 * c + d)).min(limit + step);
    }
    force
}

#[test]
fn normal_unloading_at_held_shear_stays_on_the_loading_curve() {
    let friction = pair(0.0).friction;
    for (shear, approach) in [(1e-9, 9e-9), (1e-9, 5e-9), (3e-10, 2e-9), (2e-9, 9.9e-9), (1e-9, 2e-9)] {
        let rows =
            drive(TangentialKind::MINDLIN_DERESIEWICZ, &[(1e-8, 0.0), (1e-8, shear), (approach, shear)]);
        let [top, end] = [1, 2].map(|k: usize| friction * rows[k].normal_force);
        let right = held_shear(rows[1].tangential_force, top, end);
        let miss = rows[2].tangential_force / right - 1.0;
        assert!(miss.abs() < 2e-4, "{shear:e} {approach:e}: {miss:e}, at {} of the limit", right / end);
    }
}

/// The same force, whatever the last digits of the displacement are: after loading, after unloading and after reloading in shear, while
/// the normal load falls, grows, or stays.
#[test]
fn the_last_digits_of_a_displacement_decide_nothing() {
    let histories: [&[f64]; 4] = [&[1e-9], &[1e-9, 4e-10], &[1e-9, -6e-10, 2e-10], &[-8e-10]];
    for tangential in [TangentialKind::MINDLIN_DERESIEWICZ, TangentialKind::NO_SLIP] {
        for shears in histories {
            for approach in [9e-9, 5e-9, 1e-8, 1.2e-8, 2e-8] {
                let last = shears[shears.len() - 1];
                let forces = [0.0, 1e-15, -1e-15, 1e-13, -1e-13].map(|hair: f64| {
                    let mut path = vec![(1e-8, 0.0)];
                    path.extend(shears.iter().map(|&shear| (1e-8, shear)));
                    path.push((approach, last + hair * 1e-9));
                    // What follows shows whether the memory is the same as well.
                    path.push((approach, last + 2e-10));
                    let rows = drive(tangential, &path);
                    [rows[rows.len() - 2].tangential_force, rows[rows.len() - 1].tangential_force]
                });
                let size = forces.iter().flatten().fold(0.0f64, |most, force| most.max(force.abs()));
                for force in forces {
                    for k in 0..2 {
                        let miss = (force[k] - forces[0][k]).abs() / size;
                        assert!(miss < 1e-4, "{tangential:?} {shears:?} {approach:e}, row {k}: {forces:?}");
                    }
                }
            }
        }
    }
}

/// A contact that is held at its peeling force stays there while its load changes, with a step of zero as with one of rounding.
#[test]
fn the_last_digits_decide_nothing_while_a_contact_peels() {
    let p = pair(0.1);
    let contact = ContactModel::new(NormalKind::JKR, TangentialKind::PEELING, 0.1);
    for approach in [1.9e-8, 2e-8, 2.1e-8] {
        for shear in [5e-10, 2e-9, 4e-9, 6e-9] {
            let ends = [0.0, 1e-15, -1e-15, 1e-13, -1e-13].map(|hair: f64| {
                let path =
                    [(2e-8, 0.0), (2e-8, shear), (approach, shear * (1.0 + hair)), (approach, 1.2 * shear)]
                        .map(|(normal_approach, tangential_displacement)| PathRow {
                            normal_approach,
                            tangential_displacement,
                        });
                let rows = drive_pair_refined(&contact, &p, &path, 1e-4).unwrap().rows;
                [rows[2].tangential_force, rows[3].tangential_force]
            });
            for end in ends {
                for k in 0..2 {
                    let miss = (end[k] / ends[0][k] - 1.0).abs();
                    assert!(miss < 1e-3, "{approach:e} {shear:e}, row {k}: {ends:?}");
                }
            }
        }
    }
}
