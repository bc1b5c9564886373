//! The report of a campaign: the curves of all runs, coloured by a variable, their strength against each variable, the checks that were
//! not passed, and the time that the runs took. It stays small: of each curve only as many points are drawn as the number of runs allows.

mod runs;
mod scale;

use std::collections::BTreeMap;

use maud::{Markup, html};

use super::figure::marks::Shape;
use super::figure::palette::{GREY, color};
use super::figure::{Axis, Figure, Layer, Legend, Panel, Plot, Stroke, literal};
use super::numbers::{duration, quantity, trimmed};
use super::page::{Document, Page, PageTable, rich, tiles};
use super::symbols;

pub use self::runs::{CampaignEntry, CampaignRuns, ReportVariable, VariableValue};
use self::scale::Scale;

/// Most rows of a table.
const MOST_ROWS: usize = 40;
/// The measures that are drawn against the variables: the first of these pairs that most runs have.
const STRENGTH: [[&str; 2]; 4] = [
    ["peak_friction_angle", "critical_friction_angle"],
    ["peak_stress_ratio", "late_stress_ratio"],
    ["peak_von_mises_ratio", "late_von_mises_ratio"],
    ["peak_deviator_stress", "late_deviator_stress"],
];
/// Further measures, one panel each, if most runs have them.
const FURTHER: [&str; 5] = [
    "critical_void_ratio",
    "largest_dilatancy_angle",
    "solid_fraction",
    "flow_function_coefficient",
    "unconfined_yield_strength",
];

/// Writes the report of a campaign.
pub fn report(campaign: &CampaignRuns) -> Document {
    let drawn = Drawn { campaign, scale: Scale::from_runs(campaign) };
    let mut page = Page::default();
    let tiles = drawn.tiles();
    let curves = drawn.curves();
    let figure = page.own_figure("curves", &curves.1, &curves.0);
    page.section("curves", "Curves of all runs", html! { (figure) });
    let figures: Vec<Markup> = (drawn.against_variables().into_iter())
        .map(|(file, figure, caption)| page.own_figure(&file, &caption, &figure))
        .collect();
    let measures = drawn.measures(&mut page);
    if !figures.is_empty() {
        page.section(
            "variables",
            "Strength and state against the variables",
            html! {
                @for figure in figures { (figure) }
                @if let Some(table) = &measures { (table.html()) }
            },
        );
    }
    let label = page.own_table_label();
    let checks = drawn.checks(&label);
    let failures = (!campaign.failed.is_empty()).then(|| {
        let label = page.own_table_label();
        drawn.failures(&label)
    });
    page.section(
        "checks",
        "Checks and failures",
        html! {
            @match checks { Some(table) => (table.html()), None => p { "All finished runs passed all of their checks." } }
            @if let Some(table) = failures { (table.html()) }
        },
    );
    if !drawn.plotted().is_empty() {
        let (figure, caption) = drawn.times();
        let figure = page.own_figure("times", &caption, &figure);
        page.section("times", "The time that the runs took", html! { (figure) });
    }
    let head = html! {
        (tiles)
        p { (rich(SIGNS)) }
    };
    page.finish(&format!("Campaign of {} runs", drawn.all()), &literal(&campaign.name), head)
}

/// The conventions for signs.
const SIGNS: &str = "Compression is positive, for stress, strain and normal force. Strains are logarithmic.";

struct Drawn<'a> {
    campaign: &'a CampaignRuns,
    scale: Scale,
}

impl Drawn<'_> {
    fn all(&self) -> usize {
        self.campaign.runs.len() + self.campaign.failed.len() + self.campaign.unfinished
    }

    fn variable(&self) -> Option<&ReportVariable> {
        self.campaign.variables.get(self.campaign.coloured_by)
    }

    fn color(&self, run: &CampaignEntry) -> String {
        self.scale.color(run.values.get(self.campaign.coloured_by))
    }

    /// A layer without points for each step of the legend.
    fn legend(&self) -> Vec<Layer> {
        let unit = self.variable().map_or("", |variable| variable.unit.as_str());
        let name =
            self.variable().map_or(String::new(), |variable| literal(&variable.name.replace('_', " ")));
        let layer = |(k, value): (usize, VariableValue)| {
            let text = match &value {
                VariableValue::Number(number) => quantity(*number, unit),
                VariableValue::Word(word) => literal(word),
            };
            let text = if k == 0 { format!("{name} {text}") } else { text };
            Layer::stroked(Vec::new(), Stroke::new(&self.scale.color(Some(&value)), 2.4)).named(&text)
        };
        self.scale.steps().into_iter().enumerate().map(layer).collect()
    }

    fn tiles(&self) -> Markup {
        let runs = &self.campaign.runs;
        let flagged = runs.iter().filter(|run| !run.flags.is_empty()).count();
        let accepted = runs.iter().filter(|run| !run.flags.is_empty() && run.accepted).count();
        let seconds = runs.iter().map(|run| run.seconds).sum::<f64>();
        let tile = |value: String, name: &str, remark: String| [value, name.to_string(), remark];
        tiles(&[
            tile(
                format!("{} of {}", runs.len(), self.all()),
                "runs finished",
                format!("{} to do", self.campaign.unfinished),
            ),
            tile(
                flagged.to_string(),
                "did not pass a check",
                format!("{accepted} of them accepted by the plan"),
            ),
            tile(self.campaign.failed.len().to_string(), "failed", String::new()),
            tile(duration(seconds), "time of work", "of all finished runs, on one thread each".into()),
        ])
    }

    fn curves(&self) -> (Figure, String) {
        let first = self.campaign.runs.first().map_or(symbols::STRAIN, |run| run.strain);
        let same = self.campaign.runs.iter().all(|run| run.strain == first);
        let strain = || Axis::new(if same { first } else { "Strain of the test" }).including(0.0);
        let void = || Axis::new("Void ratio *e*");
        let axes = [
            (strain(), Axis::new("Stress ratio").including(0.0)),
            (strain(), void()),
            (Axis::new("Mean stress *p*").unit("Pa").logarithmic(), void()),
        ];
        // The more lines there are, the thinner they are.
        let width = (14.0 / (self.campaign.runs.len().max(1) as f64).sqrt()).clamp(0.35, 1.4);
        let plot = |(k, (x, y)): (usize, (Axis, Axis))| {
            let line = |run: &CampaignEntry| {
                Layer::stroked(run.curves[k].clone(), Stroke::new(&self.color(run), width))
            };
            Plot::new(x, y).with_all(self.campaign.runs.iter().map(line)).with_all(self.legend())
        };
        let panels = axes.into_iter().enumerate().map(plot).map(Panel::plot).collect();
        let name =
            self.variable().map_or(String::new(), |variable| literal(&variable.name.replace('_', " ")));
        let caption = format!(
            "The {} finished runs, coloured by {name}. (a) Ratio of the deviator stress to the mean stress, *q*/*p* of triaxial tests and \
             *q*_{{vM}}/*p* of others. (b), (c) Void ratio against the strain and the mean stress.",
            self.campaign.runs.len()
        );
        (Figure::new("Curves of all runs", 3, panels).legend(Legend::Above), caption)
    }

    /// Radius of a mark: so large that its colour is seen, unless there are so many that they would hide each other.
    fn mark(&self) -> f64 {
        (40.0 / (self.campaign.runs.len().max(1) as f64).sqrt()).clamp(2.2, 4.5)
    }

    /// The variables against which something can be plotted: a seed is the number of a sample and no quantity.
    fn plotted(&self) -> Vec<usize> {
        let variables = self.campaign.variables.iter().enumerate();
        variables.filter(|(_, variable)| !variable.is_seed).map(|(k, _)| k).collect()
    }

    /// True if at least half of the runs have a measure.
    fn is_usual(&self, name: &str) -> bool {
        let count = self.campaign.runs.iter().filter(|run| run.measure(name).is_some()).count();
        count > 0 && 2 * count >= self.campaign.runs.len()
    }

    /// A figure for each measure, with a panel for each variable.
    fn against_variables(&self) -> Vec<(String, Figure, String)> {
        let pair = STRENGTH.into_iter().find(|[peak, _]| self.is_usual(peak));
        let mut groups: Vec<Vec<&str>> = Vec::new();
        groups.extend(pair.map(|pair| pair.into_iter().filter(|name| self.is_usual(name)).collect()));
        groups.extend(FURTHER.into_iter().filter(|name| self.is_usual(name)).map(|name| vec![name]));
        if self.plotted().is_empty() {
            return Vec::new();
        }
        groups.into_iter().map(|names| self.against(&names)).collect()
    }

    fn against(&self, names: &[&str]) -> (String, Figure, String) {
        let panels: Vec<Panel> =
            self.plotted().into_iter().map(|k| Panel::plot(self.panel(k, names))).collect();
        let words: Vec<String> = names.iter().map(|name| name.replace('_', " ")).collect();
        let marks = match &words[..] {
            [peak, late] => format!("{peak} (circles) and {late} (squares)"),
            _ => words.join(", "),
        };
        let by = self.variable().map_or(String::new(), |variable| literal(&variable.name.replace('_', " ")));
        let caption = format!(
            "The {marks} of each run against the variables, coloured by {by}. Grey marks are runs that are not part of the data set."
        );
        let columns = panels.len().clamp(1, 3);
        let figure =
            Figure::new(&format!("{marks} against the variables"), columns, panels).legend(Legend::Hidden);
        (names.first().map_or("measure", |name| name).replace('_', "-"), figure, caption)
    }

    fn panel(&self, k: usize, names: &[&str]) -> Plot {
        let (axis, place) = self.axis(k);
        let label = names.first().map_or(String::new(), |name| name.replace('_', " "));
        let label = if names.len() > 1 { label.replace("peak ", "") } else { label };
        let label = with_unit(&capital(&label), names.first().unwrap_or(&""));
        let mut plot = Plot::new(axis, Axis::new(&label));
        for (name, shape) in names.iter().zip([Shape::Circle, Shape::Square]) {
            for run in &self.campaign.runs {
                let (Some(x), Some(y)) = (run.values.get(k).and_then(&place), run.measure(name)) else {
                    continue;
                };
                let color = if run.accepted { self.color(run) } else { GREY.to_string() };
                plot = plot.with(Layer::dots(vec![[x, y]], shape, self.mark(), &color));
            }
        }
        plot
    }

    /// The axis of a variable, and the place of its values on it.
    fn axis(&self, k: usize) -> (Axis, impl Fn(&VariableValue) -> Option<f64> + use<>) {
        let variable = &self.campaign.variables[k];
        let mut words: Vec<String> = (self.campaign.runs.iter())
            .filter_map(|run| match run.values.get(k) {
                Some(VariableValue::Word(word)) => Some(word.clone()),
                _ => None,
            })
            .collect();
        words.sort();
        words.dedup();
        let mut axis = Axis::new(&literal(&variable.name.replace('_', " "))).unit(&variable.unit);
        if variable.logarithmic && words.is_empty() {
            axis = axis.logarithmic();
        }
        if !words.is_empty() {
            axis = axis.named(&words);
        }
        let place = move |value: &VariableValue| match value {
            VariableValue::Number(number) if words.is_empty() => Some(*number),
            VariableValue::Number(_) => None,
            VariableValue::Word(word) => words.iter().position(|known| known == word).map(|k| k as f64),
        };
        (axis, place)
    }

    /// The measures that are drawn, run by run, if there are not too many runs for a table.
    fn measures(&self, page: &mut Page) -> Option<PageTable> {
        let pair = STRENGTH.into_iter().find(|[peak, _]| self.is_usual(peak));
        let names: Vec<&str> =
            pair.into_iter().flatten().chain(FURTHER).filter(|name| self.is_usual(name)).collect();
        if names.is_empty() || self.campaign.runs.len() > MOST_ROWS {
            return None;
        }
        let label = page.own_table_label();
        let variables =
            self.campaign.variables.iter().map(|variable| literal(&variable.name.replace('_', " ")));
        let columns: Vec<String> = variables
            .chain(names.iter().map(|name| with_unit(&capital(&name.replace('_', " ")), name)))
            .collect();
        let columns: Vec<&str> = columns.iter().map(String::as_str).collect();
        let mut table = PageTable::new(&label, "Strength and state, run by run.", &columns);
        table.words = self.campaign.variables.len();
        for run in &self.campaign.runs {
            let values =
                run.values.iter().zip(&self.campaign.variables).map(|(value, variable)| match value {
                    VariableValue::Number(number) => quantity(*number, &variable.unit),
                    VariableValue::Word(word) => literal(word),
                });
            let measure = |name: &&str| run.measure(name).map_or_else(|| "–".to_string(), trimmed);
            table.row(values.chain(names.iter().map(measure)).collect());
        }
        Some(table)
    }

    /// How many runs did not pass each check.
    fn checks(&self, label: &str) -> Option<PageTable> {
        let mut found: BTreeMap<&str, (usize, usize, f64)> = BTreeMap::new();
        for run in &self.campaign.runs {
            for (name, value) in &run.flags {
                let entry = found.entry(name).or_insert((0, 0, f64::NEG_INFINITY));
                *entry = (entry.0 + 1, entry.1 + usize::from(run.accepted), entry.2.max(*value));
            }
        }
        if found.is_empty() {
            return None;
        }
        let columns = ["check", "runs that did not pass it", "of them accepted", "largest value"];
        let mut table = PageTable::new(label, "Checks that runs did not pass.", &columns);
        for (name, (count, accepted, worst)) in found {
            table.row(vec![
                capital(&literal(&name.replace('_', " "))),
                count.to_string(),
                accepted.to_string(),
                trimmed(worst),
            ]);
        }
        Some(table)
    }

    fn failures(&self, label: &str) -> PageTable {
        let mut table = PageTable::new(label, "Runs that failed.", &["run", "values", "reason"]);
        table.words = 3;
        for [name, values, reason] in self.campaign.failed.iter().take(MOST_ROWS) {
            table.row(vec![literal(name), literal(values), literal(reason)]);
        }
        if self.campaign.failed.len() > MOST_ROWS {
            table.note = format!("And {} more.", self.campaign.failed.len() - MOST_ROWS);
        }
        table
    }

    fn times(&self) -> (Figure, String) {
        let panel = |k: usize| {
            let (axis, place) = self.axis(k);
            let points = self.campaign.runs.iter();
            let points =
                points.filter_map(|run| Some([run.values.get(k).and_then(&place)?, run.seconds])).collect();
            let y = Axis::new("Seconds of work").including(0.0);
            Panel::plot(Plot::new(axis, y).with(Layer::dots(points, Shape::Circle, 2.2, color(0))))
        };
        let panels: Vec<Panel> = self.plotted().into_iter().map(panel).collect();
        let columns = panels.len().clamp(1, 3);
        let longest = self.campaign.runs.iter().map(|run| run.seconds).fold(0.0, f64::max);
        let caption = format!(
            "Wall time of each run on one thread against the variables; the longest took {} s.",
            trimmed(longest)
        );
        (Figure::new("Wall time of the runs", columns, panels), caption)
    }
}

/// The label of a measure with its unit.
fn with_unit(label: &str, name: &str) -> String {
    match name {
        _ if name.ends_with("_angle") => format!("{label}, °"),
        _ if name.ends_with("_strength") || name.ends_with("deviator_stress") => format!("{label}, Pa"),
        _ => label.to_string(),
    }
}

/// A text with a capital at its beginning.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

#[cfg(test)]
mod tests {
    use super::runs::{MOST_POINTS, POINTS_OF_CURVE, thinned};
    use super::*;

    fn campaign(runs: usize) -> CampaignRuns {
        let entry = |k: usize| {
            let friction = 0.1 + 0.5 * k as f64 / runs as f64;
            let points = (0..200)
                .map(|point| [point as f64 * 1e-3, friction * (point as f64).sqrt()])
                .collect::<Vec<_>>();
            let curve = thinned(points, (MOST_POINTS / runs).clamp(POINTS_OF_CURVE[0], POINTS_OF_CURVE[1]));
            CampaignEntry {
                name: format!("run-{k}"),
                values: vec![
                    VariableValue::Number(friction),
                    VariableValue::Word(["loose", "dense"][k % 2].into()),
                ],
                curves: [curve.clone(), curve.clone(), curve],
                strain: symbols::STRAIN,
                measures: [
                    ("peak_friction_angle".to_string(), 20.0 + friction),
                    ("critical_friction_angle".into(), 18.0),
                ]
                .into(),
                flags: if k.is_multiple_of(10) { vec![("largest_overlap".into(), 0.03)] } else { Vec::new() },
                accepted: !k.is_multiple_of(20),
                seconds: 5.0,
            }
        };
        let variable = |name: &str| ReportVariable {
            name: name.into(),
            unit: String::new(),
            logarithmic: false,
            is_seed: name == "seed",
        };
        CampaignRuns {
            name: "study".into(),
            variables: vec![variable("friction"), variable("density")],
            runs: (0..runs).map(entry).collect(),
            failed: vec![["x".into(), "friction = 3".into(), "no <room>".into()]],
            unfinished: 2,
            coloured_by: 0,
        }
    }

    #[test]
    fn a_report_tells_runs_checks_and_failures() {
        let document = report(&campaign(40));
        for wanted in ["40 of 43", "Largest overlap", "no &lt;room&gt;", "coloured by friction", "dense"] {
            assert!(document.html.contains(wanted), "{wanted}");
        }
        assert_eq!(document.figures.len(), 3);
        // Coloured by words, each word has its colour.
        let by_words = report(&CampaignRuns { coloured_by: 1, ..campaign(40) });
        assert!(by_words.html.contains(color(0)) && by_words.html.contains(color(1)));
    }

    #[test]
    fn two_thousand_runs_make_a_page_that_opens() {
        let document = report(&campaign(2000));
        assert!(document.html.len() < 6_000_000, "{}", document.html.len());
    }
}
