//! Comparisons of many runs with many tests of a laboratory.

use crate::{done, done_json, refused};

const SAND: &str = "[grains]\ncount = 80\n[grains.material]\ninterface_energy = 0\n[preparation]\nmean_stress = '100 kPa'\nfriction = 0.1\n\
                    solid_fraction = 'none'\ninertial_number = 1e-2\nunbalanced_force = 5e-2\n[[stage]]\npath = 'drained-triaxial'\n\
                    lateral_stress = '100 kPa'\naxial_strain = 0.03\ninertial_number = 1e-2\nstates = 12\n";

#[test]
fn runs_are_compared_with_the_tests_at_their_stress_and_summarised_as_these_are() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("sand.toml"), SAND).unwrap();
    for (name, seed) in [("runs/one", "1"), ("runs/two", "2")] {
        std::fs::create_dir_all(here.join("runs")).unwrap();
        done(here, &["run", "sand.toml", "--out", name, "--set", &format!("preparation.seed={seed}")]);
    }
    let header = "axial_strain (%),volumetric_strain (%),deviator_stress (kPa),mean_stress (kPa)";
    let row =
        |p: f64, k: f64| format!("{},{},{},{}\n", 0.25 * k, -0.1 * k, p * k / 10.0, p * (1.0 + k / 30.0));
    let rows = |p: f64| (0..=10).map(|k| row(p, f64::from(k))).collect::<Vec<_>>();
    let named = |name: &str, p: f64| rows(p).iter().map(|row| format!("{name},{row}")).collect::<String>();
    let several: String =
        [("T1", 100.0), ("T2", 200.0), ("T3", 300.0)].map(|(name, p)| named(name, p)).concat();
    std::fs::write(here.join("several.csv"), format!("test,{header}\n{several}")).unwrap();
    std::fs::write(here.join("alone.csv"), format!("{header}\n{}", rows(101.0).concat())).unwrap();
    let message = refused(here, 1, &["compare", "runs", "several.csv", "alone.csv"]);
    assert!(message.contains("there are 4 tests") && message.contains("--test all"), "{message}");
    let command = [
        "compare",
        "runs",
        "several.csv",
        "alone.csv",
        "--test",
        "all",
        "--same-stress",
        "--summary",
        "summary.csv",
        "--residuals",
        "residuals.csv",
    ];
    let found = done_json(here, &command);
    // Two runs, each with the two tests at its stress.
    let pairs = found["comparisons"].as_array().unwrap();
    assert_eq!(pairs.len(), 4, "{found:#}");
    assert!(pairs.iter().all(|pair| pair["test"] == "T1" || pair["test"] == "alone"), "{found:#}");
    let summary = found["summary"].as_array().unwrap();
    assert_eq!(summary.len(), 6, "{found:#}");
    // q = 100 kPa at p = 133 kPa and a lateral stress of 100 kPa: sin phi = 1/3; D = 0.4: sin psi = 1/6 of strains over the initial
    // length, a little less of logarithmic ones, as is the modulus.
    let number = |key: &str| summary[0][key].as_f64().unwrap();
    assert!((number("peak_friction_angle") - 19.4712).abs() < 1e-3, "{found:#}");
    assert!((number("largest_dilatancy_angle") - 9.5941).abs() < 0.3, "{found:#}");
    assert!((number("secant_modulus_50") / 4e6 - 0.994).abs() < 2e-3, "{found:#}");
    assert!(summary[5]["peak_friction_angle"].as_f64().unwrap() > 5.0, "{found:#}");
    // A run has one strength in all tables, also where it goes farther than the tests.
    let strength = found["strength"].as_array().unwrap();
    let table = done_json(here, &["table", "runs"]);
    for k in 0..2 {
        let measures =
            granum_io::Run::at(here.join("runs").join(["one", "two"][k])).unwrap().record().unwrap().measures;
        for key in
            ["peak_friction_angle", "critical_friction_angle", "largest_dilatancy_angle", "secant_modulus_50"]
        {
            let Some(value) = measures.get(key) else { continue };
            for (row, place) in
                [(&summary[4 + k], "summary"), (&strength[k], "strength"), (&table["runs"][k], "table")]
            {
                assert!((row[key].as_f64().unwrap() / value - 1.0).abs() < 1e-9, "{key} in {place}: {row:#}");
            }
        }
    }
    let table = std::fs::read_to_string(here.join("residuals.csv")).unwrap();
    assert!(table.starts_with("run,test,axial_strain") && table.lines().count() > 40, "{table}");
    assert!(std::fs::read_to_string(here.join("summary.csv")).unwrap().lines().count() == 7);
    let drawn = std::fs::read_to_string(here.join("compare.svg")).unwrap();
    assert!(drawn.contains("1 repetition<"), "the two runs differ in their seeds alone");
    let message =
        refused(here, 1, &["compare", "runs", "several.csv", "--test", "T2", "--same-stress", "--force"]);
    assert!(message.contains("no run begins at the mean stress"), "{message}");
    let message = refused(here, 1, &["compare", "alone.csv", "--force"]);
    assert!(message.contains("give runs before"), "{message}");
}
