//! Constants of pairs that have been found before.

use crate::contact::evaluation::constants::PairConstants;

/// Constants of pairs of materials that were found for pieces of these radii on bodies of these masses: few, where all grains are of one size.
#[derive(Default)]
pub(crate) struct KnownConstants {
    radii: [f64; 2],
    masses: Option<[f64; 2]>,
    found: Vec<([u8; 2], [f64; PairConstants::COUNT])>,
}

impl KnownConstants {
    /// Those of a pair, which are made where they are not known.
    pub(crate) fn constants(
        &mut self,
        materials: [u8; 2],
        radii: [f64; 2],
        masses: Option<[f64; 2]>,
        make: impl FnOnce() -> [f64; PairConstants::COUNT],
    ) -> [f64; PairConstants::COUNT] {
        if radii != self.radii || masses != self.masses {
            (self.radii, self.masses) = (radii, masses);
            self.found.clear();
        }
        if let Some((_, values)) = self.found.iter().find(|(known, _)| *known == materials) {
            return *values;
        }
        let values = make();
        self.found.push((materials, values));
        values
    }
}
