//! Force chains (Peters, Muthuswamy, Wibowo and Tordesillas 2005): quasi-linear rows of highly stressed grains along which
//! force is passed on.
//!
//! The stress of a grain is `sigma^p = (1/V_p) sum f r`, with the contact forces f on it and the arms r from its centre to the
//! contacts. A grain is highly stressed if its largest principal stress exceeds the mean of that over all grains. Two such grains
//! in contact are linked if the branch lies within 45 degrees of the major direction of both. So that chains do not branch, only
//! the link nearest to the major direction is retained on either side of a grain, and a link counts if it is retained at both of
//! its grains. A chain has three grains or more.

use granum_core::Part;
use granum_core::assembly::{Matrix, Vector};
use granum_core::geometry::dot;

use crate::ratio::{mean, ratio};
use crate::tensor::{add_dyad, principal, scaled};
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Cosine of the largest angle between a link and the major directions.
const ALIGNED: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// Fewest grains of a chain.
const SHORTEST: usize = 3;

/// The sensor.
pub struct ForceChains;

impl Sensor for ForceChains {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("force_chains", "number and length of the force chains (Peters et al. 2005)")
            .speaking_of(Subject::Bodies)
            .columns([
                SensorColumn::new("force_chains", "1", "number of chains of three grains or more"),
                SensorColumn::new("chain_grain_fraction", "1", "grains in chains over all grains"),
                SensorColumn::new("mean_chain_length", "1", "mean number of grains of a chain"),
                SensorColumn::new("longest_chain", "1", "number of grains of the longest chain"),
                SensorColumn::new(
                    "highly_stressed_fraction",
                    "1",
                    "grains whose largest principal stress exceeds its mean",
                ),
            ])
            .needing(&[Part::Radii, Part::Contacts, Part::NormalForces, Part::TangentialForces])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let found = Chains::from_observation(observation);
        let grains = observation.assembly.bodies.len();
        let members: usize = found.chains.iter().map(Vec::len).sum();
        values.extend([
            found.chains.len() as f64,
            mean(members as f64, grains),
            mean(members as f64, found.chains.len()),
            found.chains.iter().map(Vec::len).max().unwrap_or(0) as f64,
            mean(found.highly_stressed as f64, grains),
        ]);
    }
}

/// The force chains of an assembly.
///
/// ```
/// use granum_core::Assembly;
/// use granum_sensors::{Observation, force_chains::Chains};
///
/// assert!(Chains::from_observation(&Observation::new(&Assembly::default())).chains.is_empty());
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chains {
    /// The grains of each chain, in their order along it.
    pub chains: Vec<Vec<usize>>,
    /// Number of grains whose largest principal stress exceeds the mean.
    pub highly_stressed: usize,
}

impl Chains {
    /// Finds the chains.
    pub fn from_observation(observation: &Observation) -> Chains {
        let stresses = grain_stresses(observation);
        let major: Vec<(f64, Vector)> = stresses.iter().map(|stress| principal(stress)[0]).collect();
        let limit = mean(major.iter().map(|(stress, _)| stress).sum(), major.len());
        let is_high = |grain: usize| major.get(grain).is_some_and(|(stress, _)| *stress > limit);
        // On each side of each grain the link nearest to its direction: the other grain and the cosine.
        let mut best: Vec<[Option<(usize, f64)>; 2]> = vec![[None; 2]; major.len()];
        for contact in &observation.assembly.contacts {
            let Some([i, j]) = observation.assembly.bodies_of(contact) else { continue };
            if !(is_high(i) && is_high(j)) {
                continue;
            }
            let branch = &observation.assembly.branch_of_bodies(contact);
            let length = branch.iter().map(|x| x * x).sum::<f64>().sqrt();
            let cosine = |grain: usize| ratio(dot(branch, &major[grain].1), length);
            if cosine(i).abs() < ALIGNED || cosine(j).abs() < ALIGNED {
                continue;
            }
            keep(&mut best[i], j, cosine(i));
            keep(&mut best[j], i, -cosine(j));
        }
        let partners: Vec<[Option<usize>; 2]> = (0..best.len())
            .map(|grain| {
                best[grain].map(|link| {
                    let (other, _) = link?;
                    best[other].iter().flatten().any(|(back, _)| *back == grain).then_some(other)
                })
            })
            .collect();
        let highly_stressed = (0..major.len()).filter(|&grain| is_high(grain)).count();
        Chains { chains: follow(&partners), highly_stressed }
    }
}

/// Stores a link on its side of a grain, if it is nearer to the major direction than the link stored there.
fn keep(sides: &mut [Option<(usize, f64)>; 2], other: usize, cosine: f64) {
    let side = &mut sides[usize::from(cosine < 0.0)];
    if side.is_none_or(|(_, found)| cosine.abs() > found) {
        *side = Some((other, cosine.abs()));
    }
}

/// The rows of partners with enough grains: first those with ends, then the closed ones.
fn follow(partners: &[[Option<usize>; 2]]) -> Vec<Vec<usize>> {
    let degree = |grain: usize| partners[grain].iter().flatten().count();
    let mut seen = vec![false; partners.len()];
    let mut chains = Vec::new();
    let ends = (0..partners.len()).filter(|&grain| degree(grain) == 1);
    for start in ends.chain((0..partners.len()).filter(|&grain| degree(grain) == 2)) {
        let mut chain = Vec::new();
        let mut next = Some(start).filter(|&grain| !seen[grain]);
        while let Some(grain) = next {
            seen[grain] = true;
            chain.push(grain);
            next = partners[grain].iter().flatten().copied().find(|&other| !seen[other]);
        }
        if chain.len() >= SHORTEST {
            chains.push(chain);
        }
    }
    chains
}

/// Stress of each grain, compression positive, Pa.
fn grain_stresses(observation: &Observation) -> Vec<Matrix> {
    let assembly = observation.assembly;
    let (grains, pieces) = (&assembly.bodies, &assembly.pieces);
    let mut sums = vec![[[0.0; 3]; 3]; grains.len()];
    for contact in &assembly.contacts {
        let (Some(i), Some(j)) = (pieces.get(contact.i), pieces.get(contact.j)) else { continue };
        let force = contact.force();
        // The arms divide the branch of the pieces as the radii do; on j both force and arm are opposite.
        for (piece, side) in [(i, -1.0), (j, 1.0)] {
            let sum = &mut sums[piece.body];
            add_dyad(sum, -ratio(piece.radius, i.radius + j.radius), &force, &contact.branch);
            if !assembly.all_spheres() {
                add_dyad(sum, side, &force, &piece.arm);
            }
        }
    }
    let volume = |radius: f64| 4.0 / 3.0 * std::f64::consts::PI * radius * radius * radius;
    sums.iter()
        .zip(grains)
        .map(|(sum, grain)| scaled(sum, ratio(1.0, volume(grain.equivalent_radius))))
        .collect()
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::sensor::measured;
    use crate::{clumps, lattice};
    use granum_core::assembly::{Assembly, Contact, Sphere};

    /// Grains of radius 1 at these places, which touch where they are nearer than 2.1, with a force for each pair.
    pub(crate) fn grains_at(places: &[Vector], force: impl Fn(usize, usize) -> f64) -> Assembly {
        let grains: Vec<Sphere> = places
            .iter()
            .map(|&position| Sphere { position, radius: 1.0, mass: 1.0, ..Default::default() })
            .collect();
        let mut contacts = Vec::new();
        for i in 0..places.len() {
            for j in i + 1..places.len() {
                let branch: Vector = std::array::from_fn(|a| places[j][a] - places[i][a]);
                let length = dot(&branch, &branch).sqrt();
                if length < 2.1 {
                    let normal = branch.map(|x| x / length);
                    contacts.push(Contact {
                        i,
                        j,
                        branch,
                        normal,
                        normal_force: force(i, j),
                        ..Default::default()
                    });
                }
            }
        }
        let cell = [[100.0, 0.0, 0.0], [0.0, 100.0, 0.0], [0.0, 0.0, 100.0]];
        Assembly { cell, contacts, ..Default::default() }.with_spheres(grains)
    }

    /// A loaded row of five grains next to a weakly loaded row of five, with weak contacts between them.
    #[test]
    fn a_loaded_row_is_one_chain() {
        let places: Vec<Vector> =
            (0..10).map(|k| [2.0 * (k % 5) as f64, 2.0 * (k / 5) as f64, 0.0]).collect();
        let assembly = grains_at(&places, |i, j| if i < 5 && j < 5 { 10.0 } else { 0.5 });
        let found = Chains::from_observation(&Observation::new(&assembly));
        assert_eq!(found, Chains { chains: vec![vec![0, 1, 2, 3, 4]], highly_stressed: 5 });
        assert_eq!(measured(&ForceChains, &assembly), [1.0, 0.5, 5.0, 5.0, 0.5]);
    }

    /// A row that turns by 60 degrees in the middle: the grain at the corner is aligned with either arm within 45 degrees,
    /// and at a right angle it is not.
    #[test]
    fn a_chain_bends_but_does_not_turn_a_corner() {
        let bent = |angle: f64| {
            let (s, c) = angle.to_radians().sin_cos();
            let arm = |k: f64| [4.0 + 2.0 * k * c, 2.0 * k * s, 0.0];
            let places = [
                [0.0; 3],
                [2.0, 0.0, 0.0],
                [4.0, 0.0, 0.0],
                arm(1.0),
                arm(2.0),
                [50.0; 3],
                [60.0; 3],
                [70.0; 3],
            ];
            Chains::from_observation(&Observation::new(&grains_at(&places, |_, _| 1.0))).chains
        };
        assert_eq!(bent(60.0), [vec![0, 1, 2, 3, 4]]);
        assert!(bent(100.0).iter().all(|chain| chain.len() < 5));
    }

    /// In a cubic lattice loaded along one axis the rows close on themselves.
    #[test]
    fn a_lattice_loaded_along_one_axis_consists_of_closed_rows() {
        let mut assembly = lattice::simple_cubic(4, 1e-4, 0.0, 1.0);
        for contact in &mut assembly.contacts {
            // Half of the rows bear twice as much.
            let in_row = assembly.pieces[contact.i].position[0] < 2e-4;
            contact.normal_force = if contact.normal[1].abs() < 0.5 {
                0.1
            } else if in_row {
                2.0
            } else {
                1.0
            };
        }
        let found = Chains::from_observation(&Observation::new(&assembly));
        assert_eq!((found.chains.len(), found.highly_stressed), (8, 32));
        assert!(found.chains.iter().all(|chain| chain.len() == 4));
    }

    /// The stresses of the grains, weighted with their volumes, are the stress of the sample: of clumps with the branches between the centres
    /// of mass.
    #[test]
    fn the_stresses_of_the_grains_are_that_of_the_sample() {
        let mut packing = clumps::packing(3);
        packing.advance(3000).unwrap();
        for assembly in [clumps::few(), packing.assembly(), lattice::random_contacts(50, 2)] {
            let observation = Observation::new(&assembly);
            let mut sum = [[0.0; 3]; 3];
            for (stress, body) in grain_stresses(&observation).iter().zip(&assembly.bodies) {
                let volume = 4.0 / 3.0 * std::f64::consts::PI * body.equivalent_radius.powi(3);
                (0..9).for_each(|k| sum[k / 3][k % 3] += stress[k / 3][k % 3] * volume / observation.volume);
            }
            let (tensor, p) = (observation.stress.tensor(), observation.stress.mean());
            assert!(p != 0.0);
            for (own, whole) in sum.iter().flatten().zip(tensor.iter().flatten()) {
                assert!((own - whole).abs() < 1e-12 * p.abs(), "{sum:?} {tensor:?}");
            }
        }
    }
}
