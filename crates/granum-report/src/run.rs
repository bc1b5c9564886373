//! The report of one run.

use granum_run::strength::COHESIVE;
use granum_run::strength::symmetry::shear_at_constant_p;
use maud::{Markup, html};

use super::case_details::{case_details, whose_grains};
use super::data::RunReport;
use super::figure::literal;
use super::forces;
use super::further;
use super::material;
use super::numbers::{quantity, significant};
use super::page::{Document, Page, rich, tiles};
use super::viewer::folded;
use super::{path, preparation, sample, shapes, strength, trust};

/// The conventions for signs and axes, which every report states once.
pub const SIGNS: &str = "Compression is positive, for stress, strain and normal force. Axis 1 is the axis of compression, \
                         axes 2 and 3 are averaged: *q* = *σ*_{1} − *σ*_{3}, *p* = (*σ*_{1} + *σ*_{2} + *σ*_{3})/3, \
                         *ε*_{d} = *ε*_{1} − *ε*_{3}, *φ*_{d} = *φ*_{1} − *φ*_{3}. Strains are logarithmic.";

/// The same for tests along any path.
const SIGNS_OF_ANY_TEST: &str = "Compression is positive, for stress, strain and normal force. *p* is the mean stress; *q* of a triaxial test is \
                               the axial less the mean lateral stress, *q*_{vM} = √(3 *J*_{2}) of any other test the von Mises stress; \
                               *ε*_{q} = √(2/3 *e*:*e*) with the deviator *e* of the strain. Axis 1 is *x*. Strains are \
                               logarithmic and count from the start of the last stage that resets them.";

/// Writes the report of a run.
pub fn report(run: &RunReport) -> Document {
    let mut page = Page::default();
    let runs = std::slice::from_ref(run);
    let behaviour = behaviour(&mut page, runs);
    let further: Vec<Markup> = (further::figures(run).iter())
        .map(|(file, figure, caption)| page.own_figure(file, caption, figure))
        .collect();
    let strength = strength::table(&mut page, run);
    let behaviour = html! {
        @if let Some(strength) = strength { (strength) }
        (behaviour)
        @for figure in further { (figure) }
    };
    page.section("behaviour", "Stress, volume and contacts", behaviour);
    let spread = force_section(&mut page, run);
    page.section("forces", "Distribution of the contact forces", spread);
    let trust = trust::section(&mut page, runs);
    page.section("quality", "Can it be trusted?", trust);
    let preparation =
        preparation::figure(run).map(|(figure, caption)| page.own_figure("preparation", &caption, &figure));
    let label = page.own_table_label();
    let shapes = shapes::section(&mut page, run);
    page.section(
        "case",
        "The sample and the case",
        html! {
            (sample::own_table(&label, run).html())
            @if let Some(shapes) = shapes { (shapes) }
            @if let Some(preparation) = preparation { (preparation) }
            (case_details(run))
        },
    );
    let head = html! {
        (tiles(&headline(run)))
        p { (rich(if run.is_at_constant_p() { SIGNS } else { SIGNS_OF_ANY_TEST })) }
        @if !run.is_complete() { p class="callout" { "The test was stopped before its end; the states recorded until then are shown." } }
    };
    page.finish(&literal(&run.name), &subtitle(run), head)
}

fn subtitle(run: &RunReport) -> String {
    let case = &run.case;
    let mut parts = vec![whose_grains(run), sample::law(&case.contact), test_of(run)];
    if !run.run.granum_version.is_empty() {
        parts.push(format!("granum {}", run.run.granum_version));
    }
    parts.join(" · ")
}

/// Description of the test: what it is, if it is like the paper's, or the names of its stages.
fn test_of(run: &RunReport) -> String {
    let stages = run.case.test_stages();
    if let Some(target) = shear_at_constant_p(&stages) {
        let stress = target.value.unwrap_or(run.case.preparation.mean_stress);
        return format!("axisymmetric compression at *p* = {}", quantity(stress, "Pa"));
    }
    let names: Vec<String> =
        stages.iter().filter(|stage| !stage.is_mark()).map(|stage| literal(&stage.name)).collect();
    match names.len() {
        0..=6 => names.join(", "),
        count => format!("{count} stages: {}, ...", names[..3].join(", ")),
    }
}

fn headline(run: &RunReport) -> Vec<[String; 3]> {
    let tile = |value: Option<f64>, name: &str, remark: String| {
        Some([significant(value?, 3), name.to_owned(), remark])
    };
    let measures = run.measures();
    let measure = |name: &str| measures.get(name).copied();
    let (symbol, strain) = match measure("deviator_strain_at_peak") {
        Some(strain) => ("*ε*_{d}", Some(strain)),
        None => ("*ε*_{q}", measure("deviatoric_strain_at_peak")),
    };
    let where_peak = strain.map_or(String::new(), |e| format!("at {symbol} = {}", significant(e, 2)));
    let mut out: Vec<Option<[String; 3]>> = vec![
        tile(measure("peak_stress_ratio"), "peak *q*/*p*", where_peak.clone()),
        tile(measure("peak_von_mises_ratio"), "peak *q*_{vM}/*p*", where_peak),
    ];
    if !path::Traits::from_stages(&run.case.test_stages()).goes_to_and_fro() {
        let remark = || "mean over the last quarter of the strain".to_owned();
        out.push(tile(measure("late_stress_ratio"), "late *q*/*p*", remark()));
        out.push(tile(measure("late_von_mises_ratio"), "late *q*_{vM}/*p*", remark()));
    }
    let degrees = |name: &str| measure(name).map(|angle| format!("{angle:.1}°"));
    out.push(degrees("peak_friction_angle").map(|peak| {
        let late = degrees("critical_friction_angle").map_or(String::new(), |late| format!("late: {late}"));
        let is_secant = measures.contains_key(COHESIVE);
        let name = if is_secant {
            "peak friction angle, of a secant: the grains are cohesive"
        } else {
            "peak friction angle"
        };
        [peak, name.into(), late]
    }));
    out.push(strength::liquefaction(&measures));
    for (name, value) in run.run.measures.iter().filter(|(name, _)| name.starts_with("k0_")) {
        let stage = literal(&name.trim_start_matches("k0_").replace('_', " "));
        let remark = format!("at the end of the stage {stage}");
        out.push(tile(Some(*value), "*K*_{0} = *σ*_{3}/*σ*_{1}", remark));
    }
    out.push(tile(run.first("solid_fraction"), "solid fraction before the test", String::new()));
    let z = run
        .first("coordination_number")
        .map_or(String::new(), |z| format!("*Z* = {} over all grains", significant(z, 3)));
    let of_sample = run.first("mechanical_coordination_number");
    out.push(tile(of_sample, "mechanical coordination number before the test", z));
    let flags = &run.run.quality;
    let held = flags.iter().filter(|flag| flag.passed).count();
    out.push((!flags.is_empty()).then(|| {
        let held = format!("{held} of {}", flags.len());
        [held, "quality checks passed".into(), "servo, rate, overlap, energy".into()]
    }));
    out.into_iter().flatten().collect()
}

/// The section on stress, volume, contacts and fabric of one or several runs.
pub fn behaviour(page: &mut Page, runs: &[RunReport]) -> Markup {
    let Some(first) = runs.first() else { return html! {} };
    if !first.is_at_constant_p() {
        let path = path::behaviour(page, first);
        let (coordination, caption) = material::coordination(first);
        let coordination = page.own_figure("coordination", &caption, &coordination);
        let (fabric, caption) = material::principal_fabric(first);
        return html! { (path) (coordination) (page.own_figure("fabric", &caption, &fabric)) };
    }
    let (stress, stress_caption) = material::stress_and_volume(runs);
    let (shares, shares_caption) = material::stress_shares(first);
    let (coordination, coordination_caption) = material::coordination(first);
    let (fabric, fabric_caption) = material::fabric(runs);
    html! {
        (page.own_figure("stress", &stress_caption, &stress))
        (page.own_figure("stress-parts", &shares_caption, &shares))
        (page.own_figure("coordination", &coordination_caption, &coordination))
        (page.own_figure("fabric", &fabric_caption, &fabric))
    }
}

/// The section on P(f), roses and force chains of a run.
pub fn force_section(page: &mut Page, run: &RunReport) -> Markup {
    let (distribution, caption) = forces::distribution(run);
    let distribution = page.own_figure("forces", &caption, &distribution);
    let (roses, caption) = forces::roses(run);
    let roses = page.own_figure("roses", &caption, &roses);
    let slices = forces::slices(run.start.as_ref(), run.end.as_ref())
        .map(|(figure, caption)| page.own_figure("force-chains", &caption, &figure));
    let network = run.end.as_ref().map(|end| {
        let (figure, caption) = forces::strong_network(end);
        page.own_figure("strong-network", &caption, &figure)
    });
    let viewer = run.end.as_ref().and_then(folded);
    html! {
        (distribution) (roses)
        @if let Some(slices) = slices { (slices) }
        @if let Some(network) = network { (network) }
        @if let Some(viewer) = viewer { (viewer) }
    }
}
