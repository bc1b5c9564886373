//! An axis: its range, its ticks and the mapping from data to positions on the page.

use super::ticks::{self, Tick, power_of_ten};

/// Larger values indicate an error in the data and do not extend the range of an axis.
const LARGEST: f64 = 1e100;

/// Description of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Axis {
    /// Marked-up label.
    pub label: String,
    /// SI unit without prefix, empty for a dimensionless number. Large and small values get a prefix or a power of ten.
    pub unit: String,
    /// True for a logarithmic axis.
    pub log: bool,
    /// The ends of the axis, if they do not follow from the data.
    pub range: Option<[f64; 2]>,
    /// Values that must lie on the axis; the axis ends at such a value if the data end there.
    pub include: Vec<f64>,
    /// Names at 0, 1, 2... instead of numbers.
    pub categories: Vec<String>,
    /// Exponent of the power of ten that is factored out, where a figure gives all axes of a unit the same one.
    pub shared_exponent: Option<i32>,
}

impl Axis {
    /// A linear axis for a dimensionless number or, with a unit in the label, for a quantity.
    pub fn new(label: &str) -> Self {
        Axis { label: label.to_owned(), ..Axis::default() }
    }

    /// Sets the SI unit; a suitable prefix or power of ten is chosen automatically.
    pub fn unit(mut self, unit: &str) -> Self {
        self.unit = unit.to_owned();
        self
    }

    /// Makes the axis logarithmic.
    pub fn logarithmic(mut self) -> Self {
        self.log = true;
        self
    }

    /// Sets the ends to `low` and `high`, independently of the data.
    pub fn between(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }

    /// Adds a value that must lie on the axis.
    pub fn including(mut self, value: f64) -> Self {
        self.include.push(value);
        self
    }

    /// Sets names at 0, 1, 2... instead of numbers.
    pub fn named(mut self, categories: &[String]) -> Self {
        self.categories = categories.to_vec();
        self.range = Some([-0.5, categories.len().max(1) as f64 - 0.5]);
        self
    }

    /// Determines the ends for data between `data[0]` and `data[1]` (`None` if there are no data).
    pub fn resolve(&self, data: Option<[f64; 2]>) -> Scale {
        let [low, high] = match self.range {
            Some([low, high]) if usable(low, self.log) && usable(high, self.log) && low < high => [low, high],
            _ if self.log => self.logarithmic_range(data),
            _ => self.linear_range(data),
        };
        Scale { low, high, log: self.log, from: 0.0, to: 1.0 }
    }

    fn linear_range(&self, data: Option<[f64; 2]>) -> [f64; 2] {
        let mut ends = data;
        for &value in self.include.iter().filter(|value| usable(**value, false)) {
            ends = Some(ends.map_or([value, value], |[low, high]| [low.min(value), high.max(value)]));
        }
        let Some([mut low, mut high]) = ends else { return [0.0, 1.0] };
        // Noise about a requested end does not move it.
        let noise = 0.015 * (high - low);
        for &end in &self.include {
            low = if low < end && end - low < noise { end } else { low };
            high = if high > end && high - end < noise { end } else { high };
        }
        // For constant data the range is extended on both sides, so that they are drawn as a line in the middle.
        let least = 1e-9 * low.abs().max(high.abs());
        let span = if high - low > least { high - low } else { 2.0 * (0.1 * low.abs()).max(0.5e-3) };
        let minor = ticks::nice_step(span, 6.0) / 2.0;
        let pad = |end: f64| if self.include.contains(&end) { 0.0 } else { 0.04 * span };
        let mut from = ((low - pad(low)) / minor + 1e-6).floor() * minor;
        let mut to = ((high + pad(high)) / minor - 1e-6).ceil() * minor;
        if low >= 0.0 && from < 0.0 {
            from = 0.0;
        }
        if high <= 0.0 && to > 0.0 {
            to = 0.0;
        }
        if to - from > least { [from, to] } else { [low - 0.5 * span, high + 0.5 * span] }
    }

    fn logarithmic_range(&self, data: Option<[f64; 2]>) -> [f64; 2] {
        let mut ends = data;
        for &value in self.include.iter().filter(|value| usable(**value, true)) {
            ends = Some(ends.map_or([value, value], |[low, high]| [low.min(value), high.max(value)]));
        }
        let Some([low, high]) = ends else { return [0.1, 1.0] };
        let (low, high) = (0.9 * low, 1.1 * high);
        let (a, b) =
            (power_of_ten(libm::log10(low).floor() as i32), power_of_ten(libm::log10(high).ceil() as i32));
        if libm::log10(b / a) > 3.5 {
            return [a, b];
        }
        // If the axis spans few decades, it ends at 1, 2 or 5 times a power of ten, so that little of it is empty.
        let lower = [5.0, 2.0, 1.0].into_iter().map(|digit| digit * a).find(|&end| end <= low).unwrap_or(a);
        let upper = [0.2, 0.5, 1.0].into_iter().map(|digit| digit * b).find(|&end| end >= high).unwrap_or(b);
        [lower, upper]
    }

    /// Exponent, a multiple of 3, of the power of ten that is factored out of the tick labels: of a linear axis by its largest value, of a
    /// logarithmic one with a unit by its middle, unless a figure gives it one ([`Axis::shared_exponent`]).
    pub fn exponent(&self, scale: &Scale) -> i32 {
        if let Some(shared) = self.shared_exponent {
            return shared;
        }
        let largest = match self.log {
            true if self.unit.is_empty() => return 0,
            true => scale.low.sqrt() * scale.high.sqrt(),
            false => scale.low.abs().max(scale.high.abs()),
        };
        if !self.categories.is_empty() || largest == 0.0 {
            return 0;
        }
        let exponent = 3 * (libm::log10(largest) / 3.0 + 1e-9).floor() as i32;
        let plain = if self.unit.is_empty() { 0.009..10001.0 } else { 0.9..1001.0 };
        if plain.contains(&largest) { 0 } else { exponent }
    }

    /// The ticks; their labels are divided by the power of ten of [`Axis::exponent`].
    pub fn ticks(&self, scale: &Scale, target: f64) -> Vec<Tick> {
        if !self.categories.is_empty() {
            return (self.categories.iter().enumerate())
                .map(|(k, name)| Tick { value: k as f64, label: Some(name.clone()) })
                .collect();
        }
        let factor = power_of_ten(self.exponent(scale));
        let of = if self.log { ticks::logarithmic } else { ticks::linear };
        let mut ticks = of(scale.low / factor, scale.high / factor, target);
        for tick in &mut ticks {
            tick.value *= factor;
        }
        ticks
    }

    /// The label with its unit.
    pub fn title(&self, scale: &Scale) -> String {
        let exponent = self.exponent(scale);
        match (self.unit.as_str(), exponent) {
            ("", 0) => self.label.clone(),
            ("", n) => format!("{} × 10^{{{}}}", self.label, ticks::fixed(-n as f64, 0)),
            (unit, 0) => format!("{} ({unit})", self.label),
            (unit, n) => match prefix(n) {
                Some(prefix) => format!("{} ({prefix}{unit})", self.label),
                None => format!("{} (10^{{{}}} {unit})", self.label, ticks::fixed(n as f64, 0)),
            },
        }
    }
}

fn prefix(exponent: i32) -> Option<&'static str> {
    Some(match exponent {
        -15 => "f",
        -12 => "p",
        -9 => "n",
        -6 => "μ",
        -3 => "m",
        3 => "k",
        6 => "M",
        9 => "G",
        _ => return None,
    })
}

/// True for a value that can be shown on an axis.
pub fn usable(value: f64, log: bool) -> bool {
    value.is_finite() && value.abs() < LARGEST && (!log || value > 1.0 / LARGEST)
}

/// The mapping from data to positions on the page.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Value at the start.
    pub low: f64,
    /// Value at the end.
    pub high: f64,
    /// True for a logarithmic scale.
    pub log: bool,
    /// Position of the start, px.
    pub from: f64,
    /// Position of the end, px.
    pub to: f64,
}

impl Scale {
    /// The same range of values between two other positions.
    pub fn laid(self, from: f64, to: f64) -> Self {
        Scale { from, to, ..self }
    }

    /// Position of a value; `None` for a value that cannot be shown.
    pub fn at(&self, value: f64) -> Option<f64> {
        if !usable(value, self.log) {
            return None;
        }
        let t = if self.log {
            libm::log(value / self.low) / libm::log(self.high / self.low)
        } else {
            (value - self.low) / (self.high - self.low)
        };
        let position = self.from + t * (self.to - self.from);
        position.is_finite().then_some(position)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn resolved(axis: &Axis, low: f64, high: f64) -> [f64; 2] {
        let scale = axis.resolve(Some([low, high]));
        [scale.low, scale.high]
    }

    #[test]
    fn ranges_end_at_round_numbers_and_keep_to_zero() {
        assert_eq!(resolved(&Axis::new("").including(0.0), 0.0, 0.83), [0.0, 0.9]);
        assert_eq!(resolved(&Axis::new("").including(0.0), -0.003, 0.83), [0.0, 0.9]);
        assert_eq!(resolved(&Axis::new(""), 0.002, 0.83), [0.0, 0.9]);
        assert_eq!(resolved(&Axis::new("").between(0.0, 0.3), 0.5, 0.6), [0.0, 0.3]);
        assert_eq!(resolved(&Axis::new("").logarithmic(), 1e-4, 1.2), [1e-5, 10.0]);
    }

    #[test]
    fn constant_empty_and_huge_data_give_a_range() {
        for (axis, data) in [
            (Axis::new(""), None),
            (Axis::new(""), Some([0.0, 0.0])),
            (Axis::new(""), Some([3.0, 3.0])),
            (Axis::new(""), Some([-1e99, 1e99])),
            (Axis::new(""), Some([1e9, 1e9 + 1e-6])),
            (Axis::new("").logarithmic(), None),
            (Axis::new("").logarithmic(), Some([1e-90, 1e90])),
            (Axis::new("").between(1.0, 1.0), Some([0.0, 1.0])),
            (Axis::new("").logarithmic().between(-1.0, 1.0), Some([0.5, 0.5])),
        ] {
            let scale = axis.resolve(data);
            assert!(scale.low < scale.high && scale.low.is_finite() && scale.high.is_finite(), "{scale:?}");
            assert!(!axis.ticks(&scale, 5.0).is_empty(), "{scale:?}");
        }
    }

    #[test]
    fn units_get_prefixes_and_numbers_powers() {
        let axis = Axis::new("Work").unit("J");
        let scale = axis.resolve(Some([0.0, 3.4e-8]));
        assert_eq!(axis.title(&scale), "Work (nJ)");
        let first = axis.ticks(&scale, 4.0).into_iter().rev().find_map(|tick| tick.label).unwrap();
        assert!(["30", "35"].contains(&first.as_str()), "{first}");
        let axis = Axis::new("*I*");
        assert_eq!(axis.title(&axis.resolve(Some([0.0, 3.6e-4]))), "*I* × 10^{6}");
        let axis = Axis::new("*p*").unit("Pa");
        assert_eq!(axis.title(&axis.resolve(Some([19e3, 21e3]))), "*p* (kPa)");
    }

    #[test]
    fn what_has_no_position_gets_none() {
        let scale = Axis::new("").logarithmic().resolve(Some([0.01, 1.0])).laid(0.0, 100.0);
        for value in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e200] {
            assert_eq!(scale.at(value), None);
        }
        assert!(scale.at(0.1).is_some_and(|position| (0.0..100.0).contains(&position)));
    }
}
