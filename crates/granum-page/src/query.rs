//! The query of an address.

use crate::refused::Refused;

/// Names and values in the order of the address.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Query(Vec<(String, String)>);

impl Query {
    /// Reads it; escapes that are no text are kept as signs that no name has.
    pub fn new(text: &str) -> Query {
        Query(form_urlencoded::parse(text.as_bytes()).into_owned().collect())
    }

    /// The first value of a name.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.0.iter().find(|(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// All values of a name.
    pub fn all<'a>(&'a self, name: &'a str) -> impl Iterator<Item = &'a str> {
        self.0.iter().filter(move |(known, _)| known == name).map(|(_, value)| value.as_str())
    }

    /// The value of a name that must be given.
    ///
    /// # Errors
    /// If it is not.
    pub fn needed(&self, name: &str) -> Result<&str, Refused> {
        self.get(name).ok_or_else(|| Refused::bad(format!("the address has no {name}")))
    }

    /// A whole number, or the usual one where none is given.
    ///
    /// # Errors
    /// If it is none.
    pub fn count(&self, name: &str, usual: usize) -> Result<usize, Refused> {
        match self.get(name) {
            None => Ok(usual),
            Some(text) => text.parse().map_err(|_| Refused::bad(format!("{name} is no number"))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_values_are_read() {
        let query = Query::new("path=a%20b&path=c%2Fd&from=3&x=%00");
        assert_eq!(query.all("path").collect::<Vec<_>>(), ["a b", "c/d"]);
        assert_eq!((query.count("from", 0), query.count("count", 7)), (Ok(3), Ok(7)));
        assert!(query.count("path", 0).is_err() && query.needed("y").is_err());
        assert_eq!(query.needed("x"), Ok("\0"));
    }
}
