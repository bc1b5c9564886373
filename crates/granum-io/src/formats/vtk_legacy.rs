//! Legacy VTK text files as YADE's `VTKExporter` writes them: `exportSpheres`, `exportContactPoints` and `exportPeriodicCell`.
//!
//! Spheres are points with the scalar `radius`, in the order of their ids from 0. Contact points must be exported with these names:
//! `exportContactPoints(what={'id1': 'i.id1', 'id2': 'i.id2', 'normalForce': 'i.phys.normalForce', 'shearForce':
//! 'i.phys.shearForce', 'normal': 'i.geom.normal'})`; the forces and the normal may be missing. YADE's normal points from
//! the first body to the second, and its forces act on the second. The arrays `velocity` (or `vel`), `angularVelocity`,
//! `mass` and `force` of spheres are read as well. The cell is given by its eight corners.

use std::collections::BTreeMap;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Sphere, Vector};

use super::meanings::{self, Meanings};
use super::result::{FileContact, Frame, FrameCell, ReadOptions, ResultFormat};
use super::words::Words;
use crate::error::{Error, Result};

/// The format.
pub struct VtkLegacy;

impl ResultFormat for VtkLegacy {
    fn name(&self) -> &'static str {
        "legacy VTK of YADE"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["vtk"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        head.starts_with(b"# vtk DataFile")
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let content = Content::read(&mut Words::open(path)?)?;
        content.frame(path).map(|frame| vec![frame])
    }
}

/// What such a file holds: points, and arrays of one or three numbers a point.
struct Content {
    points: Vec<Vector>,
    /// The line of each point.
    lines: Vec<usize>,
    scalars: BTreeMap<String, Vec<f64>>,
    vectors: BTreeMap<String, Vec<Vector>>,
    is_grid: bool,
}

impl Content {
    fn read(words: &mut Words) -> Result<Content> {
        let (points, scalars, vectors) = (Vec::new(), BTreeMap::new(), BTreeMap::new());
        let mut content = Content { points, lines: Vec::new(), scalars, vectors, is_grid: false };
        for what in ["the first line", "a comment", "the kind of the file"] {
            words.need(what)?;
        }
        if words.word(0) != "ASCII" {
            return Err(words.error("only ASCII files of the legacy format can be read"));
        }
        // Number of rows of the arrays that follow.
        let mut rows = 0;
        while words.advance_to_text()? {
            match words.word(0) {
                "DATASET" => content.is_grid = words.word(1) == "UNSTRUCTURED_GRID",
                "POINTS" => {
                    let count = words.count(1, "the number of points")?;
                    content.points.reserve(count.min(1 << 20));
                    while content.points.len() < count {
                        words.need("a point")?;
                        for at in (0..words.len()).step_by(3) {
                            content.points.push(words.vector(at, "a coordinate")?);
                            content.lines.push(words.line_number());
                        }
                    }
                }
                "POINT_DATA" | "CELL_DATA" => rows = words.count(1, "the number of rows")?,
                "SCALARS" => {
                    let name = words.word(1).to_string();
                    words.need("LOOKUP_TABLE")?;
                    let values = read_scalars(words, rows)?;
                    content.scalars.insert(name, values);
                }
                "VECTORS" => {
                    let name = words.word(1).to_string();
                    let values = read_vectors(words, rows)?;
                    content.vectors.insert(name, values);
                }
                // Tensors and the topology of cells and lines say nothing that is needed.
                _ => {}
            }
        }
        Ok(content)
    }

    fn frame(self, path: &Path) -> Result<Frame> {
        if self.scalars.contains_key("radius") {
            return self.spheres(path);
        }
        if self.scalars.contains_key("id1") && self.scalars.contains_key("id2") {
            return self.contacts(path);
        }
        if self.is_grid && self.points.len() == 8 {
            return Ok(Frame { cell: Some(self.cell()), ..Frame::default() });
        }
        let message = "holds neither spheres (with a scalar radius), nor contacts (with the scalars id1 and id2), nor the eight \
                       corners of a cell";
        Err(Error::content(path, message))
    }

    fn spheres(mut self, path: &Path) -> Result<Frame> {
        let count = self.points.len();
        let radii = self.scalar(path, "radius", count)?;
        let grain =
            |k| Sphere { id: k as u64, position: self.points[k], radius: radii[k], ..Sphere::default() };
        let mut frame = Frame { grains: (0..count).map(grain).collect(), ..Frame::default() };
        frame.lines = std::mem::take(&mut self.lines);
        if let Some(k) = radii.iter().position(|radius| *radius <= 0.0) {
            return Err(Error::content(path, format!("sphere {k}: radius = {} must be positive", radii[k])));
        }
        frame.knows(&[Part::Positions, Part::Radii]);
        let optional = |name: &str| self.scalars.get(name).filter(|values| values.len() == count);
        let (bodies, kinds) = (optional("clumpId"), optional("materialId").or(optional("matId")));
        let meaning = |k: usize| Meanings {
            body: bodies.map(|values| values[k]),
            kind: kinds.map(|values| values[k].to_string()),
        };
        let meanings: Vec<Meanings> = (0..count).map(meaning).collect();
        meanings::note(&mut frame, &meanings, ("clumpId", -1.0), "materialId");
        if self.scalars.contains_key("mass") {
            let masses = self.scalar(path, "mass", count)?;
            frame.grains.iter_mut().zip(masses).for_each(|(grain, mass)| grain.mass = mass);
            frame.knows(&[Part::Masses]);
        }
        for (names, part) in [
            (["velocity", "vel"], Part::Velocities),
            (["angularVelocity", "angVel"], Part::Spins),
            (["force", "forceVec"], Part::ResultantForces),
        ] {
            let Some(values) = names.iter().find_map(|name| self.vectors.remove(*name)) else { continue };
            for (grain, value) in frame.grains.iter_mut().zip(values) {
                match part {
                    Part::Velocities => grain.velocity = value,
                    Part::Spins => grain.spin = value,
                    _ => grain.force = value,
                }
            }
            frame.knows(&[part]);
        }
        Ok(frame)
    }

    fn contacts(mut self, path: &Path) -> Result<Frame> {
        let count = self.points.len();
        let (first, second) = (self.scalar(path, "id1", count)?, self.scalar(path, "id2", count)?);
        let mut take = |name: &str| self.vectors.remove(name).filter(|values| values.len() == count);
        let (normal, across, along) = (take("normal"), take("normalForce"), take("shearForce"));
        let pair = |k: usize| {
            let normal = normal.as_ref().map(|values| values[k]);
            let force = across.as_ref().zip(along.as_ref());
            FileContact {
                first: first[k] as u64,
                second: second[k] as u64,
                normal,
                // Both act on the second body.
                force: force.map(|(n, t)| std::array::from_fn(|a| -n[k][a] - t[k][a])),
                ..FileContact::default()
            }
        };
        Ok(Frame { contacts: Some((0..count).map(pair).collect()), ..Frame::default() })
    }

    /// An array of one number a point.
    fn scalar(&mut self, path: &Path, name: &str, count: usize) -> Result<Vec<f64>> {
        let values = self.scalars.remove(name).unwrap_or_default();
        if values.len() == count {
            return Ok(values);
        }
        let message = format!("{name} has {} values for {count} points", values.len());
        Err(Error::content(path, message))
    }

    /// The cell of which YADE writes the corners: the fifth is its own, the edges lead to the eighth, sixth and first.
    fn cell(&self) -> FrameCell {
        let origin = self.points[4];
        let edge = |to: usize| -> Vector { std::array::from_fn(|a| self.points[to][a] - origin[a]) };
        let (x, y, z) = (edge(7), edge(5), edge(0));
        FrameCell { origin, edges: std::array::from_fn(|a| [x[a], y[a], z[a]]) }
    }
}

fn read_scalars(words: &mut Words, rows: usize) -> Result<Vec<f64>> {
    let mut values = Vec::with_capacity(rows.min(1 << 20));
    while values.len() < rows {
        words.need("a value")?;
        for at in 0..words.len() {
            values.push(words.number(at, "a value")?);
        }
    }
    Ok(values)
}

fn read_vectors(words: &mut Words, rows: usize) -> Result<Vec<Vector>> {
    let mut values = Vec::with_capacity(rows.min(1 << 20));
    while values.len() < rows {
        words.need("a vector")?;
        for at in (0..words.len()).step_by(3) {
            values.push(words.vector(at, "a component")?);
        }
    }
    Ok(values)
}
