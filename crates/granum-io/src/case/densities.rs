//! Densities that no sample can have: they are refused before anything is simulated.
//!
//! Upwards: spheres of equal sizes fill at most pi/sqrt(18) = 0.7405 of space (Kepler; Hales 2005), which is proven. For mixtures nothing as low
//! is proven, and two limits are assumed, both far above what compaction reaches. Diameters that differ by a factor of up to 1.5 have the limit
//! of equal spheres: denser mixtures of two sizes are described for larger factors (Marshall and Hudson 2010: for every one from 1/0.623 = 1.605
//! on), and compaction without friction reaches 0.644 (1000 grains of two sizes, 30 % of the mass fine). With a factor up to 1 + sqrt(2), where the small
//! spheres fit into the octahedral holes of the close packing of the large ones, the limit is that packing's
//! (5/3 - sqrt(2)) pi = 0.793, conjectured to be the densest of these two sizes (Fernique et al. 2025, arXiv:2505.14110); compaction reaches 0.688
//! there. Broader mixtures are not limited here. Where grains are pressed into each other, these bounds grow with the overlap of contacts that
//! carry four times `p d^2`. Compaction of equal spheres reaches 0.64 or so without order.
//!
//! Downwards: spheres without adhesion and without resistance to rolling carry no stress below a solid fraction of `4/(4 + 2 sqrt(3))` = 0.536,
//! however large their friction is (Song, Wang and Makse 2008). Small samples scatter about it, by 0.016 as taken here.

use granum_core::quantity::format_number;
use granum_dem::config::{AdhesionKind, NormalKind, RollingKind};
use granum_dem::preparation::DensityMeasure;

use super::definition::Case;

/// Solid fraction of the close packing of equal spheres, pi/sqrt(18).
const CLOSE_PACKING: f64 = 0.740_480_489_693_061;
/// Ratio of diameters up to which mixtures are taken to be no denser than equal spheres.
const NEARLY_EQUAL: f64 = 1.5;
/// Ratio of diameters at which the small spheres fit into the octahedral holes of the close packing, 1 + sqrt(2), with the solid fraction
/// of that, (5/3 - sqrt(2)) pi.
const FILLED_HOLES: [f64; 2] = [2.414, 0.793];
/// Solid fraction below which spheres carry no stress by friction alone, less the scatter of small samples.
const CARRIES: f64 = 0.52;
/// The force of the contacts by whose overlap the bound is enlarged, over `p d^2`.
const STRONG_CONTACT: f64 = 4.0;
/// Smallest overlap that is looked for, over the diameter, and the factor between overlaps.
const OVERLAPS: [f64; 2] = [1e-6, 1.2];

/// What is wrong with the density that the sample is to have.
pub(super) fn of_sample(case: &Case) -> Option<String> {
    let p = &case.preparation;
    let target = p.target()?;
    let measure = DensityMeasure::new(p);
    let wanted = format!("preparation.{} = {}", measure.key(), format_number(measure.target(p)?));
    // As many digits as a person gives.
    let shown = |solid_fraction: f64| format!("{:.3}", measure.value(p, solid_fraction));
    let name = measure.name();
    let (from, to) = match measure {
        DensityMeasure::VoidRatio => ("below", "above"),
        _ => ("above", "below"),
    };
    if let Some(densest) = densest(case).filter(|densest| target - p.solid_fraction_tolerance > *densest) {
        return Some(format!(
            "{wanted} is denser than spheres of these sizes can be packed, in order or not: their {name} is never {from} {}; compaction reaches \
             about {} without order (granum limits CASE tells what it reaches)",
            shown(densest),
            shown(RANDOM_PACKING)
        ));
    }
    let too_loose = target + p.solid_fraction_tolerance < CARRIES && holds_by_friction_alone(case);
    too_loose.then(|| {
        format!(
            "{wanted} is looser than spheres can be that carry a stress by friction alone: their {name} is never {to} {} or so; \
             adhesion or resistance to rolling (contact.rolling, preparation.rolling_friction) makes looser samples, and granum limits CASE tells \
             what compaction reaches",
            shown(CARRIES)
        )
    })
}

/// Solid fraction of spheres that were compacted without order.
const RANDOM_PACKING: f64 = 0.64;

/// The largest solid fraction that the grains can have at the stress of the sample, if a bound is known.
fn densest(case: &Case) -> Option<f64> {
    if !case.grains.are_spheres() {
        return None;
    }
    let [smallest, largest] = case.grains.size_range().ok()?;
    let ratio = largest / smallest;
    let bound = if ratio <= NEARLY_EQUAL {
        CLOSE_PACKING
    } else if ratio <= FILLED_HOLES[0] {
        FILLED_HOLES[1]
    } else {
        return None;
    };
    let left = 1.0 - strong_overlap(case)?;
    Some(bound / (left * left * left))
}

/// The overlap, over the diameter, of a strong contact at the stress of the sample.
fn strong_overlap(case: &Case) -> Option<f64> {
    let p = &case.preparation;
    let stress = STRONG_CONTACT * p.mean_stress.max(p.compaction_stress.unwrap_or(0.0));
    let diameter = case.grains.mean_diameter().ok()?;
    let limit = case.numerics.overlap_limit();
    let properties = case.properties();
    let [mut share, factor] = OVERLAPS;
    while share < limit {
        let carried = properties.stress_at_overlap(diameter, share).ok()?;
        // Where adhesion outweighs the repulsion there is no stress, and the answer is infinite.
        if carried.is_finite() && carried >= stress {
            return Some(share);
        }
        share *= factor;
    }
    Some(limit)
}

/// True if only friction and no adhesion or resistance to rolling holds the grains, with laws whose contacts are known to do neither.
fn holds_by_friction_alone(case: &Case) -> bool {
    if !case.grains.are_spheres() {
        return false;
    }
    let (contact, p) = (&case.contact, &case.preparation);
    let repels_only =
        [NormalKind::HERTZ, NormalKind::HOOKE, NormalKind::ROUGH_HERTZ].contains(&contact.normal);
    let rolls_freely =
        contact.rolling == RollingKind::NONE && p.rolling_friction.is_none_or(|friction| friction == 0.0);
    let materials = &case.grains.mixture.components;
    let sticks = contact.adhesion != AdhesionKind::NONE || p.interface_energy > 0.0;
    repels_only && rolls_freely && !sticks && materials.is_empty() && case.sample_stages().is_empty()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        Case::parse(text, "case.toml").err().map_or_else(String::new, |error| error.to_string())
    }

    #[test]
    fn what_no_sample_can_have_is_refused_in_the_measure_that_is_given() {
        let limits = "densest_void_ratio = 0.55\nloosest_void_ratio = 0.75\n";
        let loose =
            "[contact]\nnormal = \"hertz\"\ntangential = \"no-slip\"\n[preparation]\ninterface_energy = 0\n";
        for (text, parts) in [
            (
                "[preparation]\nsolid_fraction = 0.75\n".to_string(),
                &[
                    "case.toml:2:1",
                    "solid_fraction = 0.75 is denser",
                    "their solid fraction is never above 0.74",
                ][..],
            ),
            (
                "[preparation]\nvoid_ratio = 0.33\n".into(),
                &[
                    ":2:1",
                    "void_ratio = 0.33 is denser",
                    "their void ratio is never below 0.35",
                    "about 0.562",
                ],
            ),
            (
                format!("[preparation]\nrelative_density = 1.0\n{}", limits.replace("0.55", "0.3")),
                &[":2:1", "relative_density = 1 is denser", "their relative density is never above 0.8"],
            ),
            (
                format!("{loose}void_ratio = 1.1\n"),
                &[
                    ":6:1",
                    "void_ratio = 1.1 is looser",
                    "their void ratio is never above 0.923",
                    "resistance to rolling",
                ],
            ),
            (
                format!("{loose}solid_fraction = 0.45\n"),
                &["solid_fraction = 0.45 is looser", "never below 0.520"],
            ),
        ] {
            let refusal = message(&text);
            assert!(parts.iter().all(|part| refusal.contains(part)), "{text}: {refusal}");
        }
    }

    #[test]
    fn what_some_sample_can_have_is_not_refused() {
        for text in [
            "[preparation]\nsolid_fraction = 0.72\n",
            "[preparation]\nvoid_ratio = 0.36\n",
            "[preparation]\nvoid_ratio = 0.9\n",
            // Overlaps of soft grains, holes between large ones, adhesion and resistance to rolling.
            "[grains.material]\nyoungs_modulus = \"30 MPa\"\ninterface_energy = 0\n[preparation]\nmean_stress = \"100 kPa\"\nsolid_fraction = 0.76\n",
            "[grains]\ndistribution = \"two-sizes\"\nsize_ratio = 4\n[preparation]\nsolid_fraction = 0.76\n",
            "[contact]\nrolling = \"elastic-plastic\"\n[preparation]\nvoid_ratio = 1.1\n",
        ] {
            let found = message(text);
            assert!(!found.contains("denser") && !found.contains("looser"), "{text}: {found}");
        }
    }
}
