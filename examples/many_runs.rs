//! One test at several stresses and frictions: a queue of runs, a table of their results.

use granum::prelude::*;
use granum::run::queue::{NoQueueObserver, Queue, QueuedRun, Setting, combinations, names};
use granum::run::runs_table::{RunEntry, RunsTable, Selection};

const CASE: &str = "
[grains]
count = 100
[contact]
normal = \"hertz\"
tangential = \"no-slip\"
[grains.material]
interface_energy = 0
[preparation]
solid_fraction = \"none\"
friction = 0.1
unbalanced_force = 0.02
[[stage]]
path = \"drained-triaxial\"
axial_strain = 0.01
inertial_number = 0.005
";

/// The whole program.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::temp_dir().join(format!("granum-many-runs-{}", std::process::id()));
    let setting = |key: &str, values: [&str; 2]| Setting {
        key: key.to_string(),
        values: values.map(String::from).to_vec(),
    };
    // ANCHOR: plan
    let settings = [
        setting("grains.material.friction", ["0.2", "0.5"]),
        setting("stage.1.lateral_stress", ["20 kPa", "30 kPa"]),
    ];
    let case = Case::parse(CASE, "case")?;
    let mut runs = Vec::new();
    for (name, values) in names(&settings)?.into_iter().zip(combinations(&settings)?) {
        let mut case = case.clone();
        for (setting, value) in settings.iter().zip(&values) {
            case.set(&setting.key, value)?;
        }
        runs.push(QueuedRun::test(&name, case, Source::Case, folder.join(&name)));
    }
    // ANCHOR_END: plan
    // ANCHOR: queue
    // The two tests of each friction share their sample.
    let queue = Queue::with_shared_samples(runs, &folder.join("samples"))?;
    let laboratory = Laboratory::here();
    queue.check(&laboratory, false)?;
    let outcomes = queue.run(&laboratory, &NoQueueObserver);
    // ANCHOR_END: queue

    // ANCHOR: table
    let mut entries = Vec::new();
    for (run, outcome) in queue.runs().iter().zip(&outcomes) {
        match outcome.record() {
            Some(record) if run.after.is_some() => {
                entries.push(RunEntry::new(&run.name, &run.folder, run.case.clone(), record.clone()));
            }
            _ => println!("{}: {}", run.name, outcome.word()),
        }
    }
    let table = RunsTable::from_runs(&entries);
    granum::io::formats::csv::write_rows(&mut std::io::stdout(), &table.select(Selection::Main))?;
    // ANCHOR_END: table
    let friction = table.column("grains.material.friction").and_then(|column| column.numbers());
    assert_eq!(friction, Some(&[0.2, 0.2, 0.5, 0.5][..]));
    std::fs::remove_dir_all(folder)?;
    Ok(())
}
