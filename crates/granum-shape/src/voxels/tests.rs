use std::path::PathBuf;

use std::path::Path;

use tiff::encoder::{TiffEncoder, colortype};

use super::*;
use crate::ShapeDescriptors;
use crate::entry::ShapeEntry;
use crate::family::ShapeKind;

/// A stack whose labels are a function of the centres of the voxels.
pub(crate) fn stack(size: [usize; 3], step: [f64; 3], label: impl Fn([f64; 3]) -> u32) -> LabelledStack {
    let [nx, ny, nz] = size;
    let all = (0..nx * ny * nz).map(|k| [k % nx, k / nx % ny, k / nx / ny]);
    let labels = all.map(|p| label(std::array::from_fn(|a| step[a] * (p[a] as f64 + 0.5)))).collect();
    LabelledStack { size, labels }
}

fn length(x: [f64; 3]) -> f64 {
    granum_core::geometry::length(&x)
}

/// Writes a stack as a file of several images of 8, 16 or 32 bits.
pub(crate) fn write(stack: &LabelledStack, path: &Path, bits: u32) {
    let [nx, ny, _] = stack.size;
    let mut encoder = TiffEncoder::new(std::fs::File::create(path).unwrap()).unwrap();
    for image in stack.labels.chunks_exact(nx * ny) {
        let (w, h) = (nx as u32, ny as u32);
        match bits {
            8 => {
                let image: Vec<u8> = image.iter().map(|l| *l as u8).collect();
                encoder.write_image::<colortype::Gray8>(w, h, &image).unwrap();
            }
            16 => {
                let image: Vec<u16> = image.iter().map(|l| *l as u16).collect();
                encoder.write_image::<colortype::Gray16>(w, h, &image).unwrap();
            }
            _ => encoder.write_image::<colortype::Gray32>(w, h, image).unwrap(),
        }
    }
}

fn file(folder: &tempfile::TempDir, name: &str, stack: &LabelledStack, bits: u32) -> PathBuf {
    let path = folder.path().join(name);
    write(stack, &path, bits);
    path
}

fn entry(path: PathBuf) -> ShapeEntry {
    ShapeEntry { file: Some(path), ..ShapeEntry::new(ShapeKind::VOXELS) }
}

/// Row A10: a sphere of 1 mm in voxels of 20 x 20 x 40 um holds a sphere of 0.48 mm within a voxel; without the spacings 0.24.
#[test]
fn spacings_of_voxels_count() {
    let step = [0.02, 0.02, 0.04];
    let ball = stack([60, 60, 32], step, |[x, y, z]| u32::from(length([x - 0.6, y - 0.6, z - 0.64]) < 0.5));
    let (_, grid) = grains(&ball, step, Path::new("ball.tif"), &mut Vec::new()).unwrap().remove(0);
    let depths = grid.square_distances();
    let inscribed = depths.into_iter().fold(0.0, f64::max).sqrt() - 0.01;
    assert!((inscribed - 0.48).abs() < 0.02, "{inscribed}");
    let folder = tempfile::tempdir().unwrap();
    let path = file(&folder, "ball.tif", &ball, 8);
    let made = |entry: ShapeEntry| ShapeDescriptors::new(&entry.shapes().unwrap()[0]);
    let right = made(entry(path.clone()).with("spacing_z", 2.0));
    assert!((right.elongation - 1.0).abs() < 0.02 && (right.flatness - 1.0).abs() < 0.02, "{right:?}");
    let wrong = made(entry(path));
    assert!(wrong.flatness < 0.6, "{wrong:?}");
}

/// Row A10: x runs along the rows of an image, y down its columns and z from image to image, in a file and in a folder of files.
#[test]
fn axes_are_in_the_right_order() {
    let folder = tempfile::tempdir().unwrap();
    for axis in 0..3 {
        let inside = |p: [f64; 3]| {
            let mut q = p.map(|x| x - 15.0);
            let along: f64 = q[axis];
            q[axis] = along - along.clamp(-6.0, 6.0);
            u32::from(length(q) < 5.0)
        };
        let capsule = stack([30, 30, 30], [1.0; 3], inside);
        let path = file(&folder, &format!("capsule{axis}.tif"), &capsule, 16);
        let images = folder.path().join(format!("images{axis}"));
        std::fs::create_dir(&images).unwrap();
        for (k, image) in capsule.labels.chunks_exact(900).enumerate() {
            let one = LabelledStack { size: [30, 30, 1], labels: image.to_vec() };
            write(&one, &images.join(format!("s{k}.tif")), 8);
        }
        for path in [path, images] {
            assert_eq!(read(&path).unwrap(), capsule, "{path:?}");
            let spheres = ShapeKind::VOXELS.family().shapes(&entry(path)).unwrap();
            let reach =
                |a: usize| spheres[0].iter().map(|(c, _)| c[a]).fold(f64::NEG_INFINITY, f64::max) - 14.5;
            for other in (0..3).filter(|a| *a != axis) {
                assert!(reach(axis) > reach(other) + 2.5, "{axis}: {spheres:?}");
            }
        }
    }
    // Another spacing along y makes an image longer along y.
    let ball = stack([20, 20, 20], [1.0; 3], |p| u32::from(length(p.map(|x| x - 10.0)) < 6.0));
    let entry = entry(file(&folder, "ball.tif", &ball, 8)).with("spacing_y", 3.0);
    let found = ShapeDescriptors::new(&entry.shapes().unwrap()[0]);
    assert!((found.elongation - 1.0 / 3.0).abs() < 0.02 && (found.flatness - 1.0).abs() < 0.05, "{found:?}");
}

/// Each label is a shape; those at the border and small ones are left out with a notice.
#[test]
fn each_label_is_a_shape() {
    let folder = tempfile::tempdir().unwrap();
    let several = stack([60, 40, 40], [1.0; 3], |[x, y, z]| {
        let near =
            |cx: f64, r: [f64; 3]| length([(x - cx) / r[0], (y - 20.0) / r[1], (z - 20.0) / r[2]]) < 1.0;
        match () {
            () if near(14.0, [10.0, 8.0, 6.0]) => 70_000,
            () if near(36.0, [9.0, 9.0, 9.0]) => 5,
            () if near(58.0, [6.0, 6.0, 6.0]) => 9,
            () if near(49.0, [1.5, 1.5, 1.5]) => 11,
            () => 0,
        }
    });
    let (shapes, notices) = entry(file(&folder, "several.tif", &several, 32)).shapes_with_notices().unwrap();
    assert_eq!(shapes.len(), 2);
    let found: Vec<ShapeDescriptors> = shapes.iter().map(ShapeDescriptors::new).collect();
    assert!((found[0].elongation - 1.0).abs() < 0.02, "{found:?}");
    assert!((found[1].elongation - 0.8).abs() < 0.02 && (found[1].flatness - 0.75).abs() < 0.03, "{found:?}");
    assert!(
        notices[0].contains("1 labels are left out, which touch the border of the stack: 9"),
        "{notices:?}"
    );
    assert!(notices[1].contains("which have fewer than 50 voxels: 11"), "{notices:?}");
    assert!(notices[2].contains("2 grains are covered"), "{notices:?}");
}

#[test]
fn what_is_no_stack_of_grains_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let said = |path: PathBuf| {
        let message = entry(path.clone()).shapes().unwrap_err().to_string();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(message.starts_with("file ") && message.contains(&name), "{message}");
        message
    };
    let of = |name: &str, label: &dyn Fn([f64; 3]) -> u32| {
        file(&folder, name, &stack([20, 20, 20], [1.0; 3], label), 8)
    };
    assert!(said(of("none.tif", &|_| 0)).contains("has no labels"));
    let one = said(of("one.tif", &|p| u32::from(p == [9.5; 3])));
    assert!(one.contains("no grain that can be used") && one.contains("(the largest has 1)"), "{one}");
    assert!(said(of("all.tif", &|_| 1)).contains("1 touch the border"));
    let two = |p: [f64; 3]| {
        u32::from(
            length([p[0] - 5.0, p[1] - 10.0, p[2] - 10.0]) < 3.0 || p.iter().all(|x| (*x - 14.5).abs() < 3.0),
        )
    };
    assert!(said(of("two.tif", &two)).contains("has the label 1 in 2 separate parts"));
    let single = stack([20, 20, 1], [1.0; 3], |_| 1);
    assert!(said(file(&folder, "single.tif", &single, 8)).contains("has a single image"));
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("text.tif"), "hello").unwrap();
    assert!(said(path("text.tif")).contains("is not a TIFF file"));
    std::fs::write(path("grain.png"), "hello").unwrap();
    assert!(said(path("grain.png")).contains("must end in .tif or .tiff"));
    std::fs::create_dir(path("empty")).unwrap();
    assert!(said(path("empty")).contains("has no files that end in"));
    std::fs::create_dir(path("unlike")).unwrap();
    write(&single, &path("unlike").join("a1.tif"), 8);
    write(&stack([20, 19, 1], [1.0; 3], |_| 1), &path("unlike").join("a2.tif"), 8);
    assert!(
        entry(path("unlike"))
            .shapes()
            .unwrap_err()
            .to_string()
            .contains("20 x 19 pixels; those before have 20 x 20")
    );
    let mut colours = TiffEncoder::new(std::fs::File::create(path("colours.tif")).unwrap()).unwrap();
    colours.write_image::<colortype::RGB8>(2, 2, &[1; 12]).unwrap();
    assert!(said(path("colours.tif")).contains("coloured image 1"));
    let mut shares = TiffEncoder::new(std::fs::File::create(path("shares.tif")).unwrap()).unwrap();
    shares.write_image::<colortype::Gray32Float>(2, 2, &[0.5; 4]).unwrap();
    assert!(said(path("shares.tif")).contains("whole numbers from 0 of 8, 16 or 32 bits"));
}

/// Damaged files are refused, or read as another stack, but end no program.
#[test]
fn damaged_files_end_no_program() {
    let folder = tempfile::tempdir().unwrap();
    let ball = stack([12, 12, 12], [1.0; 3], |p| u32::from(length(p.map(|x| x - 6.0)) < 4.0));
    let bytes = std::fs::read(file(&folder, "ball.tif", &ball, 16)).unwrap();
    let path = folder.path().join("damaged.tif");
    let mut random = crate::random::Random::new(5, 0, 0);
    let mut refused = 0;
    for _ in 0..200 {
        let mut bytes = bytes.clone();
        for _ in 0..1 + random.whole() % 4 {
            let place = (random.whole() % bytes.len() as u64) as usize;
            match random.whole() % 4 {
                0 => bytes.truncate(place.max(1)),
                1 => bytes[place % 16] = random.whole() as u8,
                _ => bytes[place] = random.whole() as u8,
            }
        }
        std::fs::write(&path, &bytes).unwrap();
        refused += usize::from(entry(path.clone()).shapes().is_err());
    }
    println!("{refused} of 200 damaged stacks are refused");
    assert!(refused > 50 && refused < 200, "{refused}");
}

/// A tag can claim millions of values in a file of a few bytes; memory for them is not made.
#[test]
fn a_tag_takes_no_more_memory_than_its_file_warrants() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("grains.tif");
    std::fs::write(&path, include_bytes!("../../../../fuzz/regressions/voxels/tag-of-many-values")).unwrap();
    let refused = read::read(&path).unwrap_err().to_string();
    assert!(refused.contains("grains.tif") && refused.contains("limits exceeded"), "{refused}");
}
