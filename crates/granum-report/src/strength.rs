//! The strength of tests at a glance, with the scatter of several runs, and the critical state line through their late states.

use std::collections::BTreeMap;

use granum_core::Column;
use granum_run::runs_table::{RunEntry, RunGroup, groups};
use granum_run::strength::critical_state_line::{CriticalStateLine, LateState, REFERENCE_STRESS};
use granum_run::strength::one_material;
use granum_run::strength::{MEASURES, Meaning};
use maud::{Markup, html};

use super::data::RunReport;
use super::figure::palette::{INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, SHAPES, Stroke};
use super::numbers::{percent, quantity, significant};
use super::page::{Page, PageTable};

/// The measures of a run, by name.
pub type Measures = BTreeMap<String, f64>;

/// Mean and standard deviation (with n - 1) of the values of a measure; the deviation is missing for a single value, and the mean if
/// there is none.
pub fn scatter(values: &[f64]) -> Option<(f64, Option<f64>)> {
    let count = values.len() as f64;
    if values.is_empty() {
        return None;
    }
    let mean = values.iter().sum::<f64>() / count;
    let square: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    Some((mean, (values.len() > 1).then(|| (square / (count - 1.0)).sqrt())))
}

/// A value with its unit, marked up.
fn shown(meaning: &Meaning, value: f64) -> String {
    match (meaning.unit, meaning.name) {
        ("deg", _) => format!("{value:.1}°"),
        ("Pa", _) => quantity(value, "Pa"),
        (_, name) if name.contains("strain") && !name.contains("void") => percent(value),
        _ => significant(value, 3),
    }
}

/// The table of the measures of a test; `None` if there are none.
pub(crate) fn table(page: &mut Page, run: &RunReport) -> Option<Markup> {
    let measures = run.measures();
    let known = MEASURES.iter().filter_map(|known| Some((known, *measures.get(known.name)?)));
    let rows: Vec<Vec<String>> = known
        .map(|(known, value)| vec![capital(known.meaning), known.symbol.to_owned(), shown(known, value)])
        .collect();
    if rows.is_empty() {
        return None;
    }
    let label = page.own_table_label();
    let mut table = PageTable {
        rows,
        ..PageTable::new(&label, "Strength at a glance.", &["Measure", "Symbol", "Value"])
    };
    table.note = "States that carry less than 5 % of the mean stress at the start of the test do not count for peaks. Late values are \
                  those of the critical state only as far as their drift is small."
        .into();
    Some(table.html())
}

/// The measures of several runs, a row for each, and below them the mean and the standard deviation (with n - 1) of every group of runs
/// that differ in the seeds of their samples alone.
pub fn scatter_table(entries: &[RunEntry], measures: &[Measures]) -> granum_core::Table {
    let groups: Vec<RunGroup> = groups(entries).into_iter().filter(|group| group.runs.len() > 1).collect();
    let mut names: Vec<String> = entries.iter().map(|entry| entry.name.clone()).collect();
    for group in &groups {
        let label = if group.label.is_empty() { "all runs" } else { &group.label };
        let count = group.runs.len();
        names.extend([format!("mean of {count}: {label}"), format!("standard deviation: {label}")]);
    }
    let mut columns = vec![Column::of_words("name", names)];
    for known in MEASURES.iter().filter(|known| measures.iter().any(|of| of.contains_key(known.name))) {
        let of = |run: usize| measures.get(run).and_then(|of| of.get(known.name)).copied();
        let mut values: Vec<f64> = (0..entries.len()).map(|run| of(run).unwrap_or(f64::NAN)).collect();
        for group in &groups {
            let found: Vec<f64> = group.runs.iter().filter_map(|run| of(*run)).collect();
            let (mean, deviation) = scatter(&found).unwrap_or((f64::NAN, None));
            values.extend([mean, deviation.unwrap_or(f64::NAN)]);
        }
        let unit = if known.unit == "1" { "" } else { known.unit };
        columns.push(Column::new(known.name, unit, values));
    }
    // This cannot fail: the names of measures differ, and every column has a value for each run and two for each group.
    granum_core::Table::new(columns).unwrap_or_default()
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// A tile that says whether and when a sample liquefied; `None` for a drained test.
pub(crate) fn liquefaction(measures: &Measures) -> Option<[String; 3]> {
    let value = |name: &str| measures.get(name).copied();
    let largest = value("largest_pore_pressure_ratio")
        .map(|ratio| format!("*r*_{{u}} up to {}", significant(ratio, 2)));
    let what = if value("liquefied")? == 0.0 {
        return Some(["no".into(), "liquefaction".into(), largest.unwrap_or_default()]);
    } else if let Some(cycles) = value("cycles_to_liquefaction") {
        [significant(cycles, 3), "cycles to liquefaction".into()]
    } else {
        let strain = value("axial_strain_at_liquefaction").or(value("deviatoric_strain_at_liquefaction"));
        [strain.map_or("yes".into(), percent), "strain at liquefaction".into()]
    };
    let [number, name] = what;
    Some([number, name, largest.unwrap_or_default()])
}

/// The late state of a test; `None` if it has none, as where its sample has liquefied.
pub fn late_state(measures: &Measures) -> Option<LateState> {
    Some(LateState {
        mean_stress: *measures.get("critical_mean_stress")?,
        void_ratio: *measures.get("critical_void_ratio")?,
    })
}

/// A number with its standard error.
fn with_error(value: f64, error: Option<f64>) -> String {
    match error {
        Some(error) => format!("{value:.4} ± {error:.4}"),
        None => format!("{value:.4}"),
    }
}

/// The critical state line of several tests of one material as a table and a figure; `None` if their late states make no line.
pub fn critical_state_line(page: &mut Page, runs: &[RunReport]) -> Option<Markup> {
    let states: Vec<LateState> = runs.iter().filter_map(|run| late_state(&run.measures())).collect();
    let cases: Vec<_> = runs.iter().map(|run| &run.case).collect();
    let line = CriticalStateLine::through(&states).filter(|_| one_material::differing(&cases).is_empty())?;
    let (figure, caption) = line_figure(&line, &states);
    let figure = page.own_figure("critical-state-line", &caption, &figure);
    let label = page.own_table_label();
    let caption = "Critical state line *e* = *Γ* − *λ* ln(*p* / 1 kPa) through the late states of the tests.";
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
         stresses from {low} to {high}; beyond them the line is extrapolated."
    );
    Some(html! { (table.html()) (figure) })
}

/// The late states, void ratio over the logarithm of p, and the line.
fn line_figure(line: &CriticalStateLine, states: &[LateState]) -> (Figure, String) {
    let [low, high] = line.range;
    let drawn: Vec<[f64; 2]> = [low, high].map(|p| [p, line.void_ratio(p)]).to_vec();
    let points = states.iter().map(|state| [state.mean_stress, state.void_ratio]).collect();
    let plot = Plot::new(Axis::new("Mean stress *p*").unit("Pa").logarithmic(), Axis::new("Void ratio *e*"))
        .with(Layer::stroked(drawn, Stroke::new(color(0), 1.6)).named("critical state line"))
        .with(Layer::points(points, SHAPES[0], INK).named("late states"));
    let caption = format!(
        "Void ratio against mean stress over the last quarter of the strain, and the line *e* = {:.3} − {:.4} ln(*p* / {}).",
        line.intercept,
        line.slope,
        quantity(REFERENCE_STRESS, "Pa")
    );
    (Figure::new("Critical state line", 1, vec![Panel::plot(plot)]), caption)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scatter_is_the_sample_standard_deviation() {
        assert_eq!(scatter(&[]), None);
        assert_eq!(scatter(&[2.0]), Some((2.0, None)));
        let (mean, deviation) = scatter(&[1.0, 2.0, 3.0]).unwrap();
        assert_eq!((mean, deviation), (2.0, Some(1.0)));
    }

    #[test]
    fn runs_that_differ_in_their_seeds_have_a_scatter() {
        let entry = |seed: u64, friction: f64| {
            let mut case = granum_io::Case::default();
            case.preparation.seed = seed;
            case.set("grains.material.friction", &friction.to_string()).unwrap();
            RunEntry::new(format!("run-{seed}-{friction}"), "x", case, Default::default())
        };
        let entries = [entry(1, 0.3), entry(2, 0.3), entry(1, 0.5)];
        let angle = |value: f64| Measures::from([("peak_friction_angle".to_owned(), value)]);
        let table = scatter_table(&entries, &[angle(30.0), angle(32.0), Measures::new()]);
        assert_eq!(table.rows(), 5);
        let values = table.columns()[1].numbers().unwrap();
        assert!(
            values[2].is_nan() && values[3] == 31.0 && (values[4] - 2f64.sqrt()).abs() < 1e-12,
            "{values:?}"
        );
        assert_eq!(
            (table.columns()[1].name.as_str(), table.columns()[1].unit.as_str()),
            ("peak_friction_angle", "deg")
        );
    }

    #[test]
    fn a_line_is_drawn_with_its_states() {
        let states = [50e3, 100e3, 400e3]
            .map(|p| LateState { mean_stress: p, void_ratio: 0.9 - 0.02 * f64::ln(p / 1e3) });
        let line = CriticalStateLine::through(&states).unwrap();
        let (figure, caption) = line_figure(&line, &states);
        assert!(figure.to_svg().contains("late states") && caption.contains("0.900 − 0.0200"), "{caption}");
    }
}
