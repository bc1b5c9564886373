//! End-to-end tests of samples with several materials and of wet samples.

use super::{SMALL, digest, done, done_json, refused};

const TWO: &str = "\
[grains.material]
interface_energy = 0
[contact]
normal = \"hertz\"
tangential = \"no-slip\"
";

const GLASS: &str = "[[material]]\nname = \"glass\"\nshare = 0.6\n";
const RUBBER: &str =
    "[[material]]\nname = \"rubber\"\nyoungs_modulus = \"1 GPa\"\ndensity = 1100\nfriction = 0.8\n";
const PAIR: &str = "[[pair]]\nbetween = [\"glass\", \"rubber\"]\nfriction = 0.4\n";

#[test]
fn two_materials_run_to_the_same_bits_on_threads_in_any_order_and_after_a_stop() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let write = |name: &str, tables: &[&str]| {
        std::fs::write(place.join(name), [&[SMALL, TWO], tables].concat().concat()).unwrap();
    };
    write("one.toml", &[GLASS, RUBBER, PAIR]);
    write("two.toml", &[PAIR, RUBBER, GLASS]);
    done(place, &["shear", "one.toml", "--out", "one", "--threads", "1"]);
    done(place, &["shear", "two.toml", "--out", "two", "--threads", "2"]);
    assert_eq!(digest(place, "one"), digest(place, "two"));
    // The case in the folder gives the same results when it is run again.
    done(place, &["shear", "one/case.toml", "--out", "again"]);
    assert_eq!(digest(place, "one"), digest(place, "again"));
    let end = granum_io::snapshot::read_snapshot(&place.join("one/snapshots"), "end").unwrap();
    assert_eq!(end.materials, ["glass", "rubber"]);
    assert_eq!(end.bodies.iter().filter(|grain| grain.material == 0).count(), 90);
    done(place, &["report", "one"]);
    let page = std::fs::read_to_string(place.join("one/report.html")).unwrap();
    assert!(page.contains("rubber") && page.contains("40 % of the grains"));
    // Changing a value of one material gives another case; invalid values are refused, and the message gives the remedy.
    let set = ["--set", "material.rubber.friction=0.2"];
    done(place, &["shear", "one.toml", "--out", "smooth", set[0], set[1]]);
    assert_ne!(digest(place, "one"), digest(place, "smooth"));
    let text =
        refused(place, 1, &["shear", "one.toml", "--out", "x", "--set", "material.ruber.friction=0.2"]);
    assert!(text.contains("did you mean rubber?"), "{text}");
    let text = refused(place, 1, &["pair", "path.csv", "--case", "one.toml"]);
    assert!(text.contains("the case has several materials"), "{text}");
}

#[test]
fn materials_that_are_alike_give_the_series_of_one() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let one = [SMALL, TWO].concat();
    std::fs::write(place.join("one.toml"), &one).unwrap();
    let twice = "[[material]]\nname = \"a\"\n[[material]]\nname = \"b\"\n";
    std::fs::write(place.join("two.toml"), one + twice).unwrap();
    for name in ["one", "two"] {
        done(place, &["shear", &format!("{name}.toml"), "--out", name]);
    }
    let series = |name: &str| granum_io::Run::at(place.join(name)).unwrap().series().unwrap();
    assert_eq!(series("one"), series("two"));
}

#[test]
fn wet_grains_hold_together() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path();
    let wet = [SMALL, TWO, "adhesion = \"capillary-bridge\"\nbridge_volume = 0.001\n"].concat();
    std::fs::write(place.join("wet.toml"), wet).unwrap();
    let told = done_json(place, &["shear", "wet.toml", "--out", "wet"]);
    let gap = told["quality"].to_string();
    let series = granum_io::Run::at(place.join("wet")).unwrap().series().unwrap();
    assert!(series.column("pairs_apart").unwrap().iter().any(|count| *count > 0.0), "{gap}");
    assert!(series.column("attraction_loss").unwrap().last() > Some(&0.0));
    done(place, &["report", "wet"]);
    let page = std::fs::read_to_string(place.join("wet/report.html")).unwrap();
    assert!(page.contains("capillary bridges"));
}
