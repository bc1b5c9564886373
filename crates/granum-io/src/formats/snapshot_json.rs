//! Snapshots of granum's own run folders: the file `NAME.json` stands for itself and the two tables beside it.

use std::path::Path;

use granum_core::{Part, Parts};

use super::result::{FileContact, Frame, FrameCell, ReadOptions, ResultFormat};
use crate::error::{Error, Result};
use crate::run::Run;
use crate::snapshot::read_snapshot;

/// The format.
pub(super) struct SnapshotJson;

impl ResultFormat for SnapshotJson {
    fn name(&self) -> &'static str {
        "granum snapshot"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["json"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        let text = String::from_utf8_lossy(head);
        text.starts_with('{') && text.contains("\"format\"") && text.contains("\"assembly\"")
    }
    fn read(&self, path: &Path, _: &ReadOptions) -> Result<Vec<Frame>> {
        let (Some(folder), Some(name)) = (path.parent(), path.file_stem()) else {
            return Err(Error::content(path, "is no snapshot"));
        };
        // A snapshot in the folder of its run is checked against the record of the run.
        let run = folder.parent().and_then(|run| Run::of_snapshots(run, folder));
        let assembly = match run {
            Some(run) => run.snapshot(&name.to_string_lossy())?,
            None => read_snapshot(folder, &name.to_string_lossy())?,
        };
        let id = |index: usize| assembly.bodies.get(index).map_or(0, |grain| grain.id);
        let contact = |contact: &granum_core::assembly::Contact| FileContact {
            first: id(contact.i),
            second: id(contact.j),
            branch: Some(contact.branch),
            normal: Some(contact.normal),
            normal_force: Some(contact.normal_force),
            tangential_force: Some(contact.tangential_force),
            approach: Some(contact.approach),
            energies: Some([contact.normal_energy, contact.tangential_energy]),
            sliding: Some(contact.sliding),
            ..FileContact::default()
        };
        let mut frame = Frame { step: Some(assembly.step), time: Some(assembly.time), ..Frame::default() };
        frame.cell = Some(FrameCell { origin: [0.0; 3], edges: assembly.cell });
        frame.contacts = Some(assembly.contacts.iter().map(contact).collect());
        frame.parts = Parts::new(&[
            Part::Positions,
            Part::Radii,
            Part::Masses,
            Part::Velocities,
            Part::Spins,
            Part::ResultantForces,
        ]);
        frame.grains = assembly.spheres().ok_or_else(|| {
            Error::content(path, "has grains of several pieces, which are not read as spheres")
        })?;
        frame.materials = assembly.materials;
        Ok(vec![frame])
    }
}
