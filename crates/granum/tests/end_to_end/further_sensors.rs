//! Sensors that a case names, and the stiffness of samples and states.

use crate::common::stderr;
use crate::{SMALL, done, done_json, refused};

/// Every sensor that is not recorded anyway.
const ALL: &str = "overlap_distribution,nonaffine_displacement,second_order_work,void_ratio,friction_angle,dilatancy,\
                   state_parameter,networks,anisotropies,directions,contact_motion,granular_temperature,\
                   coordination_by_size,radial_distribution,d2min,force_chains,chain_buckling,local_solid_fraction,\
                   invariants";

#[test]
fn every_sensor_can_be_asked_for_and_changes_nothing_else() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    done(here, &["shear", "case.toml", "--sample", "sample", "--out", "usual"]);
    let sensors = format!("recording.sensors={ALL}");
    let line = ["--set", "recording.critical_void_ratio=0.7", "--set", "recording.critical_slope=0.01"];
    let shear = ["shear", "case.toml", "--sample", "sample", "--out", "all", "--set", &sensors];
    done(here, &[&shear[..], &line].concat());

    let table = |name: &str| granum_io::read_table(here.join(name)).unwrap();
    let (usual, all) = (table("usual/series.parquet"), table("all/series.parquet"));
    for column in usual.columns() {
        assert_eq!(all.values(&column.name), Some(&column.values[..]), "{}", column.name);
    }
    let last = |name: &str| *all.values(name).unwrap_or_else(|| panic!("no {name}")).last().unwrap();
    let e = 1.0 / last("solid_fraction") - 1.0;
    assert!((last("void_ratio") - e).abs() < 1e-4, "the mean of e is not quite e of the mean");
    // psi = e - (0.7 - 0.01 (p / 100 kPa)^0.7) at 20 kPa.
    assert!((last("state_parameter") - (e - 0.7 + 0.01 * 0.2f64.powf(0.7))).abs() < 1e-4);
    assert!((last("mobilised_friction").asin().to_degrees() - last("mobilised_friction_angle")).abs() < 0.1);
    assert!(last("voronoi_gap").abs() < 1e-12 && last("local_solid_fraction") > 0.5);
    assert!(last("contact_anisotropy") > 0.0 && last("normal_force_anisotropy") > 0.0);
    assert!((1.0..40.0).contains(&last("force_chains")) && last("chain_grain_fraction") < 1.0);
    let distances = table("all/histograms/distances.parquet");
    assert_eq!(distances.rows(), 100 * all.rows());
    done(here, &["report", "all"]);
    let report = std::fs::read_to_string(here.join("all/report.html")).unwrap();
    assert!(
        report.contains("Mobilised friction angle") && report.contains("Density of centres at a distance")
    );

    let measured = done_json(here, &["measure", "all"]);
    assert!(
        measured["values"]["state_parameter"].is_number() && measured["values"]["longest_chain"].is_number()
    );
    let shear = [
        "shear",
        "case.toml",
        "--sample",
        "sample",
        "--out",
        "r",
        "--set",
        "recording.sensors=state_parameter",
    ];
    let message = refused(here, 1, &shear);
    assert!(message.contains("set recording.critical_void_ratio"), "{message}");
}

/// The tables that granum writes are measured as what they are tables of, also by the names of other programs.
#[test]
fn tables_of_grains_and_contacts_are_measured_as_the_run_itself() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let text = std::fs::read_to_string(here.join("sample/snapshots/start.json")).unwrap();
    let snapshot: serde_json::Value = serde_json::from_str(&text).unwrap();
    let edge = |k: usize| format!("{:?} m", snapshot["assembly"]["cell"][k][k].as_f64().unwrap());
    let cell = format!("{}, {}, {}", edge(0), edge(1), edge(2));
    done(here, &["export", "sample", "--table", "grains", "-o", "grains.csv"]);
    done(here, &["export", "sample", "--table", "grains", "-o", "grains.parquet"]);
    done(here, &["export", "sample", "--table", "contacts", "-o", "contacts.csv"]);
    let whole = done_json(here, &["measure", "sample"]);
    let tables = done_json(here, &["measure", "grains.csv", "contacts.csv", "--cell", &cell]);
    // Parquet has the cell.
    assert_eq!(done_json(here, &["measure", "grains.parquet", "contacts.csv"])["values"], tables["values"]);
    let value = |told: &serde_json::Value, name: &str| told["values"][name].as_f64().unwrap();
    for name in [
        "mean_stress",
        "stress_12",
        "coordination_number",
        "solid_fraction",
        "sliding_fraction",
        "deviator_fabric",
    ] {
        let (here, there) = (value(&whole, name), value(&tables, name));
        assert!((here - there).abs() <= 1e-12 * here.abs(), "{name}: {here} {there}");
    }
    done(here, &["export", "grains.csv", "--cell", &cell, "-o", "packing.csv"]);
    let packing = granum_io::read_packing(here.join("packing.csv")).unwrap();
    assert_eq!(packing.grains.len() as u64, snapshot["grains"].as_u64().unwrap());
    let error = refused(here, 1, &["measure", "grains.csv", "--cell", "1 mm, -1 mm, 1 mm"]);
    assert!(error.contains("its edges must be positive"), "{error}");
    let error = refused(here, 1, &["export", "sample", "--table", "forces", "-o", "forces.csv"]);
    assert!(error.contains("sample has no such table; there are preparation, grains, contacts"), "{error}");
    let error = refused(here, 1, &["shear", "case.toml", "--packing", "grains.csv", "--out", "run"]);
    assert!(error.contains("grains.csv: has no cell") && error.contains("--cell"), "{error}");
}

#[test]
fn the_stiffness_of_a_sample_and_of_states_of_its_test() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    done(here, &["prepare", "case.toml", "--out", "sample"]);
    let sample = done_json(here, &["stiffness", "sample"]);
    let value = |found: &serde_json::Value, column: &str| found["columns"][column][0].as_f64().unwrap();
    let (k, g) = (value(&sample, "bulk_modulus"), value(&sample, "shear_modulus"));
    assert!(g > 0.0 && g < value(&sample, "affine_shear_modulus"), "{g}");
    assert!(k > 0.0 && k < value(&sample, "affine_bulk_modulus"), "{k}");

    let at = ["stiffness", "case.toml", "--sample", "sample", "--at", "0, 0.01", "--output", "stiffness.csv"];
    done(here, &at);
    let table = granum_io::read_table(here.join("stiffness.csv")).unwrap();
    let strains = table.values("deviator_strain").unwrap();
    assert!(strains.len() == 2 && strains[0] == 0.0 && (strains[1] - 0.01).abs() < 1e-4, "{strains:?}");
    let moduli = table.values("shear_modulus").unwrap();
    assert!((moduli[0] / g - 1.0).abs() < 0.01, "{moduli:?} {g}");
    assert_eq!(table.names().filter(|name| name.starts_with("c_")).count(), 36);

    let curve = ["stiffness", "sample", "--strain", "1e-6", "--degradation", "1e-3", "--output", "curve.csv"];
    done(here, &curve);
    let curve = granum_io::read_table(here.join("curve.csv")).unwrap();
    let relative = curve.values("relative_shear_modulus").unwrap();
    assert!(relative[0] == 1.0 && *relative.last().unwrap() < 0.5, "{relative:?}");

    let output = crate::run(here, &["stiffness", "case.toml"]);
    assert!(stderr(&output).contains("or a case with --at"), "{}", stderr(&output));
    let message = refused(here, 1, &["stiffness", "case.toml", "--at", "0, -1"]);
    assert!(message.contains("is negative"), "{message}");
}
