//! Random insertion of grains without overlap, from a seed: the initial state of a preparation.

use granum_simd::Row8;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;

use crate::assembly::Vector;
use crate::cell::Cell;
use crate::config::Grains;
use crate::initial_sphere::InitialSphere;
use crate::observer::{Flow, NoObserver, SimulationObserver, Work};
use crate::particle_row::ParticleRow;
use crate::random::unit;
use crate::sizes::SizeError;

/// Number of attempts for one grain after which the initial state is reported as too dense.
const TRIES: usize = 200_000;
/// Number of times that all grains are placed anew: few grains may block each other by chance at a solid fraction at which others have room.
const FRESH_STARTS: usize = 10;
/// Number of attempts after which positions are drawn only from regions that may have room.
const PATIENCE: usize = 30;
/// Side of a room (a small cube of the cell) over the smallest diameter, and largest number of rooms along an edge.
const ROOM: f64 = 1.0 / 3.0;
const MOST_ROOMS: usize = 1024;
/// Number of attempts, or of grains around which rooms are closed, between two calls of the observer.
const ATTEMPTS_AT_ONCE: u64 = 1024;

/// The initial state cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InsertionError {
    /// A grain found no place.
    #[error(
        "no room for grain {placed} of {count} at an initial solid fraction of {solid_fraction}: random placement reaches about 0.38, \
         and less with few grains; choose a preparation.initial_solid_fraction below {solid_fraction}"
    )]
    NoRoom {
        /// Grains that have a place.
        placed: usize,
        /// Grains that need one.
        count: usize,
        /// The requested solid fraction.
        solid_fraction: f64,
    },
    /// The observer stopped it.
    #[error("stopped after {placed} of {count} grains had been placed")]
    Stopped {
        /// Grains that have a place.
        placed: usize,
        /// Grains that need one.
        count: usize,
    },
    /// The grains cannot have these sizes.
    #[error(transparent)]
    Sizes(#[from] SizeError),
    /// The grains cannot have these shapes.
    #[error("grains.shape: {0}")]
    Shapes(#[from] granum_shape::ShapeError),
}

/// Places grains one after the other at random in a cubic cell of the given solid fraction (random sequential addition).
/// The diameters are those of [`Grains::diameters`].
///
/// # Errors
/// If the grains cannot have these sizes, or there is no room for one of them.
pub fn random_insertion(
    grains: &Grains,
    solid_fraction: f64,
    seed: u64,
) -> Result<(Cell, Vec<InitialSphere>), InsertionError> {
    followed_insertion(grains, solid_fraction, seed, &mut NoObserver)
}

/// As [`random_insertion`], with an observer that is told of the work ([`Work::Placing`]) and can stop it.
///
/// # Errors
/// As for [`random_insertion`]; [`InsertionError::Stopped`] if the observer stops it.
pub fn followed_insertion(
    grains: &Grains,
    solid_fraction: f64,
    seed: u64,
    observer: &mut dyn SimulationObserver,
) -> Result<(Cell, Vec<InitialSphere>), InsertionError> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut radii: Vec<f64> =
        grains.diameters(&mut rng)?.into_iter().map(|diameter| 0.5 * diameter).collect();
    // Large grains first: small ones fit between them.
    radii.sort_unstable_by(|a, b| b.total_cmp(a));
    let solid: f64 = radii.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
    let length = libm::cbrt(solid / solid_fraction);
    let mut listen = Listen::new(observer, grains.count);
    let mut most = 0;
    for _ in 0..FRESH_STARTS {
        match placed(&radii, length, &mut rng, &mut listen)? {
            Ok(spheres) => return Ok((Cell::cuboid([length; 3]), spheres)),
            Err(placed) => most = most.max(placed),
        }
    }
    Err(InsertionError::NoRoom { placed: most, count: grains.count, solid_fraction })
}

/// Places grains of these radii, in falling order, in a cell with this edge; the number of those that found a place if one of them found none.
fn placed(
    radii: &[f64],
    length: f64,
    rng: &mut ChaCha8Rng,
    listen: &mut Listen,
) -> Result<Result<Vec<InitialSphere>, usize>, InsertionError> {
    let mut boxes = Boxes::new(length, 2.0 * radii[0]);
    let smallest = radii.last().copied().unwrap_or(0.0);
    let mut rooms: Option<Rooms> = None;
    let mut spheres: Vec<InitialSphere> = Vec::with_capacity(radii.len());
    for (k, &radius) in radii.iter().enumerate() {
        let mut found = None;
        for attempt in 0..TRIES {
            listen.tell(k)?;
            if attempt == PATIENCE && rooms.is_none() {
                rooms = Some(Rooms::new(length, smallest, &spheres, listen)?);
            }
            let guess = match &mut rooms {
                None => Some([(); 3].map(|()| length * unit(rng))),
                Some(rooms) => rooms.guess(rng),
            };
            let Some(x) = guess else { break };
            if boxes.free(&x, radius) {
                found = Some(x);
                break;
            }
        }
        let Some(position) = found else {
            return Ok(Err(k));
        };
        boxes.insert(position, radius);
        if let Some(rooms) = &mut rooms {
            rooms.close_around(&position, radius);
        }
        spheres.push(InitialSphere { id: k as u64 + 1, position, radius });
    }
    Ok(Ok(spheres))
}

/// Tells the observer of the work now and then.
pub(crate) struct Listen<'a> {
    observer: &'a mut dyn SimulationObserver,
    calls: u64,
    count: usize,
}

impl<'a> Listen<'a> {
    pub(crate) fn new(observer: &'a mut dyn SimulationObserver, count: usize) -> Listen<'a> {
        Listen { observer, calls: 0, count }
    }

    pub(crate) fn tell(&mut self, placed: usize) -> Result<(), InsertionError> {
        let (due, count) = (self.calls.is_multiple_of(ATTEMPTS_AT_ONCE), self.count);
        self.calls += 1;
        if due && self.observer.work(&Work::Placing { placed, count }) == Flow::Stop {
            return Err(InsertionError::Stopped { placed, count });
        }
        Ok(())
    }
}

/// Small cubes ("rooms") that fill the cell. A room all of whose points are too close to a placed grain is closed for good;
/// a random point of the open rooms has the distribution of a random point of the cell that is drawn again until it falls
/// into one of them.
struct Rooms {
    side: f64,
    count: usize,
    smallest: f64,
    closed: Vec<bool>,
    open: Vec<u32>,
}

impl Rooms {
    fn new(
        length: f64,
        smallest: f64,
        spheres: &[InitialSphere],
        listen: &mut Listen,
    ) -> Result<Rooms, InsertionError> {
        let count = ((length / (2.0 * smallest * ROOM)).ceil() as usize).clamp(1, MOST_ROOMS);
        let all = count.pow(3);
        let mut rooms = Rooms {
            side: length / count as f64,
            count,
            smallest,
            closed: vec![false; all],
            open: Vec::new(),
        };
        for sphere in spheres {
            listen.tell(spheres.len())?;
            rooms.close_around(&sphere.position, sphere.radius);
        }
        rooms.open = (0..all as u32).filter(|&k| !rooms.closed[k as usize]).collect();
        Ok(rooms)
    }

    /// Closes the rooms whose farthest corner is too close to a grain for the smallest grain to fit.
    fn close_around(&mut self, x: &Vector, radius: f64) {
        let reach = radius + self.smallest;
        let (n, half) = (self.count as i64, 0.5 * self.side);
        let wide = ((reach / self.side).ceil() as i64).min(n / 2);
        let middle = x.map(|v| (v / self.side) as i64);
        // Squared distance to the far face of a room, for each axis.
        let far = |axis: usize, offset: i64| {
            let centre = (middle[axis] + offset) as f64 * self.side + half;
            ((centre - x[axis]).abs() + half).powi(2)
        };
        let at = |axis: usize, offset: i64| (middle[axis] + offset).rem_euclid(n) as usize;
        for a in -wide..=wide {
            for b in -wide..=wide {
                let plane = far(0, a) + far(1, b);
                if plane > reach * reach {
                    continue;
                }
                let row = (at(0, a) * self.count + at(1, b)) * self.count;
                for c in -wide..=wide {
                    if plane + far(2, c) < reach * reach {
                        self.closed[row + at(2, c)] = true;
                    }
                }
            }
        }
    }

    /// A random point of the open rooms; `None` if all are closed.
    fn guess(&mut self, rng: &mut ChaCha8Rng) -> Option<Vector> {
        while !self.open.is_empty() {
            let at = (unit(rng) * self.open.len() as f64) as usize;
            let room = self.open[at] as usize;
            if self.closed[room] {
                self.open.swap_remove(at);
                continue;
            }
            let corner =
                [room / (self.count * self.count), room / self.count % self.count, room % self.count];
            return Some(corner.map(|c| (c as f64 + unit(rng)) * self.side));
        }
        None
    }
}

/// Placed grains, by box.
pub(crate) struct Boxes {
    length: f64,
    count: usize,
    content: Vec<Vec<Row8>>,
}

impl Boxes {
    pub(crate) fn new(length: f64, diameter: f64) -> Boxes {
        let count = ((length / diameter).floor() as usize).clamp(1, 400);
        Boxes { length, count, content: vec![Vec::new(); count.pow(3)] }
    }

    fn index(&self, x: &Vector) -> [usize; 3] {
        x.map(|v| ((v / self.length * self.count as f64) as usize).min(self.count - 1))
    }

    pub(crate) fn insert(&mut self, x: Vector, radius: f64) {
        let [a, b, c] = self.index(&x);
        self.content[(a * self.count + b) * self.count + c]
            .push(Row8([x[0], x[1], x[2], radius, 0.0, 0.0, 0.0, 0.0]));
    }

    pub(crate) fn free(&self, x: &Vector, radius: f64) -> bool {
        let here = self.index(x);
        let n = self.count as i64;
        (0..27).all(|step| {
            let offset = [step / 9 - 1, (step / 3) % 3 - 1, step % 3 - 1];
            let b: [usize; 3] =
                std::array::from_fn(|a| (here[a] as i64 + offset[a] as i64).rem_euclid(n) as usize);
            self.content[(b[0] * self.count + b[1]) * self.count + b[2]].iter().all(|other| {
                let square: f64 = (0..3)
                    .map(|a| {
                        let d = x[a] - other.0[a];
                        (d - self.length * libm::round(d / self.length)).powi(2)
                    })
                    .sum();
                square > (radius + other.radius()).powi(2)
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grains(count: usize, spread: f64) -> Grains {
        Grains { count, spread, ..Grains::default() }
    }

    #[test]
    fn no_two_grains_overlap_and_the_solid_fraction_is_met() {
        let (cell, spheres) = random_insertion(&grains(500, 0.2), 0.33, 7).unwrap();
        let length = cell.edges[0][0];
        for (k, a) in spheres.iter().enumerate() {
            for b in &spheres[..k] {
                let square: f64 = (0..3)
                    .map(|c| {
                        let d = a.position[c] - b.position[c];
                        (d - length * (d / length).round()).powi(2)
                    })
                    .sum();
                assert!(square.sqrt() > a.radius + b.radius);
            }
        }
        let solid: f64 = spheres.iter().map(|s| 4.0 / 3.0 * std::f64::consts::PI * s.radius.powi(3)).sum();
        assert!((solid / cell.volume() - 0.33).abs() < 1e-12);
    }

    #[test]
    fn a_seed_decides_the_initial_state() {
        let g = grains(50, 0.0);
        assert_eq!(random_insertion(&g, 0.2, 3).unwrap().1, random_insertion(&g, 0.2, 3).unwrap().1);
        assert_ne!(random_insertion(&g, 0.2, 3).unwrap().1, random_insertion(&g, 0.2, 4).unwrap().1);
    }

    /// Counts the calls and stops at one of them.
    struct Counting {
        calls: usize,
        stop_at: usize,
    }

    impl SimulationObserver for Counting {
        fn work(&mut self, work: &Work) -> Flow {
            assert!(matches!(work, Work::Placing { count: 2000, .. }));
            self.calls += 1;
            if self.calls == self.stop_at { Flow::Stop } else { Flow::Continue }
        }
    }

    #[test]
    fn an_observer_can_stop_it_and_changes_nothing() {
        let g = grains(2000, 0.2);
        let mut counting = Counting { calls: 0, stop_at: usize::MAX };
        let followed = followed_insertion(&g, 0.36, 3, &mut counting).unwrap();
        assert_eq!(followed.1, random_insertion(&g, 0.36, 3).unwrap().1);
        assert!(counting.calls > 3, "{}", counting.calls);
        let mut stopping = Counting { calls: 0, stop_at: 2 };
        let stopped = followed_insertion(&g, 0.36, 3, &mut stopping).unwrap_err();
        assert!(matches!(stopped, InsertionError::Stopped { count: 2000, .. }) && stopping.calls == 2);
    }

    /// Equal grains at a solid fraction of 0.36 block each other with 9 of 300 seeds; then all are placed anew.
    #[test]
    fn few_grains_that_block_each_other_are_placed_anew() {
        let few = grains(80, 0.0);
        let is_blocked = |seed: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut radii: Vec<f64> = few.diameters(&mut rng).unwrap().iter().map(|d| 0.5 * d).collect();
            radii.sort_unstable_by(|a, b| b.total_cmp(a));
            let solid: f64 = radii.iter().map(|r| 4.0 / 3.0 * std::f64::consts::PI * r.powi(3)).sum();
            let mut listen = Listen { observer: &mut NoObserver, calls: 0, count: 80 };
            placed(&radii, libm::cbrt(solid / 0.36), &mut rng, &mut listen).unwrap().is_err()
        };
        for seed in [30, 59, 60] {
            assert!(is_blocked(seed), "{seed}");
            assert_eq!(random_insertion(&few, 0.36, seed).unwrap().1.len(), 80);
        }
    }

    #[test]
    fn too_dense_an_initial_state_is_refused() {
        assert!(random_insertion(&grains(300, 0.0), 0.6, 1).is_err());
    }

    #[test]
    fn closed_rooms_have_no_free_point() {
        for spread in [0.0, 0.3] {
            let (cell, spheres) = random_insertion(&grains(400, spread), 0.36, 5).unwrap();
            let length = cell.edges[0][0];
            let largest = spheres.iter().fold(0.0f64, |m, s| m.max(s.radius));
            let smallest = spheres.iter().fold(f64::INFINITY, |m, s| m.min(s.radius));
            let mut boxes = Boxes::new(length, 2.0 * largest);
            for s in &spheres {
                boxes.insert(s.position, s.radius);
            }
            let mut listen = Listen { observer: &mut NoObserver, calls: 0, count: 400 };
            let rooms = Rooms::new(length, smallest, &spheres, &mut listen).unwrap();
            let mut rng = ChaCha8Rng::seed_from_u64(1);
            let (mut closed, mut free) = (0, 0);
            for _ in 0..200_000 {
                let x = [(); 3].map(|()| length * unit(&mut rng));
                let room = x.map(|v| ((v / rooms.side) as usize).min(rooms.count - 1));
                if rooms.closed[(room[0] * rooms.count + room[1]) * rooms.count + room[2]] {
                    closed += 1;
                    assert!(!boxes.free(&x, smallest));
                } else {
                    free += i32::from(boxes.free(&x, smallest));
                }
            }
            // Most of the cell is closed, and the open part is worth trying.
            assert!(closed > 120_000, "{closed}");
            println!("spread {spread}: {closed} of 200000 points in closed rooms, {free} free in open ones");
        }
    }
}
