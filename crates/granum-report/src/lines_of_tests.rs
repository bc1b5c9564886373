//! What several tests of one material say together: the critical state line through those that are critical, and the envelope of the
//! strength of cohesive grains. Tests that do not take part are hollow in the figures, and are named with the reason.

use granum_run::strength::critical_state_line::{CriticalStateLine, REFERENCE_STRESS};
use granum_run::strength::envelope::StrengthEnvelope;
use granum_run::strength::{CriticalStates, Envelopes, Judged, Tested, left_out, taking_part};
use maud::{Markup, html};

use super::data::RunReport;
use super::figure::palette::{INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, SHAPES, Stroke, literal};
use super::numbers::quantity;
use super::page::{Page, PageTable, rich};
use super::strength::capital;

/// A number with its standard error.
fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value:.4} ± {error:.4}"),
        None => format!("{value:.4}"),
    }
}

/// A stress with its standard error.
fn stress_with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{} ± {}", quantity(value, "Pa"), quantity(error, "Pa")),
        None => quantity(value, "Pa"),
    }
}

fn tested(runs: &[RunReport]) -> Vec<Tested<'_>> {
    let tested = runs.iter().map(|run| Tested {
        name: &run.name,
        case: &run.case,
        about: &run.run,
        record: &run.record,
    });
    tested.collect()
}

/// A sentence for every test that does not take part.
pub fn reasons<S>(tests: &[Judged<S>]) -> Vec<String> {
    let reason = |test: &Judged<S>| Some(format!("{}: {}", test.name, test.left_out.as_ref()?));
    tests.iter().filter_map(reason).collect()
}

fn list_of_reasons<S>(tests: &[Judged<S>]) -> Markup {
    let reasons = reasons(tests);
    html! {
        @if !reasons.is_empty() {
            p { "Tests that do not take part:" }
            ul { @for reason in reasons { li { (rich(&literal(&reason))) } } }
        }
    }
}

/// The critical state line of several tests of one material as a table and a figure; `None` if fewer than two have a late state, or if
/// they are of different materials.
pub fn critical_state_line(page: &mut Page, runs: &[RunReport]) -> Option<Markup> {
    let states = CriticalStates::of_tests(&tested(runs));
    let with_state = states.tests.iter().filter(|test| test.state.is_some()).count();
    if with_state < 2 || !states.materials_differ_in.is_empty() {
        return None;
    }
    let caption = match &states.line {
        Some(line) => format!(
            "Void ratio against mean stress over the last quarter of the strain: critical states (filled), others (hollow), and the line \
             *e* = {:.3} − {:.4} ln(*p* / {}).",
            line.intercept,
            line.slope,
            quantity(REFERENCE_STRESS, "Pa")
        ),
        None => "Void ratio against mean stress over the last quarter of the strain: critical states (filled) and others (hollow). The \
                 critical states make no line."
            .into(),
    };
    let figure = Figure::new("Critical state line", 1, vec![Panel::plot(critical_state_plot(&states))]);
    let figure = page.own_figure("critical-state-line", &caption, &figure);
    let table = states.line.map(|line| line_table(page, &line));
    Some(html! { @if let Some(table) = table { (table) } (figure) (list_of_reasons(&states.tests)) })
}

fn line_table(page: &mut Page, line: &CriticalStateLine) -> Markup {
    let label = page.own_table_label();
    let caption =
        "Critical state line *e* = *Γ* − *λ* ln(*p* / 1 kPa) through the critical states of the tests.";
    let mut table = PageTable::new(&label, caption, &["Parameter", "Value", "Unit"]);
    table.row(vec![
        "*Γ*, void ratio at 1 kPa".into(),
        with_error(line.intercept, line.intercept_error),
        "1".into(),
    ]);
    table.row(vec!["*λ*, slope".into(), with_error(line.slope, line.slope_error), "1".into()]);
    let scatter = line.scatter.map_or("–".to_owned(), |scatter| format!("{scatter:.4}"));
    table.row(vec!["scatter of *e* about the line".into(), scatter, "1".into()]);
    table.row(vec!["tests".into(), line.tests.to_string(), "".into()]);
    let [low, high] = line.range.map(|p| quantity(p, "Pa"));
    table.note = format!(
        "Least squares over the void ratios, with standard errors of the regression (n − 2 degrees of freedom). The tests end at mean \
         stresses from {low} to {high}; beyond them the line is extrapolated. Only tests that passed their checks and whose ends are critical take \
         part."
    );
    table.html()
}

/// The late states, void ratio over the logarithm of p: filled where they are critical and hollow where not, and the line.
pub fn critical_state_plot(states: &CriticalStates) -> Plot {
    let points = |of: Vec<granum_run::strength::critical_state_line::LateState>| -> Vec<[f64; 2]> {
        of.iter().map(|state| [state.mean_stress, state.void_ratio]).collect()
    };
    let mut plot =
        Plot::new(Axis::new("Mean stress *p*").unit("Pa").logarithmic(), Axis::new("Void ratio *e*"));
    if let Some(line) = &states.line {
        let drawn: Vec<[f64; 2]> = line.range.map(|p| [p, line.void_ratio(p)]).to_vec();
        plot = plot.with(Layer::stroked(drawn, Stroke::new(color(0), 1.6)).named("critical state line"));
    }
    for (name, is_filled, points) in [
        ("critical states", true, points(taking_part(&states.tests))),
        ("not critical, or checks not passed", false, points(left_out(&states.tests))),
    ] {
        if !points.is_empty() {
            plot = plot.with(mark(points, is_filled).named(name));
        }
    }
    plot
}

fn mark(points: Vec<[f64; 2]>, is_filled: bool) -> Layer {
    if is_filled { Layer::dots(points, SHAPES[0], 3.0, INK) } else { Layer::points(points, SHAPES[0], INK) }
}

/// The envelope of the strength of cohesive grains as a table and a figure; `None` if no test is of cohesive grains.
pub fn envelope(page: &mut Page, runs: &[RunReport]) -> Option<Markup> {
    let envelopes = Envelopes::of_tests(&tested(runs))?;
    let caption = "Largest deviator stress of each test against the mean stress there: tests that take part (filled), others (hollow), and \
                   the envelope *q* = *M* *p* + *c* down to the isotropic tensile strength.";
    let table_and_figure = envelopes.envelope.map(|envelope| {
        let figure = Figure::new("Envelope of the strength", 1, vec![Panel::plot(envelope_plot(&envelopes))]);
        (envelope_table(page, &envelope), page.own_figure("strength-envelope", caption, &figure))
    });
    let remark = format!("{}.", capital(granum_run::strength::SECANT_REMARK));
    Some(html! {
        p { (rich(&literal(&remark))) }
        @if let Some((table, figure)) = table_and_figure { (table) (figure) }
        (list_of_reasons(&envelopes.tests))
    })
}

fn envelope_table(page: &mut Page, envelope: &StrengthEnvelope) -> Markup {
    let label = page.own_table_label();
    let caption = "Strength of the cohesive grains as an envelope *q* = *M* *p* + *c* of the largest deviator stresses.";
    let mut table = PageTable::new(&label, caption, &["Parameter", "Value"]);
    table.row(vec!["*M*, slope".into(), with_error(envelope.slope, envelope.slope_error)]);
    table.row(vec![
        "*c*, *q* at *p* = 0".into(),
        stress_with_error(envelope.intercept, envelope.intercept_error),
    ]);
    if let Some((angle, cohesion)) = envelope.friction_angle().zip(envelope.cohesion()) {
        table.row(vec!["friction angle".into(), format!("{angle:.1}°")]);
        table.row(vec!["cohesion".into(), quantity(cohesion, "Pa")]);
    }
    table.row(vec!["isotropic tensile strength *c*/*M*".into(), quantity(envelope.tensile_strength(), "Pa")]);
    if let Some(strength) = envelope.unconfined_strength() {
        table.row(vec!["unconfined strength 3*c*/(3 − *M*)".into(), quantity(strength, "Pa")]);
    }
    table.row(vec!["tests".into(), envelope.tests.to_string()]);
    let [low, high] = envelope.range.map(|p| quantity(p, "Pa"));
    table.note = format!(
        "Least squares over *q*, with standard errors of the regression (n − 2 degrees of freedom). The mean stresses at the peaks are from {low} \
         to {high}; tensile and unconfined strengths are extrapolated, and are upper bounds where the envelope is curved near the origin."
    );
    table.html()
}

fn envelope_plot(envelopes: &Envelopes) -> Plot {
    let points = |of: Vec<granum_run::strength::envelope::PeakState>| -> Vec<[f64; 2]> {
        of.iter().map(|state| [state.mean_stress, state.deviator_stress]).collect()
    };
    let mut plot = Plot::new(
        Axis::new("Mean stress *p*").unit("Pa").including(0.0),
        Axis::new("Deviator stress *q*").unit("Pa").including(0.0),
    );
    if let Some(envelope) = &envelopes.envelope {
        let ends = [-envelope.tensile_strength().max(0.0), envelope.range[1]];
        let drawn = ends.map(|p| [p, envelope.slope * p + envelope.intercept]).to_vec();
        plot = plot.with(Layer::stroked(drawn, Stroke::new(color(0), 1.6)).named("envelope"));
    }
    for (name, is_filled, points) in [
        ("tests", true, points(taking_part(&envelopes.tests))),
        ("tests that do not take part", false, points(left_out(&envelopes.tests))),
    ] {
        if !points.is_empty() {
            plot = plot.with(mark(points, is_filled).named(name));
        }
    }
    plot
}

#[cfg(test)]
mod tests {
    use granum_run::strength::critical_state_line::LateState;

    use super::*;

    #[test]
    fn states_that_are_not_critical_are_hollow() {
        let test = |k: usize, p: f64, reason: Option<&str>| Judged {
            name: format!("run-{k}"),
            state: Some(LateState { mean_stress: p, void_ratio: 0.9 - 0.02 * f64::ln(p / 1e3) }),
            left_out: reason.map(str::to_owned),
        };
        let tests =
            vec![test(1, 50e3, None), test(2, 100e3, None), test(3, 400e3, Some("it is not critical"))];
        let line = CriticalStateLine::through(&taking_part(&tests));
        let states = CriticalStates { tests, line, materials_differ_in: Vec::new() };
        let panel = Panel::plot(critical_state_plot(&states));
        let svg = Figure::new("Critical state line", 1, vec![panel]).to_svg();
        assert!(
            svg.contains("critical states") && svg.contains("not critical, or checks not passed"),
            "{svg}"
        );
        assert_eq!(reasons(&states.tests), ["run-3: it is not critical"]);
        let all = Judged { left_out: None, ..states.tests[2].clone() };
        let states = CriticalStates { tests: vec![all], ..states };
        let svg = Figure::new("x", 1, vec![Panel::plot(critical_state_plot(&states))]).to_svg();
        assert!(!svg.contains("checks not passed"));
    }
}
