//! Readable JSON: one key per line, and lists of numbers on one line.

use std::io::Write;

use serde::Serialize;

/// The text of a value, without a line end after it.
///
/// ```
/// let value = std::collections::BTreeMap::from([("weights", vec![0.5, -1.0]), ("bias", vec![0.1])]);
/// let text = granum_core::json::readable(&value)?;
/// assert_eq!(text, "{\n  \"bias\": [0.1],\n  \"weights\": [0.5, -1.0]\n}");
/// # Ok::<(), serde_json::Error>(())
/// ```
///
/// # Errors
/// If the value cannot be written as JSON (a map with keys that are no texts).
pub fn readable(value: &impl Serialize) -> Result<String, serde_json::Error> {
    let mut bytes = Vec::new();
    value.serialize(&mut serde_json::Serializer::with_formatter(&mut bytes, Lines { depth: 0 }))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Objects a key a line, lists of numbers on one line.
struct Lines {
    depth: usize,
}

impl Lines {
    fn line<W: ?Sized + Write>(&self, writer: &mut W) -> std::io::Result<()> {
        write!(writer, "\n{}", "  ".repeat(self.depth))
    }
}

impl serde_json::ser::Formatter for Lines {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> std::io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }
    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> std::io::Result<()> {
        self.depth -= 1;
        self.line(writer)?;
        writer.write_all(b"}")
    }
    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> std::io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        self.line(writer)
    }
    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> std::io::Result<()> {
        writer.write_all(b": ")
    }
    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> std::io::Result<()> {
        writer.write_all(if first { b"" } else { b", " })
    }
}
