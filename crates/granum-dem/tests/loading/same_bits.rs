//! Every path gives the same bits on any number of threads and after any restart.

use super::*;

/// Parameters with which a path is short.
fn short(name: &str) -> Given {
    let numbers: &[(&str, f64)] = match name {
        "constant-p" => &[("deviator_strain", 2e-3)],
        "isotropic" => &[("mean_stress", 30e3), ("unloading_stress", 25e3)],
        "drained-triaxial" => &[("axial_strain", 2e-3), ("lateral_stress", 22e3)],
        "undrained-triaxial" => &[("axial_strain", 2e-3), ("fluid_modulus", 1e8)],
        "constant-p-and-b" | "plane-strain" => &[("axial_strain", 2e-3)],
        "oedometer" => &[("axial_stress", 60e3), ("unloading_stress", 30e3)],
        "simple-shear" | "simple-shear-constant-volume" => &[("shear_strain", 2e-3)],
        "proportional" => &[("axial_strain", 1e-3)],
        "cyclic" => &[("stress_amplitude", 3e3), ("cycles", 1.0)],
        "unload-reload" => &[("axial_strain", 2e-3)],
        "unconfined-strength" => &[("pre_shear_strain", 1e-3), ("axial_strain", 1e-3)],
        "random" => &[("amplitude", 5e-4), ("length", 2e-3)],
        "hold" => &[("duration", 1e-4)],
        "probes" => &[("directions", 2.0), ("unbalanced_force", 2e-3)],
        _ => &[],
    };
    let mut given: Given = numbers.iter().map(|(key, value)| (key.to_string(), (*value).into())).collect();
    match name {
        "proportional" => drop(given.insert("ratios_of".into(), "stress".into())),
        "unload-reload" => drop(given.insert("at".into(), PathValue::List(vec![1e-3]))),
        "history" => {
            let columns = vec![HistoryQuantity::Strain(0), HistoryQuantity::Stress(2)];
            let rows = vec![vec![1e-3, 22e3], vec![5e-4, 21e3]];
            given.insert("file".into(), PathValue::History(History { columns, rows }));
        }
        _ => {}
    }
    given
}

/// Follows stages on so many threads; everything is written down and read back whenever so many steps were made.
fn broken(stages: &[Stage], threads: usize, every: u64) -> String {
    let mut s = sample();
    let hardware = Hardware { threads, ..Hardware::default() };
    s.set_hardware(hardware);
    let mut kept: Option<Simulation> = None;
    for stage in stages {
        match (stage.start, &kept) {
            (Start::Kept, _) => kept = Some(s.clone()),
            (Start::Back, Some(state)) => s = state.clone(),
            _ => {}
        }
        let mut stage_progress = begin(stage, &mut s).unwrap();
        loop {
            let stop_at = s.state().step().saturating_add(every);
            let mut notes = Notes { next: f64::INFINITY, stop_at, ..Notes::default() };
            match follow(stage, &mut stage_progress, &mut s, &mut notes).unwrap() {
                Ending::Complete(reason) => {
                    assert!(reason.is_asked_for(), "{}: {reason}", stage.name);
                    break;
                }
                Ending::Stopped => {
                    let text = serde_json::to_string(&stage_progress).unwrap();
                    let (restored, text) = Simulation::restore(&s.checkpoint(&text).unwrap()).unwrap();
                    s = restored;
                    s.set_hardware(hardware);
                    stage_progress = serde_json::from_str(&text).unwrap();
                }
            }
        }
    }
    format!("{:?}", s.state())
}

/// Threads and restarts change no bit of any path, and each ends by one of its end conditions.
#[test]
fn every_path_gives_the_same_bits_however_it_is_broken_off() {
    for path in preset::ALL {
        let stages = path.expand(&short(path.name));
        assert!(broken(&stages, 1, u64::MAX) == broken(&stages, 2, 700), "{}", path.name);
    }
}
