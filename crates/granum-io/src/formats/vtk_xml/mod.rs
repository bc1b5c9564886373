//! VTK XML files (`.vtu`, `.vtp`, `.vtm`, `.vtr`): grains, contacts and the cell as YADE's `VTKRecorder` and LIGGGHTS write them, and
//! what granum itself writes as [VTP](super::vtp).
//!
//! Arrays may be text or binary, inside the document or appended to it, plain or compressed with zlib.
//!
//! - Spheres (`NAME-spheres.N.vtu`): points with `radii`; `id`, `mass`, `linVelVec`, `angVelVec`, `forceVec` and `torqueVec` are read if
//!   they are present. Without `id` the spheres are numbered from 0. Positions in VTK files have seven digits.
//! - The cell (`NAME-pericell.N.vtu`, recorder `pericell`): a hexahedron.
//! - Contacts (`NAME-intrs.N.vtp`, recorder `intr`): lines with `forceN`; the grains are found by their positions. The file contains only
//!   the magnitudes of the components of the tangential force, without their signs: this force is known only where all of them are zero.
//! - `NAME-N.vtm` (`multiblock=True`) names the files of one instant, which are read together.
//!
//! LIGGGHTS: `dump custom/vtk` (points with `radius`, `id`, `mass`, `v`, `omega`, `f`), its `boundingBox` (`.vtr`), taken as periodic,
//! and `dump local/gran/vtk` of a `compute pair/gran/local pos id force` (lines with `id1`, `id2`, `force` on the first grain). The
//! names used by MercuryDPM (`Radius`, `Velocity`) are accepted as well.
//!
//! `N` is the time step. YADE 2023.02a writes the forces of contacts across a face of the cell twice, but not their lines (only
//! the centres, two for each contact): such contacts are found by their doubled rows.

mod decode;
mod document;
mod index;
mod interpret;

use std::path::Path;

use granum_core::input::{LARGEST_INPUT, read};

use self::document::Document;
use super::result::{Frame, ReadOptions, ResultFormat};
use crate::error::{Error, Result};

/// The format.
pub struct VtkXml;

impl ResultFormat for VtkXml {
    fn name(&self) -> &'static str {
        "VTK XML"
    }
    fn extensions(&self) -> &'static [&'static str] {
        &["vtu", "vtm", "vtr"]
    }
    fn recognises(&self, head: &[u8]) -> bool {
        String::from_utf8_lossy(head).contains("<VTKFile")
    }
    fn read(&self, path: &Path, options: &ReadOptions) -> Result<Vec<Frame>> {
        let bytes = read(path, LARGEST_INPUT).map_err(Error::file("read", path))?;
        let mut frame = match index::files(path, &bytes, options.outside)? {
            Some(files) => together(path, &files)?,
            None => read_one(path, &bytes)?,
        };
        frame.step = frame.step.or_else(|| step(path));
        Ok(vec![frame])
    }
}

fn read_one(path: &Path, bytes: &[u8]) -> Result<Frame> {
    interpret::frame(path, &Document::parse(path, bytes)?)
}

/// One frame of several files.
fn together(path: &Path, files: &[std::path::PathBuf]) -> Result<Frame> {
    let mut all = Frame::default();
    for file in files {
        let bytes = read(file, LARGEST_INPUT).map_err(Error::file("read", file))?;
        let frame = read_one(file, &bytes)?;
        if !frame.grains.is_empty() {
            if !all.grains.is_empty() {
                return Err(Error::content(path, "names two files of grains; give the files one by one"));
            }
            (all.grains, all.parts) = (frame.grains, frame.parts);
        }
        if frame.contacts.is_some() {
            (all.contacts, all.centres) = (frame.contacts, frame.centres);
        }
        all.cell = all.cell.or(frame.cell);
    }
    Ok(all)
}

/// The number of the time step in a name as YADE gives it: `NAME-spheres.1200.vtu`, `NAME-1200.vtm`.
fn step(path: &Path) -> Option<u64> {
    let stem = path.file_stem()?.to_str()?;
    let is_index = path.extension().is_some_and(|extension| extension == "vtm");
    let kinds = ["spheres.", "intrs.", "pericell."];
    let digits = match kinds.iter().find_map(|kind| stem.rsplit_once(*kind)) {
        Some((_, digits)) => digits,
        None if is_index => stem.rsplit(|c: char| !c.is_ascii_digit()).next()?,
        None => return None,
    };
    digits.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_index_names_files_below_it() {
        let base = tempfile::tempdir().unwrap();
        let folder = base.path().join("here");
        std::fs::create_dir(&folder).unwrap();
        let index = folder.join("run-1.vtm");
        let read = |file: &str, outside: bool| {
            let text = format!(
                "<VTKFile type=\"vtkMultiBlockDataSet\"><vtkMultiBlockDataSet><DataSet file=\"{file}\"/></vtkMultiBlockDataSet></VTKFile>"
            );
            std::fs::write(&index, text).unwrap();
            VtkXml.read(&index, &ReadOptions::default().with_outside(outside)).unwrap_err().to_string()
        };
        for name in ["../secret.vtu", "/etc/passwd"] {
            let error = read(name, false);
            assert!(
                error.contains("leads out of the folder") && error.contains("--allow-outside"),
                "{error}"
            );
        }
        assert!(read("../secret.vtu", true).contains("cannot read"));
        assert!(read("missing.vtu", false).contains("cannot read"));
    }

    #[test]
    fn the_step_is_that_of_the_name() {
        let found = |name: &str| step(Path::new(name));
        assert_eq!(found("a/run-spheres.1200.vtu"), Some(1200));
        assert_eq!(found("run-intrs.7.vtp"), Some(7));
        assert_eq!(found("run-30.vtm"), Some(30));
        assert_eq!(found("end.vtp"), None);
        assert_eq!(found("run2.vtp"), None);
    }
}
