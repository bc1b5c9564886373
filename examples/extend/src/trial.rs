//! Tries every addition, in this program and through the commands of granum.

use std::path::Path;
use std::process::Command;

use granum::prelude::*;

use crate::hardening_study::hardening_study;
use crate::replay::Replay;
use crate::spheres::loose_lattice;

/// A campaign of such tests: its base case, its variables and its conditions name what is added here.
const PLAN: &str = r#"
case = "case.toml"
accept = ["inertial_number < 1", "unbalanced_force < 1", "servo_error_rms < 1", "servo_error_largest < 9"]
[set]
grains.count = 60
recording.largest_speed = 4
[design]
kind = "full-factorial"
[[variable]]
key = "contact.rolling_spring_friction"
values = [0.1, 0.3]
[[variable]]
name = "strain"
key = "stage.1.axial_strain"
values = [0.01, 0.02]
"#;

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A case that names the law, the path and the sensor, and gives their parameters.
const CASE: &str = r#"
[grains.material]
interface_energy = 0
[contact]
normal = "hertz"
tangential = "no-slip"
rolling = "rolling-spring"
rolling_spring_friction = 0.2
[preparation]
solid_fraction = "none"
friction = 0.3
unbalanced_force = 0.01
[recording]
observations_per_state = 4
sensors = ["fluctuating_speeds"]
largest_speed = 3
[[stage]]
path = "biaxial-at-constant-mean"
axial_strain = 0.02
inertial_number = 0.005
states = 8
"#;

/// All of them.
pub fn all(registry: &Registry) -> Outcome {
    let folder = std::env::temp_dir().join(format!("granum-extend-{}", std::process::id()));
    std::fs::create_dir_all(&folder)?;
    let outcome = in_folder(registry, &folder);
    std::fs::remove_dir_all(&folder)?;
    outcome
}

fn in_folder(registry: &Registry, folder: &Path) -> Outcome {
    let packing = folder.join("loose.spheres");
    crate::rigid_plane::comes_to_rest()?;
    println!("{}", crate::thread::try_it()?);
    registry.runs.formats.write_packing(&packing, &loose_lattice(6))?;
    let records = [0.2, 0.1, 0.3].map(|friction| test(registry, &packing, friction));
    let records = records.into_iter().collect::<Result<Vec<Record>, _>>()?;
    study(registry, &records, folder)?;
    engine(registry, &records[0])?;
    commands(folder)
}

/// A test of a packing in a format, with a law, along a path and seen by a sensor of this program.
fn test(registry: &Registry, packing: &Path, friction: f64) -> Result<Record, Box<dyn std::error::Error>> {
    let given = format!("rolling_spring_friction = {friction}");
    let case = registry.parse_case(&CASE.replace("rolling_spring_friction = 0.2", &given), "case")?;
    let laboratory = Laboratory::here().with_registry(registry);
    let source = Source::Packing(packing.to_path_buf());
    let test = laboratory.plan(RunKind::Test, &case, &source, &mut NoObserver)?.in_memory(&mut NoObserver)?;

    let columns = ["axial_strain", "lateral_strain_3", "von_mises_ratio", "fluctuating_speed"];
    let [strain, fixed, ratio, speed] = test.record.series.select(columns)?;
    println!("eps_1    q/p    v (m/s)");
    for k in 0..strain.len() {
        println!("{:.4}  {:.3}  {:.2e}", strain[k], ratio[k], speed[k]);
    }
    let bins = test.record.histograms("speeds").first().map_or(0, Histogram::bins);
    assert_eq!(bins, 30, "the case gives the parameter of the sensor");
    let speeds = test.record.histograms("speeds").iter().map(Histogram::total).sum::<u64>();
    let rolled = test.simulation()?.assembly().energy.rolling;
    let released =
        test.record.series.values("rolling_release_loss").ok_or("the law has an energy channel")?;
    let released = released.last().copied().unwrap_or_default();
    println!("{speeds} speeds were counted; {rolled:.2e} J were lost by rolling, {released:.2e} J given up");

    assert!(fixed.iter().all(|strain| strain.abs() < 1e-12), "the path holds axis z");
    assert!(ratio.iter().any(|ratio| *ratio > 0.2), "the sample resists");
    assert!(speed.iter().skip(1).all(|speed| *speed > 0.0), "the sensor measures");
    assert!(speeds > 0 && rolled > 0.0, "the histogram counts, and the law takes energy");
    assert!(released != 0.0 && released.abs() < rolled, "the channel of the law has its energy");
    let energy = test.about.quality.iter().find(|flag| flag.name.contains("energy"));
    assert!(energy.is_some_and(|flag| flag.passed), "the energies add up: {energy:?}");
    Ok(test.record)
}

/// A study with the method of this program, whose surrogate is saved and read.
fn study(registry: &Registry, records: &[Record], folder: &Path) -> Outcome {
    let (study, scores) = hardening_study(records, &registry.methods)?;
    for member in &scores.fits[0].members {
        println!("{:<50} {:.1} % on the unseen run", member.name, 100.0 * member.unseen.score.relative_rmse);
    }
    let name = "von_mises_ratio-fading-memory";
    let own = scores.member(name).ok_or("the method is in the study")?;
    let ridge = scores.member("von_mises_ratio-ridge").ok_or("ridge regression is the baseline")?;
    let [ours, theirs] = [own, ridge].map(|member| member.unseen.score.relative_rmse);
    assert!(ours < theirs, "on a run that it has not seen, memory is worth something: {ours}, {theirs}");
    let file = folder.join("surrogate.json");
    let surrogate = &study.member(name)?.surrogate;
    granum::learn::surrogate::save(&file, surrogate.as_ref())?;
    let read = registry.methods.load(&file)?;
    let row = [0.01, 1e-3];
    assert_eq!(read.predict_rows(&row, 0.9)?, surrogate.predict_rows(&row, 0.9)?);
    Ok(())
}

/// A laboratory with the engine of this program.
fn engine(registry: &Registry, record: &Record) -> Outcome {
    let registry = registry.clone().with_engine(Replay(record.clone()))?;
    let case = registry.parse_case(CASE, "case")?;
    let laboratory = Laboratory { engine: "replay".into(), ..Laboratory::here().with_registry(registry) };
    let planned = laboratory.plan(RunKind::Test, &case, &Source::Case, &mut NoObserver)?;
    let again = planned.in_memory(&mut NoObserver)?;
    assert_eq!((again.about.engine.as_str(), &again.record), ("replay", record));
    Ok(())
}

/// The commands of granum, and the one of this program, in a process each.
fn commands(folder: &Path) -> Outcome {
    let run = |words: &[&str]| -> Result<String, Box<dyn std::error::Error>> {
        let output = Command::new(std::env::current_exe()?).args(words).current_dir(folder).output()?;
        let [said, error] =
            [&output.stdout, &output.stderr].map(|text| String::from_utf8_lossy(text).into_owned());
        if output.status.success() { Ok(said) } else { Err(format!("{words:?}: {said}{error}").into()) }
    };
    std::fs::write(folder.join("case.toml"), CASE)?;
    assert!(run(&["lattice", "6", "sample.spheres"])?.contains("216 spheres"));
    assert!(run(&["pair", "--help"])?.contains("rolling-spring"));
    assert!(run(&["train", "--help"])?.contains("fading-memory"));
    assert!(run(&["run", "--list"])?.contains("biaxial-at-constant-mean"));
    assert!(run(&["measure", "--list"])?.contains("fluctuating_speed"));
    assert!(run(&["schema"])?.contains("rolling_spring_friction"));
    run(&["run", "case.toml", "--packing", "sample.spheres", "--out", "run"])?;
    println!("the commands know the additions");
    campaign(folder, &run)
}

/// The commands of campaigns: their cases name the law, the path and the sensor, and the scheduler is that of this program.
fn campaign(folder: &Path, run: &dyn Fn(&[&str]) -> Result<String, Box<dyn std::error::Error>>) -> Outcome {
    std::fs::write(folder.join("plan.toml"), PLAN)?;
    assert!(run(&["campaign", "--help"])?.contains("this-process"));
    let planned = run(&["campaign", "plan.toml", "--dry-run", "--pilots", "1"])?;
    assert!(planned.starts_with("4 runs"), "{planned}");
    run(&["campaign", "plan.toml", "--out", "local"])?;
    run(&["campaign", "plan.toml", "--out", "study", "--scheduler", "this-process"])?;
    let status = run(&["campaign", "status", "study", "--json"])?;
    assert!(status.contains("\"done\":true") && !status.contains("\"accepted\":false"), "{status}");
    run(&["report", "study"])?;
    run(&["table", "study", "-o", "runs.csv"])?;
    run(&["export", "study", "-o", "states.csv"])?;
    let states = std::fs::read_to_string(folder.join("states.csv"))?;
    let head = states.lines().next().unwrap_or_default();
    let columns =
        ["variable.rolling_spring_friction", "variable.strain", "fluctuating_speed", "rolling_release_loss"];
    for column in columns {
        assert!(head.split(',').any(|name| name == column), "{column} is not in {head}");
    }
    let train =
        ["train", "study", "--input", "contact.rolling_spring_friction", "--output", "fluctuating_speed"];
    run(&[&train[..], &["--coordinate", "arc_length", "--method", "fading-memory", "--out", "surrogate"]]
        .concat())?;
    let data = |name: &str| std::fs::read(folder.join(name).join("dataset/states.parquet"));
    assert_eq!(data("local")?, data("study")?, "the same data, whoever executes the runs");
    println!("campaigns know them, and the scheduler of this program");
    Ok(())
}
