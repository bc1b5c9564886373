//! Decks with bonds: their text, and what is refused. That LAMMPS runs them and finds granum's curve is a test of the program.

use granum_core::assembly::{Assembly, Rigid, Sphere};
use granum_dem::bond::{BondKind, BondLaw, BondShape, BondStiffness, Eight, LIMITS};
use granum_dem::contact::{LawDescription, LawParameter};
use granum_io::case::{Reading, Vocabulary};
use granum_io::{Case, Packing};

use super::bonds::{check_sample, checked};
use super::tests::packing;
use super::{Confinement, LammpsDeck};

const HEAD: &str =
    "[grains.material]\ninterface_energy = 0\n[contact]\nnormal = 'hertz'\ntangential = 'no-slip'\n";
const STAGE: &str = "[[stage]]\npath = 'drained-triaxial'\naxial_strain = 0.05\n";
const BOND: &str = "law = 'additive'\nmodulus = '1 GPa'\ntensile_strength = '3 MPa'\ncohesion = '2 MPa'\n";

fn case(bond: &str, stages: &str) -> Case {
    Case::parse(&format!("{HEAD}[[bond]]\n{bond}{stages}"), "case.toml").unwrap()
}

fn deck(case: &Case, packing: &Packing) -> Result<LammpsDeck, String> {
    LammpsDeck::new(case, packing, Confinement::Own).map_err(|error| error.to_string())
}

/// The folder of a deck: script, sample and coefficients.
fn written(case: &Case) -> [String; 3] {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck");
    deck(case, &packing()).unwrap().write(&path, false).unwrap();
    ["in.granum", "packing.data", "bonds.txt"].map(|name| std::fs::read_to_string(path.join(name)).unwrap())
}

#[test]
fn bonds_are_in_the_sample_and_are_made_where_the_test_begins() {
    let [script, sample, coefficients] = written(&case(BOND, STAGE));
    // All 81 contacts of the lattice are alike: r_b = 25 um, l = 0.1 mm.
    assert!(
        sample.contains("\n81 bonds\n1 bond types\n") && sample.contains("\nAtoms # bpm/sphere\n"),
        "{sample}"
    );
    let words: Vec<&str> = coefficients.split_whitespace().collect();
    assert_eq!(words[..2], ["bond_coeff", "1"]);
    let golden = [
        1.963_495_408_5e4,
        7.853_981_634e3,
        2.454_369_260_6e-6,
        3.067_961_575_8e-6,
        5.890_486_225_5e-3,
        3.926_990_817e-3,
        4.908_738_521_2e-8,
        3.681_553_890_9e-8,
    ];
    for (word, golden) in words[2..].iter().zip(golden) {
        let found: f64 = word.parse().unwrap();
        assert!((found / golden - 1.0).abs() < 1e-9, "{found} {golden}");
    }
    assert_eq!(words[10..], ["0.0"; 4], "a bond without dashpots");
    let order = [
        "# Needs LAMMPS of 2025 or newer with the packages GRANULAR and BPM",
        "\natom_style bpm/sphere\n",
        "\nspecial_bonds lj 1 1 1 coul 1 1 1\nread_data packing.data\n",
        "\nbond_style zero nocoeff\nbond_coeff *\ncomm_modify cutoff 0.000151",
        "\nfix move all nve/bpm/sphere\n",
        "\ncompute stress all pressure NULL pair bond\n",
        "\ncompute held all nbond/atom\n",
        "print \"stage 0: rest\"",
        "\nbond_style bpm/rotational overlay/pair yes smooth no\ninclude bonds.txt\n",
        "\nset group all quat 0 0 1 0\nvariable made equal 1\nrun 0 post no\n",
        "print \"stage 1: shear\"",
    ];
    let places = order.map(|text| script.find(text).unwrap_or_else(|| panic!("{text} in {script}")));
    assert!(places.is_sorted(), "{places:?}");
    assert!(script.contains(",mechanical_coordination_number,bonds\" file ${out}"), "{script}");
    assert!(script.contains("*v_bonds\n"), "{script}");
    // Dashpots of newer versions: the coefficient of damping is lower by the root of two, the restitution higher.
    let plain = Case::parse(&format!("{HEAD}{STAGE}"), "case.toml").unwrap();
    let plain = deck(&plain, &packing()).unwrap().script().to_string();
    assert!(!plain.contains("bond") && !plain.contains("bpm"), "{plain}");
    let restitution = |script: &str| -> f64 {
        let line = script.lines().find(|line| line.starts_with("pair_coeff")).unwrap();
        line.split(' ').nth(5).unwrap().parse().unwrap()
    };
    assert!((restitution(&plain) - 0.6104).abs() < 1e-4);
    assert!((restitution(&script) - 0.7047).abs() < 2e-2 && restitution(&script) > restitution(&plain));
}

/// Dashpots as LAMMPS has them: those of the couples are doubled, that of bending over the distance of the centres.
#[test]
fn dashpots_and_strengths_without_limit_are_written() {
    let [_, sample, coefficients] = written(&case("law = 'beam'\ndamping = 0.2\n", STAGE));
    assert!(sample.contains("\n81 bonds\n1 bond types\n"), "{sample}");
    let numbers: Vec<f64> =
        coefficients.split_whitespace().skip(2).map(|word| word.parse().unwrap()).collect();
    let [normal, shear, twisting, bending] = [0, 1, 2, 3].map(|k| numbers[k]);
    assert!(shear < 7.8e3, "a beam is softer in shear: {shear}");
    // It would rupture at a stretch of a metre.
    assert_eq!(numbers[4..8], [normal, 1e300, 1e300, 1e300]);
    let density = 2650.0;
    let mass = density * 4.0 / 3.0 * std::f64::consts::PI * 5e-5f64.powi(3);
    let (reduced, moment) = (0.5 * mass, 0.5 * 0.4 * mass * 5e-5f64.powi(2));
    let length = 1e-4 - 8.5e-9;
    let golden = [
        0.4 * (reduced * normal).sqrt(),
        0.4 * (reduced * shear).sqrt(),
        0.8 * (moment * bending).sqrt() / length,
        0.8 * (moment * twisting).sqrt(),
    ];
    for (found, golden) in numbers[8..].iter().zip(golden) {
        assert!((found / golden - 1.0).abs() < 1e-6, "{found} {golden}");
    }
}

/// Strengths that scatter are types of their own; a first stage that settles has a rest before it, in which there are no bonds.
#[test]
fn each_strength_is_a_type_and_bonds_wait_for_rest() {
    let scattered = format!("{BOND}scatter = 'weibull'\nleft_out = 0.2\n");
    let consolidated = "[[stage]]\npath = 'drained-triaxial'\nlateral_stress = '50 kPa'\n";
    let [script, sample, coefficients] = written(&case(&scattered, consolidated));
    let count = coefficients.lines().count();
    assert!(count > 40 && count < 81, "{count}");
    assert!(sample.contains(&format!("\n{count} bonds\n{count} bond types\n")));
    let [rest, made, first] =
        ["stage 0: rest", "\nbond_style bpm", "print \"stage 1"].map(|text| script.find(text).unwrap());
    assert!(rest < made && made < first, "{script}");
}

#[test]
fn bonds_that_lammps_has_not_are_refused_by_name() {
    let refused = |bond: &str, stages: &str| deck(&case(bond, stages), &packing()).unwrap_err();
    let error = refused("tensile_strength = '3 MPa'\n", STAGE);
    assert!(error.contains("bond.law = \"parallel\" cannot be written for LAMMPS: table 1"), "{error}");
    assert!(error.contains("take law = \"additive\""), "{error}");
    let error = refused("law = 'beam'\ncohesion = '3 MPa'\n", STAGE);
    assert!(error.contains("bond.law = \"beam\""), "{error}");
    let error = refused(&format!("{BOND}before_stage = 2\n"), &format!("{STAGE}{STAGE}"));
    assert!(error.contains("bond.before_stage = 2") && error.contains("make them before stage 1"), "{error}");
    let error = refused(&format!("{BOND}places = 'file'\n"), STAGE);
    assert!(error.contains("places = \"file\" takes the pairs that a packing lists as bonded"), "{error}");
    // Without strengths the rule of rupture is the same.
    assert!(deck(&case("law = 'parallel'\n", STAGE), &packing()).is_ok());
}

#[test]
fn agglomerates_are_refused() {
    let text =
        format!("{HEAD}[grains.shape]\nkind = 'agglomerate'\n[[bond]]\n{BOND}places = 'inside'\n{STAGE}");
    let error = checked(&Case::parse(&text, "case.toml").unwrap()).unwrap_err().to_string();
    assert!(
        error.contains("bond.places = \"inside\"") && error.contains("the grains are rigid until"),
        "{error}"
    );
}

/// A law of a program.
#[derive(Debug)]
struct Thread;

impl BondLaw for Thread {
    fn description(&self) -> &'static LawDescription {
        const PARAMETERS: &[LawParameter] = &[];
        const { &LawDescription::new("thread", "thread", "a thread", PARAMETERS) }
    }
    fn stiffness(&self, _: &BondShape, _: &[f64]) -> BondStiffness {
        BondStiffness { normal: 1.0, ..BondStiffness::default() }
    }
    fn limits(&self, _: &BondShape, _: &[f64], _: f64) -> [f64; LIMITS] {
        [0.0; LIMITS]
    }
    fn utilisation(&self, _: &granum_dem::bond::BondLoads, _: &[Eight; LIMITS]) -> [Eight; 2] {
        [[0.0; 8]; 2]
    }
}

#[test]
fn a_law_of_a_program_is_refused() {
    let vocabulary = Vocabulary::default().with_bond_law(BondKind::new(&Thread)).unwrap();
    let reading = Reading::default().with_vocabulary(&vocabulary);
    let case =
        Case::parse_as(&format!("{HEAD}[[bond]]\nlaw = 'thread'\n{STAGE}"), "case.toml", reading).unwrap();
    let error = checked(&case).unwrap_err().to_string();
    assert!(error.contains("bond.law = \"thread\"") && error.contains("LAMMPS has no such law"), "{error}");
}

#[test]
fn samples_that_lammps_would_bond_otherwise_are_refused() {
    // One larger grain; attached halfway it can be.
    let mut uneven = packing();
    uneven.grains[4].radius *= 1.01;
    let error = deck(&case(BOND, STAGE), &uneven).unwrap_err();
    assert!(error.contains("the bonded grains ") && error.contains(" have the radii "), "{error}");
    assert!(error.contains("attachment = \"middle\""), "{error}");
    assert!(deck(&case(&format!("{BOND}attachment = 'middle'\n"), STAGE), &uneven).is_ok());
    // A cell of two grains in x, each bonded with two images of the other.
    let mut narrow = packing();
    let edge = narrow.cell[0][0] / 3.0;
    narrow.cell[0][0] = 2.0 * edge;
    narrow.grains.retain(|grain| grain.position[0] < 2.0 * edge);
    let error = deck(&case(BOND, STAGE), &narrow).unwrap_err();
    assert!(error.contains("LAMMPS bonds nearest images") && error.contains("take more grains"), "{error}");
    let mut assembly = Assembly::default().with_spheres([Sphere::default()]);
    assembly.rigid = vec![Rigid { orientation: [1.0, 0.0, 0.0, 0.0], inertia: [1.0; 3] }];
    let error = check_sample(&assembly, &[]).unwrap_err().to_string();
    assert!(error.contains("some of its grains have several pieces"), "{error}");
}

/// A run that a program follows is refused before anything begins, and where its deck would be made.
#[test]
fn the_engine_refuses_bonds() {
    let case = case(BOND, STAGE);
    for error in [
        LammpsDeck::check(&case).unwrap_err(),
        LammpsDeck::followed(&case, &packing(), Confinement::Own).unwrap_err(),
    ] {
        let error = error.to_string();
        assert!(
            error.contains("bond = 1 tables")
                && error.contains("neither the loads of bonds nor their ruptures"),
            "{error}"
        );
    }
}
