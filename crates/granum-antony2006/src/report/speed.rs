//! The page with the computing times of a study. The report leaves them out, since they depend on the computer and on
//! interruptions.

use granum_report::figure::literal;
use granum_report::numbers::{duration, factor, whole};
use granum_report::page::{Document, Page, PageTable, paragraphs, tiles};
use granum_report::symbols;
use maud::html;

use super::StudyReport;
use crate::interpretation::read_speed;

/// Writes the page; `None` if the times are unknown.
pub fn page(study: &StudyReport) -> Option<Document> {
    let speed = &study.summary.speed;
    if speed.factor <= 0.0 {
        return None;
    }
    let mut page = Page::default();
    let label = page.own_table_label();
    let mut table = PageTable::new(&label, "Computing times of DEM and networks.", &["", "Time"]);
    for (name, seconds) in [
        ("One DEM test (shear)", speed.dem_seconds),
        ("Networks, for the same curves", speed.network_seconds),
        ("Training of all networks, once", speed.training_seconds),
    ] {
        table.row(vec![name.to_owned(), duration(seconds)]);
    }
    table.row(vec!["Factor".into(), format!("{} (paper: 5–10)", factor(speed.factor))]);
    page.section(
        "speed",
        "The networks are faster than DEM",
        html! { (table.html()) (paragraphs(&[symbols::markup(&read_speed(speed))])) },
    );
    let label = page.own_table_label();
    let columns = ["Run", "Computer", "Threads", "Wall time", "Million grain-steps per second"];
    let mut runs = PageTable { words: 2, ..PageTable::new(&label, "The DEM runs.", &columns) };
    for run in study.runs.iter().filter(|run| run.wall_seconds() > 0.0) {
        let machine = &run.run.machine;
        runs.row(vec![
            literal(&run.name),
            format!("{} with {}", machine.system, machine.instruction_set),
            format!("{} of {}", machine.threads, machine.available_threads),
            duration(run.wall_seconds()),
            whole(run.run.grain_steps() as f64 / run.wall_seconds() / 1e6),
        ]);
    }
    page.section("runs", "The DEM runs", html! { (runs.html()) });
    let head = html! {
        (tiles(&[[
            format!("× {}", factor(speed.factor)),
            "faster than the DEM test".into(),
            "paper: 5–10; training not counted".into(),
        ]]))
    };
    let subtitle = "Times of this computer; all results are in report.html, which does not depend on it.";
    Some(page.finish("Computing times of DEM and networks", subtitle, head))
}
