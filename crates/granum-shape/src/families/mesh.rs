//! Grains whose surface is a mesh of triangles in a file.

use crate::cover::{
    CoverMethod, CoveredBody, EuclideanMap, LargestGain, TangentSpheres, cover_mesh, in_own_axes,
};
use crate::entry::ShapeEntry;
use crate::families::capsule::PIECES;
use crate::families::sand::SHAPE_SEED;
use crate::family::{ShapeDescription, ShapeError, ShapeFamily, ShapeParameter, Spheres};
use crate::mesh;

/// Number of spheres of a cover.
pub(crate) const SPHERES: ShapeParameter = ShapeParameter { default: 20.0, ..PIECES };

const OVERLAP: ShapeParameter = ShapeParameter {
    key: "overlap",
    default: 0.7,
    bounds: [0.0, 0.95],
    whole: false,
    meaning: "Share of its radius up to which the spheres of a cover may enter a sphere.",
};

/// A mesh in a file, covered by spheres in one of several ways.
pub struct Mesh {
    description: &'static ShapeDescription,
    method: fn(&ShapeEntry) -> CoverMethod,
}

const fn description(
    name: &'static str,
    help: &'static str,
    parameters: &'static [ShapeParameter],
) -> ShapeDescription {
    ShapeDescription { name, help, parameters, takes_spheres: false, takes_file: true }
}

/// Covered by the spheres inside it that fill most of it.
pub static GAIN: Mesh = Mesh {
    description: &description(
        "mesh",
        "a mesh in an STL, OBJ or PLY file, covered by the spheres that fill most of it",
        &[SPHERES],
    ),
    method: |given| {
        CoverMethod::Gain(LargestGain { pieces: given.value(&SPHERES) as usize, ..LargestGain::default() })
    },
};

/// Covered by the Euclidean map of Angelidakis et al. (2021).
pub static EUCLIDEAN: Mesh = Mesh {
    description: &description(
        "mesh-euclidean",
        "a mesh in a file, covered by the largest spheres that fit, one after the other",
        &[SPHERES, OVERLAP],
    ),
    method: |given| {
        let (pieces, overlap) = (given.value(&SPHERES) as usize, given.value(&OVERLAP));
        CoverMethod::Euclidean(EuclideanMap { pieces, overlap, ..EuclideanMap::default() })
    },
};

/// Covered by spheres that touch it at random points after Ferellec and McDowell (2010).
pub static TANGENT: Mesh = Mesh {
    description: &description(
        "mesh-tangent",
        "a mesh in a file, covered by spheres that touch it at random points",
        &[SPHERES, SHAPE_SEED],
    ),
    method: |given| {
        let (pieces, seed) = (given.value(&SPHERES) as usize, given.value(&SHAPE_SEED) as u64);
        CoverMethod::Tangent(TangentSpheres { pieces, seed, ..TangentSpheres::default() })
    },
};

impl ShapeFamily for Mesh {
    fn description(&self) -> &'static ShapeDescription {
        self.description
    }

    fn shapes(&self, given: &ShapeEntry) -> Result<Vec<Spheres>, ShapeError> {
        self.shapes_with_notices(given, &mut Vec::new())
    }

    fn covered_bodies(
        &self,
        given: &ShapeEntry,
        notices: &mut Vec<String>,
    ) -> Result<Vec<CoveredBody>, ShapeError> {
        covered(given, notices, self, &(self.method)(given))
    }
}

/// Errors of moments of inertia above this share are worth a notice.
const ERROR: f64 = 0.05;

/// The mesh of the file, covered. Notices say how well.
fn covered(
    given: &ShapeEntry,
    notices: &mut Vec<String>,
    family: &dyn ShapeFamily,
    method: &CoverMethod,
) -> Result<Vec<CoveredBody>, ShapeError> {
    let Some(path) = &given.file else {
        let kind = family.description().name;
        let message = format!("is missing: kind = {kind:?} needs one, e.g. file = \"grain.stl\"");
        return Err(ShapeError::new("file", message));
    };
    let mesh = mesh::read(path, notices)?;
    let cover =
        cover_mesh(&mesh, method).map_err(|why| mesh::fault(path, format!("cannot be covered: {why}")))?;
    notices.push(format!("{:?}: {}", path.display().to_string(), cover.report));
    if cover.report.inertia.iter().any(|error| error.abs() > ERROR) {
        let advice = "take more pieces, or kind = \"mesh\", which covers better than the others";
        notices.push(format!("{:?} is covered badly: {advice}", path.display().to_string()));
    }
    Ok(vec![CoveredBody::of_mesh(in_own_axes(&mesh), cover)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ShapeDescriptors;
    use crate::family::ShapeKind;
    use crate::mesh::tests::{cube, ellipsoid, text_stl};

    /// An ellipsoid in a file becomes a shape of its proportions, in whatever unit it is written, and the notice says how well.
    #[test]
    fn a_file_becomes_a_shape_of_its_proportions() {
        let folder = tempfile::tempdir().unwrap();
        for (kind, within) in
            [(ShapeKind::MESH, 0.015), (ShapeKind::MESH_EUCLIDEAN, 0.05), (ShapeKind::MESH_TANGENT, 0.05)]
        {
            let mut found_of: Vec<ShapeDescriptors> = Vec::new();
            for unit in [1.0, 1e-3] {
                let path = folder.path().join(format!("{unit}.stl"));
                let mesh = ellipsoid([unit, 0.8 * unit, 0.6 * unit], 3);
                std::fs::write(&path, text_stl(&mesh)).unwrap();
                let entry = ShapeEntry { file: Some(path), ..ShapeEntry::new(kind) };
                let (shapes, notices) = entry.shapes_with_notices().unwrap();
                assert!(notices[0].contains("20 spheres, found with an error of the volume"), "{notices:?}");
                assert_eq!(shapes.len(), 1);
                let found = ShapeDescriptors::new(&shapes[0]);
                assert!(
                    (found.elongation - 0.8).abs() < within && (found.flatness - 0.75).abs() < within,
                    "{found:?}"
                );
                found_of.push(found);
            }
            let [a, b] = [found_of[0].sphericity, found_of[1].sphericity];
            assert!((a - b).abs() < 0.01, "{found_of:?}");
        }
    }

    /// Few random spheres in a cube are a bad cover, which a notice says.
    #[test]
    fn a_bad_cover_is_told() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cube.stl");
        std::fs::write(&path, text_stl(&cube([0.0; 3], 1.0))).unwrap();
        let told = |kind: ShapeKind| {
            let entry = ShapeEntry { file: Some(path.clone()), ..ShapeEntry::new(kind) }.with("pieces", 9.0);
            entry.shapes_with_notices().unwrap().1.iter().any(|notice| notice.contains("is covered badly"))
        };
        assert!(told(ShapeKind::MESH_TANGENT) && !told(ShapeKind::MESH));
    }

    #[test]
    fn a_missing_file_is_named() {
        let said = |entry: ShapeEntry| entry.shapes().unwrap_err().to_string();
        assert!(
            said(ShapeEntry::new(ShapeKind::MESH)).contains("file is missing: kind = \"mesh\" needs one")
        );
        let file = Some("/nowhere/a.stl".into());
        assert!(said(ShapeEntry { file, ..ShapeEntry::new(ShapeKind::MESH) }).contains("cannot be read"));
    }

    /// A file that changed is read again.
    #[test]
    fn a_changed_file_is_another_shape() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grain.stl");
        let entry =
            ShapeEntry { file: Some(path.clone()), ..ShapeEntry::new(ShapeKind::MESH) }.with("pieces", 5.0);
        let made = |long: f64| {
            std::fs::write(&path, text_stl(&ellipsoid([long, 1.0, 1.0], 2))).unwrap();
            entry.shapes().unwrap()
        };
        assert_ne!(made(1.5), made(2.0));
    }
}
