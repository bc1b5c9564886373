//! Fragments: sets of grains that bonds hold together, and how they are graded.
//!
//! A fragment is a connected set of bodies with live bonds, single grains among them; its size is the diameter d of the sphere of the volume of
//! its bodies, which counts no pores. A fragment that is bonded to its own image through the faces of the cell has no size: it spans the cell.
//! With the shares w by mass of the fragments now and w_0 of those before any bond ruptured:
//!
//! - relative breakage of Hardin (1985): `B_r = B_t / B_p`, areas in log10 d above 0.074 mm between the gradings;
//! - breakage of Einav (2007): `B = int (F - F_0) dln d / int (F_u - F_0) dln d` with the ultimate grading `F_u = (d/d_M)^(3 - alpha)`,
//!   alpha = 2.6, from d = 0 to the largest size d_M before any bond ruptured;
//! - fractal dimension D: the slope of log F over log d of the fragments smaller than d_M is `3 - D`.
//!
//! They are zero where they mean nothing: breakage where bonded grains span the cell or where more than half of the mass was one fragment, as in
//! cemented sand; D unless the sizes of fragments span a decade.

use granum_core::Part;
use granum_core::assembly::Assembly;
use granum_core::geometry::{apply, invert};

use crate::ratio::ratio;
use crate::{Memory, Observation, Sensor, SensorColumn, SensorDescription, Subject, Values};

/// Size below which particles are fines, m (Hardin 1985).
const FINES: f64 = 74e-6;
/// Exponent of the ultimate grading (Einav 2007).
const ALPHA: f64 = 2.6;

/// The sensor.
pub struct Fragments;

impl Sensor for Fragments {
    fn description(&self) -> SensorDescription {
        SensorDescription::new("fragments", "sets of grains that bonds hold together, and their grading")
            .speaking_of(Subject::Bonds)
            .columns([
                SensorColumn::new("fragments", "1", "number of sets of two and more bonded grains"),
                SensorColumn::new(
                    "single_grain_fraction",
                    "1",
                    "grains without bonds, over all grains by mass",
                ),
                SensorColumn::new(
                    "largest_fragment_fraction",
                    "1",
                    "mass of the largest fragment over that of all grains",
                ),
                SensorColumn::new("spanning_fragments", "1", "number of fragments that span the cell"),
                SensorColumn::new("fragment_d50", "m", "size below which half of the mass is"),
                SensorColumn::new("hardin_breakage", "1", "relative breakage B_r of Hardin"),
                SensorColumn::new("einav_breakage", "1", "breakage B of Einav"),
                SensorColumn::new(
                    "fragment_fractal_dimension",
                    "1",
                    "fractal dimension D of the sizes of fragments",
                ),
            ])
            .needing(&[Part::Bonds, Part::Radii, Part::Masses])
    }

    fn measure(&self, observation: &Observation, _: &mut Memory, values: &mut Values) {
        let assembly = observation.assembly;
        let now = fragments(assembly);
        let whole: f64 = assembly.bodies.iter().map(|body| body.mass).sum();
        let mass = |of: &dyn Fn(&Fragment) -> bool| -> f64 {
            now.iter().filter(|fragment| of(fragment)).map(|fragment| fragment.mass).sum::<f64>() + 0.0
        };
        let bonded = |fragment: &&Fragment| fragment.bodies.len() > 1;
        let largest = now.iter().map(|fragment| fragment.mass).fold(0.0, f64::max);
        let spanning = now.iter().filter(|fragment| fragment.spans).count();
        values.push(now.iter().filter(bonded).count() as f64);
        values.push(ratio(mass(&|fragment| fragment.bodies.len() == 1), whole));
        values.push(ratio(largest, whole));
        values.push(spanning as f64);
        let graded = Grading::from_sizes(now.iter().map(|fragment| (fragment.size, fragment.mass)).collect());
        values.push(if spanning == 0 { graded.size_below_which(0.5) } else { 0.0 });
        let before = Grading::from_sizes(made_of(assembly));
        let means_nothing = spanning > 0
            || before.largest_share() > 0.5
            || assembly.bonds.is_empty() && assembly.broken_bonds.is_empty();
        let [hardin, einav, dimension] = if means_nothing {
            [0.0; 3]
        } else {
            [hardin(&before, &graded), einav(&before, &graded), graded.fractal_dimension(before.largest())]
        };
        values.extend([hardin, einav, dimension]);
    }
}

/// A set of grains that bonds hold together.
#[derive(Clone, Debug, PartialEq)]
pub struct Fragment {
    /// Its bodies, as indices of [`Assembly::bodies`].
    pub bodies: Vec<usize>,
    /// By how many edges of the cell each of its bodies is moved to lie beside the first one.
    pub images: Vec<[i64; 3]>,
    /// Its mass, kg.
    pub mass: f64,
    /// Diameter of the sphere of the volume of its bodies, m.
    pub size: f64,
    /// Its centre of mass inside the cell, m; `None` if it spans the cell.
    pub centre: Option<[f64; 3]>,
    /// True if it is bonded to an image of itself.
    pub spans: bool,
}

/// Sets that are joined pair by pair; every member knows by how many edges of the cell it is away from the first one.
struct Sets {
    parent: Vec<usize>,
    shift: Vec<[i64; 3]>,
    spans: Vec<bool>,
}

impl Sets {
    fn new(count: usize) -> Sets {
        Sets { parent: (0..count).collect(), shift: vec![[0; 3]; count], spans: vec![false; count] }
    }

    /// The first member of the set of a member, and the edges to the member from there.
    fn find(&mut self, of: usize) -> (usize, [i64; 3]) {
        let (mut root, mut total) = (of, [0; 3]);
        while self.parent[root] != root {
            total = add(total, self.shift[root], 1);
            root = self.parent[root];
        }
        // Everybody on the way is attached to the first member.
        let (mut at, mut left) = (of, total);
        while self.parent[at] != root && at != root {
            let (next, step) = (self.parent[at], self.shift[at]);
            (self.parent[at], self.shift[at]) = (root, left);
            left = add(left, step, -1);
            at = next;
        }
        (root, total)
    }

    /// Joins two members, of which the second is in an image.
    fn join(&mut self, i: usize, j: usize, image: [i64; 3]) {
        let ((a, to_i), (b, to_j)) = (self.find(i), self.find(j));
        // From a to b by way of the bond.
        let apart = add(add(to_i, image, 1), to_j, -1);
        if a == b {
            self.spans[a] |= apart != [0; 3];
            return;
        }
        let (first, second, apart) = if a < b { (a, b, apart) } else { (b, a, add([0; 3], apart, -1)) };
        (self.parent[second], self.shift[second]) = (first, apart);
        self.spans[first] |= self.spans[second];
    }
}

fn add(a: [i64; 3], b: [i64; 3], sign: i64) -> [i64; 3] {
    std::array::from_fn(|k| a[k] + sign * b[k])
}

/// The fragments of an assembly, in the order of their first bodies.
pub fn fragments(assembly: &Assembly) -> Vec<Fragment> {
    let bodies = &assembly.bodies;
    let mut sets = Sets::new(bodies.len());
    let inverse = invert(&assembly.cell);
    for bond in &assembly.bonds {
        let [Some(i), Some(j)] = [bond.i, bond.j].map(|piece| assembly.body_of(piece)) else { continue };
        let branch = assembly.branch_of_bond(bond);
        let beyond = std::array::from_fn(|a| bodies[i].position[a] + branch[a] - bodies[j].position[a]);
        sets.join(i, j, apply(&inverse, beyond).map(|edges| edges.round() as i64));
    }
    let mut place = vec![usize::MAX; bodies.len()];
    let mut found: Vec<(Fragment, [f64; 3], f64)> = Vec::new();
    for (k, body) in bodies.iter().enumerate() {
        let (root, shift) = sets.find(k);
        if place[root] == usize::MAX {
            place[root] = found.len();
            let spans = sets.spans[root];
            found.push((
                Fragment {
                    bodies: Vec::new(),
                    images: Vec::new(),
                    mass: 0.0,
                    size: 0.0,
                    centre: None,
                    spans,
                },
                [0.0; 3],
                0.0,
            ));
        }
        let (fragment, moment, volume) = &mut found[place[root]];
        fragment.bodies.push(k);
        fragment.images.push(shift);
        fragment.mass += body.mass;
        *volume += body.equivalent_radius.powi(3);
        let image = apply(&assembly.cell, shift.map(|edges| edges as f64));
        for a in 0..3 {
            moment[a] += body.mass * (body.position[a] + image[a]);
        }
    }
    let finish = |(mut fragment, moment, cubes): (Fragment, [f64; 3], f64)| {
        fragment.size = 2.0 * libm::cbrt(cubes);
        let place = apply(&inverse, moment.map(|x| x / fragment.mass));
        fragment.centre = (!fragment.spans).then(|| apply(&assembly.cell, place.map(|x| x - x.floor())));
        fragment
    };
    found.into_iter().map(finish).collect()
}

/// True if bonds made agglomerates of the grains: before any ruptured they held several grains together, and no more than half of the mass.
pub fn are_agglomerates(assembly: &Assembly) -> bool {
    let before = made_of(assembly);
    before.len() < assembly.bodies.len() && Grading::from_sizes(before).largest_share() <= 0.5
}

/// Sizes and masses of what all bonds held together before any of them ruptured.
fn made_of(assembly: &Assembly) -> Vec<(f64, f64)> {
    let bodies = &assembly.bodies;
    let mut sets = Sets::new(bodies.len());
    let index = |id: u64| bodies.binary_search_by_key(&id, |body| body.id).ok();
    let live = assembly.bonds.iter().map(|bond| [bond.i, bond.j].map(|piece| assembly.body_of(piece)));
    let broken = assembly.broken_bonds.iter().map(|bond| bond.bodies.map(index));
    for pair in live.chain(broken) {
        if let [Some(i), Some(j)] = pair {
            sets.join(i, j, [0; 3]);
        }
    }
    let mut of_set = vec![(0.0, 0.0); bodies.len()];
    for (k, body) in bodies.iter().enumerate() {
        let (cubes, mass) = &mut of_set[sets.find(k).0];
        *cubes += body.equivalent_radius.powi(3);
        *mass += body.mass;
    }
    of_set
        .into_iter()
        .filter(|(cubes, _)| *cubes > 0.0)
        .map(|(cubes, mass)| (2.0 * libm::cbrt(cubes), mass))
        .collect()
}

/// Sizes in rising order with their shares of the mass.
struct Grading(Vec<(f64, f64)>);

impl Grading {
    fn from_sizes(mut sizes: Vec<(f64, f64)>) -> Grading {
        sizes.sort_by(|a, b| a.0.total_cmp(&b.0));
        let whole: f64 = sizes.iter().map(|(_, mass)| mass).sum();
        Grading(sizes.into_iter().map(|(size, mass)| (size, ratio(mass, whole))).collect())
    }

    fn largest(&self) -> f64 {
        self.0.last().map_or(0.0, |(size, _)| *size)
    }

    fn largest_share(&self) -> f64 {
        self.0.iter().map(|(_, share)| *share).fold(0.0, f64::max)
    }

    /// The mean of a function of the size, by mass.
    fn mean(&self, of: impl Fn(f64) -> f64) -> f64 {
        self.0.iter().map(|(size, share)| share * of(*size)).sum()
    }

    /// The size below which a share of the mass is.
    fn size_below_which(&self, share: f64) -> f64 {
        let mut passing = 0.0;
        for (size, part) in &self.0 {
            passing += part;
            if passing >= share {
                return *size;
            }
        }
        self.largest()
    }

    /// `3 -` the slope of log passing over log size, of the sizes below a largest one; zero unless they span a decade.
    fn fractal_dimension(&self, below: f64) -> f64 {
        let mut points: Vec<[f64; 2]> = Vec::new();
        let mut passing = 0.0;
        for equal in self.0.chunk_by(|a, b| a.0 == b.0) {
            passing += equal.iter().map(|(_, share)| share).sum::<f64>();
            if equal[0].0 < below {
                points.push([libm::log(equal[0].0), libm::log(passing)]);
            }
        }
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return 0.0 };
        if last[0] - first[0] < std::f64::consts::LN_10 {
            return 0.0;
        }
        let count = points.len() as f64;
        let mean = |k: usize| points.iter().map(|point| point[k]).sum::<f64>() / count;
        let (x, y) = (mean(0), mean(1));
        let slope = points.iter().map(|p| (p[0] - x) * (p[1] - y)).sum::<f64>()
            / points.iter().map(|p| (p[0] - x) * (p[0] - x)).sum::<f64>();
        3.0 - slope
    }
}

fn hardin(before: &Grading, now: &Grading) -> f64 {
    let coarser = |size: f64| libm::log10(size / FINES).max(0.0);
    ratio(before.mean(coarser) - now.mean(coarser), before.mean(coarser))
}

fn einav(before: &Grading, now: &Grading) -> f64 {
    let mean = before.mean(libm::log);
    let ultimate = libm::log(before.largest()) - 1.0 / (3.0 - ALPHA);
    ratio(mean - now.mean(libm::log), mean - ultimate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sensor::measured;
    use granum_core::assembly::{Bond, BrokenBond, Rupture, Sphere};

    /// Spheres along the first axis of a cell with edges of ten, and bonds between some of them.
    fn row(places: &[f64], bonds: &[[usize; 2]]) -> Assembly {
        let edges = [[10.0, 0.0, 0.0], [0.0, 10.0, 0.0], [0.0, 0.0, 10.0]];
        let sphere = |(k, x): (usize, &f64)| Sphere {
            id: k as u64 + 1,
            position: [*x, 5.0, 5.0],
            radius: 0.4,
            mass: 1.0,
            ..Sphere::default()
        };
        let mut assembly = Assembly { cell: edges, ..Assembly::default() }
            .with_spheres(places.iter().enumerate().map(sphere));
        for (k, [i, j]) in bonds.iter().copied().enumerate() {
            let apart = places[j] - places[i];
            let branch = [apart - 10.0 * (apart / 10.0).round(), 0.0, 0.0];
            assembly.bonds.push(Bond { id: k as u64, i, j, branch, ..Bond::default() });
        }
        assembly
    }

    /// A fault of other programs: faces cut a fragment, and its centre was the mean of wrapped places.
    #[test]
    fn a_fragment_across_a_face_is_one_and_has_its_centre() {
        let found = fragments(&row(&[9.4, 0.2, 1.0, 5.0], &[[0, 1], [1, 2]]));
        assert_eq!(
            found.iter().map(|fragment| fragment.bodies.clone()).collect::<Vec<_>>(),
            [vec![0, 1, 2], vec![3]]
        );
        let centre = found[0].centre.unwrap();
        assert!((centre[0] - 0.2).abs() < 1e-12 && !found[0].spans, "{centre:?}");
        assert!((found[0].size / 0.8 - libm::cbrt(3.0)).abs() < 1e-12);
        // A ring through the face has no centre.
        let places: Vec<f64> = (0..10).map(|k| f64::from(k) + 0.5).collect();
        let ring: Vec<[usize; 2]> = (0..10).map(|k| [k, (k + 1) % 10]).collect();
        let found = fragments(&row(&places, &ring));
        assert!(found.len() == 1 && found[0].spans && found[0].centre.is_none());
        assert!(!fragments(&row(&places, &ring[1..]))[0].spans);
    }

    #[test]
    fn breakage_has_its_golden_values() {
        let before = Grading::from_sizes(vec![(1e-3, 2.0)]);
        let now = Grading::from_sizes(vec![(0.5e-3, 1.0), (1e-3, 1.0)]);
        assert!((hardin(&before, &now) - 0.133_108_613_4).abs() < 1e-9);
        assert!((einav(&before, &now) - 0.138_629_436_1).abs() < 1e-9);
        assert_eq!([hardin(&before, &before), einav(&before, &before)], [0.0; 2]);
        // A power law of exponent 0.5 is a dimension of 2.5; half a decade is too little.
        let power = |decades: f64| {
            let cuts: Vec<f64> =
                (0..=40).map(|k| libm::pow(10.0, -decades * f64::from(k) / 40.0)).rev().collect();
            let mut last = 0.0;
            let mut sizes = Vec::new();
            for cut in cuts {
                let passing = cut.sqrt();
                sizes.push((cut, passing - last));
                last = passing;
            }
            Grading::from_sizes(sizes)
        };
        assert!((power(2.0).fractal_dimension(1.0) - 2.5).abs() < 1e-9);
        assert_eq!(power(0.5).fractal_dimension(1.0), 0.0);
    }

    #[test]
    fn agglomerates_that_break_are_graded() {
        let mut assembly = row(&[1.0, 1.8, 4.0, 4.8, 7.0, 7.8], &[[0, 1], [2, 3]]);
        let crack = BrokenBond {
            id: 2,
            bodies: [5, 6],
            rupture: Rupture::Shear,
            energy: 1.0,
            time: 0.0,
            phase: 0,
            place: [0.0; 3],
            normal: [1.0, 0.0, 0.0],
            radius: 0.1,
        };
        assembly.broken_bonds.push(crack);
        let row = measured(&Fragments, &assembly);
        assert_eq!(row[..4], [2.0, 1.0 / 3.0, 1.0 / 3.0, 0.0]);
        assert!(are_agglomerates(&assembly));
        // A third of the mass lost a third of ln 2 in size.
        assert!((row[6] - libm::log(2.0) / 9.0 / 2.5).abs() < 1e-12 && row[5] > 0.0, "{row:?}");
        assembly.bonds.clear();
        assembly.broken_bonds.clear();
        let row = measured(&Fragments, &assembly);
        assert_eq!((row[0], row[1], row[6]), (0.0, 1.0, 0.0));
        assert!(!are_agglomerates(&assembly));
    }
}
