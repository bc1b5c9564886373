//! Tables `[[bond]]`: reading, writing, digests, and what is refused.

use granum_dem::bond::{BondPlaces, BondRadius, StrengthScatter};

use crate::case::Case;

const CEMENTED: &str = "[grains.material]\ninterface_energy = 0\n[[bond]]\nlaw = \"beam\"\ncement_content = \"2 %\"\n\
                        modulus = \"5 GPa\"\ntensile_strength = \"3 MPa\"\ncohesion = \"6 MPa\"\nfriction_angle = \"20 deg\"\n\
                        scatter = \"weibull\"\nlargest_gap = 0.02\nseed = 7\n";

fn parse(text: &str) -> Case {
    Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

#[test]
fn a_table_comes_to_bonds_and_is_written_and_read_again() {
    let case = parse(CEMENTED);
    let laws = case.vocabulary.laws();
    let bonding = case.bonds[0].bonding(laws);
    assert_eq!(bonding.law.name(), "beam");
    assert_eq!(bonding.radius, BondRadius::Cement { content: 0.02, density: 3100.0 });
    assert_eq!(bonding.scatter, StrengthScatter::Weibull { modulus: 4.0, reference_volume: None });
    assert_eq!((bonding.largest_gap, bonding.seed, case.bonds[0].before_stage()), (0.02, 7, 1));
    assert_eq!(bonding.parameters["tensile_strength"], 3e6);
    assert!((bonding.parameters["friction_angle"] - 20f64.to_radians()).abs() < 1e-15);
    let again = parse(&case.resolved_toml());
    assert_eq!(again.digest(), case.digest());
    assert_eq!(again.bonds[0].bonding(laws), {
        // Defaults are written out.
        let mut all = bonding.clone();
        all.parameters.insert("poissons_ratio".into(), 0.25);
        all.parameters.insert("shear_coefficient".into(), 1.0);
        all.parameters.insert("moment_factor".into(), 1.0);
        all
    });
    // Bonds have no part in the sample, and without them nothing changes.
    let mut without = case.clone();
    without.bonds.clear();
    assert_eq!(without.preparation_digest(), case.preparation_digest());
    assert_ne!(without.digest(), case.digest());
    let endless = parse("[grains.material]\ninterface_energy = 0\n[[bond]]\n");
    assert!(endless.resolved_toml().contains("tensile_strength = inf"));
    assert_eq!(parse(&endless.resolved_toml()).digest(), endless.digest());
}

#[test]
fn keys_are_set_compared_and_listed() {
    let mut case = parse(CEMENTED);
    case.set("bond.1.tensile_strength", "1 MPa").unwrap();
    let laws = case.vocabulary.laws().clone();
    assert_eq!(case.bonds[0].bonding(&laws).parameters["tensile_strength"], 1e6);
    let parameters = case.parameters();
    let of = |key: &str| {
        parameters.iter().find(|parameter| parameter.key == key).map(|p| (p.number(), p.unit.clone()))
    };
    assert_eq!(of("bond.1.tensile_strength"), Some((Some(1e6), "Pa".into())));
    assert_eq!(of("bond.1.cement_density"), Some((Some(3100.0), "kg/m3".into())));
    assert_eq!(of("bond.1.radius"), None);
    assert_eq!(case.unit_of("bond.1.modulus").as_deref(), Some("Pa"));
    let said = |case: &mut Case, key: &str, text: &str| case.set(key, text).unwrap_err().to_string();
    assert!(said(&mut case, "bond.2.modulus", "1 GPa").contains("there are 1, counted from 1"));
    assert!(said(&mut case, "bond.1.modolus", "1 GPa").contains("did you mean modulus?"));
    assert!(said(&mut Case::default(), "bond.1.modulus", "1 GPa").contains("needs a table [[bond]]"));
    let other = parse(&CEMENTED.replace("3 MPa", "4 MPa"));
    let found = crate::case::differences(&[("a", &parse(CEMENTED).values()), ("b", &other.values())]);
    assert_eq!(found[0].to_string(), "bond.1.tensile_strength: 3000000 Pa in a; 4000000 Pa in b");
}

#[test]
fn pairs_of_a_file_are_asked_for_by_type() {
    let case = parse(
        "[grains.material]\ninterface_energy = 0\n[[bond]]\nplaces = \"file\"\ntype = 2\n[[bond]]\nplaces = \"file\"\n",
    );
    let laws = case.vocabulary.laws();
    let of = |k: usize| case.bonds[k].bonding(laws);
    assert_eq!((of(0).places, of(0).kind, of(1).kind), (BondPlaces::Listed, Some(2), None));
    assert_eq!(parse(&case.resolved_toml()).digest(), case.digest());
}

/// The attachment is in no resolved case that does not give it, so that cases from before there was the key keep their digests.
#[test]
fn an_attachment_is_written_where_it_is_given() {
    use granum_dem::bond::BondAttachment;
    let of = |line: &str| parse(&format!("[grains.material]\ninterface_energy = 0\n[[bond]]\n{line}"));
    let bonding = |case: &Case| case.bonds[0].bonding(case.vocabulary.laws());
    let (plain, middle) = (of(""), of("attachment = \"middle\"\n"));
    assert_eq!(bonding(&plain).attachment, BondAttachment::Contact);
    assert_eq!(bonding(&middle).attachment, BondAttachment::Middle);
    assert!(!plain.resolved_toml().contains("attachment"), "{}", plain.resolved_toml());
    assert!(middle.resolved_toml().contains("attachment = \"middle\"\n"), "{}", middle.resolved_toml());
    assert_eq!(parse(&middle.resolved_toml()).digest(), middle.digest());
    assert_ne!(plain.digest(), middle.digest());
}

#[test]
fn mistakes_are_named_with_their_line_and_what_would_be_right() {
    let said = |lines: &str, text: &str| {
        let case = format!("[grains.material]\ninterface_energy = 0\n[[bond]]\n{lines}");
        let message = Case::parse(&case, "case.toml").unwrap_err().to_string();
        assert!(message.contains(text), "{message}");
    };
    said(
        "law = \"glue\"\n",
        "case.toml:4:7: bond.1.law = \"glue\" must be \"parallel\", \"beam\", \"additive\"",
    );
    said("modolus = 1\n", "case.toml:4:1: unknown key bond.1.modolus");
    said("modulus = \"1 m\"\n", "is a length; it must be a stress");
    said("attachment = \"end\"\n", "bond.1.attachment = \"end\" must be \"contact\" or \"middle\"");
    said("radius = 2\n", "bond.1.radius = 2 is out of bounds; it must be from 0.001 to 1");
    said("radius = 0.4\ncement_content = 0.1\n", "bond.1.radius has no effect where cement_content is given");
    said("weibull_modulus = 3\n", "has no effect unless scatter = \"weibull\"");
    said("seed = 3\n", "has no effect where nothing is drawn at random");
    said("before_stage = 2\n", "bond.1.before_stage = 2, but the test has 1 stages");
    said("before_stage = 0\n", "must be a whole number of at least 1");
    said("type = 2\n", "bond.1.type has no effect unless places = \"file\"");
    said("places = \"file\"\ntype = 0\n", "must be a whole number of at least 1");
    said("places = \"file\"\nlargest_gap = 0.1\n", "bond.1.largest_gap has no effect with places = \"file\"");
    said("law = \"beam\"\nstiffness_ratio = 2\n", "unknown key bond.1.stiffness_ratio");
    said("places = \"inside\"\n", "all grains are spheres");
    said("modulus = [1, 2]\n", "must be a single value");
    let sticky = Case::parse("[grains.material]\ninterface_energy = 0.1\n[[bond]]\n", "case.toml")
        .unwrap_err()
        .to_string();
    assert!(
        sticky.contains(
            "case.toml:2:1: bonds hold grains that grains.material.interface_energy attracts already"
        ),
        "{sticky}"
    );
    let list = Case::parse("bond = 3\n", "case.toml").unwrap_err().to_string();
    assert!(list.contains("bond = 3 is not a list of tables"), "{list}");
}
