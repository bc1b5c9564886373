//! Curves with their bands as text, for a terminal.

/// Columns and rows of the field.
const WIDTH: usize = 60;
const HEIGHT: usize = 9;

/// A curve: x, mean, lower and upper end, and what a test measured there if there is one.
pub struct ChartPoint {
    pub x: f64,
    pub mean: f64,
    pub lower: f64,
    pub upper: f64,
    pub measured: Option<f64>,
}

impl ChartPoint {
    /// What is measured, or the mean.
    fn seen(&self) -> f64 {
        self.measured.unwrap_or(self.mean)
    }
}

/// The lines of a chart: the mean as dots, a test as crosses over it, the band shaded, the ends of the axes as numbers.
pub fn chart(points: &[ChartPoint]) -> Vec<String> {
    let least = points.iter().map(|point| point.lower.min(point.seen())).fold(f64::INFINITY, f64::min);
    let most = points.iter().map(|point| point.upper.max(point.seen())).fold(f64::NEG_INFINITY, f64::max);
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    // Close to zero the axis begins there.
    let low = if least > 0.0 && least < 0.3 * most { 0.0 } else { least };
    let high = if most > low { most } else { low + 1.0 };
    let xs: Vec<f64> = points.iter().map(|point| point.x).collect();
    let at = |x: f64, value: fn(&ChartPoint) -> f64| {
        let values: Vec<f64> = points.iter().map(value).collect();
        granum_learn::curve::interpolated(x, &xs, &values)
    };
    let row_of = |value: f64| {
        let share = ((value - low) / (high - low)).clamp(0.0, 1.0);
        ((1.0 - share) * (HEIGHT - 1) as f64).round() as usize
    };
    let mut rows = vec![vec![' '; WIDTH]; HEIGHT];
    for column in 0..WIDTH {
        let x = first.x + (last.x - first.x) * column as f64 / (WIDTH - 1) as f64;
        let (top, bottom) = (row_of(at(x, |point| point.upper)), row_of(at(x, |point| point.lower)));
        rows[top..=bottom].iter_mut().for_each(|row| row[column] = '░');
        rows[row_of(at(x, |point| point.mean))][column] = '●';
        if points.iter().any(|point| point.measured.is_some()) {
            rows[row_of(at(x, ChartPoint::seen))][column] = '×';
        }
    }
    // What is next to nothing on the scale of the axis is zero.
    let shown = |value: f64| short(if value.abs() < 1e-3 * (high - low) { 0.0 } else { value });
    let label = |row: usize| match row {
        0 => shown(high),
        _ if row == HEIGHT - 1 => shown(low),
        _ => String::new(),
    };
    let mut lines: Vec<String> = rows
        .iter()
        .enumerate()
        .map(|(k, row)| format!("{:>9} │{}", label(k), row.iter().collect::<String>().trim_end()))
        .collect();
    lines.push(format!("{:>9} └{}", "", "─".repeat(WIDTH)));
    let (left, right) = (short(first.x), short(last.x));
    lines.push(format!("{:>11}{left}{right:>width$}", "", width = WIDTH - left.chars().count()));
    lines
}

/// A number with three digits.
pub fn short(value: f64) -> String {
    crate::numbers::rounded(if value.abs() < 1e-12 { 0.0 } else { value }, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rising_curve_goes_from_the_lower_left_to_the_upper_right() {
        let points: Vec<ChartPoint> = (0..11)
            .map(|k| f64::from(k) / 10.0)
            .map(|x| ChartPoint { x, mean: x, lower: x - 0.1, upper: x + 0.1, measured: None })
            .collect();
        let lines = chart(&points);
        assert_eq!(lines.len(), HEIGHT + 2);
        assert!(
            lines[0].starts_with("      1.1 │") && lines[HEIGHT - 1].starts_with("     -0.1 │"),
            "{lines:#?}"
        );
        let field: Vec<Vec<char>> =
            lines[..HEIGHT].iter().map(|line| line.chars().skip(11).collect()).collect();
        let column = |k: usize| field.iter().position(|row| row.get(k) == Some(&'●'));
        assert!(column(0) > column(WIDTH / 2) && column(WIDTH / 2) > column(WIDTH - 1), "{lines:#?}");
        assert!(lines[HEIGHT + 1].ends_with('1') && lines[HEIGHT + 1].contains(" 0 "), "{lines:#?}");
        assert!(chart(&[]).is_empty());
        let measured: Vec<ChartPoint> =
            points.into_iter().map(|point| ChartPoint { measured: Some(1.0 - point.x), ..point }).collect();
        let lines = chart(&measured);
        assert!(lines[1].contains('×') && !lines.join("").contains("●●●●●●●●●●●●"), "{lines:#?}");
    }
}
