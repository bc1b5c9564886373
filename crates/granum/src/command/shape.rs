//! `granum shape`: the shapes of a case, of a mesh or of images, and how well spheres stand for them.

use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use granum_dem::shape::{ShapeEntry, ShapeKind, SizeMeasure};
use granum_io::shell::ShowPath;
use granum_io::{Case, Run, atomic::write_atomically, check_output_file};
use granum_report::shapes::{ShownShape, figure};
use serde_json::{Value, json};

use super::case_flags::SetFlags;
use super::shape_quantities::{quantities, text};
use crate::context::Context;
use crate::failure::Failure;
use crate::output;

/// Describe the shapes of the grains of a case, or make one of a mesh or of images: spheres, descriptors, errors, picture.
///
/// For a mesh or images the table says how well the spheres stand for the body: the error of the volume as the spheres were found and
/// after they grew to its volume, those of the moments of inertia, and the distances of the surfaces. The slope tan(chi) of the widest
/// seam between two spheres acts as friction; sin(chi) = c/2d for centres at the distance c and spheres of the diameter d.
#[derive(Args)]
#[command(
    after_help = "Example:\n  granum shape case.toml\n  granum shape case.toml --set grains.shape.aspect_ratio=2\n  granum shape grain.stl --pieces 30 --out shape.svg --case shape.toml"
)]
pub struct DescribeShape {
    /// A case file, the folder of a run, a mesh (.stl, .obj, .ply), or labelled images (.tif, or a folder of them).
    file: PathBuf,
    /// Number of spheres of a grain.
    #[arg(long, value_name = "N")]
    pieces: Option<u32>,
    /// How a file becomes spheres: mesh, mesh-euclidean, mesh-tangent or voxels.
    #[arg(long, value_name = "KIND")]
    kind: Option<String>,
    /// Where to draw the shapes, beside the bodies of the file (SVG).
    #[arg(short, long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// Where to write the part of a case file that gives grains these spheres.
    #[arg(long, value_name = "FILE")]
    case: Option<PathBuf>,
    #[command(flatten)]
    set: SetFlags,
}

/// The case of a run in its folder.
const CASE: &str = "case.toml";

/// An entry of a case with its shapes.
type Shown = (ShapeEntry, Vec<ShownShape>);

impl DescribeShape {
    pub fn run(&self, context: &Context) -> Result<(), Failure> {
        self.check_outputs(context)?;
        let (entries, measure) = self.entries(context)?;
        let shown = self.shown(context, entries)?;
        let all: Vec<ShownShape> = shown.iter().flat_map(|(_, shapes)| shapes.clone()).collect();
        let mut written = Vec::new();
        if let Some(path) = &self.out {
            write_atomically(path, |file| file.write_all(figure(&all).0.to_svg().as_bytes()))?;
            written.push(path);
        }
        if let Some(path) = &self.case {
            write_atomically(path, |file| file.write_all(self.part_of_case(&shown).as_bytes()))?;
            written.push(path);
        }
        let result = json!({
            "shapes": all.iter().map(as_json).collect::<Vec<_>>(),
            "size_measure": measure,
            "written": written.iter().map(|path| output::path(path)).collect::<Vec<_>>(),
        });
        output::say(context, &result, || {
            let wrote = written.iter().map(|path| format!("wrote {}", path.shown()));
            [text(&all)].into_iter().chain(sizes(measure)).chain(wrote).collect::<Vec<_>>().join("\n")
        })
    }

    fn check_outputs(&self, context: &Context) -> Result<(), Failure> {
        for path in [&self.out, &self.case].into_iter().flatten() {
            check_output_file(path, context.force)?;
        }
        match &self.out {
            Some(path) if ending(path) != "svg" => Err(Failure::new(format!(
                "{}: is no picture by its name, which must end in .svg",
                path.shown()
            ))),
            _ => Ok(()),
        }
    }

    /// The shapes that the file names, and for a case what the size of a grain means.
    fn entries(&self, context: &Context) -> Result<(Vec<ShapeEntry>, Option<SizeMeasure>), Failure> {
        let in_folder = self.file.join(CASE);
        let is_run = in_folder.is_file();
        if is_run {
            // A case that was changed since the run began would give other shapes for those of the run.
            Run::at(&self.file)?.case()?;
        }
        if is_run || ending(&self.file) == "toml" {
            let case = if is_run { &in_folder } else { &self.file };
            return self.of_case(context, case);
        }
        if self.set.is_given() {
            return Err(Failure::new(format!(
                "--set: {} is no case, whose keys could be set; --pieces and --kind change what is made of it",
                self.file.shown()
            )));
        }
        let kind = match &self.kind {
            Some(name) => kind_named(name)?,
            None => self.kind_of_file()?,
        };
        Ok((vec![ShapeEntry { file: Some(self.file.clone()), ..ShapeEntry::new(kind) }], None))
    }

    fn of_case(
        &self,
        context: &Context,
        case: &Path,
    ) -> Result<(Vec<ShapeEntry>, Option<SizeMeasure>), Failure> {
        if self.kind.is_some() {
            return Err(Failure::new(format!(
                "--kind: {} is a case, which names the kind of its shapes itself; give a mesh or images, or change its key kind",
                case.shown()
            )));
        }
        let (mut case, mut entries) = Case::read_with_shapes(case, context.reading())?;
        if self.set.is_given() {
            let before = case.grains.shapes.clone();
            self.set.apply_law(&mut case, &["grains", "grains.shape"], &[])?;
            // What a file gives stays as the file has it, unless one of its keys was set.
            let given = std::mem::take(&mut entries);
            let kept = |(k, now): (usize, &ShapeEntry)| match (before.get(k), given.get(k)) {
                (Some(old), Some(of_file)) if old == now => of_file.clone(),
                _ => now.clone(),
            };
            entries = case.grains.shapes.iter().enumerate().map(kept).collect();
        }
        if entries.is_empty() {
            context.note("the case has no [grains.shape]: its grains are spheres");
            entries.push(ShapeEntry::default());
        }
        Ok((entries, Some(case.grains.size_measure)))
    }

    /// What the name of the file says that it is.
    fn kind_of_file(&self) -> Result<ShapeKind, Failure> {
        match ending(&self.file).as_str() {
            "stl" | "obj" | "ply" => Ok(ShapeKind::MESH),
            "tif" | "tiff" => Ok(ShapeKind::VOXELS),
            _ if self.file.is_dir() => Ok(ShapeKind::VOXELS),
            _ => Err(Failure::new(format!(
                "{}: is nothing that has a shape by its name, which must end in .toml (a case), .stl, .obj or .ply (a mesh), .tif or .tiff (a \
                 stack of images), or be that of a folder of images or of a run",
                self.file.shown()
            ))),
        }
    }

    fn shown(&self, context: &Context, entries: Vec<ShapeEntry>) -> Result<Vec<Shown>, Failure> {
        let one = |mut entry: ShapeEntry| {
            if let Some(pieces) = self.pieces {
                entry.values.insert("pieces".into(), f64::from(pieces));
            }
            let mut notices = Vec::new();
            let shapes = ShownShape::of_entry(&entry, &mut notices).map_err(|error| {
                let flag = if error.key == "pieces" { "--" } else { "" };
                Failure::new(format!("{}: {flag}{error}", self.file.shown()))
            })?;
            notices.iter().for_each(|notice| context.note(notice));
            Ok((entry, shapes))
        };
        entries.into_iter().map(one).collect()
    }

    /// The part of a case file that gives grains these spheres.
    fn part_of_case(&self, shown: &[Shown]) -> String {
        let mut case = Case::default();
        for (entry, shapes) in shown {
            case.grains.shapes.extend(shapes.iter().map(|shape| as_pieces(entry, shape)));
        }
        let name = self.file.file_name().map(|name| name.to_string_lossy()).unwrap_or_default();
        let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
        format!("# The spheres of {name}, made by granum shape.\n{}", case.shapes_part())
    }
}

/// The entry with its spheres in place of what they were made of.
fn as_pieces(entry: &ShapeEntry, shape: &ShownShape) -> ShapeEntry {
    let spheres = shape.spheres.iter().map(|([x, y, z], radius)| [*x, *y, *z, *radius]).collect();
    let pieces = ShapeEntry { share: shape.share, values: Default::default(), file: None, ..entry.clone() };
    match entry.kind == ShapeKind::SPHERE {
        true => pieces,
        false => ShapeEntry { kind: ShapeKind::PIECES, spheres, ..pieces },
    }
}

fn ending(path: &Path) -> String {
    path.extension().and_then(|ending| ending.to_str()).unwrap_or_default().to_ascii_lowercase()
}

/// A kind that is read from a file.
fn kind_named(name: &str) -> Result<ShapeKind, Failure> {
    let reads = |kind: &ShapeKind| kind.family().description().takes_file;
    ShapeKind::named(name).filter(reads).ok_or_else(|| {
        let known = granum_dem::shape::family::ALL.iter().filter(|kind| reads(kind));
        let known: Vec<&str> = known.map(|kind| kind.name()).collect();
        Failure::new(format!(
            "--kind {name}: no file becomes spheres in this way; there are {}",
            known.join(", ")
        ))
    })
}

/// What the size of a grain means in a case.
fn sizes(measure: Option<SizeMeasure>) -> Option<String> {
    let means = match measure? {
        SizeMeasure::Volume => "that of the sphere of equal volume",
        SizeMeasure::Sieve => "the edge of the smallest square hole of a sieve through which it passes",
    };
    Some(format!("The diameter of a grain in this case is {means} (grains.size_measure)."))
}

fn as_json(shape: &ShownShape) -> Value {
    let mut object = serde_json::Map::from_iter([("name".into(), json!(shape.name))]);
    for quantity in quantities() {
        let value = (quantity.value)(shape).filter(|value| value.is_finite());
        object.insert(quantity.key.into(), json!(value));
    }
    Value::Object(object)
}
