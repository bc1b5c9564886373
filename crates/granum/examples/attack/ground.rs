//! The undamaged files: cases, runs, a study, packings of every format, tables and loading paths, made by the program itself once
//! for all cases of an attack.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use crate::files;
use crate::process::{Limits, Program};

/// A test whose strain range is wide enough for a training, in about a second.
const CASE: &str = r#"
[grains]
count = 60
spread = 0.1
[contact]
normal = "hertz"
tangential = "no-slip"
[preparation]
friction = 0.1
solid_fraction = "none"
inertial_number = 1e-2
unbalanced_force = 2e-2
[shear]
deviator_strain = 0.3
inertial_number = 2e-2
[recording]
states = 40
observations_per_state = 2
"#;

/// A test of several stages, one of them from a file of the IncrementalDriver.
const STAGED: &str = r#"
[grains]
count = 60
spread = 0.1
[preparation]
friction = 0.1
solid_fraction = "none"
mean_stress = "50 kPa"
inertial_number = 1e-2
unbalanced_force = 2e-2
[recording]
sensors = ["granular_temperature", "force_chains"]
[[stage]]
path = "drained-triaxial"
axial_strain = 0.02
states = 10
inertial_number = 2e-2
[[stage]]
incremental_driver = "test.inp"
stress_unit = "1 kPa"
inertial_number = 2e-2
interval = 1e-3
[[stage]]
path = "history"
inertial_number = 2e-2
interval = 1e-3
file = "history.csv"
"#;

const DRIVER: &str = "out.txt
*OedometricE1
10 10 1
-0.002
*Repetition
2 2
*TriaxialE1 ? s1 < -100
10 10 1
-0.001
*TriaxialE1
10 10 1
0.0005
*ImportFile strains.txt | 1
10 10 1
*Cartesian
0 1
0 2
0 2
0 3
0 3
0 3
*LinearLoad
10 10 1
*Cartesian
0 -0.001
1 0
1 0
0 0
0 0
0 0
*End
";

const STRAINS: &str = "0 0 0\n-0.0005 0.0001 0\n-0.001 0.0002 0\n";

const HISTORY: &str =
    "xx_strain,yy_strain,zz_strain,xy_strain\n0,0,0,0\n0.001,0,0,0.001\n0.0015,-0.0002,0.0001,0\n";

const LABORATORY: &str = "# compression = positive\ntest,axial_strain (%),volumetric_strain (%),axial_stress (kPa),\
    lateral_stress (kPa)\nA,0,0,50,50\nA,0.5,0.1,90,50\nA,1,0.1,110,50\nA,1.5,0.05,120,50\nA,2,0,125,50\n";

/// Bonds of which some rupture; the grains of the case do not attract each other.
const BONDS: &str = "[grains.material]\ninterface_energy = 0\n[[bond]]\nlargest_gap = 0.02\ntensile_strength = \"10 kPa\"\n\
                     cohesion = \"20 kPa\"\nscatter = \"weibull\"\n";

/// Grains of several pieces.
const DIMERS: &str = "[grains.shape]\nkind = \"dimer\"\n";

/// Grains of a mesh.
const OF_MESH: &str = "[grains.shape]\nkind = \"mesh\"\nfile = \"grain.obj\"\npieces = 6\n";

/// Grains of labelled images, between two sieves.
const OF_IMAGES: &str = "[grains.shape]\nkind = \"voxels\"\nfile = \"grain.tif\"\npieces = 6\n";
const SIEVE: &str = "size (mm),passing (%)\n0.1,0\n0.2,100\n";

/// A box of twelve triangles.
const OBJECT: &str = "v 0 0 0\nv 3 0 0\nv 0 2 0\nv 3 2 0\nv 0 0 2\nv 3 0 2\nv 0 2 2\nv 3 2 2\n\
    f 1 3 4\nf 1 4 2\nf 5 6 8\nf 5 8 7\nf 1 2 6\nf 1 6 5\nf 3 7 8\nf 3 8 4\nf 1 5 7\nf 1 7 3\nf 2 4 8\nf 2 8 6\n";

const PAIR: &str =
    "normal_approach,tangential_displacement\n0,0\n1e-8,0\n1e-8,1e-9\n5e-9,1e-9\n2e-8,-1e-9\n0,0\n";

const ROWS: &str = "deviator_strain,deviator_fabric,stress_ratio,force\n0.01,0.05,0.4,0.5\n0.15,0.1,0.5,1.125\n\
    0.25,0.1,0.5,2\n";

/// Everything undamaged, in one folder.
pub struct Ground {
    pub folder: PathBuf,
    /// How long the runs took, by which kills are timed.
    pub test: Duration,
    pub of_clumps: Duration,
    pub training: Duration,
}

/// The words of a command line.
pub fn words(line: &str) -> Vec<OsString> {
    line.split(' ').filter(|word| !word.is_empty()).map(OsString::from).collect()
}

/// The training of the attack: few epochs.
pub const TRAIN: &str = "--trainer traingdx --epoch-factor 5e-4 --threads 2";

impl Ground {
    /// Makes everything in a folder, which must be empty.
    pub fn make(folder: &Path, program: &Program) -> Result<Ground, String> {
        let write = |name: &str, text: &str| {
            fs::write(folder.join(name), text)
                .map_err(|error| format!("{}: {error}", folder.join(name).display()))
        };
        write("case.toml", CASE)?;
        write("staged.toml", STAGED)?;
        write("test.inp", DRIVER)?;
        write("strains.txt", STRAINS)?;
        write("history.csv", HISTORY)?;
        write("lab.csv", LABORATORY)?;
        write("pair.csv", PAIR)?;
        write("dimers.toml", &format!("{CASE}{DIMERS}"))?;
        write("mesh.toml", &format!("{CASE}{OF_MESH}"))?;
        write("grain.obj", OBJECT)?;
        write("grain.stl", &stl())?;
        write("grain.ply", &ply())?;
        let images = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("tests/end_to_end/sixteen_cases/files-of-the-case.tif");
        files::copy(&images, &folder.join("grain.tif"))
            .map_err(|error| format!("{}: {error}", images.display()))?;
        write("sieve.csv", SIEVE)?;
        let sieved = "count = 60\ndistribution = \"sieve-curve\"\nsieve_curve = \"sieve.csv\"";
        write("images.toml", &format!("{}{OF_IMAGES}", CASE.replace("count = 60\nspread = 0.1", sieved)))?;
        let done = |line: &str| done(program, folder, line);
        done("prepare case.toml --out sample")?;
        write("bonds.toml", &format!("{CASE}{BONDS}"))?;
        done("run bonds.toml --out bonded")?;
        let begun = Instant::now();
        done("run dimers.toml --out clumps")?;
        let of_clumps = begun.elapsed();
        done("export clumps -o clumps.data --snapshot start")?;
        let begun = Instant::now();
        done("shear case.toml --out run-1")?;
        let test = begun.elapsed();
        done("shear case.toml --set preparation.seed=2 --out run-2")?;
        done("shear staged.toml --out staged")?;
        done("shear case.toml --seed 1,2 --out several")?;
        let begun = Instant::now();
        done(&format!("train run-1 --unseen run-2 --out study {TRAIN}"))?;
        let training = begun.elapsed();
        for name in ["packing.csv", "packing.data", "packing.xyz", "packing.gsd", "packing.vtp"] {
            done(&format!("export sample -o {name}"))?;
        }
        for name in ["grains", "contacts"] {
            done(&format!("export run-1 --table {name} -o {name}.csv"))?;
            done(&format!("export run-1 --table {name} -o {name}.parquet"))?;
        }
        write("rows.csv", ROWS)?;
        done("predict study --mapping F4 --input rows.csv -o rows.parquet")?;
        let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../granum-io/tests/results");
        files::copy(&results, &folder.join("results"))
            .map_err(|error| format!("{}: {error}", results.display()))?;
        interrupted(program, folder, "shear case.toml --out stopped --checkpoint-every 0.05", test)?;
        let clumps = "run dimers.toml --out stopped-clumps --checkpoint-every 0.05";
        interrupted(program, folder, clumps, of_clumps)?;
        let train = format!("train run-1 --unseen run-2 --out stopped-study --checkpoint-every 0.05 {TRAIN}");
        interrupted(program, folder, &train, training)?;
        Ok(Ground { folder: folder.to_path_buf(), test, of_clumps, training })
    }
}

/// The same box as PLY.
fn ply() -> String {
    let [mut corners, mut triangles] = [const { Vec::new() }; 2];
    for row in OBJECT.lines() {
        let numbers: Vec<&str> = row.split(' ').skip(1).collect();
        match row.starts_with('v') {
            true => corners.push(numbers.join(" ")),
            false => {
                let from_zero = numbers
                    .iter()
                    .filter_map(|corner| corner.parse::<u32>().ok())
                    .map(|corner| (corner - 1).to_string());
                triangles.push(format!("3 {}", from_zero.collect::<Vec<_>>().join(" ")));
            }
        }
    }
    format!(
        "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n{}\n{}\n",
        corners.len(),
        triangles.len(),
        corners.join("\n"),
        triangles.join("\n")
    )
}

/// The same box as STL.
fn stl() -> String {
    let rows = |word: &'static str| {
        OBJECT.lines().filter_map(move |line| line.strip_prefix(word)).map(str::trim).collect::<Vec<_>>()
    };
    let corners = rows("v ");
    let corner =
        |word: &str| word.parse().ok().and_then(|n: usize| corners.get(n - 1)).copied().unwrap_or("");
    let facet = |row: &str| {
        let vertices: String = row.split(' ').map(|word| format!("vertex {}\n", corner(word))).collect();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    format!("solid box\n{}endsolid box\n", rows("f ").into_iter().map(facet).collect::<String>())
}

fn done(program: &Program, folder: &Path, line: &str) -> Result<(), String> {
    let ended = program
        .run(folder, &words(line), Limits::default())
        .map_err(|error| format!("granum {line}: {error}"))?;
    if ended.succeeded() { Ok(()) } else { Err(format!("granum {line}: {}", ended.error.trim())) }
}

/// Interrupts a command about half-way.
fn interrupted(program: &Program, folder: &Path, line: &str, whole: Duration) -> Result<(), String> {
    let out = line.split(' ').skip_while(|word| *word != "--out").nth(1).unwrap_or_default();
    for part in [0.5, 0.35, 0.25, 0.15, 0.7, 0.6, 0.4] {
        let _ = fs::remove_dir_all(folder.join(out));
        let limits = Limits { stop_after: Some(whole.mul_f64(part)), ..Limits::default() };
        let ended =
            program.run(folder, &words(line), limits).map_err(|error| format!("granum {line}: {error}"))?;
        if ended.code() == Some(130) && folder.join(out).is_dir() {
            return Ok(());
        }
    }
    Err(format!("granum {line}: it could not be interrupted"))
}
