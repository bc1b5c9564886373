//! Which files are damaged, which commands read them, and what must hold of a command that reports success.

use Rule::{Calm, Left, Like, Told, ToldBy};

/// What a success means, beyond an end without panic, hang and signal.
#[derive(Clone, Copy, Debug)]
pub enum Rule {
    /// Nothing: nobody can know what the file held before.
    Calm,
    /// The standard output is that of the undamaged files.
    Told,
    /// The file or folder that the command wrote is that of the undamaged files.
    Left(&'static str),
    /// Another command, asked afterwards, has the output that it has for the undamaged files.
    ToldBy(&'static str),
    /// What the command wrote or completed is the same as an undamaged folder.
    Like(&'static str, &'static str),
}

/// A command line.
pub struct Line {
    pub words: &'static str,
    pub rule: Rule,
    /// Computes with grains, and may rightly go on for long: it is asked to end after a moment.
    pub simulates: bool,
}

/// Files that are damaged, and what reads them.
pub struct Target {
    pub name: &'static str,
    /// What of the undamaged files the commands need.
    pub needs: &'static [&'static str],
    /// Files, and folders of files, of which one is damaged.
    pub damaged: &'static [&'static str],
    pub lines: &'static [Line],
    /// How often this target is chosen.
    pub weight: usize,
}

const fn line(words: &'static str, rule: Rule) -> Line {
    Line { words, rule, simulates: false }
}

const fn simulation(words: &'static str, rule: Rule) -> Line {
    Line { words, rule, simulates: true }
}

const TRAINED: &str =
    "train run-1 --unseen run-2 --out out --trainer traingdx --epoch-factor 5e-4 --threads 2";

/// All targets.
pub const ALL: &[Target] = &[
    Target {
        name: "run",
        needs: &["run-1", "run-2", "study", "lab.csv"],
        damaged: &["run-1"],
        lines: &[
            line("status run-1", ToldBy("digest run-1")),
            line("digest run-1", Told),
            line("report run-1 --out out", Left("out")),
            line("export run-1 -o out.csv", Left("out.csv")),
            line("export run-1 --table forces -o out.csv", Left("out.csv")),
            line("export run-1 --table preparation -o out.csv", Left("out.csv")),
            line("export run-1 --table grains -o out.csv", Left("out.csv")),
            line("export run-1 --table contacts --snapshot start -o out.csv", Left("out.csv")),
            line("export run-1 --snapshot all -o out.xyz", Left("out.xyz")),
            line("export run-1 --snapshot all -o out.gsd", Left("out.gsd")),
            line("export run-1 -o out.vtp", Left("out.vtp")),
            line("export run-1 --snapshot start -o out.data", Left("out.data")),
            line("export run-1 --to lammps -o out", Left("out")),
            line("measure run-1", Told),
            line("measure run-1 --snapshot start", Told),
            line("table run-1 run-2 -o out.csv", Left("out.csv")),
            line("report run-1 run-2 --out out", Left("out")),
            line("compare run-1 run-2 -o out.svg", Left("out.svg")),
            line("compare run-1 lab.csv -o out.svg", Left("out.svg")),
            line("--json compare run-1 lab.csv -o out.svg", Told),
            line(TRAINED, Left("out")),
            line("evaluate study run-1 run-2", Told),
            simulation("resume run-1", ToldBy("digest run-1")),
        ],
        weight: 6,
    },
    Target {
        name: "staged-run",
        needs: &["staged"],
        damaged: &["staged"],
        lines: &[
            line("status staged", ToldBy("digest staged")),
            line("digest staged", Told),
            line("report staged --out out", Left("out")),
            line("export staged -o out.parquet", Left("out.parquet")),
            line("--json table staged", Told),
            line("export staged --snapshot all -o out.xyz", Left("out.xyz")),
            simulation("resume staged", ToldBy("digest staged")),
        ],
        weight: 2,
    },
    Target {
        name: "sample",
        needs: &["sample", "case.toml"],
        damaged: &["sample"],
        lines: &[
            line("status sample", ToldBy("digest sample")),
            line("digest sample", Told),
            line("report sample --out out", Left("out")),
            line("export sample -o out.csv", Left("out.csv")),
            line("export sample --to lammps -o out", Left("out")),
            line("measure sample", Told),
            simulation("stiffness sample", Told),
            simulation("resume sample", ToldBy("digest sample")),
            simulation("shear case.toml --sample sample --out out", Like("out", "run-1")),
        ],
        weight: 2,
    },
    Target {
        name: "study",
        needs: &["study", "run-1", "run-2", "rows.csv"],
        damaged: &["study"],
        lines: &[
            line("status study", ToldBy("evaluate study run-1 run-2")),
            line("evaluate study run-1 run-2", Told),
            line("--json evaluate study run-2", Told),
            line("predict study --mapping F4 --input rows.csv -o out.csv", Left("out.csv")),
            line("predict study --mapping F5 --input rows.csv", Told),
            simulation("resume study", ToldBy("evaluate study run-1 run-2")),
        ],
        weight: 2,
    },
    Target {
        name: "several-runs",
        needs: &["several"],
        damaged: &["several"],
        lines: &[
            line("status several", ToldBy("digest several/seed=1 several/seed=2")),
            line("table several -o out.parquet", Left("out.parquet")),
            line("report several --out out", Left("out")),
            line("compare several -o out.svg", Left("out.svg")),
            simulation("resume several", ToldBy("digest several/seed=1 several/seed=2")),
        ],
        weight: 2,
    },
    Target {
        name: "interrupted-run",
        needs: &["stopped"],
        damaged: &["stopped"],
        lines: &[
            line("status stopped", Calm),
            line("digest stopped", Calm),
            line("report stopped --out out", Calm),
            line("export stopped -o out.csv", Calm),
            simulation("resume stopped", Like("stopped", "run-1")),
        ],
        weight: 3,
    },
    Target {
        name: "interrupted-training",
        needs: &["stopped-study", "run-1", "run-2"],
        damaged: &["stopped-study"],
        lines: &[
            line("status stopped-study", Calm),
            simulation("resume stopped-study --threads 2", Like("stopped-study", "study")),
        ],
        weight: 2,
    },
    Target {
        name: "packings",
        needs: &["packing.csv", "packing.data", "packing.xyz", "packing.gsd", "packing.vtp", "case.toml"],
        damaged: &["packing.csv", "packing.data", "packing.xyz", "packing.gsd", "packing.vtp"],
        lines: &[
            line("measure FILE", Calm),
            line("--json measure FILE --case case.toml", Calm),
            line("export FILE -o out.csv", Calm),
            line("export FILE -o out.gsd", Calm),
            line("export FILE -o out.vtp", Calm),
            line("forces FILE", Calm),
            line("--json forces FILE --case case.toml", Calm),
            line("export case.toml --to lammps --packing FILE -o out", Calm),
            simulation("prepare case.toml --packing FILE --out out", Calm),
            simulation("run case.toml --packing FILE --out out", Calm),
        ],
        weight: 5,
    },
    Target {
        name: "tables",
        needs: &["grains.csv", "contacts.csv", "grains.parquet", "contacts.parquet"],
        damaged: &["grains.csv", "contacts.csv", "grains.parquet", "contacts.parquet"],
        lines: &[
            line("measure grains.csv contacts.csv --cell 1mm,1mm,1mm --density 2650", Calm),
            line("measure grains.parquet contacts.parquet --cell 1mm,1mm,1mm --density 2650", Calm),
            line("--json measure --grains grains.csv --contacts contacts.parquet --cell 1mm,1mm,1mm", Calm),
            line("export FILE -o out.csv", Calm),
            line("export grains.csv contacts.csv --cell 1mm,1mm,1mm -o out.vtp", Calm),
        ],
        weight: 2,
    },
    Target {
        name: "other-programs",
        needs: &["results"],
        damaged: &["results"],
        lines: &[
            line("measure FILE", Calm),
            line("--json measure FILE --density 2650", Calm),
            line("export FILE -o out.csv", Calm),
            line("export FILE -o out.gsd", Calm),
            line("report FILE --out out", Calm),
            line(
                "measure results/lammps/grains.dump results/lammps/contacts.dump --columns \
                 results/lammps/contacts.dump=index,patom1,patom2,fx,fy,fz,p1,p2,p3,p10,p11,p12",
                Calm,
            ),
            line(
                "measure results/mercury/box.data results/mercury/box.fstat results/mercury/box.restart",
                Calm,
            ),
            line("measure results/mercury/box.restart", Calm),
            line("measure results/yade/recorder/rough-125200.vtm", Calm),
            line("measure results/yade/recorder/smooth-125200.vtm --density 2650", Calm),
            line("measure results/yade/spheres.vtk results/yade/contacts.vtk results/yade/cell.vtk", Calm),
            line(
                "measure results/liggghts/grains-6000.vtp results/liggghts/contacts-6000.vtp results/liggghts/grains-boundingBox_6000.vtr",
                Calm,
            ),
        ],
        weight: 5,
    },
    Target {
        name: "cases",
        needs: &["case.toml", "packing.csv", "pair.csv", "sample"],
        damaged: &["case.toml"],
        lines: &[
            line("forces packing.csv --case case.toml", Calm),
            line("export case.toml --to lammps --packing packing.csv -o out", Calm),
            simulation("pair pair.csv --case case.toml", Calm),
            simulation("prepare case.toml --out out", Calm),
            simulation("--json run case.toml --out out", Calm),
            simulation("shear case.toml --sample sample --out out", Calm),
        ],
        weight: 3,
    },
    Target {
        name: "staged-cases",
        needs: &["staged.toml", "test.inp", "strains.txt", "history.csv", "packing.csv"],
        damaged: &["staged.toml", "test.inp", "test.inp", "strains.txt", "history.csv"],
        lines: &[
            line("export staged.toml --to lammps --packing packing.csv -o out", Calm),
            simulation("run staged.toml --out out", Calm),
            simulation("--json run staged.toml --packing packing.csv --out out", Calm),
        ],
        weight: 4,
    },
    Target {
        name: "clumps",
        needs: &["clumps"],
        damaged: &["clumps"],
        lines: &[
            line("status clumps", ToldBy("digest clumps")),
            line("digest clumps", Told),
            line("report clumps --out out", Left("out")),
            line("shape clumps", Told),
            line("measure clumps", Told),
            line("export clumps --snapshot all -o out.gsd", Left("out.gsd")),
            line("export clumps --snapshot start -o out.data", Left("out.data")),
            line("export clumps --to lammps -o out", Left("out")),
            simulation("resume clumps", ToldBy("digest clumps")),
        ],
        weight: 2,
    },
    Target {
        name: "bonds",
        needs: &["bonds.toml", "packing.csv"],
        damaged: &["bonds.toml"],
        lines: &[
            simulation("run bonds.toml --out out", Calm),
            simulation("run bonds.toml --out out --set bond.1.damping=0.1", Calm),
            line("export bonds.toml --to lammps --packing packing.csv -o out", Calm),
        ],
        weight: 3,
    },
    Target {
        name: "bonded-run",
        needs: &["bonded"],
        damaged: &["bonded"],
        lines: &[
            line("status bonded", ToldBy("digest bonded")),
            line("digest bonded", Told),
            line("report bonded --out out", Left("out")),
            line("measure bonded", Told),
            line("export bonded --snapshot end -o out.vtp", Left("out.vtp")),
            simulation("resume bonded", ToldBy("digest bonded")),
        ],
        weight: 2,
    },
    Target {
        name: "shapes",
        needs: &["grain.obj", "grain.stl", "grain.ply", "mesh.toml", "dimers.toml", "clumps.data"],
        damaged: &["grain.obj", "grain.stl", "grain.ply", "mesh.toml", "dimers.toml", "clumps.data"],
        lines: &[
            line("shape grain.obj --pieces 6 --out out.svg", Calm),
            line("--json shape grain.stl --pieces 6 --kind mesh-euclidean", Calm),
            line("--json shape grain.ply --pieces 6 --kind mesh-tangent", Calm),
            line("shape grain.ply --pieces 6 --case out.toml", Calm),
            line("shape mesh.toml", Calm),
            line("shape dimers.toml --set grains.shape.separation=0.7", Calm),
            line("measure clumps.data", Calm),
            line("export clumps.data --to xyz -o out.xyz", Calm),
            simulation("prepare mesh.toml --out out", Calm),
            simulation("prepare dimers.toml --packing clumps.data --out out", Calm),
        ],
        weight: 3,
    },
    Target {
        name: "images",
        needs: &["grain.tif", "sieve.csv", "images.toml"],
        damaged: &["grain.tif", "grain.tif", "grain.tif", "sieve.csv", "images.toml"],
        lines: &[
            line("shape grain.tif --kind voxels --pieces 6 --out out.svg", Calm),
            line("--json shape grain.tif --kind voxels", Calm),
            line("shape images.toml", Calm),
            simulation("prepare images.toml --out out", Calm),
        ],
        weight: 3,
    },
    Target {
        name: "interrupted-clumps",
        needs: &["stopped-clumps"],
        damaged: &["stopped-clumps"],
        lines: &[
            line("status stopped-clumps", Calm),
            line("shape stopped-clumps", Calm),
            line("measure stopped-clumps", Calm),
            simulation("resume stopped-clumps", Like("stopped-clumps", "clumps")),
        ],
        weight: 2,
    },
    Target {
        name: "laboratory",
        needs: &["run-1", "lab.csv"],
        damaged: &["lab.csv"],
        lines: &[
            line("compare run-1 lab.csv -o out.svg", Calm),
            line("--json compare run-1 lab.csv --test A -o out.svg", Calm),
        ],
        weight: 2,
    },
    Target {
        name: "inputs",
        needs: &["pair.csv", "rows.csv", "rows.parquet", "study"],
        damaged: &["pair.csv", "rows.csv", "rows.parquet"],
        lines: &[
            simulation("pair pair.csv --normal hertz --tangential no-slip -o out.csv", Calm),
            simulation("--json pair pair.csv --normal hertz --tangential mindlin-deresiewicz", Calm),
            line("predict study --mapping F6 --input rows.csv", Calm),
            line("--json predict study --mapping F6 --input rows.parquet", Calm),
        ],
        weight: 2,
    },
];
