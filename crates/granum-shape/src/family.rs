//! Families of shapes: what a case file can name as `grains.shape.kind`.
//!
//! A family turns its parameters, which are pure numbers, into spheres. Only the proportions of a shape matter: its size follows from the
//! size distribution of the grains.

use std::fmt;

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::cover::CoveredBody;
use crate::entry::ShapeEntry;
use crate::families;
pub use crate::shape_error::ShapeError;
pub use crate::union_of_spheres::Spheres;

/// A parameter of a family, a pure number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeParameter {
    /// Key in the section `[grains.shape]` of a case file.
    pub key: &'static str,
    /// Default value.
    pub default: f64,
    /// Smallest and largest value.
    pub bounds: [f64; 2],
    /// True if only whole numbers are possible.
    pub whole: bool,
    /// Its meaning, in one or two sentences.
    pub meaning: &'static str,
}

/// Description of a family.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapeDescription {
    /// Name in case files, e.g. `dimer`.
    pub name: &'static str,
    /// What it is, in a few words.
    pub help: &'static str,
    /// Its parameters.
    pub parameters: &'static [ShapeParameter],
    /// True if its spheres are given as a list.
    pub takes_spheres: bool,
    /// True if it is read from a file. The case that results contains the spheres, and no longer needs the file.
    pub takes_file: bool,
}

/// A family of shapes.
pub trait ShapeFamily: Sync {
    /// Its name, meaning and parameters.
    fn description(&self) -> &'static ShapeDescription;

    /// The spheres of its shapes: mostly of one, and of several where grains of one kind differ from each other.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError>;

    /// The same, with what its user should know: what was mended or left out, and how well spheres stand for a file.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    fn shapes_with_notices(
        &self,
        given: &ShapeEntry,
        notices: &mut Vec<String>,
    ) -> Result<Vec<Spheres>, ShapeError> {
        if !self.description().takes_file {
            return self.shapes(given);
        }
        Ok(self.covered_bodies(given, notices)?.into_iter().map(|body| body.cover.spheres).collect())
    }

    /// The bodies of the file of a family that is read from one, with the spheres that stand for them, in the order of
    /// [`ShapeFamily::shapes`]; none of any other family.
    ///
    /// # Errors
    /// The key that is wrong, and what would be right.
    fn covered_bodies(
        &self,
        _given: &ShapeEntry,
        _notices: &mut Vec<String>,
    ) -> Result<Vec<CoveredBody>, ShapeError> {
        Ok(Vec::new())
    }
}

/// The choice of a family. Its name identifies it in files.
#[derive(Clone, Copy)]
pub struct ShapeKind(&'static dyn ShapeFamily);

macro_rules! kinds {
    ($($name:ident = $type:path,)*) => {
        impl ShapeKind {
            $(
                #[doc = concat!("[`", stringify!($type), "`].")]
                pub const $name: ShapeKind = ShapeKind(&$type);
            )*
        }

        /// All families that a name in a case file can stand for.
        pub const ALL: &[ShapeKind] = &[$(ShapeKind::$name,)*];
    };
}

kinds! {
    SPHERE = families::sphere::Sphere,
    AGGLOMERATE = families::agglomerate::Agglomerate,
    DIMER = families::dimer::Dimer,
    CAPSULE = families::capsule::Capsule,
    ELLIPSOID = families::ellipsoid::Ellipsoid,
    SAND = families::sand::Sand,
    MESH = families::mesh::GAIN,
    MESH_EUCLIDEAN = families::mesh::EUCLIDEAN,
    MESH_TANGENT = families::mesh::TANGENT,
    TETRAPOD = families::tetrapod::Tetrapod,
    VOXELS = families::voxels::Voxels,
    PIECES = families::pieces::Pieces,
}

impl ShapeKind {
    /// A family of the caller's own, which a program can use without a name in case files.
    pub const fn new(family: &'static dyn ShapeFamily) -> ShapeKind {
        ShapeKind(family)
    }

    /// The family.
    pub fn family(&self) -> &'static dyn ShapeFamily {
        self.0
    }

    /// Its name in case files.
    pub fn name(&self) -> &'static str {
        self.0.description().name
    }

    /// The family of a name.
    pub fn named(name: &str) -> Option<ShapeKind> {
        ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

/// The parameters of all families, each key once, with the families that have it.
pub fn parameters() -> Vec<(&'static ShapeParameter, Vec<ShapeKind>)> {
    let mut all: Vec<(&'static ShapeParameter, Vec<ShapeKind>)> = Vec::new();
    for kind in ALL {
        for parameter in kind.0.description().parameters {
            match all.iter_mut().find(|(known, _)| known.key == parameter.key) {
                Some((_, kinds)) => kinds.push(*kind),
                None => all.push((parameter, vec![*kind])),
            }
        }
    }
    all
}

impl PartialEq for ShapeKind {
    fn eq(&self, other: &ShapeKind) -> bool {
        self.name() == other.name()
    }
}

impl Eq for ShapeKind {}

impl Default for ShapeKind {
    fn default() -> Self {
        ShapeKind::SPHERE
    }
}

impl fmt::Debug for ShapeKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl Serialize for ShapeKind {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(self.name())
    }
}

impl<'d> Deserialize<'d> for ShapeKind {
    fn deserialize<D: Deserializer<'d>>(from: D) -> Result<ShapeKind, D::Error> {
        let name = String::deserialize(from)?;
        ShapeKind::named(&name)
            .ok_or_else(|| D::Error::custom(format!("no family of shapes is called {name:?}")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// One key has one meaning for the bounds that a case file checks.
    #[test]
    fn families_agree_about_the_keys_that_they_share() {
        for kind in ALL {
            let description = kind.family().description();
            for parameter in description.parameters {
                let (first, _) =
                    parameters().into_iter().find(|(known, _)| known.key == parameter.key).unwrap();
                assert_eq!(
                    (first.bounds, first.whole),
                    (parameter.bounds, parameter.whole),
                    "{}",
                    parameter.key
                );
                assert!((parameter.bounds[0]..=parameter.bounds[1]).contains(&parameter.default));
            }
            assert_eq!(ShapeKind::named(description.name), Some(*kind));
        }
    }
}
