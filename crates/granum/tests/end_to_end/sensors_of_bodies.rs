//! What is measured on grains of several pieces in every run, and descriptors of shape as inputs of surrogates.

use granum_core::Table;

use crate::{SMALL, done};

/// Columns that only grains of several pieces have: contacts of a pair, forces between bodies, sliding of pairs, fabric of branches, axes, spin
/// and the couple of the contact forces.
const OF_BODIES: &str = "contacts_per_pair pairs_of_one_contact pairs_of_two_contacts pairs_of_three_contacts pairs_of_more_contacts \
    neighbour_coordination_number pairs mean_pair_force mean_square_pair_force tensile_pair_fraction sliding_pair_fraction \
    partly_sliding_pair_fraction pair_fabric_11 pair_fabric_22 pair_fabric_33 pair_fabric_12 pair_fabric_13 pair_fabric_23 \
    deviator_pair_fabric principal_deviator_pair_fabric mean_branch_length long_axis_11 long_axis_22 long_axis_33 long_axis_12 \
    long_axis_13 long_axis_23 deviator_long_axis long_axis_angle long_axis_fraction short_axis_11 short_axis_22 short_axis_33 \
    short_axis_fraction spin spin_along_long_axis spin_across_long_axis rotational_energy stress_asymmetry pair_forces_below \
    pair_forces_above";

const CAPSULES: &str = "[grains.shape]\nkind = \"capsule\"\naspect_ratio = 1.6\n";

fn last(table: &Table, name: &str) -> f64 {
    *table.values(name).unwrap_or_else(|| panic!("no column {name}")).last().unwrap()
}

#[test]
fn runs_of_bodies_have_their_sensors_and_runs_of_spheres_have_none_of_them() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("spheres.toml"), SMALL.replace("count = 150", "count = 60")).unwrap();
    std::fs::write(here.join("bodies.toml"), SMALL.replace("count = 150", "count = 100") + CAPSULES).unwrap();
    for name in ["spheres", "bodies"] {
        done(here, &["run", &format!("{name}.toml"), "--out", name]);
    }
    let table = |name: &str| granum_io::read_table(here.join(name)).unwrap();
    let (spheres, bodies) = (table("spheres/series.parquet"), table("bodies/series.parquet"));
    for name in OF_BODIES.split_whitespace() {
        assert!(last(&bodies, name).is_finite(), "{name}");
        assert!(spheres.values(name).is_none(), "spheres have {name}");
    }
    let of = |name: &str| last(&bodies, name);
    // Means over the observations of a state: only sums of columns agree exactly.
    let numbers = ["one_contact", "two_contacts", "three_contacts", "more_contacts"];
    let shares: f64 = numbers.iter().map(|number| of(&format!("pairs_of_{number}"))).sum();
    assert!((shares - 1.0).abs() < 1e-12, "{shares}");
    assert!((of("contacts") - of("pairs") * of("contacts_per_pair")).abs() < 0.02 * of("contacts"));
    assert!((of("neighbour_coordination_number") - 2.0 * of("pairs") / 100.0).abs() < 1e-9);
    assert!((of("coordination_number") - 2.0 * of("contacts") / 100.0).abs() < 1e-9);
    assert!(of("coordination_number") > 1.1 * of("neighbour_coordination_number"));
    // Bodies of revolution have a long axis, and no short one.
    assert_eq!((of("long_axis_fraction"), of("short_axis_fraction")), (1.0, 0.0));
    for kind in ["fabric", "pair_fabric", "long_axis"] {
        let trace: f64 = (1..=3).map(|axis| of(&format!("{kind}_{axis}{axis}"))).sum();
        assert!((trace - 1.0).abs() < 1e-9, "{kind}: {trace}");
    }
    // The force between two bodies is the sum over their contacts, so that pairs bear more than contacts.
    assert!(of("mean_pair_force") > of("mean_normal_force"));
    assert!(of("stress_asymmetry") < 0.05, "{}", of("stress_asymmetry"));
    let distribution = table("bodies/histograms/pair_forces.parquet");
    assert!(distribution.rows() > bodies.rows());
    assert!(!here.join("spheres/histograms/pair_forces.parquet").exists());
}

#[test]
fn descriptors_of_shape_are_inputs_of_a_surrogate() {
    let base = tempfile::tempdir().unwrap();
    let here = base.path();
    std::fs::write(here.join("case.toml"), SMALL.replace("count = 150", "count = 50") + CAPSULES).unwrap();
    for ratio in ["1.1", "1.5", "2", "2.4"] {
        let shape = format!("grains.shape.aspect_ratio={ratio}");
        done(here, &["run", "case.toml", "--out", ratio, "--set", &shape]);
    }
    let columns = done(here, &["train", "1.1", "2.4", "--columns"]);
    let descriptors = ["elongation", "flatness", "sphericity", "convexity", "roundness"];
    for name in descriptors {
        assert!(columns.contains(&format!("grains.{name}")), "{columns}");
    }
    let learn = "--input grains.elongation,grains.sphericity --output neighbour_coordination_number,stress_ratio \
                 --coordinate deviator_strain --method ridge -o study";
    let words: Vec<&str> = learn.split_whitespace().collect();
    done(here, &[&["train", "1.1", "2", "2.4", "--unseen", "1.5"], &words[..]].concat());
    let surrogate = std::fs::read_to_string(here.join("study/stress_ratio-ridge.json"));
    assert!(surrogate.is_ok_and(|text| text.contains("grains.elongation")));
}
