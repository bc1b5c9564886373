//! Ids by which contacts name grains whose file has none: from 1, as granum counts, or from 0, as many programs do.

use granum_core::assembly::Assembly;
use granum_core::geometry::length;
use granum_core::{Part, Parts};

use super::remark::Remark;
use super::result::FileContact;
use crate::packing::lattice::Images;

/// Lets contacts whose ids count from 0 name grains that are numbered from 1. That they do is certain where one names the grain 0; where
/// neither the first nor the last number occurs, it is so if more pairs then touch.
pub(super) fn count_from_one(
    assembly: &Assembly,
    parts: Parts,
    images: &Images,
    pairs: &mut [FileContact],
    remarks: &mut Vec<Remark>,
) {
    let ids = || pairs.iter().flat_map(|pair| [pair.first, pair.second]);
    let (Some(lowest), Some(highest)) = (ids().min(), ids().max()) else { return };
    let count = assembly.bodies.len() as u64;
    let from_zero = lowest == 0
        || (highest < count
            && parts.has(Part::Radii)
            && touching(assembly, images, pairs, 0) > touching(assembly, images, pairs, 1));
    if from_zero && highest < count {
        pairs.iter_mut().for_each(|pair| (pair.first, pair.second) = (pair.first + 1, pair.second + 1));
        remarks.push(Remark::set_right("the contacts count the grains from 0"));
    }
}

/// How many pairs touch if the first grain has this number.
fn touching(assembly: &Assembly, images: &Images, pairs: &[FileContact], first: u64) -> usize {
    let grain = |id: u64| assembly.pieces.get(usize::try_from(id.checked_sub(first)?).ok()?);
    let touches = |pair: &&FileContact| {
        let (Some(one), Some(two)) = (grain(pair.first), grain(pair.second)) else { return false };
        let apart = std::array::from_fn(|a| two.position[a] - one.position[a]);
        length(&images.nearest(apart)) < 1.01 * (one.radius + two.radius)
    };
    pairs.iter().filter(touches).count()
}
