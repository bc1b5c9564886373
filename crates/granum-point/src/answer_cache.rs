//! A memory of the last answers.

use std::collections::VecDeque;
use std::sync::{Mutex, PoisonError};

/// The last values by their keys; the one that was not asked for the longest is forgotten first.
pub(crate) struct AnswerCache<K, V> {
    capacity: usize,
    values: Mutex<VecDeque<(K, V)>>,
}

impl<K: PartialEq, V: Clone> AnswerCache<K, V> {
    pub(crate) fn new(capacity: usize) -> AnswerCache<K, V> {
        AnswerCache { capacity, values: Mutex::new(VecDeque::new()) }
    }

    /// The remembered value.
    pub(crate) fn get(&self, key: &K) -> Option<V> {
        let mut values = self.values.lock().unwrap_or_else(PoisonError::into_inner);
        let at = values.iter().position(|(known, _)| known == key)?;
        let entry = values.remove(at)?;
        let value = entry.1.clone();
        values.push_back(entry);
        Some(value)
    }

    /// Remembers a value.
    pub(crate) fn put(&self, key: K, value: V) {
        let mut values = self.values.lock().unwrap_or_else(PoisonError::into_inner);
        values.retain(|(known, _)| *known != key);
        values.push_back((key, value));
        while values.len() > self.capacity {
            values.pop_front();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_one_not_asked_for_the_longest_is_forgotten() {
        let cache = AnswerCache::new(2);
        cache.put(1, "one");
        cache.put(2, "two");
        assert_eq!(cache.get(&1), Some("one"));
        cache.put(3, "three");
        assert_eq!([cache.get(&1), cache.get(&2), cache.get(&3)], [Some("one"), None, Some("three")]);
        let none = AnswerCache::new(0);
        none.put(1, 1);
        assert_eq!(none.get(&1), None);
    }
}
