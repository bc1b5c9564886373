//! Shapes in case files.

use granum_dem::config::Bedding;
use granum_dem::shape::{ShapeEntry, ShapeKind, SizeMeasure};

use super::Case;

fn parse(text: &str) -> Case {
    Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn said(text: &str) -> String {
    Case::parse(text, "case.toml").unwrap_err().to_string()
}

#[test]
fn a_section_makes_all_grains_of_one_shape() {
    let text =
        "[grains]\nsize_measure = 'sieve'\n[grains.shape]\nkind = 'capsule'\naspect_ratio = 2\npieces = 5\n";
    let case = parse(text);
    let capsule = ShapeEntry::new(ShapeKind::CAPSULE).with("aspect_ratio", 2.0).with("pieces", 5.0);
    assert_eq!((&case.grains.shapes[..], case.grains.size_measure), (&[capsule][..], SizeMeasure::Sieve));
    let resolved = case.resolved_toml();
    assert!(
        resolved.contains("[grains.shape]\nkind = \"capsule\"\naspect_ratio = 2\npieces = 5\n"),
        "{resolved}"
    );
    assert_eq!(parse(&resolved), case);
    assert_ne!(case.digest(), Case::default().digest());
    assert_ne!(case.preparation_digest(), Case::default().preparation_digest());
    // A default that is written out is the same case, and a sphere is what grains are anyway.
    let default = parse("[grains.shape]\nkind = 'dimer'\n");
    assert_eq!(parse("[grains.shape]\nkind = 'dimer'\nseparation = 0.5\n").digest(), default.digest());
    assert_eq!(parse("[grains.shape]\nkind = 'sphere'\n"), Case::default());
    assert!(!Case::default().resolved_toml().contains("shape]"));
}

#[test]
fn keys_of_shapes_can_be_set_and_are_parameters_of_a_run() {
    let mut case = Case::default();
    case.set("grains.shape.kind", "dimer").unwrap();
    case.set("grains.shape.separation", "0.8").unwrap();
    case.check().unwrap();
    let parameters = case.parameters();
    let number =
        |key: &str| parameters.iter().find(|known| known.key == key).and_then(|known| known.number());
    assert_eq!(number("grains.shape.separation"), Some(0.8));
    assert!(number("grains.sphericity").is_some_and(|psi| psi > 0.8 && psi < 0.95));
    let of_spheres = Case::default().parameters();
    for word in ["sphericity", "shape", "size_measure", "bedding"] {
        assert!(of_spheres.iter().all(|known| !known.key.contains(word)), "{word}");
    }
    let error = case.set("grains.shape.1.separation", "0.5").unwrap_err().to_string();
    assert!(error.contains("needs the tables [[grains.shape]]"), "{error}");
    // Two whole numbers of spheres are two values.
    assert_eq!(case.shape_of("grains.shape.pieces"), crate::case::ValueShape::Plain);
    assert_eq!(case.shape_of("grains.shape.separation"), crate::case::ValueShape::Number);
    case.set("grains.shape.kind", "sphere").unwrap();
    assert!(case.check().unwrap_err().to_string().contains("separation means nothing"));
}

#[test]
fn several_shapes_are_tables_with_shares_of_the_mass() {
    let text = "[[material]]\nname = 'a'\n[[material]]\nname = 'b'\n[[grains.shape]]\nkind = 'sphere'\nshare = 0.3\n\
                [[grains.shape]]\nkind = 'pieces'\nspheres = [[0, 0, 0, 1], [1.25, 0, 0, 0.5]]\nmaterial = 'a'\n\
                smallest = '0.05 mm'\n";
    let mut case = parse(text);
    let shares: Vec<f64> = case.grains.shapes.iter().map(|entry| entry.share).collect();
    assert_eq!(shares, [0.3, 0.7]);
    assert_eq!(case.grains.shapes[1].spheres[1], [1.25, 0.0, 0.0, 0.5]);
    let resolved = case.resolved_toml();
    assert_eq!(parse(&resolved), case, "{resolved}");
    let digest = case.digest();
    assert_eq!(parse(&resolved).digest(), digest);
    assert_eq!(case.values()["grains.shape.2.material"], "\"a\"");
    case.set("grains.shape.2.spheres", "[[0, 0, 0, 1], [1, 0, 0, 0.5]]").unwrap();
    assert_ne!(case.digest(), digest);
    let error = case.set("grains.shape.3.kind", "dimer").unwrap_err().to_string();
    assert!(error.contains("there are 2, counted from 1"), "{error}");
}

#[test]
fn what_is_wrong_with_a_shape_is_told_at_its_place() {
    let kind = said("[grains.shape]\nkind = 'dimmer'\n");
    assert!(kind.contains("case.toml:2:8: grains.shape.kind = 'dimmer' is not known"), "{kind}");
    let bounds = said("[grains.shape]\nkind = 'dimer'\nseparation = 2\n");
    assert!(bounds.contains("case.toml:3:14: grains.shape.separation = 2 is out of bounds"), "{bounds}");
    let unused = said("[grains.shape]\nkind = 'dimer'\naspect_ratio = 2\n");
    assert!(unused.contains("case.toml:3:1: grains.shape.aspect_ratio means nothing with kind"), "{unused}");
    let whole = said("[grains.shape]\nkind = 'capsule'\npieces = 3.5\n");
    assert!(whole.contains("is not a whole number"), "{whole}");
    let missing = said("[grains.shape]\nkind = 'pieces'\n");
    assert!(missing.contains("grains.shape.spheres is missing"), "{missing}");
    let apart = said("[grains.shape]\nkind = 'pieces'\nspheres = [[0, 0, 0, 1], [5, 0, 0, 1]]\n");
    assert!(apart.contains("are two bodies: sphere 1"), "{apart}");
    let three = said("[grains.shape]\nkind = 'pieces'\nspheres = [[0, 0, 0, 1], [5, 0, 0]]\n");
    assert!(three.contains("value 2 = [5, 0, 0] must be a list of spheres"), "{three}");
    let shares = said("[[grains.shape]]\nshare = 0.5\n[[grains.shape]]\nkind = 'dimer'\nshare = 0.6\n");
    assert!(shares.contains("the shares of the shapes sum to 1.1"), "{shares}");
    let material = said("[[grains.shape]]\nmaterial = 'glass'\n");
    assert!(material.contains("material names \"glass\", which is no material"), "{material}");
    let key = said("[[grains.shape]]\nkinds = 'dimer'\n");
    assert!(key.contains("unknown key grains.shape.1.kinds") && key.contains("did you mean kind?"), "{key}");
    let file = said("[grains.shape]\nkind = 'dimer'\nfile = 'grain.stl'\n");
    assert!(file.contains("grains.shape.file means nothing with kind = \"dimer\""), "{file}");
    let liquid = said(
        "[grains.shape]\nkind = 'dimer'\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\n\
                       tangential = 'no-slip'\nadhesion = 'capillary-bridge-films'\n",
    );
    assert!(liquid.contains("liquid"), "{liquid}");
}

#[test]
fn bedding_is_an_angle_and_a_spread() {
    let case = parse(
        "[grains.shape]\nkind = 'dimer'\n[preparation]\nbedding_tilt = '30 deg'\nbedding_spread = '10 deg'\n",
    );
    let degree = std::f64::consts::PI / 180.0;
    let Some(Bedding { tilt, spread }) = case.preparation.bedding else { panic!("bedding") };
    assert!((tilt / degree - 30.0).abs() < 1e-12 && (spread / degree - 10.0).abs() < 1e-12);
    assert_eq!(parse(&case.resolved_toml()), case);
    let unused = said("[preparation]\nbedding_tilt = '30 deg'\n");
    assert!(unused.contains("preparation.bedding_tilt means nothing for spheres"), "{unused}");
}
