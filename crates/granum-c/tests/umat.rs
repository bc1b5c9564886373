//! The UMAT and the User_Mod as a host calls them: the faults that users of such interfaces have met.

use std::ffi::{CStr, CString, c_int};
use std::path::Path;
use std::ptr::{null, null_mut};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use granum_c::host::{granum_points_load, granum_points_message, granum_points_open, granum_points_save};
use granum_c::umat::{umat, umat_};
use granum_c::user_mod::user_mod_;

/// The configuration of a process is one: tests that load states must not run beside others.
static ALONE: Mutex<()> = Mutex::new(());

fn folder() -> &'static Path {
    static FOLDER: OnceLock<tempfile::TempDir> = OnceLock::new();
    FOLDER
        .get_or_init(|| {
            let folder = tempfile::tempdir().unwrap();
            let sand = "grains.count = 100\ngrains.material.interface_energy = 0\ngrains.material.friction = 0.5\n\
                        preparation.solid_fraction = 'none'\npreparation.friction = 0.1\n\
                        preparation.mean_stress = '100 kPa'\npreparation.unbalanced_force = 0.01\n";
            std::fs::write(folder.path().join("sand.toml"), sand).unwrap();
            folder
        })
        .path()
}

/// Opens a fresh session with these lines for its material.
fn open(host: &str, lines: &str) -> MutexGuard<'static, ()> {
    let guard = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
    let path = folder().join("granum-materials.toml");
    let text = format!(
        "host = '{host}'\n[[material]]\ncase = 'sand.toml'\ninertial_number = 5e-3\ninitial_stress = 'sample'\n{lines}\n"
    );
    std::fs::write(&path, text).unwrap();
    let path = CString::new(path.to_str().unwrap()).unwrap();
    assert_eq!(unsafe { granum_points_open(path.as_ptr()) }, 0);
    guard
}

fn message() -> String {
    unsafe { CStr::from_ptr(granum_points_message()) }.to_str().unwrap().to_string()
}

/// A point as a host keeps it.
#[derive(Clone, Debug, PartialEq)]
struct Point {
    stress: Vec<f64>,
    statev: Vec<f64>,
    ddsdde: Vec<f64>,
}

impl Point {
    fn new(name: f64, size: usize) -> Point {
        Point {
            stress: vec![0.0; size],
            statev: vec![name, 0.0, 0.0, 0.0, 0.0],
            ddsdde: vec![0.0; size * size],
        }
    }

    /// A call; the point itself is what the host has accepted.
    fn ask(&self, dstran: &[f64]) -> Point {
        self.call(dstran, 3, true, null(), 1.0).0
    }

    fn call(
        &self,
        dstran: &[f64],
        ndi: c_int,
        fortran: bool,
        drot: *const f64,
        material: f64,
    ) -> (Point, f64) {
        let mut next = self.clone();
        let (ntens, nstatv, nprops) = (dstran.len() as c_int, self.statev.len() as c_int, 1);
        let nshr = ntens - ndi;
        let mut pnewdt = 1.0;
        let call = if fortran { umat_ } else { umat };
        let (none, no) = (null::<f64>(), null_mut::<f64>());
        let zero = null::<c_int>();
        unsafe {
            call(
                next.stress.as_mut_ptr(),
                next.statev.as_mut_ptr(),
                next.ddsdde.as_mut_ptr(),
                no,
                no,
                no,
                no,
                no,
                no,
                no,
                none,
                dstran.as_ptr(),
                none,
                none,
                none,
                none,
                none,
                none,
                null(),
                &ndi,
                &nshr,
                &ntens,
                &nstatv,
                &material,
                &nprops,
                none,
                drot,
                &mut pnewdt,
                none,
                none,
                none,
                zero,
                zero,
                zero,
                zero,
                zero,
                zero,
            );
        }
        (next, pnewdt)
    }
}

/// C1: a shear of yz alone stands in the fifth place of Kratos and the sixth of Abaqus, and the stress answers there.
#[test]
fn shear_stands_where_the_host_has_it() {
    for (host, slot) in [("kratos", 4), ("abaqus", 5)] {
        let _alone = open(host, "");
        let start = Point::new(1.0, 6).ask(&[0.0; 6]);
        let mut dstran = [0.0; 6];
        dstran[slot] = 1e-3;
        let sheared = start.ask(&dstran);
        let change: Vec<f64> = sheared.stress.iter().zip(&start.stress).map(|(a, b)| a - b).collect();
        assert!(change[slot] > 2e4, "{host}: a positive shear makes a positive shear stress: {change:?}");
        for other in (3..6).filter(|k| *k != slot) {
            assert!(change[other].abs() < 0.5 * change[slot], "{host}: {change:?}");
        }
    }
}

/// C2: of a sheared sample DDSDDE is the central difference of the stresses, by columns for Fortran and by rows for C; its asymmetry stays.
#[test]
fn the_stiffness_is_neither_transposed_nor_unmapped() {
    let _alone = open("kratos", "tangent = 'probes'\nprobe_strain = 1e-5");
    let mut point = Point::new(1.0, 6).ask(&[0.0; 6]);
    point = point.ask(&[-4e-3, 2e-3, 2e-3, 6e-3, 0.0, 0.0]);
    let at = point.ask(&[0.0; 6]);
    let by_rows = point.call(&[0.0; 6], 3, false, null(), 1.0).0;
    let largest = at.ddsdde.iter().fold(0.0f64, |most, x| most.max(x.abs()));
    let mut asymmetry = 0.0f64;
    for j in 0..6 {
        let ask = |sign: f64| {
            let mut dstran = [0.0; 6];
            dstran[j] = sign * 1e-5;
            point.ask(&dstran).stress
        };
        let (forward, backward) = (ask(1.0), ask(-1.0));
        for i in 0..6 {
            let slope = (forward[i] - backward[i]) / 2e-5;
            assert!((at.ddsdde[6 * j + i] - slope).abs() < 1e-3 * largest, "{i} {j}");
            assert_eq!(by_rows.ddsdde[6 * i + j], at.ddsdde[6 * j + i]);
            asymmetry = asymmetry.max((at.ddsdde[6 * j + i] - at.ddsdde[6 * i + j]).abs());
        }
    }
    assert!(asymmetry > 0.01 * largest);
}

/// C3: 0.1, then NaN, then 1e-4: bits as if 1e-4 alone. NaN is answered with NaN and half of the step, and leaves the state variables.
#[test]
fn a_trial_leaves_no_traces() {
    let _alone = open("abaqus", "");
    let axial = |strain: f64| [strain, 0.0, 0.0, 0.0, 0.0, 0.0];
    let asked = Point::new(1.0, 6).ask(&[0.0; 6]);
    asked.ask(&axial(-0.1));
    let (refused, pnewdt) = asked.call(&axial(f64::NAN), 3, true, null(), 1.0);
    assert!(refused.stress.iter().all(|x| x.is_nan()) && pnewdt == 0.5);
    assert_eq!(refused.statev, asked.statev);
    assert!(message().contains("not a finite number"), "{}", message());
    let mut alone = Point::new(2.0, 6).ask(&[0.0; 6]).ask(&axial(-1e-4));
    alone.statev[0] = 1.0;
    assert_eq!(asked.ask(&axial(-1e-4)), alone);
}

/// C4: what is accepted in 1, 10 or 100 parts gives one cell, to the void ratio's last digits.
#[test]
fn one_cell_however_the_path_is_cut() {
    let _alone = open("abaqus", "");
    let start = Point::new(1.0, 6).ask(&[0.0; 6]);
    let mut ends = Vec::new();
    for (name, parts) in [(1.0, 1), (2.0, 10), (3.0, 100)] {
        let mut point = start.clone();
        point.statev = vec![name, 0.0, 0.0, 0.0, 0.0];
        point.stress = vec![0.0; 6];
        for _ in 0..parts {
            point = point.ask(&[-0.1 / f64::from(parts), 0.0, 0.0, 0.0, 0.0, 0.0]);
            assert!(point.stress[0] < 0.0, "{}", message());
        }
        ends.push((1.0 + point.statev[2]) / (1.0 + start.statev[2]));
    }
    for end in ends {
        assert!((end - 0.904_837_418_035_959_6).abs() < 1e-9, "{end}");
    }
}

/// C5: ten steps; five, a stage without strain, and five; five, a file and another process, and five.
#[test]
fn stages_and_restarts_lose_nothing() {
    let _alone = open("kratos", "tangent = 'affine'");
    let step = [-1e-4, 5e-5, 0.0, 2e-5, 0.0, 0.0];
    let ten = (0..10).fold(Point::new(1.0, 6).ask(&[0.0; 6]), |point, _| point.ask(&step));
    let half = (0..5).fold(Point::new(1.0, 6).ask(&[0.0; 6]), |point, _| point.ask(&step));
    let stage = half.ask(&[0.0; 6]);
    assert_eq!(stage.stress, half.stress);
    assert!(stage.ddsdde[0] > 0.0, "the first stiffness of a stage");
    let staged = (0..5).fold(stage, |point, _| point.ask(&step));
    assert_eq!(staged, ten);

    let half = (0..5).fold(Point::new(1.0, 6).ask(&[0.0; 6]), |point, _| point.ask(&step));
    let file = CString::new(folder().join("states.granum").to_str().unwrap()).unwrap();
    assert_eq!(unsafe { granum_points_save(file.as_ptr()) }, 0);
    let path = CString::new(folder().join("granum-materials.toml").to_str().unwrap()).unwrap();
    assert_eq!(unsafe { granum_points_open(path.as_ptr()) }, 0);
    assert!(half.ask(&step).stress[0].is_nan(), "another process does not know the ticket");
    assert!(message().contains("no point 1"), "{}", message());
    assert_eq!(unsafe { granum_points_load(file.as_ptr()) }, 0);
    let first = half.ask(&[0.0; 6]);
    assert!(first.ddsdde[0] > 0.0);
    let end = (0..5).fold(half, |point, _| point.ask(&step));
    assert_eq!(end, ten);
}

/// C6: the host's stress is taken over to a thousandth, and ten calls without strain do not drift.
#[test]
fn the_stress_of_the_host_is_taken_over() {
    let _alone = open("kratos", "");
    let mut point = Point::new(1.0, 6);
    point.stress = vec![-50e3, -100e3, -50e3, 0.0, 0.0, 0.0];
    let given = point.stress.clone();
    let first = point.ask(&[0.0; 6]);
    for (got, wanted) in first.stress.iter().zip(&given) {
        assert!((got - wanted).abs() <= 1e-3 * 100e3, "{:?} {}", first.stress, message());
    }
    let mut now = first.clone();
    for _ in 0..10 {
        assert_eq!(point.ask(&[0.0; 6]), first, "asked again from the same state");
        now = now.ask(&[0.0; 6]);
        assert_eq!(now, first, "accepted and asked again");
    }
}

/// Four components of plane strain are the first four of six; plane stress and other mistakes are refused by name.
#[test]
fn elements_with_four_components() {
    let _alone = open("abaqus", "");
    let four = Point::new(1.0, 4).ask(&[0.0; 4]).ask(&[-1e-4, 2e-5, 0.0, 5e-5]);
    let six = Point::new(2.0, 6).ask(&[0.0; 6]).ask(&[-1e-4, 2e-5, 0.0, 5e-5, 0.0, 0.0]);
    assert_eq!(four.stress[..], six.stress[..4]);
    for i in 0..4 {
        for j in 0..4 {
            assert_eq!(four.ddsdde[4 * j + i], six.ddsdde[6 * j + i]);
        }
    }
    let refused = |point: &Point, dstran: &[f64], ndi: c_int, material: f64, word: &str| {
        let (answer, _) = point.call(dstran, ndi, true, null(), material);
        assert!(answer.stress[0].is_nan() && message().contains(word), "{word}: {}", message());
    };
    refused(&Point::new(1.0, 3), &[0.0; 3], 2, 1.0, "plane stress");
    refused(&Point::new(0.0, 6), &[0.0; 6], 3, 1.0, "name");
    refused(&Point::new(1.5, 6), &[0.0; 6], 3, 1.0, "whole number");
    refused(&Point::new(1.0, 6), &[0.0; 6], 3, 7.0, "no material 7");
    let mut unknown = Point::new(1.0, 6);
    unknown.statev[1] = 123.0;
    refused(&unknown, &[0.0; 6], 3, 1.0, "ticket 123");
    refused(&six, &[9.0; 6], 3, 1.0, "smaller step");
    refused(&Point::new(1.0, 5), &[0.0; 5], 3, 1.0, "NTENS = 5");
    let mut short = Point::new(1.0, 6);
    short.statev.truncate(1);
    refused(&short, &[0.0; 6], 3, 1.0, "1 state variables");
}

/// DROT is by columns, and the host has rotated its stress: a quarter turn about z exchanges x and y, and runs no step.
#[test]
fn a_rotation_of_the_host_rotates_the_sample() {
    let _alone = open("abaqus", "");
    let point = Point::new(1.0, 6).ask(&[0.0; 6]).ask(&[-1e-3, 2e-4, 1e-4, 3e-4, 0.0, 0.0]);
    // x to y and y to -x: R = [[0, -1, 0], [1, 0, 0], [0, 0, 1]], by columns.
    let drot = [0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let mut turned = point.clone();
    turned.stress = vec![
        point.stress[1],
        point.stress[0],
        point.stress[2],
        -point.stress[3],
        -point.stress[5],
        point.stress[4],
    ];
    let (after, _) = turned.call(&[0.0; 6], 3, true, drot.as_ptr(), 1.0);
    for (got, wanted) in after.stress.iter().zip(&turned.stress) {
        assert!((got - wanted).abs() < 1e-6, "{:?} {:?}", after.stress, turned.stress);
    }
    assert_ne!(after.statev[1], point.statev[1], "another state");
    assert_eq!(after.statev[2], point.statev[2], "of the same grains");
}

/// A sample without stress gives a small stiffness, not none.
#[test]
fn a_sample_without_stress_has_a_stiffness() {
    let _alone = open("kratos", "tangent = 'elastic'");
    let start = Point::new(1.0, 6).ask(&[0.0; 6]);
    let mut point = start.clone();
    for _ in 0..5 {
        point = point.ask(&[5e-3, 5e-3, 5e-3, 0.0, 0.0, 0.0]);
    }
    assert!(point.stress[0].abs() < 100.0, "{:?}", point.stress);
    let after = point.ask(&[1e-6, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(after.ddsdde[0] > 0.0 && after.ddsdde[0] < 0.1 * start.ddsdde[0], "{}", message());
}

/// Tasks of a User_Mod around one point.
struct Model {
    sig0: [f64; 6],
    stvar0: [f64; 5],
}

impl Model {
    fn call(
        &mut self,
        task: c_int,
        deps: [f64; 6],
        isundr: c_int,
    ) -> ([f64; 6], [f64; 36], [f64; 5], [f64; 2], c_int) {
        let (mut sig, mut d, mut stvar, mut water, mut bulk) = ([0.0; 6], [0.0; 36], [0.0; 5], 0.0, 0.0);
        let (mut ipl, mut nstat, mut abort) = (-1, 0, -1);
        let mut attributes = [-1; 4];
        let [nonsym, strsdep, timedep, tang] = &mut attributes;
        let (props, zero, none, no) = (1.0, 0.0, null::<f64>(), null::<c_int>());
        unsafe {
            user_mod_(
                &task,
                no,
                &isundr,
                no,
                no,
                &0,
                &0,
                none,
                none,
                none,
                none,
                none,
                &props,
                self.sig0.as_ptr(),
                &zero,
                self.stvar0.as_mut_ptr(),
                deps.as_ptr(),
                d.as_mut_ptr(),
                &mut bulk,
                sig.as_mut_ptr(),
                &mut water,
                stvar.as_mut_ptr(),
                &mut ipl,
                &mut nstat,
                nonsym,
                strsdep,
                timedep,
                tang,
                no,
                no,
                &mut abort,
            );
        }
        if task == 4 {
            assert_eq!(nstat, 5);
        }
        if task == 5 {
            assert_eq!(attributes, [1, 1, 0, 1]);
        }
        (sig, d, stvar, [water, bulk], abort)
    }
}

/// The tasks of PLAXIS give what the UMAT gives, with stress and stiffness apart; the order is that of Kratos.
#[test]
fn a_user_mod_gives_what_a_umat_gives() {
    let _alone = open("kratos", "");
    let point = Point::new(5.0, 6).ask(&[0.0; 6]);
    let dstran = [-1e-4, 2e-5, 0.0, 5e-5, 0.0, 1e-5];
    let expected = point.ask(&dstran);
    let mut model = Model { sig0: [0.0; 6], stvar0: [0.0; 5] };
    model.call(5, [0.0; 6], 0);
    model.call(4, [0.0; 6], 0);
    model.call(1, [0.0; 6], 0);
    assert!(model.stvar0[0] > 0.0, "a point gets a name");
    let (sig, _, stvar, _, abort) = model.call(2, [0.0; 6], 0);
    assert_eq!((sig.to_vec(), abort), (point.stress.clone(), 0), "{}", message());
    (model.sig0, model.stvar0) = (sig, stvar);
    let (sig, _, stvar, water, abort) = model.call(2, dstran, 0);
    assert_eq!((sig.to_vec(), abort, water), (expected.stress.clone(), 0, [0.0; 2]));
    assert_eq!(stvar[1], expected.statev[1], "the same path has the same ticket");
    let (_, d, _, _, _) = model.call(3, dstran, 0);
    assert_eq!(d.to_vec(), expected.ddsdde);
    // Undrained: the pore water takes what the volume changes by.
    let (_, _, _, [water, bulk], _) = model.call(2, dstran, 1);
    assert!(bulk > 1e9 && (water - bulk * -8e-5).abs() < 1e-6 * water.abs(), "{water} {bulk}");
    // A refusal stops the host, and says why.
    let (_, _, _, _, abort) = model.call(2, [f64::NAN; 6], 0);
    assert!(abort == 1 && message().contains("finite"), "{}", message());
    let (_, _, _, _, abort) = model.call(2, dstran, 0);
    assert_eq!(abort, 0);
}

/// A tensor network of an elastic body, hardly trained: it is saved where the configuration finds it.
fn save_a_surrogate() {
    use granum_core::observer::NoObserver;
    use granum_core::{Column, Table};
    use granum_learn::surrogate::{FitSpec, PathCell, PathNetworks, SurrogateMethod, save};
    use granum_learn::{Dataset, RunStates};

    let normal = ["axial_strain", "lateral_strain_2", "lateral_strain_3"];
    let strains = normal.into_iter().chain(["shear_strain_yz", "shear_strain_zx", "shear_strain_xy"]);
    let stresses = ["stress_11", "stress_22", "stress_33", "stress_23", "stress_13", "stress_12"];
    let run = |seed: u32| {
        let strain = |k: u32| (0..20).map(move |i| 1e-4 * f64::from(i) * (f64::from(7 * seed + k)).sin());
        let columns = strains.clone().zip(0..).map(|(name, k)| Column::new(name, "1", strain(k).collect()));
        let at = |k: u32, x: f64| if k < 3 { 1e5 + 4e7 * x } else { 2e7 * x };
        let stress = |k: u32| strain(k).map(|strain| at(k, strain)).collect();
        let answers = stresses.into_iter().zip(0..).map(|(name, k)| Column::new(name, "Pa", stress(k)));
        let table = Table::new(columns.chain(answers).collect())?;
        RunStates::new(&format!("run-{seed}"), table)?.with_parameter("sample.void_ratio", "1", 0.6)
    };
    let dataset = Dataset::new((0..8).map(run).collect::<granum_learn::Result<_>>().unwrap()).unwrap();
    let mut method = PathNetworks::new(PathCell::TensorStateSpace);
    (method.hidden, method.networks) = (8, 2);
    method.trainer = granum_nets::trainer::Adam {
        epochs: 200,
        learning_rate: 0.02,
        batch_sequences: 4,
        ..Default::default()
    }
    .into();
    let spec = FitSpec::new(strains.clone().chain(["sample.void_ratio"]), stresses).with_threads(1);
    let fitted = method.fit(&dataset, &spec, &mut NoObserver).unwrap();
    save(&folder().join("sand.json"), fitted.as_ref()).unwrap();
}

/// Of a material of both, the surrogate answers what it knows, and the grains of the case what it does not: with the bits that they would have given all along.
#[test]
fn grains_take_over_from_a_surrogate() {
    save_a_surrogate();
    let lines = "[[material]]\nsurrogate = 'sand.json'\ninputs = { 'sample.void_ratio' = 0.6 }\ninitial_stress = 'sample'\n\
                 [[material]]\nsurrogate = 'sand.json'\ninputs = { 'sample.void_ratio' = 0.6 }\ninitial_stress = 'sample'\n\
                 case = 'sand.toml'\ninertial_number = 5e-3\nlargest_trusted_deviation = 0.5";
    let _alone = open("abaqus", lines);
    let begin = |material: f64, name: f64| {
        let mut point = Point::new(name, 6);
        point.statev.extend([0.0, 0.0]);
        point.call(&[0.0; 6], 3, true, null(), material).0
    };
    let ask = |from: &Point, material: f64, dstran: &[f64]| from.call(dstran, 3, true, null(), material).0;
    let (alone, both) = (begin(2.0, 51.0), begin(3.0, 52.0));
    assert_eq!(alone.stress, both.stress);
    let inside = [-1e-4, 2e-5, 2e-5, 0.0, 0.0, 1e-4];
    let (alone, both) = (ask(&alone, 2.0, &inside), ask(&both, 3.0, &inside));
    assert_eq!(alone.stress, both.stress);
    assert_eq!(both.statev[3], -1.0, "a surrogate knows no contacts: {:?}", both.statev);
    assert_eq!(both.statev[6], 0.0, "the surrogate has answered: {:?}", both.statev);
    // Outside of the training.
    let far = [-0.012, 5e-3, 5e-3, 0.0, 0.0, 0.0];
    let (alone, both) = (ask(&alone, 2.0, &far), ask(&both, 3.0, &far));
    assert!(alone.statev[5] > 0.0 && both.statev[5] == 0.0 && both.statev[3] > 1.0, "{:?}", both.statev);
    assert!(alone.statev[6] == 0.0 && both.statev[6] == 1.0, "who has answered: {:?}", both.statev);
    let mut live = begin(1.0, 53.0);
    for dstran in [inside, far] {
        live = ask(&live, 1.0, &dstran);
    }
    assert_eq!(both.stress, live.stress);
    assert!(both.ddsdde[0] > 1e6, "{:?}", both.ddsdde);
}

/// A surrogate of the configuration answers a host as a case does.
#[test]
fn a_surrogate_stands_for_a_case() {
    save_a_surrogate();
    let lines = "[[material]]\nsurrogate = 'sand.json'\ninputs = { 'sample.void_ratio' = 0.6 }\ninitial_stress = 'sample'\n\
                 tangent = 'probes'";
    let _alone = open("abaqus", lines);
    let mut named = Point::new(41.0, 6);
    named.statev.push(0.0);
    let ask = |from: &Point, dstran: &[f64]| from.call(dstran, 3, true, null(), 2.0);
    let start = ask(&named, &[0.0; 6]).0;
    assert!((start.stress[0] + 1e5).abs() < 3e4, "{:?}", start.stress);
    // A zero increment changes no bit; the stress that comes back is that of the state.
    assert_eq!(ask(&start, &[0.0; 6]).0.stress, start.stress);
    let sheared = ask(&start, &[0.0, 0.0, 0.0, 0.0, 0.0, 5e-4]).0;
    assert!(sheared.stress[5] - start.stress[5] > 2e3, "{:?} {:?}", sheared.stress, start.stress);
    assert!(sheared.ddsdde[35] > 2e6 && sheared.ddsdde[0] > 5e6, "{:?}", sheared.ddsdde);
    // The void ratio follows the strain, contacts are not known, and nothing is outside.
    assert!((sheared.statev[2] - 0.6).abs() < 1e-12 && sheared.statev[3] == -1.0, "{:?}", sheared.statev);
    let far = ask(&sheared, &[-0.02, 0.0, 0.0, 0.0, 0.0, 0.0]).0;
    assert_eq!(sheared.statev[5], 0.0);
    assert!(far.statev[5] > 0.0, "what is outside is told: {:?}", far.statev);
    // What cannot be answered is NaN with a shorter step, and says why.
    let (absurd, shorter) = ask(&sheared, &[-3.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert!(
        absurd.stress[0].is_nan() && shorter == 0.5 && message().contains("take a smaller step"),
        "{}",
        message()
    );
    // A stress that the host changed is taken over; one that the surrogate never has is NaN.
    let mut edited = sheared.clone();
    edited.stress[0] -= 1e3;
    let (taken, _) = ask(&edited, &[0.0; 6]);
    assert!((taken.stress[0] - edited.stress[0]).abs() < 150.0, "{:?} {:?}", taken.stress, edited.stress);
    edited.stress[0] = 1e9;
    let (refused, _) = ask(&edited, &[0.0; 6]);
    assert!(
        refused.stress[0].is_nan() && message().contains("cannot be brought to the stress"),
        "{}",
        message()
    );
    // The point is where it was.
    assert_eq!(ask(&sheared, &[0.0; 6]).0.stress, sheared.stress);
}
