//! The line of a packing file that gives the periodic cell.

use granum_core::geometry::{Matrix, Vector, determinant, invert};

use std::path::Path;

use crate::error::Result;
use crate::formats::FrameCell;
use crate::sheet::{Sheet, Sought};
use granum_core::quantity::format_number;

/// An example of such a line.
pub(super) const EXAMPLE: &str =
    "the first line must be like \"# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=1e-3 yhi=1e-3 zhi=1e-3\"";

const BOX: [&str; 6] = ["xlo", "ylo", "zlo", "xhi", "yhi", "zhi"];
const TILT: [&str; 3] = ["xy", "xz", "yz"];
const CELL: [&str; 12] = ["ox", "oy", "oz", "ax", "ay", "az", "bx", "by", "bz", "cx", "cy", "cz"];

/// Origin and edges, if the comment that begins at a byte of the file gives the cell.
pub(super) fn parse(sheet: &Sheet, at: usize, line: &str) -> Result<Option<(Vector, Matrix)>> {
    let comment = line.trim_start().trim_start_matches('#').trim_start();
    let tilted = comment.starts_with("periodic box");
    if !tilted && !comment.starts_with("periodic cell") {
        return Ok(None);
    }
    let wrong = |message: String| sheet.error(at..at + line.len(), message).with_help(EXAMPLE);
    let known: Vec<&str> = if tilted { BOX.into_iter().chain(TILT).collect() } else { CELL.to_vec() };
    let mut values: Vec<Option<f64>> = vec![None; known.len()];
    for pair in comment.split_whitespace().filter(|word| word.contains('=')) {
        let (name, text) = pair.split_once('=').unwrap_or((pair, ""));
        let at = known
            .iter()
            .position(|k| *k == name)
            .ok_or_else(|| wrong(format!("unknown value {name} of the cell")))?;
        let value = text.parse().ok().filter(|value: &f64| value.is_finite());
        values[at] = Some(value.ok_or_else(|| wrong(format!("{pair} is not a finite number")))?);
    }
    let value = |name: &str| {
        let at = known.iter().position(|k| *k == name);
        at.and_then(|at| values[at]).or(TILT.contains(&name).then_some(0.0))
    };
    let mut numbers = [0.0; 12];
    for (number, name) in numbers.iter_mut().zip(&known) {
        *number = value(name).ok_or_else(|| wrong(format!("the value {name} of the cell is missing")))?;
    }
    let (origin, edges) = if tilted { from_box(&numbers) } else { from_edges(&numbers) };
    let volume = determinant(&edges);
    let inverse = invert(&edges);
    if !(volume > 0.0 && volume.is_finite()) || inverse.iter().flatten().any(|x| !x.is_finite()) {
        return Err(wrong(format!("the cell has the volume {volume:e} m3; it must be positive")).into());
    }
    Ok(Some((origin, edges)))
}

/// True if the beginning of a file has a line that gives the cell.
pub(crate) fn is_given(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    text.lines().map(str::trim_start).any(|line| {
        line.trim_start_matches(['\u{feff}', '"'])
            .strip_prefix('#')
            .is_some_and(|comment| comment.trim_start().starts_with("periodic "))
    })
}

/// The cell that comments give, and the names of the columns of a CSV.
pub(crate) fn cell_and_names(path: &Path) -> Result<(Option<FrameCell>, Vec<String>)> {
    let sheet = Sheet::open(path, &Sought::NOTHING)?;
    let cell =
        cell_of(&sheet, sheet.comments_before_header())?.map(|(origin, edges)| FrameCell { origin, edges });
    Ok((cell, sheet.header().to_vec()))
}

/// Origin and edges of the cell that comments give; the last of them counts.
pub(super) fn cell_of<'a>(
    sheet: &Sheet,
    comments: impl Iterator<Item = (usize, &'a str)>,
) -> Result<Option<(Vector, Matrix)>> {
    let mut found = None;
    for (at, text) in comments {
        found = parse(sheet, at, text)?.or(found);
    }
    Ok(found)
}

fn from_box(n: &[f64; 12]) -> (Vector, Matrix) {
    let length: Vector = std::array::from_fn(|a| n[3 + a] - n[a]);
    ([n[0], n[1], n[2]], [[length[0], n[6], n[7]], [0.0, length[1], n[8]], [0.0, 0.0, length[2]]])
}

fn from_edges(n: &[f64; 12]) -> (Vector, Matrix) {
    ([n[0], n[1], n[2]], std::array::from_fn(|row| std::array::from_fn(|edge| n[3 + 3 * edge + row])))
}

/// The line for a cell: a box, if adding origin and length gives exactly the same length back, otherwise its edges.
pub(super) fn text(origin: &Vector, cell: &Matrix) -> String {
    let high: Vector = std::array::from_fn(|a| origin[a] + cell[a][a]);
    let upper = cell[1][0] == 0.0 && cell[2][0] == 0.0 && cell[2][1] == 0.0;
    let exact = (0..3).all(|a| high[a] - origin[a] == cell[a][a]);
    let (kind, names, numbers) = if upper && exact {
        let tilt = [cell[0][1], cell[0][2], cell[1][2]];
        let numbers: Vec<f64> = origin.iter().chain(&high).chain(&tilt).copied().collect();
        ("box", BOX.into_iter().chain(TILT).collect::<Vec<_>>(), numbers)
    } else {
        let edges = (0..3).flat_map(|edge| (0..3).map(move |row| cell[row][edge]));
        ("cell", CELL.to_vec(), origin.iter().copied().chain(edges).collect())
    };
    let tilted = numbers.iter().skip(6).any(|tilt| *tilt != 0.0);
    let shown = if kind == "box" && !tilted { 6 } else { names.len() };
    let pairs: Vec<String> = names
        .iter()
        .zip(&numbers)
        .take(shown)
        .map(|(name, x)| format!("{name}={}", format_number(*x)))
        .collect();
    format!("# periodic {kind}, m: {}", pairs.join(" "))
}
