//! Text files of YADE: `export.text`, `export.textExt` and `SpherePack.save`, with one line per sphere.
//!
//! `export.text` and `textExt` begin with `#format x_y_z_r` (or `id_x_y_z_r_matId` and the like) and contain no cell, which must be
//! given separately: by `--cell`, or by the file of `VTKExporter.exportPeriodicCell`. `SpherePack.save` writes lines `x y z r
//! clump`, before them `##PERIODIC:: lx ly lz` for a periodic packing. Spheres without an id are numbered from 0 in their
//! order, as YADE numbers its bodies, so that the contacts in its files refer to these numbers.

use std::path::Path;

use granum_core::Part;
use granum_core::assembly::Sphere;

use super::column_names;
use super::meanings::{self, Meanings};
use super::result::{Frame, FrameCell, ReadOptions, ResultFormat};
use super::words::{Words, head_lines};
use crate::error::{Error, Result};

/// The format.
pub struct YadeText;

/// Columns of `SpherePack.save`.
const BARE: &str = "x_y_z_r";
/// Names of columns; the mask is passed over.
const COLUMNS: [&str; 9] = ["x", "y", "z", "r", "id", MATERIAL, "mask", CLUMP, CLUMP_ID];
const MATERIAL: &str = "matId";
const CLUMP: &str = "clump";
/// The name that scripts of users give it.
const CLUMP_ID: &str = "clumpId";

impl ResultFormat for YadeText {
    fn name(&self) -> &'static str {
        "YADE text"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["txt", "spheres"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        let lines = head_lines(head);
        lines.first().is_some_and(|line| line.starts_with("#format ") || line.starts_with("##PERIODIC::"))
    }
    fn names_columns(&self) -> bool {
        true
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        if let Some(given) = &options.columns {
            column_names::check(path, given, &column_names::owned(COLUMNS), &[])?;
        }
        let mut words = Words::open(path)?;
        let mut columns: Vec<String> = options.columns.clone().unwrap_or_else(|| split(BARE));
        let mut frame = Frame::default();
        let mut meanings = Vec::new();
        while words.advance_to_text()? {
            if words.word(0) == "##PERIODIC::" {
                frame.cell = Some(periodic(&words)?);
            } else if words.word(0) == "#format" && options.columns.is_some() {
                return Err(words.error("this line names the columns; leave out --columns"));
            } else if words.word(0) == "#format" {
                columns = split(words.word(1));
            } else if !words.word(0).starts_with('#') {
                let grain = grain(&words, &columns, frame.grains.len() as u64)?;
                frame.grains.push(grain);
                frame.lines.push(words.line_number());
                meanings.push(meaning(&words, &columns));
            }
        }
        if frame.grains.is_empty() {
            return Err(Error::content(path, "has no spheres"));
        }
        meanings::note(&mut frame, &meanings, ("clump", -1.0), MATERIAL);
        frame.knows(&[Part::Positions, Part::Radii]);
        Ok(vec![frame])
    }
}

fn split(names: &str) -> Vec<String> {
    names.split(['_', ',']).map(String::from).collect()
}

fn periodic(words: &Words) -> Result<FrameCell> {
    let lengths = [1, 2, 3].map(|at| words.positive(at, "an edge of the cell"));
    let [x, y, z] = lengths;
    Ok(FrameCell::between([0.0; 3], [x?, y?, z?]))
}

/// The clump of a sphere (the fifth word of `SpherePack.save`, -1 for a sphere alone) and its material.
fn meaning(words: &Words, columns: &[String]) -> Meanings {
    let place = |name: &str| columns.iter().position(|column| column == name);
    let is_saved = columns.len() == 4 && words.len() == 5;
    let body = place(CLUMP).or_else(|| place(CLUMP_ID)).or(is_saved.then_some(4));
    Meanings {
        body: body.and_then(|at| words.word(at).parse().ok()),
        kind: place(MATERIAL).map(|at| words.word(at).to_string()),
    }
}

fn grain(words: &Words, columns: &[String], number: u64) -> Result<Sphere> {
    let place = |name: &str| columns.iter().position(|known| known == name);
    let (Some(x), Some(y), Some(z), Some(r)) = (place("x"), place("y"), place("z"), place("r")) else {
        let message = format!("the columns {} have no x, y, z and r", columns.join("_"));
        return Err(words.error(message));
    };
    let id = match place("id") {
        // YADE counts from 0, as do the contacts that it writes.
        Some(at) => words.whole(at, "id")?,
        None => number,
    };
    Ok(Sphere {
        id,
        position: [words.number(x, "x")?, words.number(y, "y")?, words.number(z, "z")?],
        radius: words.positive(r, "r")?,
        ..Sphere::default()
    })
}
