//! What a page of the viewer holds: places as fractions of a box in whole numbers of 16 bits, little-endian, in base 64.

use std::collections::HashSet;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use granum_core::assembly::{Assembly, Rupture, Vector};
use granum_core::geometry::{Matrix, apply};
use granum_core::{Part, Parts};
use granum_sensors::Observation;
use granum_sensors::force_chains::Chains;
use serde_json::{Value, json};

use super::view::View;

/// The most bonds and the most cracks that are shown, 21 bytes each in the page.
const MOST_BONDS: usize = 20_000;
/// Share of its radius with which a bond is drawn, so that grains are seen between wide bonds.
const DRAWN: f64 = 0.35;

/// Rows of 16-bit numbers.
#[derive(Default)]
struct Rows(Vec<u8>);

impl Rows {
    /// A number between 0 and 1.
    fn fraction(&mut self, x: f64) {
        self.0.extend(((x.clamp(0.0, 1.0) * 65535.0).round() as u16).to_le_bytes());
    }

    /// A number between -1 and 1.
    fn signed(&mut self, x: f64) {
        self.0.extend(((x.clamp(-1.0, 1.0) * 32767.0).round() as i16).to_le_bytes());
    }

    fn text(&self) -> String {
        STANDARD.encode(&self.0)
    }
}

/// The box in which everything is placed, along the axes: the cell may be inclined to either side.
struct Frame {
    origin: Vector,
    lengths: Vector,
    /// Corner and edges of the cell, or of the box around all grains.
    start: Vector,
    cell: Matrix,
}

/// How far something reaches along the axes.
struct Bounds {
    low: Vector,
    high: Vector,
}

impl Default for Bounds {
    fn default() -> Bounds {
        Bounds { low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3] }
    }
}

impl Bounds {
    fn reach(&mut self, place: &Vector, radius: f64) {
        for a in 0..3 {
            self.low[a] = f64::min(self.low[a], place[a] - radius);
            self.high[a] = f64::max(self.high[a], place[a] + radius);
        }
    }
}

impl Frame {
    fn around(assembly: &Assembly, parts: Parts, spheres: &[(Vector, f64)]) -> Frame {
        let (mut start, mut cell) = ([0.0; 3], assembly.cell);
        if !parts.has(Part::Cell) {
            let mut around = Bounds::default();
            spheres.iter().for_each(|(place, radius)| around.reach(place, *radius));
            start = around.low.map(|x| if x.is_finite() { x } else { 0.0 });
            cell = [[0.0; 3]; 3];
            for a in 0..3 {
                cell[a][a] = f64::max(around.high[a] - start[a], 0.0);
            }
        }
        let mut bounds = Bounds::default();
        for corner in 0..8 {
            let edges = [corner & 1, corner >> 1 & 1, corner >> 2 & 1].map(f64::from);
            let place = apply(&cell, edges);
            bounds.reach(&std::array::from_fn(|a| start[a] + place[a]), 0.0);
        }
        spheres.iter().for_each(|(place, _)| bounds.reach(place, 0.0));
        let lengths = std::array::from_fn(|a| f64::max(bounds.high[a] - bounds.low[a], 1e-300));
        Frame { origin: bounds.low, lengths, start, cell }
    }

    /// A place as fractions of the box.
    fn put(&self, rows: &mut Rows, place: &Vector) {
        for a in 0..3 {
            rows.fraction((place[a] - self.origin[a]) / self.lengths[a]);
        }
    }
}

/// The largest of absolute values, or one where all are zero.
fn largest(values: impl Iterator<Item = f64>) -> f64 {
    let most = values.map(f64::abs).fold(0.0, f64::max);
    if most > 0.0 { most } else { 1.0 }
}

/// Lines between two places, as thick as a number says: 16 bytes each.
fn lines(frame: &Frame, lines: &[(Vector, Vector, [f64; 2])]) -> (String, f64) {
    let longest = largest(lines.iter().flat_map(|(_, branch, _)| *branch));
    let mut rows = Rows::default();
    for (place, branch, about) in lines {
        frame.put(&mut rows, place);
        branch.iter().for_each(|x| rows.signed(x / longest));
        about.iter().for_each(|x| rows.signed(*x));
    }
    (rows.text(), longest)
}

/// Numbers as a reader of a scale wants them, with four digits.
fn shown(x: f64) -> String {
    let text = format!("{x:.3e}");
    let exponent = text.split('e').nth(1).and_then(|power| power.parse::<i32>().ok()).unwrap_or(0);
    if !(-4..5).contains(&exponent) {
        return text;
    }
    let text = format!("{x:.*}", (3 - exponent).max(0) as usize);
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// The data of the page.
pub(super) fn content(assembly: &Assembly, parts: Parts, view: &View) -> Value {
    // Of files of another program forces may be unknown: the grains are shown alone.
    let has_forces = parts.has(Part::Contacts) && parts.has(Part::NormalForces);
    let chains =
        if has_forces { Chains::from_observation(&Observation::new(assembly)).chains } else { Vec::new() };
    let spheres = spheres(assembly);
    let frame = Frame::around(assembly, parts, &spheres);
    let mut data = json!({
        "origin": frame.origin,
        "box": frame.lengths,
        "cell": (0..3).map(|edge| frame.cell.map(|row| row[edge])).collect::<Vec<_>>(),
        "start": frame.start,
        "opacity": view.opacity.clamp(0.0, 1.0),
        "forces_shown": view.forces,
        "chains_alone": view.chains,
        "cracks_first": view.cracks,
    });
    let mut add = |more: Value| {
        if let (Value::Object(data), Value::Object(more)) = (&mut data, more) {
            data.extend(more);
        }
    };
    add(grains(assembly, &frame, &spheres, view, &chains));
    let (forces, mut note) = forces(assembly, parts, &frame, has_forces, view.strongest, &chains);
    add(forces);
    if assembly.is_bonded() || !assembly.broken_bonds.is_empty() {
        add(bonds(assembly, &frame));
        note += &format!(
            "; {} bonds, {} broken: cracks are discs, red by tension, violet by shear",
            assembly.bonds.len(),
            assembly.broken_bonds.len()
        );
    }
    add(json!({ "note": note }));
    data
}

/// The spheres of all grains where their grains are, also beyond the cell, with their radii.
fn spheres(assembly: &Assembly) -> Vec<(Vector, f64)> {
    let sphere = |piece: &granum_core::assembly::Piece| {
        let centre = assembly.bodies.get(piece.body).map_or([0.0; 3], |body| body.position);
        (std::array::from_fn(|a| centre[a] + piece.arm[a]), piece.radius)
    };
    assembly.pieces.iter().map(sphere).collect()
}

/// The grains: place, radius and colour of each sphere.
fn grains(
    assembly: &Assembly,
    frame: &Frame,
    spheres: &[(Vector, f64)],
    view: &View,
    chains: &[Vec<usize>],
) -> Value {
    let (label, values) = view.colour.values(assembly, chains);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let (low, high) = if values.is_empty() { (0.0, 0.0) } else { (low, high) };
    let shade = |x: f64| if high > low { (x - low) / (high - low) } else { 0.5 };
    let radius = largest(spheres.iter().map(|(_, radius)| *radius));
    let mut rows = Rows::default();
    for ((place, own), piece) in spheres.iter().zip(&assembly.pieces) {
        frame.put(&mut rows, place);
        rows.fraction(own / radius);
        rows.fraction(values.get(piece.body).map_or(0.5, |x| shade(*x)));
    }
    json!({
        "count": spheres.len(), "grains": rows.text(), "largest": radius,
        "colour": label, "low": shown(low), "high": shown(high),
    })
}

/// The strongest contact forces, and what the page says of them.
fn forces(
    assembly: &Assembly,
    parts: Parts,
    frame: &Frame,
    has_forces: bool,
    strongest: usize,
    chains: &[Vec<usize>],
) -> (Value, String) {
    let all = &assembly.contacts;
    let mut order: Vec<usize> = if has_forces { (0..all.len()).collect() } else { Vec::new() };
    order.sort_by(|a, b| all[*b].normal_force.abs().total_cmp(&all[*a].normal_force.abs()));
    order.truncate(strongest);
    let most = largest(order.first().map(|k| all[*k].normal_force).into_iter());
    let linked: HashSet<[usize; 2]> =
        chains.iter().flat_map(|chain| chain.windows(2)).map(|pair| ordered([pair[0], pair[1]])).collect();
    let tubes: Vec<_> = order
        .iter()
        .filter_map(|k| {
            let contact = &all[*k];
            let [i, j] = assembly.bodies_of(contact)?;
            let of_chain = f64::from(u8::from(linked.contains(&ordered([i, j]))));
            let branch = assembly.branch_of_bodies(contact);
            Some((assembly.bodies[i].position, branch, [contact.normal_force / most, of_chain]))
        })
        .collect();
    let (text, longest) = lines(frame, &tubes);
    let mut radii: Vec<f64> = assembly.pieces.iter().map(|piece| piece.radius).collect();
    radii.sort_by(f64::total_cmp);
    let median = radii.get(radii.len() / 2).copied().unwrap_or(0.0);
    let value = json!({ "contacts": tubes.len(), "forces": text, "longest": longest, "width": 0.6 * median });
    if !has_forces {
        let contacts = format!("{} contacts without forces", all.len());
        return (value, if parts.has(Part::Contacts) { contacts } else { "grains alone".to_string() });
    }
    let members: usize = chains.iter().map(Vec::len).sum();
    let left_out =
        if tubes.len() < all.len() { format!("the {} strongest of ", tubes.len()) } else { String::new() };
    let mut note =
        format!("{left_out}{} contacts, {} force chains of {members} grains", all.len(), chains.len());
    if !tubes.is_empty() {
        note += &format!(
            "; tubes are as thick as their normal force, at most {} N: grey to red in compression, blue in tension, orange in chains",
            shown(most)
        );
    }
    (value, note)
}

fn ordered([i, j]: [usize; 2]) -> [usize; 2] {
    if i <= j { [i, j] } else { [j, i] }
}

/// Bonds that hold as lines, and those that ruptured as discs.
fn bonds(assembly: &Assembly, frame: &Frame) -> Value {
    let widest = largest(assembly.bonds.iter().map(|bond| bond.radius));
    let held: Vec<_> = assembly
        .bonds
        .iter()
        .take(MOST_BONDS)
        .filter_map(|bond| {
            let body = assembly.bodies.get(assembly.body_of(bond.i)?)?;
            let arm = assembly.arm(bond.i);
            let place = std::array::from_fn(|a| body.position[a] + arm[a]);
            Some((place, bond.branch, [bond.radius / widest, 0.0]))
        })
        .collect();
    let (text, longest) = lines(frame, &held);
    let broken = &assembly.broken_bonds;
    let largest_crack = largest(broken.iter().map(|bond| bond.radius));
    let mut rows = Rows::default();
    // Of more cracks the latest are shown.
    let shown = broken.len().min(MOST_BONDS);
    for crack in &broken[broken.len() - shown..] {
        let place = apply(&frame.cell, crack.place);
        frame.put(&mut rows, &std::array::from_fn(|a| frame.start[a] + place[a]));
        crack.normal.iter().for_each(|x| rows.signed(*x));
        rows.signed(crack.radius / largest_crack);
        rows.signed(if crack.rupture == Rupture::Shear { 1.0 } else { 0.0 });
    }
    json!({
        "bonds_shown": held.len(), "bonds": text, "longest_bond": longest, "widest_bond": DRAWN * widest,
        "cracks_shown": shown, "cracks": rows.text(), "largest_crack": largest_crack,
    })
}
