//! Small valid inputs of every target, made in code: their formats change with the program.

use granum_io::RunKind;

use std::sync::Arc;

use granum_dem::bond::Bonding;
use granum_dem::config::{ContactModel, Grains, Material, NormalKind, TangentialKind};
use granum_dem::random_insertion::random_insertion;
use granum_dem::servo::CellControl;
use granum_dem::simulation::{Hardware, Properties, Simulation};
use granum_io::{Case, Column, Machine, Packing, QualityFlag, RunFolder, RunRecord, Table};
use granum_learn::networks::SubModel;
use granum_learn::study::{StudyDefinition, StudyPlan};
use granum_learn::{FitSpec, Split};
use granum_nets::trainer::{Options, by_name};
use granum_nets::{Data, Model, ModelDefinition};
use granum_run::NoObserver;
use granum_run::laboratory::{CHECKPOINT, Laboratory, Source};
use parquet::data_type::{BoolType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::properties::{WriterProperties, WriterVersion};
use parquet::file::writer::SerializedFileWriter;

use crate::checks;

/// A name and bytes.
type Seed = (String, Vec<u8>);

/// The seeds of a target.
pub fn for_target(target: &str) -> Vec<Seed> {
    match target {
        "case" => cases(),
        "packing" => packings(),
        "model" => models(),
        "checkpoint" => checkpoints(),
        "csv" => tables(),
        "parquet" => parquets(),
        "mesh" => meshes(),
        "voxels" => stacks(),
        "bonds" => bonds(),
        _ => Vec::new(),
    }
}

fn seed(name: impl Into<String>, bytes: impl Into<Vec<u8>>) -> Seed {
    (name.into(), bytes.into())
}

/// Corners of the triangles of a box.
const TRIANGLES: [[usize; 3]; 12] = [
    [0, 2, 3],
    [0, 3, 1],
    [4, 5, 7],
    [4, 7, 6],
    [0, 1, 5],
    [0, 5, 4],
    [2, 6, 7],
    [2, 7, 3],
    [0, 4, 6],
    [0, 6, 2],
    [1, 3, 7],
    [1, 7, 5],
];

fn corner(k: usize) -> [f32; 3] {
    [(k & 1) as f32 * 3.0, (k >> 1 & 1) as f32 * 2.0, (k >> 2 & 1) as f32]
}

/// A box in each format.
fn meshes() -> Vec<Seed> {
    let mut text = String::from("Ssolid box\n");
    let mut binary = vec![b'S'];
    binary.extend([0u8; 80]);
    binary.extend(12u32.to_le_bytes());
    for triangle in TRIANGLES {
        text += "facet normal 0 0 0\nouter loop\n";
        binary.extend([0u8; 12]);
        for [x, y, z] in triangle.map(corner) {
            text += &format!("vertex {x} {y} {z}\n");
            binary.extend([x, y, z].into_iter().flat_map(f32::to_le_bytes));
        }
        text += "endloop\nendfacet\n";
        binary.extend([0u8; 2]);
    }
    text += "endsolid box\n";
    let corners: String = (0..8).map(corner).map(|[x, y, z]| format!("{x} {y} {z}\n")).collect();
    let mut object = String::from("O");
    object.extend(corners.lines().map(|line| format!("v {line}\n")));
    object.extend(TRIANGLES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1)));
    let head = "Pply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n\
                element face 12\nproperty list uchar int vertex_indices\nend_header\n";
    let mut polygon = format!("{head}{corners}");
    polygon.extend(TRIANGLES.map(|[a, b, c]| format!("3 {a} {b} {c}\n")));
    vec![
        seed("text.stl", text),
        seed("binary.stl", binary),
        seed("box.obj", object),
        seed("box.ply", polygon),
    ]
}

/// Two images of four voxels, uncompressed.
fn stacks() -> Vec<Seed> {
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    for last in [false, true] {
        let data = bytes.len() + 2 + 12 * 8 + 4;
        let tags: [(u16, usize); 8] =
            [(256, 2), (257, 2), (258, 8), (259, 1), (262, 1), (273, data), (278, 2), (279, 4)];
        bytes.extend(8u16.to_le_bytes());
        for (tag, value) in tags {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(4u16.to_le_bytes());
            bytes.extend(1u32.to_le_bytes());
            bytes.extend((value as u32).to_le_bytes());
        }
        bytes.extend((if last { 0 } else { data + 4 } as u32).to_le_bytes());
        bytes.extend([0, 1, 1, 2]);
    }
    vec![seed("two.tif", bytes)]
}

fn cases() -> Vec<Seed> {
    let mut case = Case::default();
    let short = "[grains]\ncount = 1_000\ndiameter = \"0.2 mm\"\n[shear]\nstrain_rate = \"1e-5 /s\"\ndensity_scaling = 1e12\n";
    let mut record = RunRecord::new(RunKind::Test, "0.1.0", &case, Machine::here("avx2", 2));
    record.steps.insert("test".into(), 1000);
    record.wall_seconds.insert("test".into(), 0.3);
    record.measures.insert("solid_fraction".into(), f64::NAN);
    record.quality.push(QualityFlag::at_most("servo_error_rms", 0.004, 0.01, "lower the rate"));
    record.unwritten_case = Some("[grains]\ncount = 70\n".into());
    let mut json = b"R".to_vec();
    json.extend(serde_json::to_vec(&record).expect("a record"));
    case.preparation.friction = Some(0.1);
    case.preparation.solid_fraction = None;
    let fit = FitSpec::new(["deviator_strain", "deviator_fabric"], ["stress_ratio"]);
    let fit = fit.with_coordinate("deviator_strain");
    let fit = fit.with_sub_models(SubModel::divided([0.0, 0.3], &[0.1, 0.2], &[10, 10]));
    let definition = StudyDefinition::new([fit], ["sub-models"], Split::default());
    let plan = StudyPlan::new(&["run".into()], &[], "0123".into(), definition).expect("a plan");
    let mut planned = b"P".to_vec();
    planned.extend(serde_json::to_vec(&plan).expect("a plan"));
    vec![
        seed("template", Case::template()),
        seed("resolved", case.resolved_toml()),
        seed("short", short),
        seed("record", json),
        seed("plan", planned),
    ]
}

fn packings() -> Vec<Seed> {
    let tilted = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=4 yhi=4 zhi=4 xy=0.5 xz=0 yz=-0.25\n\
        id,x,y,z,radius\n1,1,1,1,0.5\n2,2.001,1,1,0.5\n3,1,2.6,1,0.25\n4,3.5,3.5,3.5,0.05\n";
    let small = "# periodic cell, m: ox=-1 oy=0 oz=0 ax=2 ay=0 az=0 bx=0 by=2 bz=0.1 cx=0 cy=0.2 cz=2\n\
        density,radius,id,x,y,z\n2650,0.9,1,0,1,1\n";
    let mut gases = [(10, 0.0), (20, 0.4)].map(|(count, spread)| {
        let simulation = running(count, spread, ContactModel::default(), 0);
        let folder = tempfile::tempdir().expect("a folder");
        let file = folder.path().join("packing.csv");
        granum_io::write_packing(&file, &Packing::from_assembly(&simulation.assembly())).expect("a packing");
        seed(format!("loose-{count}"), std::fs::read(&file).expect("a packing"))
    });
    let mut seeds = vec![seed("tilted", tilted), seed("small", small)];
    seeds.extend(gases.iter_mut().map(std::mem::take));
    seeds
}

fn models() -> Vec<Seed> {
    let rows = 14;
    let inputs: Vec<f64> = (0..2 * rows).map(|k| (k as f64 * 0.7).sin()).collect();
    let targets = (0..rows).map(|k| 20.0 + (k as f64 * 0.4).cos()).collect();
    let data = Data::new(inputs, 2, targets).expect("a table");
    let column = granum_nets::ModelColumn::new;
    let definition = ModelDefinition {
        inputs: vec![column("deviator_strain", "1"), column("force", "N")],
        output: column("stress", "Pa"),
        quantities: Vec::new(),
        shares: Vec::new(),
        hidden: vec![2, 2],
        seed: 3,
    };
    let mut seeds = Vec::new();
    for name in granum_nets::trainer::NAMES {
        let options = Options { epochs: Some(5), ..Options::default() };
        let trainer = by_name(name, &options).expect("a known trainer");
        let (model, report) =
            Model::fit(&definition, &data, trainer.as_ref(), &mut NoObserver).expect("a model");
        seeds.push(seed(name, model.to_json()));
        let mut state = b"T".to_vec();
        state.extend(serde_json::to_vec(&report.state).expect("a state"));
        seeds.push(seed(format!("state-{name}"), state));
    }
    seeds
}

/// A few grains that were pressed together for so many steps.
fn running(count: usize, spread: f64, contact: ContactModel, steps: u64) -> Simulation {
    let grains = Grains::default().with(|grains| {
        grains.count = count;
        grains.spread = spread;
    });
    let (cell, spheres) = random_insertion(&grains, 0.35, 11).expect("a loose initial state");
    let properties = Properties::new(Material::default(), contact);
    let mut simulation = Simulation::new(cell, &spheres, properties).expect("a simulation");
    simulation.set_control(CellControl::isotropic(20e3, 8000.0));
    simulation.advance(steps).expect("steps");
    simulation
}

fn checkpoints() -> Vec<Seed> {
    let laws = [
        ("hertz", NormalKind::HERTZ, TangentialKind::NO_SLIP, 6, 0.0),
        ("jkr", NormalKind::JKR, TangentialKind::MINDLIN_DERESIEWICZ, 8, 0.3),
        ("peeling", NormalKind::JKR, TangentialKind::PEELING, 20, 0.0),
    ];
    let [sample, test] = attachments();
    laws.into_iter()
        .zip(["", &sample, &test])
        .map(|((name, normal, tangential, count, spread), attachment)| {
            let contact = ContactModel::new(normal, tangential, 0.1);
            let bytes = running(count, spread, contact, 6000).checkpoint(attachment).expect("to memory");
            // Without the header, which the check puts on.
            seed(name, &bytes[24..])
        })
        .collect()
}

/// A checkpoint of bonded grains of which some bonds ruptured, the bonds of a snapshot, and a data file of LAMMPS with bonds.
fn bonds() -> Vec<Seed> {
    let contact = ContactModel::new(NormalKind::HERTZ, TangentialKind::NO_SLIP, 0.1);
    let grains = Grains::default().with(|grains| (grains.count, grains.spread) = (12, 0.2));
    let (cell, spheres) = random_insertion(&grains, 0.35, 11).expect("a loose initial state");
    let material = Material::default().with(|material| material.interface_energy = 0.0);
    let mut simulation =
        Simulation::new(cell, &spheres, Properties::new(material, contact)).expect("a simulation");
    simulation.set_control(CellControl::isotropic(20e3, 8000.0));
    simulation.advance(6000).expect("steps");
    let weak = Bonding::default().with(|bonding| {
        (bonding.largest_gap, bonding.damping) = (0.3, 0.1);
        bonding.parameters.insert("tensile_strength".into(), 1e5);
    });
    simulation.bond(&weak).expect("bonds");
    let mut rate = CellControl::fixed();
    rate.rate = [[2e3, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]];
    simulation.set_control(rate);
    simulation.advance(300).expect("steps");
    let assembly = simulation.assembly();
    assert!(!assembly.bonds.is_empty() && !assembly.broken_bonds.is_empty());
    let mut checkpoint = b"K".to_vec();
    checkpoint.extend(&simulation.checkpoint("").expect("to memory")[24..]);
    let folder = tempfile::tempdir().expect("a folder");
    let mut pair = checks::pair();
    pair.broken_bonds = assembly.broken_bonds[..1].to_vec();
    pair.broken_bonds[0].bodies = [1, 2];
    granum_io::snapshot::write_snapshot(folder.path(), "start", &pair).expect("a snapshot");
    let mut json = b"J".to_vec();
    json.extend(std::fs::read(folder.path().join("start.bonds")).expect("bonds"));
    let data = "Dthree grains\n\n3 atoms\n1 atom types\n2 bonds\n2 bond types\n\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\nAtoms # bpm/sphere\n\n\
                1 0 1 0.2 2650 0.3 0.5 0.5\n2 0 1 0.2 2650 0.5 0.5 0.5\n3 0 1 0.2 2650 0.7 0.5 0.5\n\nBonds\n\n1 1 1 2\n2 2 2 3\n";
    vec![seed("checkpoint", checkpoint), seed("snapshot", json), seed("data", data)]
}

/// What a laboratory writes beside a sample and beside a test.
fn attachments() -> [String; 2] {
    let case = checks::tested();
    let laboratory = Laboratory::new(Hardware::default(), "seed");
    let base = tempfile::tempdir().expect("a folder");
    let beside = |folder: &RunFolder| {
        let bytes = std::fs::read(folder.path().join(CHECKPOINT)).expect("a checkpoint");
        Simulation::restore(&bytes).expect("a checkpoint").1
    };
    let sample = RunFolder::create(base.path().join("sample"), false).expect("a folder");
    laboratory.run(RunKind::Sample, &case, &Source::Case, &sample, &mut NoObserver).expect("a sample");
    let test = RunFolder::create(base.path().join("test"), false).expect("a folder");
    let source = Source::Folder(sample.path().to_path_buf());
    laboratory.run(RunKind::Test, &case, &source, &test, &mut NoObserver).expect("a test");
    [beside(&sample), beside(&test)]
}

fn tables() -> Vec<Seed> {
    vec![
        seed("plain", "deviator_strain,stress_ratio\n0,0.1\n1e-3,-2.5E-2\n"),
        seed(
            "odd",
            "\u{feff}# a comment\r\n\"a\", b\r\n1,-0\r\n\r\n nan ,inf\r\n5e-324,-1.7976931348623157e308\n",
        ),
        seed(
            "forces",
            "state,forces_below,forces_above,force,bin_width,count,deviator_strain,probability_density\n\
             0,0,0,0.5,1,3,0,1\n1,0,1,0.5,1,4,0.1,1\n",
        ),
    ]
}

fn parquets() -> Vec<Seed> {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("own.parquet");
    let own = Table::new(vec![
        Column::new("deviator_strain", "", vec![0.0, 0.1, 0.2]),
        Column::new("mean_stress", "Pa", vec![2e4, 2.1e4, f64::NAN]),
    ]);
    granum_io::formats::parquet::write(&file, &own.expect("a table")).expect("a file");
    vec![
        seed("own", std::fs::read(&file).expect("a file")),
        seed("foreign-snappy-1", foreign(WriterVersion::PARQUET_1_0, true)),
        seed("foreign-snappy-2", foreign(WriterVersion::PARQUET_2_0, true)),
        seed("foreign-plain-2", foreign(WriterVersion::PARQUET_2_0, false)),
    ]
}

/// What another program may write: integers, booleans, floats, nulls, texts, dictionaries, two groups.
fn foreign(version: WriterVersion, snappy: bool) -> Vec<u8> {
    let message = "message other { required int32 count; required int64 id; optional double gap;
        required boolean sliding; optional float ratio; required int32 unsigned (UINT_32); }";
    let schema = Arc::new(parquet::schema::parser::parse_message_type(message).expect("a schema"));
    let compression =
        if snappy { parquet::basic::Compression::SNAPPY } else { parquet::basic::Compression::UNCOMPRESSED };
    let properties = WriterProperties::builder().set_compression(compression).set_writer_version(version);
    let mut bytes = Vec::new();
    let mut file =
        SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties.build())).expect("a writer");
    for _ in 0..2 {
        let mut group = file.next_row_group().expect("a group");
        let mut at = 0;
        while let Some(mut column) = group.next_column().expect("a column") {
            let written = match at {
                0 => column.typed::<Int32Type>().write_batch(&[-3, 4, 4], None, None),
                1 => column.typed::<Int64Type>().write_batch(&[1, 1 << 53, 7], None, None),
                2 => column.typed::<DoubleType>().write_batch(&[0.5, 0.5], Some(&[0, 1, 1]), None),
                3 => column.typed::<BoolType>().write_batch(&[true, false, true], None, None),
                4 => column.typed::<FloatType>().write_batch(&[0.25], Some(&[1, 0, 0]), None),
                _ => column.typed::<Int32Type>().write_batch(&[-1, 1, 2], None, None),
            };
            written.expect("values");
            column.close().expect("a column");
            at += 1;
        }
        group.close().expect("a group");
    }
    file.close().expect("a file");
    bytes
}
