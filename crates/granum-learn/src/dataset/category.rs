//! Categories: parameters whose values are words, such as the name of a contact law or of a path.
//!
//! As an input of a surrogate, a category becomes one column of zeros and ones for each of its words (one-hot), whose name is
//! `contact.normal=hertz`. A word that the surrogate has not been fitted to is refused, since all of these columns would be zero.

/// The sign between the name of a category and one of its words.
const SIGN: char = '=';

/// A category with the words that it can have.
///
/// ```
/// use granum_learn::dataset::Category;
///
/// let law = Category::new("contact.normal", ["jkr", "hertz", "jkr"]);
/// assert_eq!(law.columns().collect::<Vec<_>>(), ["contact.normal=hertz", "contact.normal=jkr"]);
/// assert_eq!(Category::among(law.columns()), [law]);
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Category {
    /// Its name.
    pub name: String,
    /// Its words in the order of the alphabet, each once.
    pub words: Vec<String>,
}

impl Category {
    /// A category with the given words.
    pub fn new<W: Into<String>>(name: &str, words: impl IntoIterator<Item = W>) -> Category {
        let mut words: Vec<String> = words.into_iter().map(Into::into).collect();
        words.sort();
        words.dedup();
        Category { name: name.into(), words }
    }

    /// The names of its columns.
    pub fn columns(&self) -> impl Iterator<Item = String> + '_ {
        self.words.iter().map(|word| format!("{}{SIGN}{word}", self.name))
    }

    /// The name and the word of one of its columns.
    pub fn parts(column: &str) -> Option<(&str, &str)> {
        column.split_once(SIGN)
    }

    /// The categories of which these are columns, in the order in which they first occur.
    pub fn among<S: AsRef<str>>(columns: impl IntoIterator<Item = S>) -> Vec<Category> {
        let mut found: Vec<Category> = Vec::new();
        for column in columns {
            let Some((name, word)) = Category::parts(column.as_ref()) else { continue };
            match found.iter_mut().find(|known| known.name == name) {
                Some(known) => known.words.push(word.to_string()),
                None => found.push(Category { name: name.into(), words: vec![word.to_string()] }),
            }
        }
        found
    }

    /// Its words as "hertz, jkr".
    pub fn list(&self) -> String {
        self.words.join(", ")
    }
}
