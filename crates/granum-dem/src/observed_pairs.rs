//! Pairs of the neighbour list as they are observed, batch by batch.

use granum_simd::{Isa, Kernel, Lanes, Row4, Row8, dispatch};

use crate::contact::choice::contact_model::ContactModel;
use crate::contact::evaluation::constants::PairConstants;
use crate::contact::evaluation::frame::ContactFrame;
use crate::contact::evaluation::observed::ObservedBatch;
use crate::images::{self, IMAGES, NO_IMAGE};
use crate::state::State;

/// Number of batches that are evaluated together; they fit into the first cache.
pub(crate) const TOGETHER: usize = 4;

/// A batch of the neighbour list, with the positions of its grains and what its laws give.
#[derive(Clone, Copy)]
pub(crate) struct ObservedPairs {
    /// Branch vectors from the first to the second grains, m.
    pub(crate) branch: [Row8; 3],
    /// Unit normals, from the first to the second grains.
    pub(crate) normal: [Row8; 3],
    /// Tangential forces on the first grains, N.
    pub(crate) tangential_force: [Row8; 3],
}

/// A few batches of the neighbour list that are observed together.
pub(crate) struct Observing<'a> {
    state: &'a State,
    laws: &'a ContactModel,
    images: [Row4; IMAGES],
    isa: Isa,
    /// Where the pairs are.
    pub(crate) pairs: Vec<ObservedPairs>,
    /// What their laws give.
    pub(crate) laws_give: Vec<ObservedBatch>,
}

impl<'a> Observing<'a> {
    /// For the pairs of a state; `alike` are the constants of all pairs where grains are equal.
    pub(crate) fn new(state: &'a State, laws: &'a ContactModel, alike: &PairConstants<f64>) -> Self {
        let zero = [Row8::default(); 3];
        let isa = Isa::detect();
        Observing {
            state,
            laws,
            images: images::image_table(isa, &state.cell),
            isa,
            pairs: vec![ObservedPairs { branch: zero, normal: zero, tangential_force: zero }; TOGETHER],
            laws_give: vec![ObservedBatch::new(alike); TOGETHER],
        }
    }

    /// Evaluates some batches of the list, at most [`TOGETHER`].
    pub(crate) fn evaluate(&mut self, batches: impl ExactSizeIterator<Item = usize> + Clone) {
        let count = batches.len();
        let kept = self.laws.constants_kept();
        let pairs = &self.state.pairs;
        for (b, to) in batches.clone().zip(&mut self.laws_give) {
            if !pairs.constants.is_empty() {
                let rows = &pairs.constants[b * kept..(b + 1) * kept];
                to.constants = PairConstants::from_columns(kept, |c| rows[c]);
            }
            pairs.read_batch(b, &mut to.memory);
            to.touching = pairs.marks[b].touched;
            // A bridge that formed at the end of the last step has not acted yet.
            to.attracting = pairs.marks[b].attracting;
        }
        let images = &self.images;
        dispatch(
            self.isa,
            Geometry {
                state: self.state,
                images,
                batches,
                pairs: &mut self.pairs,
                laws_give: &mut self.laws_give,
            },
        );
        self.laws.observe(self.isa, &mut self.laws_give[..count]);
    }
}

/// Branch vectors, normals, overlaps and tangential forces of batches.
struct Geometry<'a, B> {
    state: &'a State,
    images: &'a [Row4; IMAGES],
    batches: B,
    pairs: &'a mut [ObservedPairs],
    laws_give: &'a mut [ObservedBatch],
}

impl<B: Iterator<Item = usize>> Kernel for Geometry<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes>(self) {
        let (state, list) = (self.state, &self.state.pairs);
        for ((b, pairs), laws) in self.batches.zip(self.pairs).zip(self.laws_give) {
            let from = L::gather8(&state.particles, &list.first[b]);
            let to = L::gather8(&state.particles, &list.second[b]);
            let mut end = [to[0], to[1], to[2]];
            if list.image[b] != [NO_IMAGE; 8] {
                let image = L::gather4(self.images, &list.image[b]);
                end = [end[0] + image[0], end[1] + image[1], end[2] + image[2]];
            }
            let [x, y, z] = [end[0] - from[0], end[1] - from[1], end[2] - from[2]];
            let length = (x * x + y * y + z * z).sqrt();
            (L::load(&laws.constants.radius_sum.0) - length).store(&mut laws.overlap.0);
            let memory = &laws.memory;
            let old =
                [L::load(&memory.normal[0].0), L::load(&memory.normal[1].0), L::load(&memory.normal[2].0)];
            let components = [L::load(&memory.history[0].0), L::load(&memory.history[1].0)];
            let force = ContactFrame::new(old).vector(components);
            for (rows, values) in [
                (&mut pairs.branch, [x, y, z]),
                (&mut pairs.normal, [x / length, y / length, z / length]),
                (&mut pairs.tangential_force, force),
            ] {
                for (row, value) in rows.iter_mut().zip(values) {
                    value.store(&mut row.0);
                }
            }
        }
    }
}
