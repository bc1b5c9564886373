//! One shape of a case: a family with the values of its parameters, and which grains have it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

use serde::{Deserialize, Serialize};

use crate::descriptors::ShapeDescriptors;
use crate::family::{ShapeError, ShapeKind, ShapeParameter};
use crate::union_of_spheres::ShapeOfSpheres;

/// Number of sets of shapes that are kept, so that they are not made again for each sample.
const KEPT: usize = 64;

/// What the size of a grain means that is not a sphere.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SizeMeasure {
    /// The diameter of the sphere of equal volume.
    #[default]
    Volume,
    /// The edge of the smallest square hole through which the grain passes: its intermediate length.
    Sieve,
}

/// One shape of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ShapeEntry {
    /// Its family.
    pub kind: ShapeKind,
    /// Values given to parameters of the family; the others have their defaults.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub values: BTreeMap<String, f64>,
    /// The spheres of a family that takes them as a list: centre and radius, in any unit of length.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spheres: Vec<[f64; 4]>,
    /// The file of a family that is read from one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<PathBuf>,
    /// Share of the mass of the grains.
    pub share: f64,
    /// The material whose grains have this shape; all if none is given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub material: Option<String>,
    /// Smallest diameter of the grains that have this shape, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallest: Option<f64>,
    /// Largest diameter of the grains that have this shape, m.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub largest: Option<f64>,
}

impl Default for ShapeEntry {
    fn default() -> Self {
        ShapeEntry::new(ShapeKind::SPHERE)
    }
}

/// Shapes that were made, with what their user should know, and their descriptors once somebody asked for them.
#[derive(Clone)]
struct Made {
    entry: ShapeEntry,
    shapes: Arc<[ShapeOfSpheres]>,
    notices: Vec<String>,
    descriptors: Option<Arc<[ShapeDescriptors]>>,
}

/// The most recent ones, the last at the end.
static MADE: Mutex<Vec<Made>> = Mutex::new(Vec::new());

impl ShapeEntry {
    /// A family with its defaults, for all grains.
    pub fn new(kind: ShapeKind) -> ShapeEntry {
        ShapeEntry {
            kind,
            values: BTreeMap::new(),
            spheres: Vec::new(),
            file: None,
            share: 1.0,
            material: None,
            smallest: None,
            largest: None,
        }
    }

    /// The same with a value for a parameter.
    pub fn with(mut self, key: &str, value: f64) -> ShapeEntry {
        self.values.insert(key.to_string(), value);
        self
    }

    /// The same with another share of the mass.
    pub fn with_share(self, share: f64) -> ShapeEntry {
        ShapeEntry { share, ..self }
    }

    /// The value of a parameter.
    pub fn value(&self, parameter: &ShapeParameter) -> f64 {
        self.values.get(parameter.key).copied().unwrap_or(parameter.default)
    }

    /// The value of a parameter of a family; not a number where the family does not have it.
    pub fn value_of(&self, key: &str) -> f64 {
        let known = self.kind.family().description().parameters;
        known
            .iter()
            .find(|parameter| parameter.key == key)
            .map_or(f64::NAN, |parameter| self.value(parameter))
    }

    /// True if all grains are spheres and nothing more is said.
    pub fn is_plain_sphere(&self) -> bool {
        *self == ShapeEntry::default()
    }

    /// Refuses values that the family does not have or that are out of bounds.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    pub fn check(&self) -> Result<(), ShapeError> {
        let description = self.kind.family().description();
        let name = description.name;
        for (key, value) in &self.values {
            let every = crate::family::parameters();
            let Some((known, _)) = every.into_iter().find(|(known, _)| known.key == key) else {
                return Err(ShapeError::new("kind", format!("= {name:?} has no parameter {key:?}")));
            };
            if description.parameters.iter().all(|parameter| parameter.key != known.key) {
                let message = format!("means nothing with kind = {name:?}; leave it out");
                return Err(ShapeError::new(known.key, message));
            }
            let [low, high] = known.bounds;
            if !(*value >= low && *value <= high) {
                return Err(ShapeError::new(
                    known.key,
                    format!("is {value}; it must be from {low} to {high}"),
                ));
            }
            if known.whole && value.fract() != 0.0 {
                return Err(ShapeError::new(known.key, format!("is {value}; it must be a whole number")));
            }
        }
        if !self.spheres.is_empty() && !description.takes_spheres {
            let message = format!("means nothing with kind = {name:?}; write kind = \"pieces\"");
            return Err(ShapeError::new("spheres", message));
        }
        if self.file.is_some() && !description.takes_file {
            return Err(ShapeError::new("file", format!("means nothing with kind = {name:?}; leave it out")));
        }
        if let (Some(smallest), Some(largest)) = (self.smallest, self.largest)
            && smallest >= largest
        {
            return Err(ShapeError::new(
                "smallest",
                format!("= {smallest} m must be below largest = {largest} m"),
            ));
        }
        Ok(())
    }

    /// The shapes of this entry, with the diameter of the sphere of equal volume as their unit of length.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    pub fn shapes(&self) -> Result<Arc<[ShapeOfSpheres]>, ShapeError> {
        Ok(self.made()?.shapes)
    }

    /// The same, with what its user should know: what was mended or left out, and how well spheres stand for a file.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    pub fn shapes_with_notices(&self) -> Result<(Arc<[ShapeOfSpheres]>, Vec<String>), ShapeError> {
        let made = self.made()?;
        Ok((made.shapes, made.notices))
    }

    /// The descriptors of these shapes.
    ///
    /// # Errors
    /// As [`ShapeEntry::shapes`].
    pub fn descriptors(&self) -> Result<Arc<[ShapeDescriptors]>, ShapeError> {
        let mut made = self.made()?;
        if let Some(descriptors) = made.descriptors {
            return Ok(descriptors);
        }
        let descriptors: Arc<[ShapeDescriptors]> = made.shapes.iter().map(ShapeDescriptors::new).collect();
        made.descriptors = Some(descriptors.clone());
        keep(made);
        Ok(descriptors)
    }

    fn made(&self) -> Result<Made, ShapeError> {
        // Which grains have it does not matter here.
        let entry = ShapeEntry { share: 1.0, material: None, smallest: None, largest: None, ..self.clone() };
        let kept = MADE.lock().ok().and_then(|made| made.iter().find(|made| made.entry == entry).cloned());
        if let Some(made) = kept {
            return Ok(made);
        }
        let made = entry.make()?;
        keep(made.clone());
        Ok(made)
    }

    fn make(self) -> Result<Made, ShapeError> {
        self.check()?;
        let mut notices = Vec::new();
        let of_family = self.kind.family().shapes_with_notices(&self, &mut notices)?;
        let shape = |spheres: &crate::family::Spheres| {
            let shape =
                ShapeOfSpheres::new(spheres).map_err(|why| ShapeError { key: "kind", message: why })?;
            Ok(shape.scaled(0.5 / shape.shape.equivalent_radius()))
        };
        let shapes: Result<Arc<[ShapeOfSpheres]>, ShapeError> = of_family.iter().map(shape).collect();
        Ok(Made { shapes: shapes?, notices, entry: self, descriptors: None })
    }
}

/// Keeps shapes that were made, in place of the oldest ones where there are many. Those of a file are read anew, since it may change.
fn keep(new: Made) {
    let Ok(mut made) = MADE.lock() else { return };
    if new.entry.file.is_some() {
        return;
    }
    made.retain(|made| made.entry != new.entry);
    if made.len() >= KEPT {
        made.remove(0);
    }
    made.push(new);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shapes_have_the_volume_of_a_sphere_of_diameter_one() {
        for kind in crate::family::ALL {
            let description = kind.family().description();
            if description.takes_spheres || description.takes_file {
                continue;
            }
            for shape in ShapeEntry::new(*kind).shapes().unwrap().iter() {
                assert!((shape.shape.equivalent_radius() - 0.5).abs() < 1e-12, "{kind:?}");
                assert!(shape.sphericity() <= 1.0 + 1e-9, "{kind:?}");
            }
        }
    }

    #[test]
    fn what_a_family_does_not_know_is_refused() {
        let said = |entry: ShapeEntry| entry.shapes().unwrap_err().to_string();
        let dimer = ShapeEntry::new(ShapeKind::DIMER);
        assert!(said(dimer.clone().with("separation", 3.0)).starts_with("separation is 3; it must be from"));
        assert!(said(dimer.clone().with("aspect_ratio", 2.0)).starts_with("aspect_ratio means nothing with"));
        assert!(said(dimer.clone().with("colour", 2.0)).contains("has no parameter \"colour\""));
        let capsule = ShapeEntry::new(ShapeKind::CAPSULE);
        assert!(said(capsule.with("pieces", 2.5)).contains("whole number"));
        let spheres = vec![[0.0, 0.0, 0.0, 1.0]];
        assert!(said(ShapeEntry { spheres, ..dimer }).starts_with("spheres means nothing"));
        assert!(said(ShapeEntry::new(ShapeKind::PIECES)).starts_with("spheres"));
    }
}
