//! The behaviour of the material: stress, volume, contacts and fabric as functions of strain.

use super::data::{RoleInStudy, RunReport};
use super::figure::literal;
use super::figure::palette::{GREY, INK, color};
use super::figure::{Axis, Figure, Layer, Legend, Panel, Plot, Stroke};
use super::symbols::STRAIN;

/// The strain axis of runs: from 0 to the largest strain.
pub fn strain_axis(runs: &[RunReport]) -> Axis {
    let axis = Axis::new(runs.first().map_or(STRAIN, |run| run.strain_and_label().1));
    if !runs.iter().all(RunReport::is_at_constant_p) {
        return axis.including(0.0);
    }
    let last = runs.iter().filter_map(|run| run.strain().last().copied());
    let largest = last.filter(|strain| strain.is_finite()).fold(0.0, f64::max);
    if largest > 0.0 { axis.between(0.0, round_up(largest)) } else { axis }
}

/// Rounds up the end of the strain axis to the nominal strain of the last state, since the average over samples around
/// that state lies just before it.
fn round_up(strain: f64) -> f64 {
    (strain / 0.01 - 0.05).ceil() * 0.01
}

/// Colour and name of a run in figures that show several.
fn style(runs: &[RunReport], k: usize) -> (Stroke, String) {
    match runs[k].role {
        RoleInStudy::Unseen => {
            let unseen = runs[..k].iter().filter(|run| run.role == RoleInStudy::Unseen).count();
            let shade = ["#7a7a7a", "#b0b0b0", "#949494", "#c6c6c6"][unseen % 4];
            (Stroke::new(shade, 1.4), "unseen runs".to_owned())
        }
        RoleInStudy::Training => (Stroke::new(color(0), 1.8), "training run".to_owned()),
        RoleInStudy::Single => (Stroke::new(color(k), 1.8), literal(&runs[k].name)),
    }
}

/// One line for each run, with the training run on top.
fn lines(runs: &[RunReport], column: &str) -> Vec<Layer> {
    let mut order: Vec<usize> = (0..runs.len()).collect();
    order.sort_by_key(|&k| runs[k].role != RoleInStudy::Unseen);
    order
        .into_iter()
        .map(|k| {
            let (stroke, name) = style(runs, k);
            let layer = Layer::stroked(runs[k].against_strain(column), stroke);
            if runs.len() > 1 { layer.named(&name) } else { layer }
        })
        .collect()
}

/// Figure of q/p and volumetric strain.
pub fn stress_and_volume(runs: &[RunReport]) -> (Figure, String) {
    let stress = Plot::new(strain_axis(runs), Axis::new("Stress ratio *q*/*p*").including(0.0))
        .with_all(lines(runs, "stress_ratio"));
    let volume = Plot::new(strain_axis(runs), Axis::new("Volumetric strain *ε*_{v}"))
        .with(Layer::stroked(vec![[0.0, 0.0], [1.0, 0.0]], Stroke::new(GREY, 0.8)))
        .with_all(lines(runs, "volumetric_strain"));
    let panels = vec![Panel::plot(stress), Panel::plot(volume)];
    let figure = Figure::new("Stress ratio and volumetric strain against deviator strain", 2, panels);
    let caption = "Axisymmetric compression at constant mean stress. (a) Ratio of deviator stress to mean stress; (b) volumetric \
                   strain, compression positive, so that a falling curve is dilation.";
    (figure, caption.to_owned())
}

/// Figure of the contributions to q: strong and weak contacts, normal and tangential forces.
pub fn stress_shares(run: &RunReport) -> (Figure, String) {
    let axis = || strain_axis(std::slice::from_ref(run));
    let panel = |parts: [(&str, &str, usize); 2]| {
        let mut plot = Plot::new(axis(), Axis::new("Contribution to *q*/*p*").including(0.0))
            .with(Layer::stroked(run.against_strain("stress_ratio"), Stroke::new(INK, 1.2)).named("all"));
        for (column, name, k) in parts {
            plot = plot.with(Layer::line(run.against_strain(column), color(k)).named(name));
        }
        Panel::plot(plot)
    };
    let panels = vec![
        panel([("strong_stress_ratio", "strong contacts", 1), ("weak_stress_ratio", "weak contacts", 0)]),
        panel([
            ("normal_stress_ratio", "normal forces", 2),
            ("tangential_stress_ratio", "tangential forces", 3),
        ]),
    ];
    let caption = "Contributions to the deviator stress: (a) contacts with *N* > ⟨*N*⟩ (strong) and the others (weak); \
                   (b) normal and tangential forces. The contributions add up to *q*/*p*.";
    (Figure::new("Contributions to the stress ratio against deviator strain", 2, panels), caption.to_owned())
}

/// Figure of coordination numbers, sliding contacts and rattlers.
pub fn coordination(run: &RunReport) -> (Figure, String) {
    let axis = || strain_axis(std::slice::from_ref(run));
    let mut numbers = Plot::new(axis(), Axis::new("Coordination number"));
    for (k, (column, name)) in [
        ("backbone_coordination_number", "backbone"),
        ("mechanical_coordination_number", "mechanical *Z*_{m}"),
        ("coordination_number", "all grains *Z*"),
        ("compressive_coordination_number", "in compression only"),
    ]
    .into_iter()
    .enumerate()
    {
        numbers = numbers.with(Layer::line(run.against_strain(column), color([2, 0, 1, 3][k])).named(name));
    }
    let mut shares = Plot::new(axis(), Axis::new("Fraction").including(0.0));
    for (k, (column, name)) in [
        ("sliding_fraction", "sliding contacts"),
        ("strong_sliding_fraction", "sliding among strong contacts"),
        ("tensile_fraction", "contacts in tension"),
        ("rattler_fraction", "rattlers among grains"),
    ]
    .into_iter()
    .enumerate()
    {
        shares = shares.with(Layer::line(run.against_strain(column), color(k)).named(name));
    }
    let panels = vec![Panel::plot(numbers), Panel::plot(shares)];
    let caption = "(a) Mean number of contacts of a grain by four definitions: over all grains; over those with at \
                   least two contacts (Thornton 2000); of contacts in compression; of the grains that remain when \
                   rattlers are removed repeatedly. (b) Fractions of sliding contacts, among all and among strong \
                   contacts, of contacts in tension, and of grains with fewer than two contacts.";
    (Figure::new("Coordination numbers and fractions against strain", 2, panels), caption.to_owned())
}

/// Figure of the deviator fabric of all, strong and weak contacts.
pub fn fabric(runs: &[RunReport]) -> (Figure, String) {
    let all = Plot::new(strain_axis(runs), Axis::new("Deviator fabric *φ*_{d}").including(0.0))
        .with_all(lines(runs, "deviator_fabric"));
    let mut panels = vec![Panel::plot(all)];
    if let Some(run) = runs.first() {
        let mut parts = Plot::new(strain_axis(runs), Axis::new("Deviator fabric *φ*_{d}").including(0.0));
        for (column, name, k) in
            [("strong_deviator_fabric", "strong contacts", 1), ("weak_deviator_fabric", "weak contacts", 0)]
        {
            parts = parts.with(Layer::line(run.against_strain(column), color(k)).named(name));
        }
        let all = Layer::stroked(run.against_strain("deviator_fabric"), Stroke::new(INK, 1.2)).named("all");
        panels.push(Panel::plot(parts.with(all)));
    }
    let caption = "Anisotropy of the contact network, *φ*_{d} = *φ*_{1} − *φ*_{3} of *φ*_{ij} = ⟨*n*_{i}*n*_{j}⟩. (a) All \
                   contacts; (b) strong and weak contacts, each averaged over their own number.";
    (
        Figure::new("Deviator fabric against deviator strain", 2, panels).legend(Legend::Inside),
        caption.to_owned(),
    )
}

/// Anisotropy of the contacts without an axis of its own.
pub fn principal_fabric(run: &RunReport) -> (Figure, String) {
    let plot = Plot::new(
        strain_axis(std::slice::from_ref(run)),
        Axis::new("Fabric *φ*_{1} − *φ*_{3}").including(0.0),
    )
    .with(Layer::line(run.against_strain("principal_deviator_fabric"), color(0)));
    let caption = "Anisotropy of the contact network: largest minus smallest eigenvalue of *φ*_{ij} = ⟨*n*_{i}*n*_{j}⟩.";
    (Figure::new("Anisotropy of the contacts", 1, vec![Panel::plot(plot)]), caption.to_owned())
}
