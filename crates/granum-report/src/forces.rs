//! The distribution of the forces: P(f) and its tail, the roses of the normals, and pictures of the force chains.

use std::f64::consts::PI;

use granum_core::assembly::Assembly;
use granum_run::strength::Curves;
use granum_sensors::Histogram;

use super::data::RunReport;
use super::figure::chains::View;
use super::figure::palette::{COLORS, GREY, color};
use super::figure::rose::Series;
use super::figure::ticks::fixed;
use super::figure::{Axis, Figure, ForceChains, Layer, Legend, Panel, Plot, Rose, SHAPES, Stroke};
use super::material::strain_axis;

/// Characteristic rows of a run: the start, the peak of the stress ratio and the end.
pub fn characteristic_rows(run: &RunReport) -> Vec<(usize, &'static str)> {
    let rows = run.record.series.rows();
    if rows == 0 {
        return Vec::new();
    }
    let mut telling = vec![(0, "start")];
    let stages = run.case.test_stages();
    let curves = Curves::new(&run.record, &stages);
    if let Some(peak) = curves.peak_row(&curves.test_rows()).filter(|&k| k > 0 && k + 1 < rows) {
        let name = if curves.axis().is_some() { "peak of *q*/*p*" } else { "peak of *q*_{vM}/*p*" };
        telling.push((peak, name));
    }
    if rows > 1 {
        telling.push((rows - 1, "end"));
    }
    telling
}

/// The bins as points (centre, density), without empty bins.
pub fn density(histogram: &Histogram) -> Vec<[f64; 2]> {
    (0..histogram.bins())
        .filter(|&bin| histogram.counts[bin] > 0)
        .map(|bin| [histogram.centre(bin), histogram.density(bin)])
        .collect()
}

fn at_strain(run: &RunReport, row: usize, name: &str) -> String {
    let strain = run.strain().get(row).copied().unwrap_or(f64::NAN);
    match run.is_at_constant_p() {
        _ if strain.abs() < 5e-4 => name.to_owned(),
        true => format!("{name}, *ε*_{{d}} = {}", fixed(strain, 2)),
        false => format!("{name}, strain {}", fixed(strain, 2)),
    }
}

/// Figure of P(f) on a logarithmic scale at three states with fits to the tail, and of the evolution of the tail with
/// strain.
pub fn distribution(run: &RunReport) -> (Figure, String) {
    let force = "Normal force *f* = *N*/⟨*N*⟩";
    let mut plot = Plot::new(Axis::new(force), Axis::new("Probability density *P*(*f*)").logarithmic());
    for (k, (row, name)) in characteristic_rows(run).into_iter().enumerate() {
        let Some(histogram) = run.record.forces().get(row) else { continue };
        let label = at_strain(run, row, name);
        plot = plot.with(Layer::points(density(histogram), SHAPES[k], color(k)).named(&label));
    }
    if let Some(&(row, _)) = characteristic_rows(run).last() {
        let fits = tail_fits(run, row);
        for (points, name, dash) in fits {
            let stroke = Stroke::new("#333333", 1.2).dashed(dash);
            plot = plot.with(Layer::stroked(points, stroke).named(name));
        }
    }
    let axis = || strain_axis(std::slice::from_ref(run));
    let tail = Plot::new(axis(), Axis::new("Log-likelihood ratio per strong contact").including(0.0))
        .with(Layer::horizontal(0.0, GREY))
        .with(Layer::line(run.against_strain("exponential_advantage"), color(0)));
    let panels = vec![Panel::plot(plot), Panel::plot(tail)];
    let caption = "(a) Distribution of normal contact forces (adhesive contacts in tension have *f* < 0) and, for the \
                   end of the test, the exponential and the half-Gaussian fitted to *f* > 1 by maximum likelihood. (b) \
                   Log-likelihood of the exponential minus that of the half-Gaussian: above zero the tail is closer to \
                   an exponential."
        .to_owned();
    let figure = Figure::new("Distribution of normal forces on a logarithmic scale", 2, panels);
    (figure.sized(720.0, 310.0), caption)
}

type Fit = (Vec<[f64; 2]>, &'static str, &'static [f64]);

/// The two fits to the tail of a state, scaled to the share of strong contacts.
fn tail_fits(run: &RunReport, row: usize) -> Vec<Fit> {
    let value =
        |name: &str| run.column(name).get(row).copied().filter(|value| value.is_finite() && *value > 0.0);
    let Some(strong) = value("strong_fraction") else { return Vec::new() };
    let largest = run.record.forces().get(row).map_or(1.0, |h| h.centre(h.bins().saturating_sub(1)));
    let fine: Vec<f64> = (0..=100).map(|k| 1.0 + (largest - 1.0) * k as f64 / 100.0).collect();
    // The lines end shortly below the last point.
    let points = run.record.forces().get(row).map(density).unwrap_or_default();
    let least = 0.3 * points.iter().filter(|p| p[0] > 1.0).map(|p| p[1]).fold(f64::INFINITY, f64::min);
    let drawn = |tail: &dyn Fn(f64) -> f64| -> Vec<[f64; 2]> {
        fine.iter().map(|&f| [f, strong * tail(f)]).filter(|p| p[1] >= least).collect()
    };
    let mut fits: Vec<Fit> = Vec::new();
    if let Some(beta) = value("exponential_decay") {
        fits.push((drawn(&|f| beta * libm::exp(-beta * (f - 1.0))), "exponential fit", &[]));
    }
    if let Some(s) = value("half_gaussian_width") {
        let norm = half_gaussian_norm(s);
        fits.push((drawn(&|f| libm::exp(-0.5 * (f / s).powi(2)) / norm), "half-Gaussian fit", &[5.0, 3.0]));
    }
    fits
}

/// `integral_1^inf exp(-f^2 / 2 s^2) df`.
fn half_gaussian_norm(s: f64) -> f64 {
    let steps = 2000;
    let below: f64 = (0..steps)
        .map(|k| {
            let f = (k as f64 + 0.5) / steps as f64;
            libm::exp(-0.5 * (f / s).powi(2)) / steps as f64
        })
        .sum();
    s * (0.5 * PI).sqrt() - below
}

/// Figure of the roses of contact normals, by number and by force.
pub fn roses(run: &RunReport) -> (Figure, String) {
    let bins = granum_sensors::rose::BINS;
    let columns = |prefix: &str, row: usize| -> Vec<f64> {
        (0..bins)
            .map(|b| run.column(&format!("{prefix}{:02}", 5 + 10 * b)).get(row).copied().unwrap_or(f64::NAN))
            .collect()
    };
    let mut roses: Vec<(Rose, String)> = Vec::new();
    for (row, name) in characteristic_rows(run) {
        let number = columns("rose_", row);
        let force = number.iter().zip(columns("rose_force_", row)).map(|(n, f)| n * f).collect();
        let series = vec![
            Series { label: "by number".to_owned(), values: number, color: COLORS[0].to_owned() },
            Series { label: "by normal force".to_owned(), values: force, color: COLORS[1].to_owned() },
        ];
        let rose = Rose {
            series,
            reference: Some(1.0),
            up: "axis 1".into(),
            right: "3".into(),
            ..Default::default()
        };
        roses.push((rose, at_strain(run, row, name)));
    }
    let rim = roses.iter().map(|(rose, _)| rose.largest()).fold(1.0, f64::max);
    let panels: Vec<Panel> = (roses.into_iter())
        .map(|(rose, title)| Panel::rose(Rose { rim: Some(rim), ..rose }).titled(&title))
        .collect();
    let columns = panels.len().max(1);
    let figure = Figure::new("Roses of contact normals", columns, panels);
    let caption = "Directions of contact normals around the axis of compression (up), as densities relative to an \
                   isotropic assembly (dashed circle): by number of contacts, and weighted by their normal force.";
    (figure.sized(720.0, 246.0).legend(Legend::Above), caption.to_owned())
}

/// Figure of slices through the sample before and after shear at one scale, with contacts drawn by their force.
pub fn slices(start: Option<&Assembly>, end: Option<&Assembly>) -> Option<(Figure, String)> {
    let titled = [(start, "at the start"), (end, "at the end")];
    let pictures: Vec<(ForceChains, &str)> = (titled.into_iter())
        .filter_map(|(assembly, title)| Some((assembly?, title)))
        .map(|(assembly, title)| (ForceChains::new(assembly, View::slice(assembly, 1.6)), title))
        .collect();
    if pictures.is_empty() {
        return None;
    }
    let extent = pictures.iter().fold([0.0f64; 2], |largest, (picture, _)| {
        std::array::from_fn(|k| largest[k].max(picture.extent()[k]))
    });
    let columns = pictures.len();
    let width = if columns == 1 { 440.0 } else { 720.0 };
    let height = ForceChains::height_for(extent, width / columns as f64 - 16.0) + 30.0;
    let panels = (pictures.into_iter())
        .map(|(picture, title)| Panel::chains(picture.with_extent(extent)).titled(title))
        .collect();
    let caption = "Force chains in a slice 1.6 diameters thick through the middle of the cell, axis 1 up. Grains are faint \
                   circles (white: fewer than two contacts); each contact between grains of the slice is a line from \
                   centre to centre, as wide and dark as its normal force. Contacts across the periodic boundary are \
                   drawn at both sides and end at it.";
    let figure = Figure::new("Force chains in a slice of the sample", columns, panels);
    Some((figure.sized(width, height), caption.to_owned()))
}

/// Figure of the strong contacts of a whole cell.
pub fn strong_network(assembly: &Assembly) -> (Figure, String) {
    let picture = ForceChains::new(assembly, View::strong());
    let height = ForceChains::height_for(picture.extent(), 632.0) + 8.0;
    let caption =
        "Strong contacts (*N* > ⟨*N*⟩) of the whole cell at the end, seen along axis 3; contacts farther \
                   away are paler."
            .to_owned();
    let figure = Figure::new("Strong contacts of the whole cell", 1, vec![Panel::chains(picture)]);
    (figure.sized(640.0, height), caption)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_half_gaussian_is_normalised() {
        for s in [0.5, 1.0, 1.253, 3.0] {
            let norm = half_gaussian_norm(s);
            let steps = 200_000;
            let sum: f64 = (0..steps)
                .map(|k| {
                    let f = 1.0 + 12.0 * s * (k as f64 + 0.5) / steps as f64;
                    (-0.5 * (f / s).powi(2)).exp() * 12.0 * s / steps as f64
                })
                .sum();
            assert!((norm / sum - 1.0).abs() < 1e-5, "{s}: {norm} {sum}");
        }
    }
}
