//! How well another material foresees the stresses at the points of a finite-element computation: along the strains that its cells of grains went through.
//!
//! ```sh
//! cargo run --release -p granum-c --example judge_points -- step-materials.toml states.granum 2
//! ```
//!
//! Material 1 of the configuration is the one with which the file of states was made. What the host accepted at each point is carried out again with it, with another of its
//! samples, and with the material of the given number, such as a surrogate. The errors are those of the deviator of the stress over the mean stress, and of the logarithm of
//! the mean stress where both are above 1 kPa, over their root mean square and their deviation along the paths. All of them get the strains of the first one, so that another
//! sample tells how much the grains themselves leave open.

use std::error::Error;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;

use granum_c::host::Session;
use granum_point::{MaterialPoint, Recipe, State, Store};

/// Mean stress, Pa, below which it is not compared.
const LEAST: f64 = 1e3;

/// The stresses after each increment of a path, until the point refuses one.
fn stresses(point: &MaterialPoint, path: &[Recipe]) -> Vec<[[f64; 3]; 3]> {
    let (mut state, mut found): (State, Vec<_>) = (point.start(), Vec::new());
    for recipe in path {
        let Ok(answer) = point.follow(&state, recipe) else { break };
        state = answer.state;
        if let Recipe::Advance(_) = recipe {
            found.push(state.stress());
        }
    }
    found
}

/// The mean part of a stress, and its deviator over it.
fn parts(stress: &[[f64; 3]; 3]) -> (f64, [[f64; 3]; 3]) {
    let mean = (stress[0][0] + stress[1][1] + stress[2][2]) / 3.0;
    let part = |i: usize, j: usize| (stress[i][j] - if i == j { mean } else { 0.0 }) / mean;
    (mean, std::array::from_fn(|i| std::array::from_fn(|j| part(i, j))))
}

/// Sums over states of squares: of errors and values of the ratio, of errors and values of the logarithm, and its sum.
#[derive(Default)]
struct Sums {
    states: f64,
    missing: f64,
    ratio: [f64; 2],
    logarithm: [f64; 2],
    mean: f64,
    bias: f64,
}

impl Sums {
    fn add(&mut self, exact: &[[[f64; 3]; 3]], other: &[[[f64; 3]; 3]]) {
        for (k, stress) in exact.iter().enumerate() {
            let (mean, ratio) = parts(stress);
            if mean < LEAST {
                continue;
            }
            let Some((own_mean, own)) = other.get(k).map(parts).filter(|(mean, _)| *mean > LEAST) else {
                self.missing += 1.0;
                continue;
            };
            let square = |a: f64, b: f64| (a - b) * (a - b);
            for (exact, own) in ratio.iter().flatten().zip(own.iter().flatten()) {
                self.ratio[0] += square(*exact, *own);
                self.ratio[1] += exact * exact;
            }
            let logarithm = mean.ln();
            self.logarithm[0] += square(logarithm, own_mean.ln());
            self.logarithm[1] += logarithm * logarithm;
            self.mean += logarithm;
            self.bias += own_mean.ln() - logarithm;
            self.states += 1.0;
        }
    }

    fn say(&self, what: &str) {
        let n = self.states;
        let ratio = (self.ratio[0] / self.ratio[1]).sqrt();
        let deviation = (self.logarithm[1] / n - (self.mean / n) * (self.mean / n)).sqrt();
        let logarithm = (self.logarithm[0] / n).sqrt();
        println!(
            "{what}: deviator of the stress over the mean stress {:.1} %; logarithm of the mean stress {:.1} % of its deviation {deviation:.3}, mean error {:+.3}; {n} states, {} without an answer",
            100.0 * ratio,
            100.0 * logarithm / deviation,
            self.bias / n,
            self.missing
        );
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [configuration, states, material] = &arguments[..] else {
        return Err("usage: judge_points CONFIGURATION STATES MATERIAL".into());
    };
    let (session, material) = (Session::open(Path::new(configuration))?, material.parse()?);
    let store = Store::load(Path::new(states))?;
    let (names, next) = (store.names(), AtomicUsize::new(0));
    let work = || {
        let mut found = Vec::new();
        while let Some(&name) = names.get(next.fetch_add(1, Ordering::Relaxed)) {
            let path = store.accepted(name).map_err(|error| error.to_string())?.1;
            let point =
                |material: usize, name: u64| session.point(material, name).map_err(|error| error.to_string());
            // The next name has the next of the samples.
            let points = [point(1, name)?, point(1, name + 1)?, point(material, name)?];
            found.push((name, points.map(|point| stresses(&point, &path))));
        }
        Ok::<_, String>(found)
    };
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let parts: Result<Vec<_>, String> = thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().map(|worker| worker.join().map_err(|_| "a thread ended".to_string())?).collect()
    });
    let mut found: Vec<_> = parts?.into_iter().flatten().collect();
    found.sort_by_key(|(name, _)| *name);
    let (mut another, mut other) = (Sums::default(), Sums::default());
    for (_, [exact, sample, judged]) in &found {
        another.add(exact, sample);
        other.add(exact, judged);
    }
    another.say("another sample of the same grains");
    other.say(&format!("material {material}"));
    Ok(())
}
