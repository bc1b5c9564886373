//! Files of other programs: they are read and written as by `granum measure` and `granum export`.

use std::path::PathBuf;

use granum_campaign::data_set::{DataSet, grainlearning};
use granum_core::assembly::Matrix;
use granum_core::quantity::Dimension;
use granum_io::formats::{
    ContactOptions, Formats, FrameCell, JoinOptions, ObservedAssembly, ReadOptions, hdf5,
};
use granum_io::{Error, check_output_file};
use granum_run::laboratory::observed_packing;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};

use crate::assembly::Assembly;
use crate::case::case_of;
use crate::detached::detached;
use crate::errors;
use crate::observed::{edges, warned};
use crate::quantity;
use crate::run::Run;
use crate::table::{SERIES, Table};

/// Reads results of other programs, as `granum measure` does: an assembly for each instant.
///
/// These are dumps and data files of LAMMPS and LIGGGHTS, texts and VTK of YADE, `.data`, `.fstat` and restart files of MercuryDPM, extended
/// XYZ, GSD, packings, and tables (CSV, Parquet) of grains and of contacts. Files that belong together are joined. Everything is in SI units,
/// or in a consistent system of units.
///
/// What files do not say can be given: three lengths of a periodic `cell` or the matrix whose columns are its edges, the `density` of
/// the grains, the `time_step` between numbered steps, and names of the `columns` of a file whose head has none of use, by the name of
/// the file (`-` for what is to be passed over). Grains whose file has no contacts touch where they overlap; with a `case` the contact law
/// gives the forces of a packing. With `allow_outside` a file may name files outside its own folder.
///
/// A table of contacts is held against the grains beside it. What was set right is in `remarks` of the assembly; what is doubtful is also a
/// `granum.RunWarning`. What cannot be decided is refused, until its owner says what pairs are that do not touch (`pairs_apart`: `"contacts"`
/// or `"no-contacts"`), what pairs are that overlap and are missing (`missing_pairs`: `"no-contacts"` or `"without-force"`), what forces are
/// that pull everywhere (`contact_forces`: `"as-given"` or `"reversed"`), and what rows of one pair with different forces are
/// (`repeated_pairs`: `"first"` or `"sum"`).
///
/// Spheres that a file puts into one molecule, clump or body are one grain, with `separate_spheres` each a grain of its own. The mass of such a grain
/// is that of the union of its spheres, with `masses_add_up` the sum of theirs.
#[pyfunction]
#[pyo3(signature = (
    *paths, cell=None, density=None, time_step=None, columns=None, case=None, allow_outside=false, pairs_apart=None, missing_pairs=None,
    contact_forces=None, repeated_pairs=None, separate_spheres=false, masses_add_up=false
))]
pub fn read(
    py: Python<'_>,
    paths: Vec<PathBuf>,
    cell: Option<&Bound<'_, PyAny>>,
    density: Option<&Bound<'_, PyAny>>,
    time_step: Option<&Bound<'_, PyAny>>,
    columns: Option<&Bound<'_, PyMapping>>,
    case: Option<&Bound<'_, PyAny>>,
    allow_outside: bool,
    pairs_apart: Option<&str>,
    missing_pairs: Option<&str>,
    contact_forces: Option<&str>,
    repeated_pairs: Option<&str>,
    separate_spheres: bool,
    masses_add_up: bool,
) -> PyResult<Vec<Assembly>> {
    let [first, others @ ..] = &paths[..] else {
        return Err(PyTypeError::new_err("granum.read needs the name of a file"));
    };
    if let Some(folder) = paths.iter().find(|path| path.is_dir()) {
        let message = format!("{} is a folder; granum.open opens the folder of a run", folder.display());
        return Err(errors::of_file(py, &Error::Rule(message), false));
    }
    let answers = [pairs_apart, missing_pairs, contact_forces, repeated_pairs];
    let given = [cell.is_some(), density.is_some(), time_step.is_some(), columns.is_some()].contains(&true)
        || answers.iter().any(Option::is_some)
        || separate_spheres
        || masses_add_up;
    let options = JoinOptions::new(
        cell.map(cell_edges).transpose()?.map(|edges| FrameCell { origin: [0.0; 3], edges }),
        positive("density", density, Dimension::DENSITY)?,
        positive("time_step", time_step, Dimension::TIME)?,
    )
    .with_contacts(contact_options(py, answers)?)
    .with_separate_spheres(separate_spheres)
    .with_masses_that_add_up(masses_add_up);
    let named = columns.map(|columns| names_of_columns(columns, &paths)).transpose()?.unwrap_or_default();
    let case = case.map(|case| case_of(py, case)).transpose()?;
    if case.is_some() && !others.is_empty() {
        let message = "it goes with one packing, not with several files";
        return Err(errors::of_value(py, "case", "", message));
    }
    let formats = Formats::standard().allowing_outside(allow_outside);
    let is_packing = others.is_empty() && !given;
    let is_packing = is_packing
        && (case.is_some()
            || !detached(py, || formats.is_result(first))?
                .map_err(|error| errors::of_file(py, &error, false))?);
    if is_packing {
        let packing = detached(py, || formats.read_packing(first))?;
        let packing = packing.map_err(|error| errors::of_file(py, &error, false))?;
        let found = detached(py, || observed_packing(&packing, case.as_ref()))?;
        return warned(py, found.map_err(|error| errors::of_laboratory(py, &error))?)
            .map(|one| vec![Assembly::from(one)]);
    }
    let columns_of =
        |path: &PathBuf| named.iter().find(|(known, _)| known == path).map(|(_, names)| names.clone());
    let files: Vec<_> =
        paths.iter().map(|path| (path.clone(), ReadOptions::with_columns(columns_of(path)))).collect();
    let found = detached(py, || formats.read_results(&files, &options))?;
    let mut found = found.map_err(|error| errors::of_file(py, &error, false))?;
    if let Some(case) = case {
        let last =
            found.pop().ok_or_else(|| errors::of_file(py, &Error::content(first, "has no grains"), false))?;
        let packing = last.packing(first).map_err(|error| errors::of_file(py, &error, false))?;
        let of_packing = detached(py, || observed_packing(&packing, Some(&case)))?;
        return warned(py, of_packing.map_err(|error| errors::of_laboratory(py, &error))?)
            .map(|one| vec![Assembly::from(one)]);
    }
    found.into_iter().map(|one| warned(py, one.with_contacts_by_geometry()).map(Assembly::from)).collect()
}

/// What cannot be decided of tables of contacts, by the names of the answers.
fn contact_options(py: Python<'_>, answers: [Option<&str>; 4]) -> PyResult<ContactOptions> {
    let [pairs_apart, missing_pairs, contact_forces, repeated_pairs] = answers;
    let options = ContactOptions::default();
    options.with_names(pairs_apart, missing_pairs, contact_forces, repeated_pairs).map_err(|(option, why)| {
        let key = option.replace('-', "_");
        let value = answers.iter().flatten().next().copied().unwrap_or_default();
        errors::of_value(py, &key, value, why)
    })
}

/// The edges of a cell: three lengths, each of which may have a unit, or a matrix.
fn cell_edges(cell: &Bound<'_, PyAny>) -> PyResult<Matrix> {
    let has_unit = |item: &Bound<'_, PyAny>| {
        Ok::<bool, PyErr>(item.is_instance_of::<PyString>() || quantity::is_of_pint(item)?)
    };
    let items: Vec<Bound<'_, PyAny>> = match cell.try_iter() {
        Ok(items) if !cell.is_instance_of::<PyString>() => items.collect::<PyResult<_>>()?,
        _ => return Err(errors::of_value(cell.py(), "cell", cell.to_string(), "three lengths are needed")),
    };
    let lengths = match &items[..] {
        [_, _, _] if items.iter().map(has_unit).collect::<PyResult<Vec<bool>>>()?.contains(&true) => {
            let length = |item: &Bound<'_, PyAny>| quantity::in_si("cell", item, Dimension::LENGTH);
            items.iter().map(length).collect::<PyResult<Vec<f64>>>()?
        }
        _ => return edges(cell),
    };
    let edge = |k: usize| std::array::from_fn(|a| if a == k { lengths[k] } else { 0.0 });
    Ok([edge(0), edge(1), edge(2)])
}

/// A quantity that must be positive.
fn positive(key: &str, value: Option<&Bound<'_, PyAny>>, dimension: Dimension) -> PyResult<Option<f64>> {
    let Some(value) = value else { return Ok(None) };
    let number = quantity::in_si(key, value, dimension)?;
    if number > 0.0 {
        return Ok(Some(number));
    }
    Err(errors::of_value(value.py(), key, number.to_string(), format!("{number} is not positive")))
}

/// The names of the columns of some of the files.
fn names_of_columns(
    columns: &Bound<'_, PyMapping>,
    paths: &[PathBuf],
) -> PyResult<Vec<(PathBuf, Vec<String>)>> {
    let mut found = Vec::new();
    for item in columns.items()?.iter() {
        let (path, names): (PathBuf, Vec<String>) = item.extract()?;
        if !paths.contains(&path) {
            let message = format!("{} is none of the files that are read", path.display());
            return Err(errors::of_value(columns.py(), "columns", path.display().to_string(), message));
        }
        found.push((path, names));
    }
    Ok(found)
}

/// What is written.
enum Content {
    Table(granum_core::Table),
    Assemblies(Vec<ObservedAssembly>),
}

/// Writes grains and contacts for other programs, as `granum export` does: VTP, extended XYZ, GSD, LAMMPS data, CSV and Parquet.
///
/// The name of the file says the format, or `format` does (`"lammps-data"`). Several assemblies are instants of one file, where the format has
/// them. As CSV an assembly is written as a packing and as Parquet as the table of its grains, with the cell in the metadata of the file, but neither
/// time nor names of materials. A run is written as its series to these two, and otherwise as its last state. With `force` an existing file is replaced.
#[pyfunction]
#[pyo3(signature = (path, data, *, format=None, force=false))]
pub fn write(
    py: Python<'_>,
    path: PathBuf,
    data: &Bound<'_, PyAny>,
    format: Option<String>,
    force: bool,
) -> PyResult<()> {
    let formats = Formats::standard();
    let is_tabular = format.is_none() && formats.table(&path).is_ok();
    let content = content_of(data, is_tabular)?;
    let written = detached(py, move || {
        check_output_file(&path, force)?;
        match content {
            Content::Table(_) if format.is_some() => Err(Error::content(
                &path,
                "a table is written as CSV or Parquet, by the name of its file, without a format",
            )),
            Content::Table(table) => formats.write_table(&path, &table),
            Content::Assemblies(observations) => {
                formats.write_assemblies(&path, format.as_deref(), observations, &path).map(|_| ())
            }
        }
    })?;
    written.map_err(|error| errors::of_file(py, &error, false))
}

/// What an object of Python stands for. A run as a table is its series, or else its last state.
fn content_of(data: &Bound<'_, PyAny>, is_tabular: bool) -> PyResult<Content> {
    let py = data.py();
    if let Ok(table) = data.cast::<Table>() {
        return Ok(Content::Table(table.get().copied()));
    }
    if let Ok(assembly) = data.cast::<Assembly>() {
        return Ok(Content::Assemblies(vec![assembly.get().observed()]));
    }
    if let Ok(run) = data.cast::<Run>() {
        if is_tabular && run.get().tables(py)?.iter().any(|name| name == SERIES) {
            let series = run.get().table(py, SERIES)?;
            return content_of(&series, is_tabular);
        }
        return Ok(Content::Assemblies(vec![run.get().snapshot(py, None)?.observed()]));
    }
    let all: Result<Vec<PyRef<'_, Assembly>>, _> = data.extract();
    match all {
        Ok(all) => Ok(Content::Assemblies(all.iter().map(|one| one.observed()).collect())),
        Err(_) => {
            let kind = data.get_type().name()?;
            let message =
                format!("an assembly, a list of assemblies, a run or a table is written, not {kind}");
            Err(PyTypeError::new_err(message))
        }
    }
}

/// Writes the data set of a campaign in the layout of GrainLearning; returns the runs that are left out, since they have fewer states.
#[pyfunction]
#[pyo3(name = "_write_grainlearning", signature = (path, folder, states=None, force=false))]
pub fn write_grainlearning(
    py: Python<'_>,
    path: PathBuf,
    folder: PathBuf,
    states: Option<&Bound<'_, PyAny>>,
    force: bool,
) -> PyResult<Vec<String>> {
    let states =
        states.map(|states| quantity::whole("states", states, 1, u64::from(u32::MAX))).transpose()?;
    let left_out = detached(py, || {
        check_output_file(&path, force)?;
        let none = || Error::content(&folder, "is neither a campaign nor its data set");
        let data_set = DataSet::read(
            &DataSet::meant_by(&folder)?.ok_or_else(none)?,
            granum::Registry::standard().reading(),
        )?;
        let made = grainlearning(&data_set, states.map(|states| states as usize))?;
        hdf5::write(&path, &made.root)?;
        Ok(made.too_short)
    })?;
    left_out.map_err(|error| errors::of_file(py, &error, false))
}
