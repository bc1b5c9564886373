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
    let exported = run(here, &["export", "run", "--snapshot", "end", "-o", "end.xyz"]);
    assert!(exported.status.success(), "{}", stdout(&exported));
    assert!(stderr(&exported).contains("bonds between the grains are not written"), "{}", stderr(&exported));
    // A damaged list of bonds is told by the digests of the run.
    let path = here.join("run/snapshots/end.bonds");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, &text[..text.len() / 2]).unwrap();
    assert!(refused(here, 1, &["digest", "run"]).contains("end.bonds"));
}

/// A bonded sample goes through a data file of LAMMPS into another run, with the same pairs; types of bonds are chosen by table.
#[test]
fn bonds_go_through_a_lammps_data_file() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), bonded()).unwrap();
    done(here, &["run", "case.toml", "--out", "run"]);
    let exported = run(here, &["export", "run", "--snapshot", "end", "-o", "end.data"]);
    assert!(exported.status.success() && stderr(&exported).is_empty(), "{}", stderr(&exported));
    let text = std::fs::read_to_string(here.join("end.data")).unwrap();
    let count = |word: &str| {
        let line = text.lines().find(|line| line.ends_with(word)).unwrap_or_default();
        line.split(' ').next().and_then(|number| number.parse::<usize>().ok()).unwrap_or_default()
    };
    let bonds = count(" bonds");
    assert!(bonds > 10 && count(" bond types") == 1, "{text}");
    let of_file = bonded().replace("largest_gap = 0.02\n", "places = \"file\"\n");
    std::fs::write(here.join("of-file.toml"), &of_file).unwrap();
    done(here, &["run", "of-file.toml", "--packing", "end.data", "--out", "again"]);
    // The pairs are those of the file: of the bonds that hold at the end, and of those that ruptured.
    let section = text.split("\nBonds\n\n").nth(1).unwrap_or_default();
    let ordered = |[i, j]: [u64; 2]| [i.min(j), i.max(j)];
    let row = |row: &str| {
        let words: Vec<u64> = row.split(' ').filter_map(|word| word.parse().ok()).collect();
        ordered([words[2], words[3]])
    };
    let mut listed: Vec<[u64; 2]> = section.lines().map(row).collect();
    listed.sort_unstable();
    assert_eq!(listed.len(), bonds);
    let end = std::fs::read_to_string(here.join("again/snapshots/end.bonds")).unwrap();
    let end: serde_json::Value = serde_json::from_str(&end).unwrap();
    let list = |name: &str| end[name].as_array().cloned().unwrap_or_default();
    let number = |value: &serde_json::Value| value.as_u64().unwrap();
    // Grains are spheres, so that the index of a piece is the id of its grain less one.
    let holding = list("bonds").into_iter().map(|bond| [number(&bond["i"]) + 1, number(&bond["j"]) + 1]);
    let broken = list("broken_bonds").into_iter().map(|bond| [0, 1].map(|k| number(&bond["bodies"][k])));
    let mut made: Vec<[u64; 2]> = holding.chain(broken).map(ordered).collect();
    made.sort_unstable();
    assert_eq!(made, listed);
    // Types are those of the tables that made the bonds, also on the way back.
    let types = |text: &str| {
        let rows = text.split("\nBonds\n\n").nth(1).unwrap_or_default().trim_end().lines();
        let pair = |row: &str| {
            let words: Vec<u64> = row.split(' ').filter_map(|word| word.parse().ok()).collect();
            (ordered([words[2], words[3]]), words[1])
        };
        rows.map(pair).collect::<std::collections::BTreeMap<_, _>>()
    };
    let split: String = text
        .replace("1 bond types", "2 bond types")
        .split_inclusive('\n')
        .enumerate()
        .map(|(k, line)| match line.split_once(" 1 ") {
            Some((id, rest)) if rest.split(' ').count() == 2 && k % 2 == 0 => format!("{id} 2 {rest}"),
            _ => line.to_string(),
        })
        .collect();
    std::fs::write(here.join("split.data"), &split).unwrap();
    let table = |kind: u32| format!("[[bond]]\nplaces = \"file\"\ntype = {kind}\nmodulus = \"1 GPa\"\n");
    let head = bonded().split("[[bond]]").next().unwrap_or_default().to_string();
    std::fs::write(here.join("two-types.toml"), head + &table(1) + &table(2)).unwrap();
    done(here, &["run", "two-types.toml", "--packing", "split.data", "--out", "two-types"]);
    done(here, &["export", "two-types", "--snapshot", "end", "-o", "two-types.data"]);
    let after = types(&std::fs::read_to_string(here.join("two-types.data")).unwrap());
    assert_eq!(after, types(&split));
    assert!(after.values().any(|kind| *kind == 2) && after.values().any(|kind| *kind == 1));
    // Bonds that no table makes are not passed over in silence.
    std::fs::write(here.join("bare.toml"), SMALL).unwrap();
    let bare = run(here, &["run", "bare.toml", "--packing", "end.data", "--out", "bare"]);
    assert!(stderr(&bare).contains("bonds, of which none is made in this run"), "{}", stderr(&bare));
    // A format without bonds says so, whoever lists them.
    let bare = run(here, &["export", "end.data", "-o", "end.csv"]);
    assert!(stderr(&bare).contains("bonds between the grains are not written"), "{}", stderr(&bare));
    let told = refused(here, 1, &["run", "of-file.toml", "--packing", "end.csv", "--out", "none"]);
    assert!(told.contains("of none that lists any"), "{told}");
    let told = refused(here, 1, &["run", "of-file.toml", "--out", "none"]);
    assert!(told.contains("of none that lists any"), "{told}");
    std::fs::write(here.join("other.toml"), of_file + "type = 2\n").unwrap();
    let told = refused(here, 1, &["run", "other.toml", "--packing", "end.data", "--out", "none"]);
    assert!(told.contains("type = 2 is none of the types of bonds") && told.contains("it has 1"), "{told}");
    // A pair that is listed twice is refused with its line.
    let row = text.trim_end().lines().last().unwrap_or_default();
    let more = text.replacen(&format!("\n{bonds} bonds"), &format!("\n{} bonds", bonds + 1), 1);
    std::fs::write(here.join("twice.data"), format!("{more}{row}\n")).unwrap();
    let told = refused(here, 1, &["measure", "twice.data"]);
    assert!(told.contains("twice.data:") && told.contains("are bonded already in line"), "{told}");
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
    assert!(deck.contains("bond.law = \"parallel\" cannot be written for LAMMPS"), "{deck}");
}
