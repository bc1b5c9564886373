//! The path of the stress in the deviatoric plane, with strength criteria through its largest stress ratio.

use super::data::RunReport;
use super::figure::palette::{GREY, INK, color};
use super::figure::{Axis, Figure, Layer, Note, Panel, Plot, SHAPES, Stroke};

/// The place of principal stresses (x, y, z) in the deviatoric plane, over p: x points up, y to the lower right.
fn place([x, y, z]: [f64; 3]) -> [f64; 2] {
    let p = (x + y + z) / 3.0;
    [(y - z) / (2f64.sqrt() * p), (2.0 * x - y - z) / (6f64.sqrt() * p)]
}

/// Stresses of mean one at a radius and an angle from the axis x.
fn stresses(radius: f64, angle: f64) -> [f64; 3] {
    let (across, up) = (radius * libm::sin(angle), radius * libm::cos(angle));
    let x = 1.0 + up * (2.0f64 / 3.0).sqrt();
    let mean = 1.5 - 0.5 * x;
    [x, mean + across / 2f64.sqrt(), mean - across / 2f64.sqrt()]
}

/// `I_1 I_2 / I_3` of Matsuoka and Nakai.
fn matsuoka_nakai([x, y, z]: [f64; 3]) -> f64 {
    (x + y + z) * (x * y + y * z + z * x) / (x * y * z)
}

/// `I_1^3 / I_3` of Lade and Duncan.
fn lade_duncan([x, y, z]: [f64; 3]) -> f64 {
    (x + y + z).powi(3) / (x * y * z)
}

/// The curve on which a criterion has a value.
fn locus(criterion: fn([f64; 3]) -> f64, value: f64) -> Vec<[f64; 2]> {
    let radius = |angle: f64| {
        let (mut low, mut high) = (0.0, 6f64.sqrt());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let stress = stresses(middle, angle);
            // Beyond the positive stresses the criterion means nothing.
            let inside = stress.iter().all(|s| *s > 0.0) && criterion(stress) < value;
            *(if inside { &mut low } else { &mut high }) = middle;
        }
        low
    };
    (0..=180)
        .map(|k| {
            let angle = f64::from(k) * std::f64::consts::PI / 90.0;
            place(stresses(radius(angle), angle))
        })
        .collect()
}

/// The figure.
pub fn figure(run: &RunReport) -> (Figure, String) {
    let columns = ["stress_11", "stress_22", "stress_33"].map(|name| run.column(name));
    let rows = columns.iter().map(|column| column.len()).min().unwrap_or(0);
    let states: Vec<[f64; 3]> =
        (0..rows).map(|k| [0, 1, 2].map(|a| columns[a][k])).filter(|s| s.iter().all(|x| *x > 0.0)).collect();
    let path: Vec<[f64; 2]> = states.iter().copied().map(place).collect();
    let peak = states.iter().copied().max_by(|a, b| matsuoka_nakai(*a).total_cmp(&matsuoka_nakai(*b)));
    let mut plot = Plot::default();
    let mut reach = 0.2f64;
    if let Some(peak) = peak {
        for (criterion, name, dashes, k) in [
            (matsuoka_nakai as fn([f64; 3]) -> f64, "Matsuoka and Nakai", &[][..], 2),
            (lade_duncan, "Lade and Duncan", &[5.0, 3.0][..], 1),
        ] {
            let curve = locus(criterion, criterion(peak));
            reach = curve.iter().flatten().fold(reach, |m, x| m.max(x.abs()));
            plot = plot.with(Layer::stroked(curve, Stroke::new(color(k), 1.2).dashed(dashes)).named(name));
        }
    }
    reach *= 1.15;
    for angle in [0.0f64, 120.0, 240.0] {
        let (sin, cos) = libm::sincos(angle.to_radians());
        plot =
            plot.with(Layer::stroked(vec![[0.0, 0.0], [reach * sin, reach * cos]], Stroke::new(GREY, 0.7)));
    }
    let last = path.last().copied();
    plot = plot
        .with(Layer::line(path, color(0)).named("stress path"))
        .with(Layer::dots(last.into_iter().collect(), SHAPES[1], 2.7, INK))
        .note(Note::new("*σ*_{x}", [0.0, reach]).shifted([5.0, 12.0]));
    plot.x = Axis::new("(*σ*_{y} − *σ*_{z}) / (√2 *p*)").between(-reach, reach);
    plot.y = Axis::new("(2*σ*_{x} − *σ*_{y} − *σ*_{z}) / (√6 *p*)").between(-reach, reach);
    let caption = "Path of the normal stresses, divided by the mean stress, in the deviatoric plane; square: end. The \
                   criteria pass through the state with the largest *I*_{1}*I*_{2}/*I*_{3}: they show how strength \
                   would depend on the intermediate stress, and are not fitted.";
    (Figure::new("Deviatoric plane", 1, vec![Panel::plot(plot)]).sized(480.0, 474.0), caption.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_and_stresses_are_inverse_and_criteria_agree_in_compression() {
        for k in 0..12 {
            let angle = f64::from(k) * std::f64::consts::PI / 6.0;
            let [across, up] = place(stresses(0.4, angle));
            assert!((across - 0.4 * angle.sin()).abs() < 1e-12 && (up - 0.4 * angle.cos()).abs() < 1e-12);
        }
        // Friction of 30 degrees in compression: 9 + 8 tan^2, and the radius of both curves.
        let peak = [3.0, 1.0, 1.0];
        assert!((matsuoka_nakai(peak) - (9.0 + 8.0 / 3.0)).abs() < 1e-12);
        let top = place(peak)[1];
        for criterion in [matsuoka_nakai as fn([f64; 3]) -> f64, lade_duncan] {
            let curve = locus(criterion, criterion(peak));
            assert!((curve[0][1] - top).abs() < 1e-9 && curve[0][0].abs() < 1e-9);
            // In extension, b = 1: 30 degrees again for Matsuoka and Nakai, 33.6307 for Lade and Duncan.
            let [_, y] = curve[90];
            let lowest = stresses(-y, std::f64::consts::PI);
            let sin = (lowest[1] - lowest[0]) / (lowest[1] + lowest[0]);
            let wanted = if std::ptr::fn_addr_eq(criterion, lade_duncan as fn([f64; 3]) -> f64) {
                33.63071
            } else {
                30.0
            };
            assert!((sin.asin().to_degrees() - wanted).abs() < 1e-4, "{}", sin.asin().to_degrees());
        }
    }
}
