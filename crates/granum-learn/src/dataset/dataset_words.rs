//! The categories of a data set: the parameters that are words in some of its runs.

use super::category::Category;
use super::named_columns::Dataset;
use super::run_states::RunStates;
use crate::error::{LearnError, Result};

impl Dataset {
    /// The category of the given name with the words of all runs; `None` if it is a number in every run, or missing in one.
    pub fn category(&self, name: &str) -> Option<Category> {
        let words = self.runs().iter().map(|run| run.word(name)).collect::<Option<Vec<String>>>()?;
        let has_word = self.runs().iter().any(|run| run.parameter(name).is_none());
        (has_word && !words.is_empty()).then(|| Category::new(name, words))
    }

    /// The categories that all runs have, in the order of the first run.
    pub fn categories(&self) -> Vec<Category> {
        let first = self.runs().first();
        let names = first.into_iter().flat_map(RunStates::parameters).map(|parameter| &parameter.key);
        names.filter_map(|name| self.category(name)).collect()
    }

    /// Refuses runs with words that are not among those of the given columns: what was fitted to these knows nothing of another word.
    ///
    /// # Errors
    /// The run, its word, and those that are known.
    pub fn check_words<S: AsRef<str>>(&self, columns: impl IntoIterator<Item = S>) -> Result<()> {
        for category in Category::among(columns) {
            for run in self.runs() {
                let Some(word) = run.word(&category.name) else {
                    let reason = format!("there is no column {}", category.name);
                    return Err(LearnError::Record { run: run.name().into(), reason });
                };
                if !category.words.contains(&word) {
                    let (name, known) = (&category.name, category.list());
                    let reason =
                        format!("{name} is {word}, of which nothing can be known from runs with {known}");
                    return Err(LearnError::Record { run: run.name().into(), reason });
                }
            }
        }
        Ok(())
    }
}
