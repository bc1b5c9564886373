//! Whether several tests are of one material: only then a line through their late states says something of it.

use std::collections::BTreeMap;

use granum_io::Case;
use granum_io::case::ParameterValue;

/// Keys that belong to a sample, not to its material.
const OF_SAMPLE: [&str; 1] = ["grains.count"];

/// The keys of grains, materials and contact laws in which cases differ; empty where all tests are of one material.
///
/// ```
/// use granum_io::Case;
/// use granum_run::strength::one_material::differing;
///
/// let paper = Case::default();
/// let mut denser = paper.clone();
/// denser.set("preparation.mean_stress", "50 kPa")?;
/// assert!(differing(&[&paper, &denser]).is_empty());
/// denser.set("grains.material.friction", "0.5")?;
/// assert_eq!(differing(&[&paper, &denser]), ["grains.material.friction"]);
/// # Ok::<(), granum_io::Error>(())
/// ```
pub fn differing(cases: &[&Case]) -> Vec<String> {
    let of_material = |key: &str| {
        let sections = ["grains.", "material.", "pair.", "contact."];
        sections.iter().any(|section| key.starts_with(section)) && !OF_SAMPLE.contains(&key)
    };
    let all: Vec<BTreeMap<String, ParameterValue>> = (cases.iter())
        .map(|case| {
            let own = case.parameters().into_iter().filter(|found| of_material(&found.key));
            own.map(|found| (found.key, found.value)).collect()
        })
        .collect();
    let mut keys: Vec<&String> = all.iter().flat_map(BTreeMap::keys).collect();
    keys.sort_unstable();
    keys.dedup();
    let differs = |key: &&String| all.windows(2).any(|pair| pair[0].get(*key) != pair[1].get(*key));
    keys.into_iter().filter(differs).cloned().collect()
}
