//! Voids between agglomerates, and pores inside of them.
//!
//! An agglomerate of spheres has pores of its own, which the [void ratio](crate::void_ratio) `e = (V - V_s)/V_s` counts among the voids. The
//! volume V_g of the grains with these pores is the sum over all [fragments](crate::fragments) of the volume of their convex hulls:
//!
//! - intergranular void ratio `e_g = (V - V_g)/V_g`: the pores inside count as part of the grains;
//! - intragranular porosity `n_g = (V_g - V_s)/V_g`, so that `1 + e = (1 + e_g)/(1 - n_g)`.
//!
//! A fragment keeps the pores within its own hull: a rupture that takes a piece off opens the pores between both. A grain without bonds is its own
//! hull, also one of several rigid pieces. The hull is found within 0.5 % ([`granum_shape::descriptors::hull_volume`]); it counts the roughness of
//! the surface as inside. Hulls of neighbours that interlock overlap, which makes e_g a lower bound: the rougher the grains and the more bent the fragments, the lower. Where a fragment
//! spans the cell it has no hull, and both are 0.

use granum_core::Part;
use granum_core::assembly::Assembly;
use granum_core::geometry::apply;
use granum_shape::ShapePiece;
use granum_shape::descriptors::hull_volume;

use crate::fragments::{Fragment, fragments};
use crate::ratio::ratio;
use crate::solid_fraction::grain_volume;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// The sensor.
pub struct AgglomerateVoids;

impl Sensor for AgglomerateVoids {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("agglomerate_voids", "voids between agglomerates, and pores inside of them")
            .speaking_of(Subject::Bonds)
            .columns([
                SensorColumn::new(
                    "intergranular_void_ratio",
                    "1",
                    "e_g = (V - V_g) / V_g, V_g the volume of the convex hulls of the fragments",
                ),
                SensorColumn::new(
                    "intragranular_porosity",
                    "1",
                    "n_g = (V_g - V_s) / V_g: share of the pores in the volume of the grains",
                ),
            ])
            .needing(&[Part::Cell, Part::Bonds, Part::Radii])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let solid = grain_volume(observation);
        let [between, inside] = match volume_with_pores(observation.assembly) {
            Some(grains) => [ratio(observation.volume - grains, grains), ratio(grains - solid, grains)],
            None => [0.0; 2],
        };
        values.extend([between, inside]);
    }
}

/// Volume V_g of the grains with the pores inside of them, m3: the sum of the convex hulls of all fragments; `None` if one spans the cell.
pub fn volume_with_pores(assembly: &Assembly) -> Option<f64> {
    let found = fragments(assembly);
    if found.iter().any(|fragment| fragment.spans) {
        return None;
    }
    let mut pieces = vec![Vec::new(); assembly.bodies.len()];
    for (k, piece) in assembly.pieces.iter().enumerate() {
        if let Some(own) = pieces.get_mut(piece.body) {
            own.push(k);
        }
    }
    Some(found.iter().map(|fragment| volume_of(assembly, fragment, &pieces)).sum::<f64>() + 0.0)
}

/// Volume of the convex hull of a fragment, m3; `pieces` are those of each body.
fn volume_of(assembly: &Assembly, fragment: &Fragment, pieces: &[Vec<usize>]) -> f64 {
    let solid =
        |body: &usize| 4.0 / 3.0 * std::f64::consts::PI * assembly.bodies[*body].equivalent_radius.powi(3);
    let of_solid: f64 = fragment.bodies.iter().map(solid).sum();
    if fragment.bodies.len() < 2 {
        return of_solid;
    }
    // Beside the first body, so that the numbers of the hull are small.
    let first = assembly.bodies[fragment.bodies[0]].position;
    let mut spheres = Vec::new();
    for (body, image) in fragment.bodies.iter().zip(&fragment.images) {
        let centre = assembly.bodies[*body].position;
        let moved = apply(&assembly.cell, image.map(|edges| edges as f64));
        for piece in pieces[*body].iter().map(|k| &assembly.pieces[*k]) {
            let place = std::array::from_fn(|a| centre[a] - first[a] + moved[a] + piece.arm[a]);
            spheres.push(ShapePiece { centre: place, radius: piece.radius });
        }
    }
    hull_volume(&spheres).max(of_solid)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::measured;
    use crate::void_ratio::void_ratio;
    use granum_core::assembly::{Bond, Sphere};

    const PI: f64 = std::f64::consts::PI;

    /// Spheres of radius one half in a cell with edges of ten, and bonds between some of them.
    fn spheres(places: &[[f64; 3]], bonds: &[[usize; 2]]) -> Assembly {
        let edges = [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
        let sphere = |(k, place): (usize, &[f64; 3])| Sphere {
            id: k as u64 + 1,
            position: *place,
            radius: 0.5,
            mass: 1.0,
            ..Sphere::default()
        };
        let mut assembly = Assembly { cell: edges, ..Assembly::default() }
            .with_spheres(places.iter().enumerate().map(sphere));
        for (k, [i, j]) in bonds.iter().copied().enumerate() {
            let branch = std::array::from_fn(|a| {
                let apart: f64 = places[j][a] - places[i][a];
                apart - 10.0 * (apart / 10.0).round()
            });
            assembly.bonds.push(Bond { id: k as u64, i, j, branch, ..Bond::default() });
        }
        assembly
    }

    /// Two spheres across a face are a capsule, a third is alone; then the bond ruptures.
    #[test]
    fn pores_inside_count_as_grain_until_the_bond_ruptures() {
        let places = [[9.6, 5.0, 5.0], [0.6, 5.0, 5.0], [5.0, 5.0, 5.0]];
        let bonded = spheres(&places, &[[0, 1]]);
        let (capsule, sphere) = (PI / 6.0 + PI / 4.0, PI / 6.0);
        let grains = volume_with_pores(&bonded).unwrap();
        assert!((grains / (capsule + sphere) - 1.0).abs() < 5e-3, "{grains}");
        let [between, inside] = measured(&AgglomerateVoids, &bonded)[..] else { panic!() };
        assert!((between - (1000.0 / grains - 1.0)).abs() < 1e-9);
        // Both void ratios belong together.
        let whole = void_ratio(&Observation::new(&bonded));
        assert!(((1.0 + between) / (1.0 - inside) / (1.0 + whole) - 1.0).abs() < 1e-12);
        let broken = spheres(&places, &[]);
        let row = measured(&AgglomerateVoids, &broken);
        assert!((row[0] / whole - 1.0).abs() < 1e-12 && row[1].abs() < 1e-12, "{row:?}");
    }

    /// Eight spheres on the corners of a cube, by Steiner's formula.
    #[test]
    fn a_cube_of_eight_spheres_has_its_hull() {
        let place = |k: usize| [k & 1, k >> 1 & 1, k >> 2].map(|edge| 4.0 + edge as f64);
        let places: Vec<[f64; 3]> = (0..8).map(place).collect();
        let bonds: Vec<[usize; 2]> =
            (0..8).flat_map(|k| [1, 2, 4].map(|bit| [k, k | bit])).filter(|[i, j]| i != j).collect();
        let cube = spheres(&places, &bonds);
        let steiner = 1.0 + 6.0 * 0.5 + 3.0 * PI * 0.25 + PI / 6.0;
        assert!((volume_with_pores(&cube).unwrap() / steiner - 1.0).abs() < 5e-3);
        let porosity = measured(&AgglomerateVoids, &cube)[1];
        assert!((porosity - (1.0 - 8.0 * PI / 6.0 / steiner)).abs() < 5e-3, "{porosity}");
    }

    #[test]
    fn what_spans_the_cell_has_no_hull() {
        let places: Vec<[f64; 3]> = (0..10).map(|k| [f64::from(k) + 0.5, 5.0, 5.0]).collect();
        let ring: Vec<[usize; 2]> = (0..10).map(|k| [k, (k + 1) % 10]).collect();
        assert_eq!(volume_with_pores(&spheres(&places, &ring)), None);
        assert_eq!(measured(&AgglomerateVoids, &spheres(&places, &ring)), [0.0, 0.0]);
    }
}
