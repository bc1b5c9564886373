//! Makes a campaign of many runs that are finished already, without simulating them: one small test is run, and its results are recorded
//! for every run. With it the time of `granum campaign status`, of the same command again and of the data set can be measured at 10,000
//! runs:
//!
//! ```sh
//! cargo run --release -p granum-campaign --example recorded_campaign -- DIR 10000            # folders of runs
//! cargo run --release -p granum-campaign --example recorded_campaign -- DIR 10000 dataset    # their rows only
//! time granum campaign status DIR/study
//! time granum campaign DIR/plan.toml --out DIR/study           # the first time it also writes the data set
//! ```

use std::path::{Path, PathBuf};

use granum_campaign::plan::Plan;
use granum_campaign::rows::{RowWriter, StoredRun, read_run};
use granum_campaign::{Campaign, RUNS};
use granum_io::{Case, OutputFolder, Reading, RunFolder, RunKind};
use granum_run::record::write_record;
use granum_run::{Laboratory, NoObserver, Source};

const SAND: &str = "[grains]\ncount = 60\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\n\
                    tangential = 'no-slip'\n[preparation]\nmean_stress = '100 kPa'\nfriction = 0.1\nsolid_fraction = 'none'\n\
                    inertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.01\n\
                    inertial_number = 1e-2\nstates = 20\n";
/// Number of runs whose rows are written at once.
const AT_ONCE: usize = 100;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let usage = "usage: recorded_campaign DIR RUNS [dataset]";
    let folder = PathBuf::from(arguments.next().ok_or(usage)?);
    let count: usize = arguments.next().ok_or(usage)?.parse()?;
    let rows_only = arguments.next().as_deref() == Some("dataset");
    std::fs::create_dir_all(&folder)?;
    std::fs::write(folder.join("sand.toml"), SAND)?;
    let keep = if rows_only { "dataset" } else { "folders" };
    let plan = format!(
        "case = 'sand.toml'\nkeep = '{keep}'\naccept = ['inertial_number < 1', 'servo_error_rms < 1', 'servo_error_largest < 10', \
         'unbalanced_force < 10', 'energy_gap < 1', 'sample_unbalanced_force < 1', 'largest_overlap < 1']\n[design]\nkind = 'sobol'\n\
         points = {count}\nsample_seeds = 'different'\n[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\nfrom = 0.1\n\
         to = 0.8\n[[variable]]\nname = 'damping'\nkey = 'contact.damping'\nfrom = 0.05\nto = 0.1\n"
    );
    std::fs::write(folder.join("plan.toml"), plan)?;
    let plan = Plan::read(&folder.join("plan.toml"), Reading::default())?;
    let planned = plan.runs()?;
    let out = OutputFolder::open_or_create(folder.join("study"))?;
    let campaign = Campaign::new(out.path(), &plan, &planned, env!("CARGO_PKG_VERSION"));
    campaign.write()?;
    let one = one_run(&folder.join("one"))?;
    let mut writer = RowWriter::new(out.path());
    for runs in campaign.runs().chunks(AT_ONCE) {
        let mut rows = Vec::new();
        for run in runs {
            let case = campaign.case_of(run)?;
            let stored = recorded(&one, &case);
            if rows_only {
                rows.push((run.name.clone(), stored));
            } else {
                write_folder(&out.path().join(RUNS).join(&run.name), &case, &stored)?;
            }
        }
        writer.append(&rows)?;
    }
    println!("made {} runs in {}", campaign.runs().len(), out.path().display());
    Ok(())
}

/// A small test, run for real.
fn one_run(folder: &Path) -> Result<StoredRun, Box<dyn std::error::Error>> {
    let case = Case::parse(SAND, "sand.toml")?;
    let laboratory = Laboratory::here();
    let run = RunFolder::create(folder, true)?;
    laboratory.run(RunKind::Test, &case, &Source::Case, &run, &mut NoObserver)?;
    drop(run);
    Ok(read_run(folder, &case.vocabulary)?)
}

/// The same results as those of another case.
fn recorded(one: &StoredRun, case: &Case) -> StoredRun {
    let mut run = one.clone();
    run.record.case_digest = case.digest();
    run.record.preparation_digest = case.preparation_digest();
    run.record.seed = Some(case.preparation.seed);
    run.record.granum_version = env!("CARGO_PKG_VERSION").into();
    run
}

fn write_folder(path: &Path, case: &Case, run: &StoredRun) -> granum_io::Result<()> {
    let folder = RunFolder::create(path, true)?;
    folder.write_case(case, None)?;
    write_record(&folder, &run.measured)?;
    folder.write_record(&run.record)
}
