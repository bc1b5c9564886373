//! The assembly of a state: what sensors, reports and files see of it.
//!
//! Grains and contacts are in the order of the ids of the grains, whatever order the engine keeps them in.

use granum_simd::{Isa, LANES, fused};

use crate::assembly::{Assembly, Contact, Grain};
use crate::contact::constants::PairConstants;
use crate::contact::law;
use crate::contact::observed::{ObservedBatch, ObservedContact};
use crate::contact::selection::ContactModel;
use crate::images::{self, image_vector};
use crate::state::State;

/// Number of contacts that are evaluated together; they fit into the first cache.
const TOGETHER: usize = 32;

/// Where the contacts of slots stand in an assembly.
struct Places {
    /// The place of each of the slots.
    places: Vec<usize>,
    /// True if some pair has several contacts, with images of its second grain.
    images: bool,
}

/// The branch from the centre of the first grain of a pair to that of the second, m, and its length.
#[derive(Clone, Copy)]
struct Branch {
    vector: [f64; 3],
    length: f64,
}

impl State {
    /// Makes an assembly that of this state. Its vectors are filled again: an observation of a large sample writes to megabytes of
    /// memory, and asking the system for them each time would cost as much as a sensor.
    pub(crate) fn assembly_into(
        &self,
        constants: impl Fn(usize) -> PairConstants<f64>,
        laws: &ContactModel,
        out: &mut Assembly,
    ) {
        let order = self.order_of_ids();
        let mut rank = vec![0; order.len()];
        for (r, &g) in order.iter().enumerate() {
            rank[g] = r;
        }
        self.add_grains(&order, &mut out.grains);
        self.list(self.pairs.touching().collect(), &rank, &constants, laws, &mut out.contacts);
        self.list(self.pairs.apart().collect(), &rank, &constants, laws, &mut out.apart);
        out.time = self.time;
        out.step = self.step;
        out.time_step = self.dt;
        out.cell = self.cell.edges;
        out.velocity_gradient = self.gradient;
        out.strain = self.strain;
        out.arc_length = self.arc_length();
        out.target_mean_stress = self.target_mean_stress();
        out.liquid = self.liquid(laws, &order);
        out.energy = self.energy_balance;
    }

    /// The contacts of the pairs in these slots, in the order of the ranks of their grains.
    fn list(
        &self,
        slots: Vec<usize>,
        rank: &[usize],
        constants: &impl Fn(usize) -> PairConstants<f64>,
        laws: &ContactModel,
        contacts: &mut Vec<Contact>,
    ) {
        contacts.resize_with(slots.len(), Contact::default);
        let Places { places, images } = self.places(&slots, rank);
        let (mut branches, mut observed) = (Vec::new(), Vec::new());
        for (slots, places) in slots.chunks(TOGETHER).zip(places.chunks(TOGETHER)) {
            fused(
                #[inline(always)]
                || {
                    self.evaluate(slots, constants, laws, &mut branches, &mut observed);
                    let found = branches.iter().zip(observed.as_flattened());
                    for ((slot, place), (branch, found)) in slots.iter().zip(places).zip(found) {
                        contacts[*place] = self.contact(*slot, rank, branch, found);
                    }
                },
            );
        }
        // Images of one pair, in a small cell, by their branch vectors.
        if images {
            for images in contacts.chunk_by_mut(|a, b| (a.i, a.j) == (b.i, b.j)) {
                images.sort_unstable_by(|a, b| a.branch[0].total_cmp(&b.branch[0]));
            }
        }
    }

    /// The grains in the order of their ids.
    fn order_of_ids(&self) -> Vec<usize> {
        let n = self.grains();
        let ids = &self.ids[..n];
        // Mostly the ids are 1..=n, and each of them is the place of its grain.
        let mut order = vec![usize::MAX; n];
        for (g, &id) in ids.iter().enumerate() {
            match order.get_mut((id as usize).wrapping_sub(1)) {
                Some(place) if *place == usize::MAX => *place = g,
                _ => {
                    order = (0..n).collect();
                    order.sort_unstable_by_key(|&g| ids[g]);
                    return order;
                }
            }
        }
        order
    }

    fn add_grains(&self, order: &[usize], grains: &mut Vec<Grain>) {
        let mut inside = self.particles[..order.len()].to_vec();
        images::wrap(&self.cell, &mut inside);
        let grain = |&g: &usize| {
            let total = self.resultant(g);
            let (p, w) = (&self.particles[g].0, &self.spin[g].0);
            Grain {
                id: self.ids[g],
                position: [inside[g].0[0], inside[g].0[1], inside[g].0[2]],
                velocity: [p[4], p[5], p[6]],
                spin: [w[0], w[1], w[2]],
                radius: p[3],
                mass: p[7],
                force: [total[0], total[1], total[2]],
                torque: [p[3] * total[4], p[3] * total[5], p[3] * total[6]],
                material: self.materials.get(g).copied().unwrap_or(0).into(),
            }
        };
        grains.clear();
        grains.extend(order.iter().map(grain));
    }

    /// The indices of the grains of the pair in a slot.
    #[inline(always)]
    fn grains_of(&self, slot: usize) -> [usize; 2] {
        let (b, l) = (slot / LANES, slot % LANES);
        [self.pairs.first[b][l] as usize, self.pairs.second[b][l] as usize]
    }

    /// The places of slots in the order of the ranks of their grains, the lower rank first; the slots of images of one pair are in
    /// rising order.
    fn places(&self, slots: &[usize], rank: &[usize]) -> Places {
        let ranks: Vec<[u32; 2]> = (slots.iter())
            .map(|&slot| {
                let [i, j] = self.grains_of(slot).map(|g| rank[g] as u32);
                [i.min(j), i.max(j)]
            })
            .collect();
        // The pairs of one lower rank are few, and sorting them is cheap once they are together.
        let mut starts = vec![0u32; rank.len() + 2];
        for &[low, _] in &ranks {
            starts[low as usize + 2] += 1;
        }
        for r in 2..starts.len() {
            starts[r] += starts[r - 1];
        }
        let mut sorted = vec![[0u32; 2]; slots.len()];
        for (k, &[low, high]) in ranks.iter().enumerate() {
            // Afterwards each start is where the next rank begins.
            let next = &mut starts[low as usize + 1];
            sorted[*next as usize] = [high, k as u32];
            *next += 1;
        }
        let mut images = false;
        for ends in starts.windows(2).filter(|ends| ends[1] > ends[0] + 1) {
            let of_one_rank = &mut sorted[ends[0] as usize..ends[1] as usize];
            of_one_rank.sort_unstable();
            images |= of_one_rank.windows(2).any(|pair| pair[0][0] == pair[1][0]);
        }
        let mut places = vec![0; slots.len()];
        for (place, [_, k]) in sorted.into_iter().enumerate() {
            places[k as usize] = place;
        }
        Places { places, images }
    }

    #[inline(always)]
    fn branch(&self, slot: usize) -> Branch {
        let [i, j] = self.grains_of(slot);
        let image = self.cell.image(image_vector(self.pairs.image[slot / LANES][slot % LANES]));
        let (a, b) = (&self.particles[i].0, &self.particles[j].0);
        let [x, y, z] = [b[0] + image[0] - a[0], b[1] + image[1] - a[1], b[2] + image[2] - a[2]];
        Branch { vector: [x, y, z], length: (x * x + y * y + z * z).sqrt() }
    }

    /// Distance of the centres of the pair in a slot, m.
    pub(crate) fn distance(&self, slot: usize) -> f64 {
        self.branch(slot).length
    }

    /// Evaluates the laws for the pairs in these slots.
    #[inline(always)]
    fn evaluate(
        &self,
        slots: &[usize],
        constants: impl Fn(usize) -> PairConstants<f64>,
        laws: &ContactModel,
        branches: &mut Vec<Branch>,
        observed: &mut Vec<ObservedBatch>,
    ) {
        let Some(&first) = slots.first() else { return };
        branches.clear();
        let batches = slots.len().div_ceil(LANES);
        // The contacts that fill the last batch are evaluated in vain.
        observed.resize_with(batches, || [ObservedContact::new(constants(first)); LANES]);
        for (found, &slot) in observed.as_flattened_mut().iter_mut().zip(slots) {
            if !self.pairs.constants.is_empty() {
                found.constants = constants(slot);
            }
            self.pairs.read_memory(slot, &mut found.memory);
            let branch = self.branch(slot);
            branches.push(branch);
            found.overlap = found.constants.radius_sum - branch.length;
            found.touching = self.pairs.touched(slot);
            // A bridge that formed at the end of the last step has not acted yet.
            found.attracting = self.pairs.attracting(slot);
        }
        laws.observe(Isa::detect(), observed);
    }

    /// The contact in a slot, from what its laws give. By rank, so that i < j holds for ids whatever the storage order.
    #[inline(always)]
    fn contact(&self, slot: usize, rank: &[usize], branch: &Branch, found: &ObservedContact) -> Contact {
        let [i, j] = self.grains_of(slot).map(|g| rank[g]);
        let sign = if i <= j { 1.0 } else { -1.0 };
        Contact {
            i: i.min(j),
            j: i.max(j),
            branch: branch.vector.map(|x| sign * x),
            normal: branch.vector.map(|x| sign * x / branch.length),
            approach: found.overlap,
            normal_force: found.contact.force - found.attraction,
            tangential_force: law::tangential_force(&found.memory).map(|x| sign * x),
            radius: found.contact.radius,
            sliding: self.pairs.sliding(slot),
            normal_energy: found.normal_energy,
            tangential_energy: found.tangential_energy,
            rolling_energy: found.rolling_energy,
            attraction_energy: found.attraction_energy,
        }
    }
}
