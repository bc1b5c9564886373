//! Time of a step and of a stiffness of surrogates, beside a live cell. The networks have their usual sizes and are hardly trained: how long they take does not
//! depend on their weights.

use std::hint::black_box;
use std::time::Instant;

use granum_core::observer::NoObserver;
use granum_core::{Column, Table};
use granum_learn::surrogate::{FitSpec, PathCell, PathNetworks, Recurrent, SurrogateMethod};
use granum_learn::{Dataset, RunStates};
use granum_nets::trainer::Adam;
use granum_point::{Controls, Increment, MaterialPoint, State, Tangent};

use crate::sand::point;

const STRAINS: [&str; 6] = [
    "axial_strain",
    "lateral_strain_2",
    "lateral_strain_3",
    "shear_strain_yz",
    "shear_strain_zx",
    "shear_strain_xy",
];
const STRESSES: [&str; 6] = ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"];
type AnyError = Box<dyn std::error::Error>;

/// Runs of an elastic body along waves of strain.
fn runs() -> Result<Dataset, AnyError> {
    let run = |seed: u32| {
        let wave = |k: u32| {
            let phase = f64::from(7 * seed + 3 * k);
            (0..30).map(move |i| 2e-3 * ((0.2 * f64::from(i) + phase).sin() - phase.sin()))
        };
        let strains = STRAINS.into_iter().zip(0..).map(|(name, k)| Column::new(name, "1", wave(k).collect()));
        let stress = |k: u32| wave(k).map(|strain| if k < 3 { 1e5 } else { 0.0 } + 1e7 * strain).collect();
        let stresses = STRESSES.into_iter().zip(0..).map(|(name, k)| Column::new(name, "Pa", stress(k)));
        RunStates::new(&format!("run-{seed}"), Table::new(strains.chain(stresses).collect())?)
    };
    Ok(Dataset::new((0..8).map(run).collect::<granum_learn::Result<_>>()?)?)
}

/// Microseconds of an increment of 1e-4, and of a probed stiffness; each question is a new one.
fn times(point: &MaterialPoint, count: u32) -> Result<[f64; 2], AnyError> {
    let mut state: State = point.start();
    let per = |start: Instant| 1e6 * start.elapsed().as_secs_f64() / f64::from(count);
    let mut states = Vec::new();
    let start = Instant::now();
    for k in 0..count {
        let strain = if k / 20 % 2 == 0 { 1e-4 } else { -1e-4 };
        state = point.advance(&state, &Increment::from_components([strain, 0.0, 0.0, 0.0, 0.0, 0.0]))?.state;
        states.push(state.clone());
    }
    let step = per(start);
    let start = Instant::now();
    for state in &states {
        black_box(point.tangent(state, Tangent::Probes { strain: 1e-5 })?);
    }
    Ok([step, per(start)])
}

/// The table.
pub fn table() -> Result<(), AnyError> {
    let (dataset, spec) = (runs()?, FitSpec::new(STRAINS, STRESSES));
    let quick = Adam { epochs: 1, ..Adam::default() };
    let path = |cell: PathCell, rotations: usize| -> Box<dyn SurrogateMethod> {
        let mut method = PathNetworks::new(cell);
        (method.rotations, method.trainer) = (rotations, quick.clone().into());
        Box::new(method)
    };
    let mut recurrent = Recurrent::default();
    recurrent.trainer = quick.clone().into();
    let methods: Vec<(&str, Box<dyn SurrogateMethod>)> = vec![
        ("`recurrent`, 4 networks of 16", Box::new(recurrent)),
        ("`path-tensor`", path(PathCell::TensorStateSpace, 0)),
        ("`path-gru` without rotations", path(PathCell::Gru, 0)),
        ("`path-gru`", path(PathCell::Gru, 1)),
        ("`path-lstm`", path(PathCell::Lstm, 1)),
    ];
    println!("\n| point | an increment of 1e-4, us | stiffness by probes, us |\n|---|---|---|");
    // One method alone, by a part of its name.
    let wanted = std::env::args().nth(2);
    for (name, method) in methods {
        if wanted.as_ref().is_some_and(|wanted| !name.contains(wanted.as_str())) {
            continue;
        }
        let surrogate = method.fit(&dataset, &spec, &mut NoObserver)?;
        let point =
            MaterialPoint::from_surrogate(surrogate.into(), &Default::default(), Controls::default())?;
        let [step, stiffness] = times(&point, 5000)?;
        println!("| {name} | {step:.1} | {stiffness:.0} |");
    }
    if wanted.is_none() {
        let [step, stiffness] = times(&point(300, 1, Controls::default())?, 10)?;
        println!("| live cell of 300 grains | {step:.0} | {stiffness:.0} |");
    }
    Ok(())
}
