//! Suggestions for a name that is not known, and what can be a name.

/// The name nearest to `wrong` among `names`, if one is near enough to be a likely correction.
pub fn nearest<'a>(wrong: &str, names: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let plain = |name: &str| name.to_lowercase().replace('-', "_");
    names
        .into_iter()
        .map(|name| (strsim::jaro_winkler(&plain(wrong), &plain(name)), name))
        .filter(|(score, _)| *score > 0.75)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, name)| name)
}

/// "did you mean x?", or the list of all names.
pub fn suggestion<'a>(name: &str, names: impl Iterator<Item = &'a str> + Clone) -> String {
    match nearest(name, names.clone()) {
        Some(near) => format!("did you mean {near}?"),
        None => {
            let all: Vec<&str> = names.take(40).collect();
            if all.is_empty() { "there are none".into() } else { format!("there are: {}", all.join(", ")) }
        }
    }
}

/// True for a name that can be used in a case file, on a command line and as the name of a file: letters and digits of ASCII,
/// hyphens and underscores.
pub fn is_word(name: &str) -> bool {
    !name.is_empty() && name.bytes().all(|c| c.is_ascii_alphanumeric() || c == b'_' || c == b'-')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearest_knows_slips_and_leaves_strangers_alone() {
        let names = ["youngs_modulus", "poissons_ratio", "friction"];
        assert_eq!(nearest("young_modulus", names), Some("youngs_modulus"));
        assert_eq!(nearest("Poissons-Ratio", names), Some("poissons_ratio"));
        assert_eq!(nearest("zzz", names), None);
    }
}
