//! `granum bench`, briefly.

mod common;

use common::{json, run, stderr, stdout};

#[test]
fn figures_for_machines_name_law_size_threads_and_instruction_set() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["bench", "--json", "--seconds", "0.01", "--threads", "1,2", "--isa", "portable"];
    let done = run(folder.path(), &[&flags[..], &["--only", "dem", "--law", "hertz,no-slip"]].concat());
    assert!(done.status.success(), "{}", stderr(&done));
    let measured = json(&stdout(&done));
    let dem = measured["dem"].as_array().unwrap();
    assert_eq!(dem.len(), 4, "{measured}");
    for (k, (grains, threads)) in [(5000, 1), (5000, 2), (100_000, 1), (100_000, 2)].into_iter().enumerate() {
        assert_eq!((&dem[k]["grains"], &dem[k]["threads"]), (&grains.into(), &threads.into()));
        assert_eq!((&dem[k]["normal"], &dem[k]["tangential"]), (&"hertz".into(), &"no-slip".into()));
        assert_eq!(dem[k]["isa"], "portable");
        assert!(dem[k]["grain_steps_per_second"].as_f64().unwrap() > 1e3);
        for speed_up in ["speed_up", "arithmetic_speed_up"] {
            let value = dem[k][speed_up].as_f64().unwrap();
            assert!(
                if threads == 1 { value == 1.0 } else { value > 0.0 && value != 1.0 },
                "{speed_up}: {value}"
            );
        }
    }
    assert_eq!(measured["nets"], json("[]"));
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn networks_have_their_figures() {
    let folder = tempfile::tempdir().unwrap();
    let done = run(folder.path(), &["bench", "--json", "--seconds", "0.01", "--only", "nets"]);
    assert!(done.status.success(), "{}", stderr(&done));
    let measured = json(&stdout(&done));
    let nets = measured["nets"].as_array().unwrap();
    assert_eq!(nets.len(), 17);
    for figure in nets {
        assert!(figure["value"].as_f64().unwrap() > 0.0, "{figure}");
        assert!(figure["name"].is_string() && figure["unit"].is_string());
    }
}

#[test]
fn a_packing_of_the_user_is_measured_and_wrong_flags_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let packing = "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=2e-4 yhi=2e-4 zhi=2e-4\nid,x,y,z,radius\n\
                   1,5e-5,5e-5,5e-5,5.1e-5\n2,1.5e-4,5e-5,5e-5,5.1e-5\n";
    std::fs::write(folder.path().join("two.csv"), packing).unwrap();
    let flags = ["bench", "--only", "dem", "--seconds", "0.01", "--threads", "1", "--grains", "2,64"];
    let done = run(folder.path(), &[&flags[..], &["--packing", "two.csv"]].concat());
    assert!(done.status.success(), "{}", stderr(&done));
    let text = stdout(&done);
    assert!(text.contains("M grain-steps/s") && text.contains("mindlin-deresiewicz"), "{text}");
    assert!(text.lines().any(|line| line.split_whitespace().nth(2) == Some("64")), "{text}");
    for (wrong, message) in [
        (&["--threads", "0"][..], "--threads 0: it must be from 1 to 1024"),
        (&["--grains", "5000,100000000000"], "--grains 100000000000: up to 230000.1 GB of memory"),
        (
            &["--isa", "sse"],
            "--isa sse: granum has no such instruction set; choose portable, neon, avx2 or avx512",
        ),
        (&["--grains", "300"], "--grains 300: the packing has 5000 grains"),
        (&["--grains", "12000"], "(here 10000 or 15000)"),
        (&["--grains", "0"], "--grains 0: the packing has 5000 grains"),
        (&["--skip-steps", "5"], "--steps"),
        (&["--steps", "0"], "--steps"),
        (&["--law", "jkr"], "--law jkr: two to four names are needed"),
        (&["--law", "jkr,slippery"], "slippery"),
        (&["--law", "hertz,peeling"], "nothing peels without adhesion"),
        (&["--seconds", "-1"], "--seconds -1"),
        (&["--time-step", "0"], "--time-step 0"),
        (&["--packing", "none.csv"], "none.csv"),
    ] {
        let failed = run(folder.path(), &[&["bench"], wrong].concat());
        assert!(!failed.status.success(), "{wrong:?}");
        assert!(stderr(&failed).contains(message), "{wrong:?}: {}", stderr(&failed));
    }
}

#[test]
fn one_stretch_of_given_steps_is_its_own_mean() {
    let folder = tempfile::tempdir().unwrap();
    let flags = ["bench", "--json", "--only", "dem", "--law", "hertz,no-slip", "--grains", "5000"];
    let steps = ["--threads", "1", "--skip-steps", "20", "--steps", "30"];
    let done = run(folder.path(), &[&flags[..], &steps].concat());
    assert!(done.status.success(), "{}", stderr(&done));
    let figure = &json(&stdout(&done))["dem"][0];
    assert_eq!((&figure["steps"], &figure["grains"]), (&30.into(), &5000.into()));
    assert_eq!(figure["grain_steps_per_second"], figure["mean_grain_steps_per_second"]);
    assert!(figure["arithmetic_speed_up"].is_null(), "{figure}");
    // The speed in the best of several segments is at least the mean speed.
    let done = run(folder.path(), &[&flags[..], &["--threads", "1", "--seconds", "0.05"]].concat());
    let figure = &json(&stdout(&done))["dem"][0];
    let value = |name: &str| figure[name].as_f64().unwrap();
    // For a single segment the two are equal except for rounding.
    let best = value("grain_steps_per_second") * (1.0 + 1e-12);
    assert!(value("mean_grain_steps_per_second") <= best, "{figure}");
}

/// Grains that do not touch are fast and say nothing.
#[test]
fn a_packing_without_load_is_refused_and_the_load_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let packing = |radius: f64| {
        let mut text = String::from(
            "# periodic box, m: xlo=0 ylo=0 zlo=0 xhi=3e-4 yhi=3e-4 zhi=3e-4\nid,x,y,z,radius\n",
        );
        for k in 0..27 {
            let [x, y, z] = [k % 3, k / 3 % 3, k / 9].map(|n| 1e-4 * f64::from(n) + 5e-5);
            text.push_str(&format!("{},{x},{y},{z},{radius}\n", k + 1));
        }
        text
    };
    let flags =
        ["bench", "--json", "--only", "dem", "--seconds", "0.01", "--threads", "1", "--packing", "p.csv"];
    let flags = [&flags[..], &["--grains", "27", "--law", "hertz,no-slip"]].concat();
    std::fs::write(folder.path().join("p.csv"), packing(3e-5)).unwrap();
    let refused = run(folder.path(), &flags);
    let message = stderr(&refused);
    assert!(!refused.status.success() && message.contains("has lost its load"), "{message}");
    assert!(
        message.contains("0.00 contacts a grain") && message.contains("at least 0.5 contacts"),
        "{message}"
    );
    std::fs::write(folder.path().join("p.csv"), packing(5.02e-5)).unwrap();
    let done = run(folder.path(), &flags);
    assert!(done.status.success(), "{}", stderr(&done));
    let figure = &json(&stdout(&done))["dem"][0];
    assert!(figure["contacts_per_grain"].as_f64().unwrap() > 1.5, "{figure}");
    assert!(figure["mean_stress"].as_f64().unwrap() > 1e3, "{figure}");
}
