//! Bonds from a case to its results: what is recorded, said, refused, and the same after a checkpoint.

use crate::common::{run, stderr, stdout};
use crate::{SMALL, digest, done, refused};

/// The small case with bonds, of which some rupture.
fn bonded() -> String {
    format!(
        "{SMALL}[grains.material]\ninterface_energy = 0\n[[bond]]\nlargest_gap = 0.02\nmodulus = \"1 GPa\"\n\
         tensile_strength = \"1 MPa\"\ncohesion = \"1 MPa\"\nscatter = \"weibull\"\nweibull_modulus = 1\n"
    )
}

#[test]
fn bonds_are_recorded_kept_and_said_to_be_left_out() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), bonded()).unwrap();
    done(here, &["run", "case.toml", "--out", "run"]);
    let measured = done(here, &["measure", "run"]);
    for column in [
        "bonds ",
        "bonds_broken_by_tension ",
        "mean_bond_radius ",
        "largest_fragment_fraction ",
        "bond_tension_loss ",
    ] {
        assert!(measured.lines().any(|line| line.starts_with(column)), "{column}: {measured}");
    }
    assert!(here.join("run/snapshots/end.bonds").is_file());
    let exported = run(here, &["export", "run", "--snapshot", "end", "-o", "end.vtp"]);
    assert!(exported.status.success(), "{}", stdout(&exported));
    assert!(stderr(&exported).contains("bonds between the grains are not written"), "{}", stderr(&exported));
    // A damaged list of bonds is told by the digests of the run.
    let path = here.join("run/snapshots/end.bonds");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &text[..text.len() / 2]).unwrap();
    assert!(refused(here, 1, &["digest", "run"]).contains("end.bonds"));
}

/// The same bits on one thread and on two, and a run in parts by a shorter interval of checkpoints.
#[test]
fn a_bonded_run_has_the_same_digest_however_it_is_made() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), bonded()).unwrap();
    done(here, &["run", "case.toml", "--out", "one", "--threads", "1"]);
    done(here, &["run", "case.toml", "--out", "two", "--threads", "2", "--checkpoint-every", "0"]);
    assert_eq!(digest(here, "one"), digest(here, "two"));
    let twice = bonded() + "[[bond]]\nlargest_gap = 0\n";
    std::fs::write(here.join("twice.toml"), twice).unwrap();
    let told = refused(here, 1, &["run", "twice.toml", "--out", "twice"]);
    assert!(told.contains("there is nothing to bond"), "{told}");
    let deck = refused(here, 1, &["export", "one", "--to", "lammps", "-o", "deck"]);
    assert!(deck.contains("bond = 1 tables cannot be written for LAMMPS"), "{deck}");
}
