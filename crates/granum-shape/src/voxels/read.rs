//! Stacks of images from TIFF files.

use std::io::{BufReader, Cursor};
use std::path::{Path, PathBuf};

use granum_core::input::{self, LARGEST_INPUT};
use tiff::decoder::{Decoder, DecodingResult, Limits};

use super::stack::LabelledStack;
use crate::mesh::fault;
use crate::shape_error::ShapeError;

/// Largest number of voxels of a stack.
const MOST_VOXELS: usize = 500_000_000;

/// Reads a file of several images, or the files of a folder in the order of the numbers in their names, whose values are labels of 8, 16 or 32 bits.
///
/// # Errors
/// The key `file`, with the name of the file, what is wrong with it and what would be right.
pub fn read(path: &Path) -> Result<LabelledStack, ShapeError> {
    if !input::are_there() {
        return Err(fault(path, "cannot be read: add it to the files of the case"));
    }
    let mut stack = LabelledStack::default();
    if input::is_folder(path) {
        for file in files(path)? {
            add_images(&mut stack, &file)?;
        }
    } else {
        if !is_tiff(path) {
            return Err(fault(
                path,
                "is not a stack of images by its name, which must end in .tif or .tiff, or be that of a folder",
            ));
        }
        add_images(&mut stack, path)?;
    }
    if stack.size[2] < 2 {
        return Err(fault(path, "has a single image; a stack of grains needs several"));
    }
    Ok(stack)
}

fn is_tiff(path: &Path) -> bool {
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
    ending.eq_ignore_ascii_case("tif") || ending.eq_ignore_ascii_case("tiff")
}

/// The images of a folder: slice_2.tif comes before slice_10.tif.
fn files(folder: &Path) -> Result<Vec<PathBuf>, ShapeError> {
    let refused = |why: std::io::Error| fault(folder, format!("cannot be read: {why}"));
    let mut files = input::files_in(folder).map_err(refused)?;
    files.retain(|path| is_tiff(path));
    if files.is_empty() {
        return Err(fault(folder, "has no files that end in .tif or .tiff"));
    }
    files.sort_by_cached_key(|path| {
        let name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        (order(&name), name)
    });
    Ok(files)
}

/// A name as pairs of what is no number and a number.
fn order(name: &str) -> Vec<(String, u64)> {
    let mut parts = vec![(String::new(), 0u64)];
    let mut in_number = false;
    for letter in name.chars() {
        match letter.to_digit(10) {
            Some(digit) => {
                if let Some(last) = parts.last_mut() {
                    last.1 = last.1.saturating_mul(10).saturating_add(u64::from(digit));
                }
                in_number = true;
            }
            None => {
                if in_number {
                    parts.push((String::new(), 0));
                }
                if let Some(last) = parts.last_mut() {
                    last.0.push(letter);
                }
                in_number = false;
            }
        }
    }
    parts
}

/// Adds the images of a file to a stack.
fn add_images(stack: &mut LabelledStack, path: &Path) -> Result<(), ShapeError> {
    let bytes =
        input::read(path, LARGEST_INPUT).map_err(|why| fault(path, format!("cannot be read: {why}")))?;
    let refused = |why: tiff::TiffError| fault(path, format!("is not a TIFF file that can be read: {why}"));
    let of_tags = limits(bytes.len());
    let mut decoder =
        Decoder::new(BufReader::new(Cursor::new(bytes))).map_err(refused)?.with_limits(of_tags.clone());
    loop {
        let (width, height) = decoder.dimensions().map_err(refused)?;
        let size = [width as usize, height as usize];
        if stack.size[2] == 0 {
            stack.size = [size[0], size[1], 0];
        }
        let image = stack.size[2] + 1;
        if size != stack.size[..2] {
            let [x, y, _] = stack.size;
            let message =
                format!("has an image {image} of {width} x {height} pixels; those before have {x} x {y}");
            return Err(fault(path, message));
        }
        if size[0].saturating_mul(size[1]).saturating_mul(image) > MOST_VOXELS {
            return Err(fault(
                path,
                format!("has more than {MOST_VOXELS} voxels; crop the stack or make it coarser"),
            ));
        }
        if !matches!(decoder.colortype().map_err(refused)?, tiff::ColorType::Gray(_)) {
            return Err(fault(
                path,
                format!("has a coloured image {image}; labels are images of one channel"),
            ));
        }
        let mut of_image = of_tags.clone();
        of_image.decoding_buffer_size = of_tags.decoding_buffer_size.max(LONGEST_VALUE * size[0] * size[1]);
        decoder = decoder.with_limits(of_image);
        let labels =
            labels(decoder.read_image().map_err(refused)?).ok_or_else(|| fault(path, wrong_format(image)))?;
        if labels.len() != size[0] * size[1] {
            return Err(fault(path, wrong_format(image)));
        }
        stack.labels.extend(labels);
        stack.size[2] = image;
        if !decoder.more_images() {
            return Ok(());
        }
        decoder = decoder.with_limits(of_tags.clone());
        decoder.next_image().map_err(refused)?;
    }
}

/// Length of the longest value of a pixel, bytes.
const LONGEST_VALUE: usize = 8;
/// What the decoder keeps in memory for a value of a tag, bytes.
const MEMORY_OF_VALUE: usize = 32;

/// How much memory tags may take: each value of one has a byte in the file at least, whatever number of values it claims.
fn limits(bytes: usize) -> Limits {
    let mut limits = Limits::default();
    limits.decoding_buffer_size = MEMORY_OF_VALUE.saturating_mul(bytes).min(LONGEST_VALUE * MOST_VOXELS);
    limits
}

fn wrong_format(image: usize) -> String {
    format!(
        "has an image {image} whose values are no labels; they must be whole numbers from 0 of 8, 16 or 32 bits"
    )
}

/// Values as labels, if they are whole and not negative.
fn labels(image: DecodingResult) -> Option<Vec<u32>> {
    let whole = |x: f64| (x >= 0.0 && x <= f64::from(u32::MAX) && x.fract() == 0.0).then_some(x as u32);
    match image {
        DecodingResult::U8(values) => Some(values.into_iter().map(u32::from).collect()),
        DecodingResult::U16(values) => Some(values.into_iter().map(u32::from).collect()),
        DecodingResult::U32(values) => Some(values),
        DecodingResult::I16(values) => values.into_iter().map(|x| u32::try_from(x).ok()).collect(),
        DecodingResult::I32(values) => values.into_iter().map(|x| u32::try_from(x).ok()).collect(),
        // Some programs write labels as numbers with a point.
        DecodingResult::F32(values) => values.into_iter().map(|x| whole(f64::from(x))).collect(),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::order;

    #[test]
    fn names_are_ordered_by_their_numbers() {
        let mut names = ["s_10.tif", "s_2.tif", "a_30.tif", "s_02b.tif", "s_1.tif"];
        names.sort_by_cached_key(|name| (order(name), *name));
        assert_eq!(names, ["a_30.tif", "s_1.tif", "s_2.tif", "s_02b.tif", "s_10.tif"]);
    }
}
