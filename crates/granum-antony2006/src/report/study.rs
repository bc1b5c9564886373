//! The report of a study: the reproduction of the whole paper, with its interpretation.

use maud::{Markup, html};

use super::StudyReport;
use super::headline;
use super::{many_runs, networks, tables};
use granum_report::case_details::case_details;
use granum_report::figure::literal;
use granum_report::headline::SIGNS;
use granum_report::numbers::whole;
use granum_report::page::{Document, Page, PageTable, paragraphs, rich, tiles};
use granum_report::run::{behaviour, force_section};
use granum_report::{sample, symbols, trust};

/// Writes the report of a study.
pub fn report(study: &StudyReport) -> Document {
    let mut page = Page::default();
    many_runs_section(&mut page, study);
    networks_section(&mut page, study);
    tables_section(&mut page, study);
    claims_section(&mut page, study);
    interpretation_section(&mut page, study);
    sample_section(&mut page, study);
    material_sections(&mut page, study);
    let trust = trust::section(&mut page, &study.runs);
    page.section("quality", "Can the runs be trusted?", trust);
    reproducibility_section(&mut page, study);
    let head = html! {
        (tiles(&headline::tiles(study)))
        (definitions(study))
        ul class="findings" { @for finding in headline::findings(study) { li { (rich(&finding)) } } }
        p class="callout" { (rich(SIGNS)) }
    };
    page.finish(
        "An integrated mechanistic–neural network model for granular systems, recomputed",
        &subtitle(study),
        head,
    )
}

/// What the mappings are, so that the findings below can name them.
fn definitions(study: &StudyReport) -> Markup {
    let formulas: Vec<String> =
        study.summary.mappings.values().map(|mapping| symbols::markup(&mapping.formula)).collect();
    if formulas.is_empty() {
        return html! {};
    }
    let text = format!(
        "The networks are mappings between soft sensors: {}. Here *ε*_{{d}} is the deviator strain, *q*/*p* the ratio of the deviator stress to \
         the mean stress, *φ*_{{d}} the deviator fabric of the contacts, and *P*(*f*) the distribution of the contact forces over their mean.",
        formulas.join("; ")
    );
    html! { p { (rich(&text)) } }
}

fn subtitle(study: &StudyReport) -> String {
    let dem = &study.summary.dem;
    let unseen = dem.runs.iter().filter(|run| run.role == "unseen").count();
    let networks: usize = study.summary.mappings.values().map(|mapping| mapping.sub_models.len()).sum();
    let version = study.runs.first().map_or("", |run| run.run.granum_version.as_str());
    let mut text = format!(
        "After Antony, Zhou and Wang (2006). {} DEM runs of {} grains, {unseen} of them unseen by any network; {networks} \
         networks.",
        dem.runs.len(),
        whole(dem.grains as f64)
    );
    if let Some(curve) = &study.summary.learning_curve {
        let most = curve.points.iter().map(|point| point.training_runs).max().unwrap_or(0);
        text += &format!(
            " In addition the same networks trained on up to {most} runs of {} grains, scored on {} more.",
            whole(curve.grains as f64),
            curve.unseen_runs
        );
    }
    if !version.is_empty() {
        text += &format!(" Computed by granum {version}.");
    }
    text
}

/// The section with results beyond the paper: which sensors reduce the error, by how much, and from how many runs on.
fn many_runs_section(page: &mut Page, study: &StudyReport) {
    if let Some(curve) = &study.summary.learning_curve {
        let body = many_runs::section(page, curve);
        page.section("more-runs", "More training runs: which soft sensors help", body);
    }
}

fn networks_section(page: &mut Page, study: &StudyReport) {
    let label = page.own_table_label();
    let table = networks::score_table(&label, &study.summary).html();
    let sensors = networks::sensor_table(&page.own_table_label(), &study.summary).map(|table| table.html());
    let (scores, caption) = networks::score_figure(&study.summary);
    let scores = page.own_figure("scores", &caption, &scores);
    let mut figures = Vec::new();
    for data in &study.figures {
        let (figure, caption) = networks::figure(data);
        figures.push(match networks::figure_number(&data.mapping) {
            Some(number) => {
                page.figure(&format!("Figure {number}"), &format!("figure-{number}.svg"), &caption, &figure)
            }
            None => page.own_figure("mapping", &caption, &figure),
        });
    }
    let body = html! {
        p { "Figures 3–8 and Tables 1–6 carry the paper\u{2019}s numbers; those that the paper does not have are numbered S1, S2… " }
        (table)
        @if let Some(sensors) = sensors { (sensors) }
        (scores)
        @for figure in figures { (figure) }
    };
    page.section("networks", "Networks compared with unseen DEM runs", body);
}

fn tables_section(page: &mut Page, study: &StudyReport) {
    let tables: Vec<PageTable> =
        study.summary.mappings.iter().filter_map(|(name, ours)| tables::table(name, ours)).collect();
    let body = html! {
        p {
            "Sizes are the paper\u{2019}s unless they were changed. An epoch of the paper\u{2019}s trainer is one pass of the \
             data with one small step; an epoch of Levenberg\u{2013}Marquardt solves for the whole step, so the two numbers \
             cannot be compared. Weights in use: the effective number of parameters found by Bayesian regularisation."
        }
        @for table in &tables { (table.html()) }
    };
    page.section("tables", "The networks", body);
}

fn claims_section(page: &mut Page, study: &StudyReport) {
    let size = networks::size_figure(&study.summary)
        .map(|(figure, caption)| page.own_figure("size", &caption, &figure));
    let size_words: Vec<String> = study
        .summary
        .size_study
        .iter()
        .flat_map(crate::interpretation::read_size_study)
        .map(|sentence| symbols::markup(&sentence))
        .collect();
    let body = html! {
        h3 { "The fabric as an input allows a smaller network" }
        @if let Some(size) = size { (size) (paragraphs(&size_words)) }
        @else { p { "The sizes were not compared in this study." } }
        h3 { "The networks are faster than DEM" }
        p {
            "The paper says 5 to 10 times. Times depend on the computer and are therefore not on this page, which has the same \
             bytes everywhere: they are in the files seconds.json and speed.html beside it. The networks are given soft \
             sensors of the test that they predict, which a laboratory would have to measure."
        }
    };
    page.section("claims", "The paper\u{2019}s claims, tested", body);
}

fn interpretation_section(page: &mut Page, study: &StudyReport) {
    // The size has a separate section.
    let elsewhere: Vec<String> =
        (study.summary.size_study.iter()).flat_map(crate::interpretation::read_size_study).collect();
    let sentences: Vec<String> = (study.summary.reading.iter())
        .filter(|sentence| !elsewhere.contains(sentence))
        .map(|sentence| symbols::markup(sentence))
        .collect();
    let body = html! {
        (paragraphs(&[
            "With one sample on one path every quantity is a function of strain alone: a network may score well and \
             have learned nothing but the curve. Each mapping is therefore compared with a network of the same size \
             whose only input is strain, with ridge regression on the same sensors, and with the mean curve of the \
             training runs. To test whether its sensors are used, each unseen run is predicted again with the sensors \
             of every other unseen run at the same strain. Only an increase of the error beyond its scatter over the \
             runs (one-sided paired t test at 5 %) shows use, and only an error below that of the strain-only \
             networks, by the same test, shows gain. The sentences follow from the numbers by fixed rules."
        ]))
        ul class="findings" { @for sentence in &sentences { li { (rich(sentence)) } } }
    };
    page.section("reading", "What the networks learned", body);
}

fn sample_section(page: &mut Page, study: &StudyReport) {
    let label = page.own_table_label();
    let body = html! {
        (paragraphs(&sample::interpretation(&study.runs)))
        @if let Some(table) = sample::table(&label, &study.runs) { (table.html()) }
    };
    page.section("sample", "The sample and the test, compared with the paper\u{2019}s", body);
}

fn material_sections(page: &mut Page, study: &StudyReport) {
    let body = behaviour(page, &study.runs);
    page.section("behaviour", "Stress, volume, contacts and fabric", body);
    if let Some(run) = study.runs.first() {
        let body = force_section(page, run);
        page.section("forces", "Distribution of the contact forces", body);
    }
}

fn reproducibility_section(page: &mut Page, study: &StudyReport) {
    let label = page.own_table_label();
    let columns = ["Run", "Role", "Seed", "Million grain-steps", "Case digest"];
    let mut table = PageTable { words: 2, ..PageTable::new(&label, "The DEM runs.", &columns) };
    for run in &study.runs {
        table.row(vec![
            literal(&run.name),
            run.role.word().to_owned(),
            run.case.preparation.seed.to_string(),
            whole(run.run.grain_steps() as f64 / 1e6),
            run.case.digest().chars().take(12).collect(),
        ]);
    }
    let mut facts = Vec::new();
    if !study.dataset_hash.is_empty() {
        facts.push(format!(
            "Data set of the networks: {}; seed of their weights: {}.",
            study.dataset_hash, study.network_seed
        ));
    }
    facts.push(
        "Results do not depend on the number of threads or the instruction set; wall times do, and are in seconds.json."
            .to_owned(),
    );
    let body: Markup = html! {
        @if !study.command.is_empty() { pre { (study.command) } }
        (table.html())
        (paragraphs(&facts))
        @if let Some(run) = study.runs.first() { (case_details(run)) }
    };
    page.section("reproducibility", "How to repeat the computation", body);
}
