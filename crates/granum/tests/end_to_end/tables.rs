//! Tables as laboratories and offices save them: signs by column, separators, marks and units.

use std::path::Path;

use serde_json::Value;

use crate::{done, done_json, refused};

const SAND: &str = "[grains]\ncount = 60\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\n\
                    tangential = 'no-slip'\n[preparation]\nmean_stress = '100 kPa'\nfriction = 0.1\nsolid_fraction = 'none'\n\
                    inertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.01\n\
                    inertial_number = 1e-2\nstates = 6\n";

/// Strains negative and stresses positive in compression.
const STRAIN_NEGATIVE: &str = "axial_strain (%),axial_stress (kPa),lateral_stress (kPa)\n0,100,100\n-0.5,260,100\n-1,310,100\n\
                               -2,345,100\n-4,360,100\n-6,352,100\n";
/// Volumetric strain positive in dilation.
const DILATION_POSITIVE: &str = "axial_strain (%),deviator_stress (kPa),volumetric_strain (%)\n0,0,0\n0.5,120,-0.05\n1,180,-0.02\n\
                                 2,230,0.3\n4,245,1.1\n6,240,1.9\n";

fn compared(here: &Path, file: &str, flags: &[&str]) -> Value {
    let line = [&["compare", "run", file, "--force"][..], flags].concat();
    done_json(here, &line)["summary"][0].clone()
}

#[test]
fn laboratory_files_are_read_as_they_are() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("sand.toml"), SAND.replace("axial_strain = 0.01", "axial_strain = 0.07"))
        .unwrap();
    done(here, &["run", "sand.toml", "--out", "run"]);
    let write = |name: &str, text: &str| std::fs::write(here.join(name), text).unwrap();
    write("strain.csv", STRAIN_NEGATIVE);
    write("dilation.csv", DILATION_POSITIVE);
    let number = |row: &Value, key: &str| row[key].as_f64().unwrap();

    let message = refused(here, 1, &["compare", "run", "strain.csv"]);
    assert!(message.contains("--compression axial_strain=negative"), "{message}");
    let message = refused(here, 1, &["compare", "run", "strain.csv", "--compression", "negative"]);
    assert!(message.contains("tension") && message.contains("axial_strain=negative"), "{message}");
    let turned = compared(here, "strain.csv", &["--compression", "axial_strain=negative"]);
    assert!((number(&turned, "peak_friction_angle") - 34.42).abs() < 0.01, "{turned:#}");
    write("stated.csv", &format!("# compression axial_strain = negative\n{STRAIN_NEGATIVE}"));
    let stated = compared(here, "stated.csv", &[]);
    assert_eq!(stated["peak_friction_angle"], turned["peak_friction_angle"]);

    let turned = compared(here, "dilation.csv", &["--compression", "volumetric_strain=negative"]);
    assert!((number(&turned, "largest_dilatancy_angle") - 9.6).abs() < 2.0, "{turned:#}");
    // All columns negative but one.
    let all_negative =
        STRAIN_NEGATIVE.replace(",260,", ",-260,").replace(",310,", ",-310,").replace(",345,", ",-345,");
    let all_negative =
        all_negative.replace(",360,", ",-360,").replace(",352,", ",-352,").replace("0,100,100", "0,-100,100");
    write("lateral.csv", &all_negative);
    let flags = ["--compression", "negative", "--compression", "lateral_stress=positive"];
    assert_eq!(compared(here, "lateral.csv", &flags)["peak_friction_angle"], stated["peak_friction_angle"]);

    for (sign, part) in [
        ("axial_strain=up", "positive or negative"),
        ("axial_strian=negative", "did you mean axial_strain?"),
        ("void_ratio=negative", "void_ratio has no sign of compression"),
    ] {
        let message = refused(here, 1, &["compare", "run", "strain.csv", "--force", "--compression", sign]);
        assert!(message.contains(part), "{sign}: {message}");
    }
}

/// Zero has no sign in what is printed, also where the sign of its column was turned.
#[test]
fn no_zero_is_negative() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("extension.toml"), SAND.replace("axial_strain = 0.01", "axial_strain = -0.01"))
        .unwrap();
    done(here, &["run", "extension.toml", "--out", "run"]);
    std::fs::write(here.join("strain.csv"), STRAIN_NEGATIVE).unwrap();
    let turned = ["compare", "run", "strain.csv", "--compression", "axial_strain=negative"];
    let message = refused(here, 1, &turned);
    assert!(message.contains("from 0 % to 6 %") && !message.contains("-0 %"), "{message}");
}

#[test]
fn files_of_offices_give_the_same_numbers() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("sand.toml"), SAND.replace("axial_strain = 0.01", "axial_strain = 0.07"))
        .unwrap();
    done(here, &["run", "sand.toml", "--out", "run"]);
    let plain = STRAIN_NEGATIVE.replace('-', "");
    std::fs::write(here.join("plain.csv"), &plain).unwrap();
    let wanted = compared(here, "plain.csv", &[]);
    let body = plain
        .lines()
        .skip(1)
        .map(|line| line.replace(',', ";").replace('.', ",") + ";\r\n")
        .collect::<String>();
    let german = format!(
        "Versuch;TMD 12;;\r\nPrüfer;\"Müller; Meier\";;\r\nDatum;01.02.2024;;\r\n\r\nEps_a;Sigma_1;Sigma_3;\r\n[%];[kPa];[kPa];\r\n{body};;;\r\n"
    );
    let map =
        ["--map", "axial_strain=Eps_a", "--map", "axial_stress=Sigma_1", "--map", "lateral_stress=Sigma_3"];
    let utf_16: Vec<u8> = format!("\u{feff}{german}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    let windows: Vec<u8> = german.chars().map(|c| u8::try_from(u32::from(c)).unwrap()).collect();
    for (name, bytes) in [
        ("utf-8.csv", german.clone().into_bytes()),
        ("utf-16.txt", utf_16),
        ("windows.csv", windows),
        ("tabs.txt", german.replace(';', "\t").into_bytes()),
    ] {
        std::fs::write(here.join(name), bytes).unwrap();
        let comparison = compared(here, name, &map);
        assert_eq!(
            comparison["peak_friction_angle"], wanted["peak_friction_angle"],
            "{name}: {comparison:#}"
        );
        assert_eq!(comparison["e50"], wanted["e50"], "{name}");
    }
    for (text, parts) in [
        (
            "axial_strain (%);deviator_stress (kPa)\n0,5;n/a\n",
            &["lab.csv:2:5", "deviator_stress", "n/a", "left out"][..],
        ),
        ("axial_strain (%);deviator_stress (kPa)\n0,5;1.234,5\n", &["lab.csv:2:5", "1.234,5", "thousands"]),
        (
            "axial_strain (%);deviator_stress (kPa)\n1,125;2,250\n",
            &["lab.csv:2:1", "1,125", "# decimal = comma"],
        ),
        ("axial_strain (%);axial_strain;q\n0;0;1\n", &["lab.csv:1:18", "axial_strain", "so is the column"]),
        (
            "axial_strain (%);volumetric_strain (%);axial_strain (%)\n0;0;1\n",
            &["lab.csv:1:40", "two columns have the name"],
        ),
    ] {
        std::fs::write(here.join("lab.csv"), text).unwrap();
        let message = refused(here, 1, &["compare", "run", "lab.csv", "--force"]);
        assert!(parts.iter().all(|part| message.contains(part)), "{text}: {message}");
    }
}

#[test]
fn designs_are_read_as_they_are_and_stay_in_their_ranges() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("sand.toml"), SAND).unwrap();
    let variables = "[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\n[[variable]]\nname = 'modulus'\n\
                     key = 'grains.material.youngs_modulus'\n";
    let plan = format!("case = 'sand.toml'\n[design]\nkind = 'csv'\nfile = 'd.csv'\n{variables}");
    std::fs::write(here.join("plan.toml"), plan).unwrap();
    let planned = ["campaign", "plan.toml", "--dry-run", "--pilots", "0"];
    let table = |text: &str| std::fs::write(here.join("d.csv"), text).unwrap();
    table("friction,modulus\n0.3,20 GPa\n0.35,21.5 GPa\n");
    let wanted = done_json(here, &planned)["runs"].clone();
    assert!(wanted.as_array().is_some_and(|runs| runs.len() == 2), "{wanted}");
    for text in [
        "\u{feff}friction,modulus\n0.3,20 GPa\n0.35,21.5 GPa\n",
        "friction;modulus (GPa);;\n0,3;20;;\n0,35;21,5;;\n;;;\n",
        "friction\tmodulus\n-\tGPa\n0,3\t20\n0,35\t21,5\n",
        "\"friction\",\"modulus\"\n\"0.3\",\"20 GPa\"\n\"0.35\",\"21.5 GPa\"\n",
    ] {
        table(text);
        let planned_runs = done_json(here, &planned)["runs"].clone();
        assert_eq!(planned_runs, wanted, "{text}");
    }
    for (text, parts) in [
        ("friction,friction\n0.1,0.2\n", &["d.csv:1:10", "two columns have the name friction"][..]),
        ("friction,modulus\n0.1\n", &["d.csv:2:1", "1 cells"]),
        ("friction;modulus\n0,1;1.234,5 MPa\n", &["d.csv:2:5", "thousands"]),
    ] {
        table(text);
        let message = refused(here, 1, &planned);
        assert!(parts.iter().all(|part| message.contains(part)), "{text}: {message}");
    }
    let range = |step: &str| {
        let plan = "case = 'sand.toml'\n[design]\nkind = 'sobol'\npoints = 8\n[[variable]]\nname = 'friction'\n\
                    key = 'grains.material.friction'\nfrom = 0.1\nto = 0.8\nstep = ";
        std::fs::write(here.join("plan.toml"), format!("{plan}{step}\n")).unwrap();
    };
    for (step, part) in
        [("10", "no multiple of the step 10"), ("0.6", "only one multiple of the step 0.6, 0.6,")]
    {
        range(step);
        let message = refused(here, 1, &planned);
        assert!(message.contains(part) && message.contains("plan.toml:10:8"), "{step}: {message}");
    }
    range("0.3");
    let runs = done_json(here, &planned)["runs"].clone();
    let frictions: Vec<f64> = runs
        .as_array()
        .unwrap()
        .iter()
        .map(|run| run["values"]["friction"].as_f64().unwrap_or(f64::NAN))
        .collect();
    assert!(
        frictions.iter().all(|friction| [0.3, 0.6].contains(friction)) && !frictions.is_empty(),
        "{runs}"
    );
}

#[test]
fn inputs_of_predictions_are_read_as_they_are() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("sand.toml"), SAND).unwrap();
    for (name, modulus) in [("one", "20 GPa"), ("two", "30 GPa")] {
        let modulus = format!("grains.material.youngs_modulus={modulus}");
        done(here, &["run", "sand.toml", "--out", name, "--set", &modulus]);
    }
    let train = [
        "train",
        "one",
        "two",
        "--input",
        "axial_strain,grains.material.youngs_modulus",
        "--output",
        "stress_ratio",
    ];
    done(here, &[&train[..], &["--coordinate", "axial_strain", "--method", "ridge", "-o", "study"]].concat());
    let predicted = |text: &str| {
        std::fs::write(here.join("rows.csv"), text).unwrap();
        done(here, &["predict", "study", "--model", "stress_ratio-ridge", "--input", "rows.csv"])
    };
    let wanted = predicted("axial_strain,grains.material.youngs_modulus\n0.005,25e9\n");
    for text in [
        "\"axial_strain\",\"grains.material.youngs_modulus\"\n\"0.005\",\"25e9\"\n",
        "\u{feff}axial_strain;grains.material.youngs_modulus;note\n0,005;25E+09;\"a; b\"\n",
        "rows for Tuesday\naxial_strain (%),grains.material.youngs_modulus (GPa)\n0.5,25\n",
        ",axial_strain,grains.material.youngs_modulus\n0,0.005,25e9\n",
    ] {
        assert_eq!(predicted(text), wanted, "{text}");
    }
    std::fs::write(here.join("rows.csv"), "axial_strain,grains.material.youngs_modulus\n0.005,25 GPa\n")
        .unwrap();
    let message =
        refused(here, 1, &["predict", "study", "--model", "stress_ratio-ridge", "--input", "rows.csv"]);
    assert!(
        message.contains("rows.csv:2:7") && message.contains("the unit belongs into the header"),
        "{message}"
    );
}

#[test]
fn densities_that_no_sample_can_have_are_refused_first() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("sand.toml"), SAND).unwrap();
    for (setting, parts) in [
        (
            "preparation.solid_fraction=0.75",
            &["solid_fraction = 0.75", "solid fraction is never above 0.74"][..],
        ),
        ("preparation.void_ratio=0.3", &["void_ratio = 0.3", "void ratio is never below 0.348"]),
        ("preparation.void_ratio=1.1", &["void_ratio = 1.1", "void ratio is never above 0.92"]),
        ("preparation.void_ratio=-0.2", &["void_ratio", "-0.2", "from 0.2 to 2"]),
    ] {
        let message = refused(here, 1, &["run", "sand.toml", "--out", "run", "--set", setting]);
        assert!(parts.iter().all(|part| message.contains(part)), "{setting}: {message}");
        assert!(!here.join("run").exists());
    }
    let loose = ["prepare", "sand.toml", "--out", "sample", "--set", "preparation.void_ratio=0.85"];
    let said = done(here, &loose);
    assert!(
        said.contains("target void ratio 0.85 not reached: preparation.friction = 0.1 gives 0."),
        "{said}"
    );
}
