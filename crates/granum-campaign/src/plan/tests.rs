//! Plans as a user writes them, right and wrong.

use std::path::Path;

use granum_io::{Case, Reading};

use super::*;

const SAND: &str = "[grains]\ncount = 300\n[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\nrolling = 'elastic-plastic'\n\
                    [grains.material]\ninterface_energy = 0\n[preparation]\nmean_stress = '100 kPa'\n\
                    [[stage]]\npath = 'drained-triaxial'\nlateral_stress = '100 kPa'\naxial_strain = 0.1\n";

const SOBOL: &str = "case = 'sand.toml'\n[design]\nkind = 'sobol'\npoints = 16\n";

fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("sand.toml"), SAND).unwrap();
    folder
}

fn read(folder: &Path, text: &str) -> granum_io::Result<PlannedRuns> {
    let file = folder.join("plan.toml");
    std::fs::write(&file, text).unwrap();
    Plan::read(&file, Reading::default())?.runs()
}

fn runs(text: &str) -> PlannedRuns {
    read(folder().path(), text).unwrap_or_else(|error| panic!("{error}"))
}

fn error(text: &str) -> String {
    read(folder().path(), text).unwrap_err().to_string()
}

fn number(run: &PlanRun, name: &str) -> f64 {
    run.values.iter().find(|(own, _)| own == name).unwrap().1.number().unwrap()
}

#[test]
fn ranges_expressions_and_several_keys_give_cases() {
    let text = format!(
        "{SOBOL}seed = 3\n[set]\n'grains.count' = 200\n[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\nfrom = 0.1\n\
         to = 0.8\n[[variable]]\nname = 'pressure'\nkeys = ['preparation.mean_stress', 'stage.1.lateral_stress']\nfrom = '50 kPa'\n\
         to = '400 kPa'\nscale = 'log'\n[[variable]]\nname = 'g'\nfrom = 0\nto = 1\n[[variable]]\nkey = 'preparation.friction'\n\
         name = 'while_prepared'\nexpression = 'g * friction'\n"
    );
    let found = runs(&text);
    assert_eq!((found.runs.len(), found.left_out, found.repeated), (16, 0, 0));
    let base = Case::parse(SAND, "sand.toml").unwrap();
    let mut lower = 0;
    for run in &found.runs {
        let (friction, g) = (number(run, "friction"), number(run, "g"));
        assert!((0.1..0.8).contains(&friction));
        assert_eq!(run.case.grains.material.friction, friction);
        assert_eq!(run.case.grains.count, 200);
        assert_eq!(run.case.preparation.mean_stress, number(run, "pressure"));
        let stress =
            run.case.parameters().into_iter().find(|found| found.key == "stage.1.lateral_stress").unwrap();
        assert_eq!(stress.number(), Some(number(run, "pressure")));
        let prepared = run.case.preparation.friction.unwrap();
        assert!((prepared - g * friction).abs() <= 1e-5 * prepared, "{prepared} {g} {friction}");
        lower += usize::from(number(run, "pressure") < 141_421.0);
        assert_eq!(run.name, run.case.digest()[..12]);
        assert_eq!(apply_settings(&base, &run.settings).unwrap(), run.case);
    }
    assert_eq!(lower, 8, "half of the points are below the geometric mean");
    // A longer sequence begins with the same points.
    let longer = runs(&text.replace("points = 16", "points = 20"));
    assert_eq!(longer.runs[..16], found.runs[..]);
}

#[test]
fn constraints_leave_points_out() {
    let text = format!(
        "constraints = ['rolling < 0.5 * friction']\n{SOBOL}[[variable]]\nname = 'friction'\nkey = 'grains.material.friction'\nfrom = 0.1\n\
         to = 0.8\n[[variable]]\nname = 'rolling'\nkey = 'contact.rolling_friction'\nfrom = 0\nto = 0.4\n"
    );
    let found = runs(&text);
    assert_eq!(found.runs.len(), 16);
    assert!(found.left_out > 4, "{}", found.left_out);
    assert!(found.runs.iter().all(|run| number(run, "rolling") < 0.5 * number(run, "friction")));
    let never = error(&text.replace("0.5 *", "-1 *"));
    assert!(
        never.contains("plan.toml:4:8: of the first 65536 points of the sequence only 0 fulfil"),
        "{never}"
    );
    let hypercube = runs(&text.replace("'sobol'", "'latin-hypercube'"));
    assert_eq!(hypercube.runs.len() + hypercube.left_out, 16);
}

#[test]
fn a_full_factorial_has_all_combinations_and_replicates() {
    let text = "case = 'sand.toml'\n[design]\nkind = 'full-factorial'\nreplicates = 2\n[[variable]]\nkey = 'grains.material.friction'\n\
                from = 0.1\nto = 0.5\nlevels = 3\n[[variable]]\nname = 'density'\nvalues = [{ name = 'dense', set = { \
                'preparation.friction' = 0, preparation.cycles = 5 } }, { name = 'loose', set = { 'preparation.friction' = 0.5 } }]\n\
                [[variable]]\nname = 'law'\nkey = 'contact.rolling'\nvalues = ['elastic-plastic', 'none']\n";
    let found = runs(text);
    assert_eq!(found.runs.len(), 3 * 2 * 2 * 2);
    let first = &found.runs[0];
    assert_eq!((first.case.preparation.friction, first.case.preparation.cycles), (Some(0.0), 5));
    assert_eq!(found.runs[1].case.preparation.seed, first.case.preparation.seed + 1);
    assert_eq!(found.runs[1].values, first.values);
    let frictions: Vec<f64> = found.runs.iter().step_by(8).map(|run| number(run, "friction")).collect();
    assert_eq!(frictions, [0.1, 0.3, 0.5]);
    assert_eq!(found.runs[2].values[2].1, RunValue::Word("none".into()));
    let different = runs(&text.replace("replicates = 2", "sample_seeds = 'different'"));
    let seeds: std::collections::BTreeSet<u64> =
        different.runs.iter().map(|run| run.case.preparation.seed).collect();
    assert_eq!(seeds.len(), 12);
    // Seeds are counted from that of the plan, where it has one.
    for (design, last) in [("replicates = 2", 701), ("sample_seeds = 'different'", 711)] {
        let set = format!("[set]\npreparation.seed = 700\n[design]\n{design}\n");
        let found = runs(&text.replace("[design]\n", &set).replace("replicates = 2\n[[", "[["));
        let seeds: Vec<u64> = found.runs.iter().map(|run| run.case.preparation.seed).collect();
        assert_eq!((seeds.first(), seeds.last()), (Some(&700), Some(&last)), "{design}");
    }
}

#[test]
fn lists_and_csv_files_give_their_rows() {
    let list = "case = 'sand.toml'\n[design]\nkind = 'list'\nrows = [{ mu = 0.2, p = '80 kPa' }, { mu = 0.4, p = '120 kPa' }]\n\
                [[variable]]\nname = 'mu'\nkey = 'grains.material.friction'\n[[variable]]\nname = 'p'\nkey = 'stage.1.lateral_stress'\n";
    let found = runs(list);
    assert_eq!(found.runs.len(), 2);
    assert_eq!((number(&found.runs[1], "mu"), number(&found.runs[1], "p")), (0.4, 120e3));
    let folder = folder();
    std::fs::write(folder.path().join("points.csv"), "mu,p\n0.2,80 kPa\n0.4,120 kPa\n").unwrap();
    let csv = list
        .replace("'list'", "'csv'")
        .replace("rows = [{ mu = 0.2, p = '80 kPa' }, { mu = 0.4, p = '120 kPa' }]", "file = 'points.csv'");
    assert_eq!(read(folder.path(), &csv).unwrap(), found);
    std::fs::write(folder.path().join("points.csv"), "mu,p\n0.2,80 kPa\n0.4,120 kg\n").unwrap();
    let message = read(folder.path(), &csv).unwrap_err().to_string();
    assert!(message.contains("points.csv:3:1: p = 120 kg is a mass"), "{message}");
    std::fs::write(folder.path().join("points.csv"), "mu\n0.2\n").unwrap();
    let message = read(folder.path(), &csv).unwrap_err().to_string();
    assert!(message.contains("points.csv:2:1: the row has no value of p; a row has mu, p"), "{message}");
}

#[test]
fn the_path_of_the_test_can_vary() {
    let text = "case = 'sand.toml'\n[design]\nkind = 'full-factorial'\n[[variable]]\nkey = 'path'\n\
                values = ['drained-triaxial', 'undrained-triaxial']\n[[variable]]\nname = 'strain'\nkey = 'stage.1.axial_strain'\n\
                values = [0.05, 0.1]\n";
    let found = runs(text);
    assert_eq!(found.runs.len(), 4);
    let path =
        |run: &PlanRun| run.case.parameters().into_iter().find(|found| found.key == "stage.1.path").unwrap();
    assert_eq!(
        path(&found.runs[3]).value,
        granum_io::case::ParameterValue::Word("undrained-triaxial".into())
    );
    // The case says nothing of its own that both paths have but the strain, which the plan gives.
    let file = folder();
    std::fs::write(file.path().join("plan.toml"), text).unwrap();
    let plan = Plan::read(&file.path().join("plan.toml"), Reading::default()).unwrap();
    let said = plan.replaced_tests(&plan.runs().unwrap());
    assert_eq!(
        said,
        [
            "path = undrained-triaxial replaces drained-triaxial of the base case; lateral_stress = 100000 of the base case does not"
        ]
    );
    let wrong = error(&text.replace("'undrained-triaxial'", "'undraind-triaxial'"));
    assert!(wrong.contains("is not a path; did you mean undrained-triaxial?"), "{wrong}");
}

/// What the base case gives to its stage stays where the new path has it, with all bits; a test that no path can take over is refused.
#[test]
fn another_path_keeps_the_parameters_that_it_has_in_common() {
    let text = "case = 'sand.toml'\n[design]\nkind = 'full-factorial'\n[[variable]]\nname = 'kind'\n\
                values = [{ name = 'drained', set = { path = 'drained-triaxial' } }, { name = 'undrained', \
                set = { path = 'undrained-triaxial' } }, { name = 'fast', set = { path = 'undrained-triaxial', \
                'stage.1.strain_rate' = '0.1 /s', 'stage.1.states' = 7 } }]\n";
    let saying = |word: &str| text.replace("name = 'kind'", &format!("name = 'kind'\nstage = '{word}'"));
    let stage = "lateral_stress = '100 kPa'\naxial_strain = 0.30000000000000004\ninertial_number = 2e-3\nstates = 30\n";
    let folder = folder();
    let base = SAND.replace("lateral_stress = '100 kPa'\naxial_strain = 0.1\n", stage);
    std::fs::write(folder.path().join("sand.toml"), &base).unwrap();
    let of = |run: &PlanRun, key: &str| {
        run.case
            .parameters()
            .into_iter()
            .find(|found| found.key == format!("stage.1.{key}"))
            .and_then(|found| found.number())
    };
    let found = read(folder.path(), text).unwrap().runs;
    assert_eq!(found[0].case.digest(), Case::parse(&base, "sand.toml").unwrap().digest());
    for (run, states) in found.iter().zip([30.0, 30.0, 7.0]) {
        assert_eq!(of(run, "axial_strain"), Some(0.30000000000000004));
        assert_eq!(of(run, "states"), Some(states));
    }
    assert_eq!(of(&found[1], "inertial_number"), Some(2e-3));
    assert_eq!(of(&found[2], "strain_rate"), Some(0.1));
    assert!(
        found[2].settings.iter().all(|(key, _)| key != "stage.1.inertial_number"),
        "{:?}",
        found[2].settings
    );
    // Only where the plan says so the path has its own parameters alone.
    let new = read(folder.path(), &saying("new")).unwrap().runs;
    assert_ne!(of(&new[1], "axial_strain"), Some(0.30000000000000004));
    let wrong = read(folder.path(), &saying("old")).unwrap_err();
    assert!(wrong.to_string().contains("must be \"kept\" or \"new\""), "{wrong}");
    // A second stage would be lost.
    std::fs::write(folder.path().join("sand.toml"), format!("{base}[[stage]]\npath = 'isotropic'\n"))
        .unwrap();
    let wrong = read(folder.path(), text).unwrap_err().to_string();
    assert!(wrong.contains("all of its 2 stages") && wrong.contains("plan.toml:4"), "{wrong}");
    assert_eq!(read(folder.path(), &saying("new")).unwrap().runs.len(), 3);
}

#[test]
fn mistakes_are_told_with_line_and_values() {
    let variable = "[[variable]]\nkey = 'grains.material.friction'\nfrom = 0.1\nto = 0.8\n";
    let told = |text: &str, wanted: &str| {
        let message = error(text);
        assert!(message.contains(wanted), "{message}\nwanted: {wanted}");
    };
    told(
        &format!("{SOBOL}{}", variable.replace("friction", "frction")),
        "plan.toml:6:7: grains.material.frction is not a key; did you mean",
    );
    told(
        &format!("{SOBOL}{}", variable.replace("0.8", "'50 kPa'")),
        "plan.toml:8:6: to = 50 kPa is a stress",
    );
    told(&format!("{SOBOL}{}", variable.replace("0.1", "0.9")), "from = 0.9 must be below to = 0.8");
    told(
        &format!("{SOBOL}{}", variable.replace("from", "fom")),
        "plan.toml:7:1: \"fom\" is no key of a variable; did you mean from?",
    );
    // One mistake, and not another one wherever the variable is used.
    let misspelt =
        format!("constraints = ['friction < 0.5']\n{SOBOL}{}", variable.replace("material", "materal"));
    told(&misspelt.replace("key", "name = 'friction'\nkey"), "grains.materal.friction is not a key");
    assert!(!error(&misspelt.replace("key", "name = 'friction'\nkey")).contains("neither a variable"));
    told(&SOBOL.replace("sobol", "sobel"), "kind = \"sobel\" is no kind of design; did you mean sobol?");
    told(&SOBOL.replace("sand", "sands"), "plan.toml:1:8: case = \"sands.toml\": there is no file");
    told(&SOBOL.replace("sand", "../sand"), "leads out of the folder");
    told(&SOBOL.replace("points = 16", ""), "sobol needs points");
    told(
        &format!("{SOBOL}[[variable]]\nkey = 'stage.1.lateral_stress'\nfrom = 50\nto = 400\n"),
        "stage.1.lateral_stress = \"50\"",
    );
    told(
        &format!("{SOBOL}{variable}[set]\ngrains.material.friction = 0.3\n"),
        "set by [set] and by a variable",
    );
    told(
        &format!("constraints = ['friktion < 0.5']\n{SOBOL}{variable}"),
        "plan.toml:1:16: friktion is neither a variable",
    );
    told(
        &format!(
            "{SOBOL}[[variable]]\nname = 'a'\nexpression = 'b'\n[[variable]]\nname = 'b'\nexpression = '2 * a'\n"
        ),
        "the expression of a depends on itself",
    );
    told("case = 'sand.toml'\n", "the plan has no design");
    told("[design]\nkind = 'sobol'\n", "the plan names no base case");
    told("case = \n", "this is not TOML");
    told(
        &format!("accept = ['largest_overlpa < 0.05']\n{SOBOL}{variable}"),
        "plan.toml:1:11: accept: largest_overlpa is not a quality check; did you mean largest_overlap?",
    );
    // A corner that no case accepts is refused with its values, before anything runs.
    let corner = format!("{SOBOL}{}", variable.replace("0.8", "30"));
    told(&corner, "plan.toml:5:1: grains.material.friction = ");
    told(&corner, "in the run with friction = ");
    told(&corner, "more runs are refused");
}

#[test]
fn points_that_give_the_same_case_are_run_once() {
    let text = format!("{SOBOL}[[variable]]\nkey = 'grains.count'\nfrom = 100\nto = 103\n");
    let found = runs(&text);
    assert!(found.runs.len() <= 4 && found.runs.len() + found.repeated == 16, "{}", found.runs.len());
    assert!(found.runs.iter().all(|run| number(run, "count").fract() == 0.0));
}
