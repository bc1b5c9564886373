//! What the laws keep of the contacts of a simulation, in the order of the contacts of its assembly.

use crate::assembly::Vector;
use crate::contact::evaluation::frame::ContactFrame;
use crate::contact::evaluation::memory::Memory;
use crate::simulation::Simulation;

/// What one law keeps of every contact.
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct LawHistory {
    /// Number of vectors that it keeps of a contact.
    pub vectors_kept: usize,
    /// Number of scalars that it keeps of a contact.
    pub scalars_kept: usize,
    /// The vectors in the plane of each contact, contact by contact, in the unit that the law states: those on the first grain, such as
    /// the tangential force on it, N.
    pub vectors: Vec<Vector>,
    /// The scalars, contact by contact, in the unit that the law states.
    pub scalars: Vec<f64>,
}

/// What the laws keep of the contacts: [`Simulation::contact_history`].
#[derive(Clone, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct ContactHistory {
    /// Number of contacts that touch.
    pub contacts: usize,
    /// Of the normal law; scalars alone.
    pub normal: LawHistory,
    /// Of the tangential law, whose first vector is the tangential force on the first grain, N.
    pub tangential: LawHistory,
    /// Of the law of moments.
    pub moments: LawHistory,
    /// Of the law of adhesion; scalars alone.
    pub adhesion: LawHistory,
}

impl LawHistory {
    /// Of a law with these numbers of columns, the first of which are the components of vectors.
    fn of_columns(columns: usize, vectors: usize) -> LawHistory {
        let scalars_kept = columns.saturating_sub(2 * vectors);
        LawHistory { vectors_kept: vectors, scalars_kept, ..LawHistory::default() }
    }

    /// Adds a contact whose vectors have these components in a frame; `sign` is minus one where the grains change roles.
    fn add(&mut self, columns: &[f64], frame: &ContactFrame<f64>, sign: f64) {
        let (vectors, scalars) = columns.split_at(2 * self.vectors_kept);
        let in_space = |pair: &[f64; 2]| frame.vector(*pair).map(|x| sign * x);
        self.vectors.extend(vectors.as_chunks::<2>().0.iter().map(in_space));
        self.scalars.extend(&scalars[..self.scalars_kept]);
    }
}

impl Simulation {
    /// What the laws keep of each contact that touches, in the order of the contacts of [`Simulation::assembly`]. It is a copy: the engine
    /// keeps contacts in batches of eight, in another order.
    pub fn contact_history(&self) -> ContactHistory {
        let state = self.state();
        let laws = &self.properties().contact;
        let [tangential, moments, adhesion, normal] = laws.history();
        let [of_tangential, of_moments] =
            [laws.tangential.law().history()[1], laws.rolling.law().history()[1]];
        let mut found = ContactHistory {
            contacts: 0,
            normal: LawHistory::of_columns(normal, 0),
            tangential: LawHistory::of_columns(tangential, of_tangential),
            moments: LawHistory::of_columns(moments, of_moments),
            adhesion: LawHistory::of_columns(adhesion, 0),
        };
        for (slot, sign) in state.slots_of_contacts() {
            let memory: Memory<f64> = state.pairs.memory(slot);
            let frame = ContactFrame::new(memory.normal);
            found.normal.add(&memory.loading[..normal], &frame, sign);
            found.tangential.add(&memory.history[..tangential], &frame, sign);
            found.moments.add(&memory.moments[..moments], &frame, sign);
            found.adhesion.add(&memory.adhesion[..adhesion], &frame, sign);
            found.contacts += 1;
        }
        found
    }
}
