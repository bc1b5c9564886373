use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use granum_core::Part;
use granum_core::assembly::{Bond, BrokenBond, Contact, Rupture, Sphere};
use serde_json::Value;

use super::*;

/// Two grains that touch and hold, and a third whose bond ruptured.
fn assembly() -> Assembly {
    let sphere = |id, x| Sphere { id, position: [x, 0.5, 0.5], radius: 0.1, mass: 1.0, ..Sphere::default() };
    let cell = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let spheres = [sphere(1, 0.2), sphere(2, 0.4), sphere(3, 0.61)];
    let mut assembly = Assembly { cell, ..Assembly::default() }.with_spheres(spheres);
    let branch = [0.2, 0.0, 0.0];
    assembly.contacts = vec![Contact { i: 0, j: 1, branch, normal_force: 2.0, ..Contact::default() }];
    assembly.bonds = vec![Bond { id: 1, i: 0, j: 1, branch, radius: 0.05, ..Bond::default() }];
    assembly.broken_bonds = vec![BrokenBond {
        id: 2,
        bodies: [2, 3],
        rupture: Rupture::Shear,
        energy: 1.0,
        time: 0.0,
        phase: 0,
        place: [0.505, 0.5, 0.5],
        normal: [1.0, 0.0, 0.0],
        radius: 0.04,
    }];
    assembly
}

fn data(page: &str) -> Value {
    let start = page.split_once("id=\"data\">").unwrap().1;
    serde_json::from_str(start.split_once("</script>").unwrap().0).unwrap()
}

fn numbers(data: &Value, key: &str) -> Vec<i16> {
    let bytes = STANDARD.decode(data[key].as_str().unwrap()).unwrap();
    bytes.chunks(2).map(|two| i16::from_le_bytes([two[0], two[1]])).collect()
}

#[test]
fn grains_forces_bonds_and_cracks_are_where_they_are() {
    let page = page(&assembly(), Parts::all(), &View::default());
    let data = data(&page);
    let near = |found: i16, share: f64| {
        assert!((f64::from(found as u16) / 65535.0 - share).abs() < 1e-4, "{found} {share}")
    };
    let grains = numbers(&data, "grains");
    assert_eq!((data["count"].as_u64(), grains.len()), (Some(3), 15));
    near(grains[5], 0.4);
    near(grains[10], 0.61);
    assert_eq!((data["contacts"].as_u64(), &numbers(&data, "forces")[6..]), (Some(1), &[32767, 0][..]));
    assert_eq!((data["bonds_shown"].as_u64(), &numbers(&data, "bonds")[6..]), (Some(1), &[32767, 0][..]));
    let cracks = numbers(&data, "cracks");
    near(cracks[0], 0.505);
    assert_eq!(&cracks[3..], &[32767, 0, 0, 32767, 32767]);
    assert!(data["note"].as_str().unwrap().contains("1 bonds, 1 broken"), "{}", data["note"]);
    // Nothing comes from elsewhere.
    assert!(!page.contains("http") && !page.contains("src="), "the page asks for something");
}

#[test]
fn titles_and_data_end_no_script_and_stand_for_no_place() {
    let title = "</script><b>__DATA__ & \"more\"";
    let page = page(&assembly(), Parts::all(), &View::default().with(|view| view.title = Some(title.into())));
    assert!(!page.contains("<b>") && page.matches("</script>").count() == 2);
    assert!(page.contains("&lt;b&gt;__DATA__ &amp;"), "the title is changed");
}

#[test]
fn colours_are_those_of_the_grains() {
    let shades = |colour: Colour| {
        let page = page(&assembly(), Parts::all(), &View::default().with(|view| view.colour = colour));
        let data = data(&page);
        let shades: Vec<u16> = numbers(&data, "grains").chunks(5).map(|row| row[4] as u16).collect();
        (shades, data["low"].clone(), data["high"].clone())
    };
    for kind in GrainColour::ALL {
        assert_eq!(GrainColour::named(kind.name()), Some(kind));
        assert_eq!(shades(Colour::Grain(kind)).0.len(), 3);
    }
    assert_eq!(shades(Colour::Grain(GrainColour::Bonds)), (vec![65535, 65535, 0], "0".into(), "1".into()));
    assert_eq!(shades(Colour::Grain(GrainColour::Fragment)).0, [65535, 65535, 0]);
    assert_eq!(shades(Colour::Values(vec![-1.0, 0.0, 1.0])).0, [0, 32768, 65535]);
}

#[test]
fn data_of_other_programs_are_shown_without_what_they_lack() {
    let known: Vec<Part> =
        Part::ALL.into_iter().filter(|part| !matches!(part, Part::Cell | Part::NormalForces)).collect();
    let parts = Parts::new(&known);
    let page = page(&assembly(), parts, &View::default());
    let data = data(&page);
    // The box is that around the grains.
    assert!((data["cell"][0][0].as_f64().unwrap() - 0.61).abs() < 1e-12, "{}", data["cell"]);
    assert_eq!(data["contacts"].as_u64(), Some(0));
    assert!(data["note"].as_str().unwrap().starts_with("1 contacts without forces"));
}
