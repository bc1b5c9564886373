//! The points, cells and arrays of a VTK XML file.

use std::borrow::Cow;
use std::cell::Cell;
use std::ops::Range;
use std::path::Path;

use granum_core::assembly::Vector;
use roxmltree::{Document as Xml, Node};

use super::decode::{self, Encoding, Layout, NumberType};
use crate::error::{Error, InputError, Result};
use crate::shell::ShowPath;

/// Where the appended data begin.
const APPENDED: &[u8] = b"<AppendedData";

/// An array of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Array {
    pub(super) name: String,
    pub(super) components: usize,
    pub(super) values: Vec<f64>,
}

/// What a cell of a grid is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Shape {
    Vertex,
    Line,
    Hexahedron,
    Other,
}

/// A cell of a grid and its points.
#[derive(Clone, Debug)]
pub(super) struct GridCell {
    pub(super) shape: Shape,
    pub(super) points: Vec<usize>,
}

/// The content of a file; several pieces are one after the other.
#[derive(Clone, Debug, Default)]
pub(super) struct Document {
    pub(super) points: Vec<Vector>,
    pub(super) cells: Vec<GridCell>,
    pub(super) point_data: Vec<Array>,
    pub(super) cell_data: Vec<Array>,
    pub(super) field_data: Vec<Array>,
    /// The coordinates along the axes of a rectilinear grid.
    pub(super) coordinates: Vec<Array>,
}

impl Document {
    pub(super) fn parse(path: &Path, bytes: &[u8]) -> Result<Document> {
        let text = text_part(path, bytes)?;
        let xml = parse_text(path, &text)?;
        let kind = kind(path, &xml)?;
        let root = xml.root_element();
        if !["PolyData", "UnstructuredGrid", "RectilinearGrid"].contains(&kind) {
            let message =
                format!("has type=\"{kind}\"; PolyData, UnstructuredGrid and RectilinearGrid can be read");
            return Err(Error::content(path, message));
        }
        let (layout, appended) = (layout(path, root)?, appended(path, bytes)?);
        let file = File { path, xml: &xml, layout, appended, room: decode::room(bytes.len()) };
        let mut document = Document::default();
        for node in root.descendants().filter(|node| node.has_tag_name("FieldData")) {
            document.field_data.extend(file.arrays(node)?);
        }
        for (k, piece) in root.descendants().filter(|node| node.has_tag_name("Piece")).enumerate() {
            document.add(&file, piece, k == 0)?;
        }
        Ok(document)
    }

    fn add(&mut self, file: &File, piece: Node, first: bool) -> Result<()> {
        let before = self.points.len();
        for node in children(piece, "Coordinates") {
            self.coordinates.extend(file.arrays(node)?);
        }
        for node in children(piece, "Points") {
            for array in file.arrays(node)? {
                if array.components != 3 {
                    return Err(file.error(node, "the points must have three components"));
                }
                self.points.extend(array.values.chunks_exact(3).map(|x| [x[0], x[1], x[2]]));
            }
        }
        for (name, shape) in [
            ("Verts", Shape::Vertex),
            ("Lines", Shape::Line),
            ("Strips", Shape::Other),
            ("Polys", Shape::Other),
        ] {
            for node in children(piece, name) {
                self.add_cells(file, node, before, |_| shape)?;
            }
        }
        for node in children(piece, "Cells") {
            let types =
                file.arrays(node)?.into_iter().find(|array| array.name == "types").unwrap_or_default();
            self.add_cells(file, node, before, |k| match types.values.get(k) {
                Some(1.0) => Shape::Vertex,
                Some(3.0) => Shape::Line,
                Some(12.0) => Shape::Hexahedron,
                _ => Shape::Other,
            })?;
        }
        for (name, into) in [("PointData", &mut self.point_data), ("CellData", &mut self.cell_data)] {
            let mut found = Vec::new();
            for node in children(piece, name) {
                found.extend(file.arrays(node)?);
            }
            if first {
                *into = found;
                continue;
            }
            // An array counts if every piece has it.
            into.retain(|array| found.iter().any(|other| other.name == array.name));
            for array in into.iter_mut() {
                let more = found.iter().find(|other| other.name == array.name);
                array.values.extend(more.iter().flat_map(|other| &other.values));
            }
        }
        Ok(())
    }

    fn add_cells(
        &mut self,
        file: &File,
        node: Node,
        before: usize,
        shape: impl Fn(usize) -> Shape,
    ) -> Result<()> {
        let arrays = file.arrays(node)?;
        let of = |name: &str| {
            arrays.iter().find(|array| array.name == name).map_or(&[][..], |array| &array.values)
        };
        let (connectivity, offsets) = (of("connectivity"), of("offsets"));
        let mut start = 0;
        for (k, end) in offsets.iter().enumerate() {
            let end = *end as usize;
            let Some(points) = connectivity.get(Range { start, end }) else {
                return Err(
                    file.error(node, format!("offset {end} does not follow {start} in the connectivity"))
                );
            };
            let all = self.points.len();
            let known = |point: &f64| *point >= 0.0 && before + (*point as usize) < all;
            if let Some(point) = points.iter().find(|point| !known(point)) {
                return Err(file.error(node, format!("a cell has the point {point}, which is not there")));
            }
            let points = points.iter().map(|point| before + *point as usize).collect();
            self.cells.push(GridCell { shape: shape(k), points });
            start = end;
        }
        Ok(())
    }
}

/// The document without the data that are appended to it, which need not be text.
pub(super) fn text_part<'a>(path: &Path, bytes: &'a [u8]) -> Result<Cow<'a, str>> {
    let not_text = |_| Error::content(path, "is not UTF-8 text before its appended data");
    Ok(match find(bytes, APPENDED) {
        Some(at) => (std::str::from_utf8(&bytes[..at]).map_err(not_text)?.to_string() + "</VTKFile>").into(),
        None => std::str::from_utf8(bytes).map_err(not_text)?.into(),
    })
}

/// The tree of a document.
pub(super) fn parse_text<'a>(path: &Path, text: &'a str) -> Result<Xml<'a>> {
    Xml::parse(text).map_err(|error| {
        let line = error.pos().row as usize;
        let message = format!("is no VTK XML file or is damaged: {error}");
        InputError::in_line(&path.shown(), line, "", 0..0, message).into()
    })
}

/// The type of a file: `PolyData` and the like.
pub(super) fn kind<'a>(path: &Path, xml: &'a Xml) -> Result<&'a str> {
    let root = xml.root_element();
    let kind = root.attribute("type").filter(|_| root.has_tag_name("VTKFile"));
    kind.ok_or_else(|| Error::content(path, "is no VTK XML file: it does not begin with <VTKFile type=...>"))
}

fn layout(path: &Path, root: Node) -> Result<Layout> {
    let choice = |name: &str, known: [&str; 2]| match root.attribute(name) {
        None => Ok(0),
        Some(value) => known.iter().position(|known| *known == value).ok_or_else(|| {
            let message = format!("has {name}=\"{value}\"; it may be {} or {}", known[0], known[1]);
            Error::content(path, message)
        }),
    };
    let compressed = match root.attribute("compressor") {
        None | Some("") => false,
        Some("vtkZLibDataCompressor") => true,
        Some(other) => {
            let message = format!(
                "is compressed by {other}; plain files and those of vtkZLibDataCompressor can be read"
            );
            return Err(Error::content(path, message));
        }
    };
    Ok(Layout {
        big_endian: choice("byte_order", ["LittleEndian", "BigEndian"])? == 1,
        header: [4, 8][choice("header_type", ["UInt32", "UInt64"])?],
        compressed,
    })
}

/// The appended data, after the underscore that begins them, and how they are encoded.
fn appended<'a>(path: &Path, bytes: &'a [u8]) -> Result<Option<(&'a [u8], Encoding)>> {
    let Some(at) = find(bytes, APPENDED) else { return Ok(None) };
    let (Some(end), Some(start)) = (find(&bytes[at..], b">"), find(&bytes[at..], b"_")) else {
        return Err(Error::content(path, "ends in its appended data"));
    };
    let tag = String::from_utf8_lossy(&bytes[at..at + end]).into_owned();
    let encoding = if tag.contains("\"raw\"") { Encoding::Raw } else { Encoding::Base64 };
    Ok(Some((&bytes[at + start + 1..], encoding)))
}

fn find(bytes: &[u8], wanted: &[u8]) -> Option<usize> {
    bytes.windows(wanted.len()).position(|window| window == wanted)
}

fn children<'a, 'b: 'a>(node: Node<'a, 'b>, name: &'a str) -> impl Iterator<Item = Node<'a, 'b>> {
    node.children().filter(move |child| child.has_tag_name(name))
}

/// What is needed to read arrays and to say where they are.
struct File<'a> {
    path: &'a Path,
    xml: &'a Xml<'a>,
    layout: Layout,
    appended: Option<(&'a [u8], Encoding)>,
    /// Bytes that its arrays may still have.
    room: Cell<usize>,
}

impl File<'_> {
    /// The numeric arrays that are children of a node.
    fn arrays(&self, node: Node) -> Result<Vec<Array>> {
        let nodes = node.children().filter(|child| child.has_tag_name("DataArray"));
        let mut found = Vec::new();
        for node in nodes {
            // Arrays of words hold nothing that is needed.
            if node.attribute("type") != Some("String") {
                found.push(self.array(node)?);
            }
        }
        Ok(found)
    }

    fn array(&self, node: Node) -> Result<Array> {
        let name = node.attribute("Name").unwrap_or("Points").to_string();
        let wrong = |what: String| self.error(node, format!("the array {name} {what}"));
        let type_name = node.attribute("type").unwrap_or("");
        let kind = NumberType::named(type_name)
            .ok_or_else(|| wrong(format!("has the unknown type {type_name:?}")))?;
        let components = match node.attribute("NumberOfComponents").map(str::parse::<usize>) {
            None => 1,
            Some(Ok(count)) if count > 0 => count,
            Some(_) => return Err(wrong("has no number of components".into())),
        };
        let text =
            || node.children().find(|child| child.is_text()).and_then(|child| child.text()).unwrap_or("");
        let values = match node.attribute("format").unwrap_or("ascii") {
            "ascii" => text_values(text(), kind).map_err(wrong)?,
            "binary" => {
                let bytes: Vec<u8> = text().bytes().filter(|byte| !byte.is_ascii_whitespace()).collect();
                decode::binary(&bytes, 0, Encoding::Base64, self.layout, kind, &self.room).map_err(wrong)?
            }
            "appended" => {
                let offset = node.attribute("offset").and_then(|offset| offset.trim().parse::<usize>().ok());
                let (Some(offset), Some((data, encoding))) = (offset, self.appended) else {
                    return Err(wrong("is in appended data that are not there".into()));
                };
                decode::binary(data, offset, encoding, self.layout, kind, &self.room).map_err(wrong)?
            }
            other => return Err(wrong(format!("has the unknown format {other:?}"))),
        };
        if values.len() % components != 0 {
            return Err(wrong(format!("has {} values, but {components} components", values.len())));
        }
        Ok(Array { name, components, values })
    }

    fn error(&self, node: Node, message: impl Into<String>) -> Error {
        let line = self.xml.text_pos_at(node.range().start).row as usize;
        InputError::in_line(&self.path.shown(), line, "", 0..0, message.into()).into()
    }
}

fn text_values(text: &str, kind: NumberType) -> std::result::Result<Vec<f64>, String> {
    let number = |word: &str| {
        let shown = || word.chars().take(40).collect::<String>();
        kind.parse(word).ok_or_else(|| format!("has the value {:?}, which is no number", shown()))
    };
    text.split_ascii_whitespace().map(number).collect()
}
