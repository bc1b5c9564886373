//! The report of several runs: their curves over each other, and their results in a table.

use granum_core::Column;
use granum_core::words::listed;
use granum_io::case::SEED;
use granum_run::runs_table::{RunEntry, RunGroup, RunsTable, Selection, differing_keys, groups};
use granum_run::strength::{Curves, symmetry};
use maud::{Markup, html};

use super::case_details::case_details;
use super::data::RunReport;
use super::figure::palette::{COLORS, GREY, color};
use super::figure::{Axis, Figure, Layer, Legend, Panel, Plot, Stroke, literal};
use super::forces::density;
use super::numbers::{quantity, trimmed};
use super::page::{Document, Page, PageTable, rich};
use super::{lines_of_tests, path, strength, trust};

/// Patterns of lines after the colours have been used once.
const DASHES: [&[f64]; 4] = [&[], &[7.0, 3.0], &[2.0, 2.5], &[8.0, 3.0, 2.0, 3.0]];
/// Most groups of runs that a legend can tell apart.
const MOST_IN_LEGEND: usize = 24;

/// The stroke of group k: its colour, and once these have been used a pattern.
pub fn stroke(k: usize) -> Stroke {
    Stroke::new(color(k), 1.6).dashed(DASHES[k / COLORS.len() % DASHES.len()])
}

/// The entries of runs for a table of them.
pub fn entries(runs: &[RunReport]) -> Vec<RunEntry> {
    runs.iter().map(|run| RunEntry::new(&run.name, &run.name, run.case.clone(), run.run.clone())).collect()
}

/// Writes the report of several runs.
pub fn report(runs: &[RunReport]) -> Document {
    let mut page = Page::default();
    let entries = entries(runs);
    let drawn = Drawn { runs, groups: groups(&entries) };
    let figures = [drawn.stress_and_volume(), drawn.path_and_void_ratio(), drawn.contacts(), drawn.forces()];
    let figures: Vec<Markup> = (figures.iter().flatten())
        .map(|(file, figure, caption)| page.own_figure(file, caption, figure))
        .collect();
    page.section(
        "behaviour",
        "Stress, volume, contacts and forces",
        html! { @for figure in figures { (figure) } },
    );
    let table = RunsTable::from_runs(&entries).select(Selection::Main);
    let label = page.own_table_label();
    let mut of_all =
        html! { (results(&label, "The runs, the keys that differ, and their main results.", &table).html()) };
    let scatter =
        strength::scatter_table(&entries, &runs.iter().map(RunReport::measures).collect::<Vec<_>>());
    if scatter.columns().len() > 1 {
        let label = page.own_table_label();
        let caption = "Strength of the runs; of those that differ in their seeds alone the mean and the standard deviation.";
        of_all = html! { (of_all) (results(&label, caption, &scatter).html()) };
    }
    for lines in
        [lines_of_tests::critical_state_line(&mut page, runs), lines_of_tests::envelope(&mut page, runs)]
    {
        of_all = html! { (of_all) @if let Some(lines) = lines { (lines) } };
    }
    page.section("results", "Results", of_all);
    page.section("quality", "Can they be trusted?", trust::of_several(runs));
    if let Some(first) = runs.first() {
        let case = html! { p { "The case of " (rich(&literal(&first.name))) ":" } (case_details(first)) };
        page.section("case", "The case", case);
    }
    let head = html! {
        p { (rich(&differences(&entries))) }
        p { (rich(SIGNS)) }
        @if runs.iter().any(|run| !run.is_complete()) {
            p class="callout" { "Not every test reached its end; the states recorded until then are shown." }
        }
    };
    let subtitle = runs.iter().map(|run| literal(&run.name)).collect::<Vec<_>>();
    let subtitle =
        if subtitle.len() > 6 { format!("{}, ...", subtitle[..6].join(", ")) } else { subtitle.join(", ") };
    page.finish(&format!("{} runs", runs.len()), &subtitle, head)
}

/// The conventions for signs and axes.
const SIGNS: &str = "Compression is positive, for stress, strain and normal force. Axis 1 is *x*, the axial one. Strains are logarithmic.";

/// A sentence on the keys by which the runs differ.
fn differences(entries: &[RunEntry]) -> String {
    let keys: Vec<String> = differing_keys(entries).into_iter().map(|found| literal(&found.key)).collect();
    match (keys.is_empty(), keys == [SEED]) {
        (true, _) => "The cases of the runs are the same.".into(),
        (_, true) => "The runs differ in the seed of their samples alone.".into(),
        _ => format!("The cases of the runs differ in {}, and in nothing else.", listed(&keys)),
    }
}

/// The table of the main results.
fn results(label: &str, caption: &str, table: &granum_core::Table) -> PageTable {
    let head = |column: &Column| literal(&column.name.replace('_', " "));
    let heads: Vec<String> = table.columns().iter().map(head).collect();
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut out = PageTable::new(label, caption, &heads);
    for row in 0..table.rows() {
        out.row(table.columns().iter().map(|column| cell(column, row)).collect());
    }
    out
}

fn cell(column: &Column, row: usize) -> String {
    match column.numbers() {
        None => column.word(row).map_or_else(String::new, literal),
        Some(numbers) => match (numbers.get(row).copied(), column.unit.as_str()) {
            (Some(value), "Pa") => quantity(value, "Pa"),
            (Some(value), "deg") if value.is_finite() => format!("{}°", trimmed(value)),
            (Some(value), _) => trimmed(value),
            (None, _) => String::new(),
        },
    }
}

/// A column against the strain, with a gap where the strain begins to count anew.
fn against_strain(run: &RunReport, column: &str) -> Vec<[f64; 2]> {
    path::lines(run, &run.strain(), run.column(column))
}

/// A figure with the name of its file and its caption.
type Named = (&'static str, Figure, String);

/// The runs with the groups in which they are drawn.
struct Drawn<'a> {
    runs: &'a [RunReport],
    groups: Vec<RunGroup>,
}

impl Drawn<'_> {
    /// A plot with a line for each run.
    fn plot(&self, x: Axis, y: Axis, points: impl Fn(&RunReport) -> Vec<[f64; 2]>) -> Plot {
        let mut plot = Plot::new(x, y);
        for (k, group) in self.groups.iter().enumerate() {
            for run in &group.runs {
                let line = Layer::stroked(points(&self.runs[*run]), stroke(k));
                plot = plot.with(line.named(&literal(&group.label)));
            }
        }
        plot
    }

    fn figure(&self, description: &str, panels: Vec<Plot>, caption: &str) -> (Figure, String) {
        let columns = panels.len().min(2);
        let panels = panels.into_iter().map(Panel::plot).collect();
        let figure = Figure::new(description, columns, panels);
        if self.groups.len() > MOST_IN_LEGEND {
            let caption = format!("{caption} The lines are too many for a legend.");
            return (figure.legend(Legend::Hidden), caption);
        }
        (figure.legend(Legend::Above), caption.to_owned())
    }

    /// The strain that all runs have on their axis.
    fn strain_axis(&self) -> Axis {
        let mut labels = self.runs.iter().map(|run| run.strain_and_label().1);
        let first = labels.next().unwrap_or("Strain");
        let label = if labels.all(|label| label == first) { first } else { "Strain of the test" };
        Axis::new(label).including(0.0)
    }

    /// True if every test is axisymmetric about the axis x.
    fn are_axisymmetric(&self) -> bool {
        self.runs.iter().all(|run| symmetry::axis(&run.case.test_stages()) == Some(0))
    }

    /// The deviator stress of a run, with the mean stress.
    fn stresses(&self, run: &RunReport) -> Vec<[f64; 2]> {
        let stages = run.case.test_stages();
        let curves = Curves::new(&run.record, &stages);
        let q = if self.are_axisymmetric() { curves.axial_deviator() } else { curves.von_mises_stress() };
        q.into_iter().zip(curves.mean_stress()).map(|(q, p)| [q, *p]).collect()
    }

    fn q(&self) -> &'static str {
        if self.are_axisymmetric() { "*q*" } else { "*q*_{vM}" }
    }

    /// What q is, for captions.
    fn meaning_of_q(&self) -> &'static str {
        match self.are_axisymmetric() {
            true => "*q* is the axial minus the mean lateral stress",
            false => "*q*_{vM} = √(3 *J*_{2}) is the von Mises stress",
        }
    }

    fn stress_and_volume(&self) -> Option<Named> {
        let ratio = self.plot(
            self.strain_axis(),
            Axis::new(&format!("Stress ratio {}/*p*", self.q())).including(0.0),
            |run| {
                let stages = run.case.test_stages();
                let ratios = self.stresses(run).into_iter().map(|[q, p]| q / p);
                let ratios = path::where_stress(&Curves::new(&run.record, &stages), ratios);
                path::lines(run, &run.strain(), &ratios)
            },
        );
        let volume = self
            .plot(self.strain_axis(), Axis::new("Volumetric strain *ε*_{v}"), |run| {
                against_strain(run, "volumetric_strain")
            })
            .with(Layer::horizontal(0.0, GREY));
        let caption = format!(
            "(a) Stress ratio; {}; states that have lost 95 % of the mean stress are not drawn. (b) Volumetric strain, compression positive, \
             so that a falling curve is dilation.",
            self.meaning_of_q()
        );
        let (figure, caption) =
            self.figure("Stress ratio and volumetric strain of several runs", vec![ratio, volume], &caption);
        Some(("stress", figure, caption))
    }

    fn path_and_void_ratio(&self) -> Option<Named> {
        let pressure = || Axis::new("Mean stress *p*").unit("Pa");
        let q = Axis::new(&format!("Deviator stress {}", self.q())).unit("Pa").including(0.0);
        let path = self.plot(pressure().including(0.0), q, |run| {
            self.stresses(run).into_iter().map(|[q, p]| [p, q]).collect()
        });
        let void = self.plot(pressure().logarithmic(), Axis::new("Void ratio *e*"), |run| {
            run.column("mean_stress").iter().zip(path::void_ratio(run)).map(|(p, e)| [*p, e]).collect()
        });
        let caption =
            format!("(a) Stress paths; {}. (b) Void ratio against mean stress.", self.meaning_of_q());
        let (figure, caption) =
            self.figure("Stress paths and void ratios of several runs", vec![path, void], &caption);
        Some(("stress-path", figure, caption))
    }

    fn contacts(&self) -> Option<Named> {
        let coordination =
            self.plot(self.strain_axis(), Axis::new("Mechanical coordination number *Z*_{m}"), |run| {
                against_strain(run, "mechanical_coordination_number")
            });
        let fabric = self
            .plot(self.strain_axis(), Axis::new("Deviator fabric *φ*_{d}"), |run| {
                against_strain(run, "deviator_fabric")
            })
            .with(Layer::horizontal(0.0, GREY));
        let caption = "(a) Mechanical coordination number, over grains with two contacts or more. (b) Deviator of the fabric tensor, \
                       *φ*_{1} − *φ*_{3}.";
        let description = "Coordination number and fabric of several runs";
        let (figure, caption) = self.figure(description, vec![coordination, fabric], caption);
        Some(("contacts", figure, caption))
    }

    /// P(f) at the last state.
    fn forces(&self) -> Option<Named> {
        self.runs.iter().find(|run| !run.record.forces().is_empty())?;
        let plot = self.plot(
            Axis::new("Normal force *f* = *N*/⟨*N*⟩"),
            Axis::new("Probability density *P*(*f*)").logarithmic(),
            |run| run.record.forces().last().map(density).unwrap_or_default(),
        );
        let caption = "Distribution of the normal contact forces at the last state of each run.";
        let (figure, caption) = self.figure("Force distributions of several runs", vec![plot], caption);
        Some(("forces", figure, caption))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_never_taken_for_markup() {
        use crate::figure::Rich;
        for text in ["friction=0.2_lateral_stress=50kPa", "a*b*c", "x_{1}^{2}", "back\\slash <b>"] {
            assert_eq!(Rich::new(&literal(text)).plain(), text);
        }
        assert!(Rich::new(&literal("a <b>")).html().contains("&lt;b&gt;"));
    }

    #[test]
    fn lines_differ_in_colour_and_then_in_pattern() {
        let strokes: Vec<Stroke> = (0..24).map(stroke).collect();
        for (k, stroke) in strokes.iter().enumerate() {
            assert!(!strokes[..k].contains(stroke), "{k}");
        }
    }
}
