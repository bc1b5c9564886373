//! Reports of runs as pages.

use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use granum_io::atomic::write_atomically;
use granum_io::{RunKind, check_new_file};
use granum_report::{Document, RoleInStudy, RunReport, run_report, sample_report};
use pyo3::prelude::*;

use crate::detached::detached;
use crate::errors;
use crate::results::Place;

/// What the report of a run is made of; with `pictures` also the assemblies.
fn content(place: &Place, pictures: bool) -> granum_learn::Result<RunReport> {
    match place {
        Place::Folder { run, .. } if pictures => RunReport::read(&run.now(), RoleInStudy::Single),
        Place::Folder { run, .. } => RunReport::read_without_pictures(&run.now(), RoleInStudy::Single),
        Place::Memory { case, result } => {
            let (about, record) = (result.about.clone(), result.record.clone());
            let report =
                RunReport::of_parts("run in memory", (**case).clone(), about, record, RoleInStudy::Single);
            let end = result.state.as_ref().filter(|_| pictures).map(|state| state.assembly());
            Ok(RunReport { end, ..report })
        }
    }
}

/// The report of a run, as the program makes it.
pub fn document(py: Python<'_>, place: &Arc<Place>, pictures: bool) -> PyResult<Document> {
    let place = place.clone();
    let made = detached(py, move || {
        let report = content(&place, pictures)?;
        Ok(if report.run.kind == RunKind::Sample { sample_report(&report) } else { run_report(&report) })
    })?;
    made.map_err(|error| errors::of_learning(py, &error))
}

/// Writes a page: as a file, or into a folder with its figures beside it.
pub fn write(py: Python<'_>, document: &Document, out: &Path, force: bool) -> PyResult<()> {
    let is_page = out.extension().is_some_and(|extension| extension == "html") && !out.is_dir();
    let file = if is_page { out.to_path_buf() } else { out.join("report.html") };
    let written = detached(py, || {
        check_new_file(&file, force)?;
        match is_page {
            true => write_atomically(out, |file| file.write_all(document.html.as_bytes())),
            false => {
                std::fs::create_dir_all(out).map_err(granum_io::Error::file("create the folder", out))?;
                document.write(out)
            }
        }
    })?;
    written.map_err(|error| errors::of_file(py, &error, false))
}
