#!/usr/bin/env python3
"""Paths with ramps and turning points in granum and in LAMMPS, with copies of each: how far are they apart?

    turning_paths.py GRANUM FOLDER

GRANUM is the program; LAMMPS must be installed as `lmp`. A copy has the grains in another order, or half the time step. Prints rms
distances between states of equal numbers: mean stress in per cent of its mean, and coordination number. Takes half an hour.
"""

import csv
import math
import pathlib
import random
import subprocess
import sys

CASE = """[grains]
count = 150
[contact]
normal = "hertz"
tangential = "no-slip"
[preparation]
friction = 0.1
solid_fraction = "none"
inertial_number = 5e-3
unbalanced_force = 5e-3
[recording]
observations_per_state = 2
"""
HISTORY = "xx_strain,yy_stress (kPa),zz_stress (kPa)\n0.0005,20,20\n0.001,24,22\n0.0003,22,20\n0.0008,20,20\n"
PATHS = {
    "strain cycles": ["cyclic", "strain_amplitude=2.5e-4", "cycles=2", "interval=5e-5"],
    "stress cycle": ["cyclic", "stress_amplitude=8 kPa", "cycles=1", "interval=5e-6"],
    "history": ["history", "file=history.csv", "interval=5e-5"],
    "unload-reload": ["unload-reload", "axial_strain=0.002", "at=0.001", "states=40"],
    "proportional": ["proportional", "ratios_of=stress", "axial_strain=0.001", "states=20"],
}
COPIES = {"first": [], "order": [], "digit": ["0.200001"], "half": ["0.1"]}


def granum(program, folder, *arguments):
    subprocess.run([program, *arguments], cwd=folder, check=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def reorder(source, target):
    """The same grains with other numbers."""
    head, rows = source[:2], [line.split(",", 1)[1] for line in source[2:]]
    random.Random(2).shuffle(rows)
    target.write_text("\n".join(head + [f"{k + 1},{row}" for k, row in enumerate(rows)]) + "\n")


def series(program, folder, name, path, copy, engine):
    """The series of a run, which is made if it is not there."""
    table = folder / f"{name}.csv"
    if not table.exists():
        (folder / name).exists() or granum(program, folder, *arguments_of(path, copy, engine), "--out", name)
        granum(program, folder, "export", name, "-o", table.name)
    lines = [line for line in table.read_text().splitlines() if not line.startswith("#")]
    return {(row["stage"], row["state"]): row for row in csv.DictReader(lines)}


def arguments_of(path, copy, engine):
    packing = "order.csv" if copy == "order" else "first.csv"
    factor = [word for value in COPIES[copy] for word in ("--set", f"numerics.time_step_factor={value}")]
    name, *given = [*path, "inertial_number=3e-3"]
    given = [word for value in given for word in ("--with", value)]
    return ["run", "case.toml", "--packing", packing, *factor, "--path", name, *given, "--engine", engine]


def distance(one, other):
    """Relative rms distance of the mean stress, and rms distance of the coordination number."""
    keys = sorted(one.keys() & other.keys())
    found = []
    for column in ("mean_stress", "coordination_number"):
        pairs = [[number(table[key], column) for table in (one, other)] for key in keys]
        found.append(math.sqrt(sum((a - b) ** 2 for a, b in pairs) / len(pairs)))
        found[-1] /= sum(a for a, _ in pairs) / len(pairs) if column == "mean_stress" else 1.0
    return f"{100 * found[0]:.2f} % ({found[1]:.3f})"


def number(row, column):
    """A column may have its unit after its name."""
    return float(next(value for name, value in row.items() if name.split(" ")[0] == column))


def main():
    program, folder = str(pathlib.Path(sys.argv[1]).resolve()), pathlib.Path(sys.argv[2])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(CASE)
    (folder / "history.csv").write_text(HISTORY)
    if not (folder / "first.csv").exists():
        granum(program, folder, "prepare", "case.toml", "--out", "sample")
        granum(program, folder, "export", "sample", "-o", "first.csv")
    reorder((folder / "first.csv").read_text().splitlines(), folder / "order.csv")
    for title, path in PATHS.items():
        runs = {}
        for engine in ("granum", "lammps"):
            for copy in COPIES:
                name = f"{title.replace(' ', '-')}-{engine}-{copy}"
                runs[engine, copy] = series(program, folder, name, path, copy, engine)
        print(title)
        print("  LAMMPS and granum:", distance(runs["granum", "first"], runs["lammps", "first"]))
        print("  both with half the time step:", distance(runs["granum", "half"], runs["lammps", "half"]))
        for engine in ("granum", "lammps"):
            for copy in ("order", "digit", "half"):
                print(f"  {engine}, {copy}:", distance(runs[engine, "first"], runs[engine, copy]), flush=True)


if __name__ == "__main__":
    main()
