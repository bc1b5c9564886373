//! The report of a study of surrogates of any columns.

use granum_core::Table as Columns;
use granum_core::words::listed;
use granum_learn::networks::NetworkScores;
use granum_learn::study::{FitScores, MemberRole, MemberScores, PartScore, StoredStudy, StudyFit};
use granum_learn::worth::Worth;
use maud::{Markup, html};

use super::figure::palette::{INK, color};
use super::figure::{Axis, Figure, Layer, Panel, Plot, SHAPES, Stroke, literal};
use super::learning_curve;
use super::numbers::{percent, points, significant, whole};
use super::page::{Document, Page, PageTable, paragraphs, tiles};
use super::worth;

/// Most panels of a figure.
const MOST_PANELS: usize = 4;
/// Most runs in a panel.
const MOST_RUNS: usize = 4;

/// Writes the report of a study from what its folder contains; `name` is that of the folder, and what each soft sensor is worth is the first
/// section if it is known.
pub fn report(stored: &StoredStudy, name: &str, worth: Option<&Worth>) -> Document {
    let mut page = Page::default();
    if let Some(worth) = worth {
        let body = worth::section(&mut page, worth);
        page.section("worth", "What each soft sensor is worth", body);
    }
    let pairs: Vec<(&StudyFit, &FitScores)> = stored.study.fits.iter().zip(&stored.scores.fits).collect();
    let body = scores_section(&mut page, &pairs);
    page.section("scores", "Scores", body);
    let body = uses_section(&mut page, &pairs);
    page.section("inputs", "Use of the inputs", body);
    if let Some(curve) = &stored.study.learning_curve {
        let body = learning_curve::section(&mut page, curve);
        page.section("learning-curve", "Number of training runs", body);
    }
    let body = figures_section(&mut page, stored);
    page.section("predictions", "Predictions for unseen runs", body);
    let body = repeat_section(&mut page, stored);
    page.section("reproducibility", "What the study consists of", body);
    let outputs = literals(pairs.iter().flat_map(|(fit, _)| &fit.spec.outputs));
    let head = html! { (tiles(&pairs.iter().map(|(_, scores)| tile(scores)).collect::<Vec<_>>())) };
    let subtitle =
        format!("Surrogates of {}, scored on {} unseen runs.", listed(&outputs), stored.unseen.len());
    page.finish(&format!("Study {}", literal(name)), &subtitle, head)
}

/// Names of columns, methods or runs, to be shown letter by letter.
fn literals<'a>(names: impl IntoIterator<Item = &'a String>) -> Vec<String> {
    names.into_iter().map(|name| literal(name)).collect()
}

/// The name of a fit in words.
fn in_words(name: &str) -> String {
    literal(&name.replace('_', " "))
}

fn error(part: &PartScore) -> f64 {
    if part.score.states > 0 { part.score.relative_rmse } else { f64::NAN }
}

/// The smallest error of a method that was asked for.
fn tile(scores: &FitScores) -> [String; 3] {
    let asked = scores.members.iter().filter(|member| member.role == MemberRole::Asked);
    let best = asked.min_by(|a, b| error(&a.unseen).total_cmp(&error(&b.unseen)));
    let value = best.map_or(f64::NAN, |member| error(&member.unseen));
    [
        percent(value),
        literal(&scores.name),
        format!("relative RMSE of {}", best.map_or(String::new(), |member| literal(&member.method))),
    ]
}

fn role(member: &MemberScores) -> &'static str {
    match member.role {
        MemberRole::Asked => "asked for",
        MemberRole::CoordinateOnly => "coordinate only",
        MemberRole::Baseline => "baseline",
    }
}

fn scores_section(page: &mut Page, pairs: &[(&StudyFit, &FitScores)]) -> Markup {
    let mut tables = Vec::new();
    for (fit, scores) in pairs {
        let caption =
            format!("Relative RMSE of {} from {}.", literal(&fit.name), listed(&literals(&fit.spec.inputs)));
        let columns = ["Surrogate", "", "Training", "Held out", "Unseen", "R²", "In interval", "Outside"];
        let mut table = PageTable { words: 2, ..PageTable::new(&page.own_table_label(), &caption, &columns) };
        for member in &scores.members {
            table.row(vec![
                literal(&member.method),
                role(member).into(),
                percent(error(&member.training)),
                percent(error(&member.held_out)),
                percent(error(&member.unseen)),
                significant(member.unseen.score.r2, 4),
                member.unseen.coverage.map_or("–".into(), percent),
                whole(member.unseen.outside as f64),
            ]);
        }
        table.note = "In interval: share of the values of unseen runs that lie within their intervals. Outside: states of \
                      unseen runs with an input outside the trained range."
            .into();
        tables.push(table.html());
        if fit.members.first().is_some_and(|member| member.surrogate.columns().outputs.len() > 1) {
            tables.push(outputs_table(page, scores).html());
        }
        if let Some(table) = networks_table(page, fit, scores) {
            tables.push(table.html());
        }
        tables.push(paragraphs(&scatter_sentence(scores).into_iter().collect::<Vec<_>>()));
        tables.push(paragraphs(&literals(&fit.remarks)));
    }
    html! {
        (paragraphs(&[
            "The relative RMSE is the root mean square error over the root mean square of the measured values. A surrogate is \
             worth something if its error on unseen runs is below that of the mean curve of the training runs, and its inputs \
             are if the error is below that of the same method with the coordinate only."
        ]))
        @for table in &tables { (table) }
    }
}

/// The networks of sub-models, if there are several.
fn networks_table(page: &mut Page, fit: &StudyFit, scores: &FitScores) -> Option<PageTable> {
    let members = scores.members.iter().filter(|member| member.networks.len() > 1);
    let rows: Vec<(&MemberScores, usize, &NetworkScores)> = members
        .flat_map(|member| member.networks.iter().enumerate().map(move |(k, network)| (member, k, network)))
        .collect();
    rows.first()?;
    let coordinate = literal(fit.spec.coordinate.as_deref().unwrap_or(""));
    let caption = format!("Networks of {}, each for a range of {coordinate}.", literal(&scores.name));
    let columns = ["Surrogate", "Range", "Hidden layers", "Rows", "Epochs", "Held out", "Unseen"];
    let mut table = PageTable { words: 1, ..PageTable::new(&page.own_table_label(), &caption, &columns) };
    let error = |score: &granum_learn::Score| {
        if score.states > 0 { percent(score.relative_rmse) } else { "–".into() }
    };
    for (member, _, network) in &rows {
        let mark = if network.constant { " (constant)" } else { "" };
        let layers: Vec<String> = network.hidden.iter().map(|n| whole(*n as f64)).collect();
        table.row(vec![
            literal(&member.name) + mark,
            format!("{} to {}", significant(network.range[0], 4), significant(network.range[1], 4)),
            layers.join(", "),
            whole(network.rows as f64),
            whole(network.epochs as f64),
            error(&network.held_out),
            error(&network.unseen),
        ]);
    }
    table.note =
        "Held out, unseen: relative RMSE in the range. A constant network has learned nothing.".into();
    Some(table)
}

/// The scatter between runs that differ only in their seed.
fn scatter_sentence(scores: &FitScores) -> Option<String> {
    let scatter = scores.seed_scatter?;
    let groups = if scatter.groups == 1 { String::new() } else { format!(" in {} groups", scatter.groups) };
    let best = scatter.best_without_inputs.map_or(String::new(), |best| {
        format!(
            " If nothing but the mean of the training runs with the same parameters is known, an error of {} must be expected on \
             an unseen run.",
            percent(best)
        )
    });
    Some(format!(
        "The {} runs{groups} that differ only in their seed scatter by {} in the same measure.{best}",
        scatter.runs,
        percent(scatter.relative)
    ))
}

/// The error of each output of the methods that were asked for.
fn outputs_table(page: &mut Page, scores: &FitScores) -> PageTable {
    let asked: Vec<&MemberScores> =
        scores.members.iter().filter(|member| member.role == MemberRole::Asked).collect();
    let caption = format!("Relative RMSE on unseen runs of each output of {}.", literal(&scores.name));
    let mut table = PageTable::new(&page.own_table_label(), &caption, &["Output"]);
    table.columns.extend(asked.iter().map(|member| literal(&member.method)));
    for (k, output) in asked.first().map_or(&[][..], |member| &member.outputs).iter().enumerate() {
        let errors = asked.iter().map(|member| percent(member.outputs[k].unseen.relative_rmse));
        table.row(std::iter::once(literal(&output.name)).chain(errors).collect());
    }
    table
}

fn uses_section(page: &mut Page, pairs: &[(&StudyFit, &FitScores)]) -> Markup {
    let columns =
        ["Surrogate", "Own inputs", "Another run\u{2019}s", "Permuted", "Use", "Help", "Conclusion"];
    let caption =
        "Relative RMSE on unseen runs with inputs of different origin; use and help in percentage points.";
    let mut table = PageTable::new(&page.own_table_label(), caption, &columns);
    for (name, used) in pairs.iter().flat_map(|(_, scores)| &scores.uses) {
        let error = |score: Option<granum_learn::Score>| {
            score.map_or("–".into(), |score| percent(score.relative_rmse))
        };
        table.row(vec![
            literal(name),
            error(used.own),
            error(used.with_other),
            error(used.permuted),
            points(used.lost_with_other()),
            points(used.help()),
            used.verdict().words("inputs"),
        ]);
    }
    let rows = !table.rows.is_empty();
    html! {
        (paragraphs(&[
            "Every unseen run is predicted again with the inputs of the other unseen runs at the same coordinate, and with its \
             own inputs permuted over its states. Use is the increase of the error with the inputs of other runs, help the \
             decrease against the same method with the coordinate only; † marks a mean above zero in a one-sided paired t test \
             at 5 % over the runs."
        ]))
        @if rows { (table.html()) } @else { p { "No surrogate has inputs besides the coordinate, or no run is unseen." } }
    }
}

fn figures_section(page: &mut Page, stored: &StoredStudy) -> Markup {
    let Some(table) = &stored.predictions else {
        return html! { p { "No run is unseen, so that there is nothing to draw." } };
    };
    let mut figures = Vec::new();
    for fit in &stored.study.fits {
        if let Some((figure, caption)) = along_figure(stored, fit, table) {
            figures.push(page.own_figure("along", &caption, &figure));
        }
        let (figure, caption) = against_figure(fit, table);
        figures.push(page.own_figure("against", &caption, &figure));
    }
    html! { @for figure in &figures { (figure) } }
}

fn axis(table: &Columns, name: &str, word: &str) -> Axis {
    let unit =
        table.columns().iter().find(|column| column.name == name).map_or("", |column| column.unit.as_str());
    let axis = Axis::new(&format!("{word}{}", in_words(name)));
    if unit.is_empty() || unit == "1" { axis } else { axis.unit(unit) }
}

/// Some of the outputs of a fit, evenly chosen.
fn some_outputs(fit: &StudyFit) -> Vec<String> {
    let names = fit.members.first().map_or(Vec::new(), |member| member.surrogate.columns().output_names());
    let step = names.len().div_ceil(MOST_PANELS).max(1);
    names.into_iter().step_by(step).collect()
}

/// The outputs along the coordinate: unseen runs as points, the first method as lines with its intervals as bands.
fn along_figure(stored: &StoredStudy, fit: &StudyFit, table: &Columns) -> Option<(Figure, String)> {
    let coordinate = fit.spec.coordinate.as_ref()?;
    let member = fit.members.first()?;
    let (xs, runs) = (table.values(coordinate)?, table.values("run")?);
    let mut panels = Vec::new();
    for output in some_outputs(fit) {
        let of = |word: &str| table.values(&format!("{word}_{output}_by_{}", member.name));
        let (exact, predicted) = (table.values(&output)?, of("predicted")?);
        let mut plot = Plot::new(axis(table, coordinate, ""), axis(table, &output, ""));
        for (k, name) in stored.unseen.iter().take(MOST_RUNS).enumerate() {
            let rows: Vec<usize> = (0..xs.len()).filter(|&row| runs[row] == (k + 1) as f64).collect();
            if let (Some(lower), Some(upper)) = (of("lower"), of("upper")) {
                plot = plot
                    .with(Layer::band(rows.iter().map(|&r| [xs[r], lower[r], upper[r]]).collect(), color(k)));
            }
            let line = rows.iter().map(|&r| [xs[r], predicted[r]]).collect();
            plot = plot.with(Layer::stroked(line, Stroke::new(color(k), 1.6)));
            // About forty markers per curve can be distinguished.
            let marks =
                rows.iter().step_by(rows.len().div_ceil(40).max(1)).map(|&r| [xs[r], exact[r]]).collect();
            plot = plot.with(Layer::points(marks, SHAPES[k % SHAPES.len()], color(k)).named(&literal(name)));
        }
        panels.push(Panel::plot(plot));
    }
    let caption = format!(
        "{} along {}: unseen runs (marks), predictions of {} (lines) and their intervals (bands).",
        in_words(&fit.name),
        literal(coordinate),
        literal(&member.method)
    );
    Some((Figure::new(&caption, panels.len().clamp(1, 2), panels), caption))
}

/// Predicted against measured values for all unseen runs and each method that was asked for.
fn against_figure(fit: &StudyFit, table: &Columns) -> (Figure, String) {
    let mut panels = Vec::new();
    for output in some_outputs(fit) {
        let exact = table.values(&output).unwrap_or(&[]);
        let mut plot = Plot::new(axis(table, &output, "Measured "), axis(table, &output, "Predicted "));
        let asked = fit.members.iter().filter(|member| member.role == MemberRole::Asked);
        for (k, member) in asked.enumerate() {
            let predicted = table.values(&format!("predicted_{output}_by_{}", member.name)).unwrap_or(&[]);
            let dots = exact.iter().zip(predicted).map(|(x, y)| [*x, *y]).collect();
            plot = plot.with(
                Layer::dots(dots, SHAPES[k % SHAPES.len()], 2.0, color(k)).named(&literal(&member.method)),
            );
        }
        let ends = granum_learn::curve::range(exact.iter().copied());
        if ends[0] <= ends[1] {
            plot = plot.with(Layer::stroked(
                ends.map(|x| [x, x]).to_vec(),
                Stroke::new(INK, 0.8).dashed(&[4.0, 3.0]),
            ));
        }
        panels.push(Panel::plot(plot));
    }
    let caption =
        format!("Predicted against measured {} of all unseen runs; dashed: equality.", in_words(&fit.name));
    (Figure::new(&caption, panels.len().clamp(1, 2), panels), caption)
}

fn repeat_section(page: &mut Page, stored: &StoredStudy) -> Markup {
    let study = &stored.study;
    let columns = ["Run", "Role", "Seed"];
    let mut table = PageTable { words: 2, ..PageTable::new(&page.own_table_label(), "The runs.", &columns) };
    for run in &study.runs {
        let seed = run.values.get(granum_io::case::SEED).cloned().unwrap_or_else(|| "–".into());
        table.row(vec![literal(&run.name), run.role.name().into(), seed]);
    }
    let facts = [
        format!(
            "Every {} state of the training runs was used for training, the others were held out. Data set: {}.",
            if study.definition.split.stride == 2 {
                "second".into()
            } else {
                format!("{}th", study.definition.split.stride)
            },
            study.dataset_digest
        ),
        format!(
            "Methods: {}. Intervals of {}.",
            listed(&literals(&study.definition.methods)),
            percent(study.definition.level)
        ),
    ];
    html! { (paragraphs(&facts)) @if !study.runs.is_empty() { (table.html()) } }
}
