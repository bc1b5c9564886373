//! A packing format: the edges of a cuboid cell in the first line, `x y z radius` in each line after it.

use std::path::Path;

use granum::io::{Error, Result, atomic::write_atomically};
use granum::prelude::*;

pub struct Spheres;

impl PackingFormat for Spheres {
    fn name(&self) -> &'static str {
        "spheres"
    }

    fn extensions(&self) -> &'static [&'static str] {
        &["spheres"]
    }

    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"cell ")
    }

    fn read(&self, path: &Path) -> Result<Packing> {
        let text = std::fs::read_to_string(path).map_err(Error::file("read", path))?;
        let numbers = |line: &str| line.split_whitespace().flat_map(str::parse).collect::<Vec<f64>>();
        let mut lines = text.lines().enumerate();
        let [a, b, c] = lines.next().map_or(vec![], |(_, line)| numbers(line))[..] else {
            return Err(Error::content(path, "line 1 must be: cell A B C"));
        };
        let mut grains = Vec::new();
        for (k, line) in lines {
            let [x, y, z, radius] = numbers(line)[..] else {
                return Err(Error::content(path, format!("line {} must be: X Y Z RADIUS", k + 1)));
            };
            grains.push((PackedGrain { id: k as u64, position: [x, y, z], radius }, k + 1));
        }
        Packing::checked(&path.display().to_string(), [0.0; 3], Cell::cuboid([a, b, c]).edges, grains)
    }

    fn write(&self, path: &Path, packing: &Packing) -> Result<()> {
        let mut text =
            format!("cell {:e} {:e} {:e}\n", packing.cell[0][0], packing.cell[1][1], packing.cell[2][2]);
        for grain in &packing.grains {
            let [x, y, z] = packing.from_corner(grain);
            text += &format!("{x:e} {y:e} {z:e} {:e}\n", grain.radius);
        }
        write_atomically(path, |file| std::io::Write::write_all(file, text.as_bytes()))
    }
}

/// `n^3` spheres of two sizes on a lattice on which they do not touch, to be compacted.
pub fn loose_lattice(n: usize) -> Packing {
    let spacing = 1.25e-4;
    let edge = n as f64 * spacing;
    let grains = (0..n * n * n).map(|k| {
        let place = [k % n, k / n % n, k / (n * n)];
        // Off the lattice by a little, so that it does not crystallise.
        let position = place.map(|at| {
            (at as f64 + 0.5 + 0.18 * ((31 * k * k + 17 * at * (k + 1)) % 101) as f64 / 101.0) * spacing
        });
        PackedGrain { id: k as u64 + 1, position, radius: if k % 2 == 0 { 5e-5 } else { 4.2e-5 } }
    });
    Packing::new([0.0; 3], Cell::cuboid([edge; 3]).edges, grains.collect())
}
