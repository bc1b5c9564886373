//! `granum shape`: shapes of cases, meshes and images; and what a run and its report tell about shapes.

use std::path::Path;

use crate::{SMALL, done, done_json, refused};

/// A box from the origin, as an STL file of text.
fn box_stl(lengths: [f64; 3]) -> String {
    let corner =
        |k: usize| -> [f64; 3] { std::array::from_fn(|axis| lengths[axis] * (k >> axis & 1) as f64) };
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid box\n");
    for [a, b, c, d] in faces {
        for triangle in [[a, b, c], [a, c, d]] {
            text.push_str("facet normal 0 0 0\nouter loop\n");
            for [x, y, z] in triangle.map(corner) {
                text.push_str(&format!("vertex {x} {y} {z}\n"));
            }
            text.push_str("endloop\nendfacet\n");
        }
    }
    text + "endsolid box\n"
}

/// A stack of images of 8 bits as an uncompressed TIFF file.
fn stack(size: [usize; 3], label: impl Fn([usize; 3]) -> u8) -> Vec<u8> {
    let [nx, ny, nz] = size;
    let mut bytes = b"II*\0\x08\0\0\0".to_vec();
    for z in 0..nz {
        let tags: [(u16, usize); 8] = [
            (256, nx),
            (257, ny),
            (258, 8),
            (259, 1),
            (262, 1),
            (273, bytes.len() + 2 + 12 * 8 + 4),
            (278, ny),
            (279, nx * ny),
        ];
        let next = if z + 1 < nz { bytes.len() + 2 + 12 * 8 + 4 + nx * ny } else { 0 };
        bytes.extend(8u16.to_le_bytes());
        for (tag, value) in tags {
            bytes.extend(tag.to_le_bytes());
            bytes.extend(4u16.to_le_bytes());
            bytes.extend(1u32.to_le_bytes());
            bytes.extend((value as u32).to_le_bytes());
        }
        bytes.extend((next as u32).to_le_bytes());
        for y in 0..ny {
            bytes.extend((0..nx).map(|x| label([x, y, z])));
        }
    }
    bytes
}

/// A case whose grains are dimers.
fn write_dimers(here: &Path) {
    let case = SMALL.replace("count = 150", "count = 100") + "[grains.shape]\nkind = \"dimer\"\n";
    std::fs::write(here.join("case.toml"), case).unwrap();
}

#[test]
fn the_shapes_of_a_case_are_described() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_dimers(here);
    let text = done(here, &["shape", "case.toml"]);
    let row =
        |name: &str| text.lines().find(|line| line.starts_with(name)).unwrap_or_else(|| panic!("{name}"));
    assert!(row("spheres").ends_with('2') && row("sphericity").ends_with("0.9449"), "{text}");
    assert!(
        row("slope tan(chi) of the widest seam").ends_with("0.2582") && !text.contains("original"),
        "{text}"
    );
    assert!(text.contains("is that of the sphere of equal volume (grains.size_measure)"), "{text}");
    let found = done_json(here, &["shape", "case.toml", "--out", "shape.svg", "--case", "shape.toml"]);
    assert_eq!(
        (found["shapes"][0]["name"].as_str(), found["shapes"][0]["share"].as_f64()),
        (Some("dimer"), Some(1.0))
    );
    assert!(found["shapes"][0]["original_sphericity"].is_null() && found["size_measure"] == "volume");
    let svg = std::fs::read_to_string(here.join("shape.svg")).unwrap();
    assert!(
        roxmltree::Document::parse(&svg).unwrap().descendants().filter(|n| n.has_tag_name("circle")).count()
            > 60
    );
    // What was written is the part of a case with the same shape.
    let again = done_json(here, &["shape", "shape.toml"]);
    let sphericity = |found: &serde_json::Value| found["shapes"][0]["sphericity"].as_f64().unwrap();
    assert!((sphericity(&again) - sphericity(&found)).abs() < 1e-9 && again["shapes"][0]["name"] == "pieces");
    // Keys of the case can be changed, those of grains and no others.
    let longer = done_json(here, &["shape", "case.toml", "--set", "grains.shape.separation=0.9"]);
    assert!(sphericity(&longer) < sphericity(&found) - 0.05, "{longer}");
    let capsule = done_json(here, &["shape", "case.toml", "--set", "grains.shape.kind=tetrapod"]);
    assert_eq!(capsule["shapes"][0]["name"], "tetrapod");
    let message = refused(here, 1, &["shape", "case.toml", "--set", "preparation.friction=0.2"]);
    assert!(message.contains("--set preparation.friction has no effect in this command"), "{message}");
    let message = refused(here, 1, &["shape", "case.toml", "--out", "shape.svg"]);
    assert!(message.contains("shape.svg") && message.contains("--force"), "{message}");
    let message = refused(here, 1, &["shape", "case.toml", "--pieces", "5"]);
    assert!(message.contains("--pieces means nothing with kind = \"dimer\""), "{message}");
}

#[test]
fn a_mesh_becomes_spheres_that_a_case_can_use() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("box.stl"), box_stl([3.0, 2.0, 2.0])).unwrap();
    let message = refused(here, 1, &["shape", "box.stl", "--set", "grains.shape.pieces=12"]);
    assert!(message.contains("--set: ") && message.contains("is no case"), "{message}");
    let made = ["shape", "box.stl", "--pieces", "12", "--out", "box.svg", "--case", "part.toml"];
    let found = done_json(here, &made);
    let shape = &found["shapes"][0];
    let value = |key: &str| shape[key].as_f64().unwrap_or_else(|| panic!("{key}: {shape}"));
    assert!(value("pieces") <= 12.0 && (value("original_volume") - 12.0).abs() < 1e-9);
    let of_box = std::f64::consts::PI.cbrt() * 72f64.powf(2.0 / 3.0) / 32.0;
    assert!(
        (value("original_sphericity") - of_box).abs() < 1e-6,
        "{of_box} {}",
        value("original_sphericity")
    );
    assert!(
        value("volume_error") < 0.0
            && value("volume_error_after_growth").abs() < 1e-9
            && value("growth") > 0.0
    );
    assert!(value("mean_distance") < 0.05 && value("largest_distance") > value("mean_distance"));
    let notices = found["warnings"].as_array().unwrap();
    assert!(
        notices
            .iter()
            .any(|notice| notice.as_str().unwrap().contains("spheres, found with an error of the volume"))
    );
    assert!(
        std::fs::read_to_string(here.join("box.svg")).unwrap().contains("original, along the shortest axis")
    );

    // A case with the mesh is the same as one with its spheres, and its original is told as well.
    std::fs::write(
        here.join("mesh.toml"),
        "[grains.shape]\nkind = \"mesh\"\nfile = \"box.stl\"\npieces = 12\n",
    )
    .unwrap();
    let of_case = done_json(here, &["shape", "mesh.toml"]);
    assert_eq!(of_case["shapes"][0]["mean_distance"], shape["mean_distance"]);
    let case = |name: &str| granum_io::Case::read(here.join(name)).unwrap();
    assert_eq!(case("mesh.toml").digest(), case("part.toml").digest());

    let other = done_json(here, &["shape", "box.stl", "--kind", "mesh-tangent", "--pieces", "30"]);
    assert_eq!(other["shapes"][0]["name"], "mesh-tangent");
}

#[test]
fn each_labelled_grain_of_images_is_a_shape() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    let inside = |[x, y, z]: [usize; 3], centre: f64, [a, b]: [f64; 2]| {
        let part = |at: usize, centre: f64, half: f64| ((at as f64 - centre) / half).powi(2);
        part(x, centre, a) + part(y, 9.0, b) + part(z, 9.0, b) < 1.0
    };
    let label = |place: [usize; 3]| match place {
        _ if inside(place, 9.0, [7.0, 7.0]) => 3,
        _ if inside(place, 27.0, [8.0, 5.0]) => 5,
        _ => 0,
    };
    std::fs::write(here.join("grains.tif"), stack([38, 19, 19], label)).unwrap();
    let made = ["shape", "grains.tif", "--pieces", "10", "--case", "shapes.toml", "--out", "grains.svg"];
    let found = done_json(here, &made);
    let shapes = found["shapes"].as_array().unwrap();
    let names: Vec<&str> = shapes.iter().map(|shape| shape["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["voxels 3", "voxels 5"]);
    let elongation = shapes[1]["elongation"].as_f64().unwrap();
    assert!((elongation - 5.0 / 8.0).abs() < 0.06, "{elongation}");
    let case = granum_io::Case::read(here.join("shapes.toml")).unwrap();
    assert_eq!(case.grains.shapes.iter().map(|entry| entry.share).collect::<Vec<_>>(), [0.5, 0.5]);
}

#[test]
fn what_has_no_shape_is_refused_with_what_would_be_right() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("notes.txt"), "nothing").unwrap();
    let said = |arguments: &[&str]| refused(here, 1, arguments);
    let message = said(&["shape", "notes.txt"]);
    assert!(message.contains("notes.txt") && message.contains(".stl, .obj or .ply (a mesh)"), "{message}");
    assert!(said(&["shape", "missing.stl"]).contains("\"missing.stl\" cannot be read"));
    std::fs::write(here.join("broken.stl"), "solid\nfacet\n").unwrap();
    assert!(said(&["shape", "broken.stl"]).contains("broken.stl"));
    std::fs::write(here.join("box.stl"), box_stl([1.0; 3])).unwrap();
    let message = said(&["shape", "box.stl", "--kind", "dimer"]);
    assert!(message.contains("--kind dimer") && message.contains("mesh-euclidean"), "{message}");
    assert!(said(&["shape", "box.stl", "--pieces", "1"]).contains("--pieces is 1; it must be from 2 to 200"));
    assert!(said(&["shape", "box.stl", "--out", "box.png"]).contains("must end in .svg"));
    std::fs::write(here.join("case.toml"), "[grains]\ncount = 100\n").unwrap();
    assert!(said(&["shape", "case.toml", "--kind", "mesh"]).contains("names the kind of its shapes itself"));
    let found = done_json(here, &["shape", "case.toml"]);
    assert!(found["warnings"][0].as_str().unwrap().contains("its grains are spheres"));
}

#[test]
fn a_run_and_its_report_tell_about_shapes() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    write_dimers(here);
    let told = done(here, &["run", "case.toml", "--out", "run"]);
    let line = "the grains are dimer, with 2 spheres a grain and a sphericity of 0.945; their diameters are those of the \
                spheres of equal volume";
    assert!(told.lines().any(|told| told == line), "{told}");
    assert!(done(here, &["shape", "run"]).contains("dimer"));
    done(here, &["report", "run"]);
    let report = std::fs::read_to_string(here.join("run/report.html")).unwrap();
    assert!(
        report.contains("The shapes of the grains.") && report.contains("along the three principal axes")
    );
    let figures: Vec<String> = (std::fs::read_dir(here.join("run/figures")).unwrap())
        .map(|file| file.unwrap().file_name().to_string_lossy().into_owned())
        .collect();
    assert!(figures.iter().any(|name| name.ends_with("-shapes.svg")), "{figures:?}");
    // The case of a run is its record: shapes of another one would be given for its own.
    let case = here.join("run/case.toml");
    let text = std::fs::read_to_string(&case).unwrap();
    let other =
        |line: &str| if line.starts_with("separation") { "separation = 0.7" } else { line }.to_owned() + "\n";
    std::fs::write(&case, text.lines().map(other).collect::<String>()).unwrap();
    let message = refused(here, 1, &["shape", "run"]);
    assert!(message.contains("the case was changed since the run began"), "{message}");
}
