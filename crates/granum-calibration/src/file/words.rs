//! Words of the file.

use granum_campaign::plan::{Node, Reader};
use granum_core::names::suggestion;

/// The value with a word among those that are known.
pub(super) fn word<T: Copy>(reader: &mut Reader, node: &Node, key: &str, known: &[(T, &str)]) -> Option<T> {
    let text = reader.text(node, key)?;
    let found = known.iter().find(|(_, word)| *word == text).map(|(value, _)| *value);
    if found.is_none() {
        let help = suggestion(&text, known.iter().map(|(_, word)| *word));
        reader.error(node.span(), format!("{key} = {text:?} is not known"), &help);
    }
    found
}
