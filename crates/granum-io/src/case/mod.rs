//! The case file (TOML): everything that determines a result.
//!
//! [`fields`] is the only list of keys with their bounds; reading, writing, the template of `granum init` and the
//! digests are all based on it. A new key is one entry in this list. The tables `[[stage]]` and `[[preparation.stage]]` are not
//! part of it, since named paths declare their own parameters ([`granum_dem::loading::preset`]); the tables `[[material]]` and `[[pair]]` use keys of the list.

mod bare_number;
mod bond;
mod case_stage;
mod case_test;
mod definition;
mod densities;
mod difference;
mod digest;
pub(crate) mod doubt;
mod field;
mod field_text;
mod fields;
mod history;
mod incremental_driver;
mod material;
mod material_read;
mod material_table;
mod parameters;
mod path_exchange;
mod read;
mod reader;
mod reading;
mod rules;
mod schema;
mod sensor_parameters;
mod shape;
mod shape_read;
mod shape_table;
mod shape_value;
mod sieve;
mod stage;
mod stage_control;
mod stage_read;
mod stage_values;
mod stage_write;
mod stresses;
mod suggestion;
mod test_definition;
mod test_of_case;
mod unit;
mod value_list;
mod vocabulary;
mod write;

pub use bare_number::SetKey;
pub use bond::CaseBond;
pub use case_stage::CaseStage;
pub use case_test::CaseTest;
pub use definition::Case;
pub use difference::{CaseValues, Difference, SEED, differences};
pub use digest::decides_sample;
pub use field::{Field, Value};
pub use fields::{Fields, field};
pub use parameters::{CaseParameter, ParameterValue};
pub use path_exchange::PathExchange;
pub use reading::Reading;
pub use stage_values::{CRITICAL_STRESS_RATIO, CRITICAL_VOLUMETRIC_STRAIN, CRITICAL_WINDOW};
pub use test_definition::TestDefinition;
pub use value_list::{ValueShape, values_in};
pub use vocabulary::Vocabulary;

/// Keys that are not used in a run whose sample is made from a packing: its grains replace the random insertion.
pub const UNUSED_WITH_PACKING: [&str; 9] = [
    "grains.count",
    "grains.diameter",
    "grains.spread",
    "grains.distribution",
    "grains.smallest",
    "grains.largest",
    "grains.sieve_curve",
    "preparation.seed",
    "preparation.initial_solid_fraction",
];

impl Case {
    /// Keys that have no part in a run of this case whose sample is made of a packing: [`UNUSED_WITH_PACKING`], but for the seed
    /// where it says which grain is of which material.
    pub fn unused_with_packing(&self) -> impl Iterator<Item = &'static str> + use<> {
        let drawn = !self.grains.mixture.is_empty();
        UNUSED_WITH_PACKING.into_iter().filter(move |key| !(drawn && *key == SEED))
    }
}

#[cfg(test)]
mod bare_number_tests;
#[cfg(test)]
mod material_tests;
#[cfg(test)]
mod preparation_stage_tests;
#[cfg(test)]
mod shape_tests;
#[cfg(test)]
mod stage_tests;
#[cfg(test)]
mod tests {
    use super::fields::RENAMED;
    use super::*;
    use granum_dem::config::Rate;
    use proptest::prelude::*;

    fn parse(text: &str) -> Case {
        Case::parse(text, "case.toml").unwrap_or_else(|error| panic!("{error}\n{text}"))
    }

    #[test]
    fn an_empty_file_is_the_paper() {
        assert_eq!(parse(""), Case::default());
    }

    #[test]
    fn the_template_teaches_every_key_and_is_the_default() {
        let template = Case::template();
        assert_eq!(parse(&template), Case::default());
        for field in Fields::standard().iter() {
            assert!(template.contains(&format!("{} = ", field.key)), "{} is not in the template", field.key);
        }
    }

    #[test]
    fn every_number_of_the_configuration_has_a_field() {
        fn leaves(value: &serde_json::Value, path: &str, into: &mut Vec<String>) {
            match value {
                serde_json::Value::Object(map) => {
                    for (key, value) in map {
                        let inner = if path.is_empty() { key.clone() } else { format!("{path}.{key}") };
                        leaves(value, &inner, into);
                    }
                }
                _ => into.push(path.to_string()),
            }
        }
        let mut paths = Vec::new();
        leaves(&serde_json::to_value(Case::default()).unwrap(), "", &mut paths);
        for path in paths {
            let path = path.replace("shear.rate.inertial-number", "shear.inertial_number");
            assert!(
                field(&path).is_some(),
                "{path} is in granum_dem::config, but is no key of the case file"
            );
        }
    }

    #[test]
    fn examples_and_bounds_of_every_field_are_valid() {
        for field in Fields::standard().iter() {
            let mut case = Case::default();
            if field.key == "density_scaling" {
                case.set("shear.strain_rate", "1e-5 /s").unwrap();
            }
            case.set(&field.path(), &field.example).unwrap_or_else(|error| panic!("{error}"));
        }
    }

    fn rate(case: &Case) -> Rate {
        case.test.shear().unwrap().rate
    }

    #[test]
    fn the_paper_rate_is_said_either_way() {
        let case = parse("[shear]\nstrain_rate = \"1e-5 /s\"\ndensity_scaling = 1e12\n");
        assert_eq!(rate(&case), Rate::StrainRate { strain_rate: 1e-5, density_scaling: 1e12 });
        let case = parse("[shear]\ninertial_number = 1e-3\n");
        assert_eq!(rate(&case), Rate::InertialNumber(1e-3));
        let case = parse("[shear]\nstrain_rate = 2\n");
        assert_eq!(rate(&case), Rate::StrainRate { strain_rate: 2.0, density_scaling: 1.0 });
    }

    #[test]
    fn states_are_spaced_as_the_case_says() {
        use granum_dem::config::Spacing;
        assert_eq!(parse("[recording]\nfirst_strain = \"none\"\nstrains = \"none\"\n"), Case::default());
        let geometric = parse("[recording]\nfirst_strain = 1e-5\n");
        assert_eq!(geometric.recording.spacing, Spacing::Geometric(1e-5));
        let listed = parse("[recording]\nstrains = [1e-5, \"0.1 %\", 0.2,]\nsnapshots = [0.1]\n");
        assert_eq!(listed.recording.spacing, Spacing::Strains(vec![1e-5, 1e-3, 0.2]));
        assert_eq!(listed.recording.snapshots, [0.1]);
        for case in [&geometric, &listed] {
            assert_eq!(&parse(&case.resolved_toml()), case);
            assert_ne!(case.digest(), Case::default().digest());
            assert_eq!(case.preparation_digest(), Case::default().preparation_digest());
        }
        let mut case = Case::default();
        for text in ["[1e-5, 1e-3, 0.2]", "1e-5,1e-3,0.2", "[\"1e-5\", 1e-3, 0.2, ]"] {
            case.set("recording.strains", text).unwrap();
            assert_eq!(case.recording.spacing, listed.recording.spacing, "{text}");
        }
        let error = case.set("recording.strains", "0.1,0.05").unwrap_err().to_string();
        assert!(error.contains("value 2 (\"0.05\") is not greater than the one before"), "{error}");
        case.set("recording.strains", "none").unwrap();
        assert_eq!(case, Case::default());
    }

    #[test]
    fn laws_own_their_keys() {
        let text = "[contact]\nrolling = \"elastic-plastic\"\nrolling_friction = 0.2\n";
        let case = parse(text);
        assert_eq!(case.contact.rolling.name(), "elastic-plastic");
        assert_eq!(case.contact.parameters.given("rolling_friction"), Some(0.2));
        assert_eq!(&parse(&case.resolved_toml()).digest(), &case.digest());
        assert!(
            case.resolved_toml().contains("rolling_friction = 0.2")
                && case.digest() != Case::default().digest()
        );
        // Writing out a default gives the same case.
        let written = parse("[contact]\nrolling = \"elastic-plastic\"\nrolling_friction = 0.1\n");
        let left_out = parse("[contact]\nrolling = \"elastic-plastic\"\n");
        assert_eq!(written.digest(), left_out.digest());
        let stiff = parse(
            "[contact]\nnormal = \"hooke\"\ntangential = \"no-slip\"\nnormal_stiffness = \"20 kN/m\"\n",
        );
        assert_eq!(stiff.contact.parameters.given("normal_stiffness"), Some(2e4));
        let mut set = Case::default();
        set.set("contact.rolling_friction", "0.2").unwrap();
        assert!(set.check().unwrap_err().to_string().contains("contact.rolling_friction has no effect with"));
        set.set("contact.rolling", "elastic-plastic").unwrap();
        set.check().unwrap();
        assert_eq!(set.digest(), case.digest());
    }

    #[test]
    fn keys_of_laws_are_refused_where_they_mean_nothing() {
        let message = |text: &str| Case::parse(text, "case.toml").unwrap_err().to_string();
        let unused = message("[contact]\nrolling_friction = 0.2\n");
        assert!(unused.contains("case.toml:2:1: contact.rolling_friction has no effect with"), "{unused}");
        let area = message("[contact]\ntangential = \"no-slip\"\ntangential_stiffness_ratio = 0.5\n");
        assert!(area.contains("case.toml:3:1: contact.tangential_stiffness_ratio has no effect"), "{area}");
        let bounds = message("[contact]\nrolling = \"elastic-plastic\"\nrolling_friction = 3\n");
        assert!(
            bounds.contains("contact.rolling_friction = 3 is out of bounds; it must be from 0 to 2"),
            "{bounds}"
        );
        let unit = message("[contact]\nnormal = \"hooke\"\nnormal_stiffness = \"1 MPa\"\n");
        assert!(unit.contains("is a stress; it must be a"), "{unit}");
        let apart = message("[contact]\nnormal = \"hooke\"\n");
        assert!(
            apart.contains("contact.tangential = \"mindlin-deresiewicz\" needs a normal law with"),
            "{apart}"
        );
        let unknown = message("[contact]\nnormal = \"hook\"\n");
        assert!(unknown.contains("must be \"hertz\", \"jkr\", \"hooke\","), "{unknown}");
    }

    /// The reference chapter of the book lists every key of the contact laws with its help text.
    #[test]
    fn the_book_lists_the_keys_of_laws() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/src/case.md");
        let book = std::fs::read_to_string(path).unwrap();
        for field in Fields::standard().iter().filter(|field| field.section == "contact") {
            let row = book.lines().find(|line| line.starts_with(&format!("| `{}` | `", field.key)));
            assert!(row.is_some(), "docs/src/case.md has no row of {}", field.path());
            assert!(
                book.lines()
                    .any(|line| line.starts_with(&format!("| `{}` |", field.key))
                        && line.contains(&field.help)),
                "docs/src/case.md has another help for {}: {}",
                field.path(),
                field.help
            );
        }
    }

    /// Published digests: a new key must not change them where it is not in use.
    #[test]
    fn the_digest_of_the_default_case_stays() {
        let whole = "c533b7cdb3edf215fdbefd56a92fd863819ef0168e388b8eeefd6d917d809e5d";
        assert_eq!(Case::default().digest(), whole);
        let preparation = "71b668edeaab91207393af95b99c0fecdf376c3196ca1fac8bfcf746b4be1b5f";
        assert_eq!(Case::default().preparation_digest(), preparation);
    }

    /// A parameter that a law received later does not change the digest of a case in which it has its default.
    #[test]
    fn the_digest_of_a_case_with_bridges_stays() {
        let text = "[grains]\ncount = 60\n[grains.material]\ninterface_energy = 0\n[contact]\nnormal = \"hertz\"\n\
                    tangential = \"no-slip\"\nadhesion = \"capillary-bridge\"\nbridge_volume = 1e-3\n\
                    [preparation]\nsolid_fraction = \"none\"\n[shear]\ndeviator_strain = 1e-3\n\
                    inertial_number = 3e-2\n[recording]\nstates = 2\n";
        let mut case = parse(text);
        let digest = "7b42e0dbdf0438ed964a5bff976efbf51638ebb0015038faa38032eaf0845767";
        assert_eq!(case.digest(), digest);
        case.set("contact.rupture_coefficient", "0.1").unwrap();
        assert_eq!(case.digest(), digest);
        case.set("contact.rupture_coefficient", "0").unwrap();
        assert_ne!(case.digest(), digest);
    }

    #[test]
    fn a_packing_is_part_of_the_digests() {
        let case = Case::default();
        let digests = [None, Some("aa"), Some("bb")].map(|packing| case.digest_with(packing));
        assert!(digests[0] == case.digest() && digests[0] != digests[1] && digests[1] != digests[2]);
        let digests = [None, Some("aa"), Some("bb")].map(|packing| case.preparation_digest_with(packing));
        assert!(
            digests[0] == case.preparation_digest() && digests[0] != digests[1] && digests[1] != digests[2]
        );
    }

    #[test]
    fn a_key_that_was_renamed_is_refused_with_its_new_name() {
        for [old, new] in RENAMED {
            assert!(field(old).is_none() && field(new).is_some());
            let (section, key) = old.rsplit_once('.').unwrap();
            let text = format!("[{section}]\n{key} = 20\n");
            let error = Case::parse(&text, "case.toml").unwrap_err().to_string();
            assert!(error.contains(&format!("case.toml:2:1: {old} is now called {new}")), "{error}");
            let error = Case::default().set(old, "20").unwrap_err().to_string();
            assert!(error.contains(&format!("is now called {new}")), "{error}");
        }
    }

    #[test]
    fn keywords_mean_absence() {
        let case = parse(
            "[preparation]\nsolid_fraction = \"none\"\nfriction = 0.1\n[shear]\nmean_stress = \"sample\"\n",
        );
        assert_eq!(case.preparation.solid_fraction, None);
        assert_eq!(case.preparation.friction, Some(0.1));
        assert_eq!(case.test.shear().unwrap().mean_stress, None);
    }

    #[test]
    fn digests_see_physics_and_nothing_else() {
        let paper = Case::default();
        assert_eq!(parse("# a comment\n[grains]\ndiameter = 1e-4\n").digest(), paper.digest());
        let sheared = paper.clone().with_shear(|shear| shear.deviator_strain = 0.2);
        assert_ne!(sheared.digest(), paper.digest());
        assert_eq!(sheared.preparation_digest(), paper.preparation_digest());
        let mut reseeded = paper.clone();
        reseeded.preparation.seed = 2;
        assert_ne!(reseeded.preparation_digest(), paper.preparation_digest());
        assert_ne!(paper.digest(), paper.preparation_digest());
    }

    #[test]
    fn set_names_the_key_and_what_would_be_right() {
        let mut case = Case::default();
        case.set("grains.material.youngs_modulus", "10 GPa").unwrap();
        assert_eq!(case.grains.material.youngs_modulus, 10e9);
        let error = case.set("grains.material.youngs_modulus", "70 kg").unwrap_err().to_string();
        assert!(error.contains("is a mass; it must be a stress"), "{error}");
        assert!(case.set("shear.density_scaling", "2").is_err());
        assert!(
            case.set("grains.diametre", "2")
                .unwrap_err()
                .to_string()
                .contains("did you mean grains.diameter?")
        );
        assert_eq!(case.grains.material.youngs_modulus, 10e9);
    }

    /// Takes back what random values hardly ever have in common.
    fn mend(case: &mut Case) {
        let has_mean = case.grains.sizes.distribution.distribution().description().has_mean;
        if !has_mean || case.grains.check_sizes().is_err() {
            case.grains.sizes = Default::default();
        }
        // Random sand takes a second to make, and is written as every other family.
        let slow = case.grains.shapes.iter().any(|entry| entry.kind.name() == "sand");
        if slow || case.grains.check_shapes().is_err() {
            case.grains.shapes = Vec::new();
        }
        let p = &mut case.preparation;
        if case.grains.are_spheres() {
            p.bedding = None;
        }
        if p.densest_void_ratio.zip(p.loosest_void_ratio).is_none_or(|(dense, loose)| dense >= loose) {
            (p.relative_density, p.densest_void_ratio, p.loosest_void_ratio) = (None, None, None);
        }
        if case.contact.adhesion.name() != "none" {
            p.interface_energy = 0.0;
        }
    }

    /// A random value within the bounds of each field; rules between fields may still reject the case.
    fn any_case() -> impl Strategy<Value = Case> {
        (proptest::collection::vec(0.0..=1.0f64, Fields::standard().iter().len()), any::<bool>())
            .prop_filter_map("rules between fields", |(draws, by_rate)| {
                let mut case = Case::default();
                for (field, draw) in Fields::standard().iter().zip(draws) {
                    let of_rate = matches!(field.key, "strain_rate" | "density_scaling");
                    let of_inertia = field.section == "shear" && field.key == "inertial_number";
                    // A parameter of laws that were not drawn is not a part of the case.
                    let of_one_kind = field.is_of_law()
                        || field.is_of_sizes()
                        || field.is_of_shapes()
                        || field.is_spheres();
                    let of_other_law = of_one_kind && field.value(&case).is_none();
                    if of_other_law || (of_rate && !by_rate) || (of_inertia && by_rate) {
                        continue;
                    }
                    field.apply(&mut case, field.draw(draw));
                }
                mend(&mut case);
                case.check().is_ok().then_some(case)
            })
    }

    proptest! {
        #[test]
        fn the_resolved_case_reads_back_as_the_same_case(case in any_case()) {
            let text = case.resolved_toml();
            let back = parse(&text);
            prop_assert_eq!(&back, &case);
            prop_assert_eq!(back.digest(), case.digest());
        }

        #[test]
        fn no_text_makes_the_reader_panic(text in "(\\[[a-z.]{0,12}\\]|[a-z_]{1,9} ?= ?(\"[ -~]{0,9}\"|[0-9e.+_-]{1,6}|\\[1\\])|\n|\\PC){0,12}") {
            let _ = Case::parse(&text, "case.toml");
        }
    }
}
