//! Reports from synthetic data: they are complete and self-contained, and the same data give identical bytes.
//!
//! The pages are written to the target directory, where they can be inspected.

mod checks;
mod names_and_noise;
mod synthetic;

use granum_report::{self as report, RoleInStudy, RunReport};

use checks::{check, keep};

#[test]
fn a_run_has_every_section_and_figure() {
    let mut run = synthetic::run(RoleInStudy::Single, 3);
    run.start = Some(synthetic::assembly(0.0));
    run.end = Some(synthetic::assembly(0.35));
    let document = report::run_report(&run);
    keep(&document, "run");
    check(&document);
    for id in ["behaviour", "forces", "quality", "case"] {
        assert!(document.html.contains(&format!("<section id=\"{id}\">")), "{id}");
    }
    for file in
        ["stress", "coordination", "fabric", "forces", "roses", "force-chains", "strong-network", "energy"]
    {
        assert!(document.figures.iter().any(|(name, _)| name.contains(file)), "{file}");
    }
    assert!(document.html.contains("Compression is positive"));
    assert!(document == report::run_report(&run), "the same run is the same bytes");
}

#[test]
fn a_run_without_anything_is_still_a_page() {
    let document = report::run_report(&RunReport::default());
    check(&document);
    assert!(document.html.contains("did not reach its end"));
}

#[test]
fn names_cannot_break_the_page() {
    let run = RunReport { name: "</title><b>\"&'".into(), ..Default::default() };
    let document = report::run_report(&run);
    check(&document);
    assert!(!document.html.contains("<b>\"&'"));
}

#[test]
fn a_run_is_read_from_its_folder_as_it_was_written() {
    let mut run = synthetic::run(RoleInStudy::Single, 5);
    run.start = Some(synthetic::assembly(0.0));
    run.end = Some(synthetic::assembly(0.2));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("run-5");
    {
        let out = granum_io::RunFolder::create(&path, false).expect("a new folder");
        run.run.case_digest = run.case.digest();
        run.run.preparation_digest = run.case.preparation_digest();
        out.write_case(&run.case, None).expect("written");
        out.write_record(&run.run).expect("written");
        granum_run::record::write_record(&out, &run.record).expect("written");
        for (name, assembly) in
            [(granum_run::laboratory::SAMPLE, &run.start), (granum_run::laboratory::END, &run.end)]
        {
            out.write_snapshot(name, assembly.as_ref().expect("set above")).expect("written");
        }
    }
    let read =
        RunReport::read(&granum_io::Run::at(&path).expect("a run"), RoleInStudy::Single).expect("readable");
    assert_eq!(read.name, "run-5");
    for (found, written) in read.record.series.columns().iter().zip(run.record.series.columns()) {
        assert!(found == written, "{} differs", written.name);
    }
    assert!(read.record.histograms == run.record.histograms, "the histograms differ");
    assert!(read.case == run.case, "the case differs");
    let [written, again] = [&run, &read].map(|run| {
        let document = report::run_report(&RunReport { name: "same".into(), ..run.clone() });
        document.figures
    });
    assert!(written == again, "the figures of the folder are those of the run");
}
