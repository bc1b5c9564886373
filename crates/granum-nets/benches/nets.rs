//! Speed of training and prediction on synthetic rows of the size of Antony, Zhou and Wang (2006).
//!
//! `cargo bench -p granum-nets --bench nets [-- traingdx|levenberg-marquardt|eighteen|prediction]`. Each figure is the best of several repeats, on one core where not said
//! otherwise.

use std::hint::black_box;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use granum_nets::trainer::{LevenbergMarquardt, Silent, Trainer, Traingdx};
use granum_nets::{Column, Data, Model, Network, Recipe};
use granum_simd::Isa;

type Outcome<T> = Result<T, Box<dyn std::error::Error>>;

/// Inputs and hidden neurons of the eighteen networks of Tables 1 to 6.
const PAPER: [(usize, [usize; 3]); 6] = [
    (3, [60, 55, 50]),
    (3, [25, 40, 65]),
    (4, [50, 50, 50]),
    (3, [25, 40, 55]),
    (4, [25, 40, 55]),
    (3, [50, 60, 65]),
];

/// Deterministic noise of standard deviation one.
fn noise(k: usize) -> f64 {
    let mut h = k as u64 ^ 0x9e37_79b9_7f4a_7c15;
    let mut sum = -6.0;
    for _ in 0..12 {
        h = h.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        sum += (h >> 11) as f64 / 9_007_199_254_740_992.0;
    }
    sum
}

/// Rows like (strain, f, P(f)) with a target between 0.1 and 0.9 and 1 % noise.
fn rows(count: usize, columns: usize) -> Outcome<Data> {
    let mut inputs = Vec::new();
    let mut targets = Vec::new();
    for r in 0..count {
        let strain = (r / 7) as f64 / (count / 7) as f64;
        let f = (r % 7) as f64 / 6.0;
        let all = [2.0 * strain - 1.0, 2.0 * f - 1.0, (1.0 - f) * (3.0 * strain).cos(), (5.0 * strain).sin()];
        inputs.extend_from_slice(&all[..columns]);
        targets.push(0.5 + 0.35 * (4.0 * strain).sin() * (1.0 - f) + 0.008 * noise(r));
    }
    Ok(Data::new(inputs, columns, targets)?)
}

/// Best time of one call in seconds, over about `seconds`.
fn best(seconds: f64, mut call: impl FnMut() -> Outcome<()>) -> Outcome<f64> {
    let clock = Instant::now();
    let mut least = f64::INFINITY;
    while clock.elapsed().as_secs_f64() < seconds {
        let start = Instant::now();
        call()?;
        least = least.min(start.elapsed().as_secs_f64());
    }
    Ok(least)
}

fn descent() -> Outcome<()> {
    for hidden in [60, 25] {
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
            let epochs = if isa == Isa::Portable { 20 } else { 2000 };
            let data = rows(280, 3)?;
            let rule = Traingdx { epochs, isa, minimum_gradient: 0.0, ..Default::default() };
            let seconds = best(3.0, || {
                let mut network = Network::new(&[3, hidden, hidden, 1], 1)?;
                black_box(rule.train(&mut network, &data, &mut Silent)?);
                Ok(())
            })?;
            let rate = epochs as f64 / seconds;
            println!("traingdx 280 rows 3-{hidden}-{hidden}-1 {:9} {rate:9.0} epochs/s", isa.name());
        }
    }
    Ok(())
}

fn levenberg_marquardt() -> Outcome<()> {
    for hidden in [60, 25] {
        for isa in Isa::ALL.into_iter().filter(|isa| isa.available() && *isa != Isa::Portable) {
            let data = rows(280, 3)?;
            let rule = LevenbergMarquardt { isa, epochs: 50, tolerance: 0.0, ..Default::default() };
            let mut epochs = 1;
            let seconds = best(2.0, || {
                let mut network = Network::new(&[3, hidden, hidden, 1], 1)?;
                epochs = rule.train(&mut network, &data, &mut Silent)?.epochs;
                Ok(())
            })?;
            let each = 1e3 * seconds / epochs as f64;
            println!(
                "levenberg-marquardt 280 rows 3-{hidden}-{hidden}-1 {:9} {each:6.3} ms an epoch",
                isa.name()
            );
        }
    }
    Ok(())
}

fn eighteen(threads: usize) -> Outcome<()> {
    let jobs: Vec<(usize, usize)> = PAPER.iter().flat_map(|(c, h)| h.map(|h| (*c, h))).collect();
    let data = [rows(280, 3)?, rows(280, 4)?];
    let (next, epochs) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let work = || {
        while let Some(&(columns, hidden)) = jobs.get(next.fetch_add(1, Ordering::Relaxed)) {
            let Ok(mut network) = Network::new(&[columns, hidden, hidden, 1], 1) else { return };
            let trained = LevenbergMarquardt::default().train(&mut network, &data[columns - 3], &mut Silent);
            epochs.fetch_add(trained.map_or(0, |r| r.epochs as usize), Ordering::Relaxed);
        }
    };
    let clock = Instant::now();
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(work);
        }
        work();
    });
    let seconds = clock.elapsed().as_secs_f64();
    let epochs = epochs.into_inner();
    println!(
        "eighteen networks, default trainer, {threads} threads: {seconds:.2} s ({epochs} epochs in all)"
    );
    Ok(())
}

fn prediction() -> Outcome<()> {
    for hidden in [60, 25] {
        let recipe = Recipe {
            inputs: ["strain", "f", "probability"].map(|n| Column::new(n, "1")).to_vec(),
            output: Column::new("stress_ratio", "1"),
            hidden: vec![hidden, hidden],
            seed: 1,
        };
        let rule = LevenbergMarquardt { epochs: 20, ..Default::default() };
        let (model, _) = Model::fit(&recipe, &rows(280, 3)?, &rule, &mut Silent)?;
        let name = format!("3-{hidden}-{hidden}-1");
        let each = |seconds: f64| 1e6 * seconds / 1000.0;
        let mut value = || {
            for k in 0..1000 {
                black_box(model.value(black_box(&[1e-3 * k as f64, 0.3, 0.4]))?);
            }
            Ok(())
        };
        println!("one prediction {name}: {:.3} us", each(best(1.0, &mut value)?));
        let mut full = || {
            for k in 0..1000 {
                black_box(model.predict(black_box(&[1e-3 * k as f64, 0.3, 0.4]))?);
            }
            Ok(())
        };
        println!("one prediction {name} with standard deviation: {:.2} us", each(best(1.0, &mut full)?));
        let table: Vec<f64> = (0..3_000_000).map(|k| (k as f64 * 0.37).sin()).collect();
        let seconds = best(3.0, || {
            black_box(model.predict_batch(&table)?);
            Ok(())
        })?;
        println!("batch of a million rows {name}: {:.2} million rows/s", 1.0 / seconds);
    }
    Ok(())
}

/// The paper's largest class of network on the widest instruction set: what `benches/peers/traingdx_jax.py` compares.
fn descent_paper() -> Outcome<()> {
    let data = rows(280, 3)?;
    let rule = Traingdx { epochs: 2000, minimum_gradient: 0.0, ..Default::default() };
    let seconds = best(3.0, || {
        let mut network = Network::new(&[3, 60, 60, 1], 1)?;
        black_box(rule.train(&mut network, &data, &mut Silent)?);
        Ok(())
    })?;
    println!("traingdx-paper {:.0} epochs/s", 2000.0 / seconds);
    Ok(())
}

fn main() -> Outcome<()> {
    // Cargo passes `--bench`; a name picks one part.
    let name = std::env::args().skip(1).find(|a| !a.starts_with('-'));
    let wanted = |part: &str| name.as_deref().is_none_or(|n| n == part);
    if name.as_deref() == Some("traingdx-paper") {
        return descent_paper();
    }
    if wanted("traingdx") {
        descent()?;
    }
    if wanted("levenberg-marquardt") {
        levenberg_marquardt()?;
    }
    if wanted("eighteen") {
        eighteen(1)?;
        eighteen(2)?;
    }
    if wanted("prediction") {
        prediction()?;
    }
    Ok(())
}
