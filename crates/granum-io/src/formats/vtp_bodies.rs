//! Grains as bodies in VTK PolyData for ParaView: each is one vertex in its centre of mass, whatever its number of pieces, for glyphs.
//!
//! Point data: `id`; `radius` of the sphere of equal volume; `pieces`, their number; `orientation`, the rotation from the principal axes of the
//! grain to those of space as a quaternion in the order **w, x, y, z** (filter Glyph of ParaView, orientation mode Quaternion; a sphere has 1, 0, 0, 0);
//! `principal_inertia`, in the same axes, `mass`, `velocity` (without the homogeneous part), `angular_velocity` in the axes of space, `force` and
//! `torque` about the centre, where they are known. Field data as in [files of pieces](super::vtp). The format is chosen by its name,
//! `vtp-bodies`; read again, the grains are spheres of equal volume.

use std::fmt::Write as _;
use std::path::Path;

use granum_core::Part;
use granum_core::assembly::{Assembly, Body, Rigid};
use granum_core::rotation::IDENTITY;

use super::result::{Frame, ObservedAssembly, ReadOptions, ResultFormat};
use super::vtk_xml::VtkXml;
use super::vtp::{BEGINNING, array, cells, fields, write_one};
use crate::error::Result;

/// The format.
pub struct VtpBodies;

impl ResultFormat for VtpBodies {
    fn name(&self) -> &'static str {
        "VTP bodies"
    }
    fn extensions(&self) -> &'static [&'static str] {
        // The extension is that of the files of pieces.
        &[]
    }
    fn recognises(&self, _: &[u8]) -> bool {
        false
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        VtkXml.read(path, options)
    }
    fn holds_one_instant(&self) -> bool {
        true
    }
    fn is_written(&self) -> bool {
        true
    }
    fn holds_bodies(&self) -> bool {
        true
    }
    fn write(&self, path: &Path, observations: &[ObservedAssembly]) -> Result<()> {
        write_one(path, observations, text)
    }
}

/// An array with the part of an assembly that it needs and its number of components.
type Quantity = (Part, &'static str, usize, fn(&Assembly, &Body) -> Vec<f64>);

const QUANTITIES: [Quantity; 9] = [
    (Part::Positions, "id", 1, |_, body| vec![body.id as f64]),
    (Part::Radii, "radius", 1, |_, body| vec![body.equivalent_radius]),
    (Part::Positions, "orientation", 4, |assembly, body| {
        rigid(assembly, body).map_or(IDENTITY, |rigid| rigid.orientation).to_vec()
    }),
    (Part::Masses, "mass", 1, |_, body| vec![body.mass]),
    (Part::Masses, "principal_inertia", 3, |assembly, body| inertia(assembly, body).to_vec()),
    (Part::Velocities, "velocity", 3, |_, body| body.velocity.to_vec()),
    (Part::Spins, "angular_velocity", 3, |_, body| body.spin.to_vec()),
    (Part::ResultantForces, "force", 3, |_, body| body.force.to_vec()),
    (Part::ResultantForces, "torque", 3, |_, body| body.torque.to_vec()),
];

fn rigid<'a>(assembly: &'a Assembly, body: &Body) -> Option<&'a Rigid> {
    assembly.rigid.get(body.rigid? as usize)
}

/// The principal moments of inertia, kg m2: `2/5 m R^2` of a sphere.
fn inertia(assembly: &Assembly, body: &Body) -> [f64; 3] {
    let radius = body.equivalent_radius;
    rigid(assembly, body).map_or([0.4 * body.mass * radius * radius; 3], |rigid| rigid.inertia)
}

fn text(observation: &ObservedAssembly) -> String {
    let (assembly, parts) = (&observation.assembly, observation.parts);
    let count = assembly.bodies.len();
    let mut xml = String::from(BEGINNING);
    fields(&mut xml, observation);
    let _ = writeln!(
        xml,
        "<Piece NumberOfPoints=\"{count}\" NumberOfVerts=\"{count}\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
         NumberOfPolys=\"0\">\n<PointData>"
    );
    for (_, name, components, values) in QUANTITIES.iter().filter(|(part, _, _, _)| parts.has(*part)) {
        let values: Vec<f64> = assembly.bodies.iter().flat_map(|body| values(assembly, body)).collect();
        array(&mut xml, name, *components, &values);
    }
    array(&mut xml, "pieces", 1, &pieces(assembly));
    xml.push_str("</PointData>\n<Points>\n");
    let place = |body: &Body| (0..3).map(|a| body.position[a] + observation.origin[a]).collect::<Vec<f64>>();
    array(&mut xml, "Points", 3, &assembly.bodies.iter().flat_map(place).collect::<Vec<f64>>());
    xml.push_str("</Points>\n");
    cells(&mut xml, "Verts", 0, count, 1);
    xml.push_str("</Piece>\n</PolyData>\n</VTKFile>\n");
    xml
}

/// The number of pieces of each body.
fn pieces(assembly: &Assembly) -> Vec<f64> {
    let mut count = vec![0.0; assembly.bodies.len()];
    for piece in &assembly.pieces {
        if let Some(count) = count.get_mut(piece.body) {
            *count += 1.0;
        }
    }
    count
}
