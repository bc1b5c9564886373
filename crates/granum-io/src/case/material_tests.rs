//! Several materials in a case file.

use super::{Case, differences};

const TWO: &str = "\
[grains.material]
interface_energy = 0
[contact]
normal = \"hertz\"
rolling = \"elastic-plastic\"
[[material]]
name = \"glass\"
share = 0.75
[[material]]
name = \"rubber\"
youngs_modulus = \"5 MPa\"
poissons_ratio = 0.49
friction = 0.9
rolling_friction = 0.4
[[pair]]
between = [\"rubber\", \"glass\"]
friction = 0.7
";

fn parse(text: &str) -> Case {
    Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn refused(text: &str) -> String {
    Case::parse(text, "case.toml").unwrap_err().to_string()
}

#[test]
fn a_material_leaves_out_what_is_as_in_the_sections() {
    let case = parse(TWO);
    let mixture = &case.grains.mixture;
    let [glass, rubber] = mixture.components.as_slice() else { panic!("{mixture:?}") };
    assert_eq!((glass.name.as_str(), glass.share, rubber.share), ("glass", 0.75, 0.25));
    assert_eq!(glass.material, case.grains.material);
    assert_eq!(rubber.material.youngs_modulus, 5e6);
    assert_eq!((rubber.material.density, rubber.material.friction), (2650.0, 0.9));
    assert_eq!(rubber.parameters.given("rolling_friction"), Some(0.4));
    assert!(glass.parameters.is_empty());
    assert_eq!(mixture.rule("glass", "rubber").unwrap().friction, Some(0.7));
    let pair = case.properties().pair(["glass", "rubber"], [5e-5; 2]).unwrap();
    assert_eq!(pair.friction, 0.7);
    case.check().unwrap();
}

/// A value that equals the default of its law is given all the same: `[contact]` may have another one.
#[test]
fn a_default_that_a_material_or_a_pair_gives_is_kept() {
    let text = |contact: &str, glass: &str, pair: &str| {
        format!(
            "[contact]\nrolling = \"elastic-plastic\"\n{contact}[[material]]\nname = \"glass\"\n{glass}\
             [[material]]\nname = \"rubber\"\n[[pair]]\nbetween = [\"glass\", \"rubber\"]\nfriction = 0.7\n{pair}"
        )
    };
    let (other, default) = ("rolling_friction = 0.3\n", "rolling_friction = 0.1\n");
    let case = parse(&text(other, default, default));
    let rolling = |case: &Case, key: &str| {
        let all = case.parameters();
        all.iter().find(|found| found.key == key).and_then(|found| found.number())
    };
    assert_eq!(rolling(&case, "contact.rolling_friction"), Some(0.3));
    assert_eq!(rolling(&case, "material.glass.rolling_friction"), Some(0.1));
    assert_eq!(rolling(&case, "material.rubber.rolling_friction"), Some(0.3));
    assert_eq!(rolling(&case, "pair.glass.rubber.rolling_friction"), Some(0.1));
    assert_eq!(parse(&case.resolved_toml()), case);
    assert_ne!(case.digest(), parse(&text(other, "", default)).digest());
    assert_ne!(case.digest(), parse(&text(other, default, "")).digest());
    // Where everything has the default, writing it out is the same case.
    assert_eq!(parse(&text("", default, default)).digest(), parse(&text("", "", "")).digest());
    assert_eq!(parse(&text(default, default, "")).digest(), parse(&text("", "", "")).digest());
}

#[test]
fn the_resolved_case_reads_back_and_the_order_of_tables_does_not_matter() {
    let case = parse(TWO);
    let back = parse(&case.resolved_toml());
    assert_eq!(back, case);
    assert_eq!(back.digest(), case.digest());
    let (head, tables) = TWO.split_at(TWO.find("[[material]]").unwrap());
    let second = tables[1..].find("[[material]]").unwrap() + 1;
    let pair = tables.find("[[pair]]").unwrap();
    let swapped = format!("{head}{}{}{}", &tables[second..pair], &tables[..second], &tables[pair..]);
    assert_ne!(swapped, TWO);
    assert_eq!(parse(&swapped), case);
}

#[test]
fn materials_are_part_of_the_digests_and_of_comparisons() {
    let case = parse(TWO);
    let mut other = case.clone();
    other.set("material.rubber.friction", "0.8").unwrap();
    other.set("pair.rubber.glass.rolling_friction", "0.2").unwrap();
    assert_ne!(other.digest(), case.digest());
    assert_ne!(other.preparation_digest(), case.preparation_digest());
    let found = differences(&[("one", &case.values()), ("two", &other.values())]);
    let shown: Vec<String> = found.iter().map(ToString::to_string).collect();
    assert_eq!(
        shown,
        [
            "material.rubber.friction: 0.9 in one; 0.8 in two",
            "pair.glass.rubber.rolling_friction: not given in one; 0.2 in two",
        ]
    );
    assert_eq!(other.grains.mixture.rule("glass", "rubber").unwrap().friction, Some(0.7));
    let unknown = other.set("material.ruber.friction", "1").unwrap_err().to_string();
    assert!(unknown.contains("did you mean rubber?"), "{unknown}");
    let key = other.set("material.rubber.frction", "1").unwrap_err().to_string();
    assert!(key.contains("did you mean friction?"), "{key}");
    let none = Case::default().set("material.rubber.friction", "1").unwrap_err().to_string();
    assert!(none.contains("needs the tables [[material]]"), "{none}");
}

#[test]
fn shares_are_completed() {
    let shares = |text: &str| -> Vec<f64> {
        parse(text).grains.mixture.components.iter().map(|component| component.share).collect()
    };
    assert_eq!(shares("[[material]]\nname = \"a\"\n[[material]]\nname = \"b\"\n"), [0.5, 0.5]);
    assert_eq!(shares("[[material]]\nname = \"a\"\n"), [1.0]);
}

#[test]
fn mistakes_are_told_with_their_place_and_remedy() {
    let said = |text: &str, wanted: &[&str]| {
        let found = refused(text);
        for wanted in wanted {
            assert!(found.contains(wanted), "{wanted}\nis not in\n{found}");
        }
    };
    said("material = 3\n", &["case.toml:1:12: material = 3 is not a list of tables", "write [[material]]"]);
    said("[[material]]\nshare = 1\n", &["case.toml:1:1: material.1 has no name", "name = \"glass\""]);
    said(
        "[[material]]\nname = \"a b\"\n",
        &["case.toml:2:8: material.1.name = \"a b\" must be text of letters"],
    );
    said(
        "[[material]]\nname = \"a\"\nfrction = 0.1\n",
        &["case.toml:3:1: unknown key material.1.frction", "did you mean friction?"],
    );
    said(
        "[[material]]\nname = \"a\"\ndensity = \"2 m\"\n",
        &["case.toml:3:11: material.1.density = \"2 m\" is a length", "e.g. density = \"2650 kg/m3\""],
    );
    said(
        "contact.normal = \"rough-hertz\"\npreparation.interface_energy = \"1 J/m2\"\n",
        &["case.toml:2:13: preparation.interface_energy has no effect with contact.normal = \"rough-hertz\""],
    );
    said(
        "[[material]]\nname = \"a\"\nrolling_friction = 0.1\n",
        &["case.toml:3:1: material.1.rolling_friction has no effect with contact.normal"],
    );
    let two = "[[material]]\nname = \"a\"\nshare = 0.5\n[[material]]\nname = \"b\"\n";
    said(&format!("{two}share = 0.6\n"), &["case.toml:6:9: the shares of the materials sum to 1.1"]);
    said(
        &two.replace("\"b\"", "\"a\""),
        &["material.2.name = \"a\" is already the name of another material"],
    );
    said(&two.replace("0.5", "1"), &["material.2 has no share, and nothing is left for it"]);
    said(
        &format!("{two}[[material]]\nname = \"c\"\n"),
        &["material.3 has no share, and neither has another material"],
    );
    said(
        &format!("{two}[[pair]]\nbetween = [\"a\", \"bb\"]\n"),
        &["case.toml:7:17: pair.1.between names \"bb\", which is not a material", "did you mean b?"],
    );
    said(&format!("{two}[[pair]]\nbetween = \"a\"\n"), &["pair.1.between = \"a\" is not a pair of names"]);
    said(&format!("{two}[[pair]]\nfriction = 1\n"), &["pair.1 does not name its two materials"]);
    said(
        &format!("{two}[[pair]]\nbetween = [\"a\", \"b\"]\n[[pair]]\nbetween = [\"b\", \"a\"]\n"),
        &["case.toml:9:12: pair.2 sets the pair of"],
    );
    said(
        &format!("{two}[[pair]]\nbetween = [\"a\", \"b\"]\ndensity = 1\n"),
        &["unknown key pair.1.density", "known here: friction, interface_energy"],
    );
    said(
        "[[pair]]\nbetween = [\"a\", \"b\"]\n",
        &["which is not a material", "add [[material]] with this name"],
    );
}

/// Adhesion of one of the materials beyond the theory of small contacts.
#[test]
fn too_much_adhesion_of_a_material_is_refused() {
    let soft = "[[material]]\nname = \"a\"\n[[material]]\nname = \"b\"\nyoungs_modulus = \"10 kPa\"\n";
    let found = refused(soft);
    assert!(found.contains("would hold the smallest grains together up to"), "{found}");
}
