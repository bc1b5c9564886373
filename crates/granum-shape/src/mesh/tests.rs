use std::path::{Path, PathBuf};

use granum_core::assembly::Vector;

use super::*;
use crate::directions::directions;

/// The corners of a cube and its triangles, outwards.
pub(crate) fn cube(corner: Vector, edge: f64) -> TriangleMesh {
    let vertices = (0..8)
        .map(|k| [k & 1, k >> 1 & 1, k >> 2 & 1])
        .map(|b| std::array::from_fn(|a| corner[a] + edge * f64::from(b[a])));
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let halves = squares.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
    TriangleMesh { vertices: vertices.collect(), triangles: halves.collect() }
}

/// An ellipsoid of these semi-lengths.
pub(crate) fn ellipsoid(semi_lengths: Vector, level: usize) -> TriangleMesh {
    let spread = directions(level);
    let place = |u: &Vector| std::array::from_fn(|a| semi_lengths[a] * u[a]);
    TriangleMesh { vertices: spread.units.iter().map(place).collect(), triangles: spread.triangles.clone() }
}

fn join(mut first: TriangleMesh, second: &TriangleMesh) -> TriangleMesh {
    let shift = first.vertices.len();
    first.vertices.extend(&second.vertices);
    first.triangles.extend(second.triangles.iter().map(|t| t.map(|k| k + shift)));
    first
}

fn inverted(mut mesh: TriangleMesh) -> TriangleMesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    mesh
}

fn check(mesh: TriangleMesh) -> Result<(TriangleMesh, Vec<String>), String> {
    let mut notices = Vec::new();
    match checked(mesh, Path::new("grain.stl"), &mut notices) {
        Ok(mesh) => Ok((mesh, notices)),
        Err(why) => {
            assert!(why.message.starts_with("file \"grain.stl\" "), "{why}");
            Err(why.message)
        }
    }
}

fn refused(mesh: TriangleMesh, text: &str) {
    let message = check(mesh).expect_err(text);
    assert!(message.contains(text), "{message}");
}

pub(crate) fn text_stl(mesh: &TriangleMesh) -> String {
    let mut text = String::from("solid grain\n");
    for k in 0..mesh.triangles.len() {
        text += "facet normal 0 0 0\n outer loop\n";
        for [x, y, z] in mesh.corners(k) {
            text += &format!("  vertex {x} {y} {z}\n");
        }
        text += " endloop\nendfacet\n";
    }
    text + "endsolid grain\n"
}

pub(crate) fn binary_stl(mesh: &TriangleMesh) -> Vec<u8> {
    let mut bytes = b"solid that is binary".to_vec();
    bytes.resize(80, 0);
    bytes.extend((mesh.triangles.len() as u32).to_le_bytes());
    for k in 0..mesh.triangles.len() {
        bytes.extend([0; 12]);
        bytes.extend(mesh.corners(k).iter().flatten().flat_map(|x| (*x as f32).to_le_bytes()));
        bytes.extend([0; 2]);
    }
    bytes
}

pub(crate) fn obj(mesh: &TriangleMesh) -> String {
    let corners = mesh.vertices.iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = mesh.triangles.iter().map(|t| format!("f {} {} {}\n", t[0] + 1, t[1] + 1, t[2] + 1));
    corners.chain(faces).collect()
}

pub(crate) fn ply(mesh: &TriangleMesh) -> String {
    let head = format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.vertices.len(),
        mesh.triangles.len()
    );
    let corners = mesh.vertices.iter().map(|[x, y, z]| format!("{x} {y} {z} 7\n"));
    let faces = mesh.triangles.iter().map(|t| format!("3 {} {} {}\n", t[0], t[1], t[2]));
    head + &corners.chain(faces).collect::<String>()
}

fn file(folder: &tempfile::TempDir, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, bytes).unwrap();
    path
}

/// Row A8 of the list of known faults: a cube of 1 mm that is 10 m away, in a file of text.
#[test]
fn moments_far_from_the_origin_keep_their_digits() {
    let folder = tempfile::tempdir().unwrap();
    let far = cube([10.0; 3], 1e-3);
    for (name, bytes) in [("a.stl", text_stl(&far)), ("a.obj", obj(&far)), ("a.ply", ply(&far))] {
        let mesh = read(&file(&folder, name, bytes), &mut Vec::new()).unwrap();
        let found = moments(&mesh);
        let inertia = found.inertia_over_volume();
        for a in 0..3 {
            let moment = inertia[a][a] * found.volume;
            assert!((moment / 1.6666666666667e-16 - 1.0).abs() < 1e-9, "{name}: {moment}");
            assert!((found.centre[a] - 10.0005).abs() < 1e-12, "{name}");
        }
        assert!((found.surface / 6e-6 - 1.0).abs() < 1e-9, "{name}");
    }
}

#[test]
fn all_formats_are_the_same_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = ellipsoid([1.0, 0.75, 0.5], 2);
    let golden = moments(&mesh);
    let files = [
        file(&folder, "a.stl", text_stl(&mesh)),
        file(&folder, "b.STL", binary_stl(&mesh)),
        file(&folder, "c.obj", obj(&mesh)),
        file(&folder, "d.ply", ply(&mesh)),
    ];
    for path in files {
        let mut notices = Vec::new();
        let read = read(&path, &mut notices).unwrap();
        assert_eq!((read.vertices.len(), read.triangles.len()), (162, 320), "{path:?}");
        assert!((moments(&read).volume / golden.volume - 1.0).abs() < 1e-6, "{path:?}");
        assert!(notices.is_empty(), "{notices:?}");
    }
}

/// Row A9: inside out, without a face, two shells, and the centre of the body rather than of its corners.
#[test]
fn meshes_that_are_no_body_are_mended_or_refused() {
    let unit = || cube([0.0; 3], 1.0);
    let (mesh, notices) = check(inverted(unit())).unwrap();
    assert!(notices[0].contains("was inside out"), "{notices:?}");
    let found = moments(&mesh);
    assert!(
        (found.volume - 1.0).abs() < 1e-14 && (found.inertia_over_volume()[0][0] - 1.0 / 6.0).abs() < 1e-14
    );
    let mut open = unit();
    open.triangles.truncate(10);
    refused(open, "is not closed: it has 4 open edges");
    refused(join(unit(), &cube([0.5, 0.0, 0.0], 1.0)), "2 separate shells");
    refused(join(unit(), &inverted(cube([0.25; 3], 0.5))), "2 separate shells");
    let mut fine = unit();
    for k in 0..49 {
        // A triangle of the first face becomes three.
        let t = if k < 1 { 0 } else { fine.triangles.len() - 1 };
        let corners = fine.corners(t);
        fine.vertices.push(std::array::from_fn(|a| corners.iter().map(|c| c[a]).sum::<f64>() / 3.0));
        let ([a, b, c], new) = (fine.triangles[t], fine.vertices.len() - 1);
        fine.triangles[t] = [a, b, new];
        fine.triangles.extend([[b, c, new], [c, a, new]]);
    }
    let (fine, _) = check(fine).unwrap();
    let found = moments(&fine);
    assert_eq!(fine.triangles.len(), 12 + 98);
    assert!(found.centre.iter().all(|x| (x - 0.5).abs() < 1e-12), "{:?}", found.centre);
}

#[test]
fn single_faults_are_named() {
    let mut far = cube([0.0; 3], 1.0);
    far.vertices[1][2] = 1e308;
    refused(far, "coordinates must be at most 1e50");
    let unit = || cube([0.0; 3], 1.0);
    let mut one = unit();
    one.triangles[3].swap(0, 1);
    let (mesh, notices) = check(one).unwrap();
    assert!(notices[0].contains("1 triangles that look to the other side"), "{notices:?}");
    assert!((moments(&mesh).volume - 1.0).abs() < 1e-14);
    let mut degenerate = unit();
    degenerate.triangles.push([0, 0, 1]);
    assert!(check(degenerate).unwrap().1[0].contains("1 triangles with two equal corners"));
    let mut nan = unit();
    nan.vertices[2][1] = f64::NAN;
    refused(nan, "has the corner 2 at");
    let mut beyond = unit();
    beyond.triangles[5][2] = 99;
    refused(beyond, "corner that does not exist");
    refused(TriangleMesh::default(), "has no triangles");
    let mut flat = unit();
    flat.vertices.iter_mut().for_each(|p| p[2] = 3.0);
    refused(flat, "is flat: all corners have z = 3");
    // A corner is pushed through the opposite side.
    let mut pushed = ellipsoid([1.0; 3], 2);
    pushed.vertices[0] = pushed.vertices[0].map(|x| -3.0 * x);
    refused(pushed, "crosses itself");
    let doubled = join(unit(), &unit());
    refused(doubled, "edges at which more than two triangles meet");
    let many = TriangleMesh { vertices: vec![[0.0; 3]], triangles: vec![[0; 3]; MOST_TRIANGLES + 1] };
    refused(many, "1000001 triangles or more; decimate it to at most 1000000");
}

#[test]
fn files_that_are_no_meshes_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let said = |name: &str, bytes: &[u8]| {
        let path = file(&folder, name, bytes);
        let message = read(&path, &mut Vec::new()).unwrap_err().message;
        assert!(message.contains(name), "{message}");
        message
    };
    assert!(said("a.txt", b"hello").contains("must end in .stl, .obj or .ply"));
    assert!(said("a.stl", b"hello").contains("is not an STL file"));
    assert!(said("b.stl", &[7; 200]).contains("cut off: it has 200 bytes"));
    assert!(said("c.stl", b"solid x\nendsolid x\n").contains("no triangles"));
    assert!(said("d.stl", b"solid x\nfacet\nvertex 1 2\n").contains("line 3"));
    assert!(said("a.obj", b"hello\nv a b c\n").contains("OBJ"));
    assert!(said("b.obj", b"v 0 0 0\n").contains("no triangles"));
    assert!(said("a.ply", b"hello").contains("PLY"));
    let missing = read(Path::new("/nowhere/grain.stl"), &mut Vec::new()).unwrap_err().message;
    assert!(missing.contains("cannot be read"), "{missing}");
    // A pipe without a writer is never opened and a device never ends: what is not a regular file is refused first.
    #[cfg(unix)]
    {
        let device = folder.path().join("grain.stl");
        std::os::unix::fs::symlink("/dev/zero", &device).unwrap();
        let message = read(&device, &mut Vec::new()).unwrap_err().message;
        assert!(message.contains("regular file"), "{message}");
    }
    let head =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n";
    let face =
        "element face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -2\n";
    assert!(said("b.ply", (head.to_string() + face).as_bytes()).contains("does not exist"));
}

/// Large meshes take seconds at most: checks are not quadratic.
#[test]
fn a_mesh_of_ten_thousand_triangles_is_checked_at_once() {
    let start = std::time::Instant::now();
    let (mesh, _) = check(ellipsoid([1.0, 0.8, 0.6], 5)).unwrap();
    println!("check of {} triangles: {:?}", mesh.triangles.len(), start.elapsed());
    assert!(start.elapsed().as_secs() < 10);
    let tree = Tree::new(&mesh);
    for (x, distance) in [([0.0; 3], 0.6), ([2.0, 0.0, 0.0], 1.0), ([0.0, -3.0, 0.0], 2.2)] {
        assert!((tree.distance(&x) - distance).abs() < 2e-3, "{x:?} {}", tree.distance(&x));
    }
}

/// Damaged files are refused, or read as another mesh, but end no program.
#[test]
fn damaged_files_end_no_program() {
    let mesh = ellipsoid([1.0, 0.75, 0.5], 1);
    let path = Path::new("a.mesh");
    type Parse = fn(&Path, &[u8]) -> Result<TriangleMesh, ShapeError>;
    let files: [(Vec<u8>, Parse); 4] = [
        (text_stl(&mesh).into_bytes(), stl::parse),
        (binary_stl(&mesh), stl::parse),
        (obj(&mesh).into_bytes(), obj::parse),
        (ply(&mesh).into_bytes(), ply::parse),
    ];
    let mut random = crate::random::Random::new(11, 0, 0);
    let mut refused = 0;
    for (bytes, parse) in &files {
        for _ in 0..150 {
            let mut bytes = bytes.clone();
            for _ in 0..1 + random.whole() % 3 {
                let place = (random.whole() % bytes.len() as u64) as usize;
                let head = place % bytes.len().min(400);
                match random.whole() % 5 {
                    0 => bytes.truncate(place.max(1)),
                    1 => bytes[head] = random.whole() as u8,
                    2 => bytes[place] = b"0123456789-. \nevf"[(random.whole() % 17) as usize],
                    3 => bytes.insert(head, b'9'),
                    _ => bytes[place] = random.whole() as u8,
                }
            }
            let read = parse(path, &bytes).and_then(|mesh| checked(mesh, path, &mut Vec::new()));
            refused += usize::from(read.is_err());
        }
    }
    println!("{refused} of 600 damaged files are refused");
    assert!(refused > 100 && refused < 600, "{refused}");
}
