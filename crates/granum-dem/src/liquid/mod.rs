//! Exchange of liquid between the films of grains and the bridges of a law that shares liquid
//! ([`AdhesionLaw::SHARES_LIQUID`](crate::contact::AdhesionLaw::SHARES_LIQUID)).
//!
//! Liquid is exchanged in the serial part at the end of a step, in the order of the slots of the pairs, so that the result
//! does not depend on the number of threads. First the bridges that ruptured in the step return their liquid, one half to the
//! film of each grain. Then bridges form between grains that touch and have none, where a contact began in the step or films
//! received liquid: both films give equal volumes, at most what the drier of the two has, up to the largest volume of a
//! bridge. Every volume that is taken from a film or bridge is added to another, so that the total volume of liquid changes by
//! rounding errors only.
//!
//! A bridge acts from the step after its formation. The energy that it has at the overlap at which it forms is counted as
//! lost at its formation.

use granum_core::assembly::Liquid;
use granum_simd::{LANES, Row8};

use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::law::limits::MAX_ADHESION_HISTORY;
use crate::integrator::Integrator;
use crate::kernel::Views;
use crate::pairs::{Block, Marks, NORMAL_COLUMNS};
use crate::particle_row::ParticleRow;
use crate::state::State;
use granum_simd::vectors::dot;

/// The column of a contact history that contains the volume of liquid of a bridge, m3; the other columns of the adhesion law
/// follow it.
fn volume_column(laws: &ContactModel) -> usize {
    let [tangential, moments, ..] = laws.history();
    NORMAL_COLUMNS + tangential + moments
}

/// The lanes whose bit is set.
fn lanes(bits: u8) -> impl Iterator<Item = usize> {
    (0..LANES).filter(move |l| bits >> l & 1 != 0)
}

/// The batches of the inner lists: only in these a pair can touch, or have a bridge.
fn evaluated(blocks: &[Block]) -> impl Iterator<Item = usize> {
    let range = |from: u32, to: u32| from as usize..to as usize;
    blocks.iter().flat_map(move |block| {
        let ([start, inner, _], [within, across]) = (block.batches, block.inner_ends);
        range(start, within).chain(range(inner, across))
    })
}

/// The pairs that take part in an exchange.
#[derive(Clone, Copy, PartialEq)]
enum Scope {
    /// The pairs that began or ceased to interact in the last step, and every dry contact where films received liquid.
    Changed,
    /// All contacts.
    All,
}

/// The result of an exchange.
struct Exchanged {
    /// Energy lost by the formation of bridges, J.
    lost: f64,
    /// True if bridges formed.
    made: bool,
}

/// Returns the liquid of ruptured bridges to the films and makes new ones.
///
/// # Safety
/// No other thread may work on these views.
unsafe fn exchange(v: &Views, scope: Scope, constants: impl Fn(usize) -> PairConstants<f64>) -> Exchanged {
    let law = v.laws.adhesion.law();
    let (column, columns, held) = (volume_column(&v.laws), v.columns, law.history());
    // SAFETY: guaranteed by the caller.
    let (films, marks, memory, blocks, first, second) = unsafe {
        (
            v.films.write(0..v.films.len()),
            v.marks.write(0..v.marks.len()),
            v.memory.write(0..v.memory.len()),
            v.blocks.read(),
            v.first.read(),
            v.second.read(),
        )
    };
    let mut returned = false;
    for b in evaluated(blocks) {
        for l in lanes(marks[b].changed & !marks[b].touched) {
            let half = 0.5 * std::mem::take(&mut memory[b * columns + column].0[l]);
            films[first[b][l] as usize] += half;
            films[second[b][l] as usize] += half;
            returned = true;
        }
    }
    let all = returned || scope == Scope::All;
    let (mut lost, mut made) = (0.0, false);
    for b in evaluated(blocks) {
        let Marks { touched, attracting, changed, .. } = marks[b];
        if changed | touched & !attracting == 0 {
            continue;
        }
        marks[b].changed = 0;
        for l in lanes(touched & !attracting & if all { u8::MAX } else { changed }) {
            let [i, j] = [first[b][l] as usize, second[b][l] as usize];
            // A grain that touches an image of itself gives both halves.
            let available = if i == j { films[i] } else { 2.0 * films[i].min(films[j]) };
            let rows = &mut memory[b * columns + column..][..held];
            if available == 0.0 || rows[0].0[l] != 0.0 {
                continue;
            }
            let constants = constants(b * LANES + l);
            let volume = available.min(law.largest_bridge(&constants.adhesion));
            let history = law.bridge(&constants.adhesion, volume);
            if history[0] == 0.0 {
                continue;
            }
            films[i] -= 0.5 * history[0];
            films[j] -= 0.5 * history[0];
            store(rows, l, &history);
            // SAFETY: guaranteed by the caller.
            let overlap = constants.radius_sum - unsafe { distance(v, b, l) };
            lost -= law.energy(&constants.adhesion, overlap, &history);
            made = true;
        }
    }
    Exchanged { lost, made }
}

fn store(rows: &mut [Row8], lane: usize, history: &[f64; MAX_ADHESION_HISTORY]) {
    for (row, value) in rows.iter_mut().zip(history) {
        row.0[lane] = *value;
    }
}

/// Distance of the centres of a pair, m.
///
/// # Safety
/// As for [`exchange`].
unsafe fn distance(v: &Views, b: usize, l: usize) -> f64 {
    // SAFETY: guaranteed by the caller.
    let (particles, i, j, image) =
        unsafe { (v.particles.read(), v.first.read()[b][l], v.second.read()[b][l], v.image.read()[b][l]) };
    let [i, j] = [i, j].map(|grain| particles[grain as usize].0);
    let image = v.images[image as usize].0;
    let branch: [f64; 3] = std::array::from_fn(|k| j[k] - i[k] + image[k]);
    dot(branch, branch).sqrt()
}

impl Integrator {
    /// The exchange of liquid after the contacts were evaluated, if a law shares liquid; true if it made a bridge.
    ///
    /// # Safety
    /// The views are those of this integrator, and no other thread works on them.
    pub(crate) unsafe fn exchange_liquid(&self, views: &Views) -> bool {
        if !self.properties.contact.adhesion.law().shares_liquid() {
            return false;
        }
        // SAFETY: guaranteed by the caller; nothing else refers to the sums of the contacts.
        unsafe {
            let done = exchange(views, Scope::Changed, |slot| self.pair_constants(slot));
            views.contact_sums.write(0..1)[0].mechanisms.attraction_loss += done.lost;
            done.made
        }
    }

    /// Makes bridges at existing contacts when a law begins to share liquid, or when the amount of liquid increases.
    pub(crate) fn make_bridges(&mut self) {
        if !self.properties.contact.adhesion.law().shares_liquid() {
            return;
        }
        let views = self.views();
        // SAFETY: no other thread works on these views.
        let done = unsafe { exchange(&views, Scope::All, |slot| self.pair_constants(slot)) };
        self.state.ledger.balance.attraction_loss += done.lost;
    }

    /// The films that grains have at the start, m3, if the law shares liquid.
    pub(crate) fn first_films(&self) -> Option<Vec<f64>> {
        let law = self.properties.contact.adhesion.law();
        let film = |grain: usize| {
            let contact = self.contact_of_grain(grain as u32);
            let radius = self.state.particles[grain].radius();
            law.film(radius, &contact.parameters.resolved(law.description().parameters))
        };
        law.shares_liquid().then(|| (0..self.state.pieces()).map(film).collect())
    }

    /// Gives the grains their initial films if the law shares liquid and they have had no films so far. If the initial films
    /// would have been different under the properties before, the difference is added to the present films.
    pub(crate) fn wet_grains(&mut self, before: Option<&[f64]>) {
        let Some(films) = self.first_films() else { return };
        match before {
            _ if self.state.films.is_empty() => self.state.films = films,
            Some(before) => {
                for ((film, new), old) in self.state.films.iter_mut().zip(films).zip(before) {
                    *film = (*film + (new - old)).max(0.0);
                }
            }
            None => {}
        }
    }

    /// Adapts the bridges to other properties, before the histories are adapted: a bridge that does not exist under the new law,
    /// or whose gap exceeds the new rupture distance, returns its liquid, and one that exceeds the largest volume returns the
    /// excess.
    pub(crate) fn change_bridges(&mut self, before: &ContactModel) {
        if !before.adhesion.law().shares_liquid() {
            return;
        }
        let law = self.properties.contact.adhesion.law();
        let same = before.adhesion == self.properties.contact.adhesion;
        let (column, columns) = (volume_column(before), self.state.pairs.columns_in_all());
        for b in 0..self.state.pairs.batches() {
            for l in 0..LANES {
                let volume = self.state.pairs.column(b, column)[l];
                if volume == 0.0 {
                    continue;
                }
                let [i, j] = [self.state.pairs.first[b][l], self.state.pairs.second[b][l]];
                let materials = [i, j].map(|grain| self.material_of(grain));
                let radii = [i, j].map(|grain| self.state.particles[grain as usize].radius());
                let constants = self.constants_of(materials, radii);
                let gap = self.state.distance(b * LANES + l) - constants.radius_sum;
                let mut history = [0.0; MAX_ADHESION_HISTORY];
                // The next neighbour list may omit a pair with a gap larger than the range of bridges.
                if same && gap < law.range(&constants.adhesion) {
                    let largest = law.largest_bridge(&constants.adhesion);
                    history = law.bridge(&constants.adhesion, volume.min(largest));
                }
                let rest = 0.5 * (volume - history[0]);
                self.state.films[i as usize] += rest;
                self.state.films[j as usize] += rest;
                let rows = &mut self.state.pairs.memory[b * columns + column..];
                store(&mut rows[..before.adhesion.law().history()], l, &history);
            }
        }
    }
}

impl State {
    /// Volumes of liquid in films and bridges, if a law shares liquid.
    pub(crate) fn liquid(&self, laws: &ContactModel, order: &[usize]) -> Option<Liquid> {
        if self.films.is_empty() {
            return None;
        }
        let mut liquid =
            Liquid { films: order.iter().map(|&grain| self.films[grain]).sum(), ..Liquid::default() };
        if laws.adhesion.law().shares_liquid() {
            let column = volume_column(laws);
            for b in 0..self.pairs.batches() {
                for volume in self.pairs.column(b, column).iter().filter(|volume| **volume != 0.0) {
                    liquid.bridges += volume;
                    liquid.count += 1;
                }
            }
        }
        Some(liquid)
    }
}

#[cfg(test)]
mod tests;
