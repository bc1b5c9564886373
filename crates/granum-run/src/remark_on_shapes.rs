//! A sentence about the shapes of the grains of a case.

use granum_dem::shape::{ShapeDescriptors, ShapeEntry, SizeMeasure};
use granum_io::Case;

/// Largest number of shapes that are told one by one.
const TOLD: usize = 4;

/// A sentence about the shapes of the grains of a case, their spheres and what their size means, unless all are spheres.
pub fn remark_on_shapes(case: &Case) -> Option<String> {
    let grains = &case.grains;
    if grains.are_spheres() {
        return None;
    }
    let measure = match grains.size_measure {
        SizeMeasure::Volume => "those of the spheres of equal volume",
        SizeMeasure::Sieve => "those of the sieve",
    };
    let told = match grains.shapes.len() {
        1..=TOLD => one_by_one(&grains.shapes)?,
        count => format!("of {count} shapes: {}", together(&grains.shapes)?),
    };
    Some(format!("the grains are {told}; their diameters are {measure}"))
}

/// Each entry with its share, its spheres and its sphericity.
fn one_by_one(entries: &[ShapeEntry]) -> Option<String> {
    let one = |entry: &ShapeEntry| {
        let share = match entries.len() {
            1 => String::new(),
            _ => format!(" ({:.1} % of the mass)", 100.0 * entry.share),
        };
        Some(format!("{}{share}, {}", entry.kind.name(), together(std::slice::from_ref(entry))?))
    };
    Some(entries.iter().map(one).collect::<Option<Vec<_>>>()?.join(", and "))
}

/// The numbers of spheres, and the mean sphericity by mass.
fn together(entries: &[ShapeEntry]) -> Option<String> {
    let mut all: Vec<(usize, ShapeDescriptors, f64)> = Vec::new();
    for entry in entries {
        let (shapes, found) = (entry.shapes().ok()?, entry.descriptors().ok()?);
        let share = entry.share / shapes.len() as f64;
        let each = shapes.iter().zip(found.iter());
        all.extend(each.map(|(shape, found)| (shape.shape.pieces.len(), *found, share)));
    }
    let (least, most) = (all.iter().map(|one| one.0).min()?, all.iter().map(|one| one.0).max()?);
    let count = match (least, most) {
        (1, 1) => "1 sphere a grain".to_string(),
        _ if least == most => format!("{least} spheres a grain"),
        _ => format!("{least} to {most} spheres a grain"),
    };
    let mass: f64 = all.iter().map(|one| one.2).sum();
    let sphericity = all.iter().map(|one| one.2 * one.1.sphericity).sum::<f64>() / mass;
    let mean = if all.len() > 1 { "a mean sphericity of" } else { "a sphericity of" };
    Some(format!("with {count} and {mean} {sphericity:.3}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(text: &str) -> Option<String> {
        remark_on_shapes(&Case::parse(text, "case.toml").unwrap())
    }

    #[test]
    fn shapes_are_told_with_their_shares() {
        assert_eq!(said(""), None);
        let dimers = said("[grains]\nsize_measure = 'sieve'\n[grains.shape]\nkind = 'dimer'\n").unwrap();
        assert_eq!(
            dimers,
            "the grains are dimer, with 2 spheres a grain and a sphericity of 0.945; their diameters are those of the sieve"
        );
        let two = said("[[grains.shape]]\nshare = 0.25\n[[grains.shape]]\nkind = 'capsule'\n").unwrap();
        assert!(two.contains("sphere (25.0 % of the mass), with 1 sphere a grain"), "{two}");
        assert!(two.contains("and capsule (75.0 % of the mass), with 3 spheres a grain"), "{two}");
        let tables: Vec<String> = [0.3, 0.4, 0.5, 0.6, 0.7]
            .map(|separation| format!("[[grains.shape]]\nkind = 'dimer'\nseparation = {separation}\n"))
            .into();
        let many = said(&tables.concat()).unwrap();
        assert!(many.contains("of 5 shapes: with 2 spheres a grain and a mean sphericity of 0.9"), "{many}");
    }
}
