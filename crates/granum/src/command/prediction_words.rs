//! The categories among the inputs of a surrogate, which are given as words.

use std::path::Path;

use granum_core::Table;
use granum_io::read_table_with_words;
use granum_learn::dataset::Category;
use granum_learn::surrogate::Columns;

use crate::failure::Failure;

/// The inputs of a surrogate: categories, and numbers.
pub(super) struct InputWords {
    categories: Vec<Category>,
    /// Names of the inputs that are numbers.
    pub(super) numbers: Vec<String>,
}

impl InputWords {
    pub(super) fn new(columns: &Columns) -> InputWords {
        let categories = columns.categories();
        let is_number =
            |name: &String| !categories.iter().any(|known| known.columns().any(|own| own == *name));
        let numbers = columns.input_names().into_iter().filter(is_number).collect();
        InputWords { categories, numbers }
    }

    /// The names of the inputs as a user gives them, categories with their words.
    pub(super) fn names(&self) -> Vec<String> {
        let words =
            self.categories.iter().map(|known| format!("{} ({})", known.name, known.words.join(" or ")));
        self.numbers.iter().cloned().chain(words).collect()
    }

    /// The columns of the words that flags give, and the other flags.
    pub(super) fn given(
        &self,
        flags: &[String],
        needs: &dyn Fn() -> String,
    ) -> Result<(Vec<String>, Vec<String>), Failure> {
        let (mut given, mut others): (Vec<String>, Vec<String>) = Default::default();
        for flag in flags {
            let parts = flag.split_once('=').map(|(name, word)| (name.trim(), word.trim()));
            let category =
                parts.and_then(|(name, _)| self.categories.iter().find(|known| known.name == name));
            let (Some(category), Some((name, word))) = (category, parts) else {
                others.push(flag.clone());
                continue;
            };
            if !category.words.iter().any(|known| known == word) {
                let known = category.words.join(" or ");
                return Err(Failure::new(format!(
                    "--set {flag}: {word:?} is no word to which the surrogate was fitted; it must be {known}"
                )));
            }
            if given.iter().any(|column| Category::parts(column).is_some_and(|(known, _)| known == name)) {
                return Err(Failure::new(format!("--set {flag}: {name} is given twice")));
            }
            given.push(format!("{name}={word}"));
        }
        let is_given = |category: &&Category| category.columns().any(|column| given.contains(&column));
        if let Some(missing) = self.categories.iter().find(|category| !is_given(category)) {
            let (name, word) = (&missing.name, missing.words.first().map_or("WORD", String::as_str));
            return Err(Failure::new(format!("missing: {name} (e.g. --set {name}={word})\n{}", needs())));
        }
        Ok((given, others))
    }

    /// The values of all inputs of these names, from the columns of the given words and the values of the numbers.
    pub(super) fn row(&self, names: &[String], given: &[String], numbers: Vec<f64>) -> Vec<f64> {
        let mut numbers = numbers.into_iter();
        let value = |name: &String| match self.numbers.contains(name) {
            true => numbers.next().unwrap_or(f64::NAN),
            false => f64::from(u8::from(given.contains(name))),
        };
        names.iter().map(value).collect()
    }

    /// Adds the categories to a table of the numbers: columns of words of a file.
    pub(super) fn read_into(&self, table: &mut Table, path: &Path) -> Result<(), Failure> {
        let names: Vec<&str> = self.categories.iter().map(|known| known.name.as_str()).collect();
        if names.is_empty() {
            return Ok(());
        }
        for column in read_table_with_words(path, Some(&names))?.into_columns() {
            table.set(column)?;
        }
        Ok(())
    }
}
