use super::*;
use crate::lattice;
use granum_dem::config::Spacing;

fn at(strain: f64) -> Assembly {
    let mut assembly = lattice::simple_cubic(3, 1e-4, 1e-4, 2e-4 * (1.0 + strain));
    assembly.strain = [[strain, 0.0, 0.0], [0.0; 3], [0.0; 3]];
    assembly.target_mean_stress = Some(2e4);
    assembly
}

fn recorder(recording: &Recording, end: f64) -> Recorder {
    Recorder::new(&Sensors::standard(), recording, end).unwrap()
}

fn run(recorder: &mut Recorder, steps: usize, end: f64) -> usize {
    let mut observations = 0;
    for k in 0..=steps {
        let strain = end * (k as f64 / steps as f64);
        if strain >= recorder.next_observation() {
            recorder.observe(&at(strain));
            observations += 1;
        }
    }
    observations
}

#[test]
fn windows_are_centred_with_half_a_window_at_the_end() {
    let recording = Recording::default().with(|recording| {
        recording.states = 4;
        recording.observations_per_state = 6;
    });
    let mut recorder = recorder(&recording, 0.4);
    assert_eq!(run(&mut recorder, 2400, 0.4), 1 + 3 * 6 + 3);
    assert!(recorder.is_complete() && recorder.next_observation().is_infinite());
    assert!(
        recorder.is_like(&self::recorder(&recording, 0.4))
            && !recorder.is_like(&self::recorder(&recording, 0.3))
    );
    assert!(!recorder.is_like(&self::recorder(
        &recording.clone().with(|recording| recording.observations_per_state = 5),
        0.4
    )));
    let record = recorder.record();
    let strain = record.series.values("deviator_strain").unwrap();
    let step = 0.4 / 2400.0;
    for (k, value) in strain.iter().enumerate() {
        let centre = [0.0, 0.1, 0.2, 0.3, 0.375][k];
        assert!((value - centre).abs() <= step, "state {k}: {value}");
    }
    assert_eq!(record.series.values("observations").unwrap(), [1.0, 6.0, 6.0, 6.0, 3.0]);
    assert_eq!(record.forces()[1].total(), 6 * 81);
    assert_eq!(record.forces()[0].total(), 81);
}

#[test]
fn a_single_look_a_state_stands_on_the_state() {
    let recording = Recording::default().with(|recording| {
        recording.states = 3;
        recording.observations_per_state = 1;
    });
    let mut recorder = recorder(&recording, 0.3);
    assert_eq!(recorder.next_observation(), 0.0);
    assert_eq!(run(&mut recorder, 300, 0.3), 4);
    let record = recorder.record();
    let strain = record.series.values("deviator_strain").unwrap();
    assert!(strain.iter().enumerate().all(|(k, s)| (s - 0.1 * k as f64).abs() < 1.1e-3), "{strain:?}");
}

#[test]
fn averages_follow_what_the_column_asks_for() {
    let recording = Recording::default().with(|recording| {
        recording.states = 1;
        recording.observations_per_state = 2;
    });
    let mut recorder = recorder(&recording, 0.2);
    recorder.observe(&at(0.0));
    recorder.observe(&at(0.16));
    let p = Observation::new(&at(0.16)).stress.mean();
    let record = recorder.record();
    let value = |name: &str| record.series.values(name).unwrap()[1];
    assert!((value("mean_stress") / p - 1.0).abs() < 1e-12);
    assert!((value("servo_error_rms") - (p / 2e4 - 1.0).abs()).abs() < 1e-12);
    assert!((value("servo_error_largest") - (p / 2e4 - 1.0).abs()).abs() < 1e-12);
    assert!((value("largest_overlap") - 1e-4).abs() < 1e-12);
}

#[test]
fn strides_longer_than_a_window_leave_states_out_and_early_looks_do_nothing() {
    let recording = Recording::default().with(|recording| {
        recording.states = 10;
        recording.observations_per_state = 4;
    });
    let mut recorder = recorder(&recording, 1.0);
    for strain in [0.0, 0.01, 0.02, 0.5, 0.5, 1.0] {
        recorder.observe(&at(strain));
    }
    assert_eq!(recorder.record().series.values("state").unwrap(), [0.0, 5.0, 10.0]);
    assert!(recorder.is_complete());
}

/// Strains at which observations are due, one by one.
fn due(mut recorder: Recorder) -> Vec<f64> {
    let mut due = Vec::new();
    while !recorder.is_complete() {
        due.push(recorder.next_observation());
        recorder.saved.schedule.advance();
    }
    due
}

#[test]
fn states_stand_where_a_geometric_spacing_or_a_list_says() {
    let near = |found: &[f64], wanted: &[f64]| {
        assert_eq!(found.len(), wanted.len(), "{found:?}");
        for (a, b) in found.iter().zip(wanted) {
            assert!((a - b).abs() <= 1e-12 * b.abs(), "{found:?}");
        }
    };
    let one = Recording::default().with(|recording| {
        recording.states = 4;
        recording.observations_per_state = 1;
    });
    let geometric = one.clone().with(|recording| recording.spacing = Spacing::Geometric(1e-4));
    near(&due(recorder(&geometric, 0.1)), &[0.0, 1e-4, 1e-3, 1e-2, 0.1]);
    let list = one.with(|recording| recording.spacing = Spacing::Strains(vec![0.01, 0.02, 0.05]));
    near(&due(recorder(&list, 0.1)), &[0.0, 0.01, 0.02, 0.05]);
    // The width of a window is the distance of the nearer neighbour, so that windows never overlap.
    let two = list.clone().with(|recording| recording.observations_per_state = 2);
    near(&due(recorder(&two, 0.1)), &[0.0, 0.0075, 0.0125, 0.0175, 0.0225, 0.0425, 0.0575]);
    // At the end of the test half a window is left, with half of the observations.
    near(&due(recorder(&two, 0.05)), &[0.0, 0.0075, 0.0125, 0.0175, 0.0225, 0.0425]);
    let mut recorder = recorder(&list, 0.1);
    run(&mut recorder, 1000, 0.1);
    assert!(
        recorder.is_complete()
            && recorder.is_like(&self::recorder(&list, 0.1))
            && !recorder.is_like(&self::recorder(&geometric, 0.1))
    );
    assert_eq!(recorder.record().series.values("state").unwrap(), [0.0, 1.0, 2.0, 3.0]);
    assert_eq!(
        recorder.missed_observations(),
        MissedObservations { wanted: 4, ..MissedObservations::default() }
    );
}

#[test]
fn looks_that_could_not_be_taken_are_counted() {
    let recording = Recording::default().with(|recording| {
        recording.states = 10;
        recording.observations_per_state = 4;
    });
    let mut recorder = recorder(&recording, 1.0);
    assert_eq!(recorder.missed_observations(), MissedObservations::default());
    for strain in [0.0, 0.5, 1.0] {
        recorder.observe(&at(strain));
    }
    // State 0 has one observation, the last state two, the others four; one was made at each of states 0, 5 and 10.
    let found = recorder.missed_observations();
    assert_eq!((found.wanted, found.missing), (1 + 9 * 4 + 2, 9 * 4 - 1 + 1));
    assert_eq!((found.states, found.empty_states), (10, 8));
}

#[test]
fn a_strain_short_by_rounding_is_due() {
    let mut recorder = recorder(
        &Recording::default().with(|recording| {
            recording.states = 3;
            recording.observations_per_state = 2;
        }),
        0.3,
    );
    recorder.observe(&at(0.0));
    let before = recorder.next_observation();
    assert!(before > 0.0);
    recorder.observe(&at(before * (1.0 - 1e-15)));
    assert!(recorder.next_observation() > before);
}

#[test]
fn nothing_looked_at_is_an_empty_record() {
    let recorder = recorder(
        &Recording::default().with(|recording| {
            recording.states = 0;
            recording.observations_per_state = 0;
        }),
        0.3,
    );
    assert_eq!(recorder.record().series.rows(), 0);
    assert!(recorder.record().forces().is_empty());
}

/// The limit of neighbours holds while a run records as well: what would never end is not a number.
#[test]
fn a_sensor_that_would_take_too_long_records_no_number() {
    let recording = Recording::default().with(|recording| {
        recording.sensors = ["radial_distribution", "void_ratio"].map(String::from).to_vec();
    });
    let mut recorder = recorder(&recording, 0.3);
    let mut assembly = at(0.0);
    assembly.bodies[0].equivalent_radius = 1e3;
    recorder.observe(&assembly);
    let series = recorder.record().series;
    let first = |column: &str| series.column(column).unwrap()[0];
    assert!(first("grains").is_nan() && first("cell_volume_in_diameters").is_nan());
    assert!(first("void_ratio").is_finite(), "the columns of other sensors are as before");
}

/// A recorder that is saved and restored during a test continues with the same bits, also where a sensor compares
/// observations.
#[test]
fn a_resumed_recorder_goes_on_with_the_same_bits() {
    let names = ["nonaffine_displacement", "second_order_work", "overlap_distribution"];
    let sensors = names.map(String::from).to_vec();
    let recording = Recording::default().with(|recording| {
        recording.states = 5;
        recording.observations_per_state = 4;
        recording.sensors = sensors;
    });
    let mut whole = recorder(&recording, 0.3);
    let mut first = recorder(&recording, 0.3);
    let moving = |strain: f64| {
        let mut assembly = at(strain);
        assembly.arc_length = strain;
        for (k, grain) in assembly.bodies.iter_mut().enumerate() {
            grain.position[k % 3] += 1e-5 * (strain * (k + 1) as f64).sin();
        }
        assembly
    };
    let strains: Vec<f64> = (0..=600).map(|k| 0.3 * k as f64 / 600.0).collect();
    for &strain in &strains {
        whole.observe(&moving(strain));
    }
    for &strain in &strains[..250] {
        first.observe(&moving(strain));
    }
    let text = serde_json::to_string(&first).unwrap();
    let saved: SavedRecorder = serde_json::from_str(&text).unwrap();
    let mut second = saved.with_sensors(&Sensors::standard()).unwrap();
    assert!(second == first && second.is_like(&recorder(&recording, 0.3)));
    for &strain in &strains[250..] {
        second.observe(&moving(strain));
    }
    assert_eq!(whole, second);
    assert_eq!(whole.record(), second.record());
    let displacements = whole.record().series.column("nonaffine_displacement").unwrap().to_vec();
    assert!(displacements[0] == 0.0 && displacements[1..].iter().all(|x| *x > 0.0), "{displacements:?}");
    assert!(!text.contains("\"memories\":[]"));
    whole.end();
    assert!(
        serde_json::to_string(&whole).unwrap().len() + 1000 < serde_json::to_string(&second).unwrap().len()
    );
}

#[test]
fn sensors_that_are_not_asked_for_change_nothing() {
    let recording = Recording::default().with(|recording| {
        recording.states = 3;
        recording.observations_per_state = 2;
    });
    let sensors = vec!["invariants".to_string(), "second_order_work".to_string()];
    let (mut plain, mut more) =
        (recorder(&recording, 0.3), recorder(&recording.with(|recording| recording.sensors = sensors), 0.3));
    assert!(!plain.is_like(&more) && !more.is_like(&plain));
    for k in 0..=60 {
        plain.observe(&at(0.005 * k as f64));
        more.observe(&at(0.005 * k as f64));
    }
    let (plain, more) = (plain.record(), more.record());
    let names: Vec<&str> = more.series.names().collect();
    assert_eq!(names.len(), plain.series.names().count() + 11);
    assert_eq!(names[names.len() - 3..], ["second_order_work", "forces_below", "forces_above"]);
    for column in plain.series.columns() {
        assert_eq!(more.series.values(&column.name), Some(&column.values[..]));
    }
    assert_eq!(plain.forces(), more.forces());
}

#[test]
fn a_saved_recorder_of_a_sensor_that_is_not_known_is_refused() {
    let text = serde_json::to_string(&recorder(&Recording::default(), 0.3)).unwrap();
    let saved: SavedRecorder = serde_json::from_str(&text.replace("\"rose\"", "\"roses\"")).unwrap();
    let error = saved.with_sensors(&Sensors::standard()).unwrap_err().to_string();
    assert_eq!(error, "there is no sensor \"roses\"; did you mean rose?");
}

/// A checkpoint in which the parameters of sensors had places of their own is read as one of today.
#[test]
fn the_recorder_of_an_earlier_version_is_read() {
    let recording = Recording::default().with(|recording| {
        recording.parameters =
            [("bin_width".to_string(), 0.1), ("critical_void_ratio".to_string(), 0.8)].into();
    });
    let now = recorder(&recording, 0.3);
    let text = serde_json::to_string(&now).unwrap();
    let parameters = "\"parameters\":{\"bin_width\":0.1,\"critical_void_ratio\":0.8}";
    assert!(text.contains(parameters), "{text}");
    let before = "\"bin_width\":0.1,\"largest_force\":6.0,\
                  \"critical_state\":{\"void_ratio\":0.8,\"slope\":null,\"exponent\":null}";
    let saved: SavedRecorder = serde_json::from_str(&text.replace(parameters, before)).unwrap();
    assert_eq!(saved.with_sensors(&Sensors::standard()).unwrap(), now);
}
