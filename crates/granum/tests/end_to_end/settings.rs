//! `--set` and `--seed`: many runs from one case, with the same error messages as for the case file.

use crate::{SMALL, digest, done, done_json, refused};

#[test]
fn flags_change_the_case_as_its_file_would() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    std::fs::write(
        here.join("changed.toml"),
        SMALL.replace("[shear]", "seed = 7\n[grains.material]\nfriction = 0.2\n[shear]"),
    )
    .unwrap();
    let set = ["--set", "grains.material.friction=0.2", "--seed", "7"];
    done(here, &[&["shear", "case.toml", "--out", "by-flags"][..], &set].concat());
    done(here, &["shear", "changed.toml", "--out", "by-file"]);
    assert_eq!(digest(here, "by-flags"), digest(here, "by-file"));
    let case = std::fs::read_to_string(here.join("by-flags/case.toml")).unwrap();
    assert!(case.contains("friction = 0.2\n") && case.contains("seed = 7\n"), "{case}");
    done(here, &[&["prepare", "case.toml", "--out", "sample"][..], &set].concat());
    done(here, &["shear", "changed.toml", "--sample", "sample", "--out", "by-sample"]);
    assert_eq!(digest(here, "by-sample"), digest(here, "by-file"));
}

#[test]
fn wrong_flags_are_refused_with_what_would_be_right() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL).unwrap();
    for (flags, wanted) in [
        (
            &["--set", "grains.diameter=70 kg"][..],
            "--set grains.diameter = \"70 kg\" is a mass; it must be a length",
        ),
        (
            &["--set", "grains.diametre=1 mm"],
            "--set grains.diametre = \"1 mm\" is not a key; did you mean grains.diameter?",
        ),
        (&["--set", "contact.damping"], "--set \"contact.damping\": a key and its value are needed"),
        (&["--set", "contact.damping=2"], "is out of bounds; it must be from 0 to 1"),
        (&["--seed", "-1"], "--seed = \"-1\" is not a whole number"),
        (&["--seed", "2", "--set", "preparation.seed=3"], "preparation.seed is given twice"),
        (
            &["--set", "shear.strain_rate=1e-5 /s", "--set", "shear.inertial_number=1e-3"],
            "exclude each other",
        ),
        (
            &["--set", "contact.normal=hertz", "--set", "contact.tangential=peeling"],
            "with --set contact.normal=hertz --set contact.tangential=peeling: contact.tangential = \"peeling\" needs",
        ),
    ] {
        for command in ["shear", "prepare"] {
            let message = refused(here, 1, &[&[command, "case.toml", "--out", "r"][..], flags].concat());
            assert!(message.contains(wanted), "{flags:?}: {message}");
        }
    }
    assert_eq!(std::fs::read_dir(here).unwrap().count(), 1, "nothing may be left behind");
}

#[test]
fn commands_on_a_law_take_keys_of_the_law() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("path.csv"), "normal_approach,tangential_displacement\n1e-8,0\n1e-8,1e-9\n")
        .unwrap();
    std::fs::write(here.join("case.toml"), "[contact]\nnormal = \"hertz\"\n").unwrap();
    let force =
        |flags: &[&str]| done(here, &[&["pair", "path.csv", "--case", "case.toml"][..], flags].concat());
    assert_eq!(
        force(&["--set", "grains.material.youngs_modulus=30 GPa"]),
        force(&["--youngs-modulus", "30 GPa"])
    );
    assert_ne!(force(&["--set", "grains.material.youngs_modulus=30 GPa"]), force(&[]));
    let impact = |flags: &[&str]| {
        done_json(here, &[&["impact", "--speed", "0.1", "--case", "case.toml"][..], flags].concat())
    };
    assert_eq!(impact(&["--set", "contact.damping=0.3"]), impact(&["--damping", "0.3"]));
    let message = refused(here, 1, &["pair", "path.csv", "--set", "shear.deviator_strain=0.1"]);
    assert!(message.contains("--set shear.deviator_strain has no effect in this command"), "{message}");
    let message =
        refused(here, 1, &["pair", "path.csv", "--friction", "0.1", "--set", "grains.material.friction=0.2"]);
    assert!(message.contains("--friction both set grains.material.friction"), "{message}");
    let message = refused(here, 1, &["pair", "path.csv", "--set", "contact.dampling=0.1"]);
    assert!(message.contains("did you mean contact.damping?"), "{message}");
}
