//! A user-defined packing format: the first line gives the edges of a cuboid cell, and every other line `x y z radius`.

use std::path::Path;

use granum::io::Error;
use granum::prelude::*;

struct Plain;

impl PackingFormat for Plain {
    fn name(&self) -> &'static str {
        "plain spheres"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["spheres"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"cell ")
    }
    fn read(&self, path: &Path) -> granum::io::Result<Packing> {
        let text = std::fs::read_to_string(path).map_err(Error::file("read", path))?;
        let numbers =
            |line: &str| -> Vec<f64> { line.split_whitespace().filter_map(|n| n.parse().ok()).collect() };
        let mut lines = text.lines().enumerate();
        let edges = lines.next().map(|(_, line)| numbers(line)).unwrap_or_default();
        let [a, b, c] = edges[..] else { return Err(Error::content(path, "line 1 must be: cell A B C")) };
        let mut grains = Vec::new();
        for (k, line) in lines {
            let [x, y, z, radius] = numbers(line)[..] else {
                return Err(Error::content(path, format!("line {} must be: X Y Z RADIUS", k + 1)));
            };
            grains.push((PackedGrain { id: k as u64, position: [x, y, z], radius }, k + 1));
        }
        let cell = Cell::cuboid([a, b, c]).edges;
        Packing::checked(&path.display().to_string(), [0.0; 3], cell, grains)
    }
    fn write(&self, path: &Path, packing: &Packing) -> granum::io::Result<()> {
        let [a, b, c] = [0, 1, 2].map(|k| packing.cell[k][k]);
        let lines = packing.grains.iter().map(|grain| {
            let [x, y, z] = packing.from_corner(grain);
            format!("{x:e} {y:e} {z:e} {:e}\n", grain.radius)
        });
        let text: String = std::iter::once(format!("cell {a:e} {b:e} {c:e}\n")).chain(lines).collect();
        granum::io::atomic::write_atomically(path, |file| std::io::Write::write_all(file, text.as_bytes()))
    }
}

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let packing = read_packing(concat!(env!("CARGO_MANIFEST_DIR"), "/../data/packing-5000.csv"))?;
    let formats = Formats::standard().with_packing(Plain)?;
    let file = std::env::temp_dir().join(format!("granum-example-{}.spheres", std::process::id()));
    formats.write_packing(&file, &packing)?;
    let back = formats.read_packing(&file)?;
    std::fs::remove_file(&file)?;
    println!("{} grains, solid fraction {:.4}", back.grains.len(), back.solid_fraction());
    assert_eq!(back.grains.len(), packing.grains.len());
    Ok(())
}
