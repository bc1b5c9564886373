//! Contacts as they are observed: their forces and stored energies, from their constants and histories.

use super::constants::PairConstants;
use super::law::Normal;
use super::memory::Memory;
use super::selection::ContactModel;

/// A pair whose grains touch, or on which a law of adhesion acts, with what an observer wants to know about it.
///
/// A law evaluates many of them in one call: the numbers of one contact are a long chain of dependent operations, and those of the
/// next are computed beside it.
#[derive(Clone, Copy)]
pub struct ObservedContact {
    /// The constants of the pair.
    pub constants: PairConstants<f64>,
    /// The history of the pair.
    pub memory: Memory<f64>,
    /// Overlap, m.
    pub overlap: f64,
    /// True if the pair touches.
    pub touching: bool,
    /// True if a law of adhesion acts on the pair.
    pub attracting: bool,
    /// The normal part of the contact; without force and area where the pair does not touch.
    pub contact: Normal<f64>,
    /// Elastic energy of the overlap, J.
    pub normal_energy: f64,
    /// Elastic energy of the tangential displacement, J.
    pub tangential_energy: f64,
    /// Elastic energy of rolling and twisting, J.
    pub rolling_energy: f64,
    /// Attractive force of a law of adhesion, N.
    pub attraction: f64,
    /// Energy of this attraction, J.
    pub attraction_energy: f64,
}

impl ObservedContact {
    /// A pair with these constants that has not been evaluated.
    pub(crate) fn new(constants: PairConstants<f64>) -> ObservedContact {
        ObservedContact {
            constants,
            memory: Memory::new(),
            overlap: 0.0,
            touching: false,
            attracting: false,
            contact: Normal::none(),
            normal_energy: 0.0,
            tangential_energy: 0.0,
            rolling_energy: 0.0,
            attraction: 0.0,
            attraction_energy: 0.0,
        }
    }

    /// The overlap with which the normal law is evaluated, m: that of grains far apart where the pair does not touch, since only
    /// the law of adhesion acts there.
    #[inline(always)]
    pub(super) fn overlap_of_contact(&self) -> f64 {
        if self.touching { self.overlap } else { -self.constants.radius_sum }
    }
}

impl ContactModel {
    /// Evaluates the laws of the set for these pairs.
    pub(crate) fn observe(&self, contacts: &mut [ObservedContact]) {
        self.normal.law().observe(contacts);
        self.tangential.law().observe(contacts);
        let (rolling, adhesion) = (self.rolling.law(), self.adhesion.law());
        if rolling.acts() {
            for c in &mut *contacts {
                c.rolling_energy = rolling.energy(&c.constants.rolling, &c.memory.moments);
            }
        }
        if adhesion.acts() {
            for c in contacts {
                (c.attraction, c.attraction_energy) = (0.0, 0.0);
                if c.attracting {
                    let (constants, history) = (&c.constants.adhesion, &c.memory.adhesion);
                    c.attraction = adhesion.force(constants, c.overlap, c.touching, history);
                    c.attraction_energy = adhesion.energy(constants, c.overlap, history);
                }
            }
        }
    }
}
