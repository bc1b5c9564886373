//! Files that name other files: `.vtm`.

use std::path::{Path, PathBuf};

use super::document::{kind, parse_text, text_part};
use crate::error::{Error, Result};
use crate::named_file::named_file;

/// The files that an index names, in their order; none if the file is no index. They lie in its folder or below it unless `outside` is
/// true.
pub(super) fn files(path: &Path, bytes: &[u8], outside: bool) -> Result<Option<Vec<PathBuf>>> {
    let text = text_part(path, bytes)?;
    let document = parse_text(path, &text)?;
    match kind(path, &document)? {
        "vtkMultiBlockDataSet" => {}
        other @ ("PPolyData" | "PUnstructuredGrid" | "Collection") => {
            let message = format!("is an index of other files (type {other}); give the files that it names");
            return Err(Error::content(path, message));
        }
        _ => return Ok(None),
    }
    let folder = path.parent().unwrap_or(Path::new(""));
    let named = document.descendants().filter(|node| node.has_tag_name("DataSet"));
    let files: Vec<PathBuf> = named
        .filter_map(|node| node.attribute("file"))
        .map(|file| {
            named_file(folder, file, outside)
                .map_err(|why| Error::content(path, format!("a file that it names {why}")))
        })
        .collect::<Result<_>>()?;
    if files.is_empty() {
        return Err(Error::content(path, "names no files"));
    }
    Ok(Some(files))
}
