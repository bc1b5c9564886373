//! The report of the data of another program: force chains, fabric, the distribution of forces, and every sensor that the data allow.

use granum_core::{Assembly, Part, Parts};
use granum_sensors::force_distribution::FORCES;
use granum_sensors::{Measurement, Sensors};
use maud::{Markup, html};

use super::figure::chains::View;
use super::figure::palette::{COLORS, color};
use super::figure::rose::Series;
use super::figure::{Axis, Figure, ForceChains, Layer, Legend, Panel, Plot, Rose, SHAPES, literal};
use super::forces::density;
use super::numbers::{significant, whole};
use super::page::{Document, Page, PageTable, rich, tiles};

/// Thickness of a slice, mean diameters.
const SLICE: f64 = 1.6;

/// An instant of the data, with its name and the parts that are known.
#[derive(Clone, Debug)]
pub struct Instant {
    /// Its name, e.g. `the data` or `step 1000`.
    pub name: String,
    /// The grains and contacts.
    pub assembly: Assembly,
    /// What is known of them.
    pub parts: Parts,
}

/// Writes the report of one or several instants; of several, pictures and distributions show the first and the last.
///
/// `title` names the data, e.g. by their files; `sensors` measure them.
pub fn report(title: &str, instants: &[Instant], sensors: &Sensors) -> Document {
    let mut page = Page::default();
    let mut shown: Vec<(&Instant, Measurement)> = Vec::new();
    for instant in instants.first().into_iter().chain(instants.last().filter(|_| instants.len() > 1)) {
        shown.push((instant, sensors.measure(&instant.assembly, instant.parts)));
    }
    let mut missing: Vec<String> = Vec::new();
    let mut figures: Vec<Markup> = Vec::new();
    for (file, found) in [
        ("force-chains", slices(&shown)),
        ("strong-network", strong_network(&shown)),
        ("forces", distribution(&shown)),
        ("roses", roses(&shown)),
        ("series", series(sensors, instants)),
    ] {
        match found {
            Ok(Some((figure, caption))) => figures.push(page.own_figure(file, &caption, &figure)),
            Ok(None) => {}
            Err(why) => missing.push(why),
        }
    }
    let body = html! {
        @for figure in figures { (figure) }
        @for why in &missing { p class="callout" { (why) } }
    };
    page.section("forces", "Force chains and fabric", body);
    let label = page.own_table_label();
    page.section("sensors", "Sensors", measured(&label, &shown));
    let grains = shown.first().map_or(0, |(instant, _)| instant.assembly.bodies.len());
    let contacts = shown.first().map_or(0, |(instant, _)| instant.assembly.contacts.len());
    let head = html! {
        (tiles(&heads(grains, contacts, instants.len(), &shown)))
        p { (rich("Compression is positive, for stress and normal force. Axis 1 is *x*. Units are SI.")) }
    };
    page.finish(&literal(title), "data of another program, measured by granum", head)
}

/// A figure with its caption, none, or the reason why there is none.
type Found = Result<Option<(Figure, String)>, String>;

fn heads(
    grains: usize,
    contacts: usize,
    instants: usize,
    shown: &[(&Instant, Measurement)],
) -> Vec<[String; 3]> {
    let mut heads = vec![[whole(grains as f64), "grains".into(), String::new()]];
    if shown.first().is_some_and(|(instant, _)| instant.parts.has(Part::Contacts)) {
        heads.push([whole(contacts as f64), "contacts".into(), String::new()]);
    }
    if instants > 1 {
        heads.push([whole(instants as f64), "instants".into(), String::new()]);
    }
    let Some((_, first)) = shown.first() else { return heads };
    for (column, name) in [
        ("solid_fraction", "solid fraction"),
        ("mechanical_coordination_number", "mechanical coordination number"),
        ("deviator_fabric", "deviator fabric *φ*_{d}"),
    ] {
        if let Some(value) = first.value(column) {
            heads.push([significant(value, 3), name.into(), String::new()]);
        }
    }
    heads
}

/// The instants that have certain parts, or a sentence on what is missing.
fn with_parts<'a>(
    shown: &'a [(&Instant, Measurement)],
    wanted: &[Part],
    what: &str,
) -> Result<Vec<&'a (&'a Instant, Measurement)>, String> {
    let able: Vec<_> = shown.iter().filter(|(instant, _)| instant.parts.missing(wanted).is_empty()).collect();
    if !able.is_empty() {
        return Ok(able);
    }
    let lacking = shown.first().map_or(Vec::new(), |(instant, _)| instant.parts.missing(wanted));
    let names: Vec<&str> = lacking.iter().map(|part| part.name()).collect();
    Err(format!("There is no figure of {what}: the data have no {}.", names.join(", no ")))
}

fn title(instants: usize, instant: &Instant) -> String {
    if instants > 1 { literal(&instant.name) } else { String::new() }
}

/// Slices with the contacts drawn by their force.
fn slices(shown: &[(&Instant, Measurement)]) -> Found {
    let wanted = [Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::NormalForces];
    let able = with_parts(shown, &wanted, "force chains")?;
    let pictures: Vec<(ForceChains, String)> = able
        .iter()
        .map(|(instant, _)| {
            let view = View::slice(&instant.assembly, SLICE);
            (ForceChains::new(&instant.assembly, view), title(shown.len(), instant))
        })
        .collect();
    let extent = pictures.iter().fold([0.0f64; 2], |largest, (picture, _)| {
        std::array::from_fn(|k| largest[k].max(picture.extent()[k]))
    });
    let columns = pictures.len();
    let width = if columns == 1 { 440.0 } else { 720.0 };
    let height = ForceChains::height_for(extent, width / columns as f64 - 16.0) + 30.0;
    let panels = pictures
        .into_iter()
        .map(|(picture, title)| Panel::chains(picture.with_extent(extent)).titled(&title))
        .collect();
    let caption = "Force chains in a slice 1.6 diameters thick through the middle of the cell, *x* up and *y* to the right. Grains are faint \
                   circles (white: fewer than two contacts); each contact between grains of the slice is a line from centre to \
                   centre, as wide and dark as its normal force.";
    let figure = Figure::new("Force chains in a slice", columns, panels);
    Ok(Some((figure.sized(width, height), caption.into())))
}

/// The strong contacts of the whole cell at the last instant.
fn strong_network(shown: &[(&Instant, Measurement)]) -> Found {
    let wanted = [Part::Cell, Part::Positions, Part::Radii, Part::Contacts, Part::NormalForces];
    // What is missing is said with the slices.
    let Some((instant, _)) =
        with_parts(shown, &wanted, "force chains").ok().and_then(|able| able.last().copied())
    else {
        return Ok(None);
    };
    let picture = ForceChains::new(&instant.assembly, View::strong());
    let height = ForceChains::height_for(picture.extent(), 632.0) + 8.0;
    let when = if shown.len() > 1 { " at the last instant" } else { "" };
    let caption = format!(
        "Strong contacts (*N* > ⟨*N*⟩) of the whole cell{when}, seen along axis 3 with *x* up; contacts farther away are paler."
    );
    let figure = Figure::new("Strong contacts of the whole cell", 1, vec![Panel::chains(picture)]);
    Ok(Some((figure.sized(640.0, height), caption)))
}

/// P(f) on a logarithmic scale.
fn distribution(shown: &[(&Instant, Measurement)]) -> Found {
    let mut plot = Plot::new(
        Axis::new("Normal force *f* = *N*/⟨*N*⟩"),
        Axis::new("Probability density *P*(*f*)").logarithmic(),
    );
    let mut drawn = 0;
    for (k, (instant, measured)) in shown.iter().enumerate() {
        let Some((_, histogram)) = measured.histograms.iter().find(|(bins, _)| bins.name == FORCES) else {
            continue;
        };
        let mut layer = Layer::points(density(histogram), SHAPES[k], color(k));
        if shown.len() > 1 {
            layer = layer.named(&literal(&instant.name));
        }
        plot = plot.with(layer);
        drawn += 1;
    }
    let caption = "Distribution of the normal contact forces.";
    let figure = || Figure::new("Distribution of normal forces", 1, vec![Panel::plot(plot)]);
    Ok((drawn > 0).then(|| (figure(), caption.into())))
}

/// Roses of the contact normals, by number and by force where forces are known.
fn roses(shown: &[(&Instant, Measurement)]) -> Found {
    let values = |measured: &Measurement, prefix: &str| -> Option<Vec<f64>> {
        (0..granum_sensors::rose::BINS)
            .map(|bin| measured.value(&format!("{prefix}{:02}", 5 + 10 * bin)))
            .collect()
    };
    let mut roses: Vec<(Rose, String)> = Vec::new();
    for (instant, measured) in shown {
        let Some(number) = values(measured, "rose_") else { continue };
        let mut series =
            vec![Series { label: "by number".into(), values: number.clone(), color: COLORS[0].into() }];
        if let Some(force) = values(measured, "rose_force_") {
            let force = number.iter().zip(force).map(|(n, f)| n * f).collect();
            series.push(Series { label: "by normal force".into(), values: force, color: COLORS[1].into() });
        }
        let rose = Rose {
            series,
            reference: Some(1.0),
            up: "*x*".into(),
            right: "*y*, *z*".into(),
            ..Rose::default()
        };
        roses.push((rose, title(shown.len(), instant)));
    }
    if roses.is_empty() {
        return Err("There is no rose of contact normals: the data have no contacts.".into());
    }
    let rim = roses.iter().map(|(rose, _)| rose.largest()).fold(1.0, f64::max);
    let panels: Vec<Panel> = roses
        .into_iter()
        .map(|(rose, title)| Panel::rose(Rose { rim: Some(rim), ..rose }).titled(&title))
        .collect();
    let columns = panels.len();
    let figure = Figure::new("Roses of contact normals", columns, panels);
    let caption = "Fabric: directions of the contact normals by their angle to *x* (up), as densities relative to an isotropic assembly \
                   (dashed circle), by number of contacts and, where forces are known, weighted by their normal force.";
    let figure = figure.sized(360.0 * columns as f64, 260.0).legend(Legend::Above);
    Ok(Some((figure, caption.into())))
}

/// Coordination number and fabric over the instants, if there are more than two.
fn series(sensors: &Sensors, instants: &[Instant]) -> Found {
    if instants.len() < 3 {
        return Ok(None);
    }
    let views: Vec<(&Assembly, Parts)> =
        instants.iter().map(|instant| (&instant.assembly, instant.parts)).collect();
    let measured = sensors.measure_series(&views);
    let line = |label: &str, column: &str| {
        let values = measured.values(column)?;
        let points = values.iter().enumerate().map(|(k, value)| [(k + 1) as f64, *value]).collect();
        Some(Panel::plot(
            Plot::new(Axis::new("Instant"), Axis::new(label)).with(Layer::line(points, color(0))),
        ))
    };
    let panels: Vec<Panel> = [
        line("Mechanical coordination number *Z*_{m}", "mechanical_coordination_number"),
        line("Deviator fabric *φ*_{d}", "deviator_fabric"),
    ]
    .into_iter()
    .flatten()
    .collect();
    if panels.is_empty() {
        return Ok(None);
    }
    let columns = panels.len();
    let figure = Figure::new("Coordination number and fabric over the instants", columns, panels);
    Ok(Some((
        figure,
        "Coordination number and deviator fabric *φ*_{1} − *φ*_{3} over the instants of the data.".into(),
    )))
}

/// Every sensor that could be measured, and what the others lack.
fn measured(label: &str, shown: &[(&Instant, Measurement)]) -> Markup {
    let mut heads = vec!["Column".to_string(), "Meaning".into(), "Unit".into()];
    match shown {
        [_] => heads.push("Value".into()),
        _ => heads.extend(shown.iter().map(|(instant, _)| literal(&instant.name))),
    }
    let heads: Vec<&str> = heads.iter().map(String::as_str).collect();
    let mut table = PageTable::new(label, "What could be measured.", &heads);
    table.words = 3;
    let Some((_, first)) = shown.first() else { return html! {} };
    for (column, _) in &first.columns {
        let unit = if column.unit == "1" { "" } else { column.unit };
        let mut cells = vec![literal(column.name), literal(column.description), literal(unit)];
        cells.extend(
            shown
                .iter()
                .map(|(_, one)| one.value(column.name).map_or("–".into(), |value| significant(value, 4))),
        );
        table.row(cells);
    }
    html! {
        (table.html())
        @if !first.left_out.is_empty() {
            p { "Not measured, with what the data lack:" }
            ul { @for left_out in &first.left_out { li { (left_out.to_string()) } } }
        }
    }
}
