//! Which grain of a sample has which shape, and how large it is.
//!
//! Shapes are assigned in the order of falling size: each grain gets the shape that is farthest behind its share of the mass. So shares are
//! met as closely as whole grains can, in every range of sizes, and no random numbers are used.

use granum_shape::{RigidShape, ShapeDescriptors, ShapeEntry, ShapeError, ShapeOfSpheres, SizeMeasure};

use crate::config::Grains;

/// The shapes of the grains of a sample.
#[derive(Clone, Debug)]
pub(crate) struct GrainShapes {
    /// The different shapes, whose unit of length is the diameter of the sphere of equal volume.
    pub(crate) shapes: Vec<RigidShape>,
    /// The shape of each grain.
    pub(crate) of_grains: Vec<usize>,
    /// Factor on the lengths of its shape, m: its diameter by volume.
    pub(crate) scales: Vec<f64>,
}

/// A shape that grains can have.
struct Candidate<'a> {
    entry: &'a ShapeEntry,
    share: f64,
    /// Volume of a grain over the third power of its given diameter.
    volume: f64,
    /// Diameter by volume over the given diameter.
    scale: f64,
}

impl Candidate<'_> {
    fn suits(&self, diameter: f64, material: Option<&str>) -> bool {
        let entry = self.entry;
        entry.material.as_deref().is_none_or(|name| material == Some(name))
            && entry.smallest.is_none_or(|smallest| diameter >= smallest)
            && entry.largest.is_none_or(|largest| diameter <= largest)
    }
}

impl Grains {
    /// True if all grains are spheres.
    ///
    /// ```
    /// use granum_dem::config::Grains;
    /// use granum_dem::shape::{ShapeEntry, ShapeKind};
    ///
    /// assert!(Grains::default().are_spheres());
    /// let grains = Grains::default().with(|grains| grains.shapes = vec![ShapeEntry::new(ShapeKind::DIMER)]);
    /// assert!(!grains.are_spheres());
    /// ```
    pub fn are_spheres(&self) -> bool {
        self.shapes.iter().all(|entry| entry.kind == granum_shape::ShapeKind::SPHERE)
    }

    /// Refuses impossible shapes, and grains that none of the shapes suits.
    ///
    /// # Errors
    /// The first key that is wrong, and what would be right.
    pub fn check_shapes(&self) -> Result<(), ShapeError> {
        if self.shapes.is_empty() {
            return Ok(());
        }
        let sum: f64 = self.shapes.iter().map(|entry| entry.share).sum();
        if !(self.shapes.iter().all(|entry| entry.share > 0.0) && (sum - 1.0).abs() < 1e-9) {
            return Err(ShapeError::new(
                "share",
                format!("of all shapes sum to {sum}; they must be positive and sum to 1"),
            ));
        }
        let names: Vec<&str> =
            self.mixture.components.iter().map(|component| component.name.as_str()).collect();
        for entry in &self.shapes {
            entry.check()?;
            if let Some(name) = entry.material.as_deref().filter(|name| !names.contains(name)) {
                let known = if names.is_empty() { "none".to_string() } else { names.join(", ") };
                return Err(ShapeError::new(
                    "material",
                    format!("names {name:?}, which is no material; there are {known}"),
                ));
            }
        }
        let made = self.made()?;
        let candidates = self.candidates(&made);
        let materials = if names.is_empty() { vec![None] } else { names.into_iter().map(Some).collect() };
        for diameter in self.size_range().unwrap_or([self.diameter; 2]) {
            for material in &materials {
                if !candidates.iter().any(|candidate| candidate.suits(diameter, *material)) {
                    return Err(no_shape(diameter, *material));
                }
            }
        }
        Ok(())
    }

    fn made(&self) -> Result<Vec<std::sync::Arc<[ShapeOfSpheres]>>, ShapeError> {
        self.shapes.iter().map(ShapeEntry::shapes).collect()
    }

    fn candidates<'a>(&'a self, made: &[std::sync::Arc<[ShapeOfSpheres]>]) -> Vec<Candidate<'a>> {
        let mut candidates = Vec::new();
        for (entry, shapes) in self.shapes.iter().zip(made) {
            for shape in shapes.iter() {
                let scale = match self.size_measure {
                    SizeMeasure::Volume => 1.0,
                    SizeMeasure::Sieve => 1.0 / ShapeDescriptors::new(shape).sieve_diameter(),
                };
                let share = entry.share / shapes.len() as f64;
                candidates.push(Candidate {
                    entry,
                    share,
                    volume: scale * scale * scale * shape.shape.volume,
                    scale,
                });
            }
        }
        candidates
    }

    /// The different shapes of the grains, whose unit of length is the diameter of the sphere of equal volume, each with its share of the
    /// mass; empty for spheres.
    ///
    /// # Errors
    /// As [`Grains::check_shapes`].
    pub fn shapes_with_shares(&self) -> Result<Vec<(ShapeOfSpheres, f64)>, ShapeError> {
        let made = self.made()?;
        let each = self.shapes.iter().zip(&made).flat_map(|(entry, shapes)| {
            let share = entry.share / shapes.len() as f64;
            shapes.iter().map(move |shape| (shape.clone(), share))
        });
        Ok(each.collect())
    }

    /// Number of spheres of the grains of a sample: the number of grains if all are spheres.
    ///
    /// # Errors
    /// As [`Grains::check_shapes`].
    pub fn pieces(&self) -> Result<usize, ShapeError> {
        let shapes = self.shapes_with_shares()?;
        if shapes.is_empty() {
            return Ok(self.count);
        }
        let mean: f64 = shapes.iter().map(|(shape, share)| share * shape.shape.pieces.len() as f64).sum();
        Ok((self.count as f64 * mean).ceil() as usize)
    }

    /// Radius of the smallest piece of a grain over its diameter: 0.5 for spheres.
    ///
    /// # Errors
    /// As [`Grains::check_shapes`].
    pub fn smallest_piece(&self) -> Result<f64, ShapeError> {
        let made = self.made()?;
        let candidates = self.candidates(&made);
        let shapes = made.iter().flat_map(|shapes| shapes.iter());
        let least = candidates.iter().zip(shapes).flat_map(|(candidate, shape)| {
            shape.shape.pieces.iter().map(|piece| candidate.scale * piece.radius)
        });
        Ok(least.fold(0.5, f64::min))
    }

    /// The shapes of grains with these diameters, m, which fall, and these materials, which are empty where there is one.
    pub(crate) fn assign_shapes(
        &self,
        diameters: &[f64],
        materials: &[u8],
    ) -> Result<GrainShapes, ShapeError> {
        let made = self.made()?;
        let candidates = self.candidates(&made);
        let name = |k: usize| {
            let material = *materials.get(k)? as usize;
            Some(self.mixture.components.get(material)?.name.as_str())
        };
        // For each set of candidates that occurs: its members and the volume that each has so far.
        let mut groups: Vec<(Vec<usize>, Vec<f64>)> = Vec::new();
        let (mut of_grains, mut scales) =
            (Vec::with_capacity(diameters.len()), Vec::with_capacity(diameters.len()));
        for (k, &diameter) in diameters.iter().enumerate() {
            let suits = |c: &usize| candidates[*c].suits(diameter, name(k));
            let members: Vec<usize> = (0..candidates.len()).filter(suits).collect();
            let place = groups.iter().position(|(known, _)| *known == members).unwrap_or_else(|| {
                groups.push((members.clone(), vec![0.0; members.len()]));
                groups.len() - 1
            });
            let (members, volumes) = &mut groups[place];
            let Some(chosen) = farthest_behind(&candidates, members, volumes, diameter) else {
                return Err(no_shape(diameter, name(k)));
            };
            volumes[chosen] += candidates[members[chosen]].volume * diameter * diameter * diameter;
            of_grains.push(members[chosen]);
            scales.push(candidates[members[chosen]].scale * diameter);
        }
        let shapes = made.iter().flat_map(|shapes| shapes.iter().map(|shape| shape.shape.clone())).collect();
        Ok(GrainShapes { shapes, of_grains, scales })
    }
}

/// The member that would be farthest behind its share of the volume without the next grain.
fn farthest_behind(
    candidates: &[Candidate],
    members: &[usize],
    volumes: &[f64],
    diameter: f64,
) -> Option<usize> {
    let shares: f64 = members.iter().map(|&c| candidates[c].share).sum();
    let all: f64 = volumes.iter().sum();
    let cube = diameter * diameter * diameter;
    let behind = |m: usize| {
        let candidate = &candidates[members[m]];
        let grain = candidate.volume * cube;
        // Over the volume of a grain, so that large and small shapes take turns.
        (candidate.share / shares * (all + grain) - volumes[m]) / grain
    };
    (0..members.len()).max_by(|&a, &b| behind(a).total_cmp(&behind(b)).then(b.cmp(&a)))
}

fn no_shape(diameter: f64, material: Option<&str>) -> ShapeError {
    let of = material.map_or(String::new(), |name| format!(" of the material {name:?}"));
    let message = format!(
        "leaves grains{of} of the diameter {diameter:.3e} m without a shape: add one without material, smallest and largest"
    );
    ShapeError::new("shape", message)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixture::{Component, Mixture};
    use granum_shape::ShapeKind;

    fn grains(shapes: Vec<ShapeEntry>) -> Grains {
        Grains::default().with(|grains| grains.shapes = shapes)
    }

    #[test]
    fn shares_are_of_the_mass_in_every_range_of_sizes() {
        let shapes = vec![
            ShapeEntry::new(ShapeKind::SPHERE).with_share(0.3),
            ShapeEntry::new(ShapeKind::DIMER).with_share(0.7),
        ];
        let grains = grains(shapes);
        grains.check_shapes().unwrap();
        let diameters: Vec<f64> = (0..400).map(|k| 2e-4 - 2e-7 * k as f64).collect();
        let assigned = grains.assign_shapes(&diameters, &[]).unwrap();
        for half in [0..200, 200..400] {
            let volume = |wanted: usize| -> f64 {
                half.clone()
                    .filter(|&k| assigned.of_grains[k] == wanted)
                    .map(|k| assigned.scales[k].powi(3))
                    .sum()
            };
            let share = volume(0) / (volume(0) + volume(1));
            assert!((share - 0.3).abs() < 0.01, "{share}");
        }
    }

    #[test]
    fn materials_and_sizes_have_shapes_of_their_own() {
        let mut shapes = vec![ShapeEntry::new(ShapeKind::DIMER), ShapeEntry::new(ShapeKind::TETRAPOD)];
        shapes.iter_mut().for_each(|entry| entry.share = 0.5);
        shapes[0].material = Some("b".into());
        shapes[1].largest = Some(1.5e-4);
        let mut grains = grains(shapes);
        let said = |grains: &Grains| grains.check_shapes().unwrap_err().to_string();
        assert!(said(&grains).contains("material names \"b\", which is no material"), "{}", said(&grains));
        let material = grains.material;
        grains.mixture =
            Mixture::new([Component::new("a", 0.5, material), Component::new("b", 0.5, material)]);
        grains.diameter = 2e-4;
        assert!(
            said(&grains).contains("of the material \"a\" of the diameter 2.000e-4 m"),
            "{}",
            said(&grains)
        );
        let assigned = grains.assign_shapes(&[2e-4, 1e-4, 1e-4, 1e-4], &[1, 0, 0, 1]).unwrap();
        assert_eq!(assigned.of_grains[..3], [0, 1, 1]);
        assert!(grains.assign_shapes(&[2e-4], &[0]).is_err());
    }

    #[test]
    fn sizes_by_the_sieve_make_long_grains_larger() {
        let mut grains = grains(vec![ShapeEntry::new(ShapeKind::DIMER).with("separation", 1.0)]);
        let by_volume = grains.assign_shapes(&[1e-4], &[]).unwrap().scales[0];
        assert_eq!(by_volume, 1e-4);
        grains.size_measure = SizeMeasure::Sieve;
        let by_sieve = grains.assign_shapes(&[1e-4], &[]).unwrap();
        // The spheres pass the hole.
        let radius = by_sieve.scales[0] * by_sieve.shapes[0].pieces[0].radius;
        assert!((2.0 * radius / 1e-4 - 1.0).abs() < 1e-6, "{radius}");
    }
}
