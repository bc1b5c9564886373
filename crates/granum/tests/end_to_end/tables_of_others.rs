//! Files of other programs whose tables say more or less than which grains touch. The numbers are those of LAMMPS (`compute contact/atom`)
//! and of a search over all images.

use std::path::Path;

use serde_json::Value;

use crate::{done, done_json, refused};

fn file(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/end_to_end/tables_of_others");
    folder.join(name).to_str().unwrap().to_string()
}

fn measured(here: &Path, arguments: &[&str]) -> Value {
    done_json(here, &[&["measure"], arguments].concat())
}

fn assert_near(measured: &Value, column: &str, wanted: f64) {
    let value = measured["values"][column].as_f64().unwrap();
    assert!((value - wanted).abs() < 5e-4 * wanted.abs(), "{column}: {value}, not {wanted}");
}

const COLUMNS: &str = "index,patom1,patom2,fx,fy,fz,p1,p2,p3";

/// LAMMPS lists 497 pairs within the cutoff, of which 258 touch.
#[test]
fn pairs_within_a_cutoff_are_no_contacts() {
    let base = tempfile::tempdir().unwrap();
    let of = |pairs: &str| {
        let columns = format!("{}={COLUMNS}", file(pairs));
        measured(base.path(), &[&file("grains.dump"), &file(pairs), "--columns", &columns])
    };
    let all = of("pairs.dump");
    assert_eq!((&all["contacts"], &all["contacts_are"]), (&258.into(), &"read".into()));
    for (column, wanted) in [
        ("coordination_number", 5.16),
        ("rattler_fraction", 0.02),
        ("deviator_fabric", 0.034_696),
        ("mean_normal_force", 0.107_395_5),
    ] {
        assert_near(&all, column, wanted);
    }
    let said = all["warnings"][0].as_str().unwrap();
    assert!(said.starts_with("239 pairs of 497 of the table do not touch and have no force"), "{said}");
    let touching = of("touching.dump");
    assert_eq!(touching["values"], all["values"]);
    assert!(touching.get("warnings").is_none_or(|warnings| warnings.as_array().unwrap().is_empty()));
}

#[test]
fn a_table_that_lacks_pairs_or_pulls_everywhere_is_refused_until_its_owner_tells() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let text = std::fs::read_to_string(file("touching.dump")).unwrap();
    let (head, rows) = text.split_once("ITEM: ENTRIES").unwrap();
    let mut lines: Vec<&str> = rows.lines().collect();
    lines.truncate(1 + 200);
    let fewer = format!("{}ITEM: ENTRIES{}\n", head.replace("\n258\n", "\n200\n"), lines.join("\n"));
    std::fs::write(here.join("fewer.dump"), fewer).unwrap();
    let measure = |name: &str| -> Vec<String> {
        ["measure", &file("grains.dump"), name, "--columns", &format!("{name}={COLUMNS}")]
            .map(String::from)
            .to_vec()
    };
    let given = measure("fewer.dump");
    let line: Vec<&str> = given.iter().map(String::as_str).collect();
    let message = refused(here, 1, &line);
    assert!(message.contains("fewer.dump") && message.contains("58 pairs of grains overlap"), "{message}");
    assert!(message.contains("--missing-pairs no-contacts"), "{message}");
    let counted = done_json(here, &[&line[..], &["--missing-pairs", "without-force"]].concat());
    assert_eq!(counted["contacts"], 258);
    let message = refused(here, 1, &[&line[..], &["--missing-pairs", "no-contact"]].concat());
    assert!(message.contains("did you mean no-contacts?"), "{message}");
}

/// 12 contacts, as `--case` finds them.
#[test]
fn grains_without_a_table_touch_where_they_overlap() {
    let base = tempfile::tempdir().unwrap();
    let found = measured(base.path(), &[&file("grains-only.dump")]);
    assert_eq!((&found["contacts"], &found["contacts_are"]), (&12.into(), &"computed".into()));
    assert_near(&found, "coordination_number", 0.3);
    assert_near(&found, "fabric_11", 0.440_65);
    let text = done(base.path(), &["measure", &file("grains-only.dump")]);
    assert!(text.contains("80 grains, 12 contacts (computed from the overlaps of the grains)"), "{text}");
}

/// Three grains in a row without a cell, as ParaView names their columns: two overlap, and the third is apart.
#[test]
fn columns_of_paraview_and_no_cell_are_enough_for_contacts() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let rows = "\"Points:0\",\"Points:1\",\"Points:2\",rad\n0,0,0,0.5\n0.9,0,0,0.5\n2.5,0,0,0.5\n";
    std::fs::write(here.join("points.csv"), rows).unwrap();
    let found = measured(here, &["points.csv"]);
    assert_eq!((&found["grains"], &found["contacts"]), (&3.into(), &1.into()));
}

#[test]
fn a_box_of_any_orientation_is_the_restricted_one_turned() {
    let base = tempfile::tempdir().unwrap();
    let of = |name: &str| measured(base.path(), &[&file(name)]);
    let (general, restricted) = (of("general.data"), of("restricted.data"));
    for found in [&general, &restricted] {
        assert_near(found, "solid_fraction", 0.208_291);
        assert_eq!(found["contacts"], 12);
    }
    let packing = base.path().join("packing.csv");
    done(base.path(), &["export", &file("general.data"), "-o", packing.to_str().unwrap()]);
    assert_near(&measured(base.path(), &["packing.csv"]), "solid_fraction", 0.208_291);
}

/// Two spheres of a clump and one that is alone, whose file has no cell.
#[test]
fn a_cell_goes_with_a_case_and_clumps_are_said() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let rows = "#format x_y_z_r_clumpId\n0.30 0.5 0.5 0.1 0\n0.495 0.5 0.5 0.1 0\n0.69 0.5 0.5 0.1 -1\n";
    std::fs::write(here.join("grains.txt"), rows).unwrap();
    let case = "[preparation]\nmean_stress = '1.5 kPa'\n[grains.material]\nyoungs_modulus = '400 kPa'\ninterface_energy = 0\n\
                [contact]\nnormal = 'hertz'\ntangential = 'no-slip'\n";
    std::fs::write(here.join("case.toml"), case).unwrap();
    for flags in [&["--case", "case.toml"][..], &[]] {
        let line = [&["grains.txt", "--cell", "1 m, 1 m, 1 m"][..], flags].concat();
        let found = measured(here, &line);
        assert_eq!((&found["grains"], &found["contacts"]), (&2.into(), &1.into()));
        assert_eq!(found["values"].get("mean_normal_force").is_some(), !flags.is_empty());
    }
    let found = measured(here, &["grains.txt", "--cell", "1 m, 1 m, 1 m", "--separate-spheres"]);
    assert_eq!((&found["grains"], &found["contacts"]), (&3.into(), &2.into()));
    let said = found["warnings"][0].as_str().unwrap();
    assert!(said.starts_with("2 spheres are parts of 1 body (column clump)"), "{said}");
}

/// A command checks what it uses of a case: two soft grains have a force, whatever stress a sample would have.
#[test]
fn soft_grains_have_forces_where_no_sample_is_made() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(
        here.join("two.csv"),
        "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=10 yhi=10 zhi=10\nid,x,y,z,radius\n1,2.5,5,5,0.5\n2,3.49,5,5,0.5\n",
    )
    .unwrap();
    std::fs::write(here.join("path.csv"), "normal_approach,tangential_displacement\n1e-4,0\n").unwrap();
    let law = ["--normal", "hertz", "--youngs-modulus", "400 kPa", "--poissons-ratio", "0.2"];
    let forces = done_json(here, &[&["forces", "two.csv"], &law[..]].concat());
    let force = forces["forces"]["fx"][1].as_f64().unwrap();
    // 4/3 E* sqrt(R*) overlap^1.5
    let wanted = 4.0 / 3.0 * (2e5 / 0.96) * 0.25f64.sqrt() * 0.01f64.powf(1.5);
    assert!((force / wanted - 1.0).abs() < 1e-9, "{force} {wanted}");
    done(here, &[&["pair", "path.csv", "--diameter", "1 cm"], &law[..]].concat());
    done(
        here,
        &[&["impact", "--speed", "1 cm/s", "--diameter", "1 cm", "--density", "1000"], &law[..]].concat(),
    );
    // What the command uses is checked as before.
    let message = refused(here, 1, &["forces", "two.csv", "--friction=-1"]);
    assert!(message.contains("--friction"), "{message}");
}
