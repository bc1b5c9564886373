//! Numbers of a test by the keys of its case.

/// Numbers of a test by their keys.
#[derive(Clone, Debug, Default)]
pub struct KnownNumbers(pub Vec<(String, f64)>);

impl KnownNumbers {
    pub fn get(&self, key: &str) -> Option<f64> {
        self.0.iter().find(|(name, _)| name == key).map(|(_, value)| *value)
    }

    pub fn set(&mut self, key: &str, value: f64) {
        self.0.retain(|(name, _)| name != key);
        self.0.push((key.into(), value));
    }

    pub fn forget(&mut self, key: &str) {
        self.0.retain(|(name, _)| name != key);
    }
}
