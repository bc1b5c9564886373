//! Tests of stresses and strains without a unit.

use super::bare_number::SetKey;
use super::{Case, Reading};

/// A case of a sample at 100 kPa with this stage.
fn stage(stage: &str) -> crate::Result<Case> {
    Case::parse(&format!("[preparation]\nmean_stress = \"100 kPa\"\n[[stage]]\n{stage}\n"), "case.toml")
}

#[test]
fn a_number_far_from_the_sample_needs_its_unit() {
    for (text, parts) in [
        (
            "path = \"drained-triaxial\"\nlateral_stress = 50",
            &[
                "case.toml:5:18: stage.1.lateral_stress = 50 is understood as 50 Pa, 2000 times less than",
                "mean stress of 100 kPa; probably 50 kPa was meant: write \"50 kPa\", or \"50 Pa\" if that is meant",
            ][..],
        ),
        ("path = \"drained-triaxial\"\nlateral_stress = \"50\"", &["is understood as 50 Pa", "\"50 kPa\""]),
        ("path = \"drained-triaxial\"\nlateral_stress = 1e4", &["10 kPa, 10 times less than"]),
        (
            "path = \"drained-triaxial\"\nlateral_stress = 1e6",
            &["1 MPa, 10 times the", "with its unit, \"1e6 Pa\""],
        ),
        ("path = \"oedometer\"\naxial_stress = 0.4", &["0.4 Pa", "\"0.4 MPa\""]),
        ("path = \"drained-triaxial\"\naxial_strain = 2", &["a strain of 200 %", "\"2 %\"", "\"200 %\""]),
        ("path = \"drained-triaxial\"\naxial_strain = -2.5", &["a strain of -250 %", "\"-2.5 %\""]),
        (
            "path = \"unload-reload\"\nat = [0.5, 1.5]",
            &["stage.1.at = 1.5 is understood as a strain of 150 %"],
        ),
        ("xx = { stress = 50 }\nuntil = { xx_strain = 0.1 }", &["stage.1.xx.stress = 50", "50 kPa"]),
        ("xx = { strain_to = 5 }", &["stage.1.xx.strain_to = 5", "500 %"]),
        ("xx = { rate = 1 }\nuntil = { mean_stress = 300 }", &["stage.1.until.mean_stress = 300", "300 kPa"]),
        ("xx = { rate = 1 }\nuntil = { xx_strain = 10 }", &["stage.1.until.xx_strain = 10", "1000 %"]),
        (
            "xx = { rate = 1 }\nturns = { measure = \"mean_stress\", high = \"150 kPa\", low = 50 }\nuntil = { reversals = 2 }",
            &["stage.1.turns.low = 50", "50 kPa"],
        ),
        (
            "constraint = [{ stress = [1, 1, 1, 0, 0, 0], value = 300 }]\nxx = { rate = 1 }\nyy = \"free\"\nuntil = { xx_strain = 0.1 }",
            &["stage.1.constraint.1.value = 300"],
        ),
        (
            "path = \"history\"\ncolumns = [\"xx_strain\", \"yy_stress\"]\nrows = [[0, 100], [0.01, 120]]",
            &["case.toml:6:13: stage.1.rows (yy_stress) = 100 is understood as 100 Pa", "\"100 kPa\""],
        ),
    ] {
        let found = stage(text).unwrap_err().to_string();
        assert!(parts.iter().all(|part| found.contains(part)), "{text}: {found}");
    }
}

#[test]
fn a_number_with_a_unit_or_near_the_sample_is_taken() {
    for text in [
        "path = \"drained-triaxial\"\nlateral_stress = \"50 Pa\"",
        "path = \"drained-triaxial\"\nlateral_stress = 50e3",
        "path = \"drained-triaxial\"\naxial_strain = \"200 %\"",
        "path = \"drained-triaxial\"\naxial_strain = 1",
        "path = \"cyclic\"\nmean_deviator_stress = 0\nstress_amplitude = 20e3",
        "path = \"undrained-triaxial\"\nfluid_modulus = 2e9",
        // A path begins at zero, and its largest stress is that of the sample.
        "path = \"history\"\ncolumns = [\"yy_stress\"]\nrows = [[0], [500], [90e3]]",
        // Each stress is near the one before it.
        "path = \"isotropic\"\nmean_stress = 5e5\n[[stage]]\npath = \"isotropic\"\nmean_stress = 2e6",
        "path = \"isotropic\"\nmean_stress = \"10 MPa\"\n[[stage]]\npath = \"isotropic\"\nmean_stress = 2e7",
        "xx = { rate = 1 }\nuntil = { arc_length = 5 }",
    ] {
        stage(text).unwrap_or_else(|error| panic!("{text}: {error}"));
    }
}

#[test]
fn the_stress_of_the_sample_itself_is_not_a_few_pascals() {
    let error = Case::parse("[preparation]\nmean_stress = 100\n", "case.toml").unwrap_err().to_string();
    assert!(
        error.contains("case.toml:2:15: preparation.mean_stress = 100 is understood as 100 Pa"),
        "{error}"
    );
    assert!(error.contains("write \"100 kPa\", or \"100 Pa\" if that is meant"), "{error}");
    Case::parse("[preparation]\nmean_stress = \"100 Pa\"\n", "case.toml").unwrap();
    Case::parse("[preparation]\nmean_stress = 1000\n", "case.toml").unwrap();
    let error = Case::parse("[shear]\nmean_stress = 100\n", "case.toml").unwrap_err().to_string();
    assert!(
        error.contains("shear.mean_stress = 100 is understood as 100 Pa, 200 times less than"),
        "{error}"
    );
}

/// What granum writes is read back as it is, wherever it is copied to, and old records need no units.
#[test]
fn a_resolved_case_has_units_where_they_are_needed() {
    let text = "path = \"drained-triaxial\"\nlateral_stress = \"50 Pa\"\naxial_strain = \"230 %\"\n[[stage]]\npath = \"history\"\n\
                columns = [\"xx_strain\", \"yy_stress\"]\nrows = [[0, \"100 Pa\"], [\"210 %\", \"120 Pa\"]]\n[[stage]]\n\
                xx = { stress_to = \"3 Pa\" }\nuntil = { yy_strain = \"700 %\" }";
    let case = stage(text).unwrap();
    let written = case.readable_toml(None).unwrap();
    for part in [
        "lateral_stress = \"50 Pa\"",
        "axial_strain = \"230 %\"",
        "\"120 Pa\"",
        "stress_to = \"3 Pa\"",
        "\"700 %\"",
    ] {
        assert!(written.contains(part), "{part} in {written}");
    }
    assert_eq!(Case::parse(&written, "copy.toml").unwrap(), case);
    let old = "[preparation]\nmean_stress = 100000  # Pa\n[[stage]]\npath = \"drained-triaxial\"\nlateral_stress = 50  # Pa\n";
    assert!(Case::parse(old, "case.toml").is_err());
    Case::parse_as(old, "case.toml", Reading::recorded()).unwrap();
    // A usual case is written as ever.
    let usual = stage("path = \"drained-triaxial\"\nlateral_stress = \"200 kPa\"").unwrap().resolved_toml();
    assert!(usual.contains("lateral_stress = 200000  # Pa\n"), "{usual}");
}

#[test]
fn the_case_file_of_a_run_folder_is_its_record() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("case.toml");
    let old =
        "[preparation]\nmean_stress = 100000\n[[stage]]\npath = \"drained-triaxial\"\nlateral_stress = 50\n";
    std::fs::write(&path, old).unwrap();
    assert!(Case::read(&path).is_err());
    std::fs::write(folder.path().join("run.json"), "{}").unwrap();
    Case::read(&path).unwrap();
}

#[test]
fn histories_in_files_name_their_units() {
    let folder = tempfile::tempdir().unwrap();
    let case = |history: &str| {
        std::fs::write(folder.path().join("element.csv"), history).unwrap();
        let text = "[preparation]\nmean_stress = \"100 kPa\"\n[[stage]]\npath = \"history\"\nfile = \"element.csv\"\n";
        std::fs::write(folder.path().join("case.toml"), text).unwrap();
        Case::read(folder.path().join("case.toml"))
    };
    let error = case("xx_strain,yy_stress\n0,0\n0.01,120\n").unwrap_err().to_string();
    let parts = [
        "element.csv:1:11: yy_stress goes to 120 and is understood as 120 Pa",
        "yy_stress (kPa), or yy_stress (Pa)",
    ];
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    let error = case("time,xx_strain\n0,0\n1,-5\n").unwrap_err().to_string();
    let parts = [
        "element.csv:1:6: xx_strain goes to -5 and is understood as a strain of -500 %",
        "xx_strain (%), or xx_strain (1)",
    ];
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    for good in [
        "xx_strain,yy_stress (Pa)\n0,0\n0.01,120\n",
        "xx_strain (1)\n5\n",
        "xx_strain [%],yy_stress (kPa)\n5,100\n",
    ] {
        case(good).unwrap_or_else(|error| panic!("{good}: {error}"));
    }
}

#[test]
fn flags_are_judged_by_the_sample_that_they_leave() {
    let before = stage("path = \"drained-triaxial\"\nlateral_stress = \"100 kPa\"").unwrap();
    let check = |keys: &[(&str, &str)]| {
        let mut after = before.clone();
        keys.iter().for_each(|(path, text)| after.set(path, text).unwrap());
        let keys: Vec<SetKey> = keys.iter().map(|&(path, text)| SetKey { flag: path, path, text }).collect();
        after.check_bare_numbers(&before, &keys)
    };
    let error = check(&[("stage.1.lateral_stress", "50")]).unwrap_err().to_string();
    let parts = ["stage.1.lateral_stress = \"50\" is understood as 50 Pa", "probably 50 kPa was meant"];
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
    assert!(check(&[("stage.1.axial_strain", "2")]).is_err());
    assert!(check(&[("preparation.mean_stress", "50")]).is_err());
    check(&[("stage.1.lateral_stress", "50 Pa"), ("stage.1.axial_strain", "120 %")]).unwrap();
    check(&[("stage.1.lateral_stress", "2e6"), ("preparation.mean_stress", "1 MPa")]).unwrap();
}
