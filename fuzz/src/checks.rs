//! What must hold for any bytes in place of a file that granum reads: an error or a value that can be used, no panic,
//! no hang, no memory beyond a bound. One function a target; a panic is a find.
//!
//! The fuzz targets call these, and so does a test of the stable toolchain on every kept input.

use std::hint::black_box;

use granum_core::assembly::{Assembly, Bond, Sphere};
use granum_dem::config::{ContactModel, Material, Rate, Recording};
use granum_dem::simulation::{Properties, Simulation};
use granum_io::{Case, RunRecord, Table, safe_text};
use granum_learn::study::StudyPlan;
use granum_nets::trainer::{Flow, Progress, TrainerState, by_name};
use granum_nets::{Data, Model, Network};
use granum_run::laboratory;

/// A target and its check.
pub type Target = (&'static str, fn(&[u8]));

/// Every target.
pub const ALL: [Target; 9] = [
    ("case", case),
    ("packing", packing),
    ("model", model),
    ("checkpoint", checkpoint),
    ("csv", csv),
    ("parquet", parquet),
    ("mesh", mesh),
    ("voxels", voxels),
    ("bonds", bonds),
];

/// A case file; after the byte `R` the record of a run, after `P` the plan of a training.
pub fn case(data: &[u8]) {
    match data {
        [b'R', json @ ..] => return record(json),
        [b'P', json @ ..] => return plan(json),
        _ => {}
    }
    let Ok(text) = std::str::from_utf8(data) else { return };
    match Case::parse(text, "case.toml") {
        Ok(case) => {
            let resolved = case.resolved_toml();
            let back = Case::parse(&resolved, "resolved.toml").expect("a resolved case reads back");
            assert_eq!(back, case, "{resolved}");
            assert_eq!(back.digest(), case.digest());
            case.check().expect("a case that was read is within its bounds");
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn record(json: &[u8]) {
    let Ok(record) = serde_json::from_slice::<RunRecord>(json) else { return };
    black_box((record.grain_steps(), record.is_good()));
    if let Some(text) = &record.unwritten_case {
        let _ = Case::parse(text, "run.json");
    }
}

fn plan(json: &[u8]) {
    let Ok(plan) = serde_json::from_slice::<StudyPlan>(json) else { return };
    black_box((plan.surrogates(), plan.files_in(std::path::Path::new("nowhere")), plan.differences(&plan)));
}

/// A packing file: what is accepted makes a simulation that can be looked at.
pub fn packing(data: &[u8]) {
    let Ok(packing) = granum_io::formats::packing_csv::read_from(data, "packing.csv") else { return };
    black_box(packing.solid_fraction());
    let properties = Properties::new(Material::default(), ContactModel::default());
    let Ok(mut simulation) = laboratory::simulation(&packing, properties) else { return };
    assert_eq!(simulation.assembly().bodies.len(), packing.grains.len());
    let _ = simulation.advance(2);
    black_box(simulation.assembly());
}

/// A model file, whose checksum is put right first; after the byte `T` the state of a training.
pub fn model(data: &[u8]) {
    if let [b'T', json @ ..] = data {
        return training(json);
    }
    let Ok(text) = std::str::from_utf8(data) else { return };
    let Ok(model) = Model::from_json(&with_checksum(text), "model.json") else { return };
    let inputs = model.inputs().len();
    for value in [0.0, 0.3, -1e9, 1e300] {
        let row = vec![value; inputs];
        black_box(model.predict(&row).expect("finite inputs of the right number"));
        let batch = model.predict_batch(&row).expect("finite inputs of the right number");
        let single = model.value(&row).expect("finite inputs of the right number");
        assert_eq!(batch.values[0].to_bits(), single.to_bits());
    }
    let saved = model.to_json();
    let back = Model::from_json(&saved, "saved.json").expect("a saved model reads back");
    assert_eq!(back.to_json(), saved);
}

/// The text with the checksum of a model file, as its last entry, made for it.
fn with_checksum(text: &str) -> String {
    const MARK: &str = ",\n  \"checksum\": \"";
    let body = text.rfind(MARK).map_or(text, |at| &text[..at]);
    format!("{body}{MARK}{}\"\n}}\n", granum_core::digest::sha256(body.as_bytes()))
}

/// A training goes on from a state for a few epochs, or refuses it.
fn training(json: &[u8]) {
    let Ok(state) = serde_json::from_slice::<TrainerState>(json) else { return };
    let rows = 12;
    let inputs: Vec<f64> = (0..2 * rows).map(|k| (k as f64 * 0.7).sin()).collect();
    let targets = (0..rows).map(|k| 0.5 + 0.3 * (k as f64 * 0.4).cos()).collect();
    let data = Data::new(inputs, 2, targets).expect("a table");
    let first = state.epoch();
    for name in granum_nets::trainer::NAMES {
        let trainer = by_name(name, &Default::default()).expect("a known trainer");
        let mut network = Network::new(&[2, 2, 2, 1], 1).expect("a small network");
        let mut few = |p: &Progress| {
            if p.done > first.saturating_add(3) { Flow::Stop } else { Flow::Continue }
        };
        let _ = black_box(trainer.resume(&mut network, &data, Some(state.clone()), &mut few));
    }
}

/// The body of a checkpoint, without its header: that is put on here.
pub fn checkpoint(body: &[u8]) {
    let Ok((mut simulation, attachment)) = Simulation::restore(&with_header(body)) else { return };
    let grains = simulation.state().grains();
    assert_eq!(simulation.assembly().bodies.len(), grains);
    let _ = simulation.advance(3);
    black_box(simulation.assembly());
    let _ = laboratory::check_beside(&attachment, &tested());
    // What goes on can be written down again.
    let bytes = simulation.checkpoint(&attachment).expect("to memory");
    black_box(bytes.len());
}

/// The case of the test whose checkpoint is a seed.
pub fn tested() -> Case {
    let mut case = Case::default();
    case.grains.count = 50;
    case.preparation.friction = Some(0.1);
    case.preparation.solid_fraction = None;
    case.preparation.inertial_number = 5e-2;
    case.preparation.unbalanced_force = 1e-1;
    case = case.with_shear(|shear| {
        shear.deviator_strain = 0.01;
        shear.rate = Rate::InertialNumber(1e-2);
    });
    case.recording = Recording::default().with(|recording| {
        recording.states = 3;
        recording.observations_per_state = 2;
        recording.parameters = [("bin_width".to_string(), 2.0), ("largest_force".to_string(), 4.0)].into();
    });
    case
}

/// A checkpoint of spheres with this body.
pub fn with_header(body: &[u8]) -> Vec<u8> {
    header(granum_dem::checkpoint::OF_SPHERES, body)
}

/// A checkpoint of a version with this body.
pub fn header(version: u32, body: &[u8]) -> Vec<u8> {
    let mut bytes = b"GRANUMCP".to_vec();
    bytes.extend(version.to_le_bytes());
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(crc32fast::hash(body).to_le_bytes());
    bytes.extend(body);
    bytes
}

/// Bonds: after the byte `K` the body of a checkpoint of bonded grains, after `J` the bonds of a snapshot of two grains, after `D` a data file
/// of LAMMPS.
pub fn bonds(data: &[u8]) {
    match data {
        [b'K', body @ ..] => bonded_checkpoint(body),
        [b'J', json @ ..] => bonds_of_snapshot(json),
        [b'D', text @ ..] => data_file(text),
        _ => {}
    }
}

/// Bonded grains go on for a few steps, are observed, and can be written down again.
fn bonded_checkpoint(body: &[u8]) {
    let bytes = header(granum_dem::checkpoint::VERSION, body);
    let Ok((mut simulation, attachment)) = Simulation::restore(&bytes) else { return };
    black_box(simulation.assembly());
    let _ = simulation.advance(3);
    black_box(simulation.assembly());
    black_box(simulation.checkpoint(&attachment).expect("to memory").len());
}

/// Whatever is read as bonds can be measured.
fn bonds_of_snapshot(json: &[u8]) {
    match snapshot_of_a_pair(json) {
        Ok(assembly) => {
            black_box(granum_sensors::Sensors::standard().measure(&assembly, granum_core::Parts::all()));
        }
        Err(error) => assert!(error.to_string().contains("start.bonds"), "{error}"),
    }
}

/// What is read of a snapshot of two grains with these bonds. The rest of the snapshot is written once.
pub fn snapshot_of_a_pair(json: &[u8]) -> granum_io::Result<Assembly> {
    thread_local! {
        static FOLDER: tempfile::TempDir = {
            let folder = tempfile::tempdir().expect("a folder");
            granum_io::snapshot::write_snapshot(folder.path(), "start", &pair()).expect("a snapshot");
            folder
        };
    }
    FOLDER.with(|folder| {
        std::fs::write(folder.path().join("start.bonds"), json).expect("a file");
        granum_io::snapshot::read_snapshot(folder.path(), "start")
    })
}

/// Two grains that a bond joins.
pub fn pair() -> Assembly {
    let sphere = |id, x| Sphere { id, position: [x, 0.5, 0.5], radius: 0.1, mass: 1.0, ..Sphere::default() };
    let cell = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut pair = Assembly { cell, ..Assembly::default() }.with_spheres([sphere(1, 0.3), sphere(2, 0.5)]);
    let (branch, normal) = ([0.2, 0.0, 0.0], [1.0, 0.0, 0.0]);
    pair.bonds = vec![Bond { id: 3, i: 0, j: 1, branch, normal, radius: 0.05, ..Bond::default() }];
    pair
}

/// What is read of a data file of LAMMPS has an image that can be looked at.
fn data_file(text: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grains.data");
    std::fs::write(&path, text).expect("a file");
    match granum_io::formats::read_packing(&path) {
        Ok(packing) => drop(black_box(packing.solid_fraction())),
        Err(error) => assert!(error.to_string().contains("grains.data"), "{error}"),
    }
}

/// A table as CSV.
pub fn csv(data: &[u8]) {
    let Ok(table) = granum_io::formats::csv::read_from(data, "table.csv", None) else { return };
    use_table(&table);
    let mut text = Vec::new();
    if let Err(error) = granum_io::formats::csv::write_rows(&mut text, &table) {
        return assert!(error.to_string().contains("cannot hold a column named"), "{error}");
    }
    let back =
        granum_io::formats::csv::read_from(&text[..], "again.csv", None).expect("a written table reads back");
    // Signs that a terminal or a spreadsheet obeys are written so that they are shown.
    let as_shown: Vec<String> =
        table.names().map(|name| safe_text::of_csv(&safe_text::csv(name)).to_owned()).collect();
    assert_eq!(as_shown, back.names().collect::<Vec<_>>());
    assert_same_values(&table, &back);
}

/// A table as Parquet.
pub fn parquet(data: &[u8]) {
    let Ok(table) = granum_io::formats::parquet::read_bytes(data.to_vec(), "table.parquet", None) else {
        return;
    };
    use_table(&table);
}

/// A mesh, as STL after the byte `S`, as OBJ after `O` and as PLY after `P`: one that is accepted is a closed body with a volume.
pub fn mesh(data: &[u8]) {
    let (name, bytes) = match data {
        [b'S', bytes @ ..] => ("grain.stl", bytes),
        [b'O', bytes @ ..] => ("grain.obj", bytes),
        [b'P', bytes @ ..] => ("grain.ply", bytes),
        _ => return,
    };
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).expect("a file");
    let mut notices = Vec::new();
    match granum_shape::mesh::read(&path, &mut notices) {
        Ok(read) => {
            let moments = granum_shape::mesh::moments(&read);
            assert!(moments.volume > 0.0 && moments.volume.is_finite(), "{}", moments.volume);
            assert!(moments.centre.iter().all(|x| x.is_finite()), "{:?}", moments.centre);
        }
        Err(error) => assert!(error.to_string().contains(name), "{error}"),
    }
}

/// A stack of images as TIFF: one that is accepted has a label for each voxel.
pub fn voxels(data: &[u8]) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("grains.tif");
    std::fs::write(&path, data).expect("a file");
    match granum_shape::voxels::read(&path) {
        Ok(stack) => assert_eq!(stack.size.iter().product::<usize>(), stack.labels.len()),
        Err(error) => assert!(error.to_string().contains("grains.tif"), "{error}"),
    }
}

fn assert_same_values(table: &Table, back: &Table) {
    for (one, two) in table.columns().iter().zip(back.columns()) {
        assert_eq!(one.values.len(), two.values.len());
        for (a, b) in one.values.iter().zip(&two.values) {
            assert!(a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan()), "{a} {b}");
        }
    }
}

/// A table may claim to be the series of a run, its forces, or both.
fn use_table(table: &Table) {
    if let Ok(record) = granum_sensors::Record::from_tables(table.clone(), [("forces", table)]) {
        record.histogram_tables().for_each(|table| drop(black_box(table)));
    }
}
