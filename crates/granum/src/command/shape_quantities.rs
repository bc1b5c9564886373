//! What `granum shape` tells about a shape, as readable text and under the keys of its JSON.

use granum_report::shapes::{OriginalBody, ShownShape};

use crate::numbers::rounded;

/// Largest number of shapes beside each other.
const BESIDE: usize = 6;

/// How a number is shown.
#[derive(Clone, Copy)]
pub enum Shown {
    /// With four digits.
    Number,
    /// As a share in percent.
    Percent,
    /// As an error in percent with its sign.
    Error,
}

/// A quantity of a shape.
pub struct Quantity {
    /// Its key in JSON.
    pub key: &'static str,
    name: &'static str,
    shown: Shown,
    /// Its value, if the shape has it.
    pub value: fn(&ShownShape) -> Option<f64>,
}

/// A quantity that every shape has.
fn of_all(key: &'static str, name: &'static str, value: fn(&ShownShape) -> Option<f64>) -> Quantity {
    Quantity { key, name, shown: Shown::Number, value }
}

/// All quantities, in the order in which they are shown.
pub fn quantities() -> Vec<Quantity> {
    let mut all = vec![
        Quantity { key: "share", name: "share of the mass", shown: Shown::Percent, value: |s| Some(s.share) },
        of_all("pieces", "spheres", |s| Some(s.pieces() as f64)),
        of_all("elongation", "elongation (intermediate over largest length)", |s| {
            Some(s.descriptors.elongation)
        }),
        of_all("flatness", "flatness (least over intermediate length)", |s| Some(s.descriptors.flatness)),
        of_all("sphericity", "sphericity", |s| Some(s.descriptors.sphericity)),
        of_all("original_sphericity", "  that of the original", |s| Some(s.original.as_ref()?.sphericity)),
        of_all("convexity", "convexity", |s| Some(s.descriptors.convexity)),
        of_all("roundness", "roundness", |s| Some(s.descriptors.roundness)),
        of_all("sieve_over_volume_diameter", "sieve diameter over volume diameter", |s| {
            Some(s.descriptors.sieve_diameter() / s.descriptors.volume_diameter)
        }),
        of_all("time_step_share", "time step over that of spheres of the same mass", |s| {
            Some(s.time_step_share)
        }),
        of_all("seam_slope", "slope tan(chi) of the widest seam", |s| s.seam),
    ];
    all.extend(of_covers());
    all
}

/// What is known of spheres that stand for a body of a file.
fn of_covers() -> [Quantity; 10] {
    let error = |key, name, value| Quantity { key, name, shown: Shown::Error, value };
    [
        of_all("original_volume", "volume of the original, in its unit", |s| {
            Some(s.original.as_ref()?.volume)
        }),
        error("volume_error", "error of the volume, spheres as found", |s| Some(body(s)?.report.volume)),
        error("volume_error_after_growth", "  after they grew", |s| {
            Some(body(s)?.volume_of_spheres / body(s)?.volume - 1.0)
        }),
        of_all("growth", "growth of the radii over the diameter", |s| Some(body(s)?.report.growth)),
        error("least_inertia_error", "error of the least moment of inertia", |s| {
            Some(body(s)?.report.inertia[0])
        }),
        error("intermediate_inertia_error", "  of the intermediate one", |s| {
            Some(body(s)?.report.inertia[1])
        }),
        error("largest_inertia_error", "  of the largest one", |s| Some(body(s)?.report.inertia[2])),
        error("surface_error", "error of the surface", |s| Some(body(s)?.report.surface)),
        of_all("mean_distance", "distance of the surfaces over the diameter, mean", |s| {
            Some(body(s)?.report.mean_distance)
        }),
        of_all("largest_distance", "  at most", |s| Some(body(s)?.report.largest_distance)),
    ]
}

fn body(shape: &ShownShape) -> Option<&OriginalBody> {
    shape.original.as_ref()
}

/// The table of shapes: a row for each quantity that any of them has, and a column for each shape.
pub fn text(shapes: &[ShownShape]) -> String {
    let blocks = shapes.chunks(BESIDE).enumerate().map(|(k, shapes)| block(k * BESIDE, shapes));
    blocks.collect::<Vec<_>>().join("\n\n")
}

fn block(before: usize, shapes: &[ShownShape]) -> String {
    let names = shapes.iter().enumerate().map(|(k, shape)| format!("{} {}", before + k + 1, shape.name));
    let mut rows = vec![("shape".to_string(), names.collect::<Vec<_>>())];
    for quantity in quantities() {
        let cells: Vec<Option<String>> = shapes.iter().map(|shape| cell(&quantity, shape)).collect();
        if cells.iter().any(Option::is_some) {
            let cells = cells.into_iter().map(|cell| cell.unwrap_or_else(|| "-".into()));
            rows.push((quantity.name.into(), cells.collect()));
        }
    }
    let first = rows.iter().map(|(name, _)| name.chars().count()).max().unwrap_or(0);
    let widths: Vec<usize> = (0..shapes.len())
        .map(|k| rows.iter().map(|(_, cells)| cells[k].chars().count()).max().unwrap_or(0))
        .collect();
    let line = |(name, cells): &(String, Vec<String>)| {
        let cells = cells.iter().zip(&widths).map(|(cell, width)| format!("  {cell:>width$}"));
        format!("{name:<first$}{}", cells.collect::<String>())
    };
    rows.iter().map(line).collect::<Vec<_>>().join("\n")
}

fn cell(quantity: &Quantity, shape: &ShownShape) -> Option<String> {
    let value = (quantity.value)(shape).filter(|value| value.is_finite())?;
    Some(match quantity.shown {
        Shown::Number => rounded(value, 4),
        Shown::Percent => format!("{:.1} %", 100.0 * value),
        // Rounded first, so that zero has no sign of its own.
        Shown::Error => format!("{:+.2} %", (1e4 * value).round() / 100.0 + 0.0),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use granum_dem::shape::{ShapeEntry, ShapeKind};

    #[test]
    fn rows_that_no_shape_has_are_left_out() {
        let entry = |kind| ShownShape::of_entry(&ShapeEntry::new(kind), &mut Vec::new()).unwrap();
        let sphere = text(&entry(ShapeKind::SPHERE));
        assert!(sphere.contains("sphericity") && !sphere.contains("seam") && !sphere.contains("original"));
        let both = [entry(ShapeKind::SPHERE), entry(ShapeKind::DIMER)].concat();
        let seam = text(&both).lines().find(|line| line.contains("seam")).unwrap().to_string();
        assert!(seam.ends_with("-   0.2582"), "{seam}");
    }
}
