//! The assembly of a state: what sensors, reports and files see of it.
//!
//! Bodies, pieces and contacts are in the order of the ids of the bodies, whatever order the engine keeps them in.

use granum_core::geometry::invert;
use granum_core::rotation::{matrix, to_space};
use granum_simd::{LANES, Real, Row8, ScalarKernel, fused, prefetch};

use crate::assembly::{Assembly, Body, Contact, Matrix, Piece, Rigid, Sphere};
use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::images::{self, NO_IMAGE, image_vector};
use crate::observed_pairs::{Observing, TOGETHER};
use crate::particle_row::ParticleRow;
use crate::state::State;
use crate::state::bodies::BodyPlace;
use granum_shape::equivalent_radius;

/// Number of grains between prefetching one and copying it.
const GRAINS_AHEAD: usize = 12;

/// Prefetches the memory of a contact that will be written: its place has nothing to do with those of its neighbours in the list of
/// pairs, so that the processor cannot predict it.
#[inline(always)]
fn fetch_ahead(contact: &Contact) {
    let start: *const Contact = contact;
    for line in (0..size_of::<Contact>()).step_by(64) {
        prefetch(start.cast::<u8>().wrapping_add(line));
    }
}

/// Sorts a few numbers in place; a call of the library's function would cost more than the sorting.
#[inline(always)]
fn insert(few: &mut [[u32; 2]]) {
    for end in 1..few.len() {
        let new = few[end];
        let mut at = end;
        while at > 0 && few[at - 1] > new {
            few[at] = few[at - 1];
            at -= 1;
        }
        few[at] = new;
    }
}

/// Where the contacts of slots stand in an assembly.
struct Places {
    /// The place of each of the slots.
    places: Vec<usize>,
    /// True if some pair has several contacts, with images of its second grain.
    images: bool,
}

impl State {
    /// Makes an assembly that of this state. Its vectors are filled again: an observation of a large sample writes to megabytes of
    /// memory, and asking the system for them each time would cost as much as a sensor.
    pub(crate) fn assembly_into(&self, alike: &PairConstants<f64>, laws: &ContactModel, out: &mut Assembly) {
        let bodies = self.bodies_in_order();
        let order = self.pieces_in_order(&bodies);
        let rank = ranks(&order);
        if self.has_clumps() {
            self.add_bodies(&bodies, out);
        } else {
            self.add_spheres(&order, out);
        }
        let mut observing = Observing::new(self, laws, alike);
        self.list(self.pairs.touching().collect(), &rank, &mut observing, &mut out.contacts);
        let apart = if laws.adhesion.law().acts() { self.pairs.apart().collect() } else { Vec::new() };
        self.list(apart, &rank, &mut observing, &mut out.apart);
        out.time = self.time;
        out.step = self.step;
        out.time_step = self.dt;
        out.cell = self.cell.edges;
        out.velocity_gradient = self.gradient;
        out.strain = self.strain;
        out.arc_length = self.arc_length();
        out.target_mean_stress = self.target_mean_stress();
        out.liquid = self.liquid(laws, &order);
        out.energy = self.ledger.named(laws);
        self.add_bonds_to(&rank, out);
    }

    /// The contacts of the pairs in these slots, in the order of the ranks of their grains.
    fn list(
        &self,
        slots: Vec<usize>,
        rank: &[usize],
        observing: &mut Observing<'_>,
        contacts: &mut Vec<Contact>,
    ) {
        contacts.resize_with(slots.len(), Contact::default);
        let Places { places, images } = self.places(&slots, rank);
        let batches: Vec<&[usize]> = slots.chunk_by(|a, b| a / LANES == b / LANES).collect();
        let mut done = 0;
        for batches in batches.chunks(TOGETHER) {
            for &place in places[done..].iter().skip(TOGETHER * LANES).take(TOGETHER * LANES) {
                fetch_ahead(&contacts[place]);
            }
            observing.evaluate(batches.iter().map(|slots| slots[0] / LANES));
            for (k, slots) in batches.iter().enumerate() {
                for &slot in *slots {
                    contacts[places[done]] = self.contact(slot, rank, observing, k);
                    done += 1;
                }
            }
        }
        // Images of one pair, in a small cell, by their branch vectors.
        if images {
            for images in contacts.chunk_by_mut(|a, b| (a.i, a.j) == (b.i, b.j)) {
                images.sort_unstable_by(|a, b| a.branch[0].total_cmp(&b.branch[0]));
            }
        }
    }

    /// The slots of the contacts that touch, in the order of the contacts of the assembly, each with minus one where the grains of its pair
    /// have changed roles there, and one elsewhere.
    pub(crate) fn slots_of_contacts(&self) -> Vec<(usize, f64)> {
        let rank = ranks(&self.pieces_in_order(&self.bodies_in_order()));
        let slots: Vec<usize> = self.pairs.touching().collect();
        let Places { places, images } = self.places(&slots, &rank);
        let mut found = vec![(0, 1.0); slots.len()];
        for (slot, place) in slots.into_iter().zip(places) {
            let [i, j] = self.grains_of(slot).map(|g| rank[g]);
            found[place] = (slot, if i <= j { 1.0 } else { -1.0 });
        }
        if images {
            let pair = |&(slot, _): &(usize, f64)| {
                let [i, j] = self.grains_of(slot);
                [i.min(j), i.max(j)]
            };
            for images in found.chunk_by_mut(|a, b| pair(a) == pair(b)) {
                images.sort_unstable_by(|a, b| self.branch_x(*a).total_cmp(&self.branch_x(*b)));
            }
        }
        found
    }

    /// The first component of the branch vector of the contact in a slot, m.
    fn branch_x(&self, (slot, sign): (usize, f64)) -> f64 {
        let [i, j] = self.grains_of(slot).map(|g| self.particles[g].0[0]);
        let code = self.pairs.image[slot / LANES][slot % LANES];
        let image = if code == NO_IMAGE { 0.0 } else { self.cell.image(image_vector(code))[0] };
        sign * (j + image - i)
    }

    /// Spheres, in the order of their rows.
    fn add_spheres(&self, order: &[usize], out: &mut Assembly) {
        let inverse = invert(&self.cell.edges);
        out.rigid.clear();
        out.bodies.resize_with(order.len(), Body::default);
        out.pieces.resize_with(order.len(), Piece::default);
        fused(AddSpheres { state: self, inverse, order, bodies: &mut out.bodies, pieces: &mut out.pieces });
    }

    /// Spheres and clumps, in the order of their ids.
    fn add_bodies(&self, bodies: &[BodyPlace], out: &mut Assembly) {
        let inverse = invert(&self.cell.edges);
        out.rigid.clear();
        out.bodies.clear();
        out.pieces.clear();
        fused(AddBodies { state: self, inverse, places: bodies, out });
    }

    #[inline(always)]
    fn add_clump<R: Real>(&self, k: usize, inverse: &Matrix, out: &mut Assembly) {
        let clump = &self.clumps.bodies[k];
        let pieces = self.clumps.pieces_of(clump);
        let rotation = matrix(&clump.orientation);
        let [x, y, z] = clump.centre;
        let centre = Row8([x, y, z, 0.0, 0.0, 0.0, 0.0, 0.0]);
        let [force, torque] = self.loads_of(clump);
        let material = self.materials.get(pieces[0].row as usize).copied().unwrap_or(0);
        for piece in pieces {
            let row = self.particles[piece.row as usize];
            out.pieces.push(Piece {
                body: out.bodies.len(),
                position: images::wrapped::<R>(&self.cell, inverse, &row).0,
                radius: row.radius(),
                arm: to_space(&rotation, &piece.centre),
            });
        }
        out.bodies.push(Body {
            id: clump.id,
            position: images::wrapped::<R>(&self.cell, inverse, &centre).0,
            velocity: clump.velocity,
            spin: clump.spin(),
            equivalent_radius: equivalent_radius(clump.volume),
            mass: clump.mass,
            force,
            torque,
            material: material.into(),
            rigid: Some(out.rigid.len() as u32),
        });
        out.rigid.push(Rigid { orientation: clump.orientation, inertia: clump.inertia });
    }

    #[inline(always)]
    fn sphere<R: Real>(&self, g: usize, inverse: &Matrix) -> Sphere {
        let total = self.resultant(g);
        let (particle, w) = (&self.particles[g], &self.spin[g].0);
        let radius = particle.radius();
        Sphere {
            id: self.ids[g],
            position: images::wrapped::<R>(&self.cell, inverse, &self.particles[g]).0,
            velocity: particle.velocity(),
            spin: [w[0], w[1], w[2]],
            radius,
            mass: particle.mass(),
            force: [total[0], total[1], total[2]],
            torque: [radius * total[4], radius * total[5], radius * total[6]],
            material: self.materials.get(g).copied().unwrap_or(0).into(),
        }
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
            insert(of_one_rank);
            images |= of_one_rank.windows(2).any(|pair| pair[0][0] == pair[1][0]);
        }
        let mut places = vec![0; slots.len()];
        for (place, [_, k]) in sorted.into_iter().enumerate() {
            places[k as usize] = place;
        }
        Places { places, images }
    }

    /// Distance of the centres of the pair in a slot, m.
    pub(crate) fn distance(&self, slot: usize) -> f64 {
        let [i, j] = self.grains_of(slot);
        let (a, b) = (&self.particles[i].0, &self.particles[j].0);
        let code = self.pairs.image[slot / LANES][slot % LANES];
        let image = if code == NO_IMAGE { [0.0; 3] } else { self.cell.image(image_vector(code)) };
        let [x, y, z] = [b[0] + image[0] - a[0], b[1] + image[1] - a[1], b[2] + image[2] - a[2]];
        (x * x + y * y + z * z).sqrt()
    }

    /// The contact in a slot of the k-th of the observed batches. By rank, so that i < j holds for ids whatever the storage order.
    #[inline(always)]
    fn contact(&self, slot: usize, rank: &[usize], observing: &Observing<'_>, k: usize) -> Contact {
        let l = slot % LANES;
        let (pairs, laws) = (&observing.pairs[k], &observing.laws_give[k]);
        let [force, radius, ..] = &laws.contact;
        let [i, j] = self.grains_of(slot).map(|g| rank[g]);
        let sign = if i <= j { 1.0 } else { -1.0 };
        // By reference: a row is large.
        let vector = |rows: &[Row8; 3]| [sign * rows[0].0[l], sign * rows[1].0[l], sign * rows[2].0[l]];
        Contact {
            i: i.min(j),
            j: i.max(j),
            branch: vector(&pairs.branch),
            normal: vector(&pairs.normal),
            approach: laws.overlap.0[l],
            normal_force: force.0[l] - laws.attraction.0[l],
            tangential_force: vector(&pairs.tangential_force),
            radius: radius.0[l],
            sliding: self.pairs.sliding(slot),
            normal_energy: laws.normal_energy.0[l],
            tangential_energy: laws.tangential_energy.0[l],
            rolling_energy: laws.rolling_energy.0[l],
            attraction_energy: laws.attraction_energy.0[l],
        }
    }
}

/// The rank of each row: its place in an order of rows.
fn ranks(order: &[usize]) -> Vec<usize> {
    let mut rank = vec![0; order.len()];
    for (r, &g) in order.iter().enumerate() {
        rank[g] = r;
    }
    rank
}

/// Copies spheres, with the fused operations of the processor.
struct AddSpheres<'a> {
    state: &'a State,
    inverse: Matrix,
    order: &'a [usize],
    bodies: &'a mut [Body],
    pieces: &'a mut [Piece],
}

impl ScalarKernel for AddSpheres<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        let AddSpheres { state, inverse, order, bodies, pieces } = self;
        for (k, &g) in order.iter().enumerate() {
            // The order of the ids has nothing to do with the order in memory.
            if let Some(&later) = order.get(k + GRAINS_AHEAD) {
                prefetch(&state.particles[later]);
                prefetch(&state.spin[later]);
                prefetch(&state.pairs.forces[later]);
            }
            let sphere = state.sphere::<R>(g, &inverse);
            pieces[k] = Piece { body: k, position: sphere.position, radius: sphere.radius, arm: [0.0; 3] };
            bodies[k] = sphere.into();
        }
    }
}

/// Copies spheres and clumps, with the fused operations of the processor.
struct AddBodies<'a> {
    state: &'a State,
    inverse: Matrix,
    places: &'a [BodyPlace],
    out: &'a mut Assembly,
}

impl ScalarKernel for AddBodies<'_> {
    type Output = ();

    #[inline(always)]
    fn run<R: Real>(self) {
        for place in self.places {
            match *place {
                BodyPlace::Sphere(row) => self.out.push_sphere(self.state.sphere::<R>(row, &self.inverse)),
                BodyPlace::Clump(k) => self.state.add_clump::<R>(k, &self.inverse, self.out),
            }
        }
    }
}
