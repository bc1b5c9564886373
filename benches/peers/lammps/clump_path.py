#!/usr/bin/env python3
"""A drained triaxial test of grains of three spheres in LAMMPS and in granum, from the same sample, by the deck of `granum export --to lammps`.

    cargo build --release
    python3 benches/peers/lammps/clump_path.py            # --count 400 --seeds 3 --strain 0.05

Each sample is tested in both programs, and in both with 0.85 and with half of the time step, which are copies that drift apart; other samples
differ by their seeds. The last rows leave out the two corrections of `fix rigid/small` in a cell that is strained.
"""

import argparse
import csv
import math
import os
import pathlib
import statistics
import subprocess
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent.parent
CASE = """
[grains]
count = {count}
diameter = "0.2 mm"
spread = 0.2
[grains.shape]
{shape}
[grains.material]
youngs_modulus = "2 GPa"
friction = 0.4
interface_energy = 0
[contact]
normal = "hertz"
tangential = "no-slip"
[preparation]
mean_stress = "100 kPa"
solid_fraction = "none"
inertial_number = 3e-3
unbalanced_force = 1e-3
friction = 0.1
[recording]
observations_per_state = 10
[[stage]]
path = "{path}"
{strain}
inertial_number = 2e-3
states = 100
"""
COLUMNS = ["stress_ratio", "mean_stress", "volumetric_strain", "coordination_number"]


def run(command, folder):
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True, text=True, env=dict(os.environ, OMP_NUM_THREADS="1"))
    if done.returncode != 0:
        raise SystemExit(f"{command} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")


def curve(path, along):
    """Points of stage 1 along a column, in rising order."""
    with open(path) as file:
        rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#")) if float(row["stage"]) == 1.0]
    points, last = [], -math.inf
    for row in rows:
        if float(row[along]) > last:
            last = float(row[along])
            points.append((last, [float(row[name]) for name in COLUMNS]))
    return points


def at(points, place):
    for (a, p), (b, q) in zip(points, points[1:]):
        if a <= place <= b:
            t = (place - a) / (b - a)
            return [x + t * (y - x) for x, y in zip(p, q)]
    return points[-1][1]


def apart(one, other, end):
    """Root mean square of the differences between 5 and 98 % of the way."""
    places = [end * (0.05 + 0.93 * k / 200) for k in range(201)]
    pairs = [(at(one, place), at(other, place)) for place in places]
    return [math.sqrt(statistics.fmean((a[k] - b[k]) ** 2 for a, b in pairs)) for k in range(len(COLUMNS))]


def mean(points, end):
    places = [end * (0.05 + 0.93 * k / 200) for k in range(201)]
    return [statistics.fmean(at(points, place)[k] for place in places) for k in range(len(COLUMNS))]


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--granum", default=ROOT / "target/release/granum")
    flags.add_argument("--lammps", default="lmp")
    flags.add_argument("--count", type=int, default=400)
    flags.add_argument("--seeds", type=int, default=3)
    flags.add_argument("--strain", type=float, default=0.05)
    flags.add_argument("--shape", default='kind = "capsule"\naspect_ratio = 1.5', help="lines of [grains.shape]")
    flags.add_argument("--path", default="drained-triaxial", choices=["drained-triaxial", "simple-shear-constant-volume"])
    given = flags.parse_args()
    granum = pathlib.Path(given.granum).resolve()
    sheared = given.path != "drained-triaxial"
    along = "shear_strain_xy" if sheared else "axial_strain"
    strain = f"{'shear_strain' if sheared else 'axial_strain'} = {given.strain}"
    curves = {}
    with tempfile.TemporaryDirectory() as name:
        for seed in range(1, given.seeds + 1):
            folder = pathlib.Path(name) / str(seed)
            folder.mkdir()
            (folder / "case.toml").write_text(CASE.format(count=given.count, shape=given.shape, path=given.path, strain=strain))
            run([granum, "prepare", "case.toml", "--seed", seed, "--out", "sample"], folder)
            # Both programs begin without tangential forces and bring the sample to rest.
            run([granum, "export", "sample", "-o", "packing.csv"], folder)
            run([granum, "export", "sample", "--to", "lammps", "--out", "deck"], folder)
            copies = [1.0, 0.85, 0.5] if seed == 1 else [1.0]
            for factor in copies:
                run([given.lammps, "-in", "in.granum", "-screen", "none", "-var", "time_step_factor", factor, "-var", "out", f"{factor}.csv"], folder / "deck")
                curves["LAMMPS", seed, factor] = curve(folder / "deck" / f"{factor}.csv", along)
                ours = ["run", "case.toml", "--packing", "packing.csv", "--out", f"run{factor}", "--set", f"numerics.time_step_factor={0.2 * factor}"]
                run([granum, *ours], folder)
                run([granum, "export", f"run{factor}", "-o", f"{factor}.csv"], folder)
                curves["granum", seed, factor] = curve(folder / f"{factor}.csv", along)
            if seed == 1:
                script = (folder / "deck" / "in.granum").read_text()
                for fix in ("cross", "beyond"):
                    lines = [line for line in script.splitlines() if not line.startswith(f"fix {fix} ")]
                    (folder / "deck" / "less.in").write_text("\n".join(lines) + "\n")
                    command = [given.lammps, "-in", "less.in", "-screen", "none", "-var", "out", "less.csv"]
                    done = subprocess.run(command, cwd=folder / "deck", capture_output=True, timeout=900)
                    if done.returncode == 0 and (folder / "deck" / "less.csv").read_text().count("\n1,") > 10:
                        curves[f"without fix {fix}", seed, 1.0] = curve(folder / "deck" / "less.csv", along)
                    else:
                        print(f"without fix {fix} LAMMPS does not come to the end of the test")
    end = given.strain

    def show(words, numbers):
        print(f"{words:42}", *(f"{name} {number:.5g}" for name, number in zip(COLUMNS, numbers)))

    for key, points in curves.items():
        show(f"mean of {key[0]}, seed {key[1]}, step {key[2]}", mean(points, end))
    for seed in range(1, given.seeds + 1):
        show(f"LAMMPS - granum, seed {seed}", apart(curves["LAMMPS", seed, 1.0], curves["granum", seed, 1.0], end))
    for program in ("LAMMPS", "granum"):
        for factor in (0.85, 0.5):
            show(f"{program}: step {factor} - 1", apart(curves[program, 1, factor], curves[program, 1, 1.0], end))
        for seed in range(2, given.seeds + 1):
            show(f"{program}: seed {seed} - 1", apart(curves[program, seed, 1.0], curves[program, 1, 1.0], end))
    for key in curves:
        if key[0].startswith("without"):
            show(f"{key[0]} - granum", apart(curves[key], curves["granum", 1, 1.0], end))


if __name__ == "__main__":
    main()
