#!/usr/bin/env python3
"""Grains of three spheres in LAMMPS and in granum: the forces of one packing, and the speed of both by turns on one core.

    cargo build --release
    cargo build --release -p granum-dem --example clump_speed
    python3 benches/peers/lammps/clumps.py            # --rounds 5 --core 1

The packing is the sample of clumps.toml, which granum makes (about ten seconds) and exports for LAMMPS with its bodies as molecules. LAMMPS
moves them with `fix rigid/small` and `pair granular`; granum shears grains of the same shape and number.
"""

import argparse
import csv
import math
import os
import pathlib
import re
import shutil
import statistics
import subprocess
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent.parent
PIECES = 3


def run(command, folder, core=None):
    if core is not None and shutil.which("taskset"):
        command = ["taskset", "-c", str(core), *command]
    environment = dict(os.environ, OMP_NUM_THREADS="1")
    done = subprocess.run([str(part) for part in command], cwd=folder, capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise SystemExit(f"{command} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def atom(row, side):
    return PIECES * (int(row[side]) - 1) + int(row[f"{side}_piece"]) + 1


def forces(folder):
    """Normal forces by pairs of atoms, of granum and of LAMMPS."""
    with open(folder / "contacts.csv") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    ours = {tuple(sorted((atom(row, "first"), atom(row, "second")))): float(row["normal_force"]) for row in rows}
    theirs = {}
    for line in (folder / "forces.txt").read_text().splitlines():
        parts = line.split()
        if len(parts) == 6 and parts[0].isdigit():
            force = math.sqrt(sum(float(part) ** 2 for part in parts[3:]))
            if force > 0.0:
                theirs[tuple(sorted((int(parts[0]), int(parts[1]))))] = force
    return ours, theirs


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--granum", default=ROOT / "target/release/granum")
    flags.add_argument("--speed", default=ROOT / "target/release/examples/clump_speed")
    flags.add_argument("--rounds", type=int, default=3)
    flags.add_argument("--core", type=int, default=0)
    given = flags.parse_args()
    given.granum, given.speed = pathlib.Path(given.granum).resolve(), pathlib.Path(given.speed).resolve()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        run([given.granum, "prepare", HERE / "clumps.toml", "--out", "sample"], folder)
        run([given.granum, "export", "sample", "-o", "clumps.data"], folder)
        run([given.granum, "export", "sample", "--table", "contacts", "-o", "contacts.csv"], folder)
        run(["lmp", "-in", HERE / "clump_forces.in", "-log", "none"], folder)
        ours, theirs = forces(folder)
        mean = statistics.fmean(ours.values())
        apart = max(abs(ours.get(pair, 0.0) - theirs.get(pair, 0.0)) for pair in ours.keys() | theirs.keys())
        print(f"forces: {len(ours)} contacts in granum, {len(theirs)} in LAMMPS, largest difference {apart / mean:.1e} of the mean force")
        times = {"granum": [], "lammps": []}
        for _ in range(given.rounds):
            text = run([given.speed, 5000, 2000, "capsule"], folder, given.core)
            times["granum"].append(1e-6 * float(re.search(r"([0-9.]+) us a step", text)[1]))
            text = run(["lmp", "-in", HERE / "clumps.in", "-log", "none"], folder, given.core)
            times["lammps"].append(float(re.findall(r"Loop time of ([0-9.]+)", text)[-1]) / 2000)
        ours, theirs = (statistics.median(times[program]) for program in ("granum", "lammps"))
        print(f"a step of 5000 grains of three spheres: granum {1e3 * ours:.3f} ms, LAMMPS {1e3 * theirs:.3f} ms, ratio {theirs / ours:.2f}")


if __name__ == "__main__":
    main()
