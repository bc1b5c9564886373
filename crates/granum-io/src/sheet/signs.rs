//! The signs of compression in a table: of all columns, or of single ones.

/// What is said of one column, or of all if it has no name: true if compression is negative in it.
pub(crate) type Sign = (Option<String>, bool);

/// The signs of a text: `negative`, `axial_strain=negative`, or several of them with commas between.
///
/// # Errors
/// What it must be.
pub(crate) fn signs(text: &str) -> Result<Vec<Sign>, String> {
    let sign = |part: &str| {
        let (name, word) = match part.split_once('=') {
            Some((name, word)) => {
                (Some(name.trim().to_string()).filter(|name| !name.is_empty()), word.trim())
            }
            None => (None, part.trim()),
        };
        match word {
            "positive" => Ok((name, false)),
            "negative" => Ok((name, true)),
            _ => Err(format!(
                "compression = {text} is not known; it must be positive or negative, or the same of single columns, as axial_strain=negative"
            )),
        }
    };
    text.split(',').map(sign).collect()
}

/// What a comment says of signs: `# compression = negative`, `# compression axial_strain = negative`.
pub(crate) fn of_comment(comment: &str) -> Option<&str> {
    let rest = comment.trim_start_matches('#').trim().strip_prefix("compression")?;
    let value = rest.trim_start();
    match value.strip_prefix('=') {
        Some(value) => Some(value.trim()),
        // A sentence about compression states nothing.
        None => (rest.starts_with(' ')
            && value.split_once('=').is_some_and(|(name, _)| !name.trim().contains(' ')))
        .then_some(value),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_are_of_all_columns_or_of_one() {
        assert_eq!(signs("negative").unwrap(), [(None, true)]);
        let two = [(Some("axial_strain".to_string()), true), (Some("mean_stress".to_string()), false)];
        assert_eq!(signs("axial_strain=negative, mean_stress = positive").unwrap(), two);
        assert!(signs("up").unwrap_err().contains("positive or negative"));
        assert_eq!(of_comment("# compression = negative"), Some("negative"));
        assert_eq!(of_comment("#compression axial_strain = negative"), Some("axial_strain = negative"));
        assert_eq!(of_comment("# compression of the sample at rate = 2"), None);
        assert_eq!(of_comment("# compressions = 3"), None);
    }
}
