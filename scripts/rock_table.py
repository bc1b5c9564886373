#!/usr/bin/env python3
"""What the parameters of bonds do to a rock-like packing: strength in compression and tension, Young's modulus and Poisson's ratio.

    python3 scripts/rock_table.py --granum target/release/granum --work rock --table table.md
    python3 scripts/rock_table.py --like 200,69,0.26

The packing is that of the ready case `rock-like` in small, made at a small stress, so that no stress of the preparation is locked in. Each parameter is
varied alone. Every set is compressed and stretched along one axis with next to no lateral stress (`LATERAL`), for each seed of the sample. Young's modulus
and Poisson's ratio are secants from the start of the test to half of the strength. Runs that lie in the folder of `--work` are not made again.

With `--like STRENGTH,MODULUS,POISSON` (MPa, GPa) it looks for the bonds of a packing with the unconfined strength, Young's modulus and Poisson's ratio of a
rock instead, and says what that packing does where it was not fitted: in tension, and under the confinement `CONFINED`.
Needs nothing but Python.
"""
import argparse
import concurrent.futures
import csv
import math
import pathlib
import subprocess
import sys

LATERAL = "10 kPa"
MADE_AT = "100 kPa"
SPEED = "2e-3"  # inertial number at the lateral stress
CONFINED = "10 MPa"
CONFINED_SPEED = "6e-5"  # so that the strain rate is the same
ROUNDS = 4  # of a search for the bonds of a rock
STRAINS = {"compression": 0.006, "tension": -0.0014}  # largest, of the bonds of the ready case
BOND = "bond.1."
GIVEN = {"modulus": 20e9, "tensile_strength": 20e6}  # of the ready case

# Name of a row, and the keys that differ from the ready case.
SETS = [
    ("rock-like", {}),
    ("modulus 10 GPa", {"modulus": 10e9}),
    ("modulus 40 GPa", {"modulus": 40e9}),
    ("stiffness ratio 1", {"stiffness_ratio": 1}),
    ("stiffness ratio 1.5", {"stiffness_ratio": 1.5}),
    ("stiffness ratio 4", {"stiffness_ratio": 4}),
    ("stiffness ratio 10", {"stiffness_ratio": 10}),
    ("both strengths 10 MPa", {"tensile_strength": 10e6, "cohesion": 10e6}),
    ("both strengths 40 MPa", {"tensile_strength": 40e6, "cohesion": 40e6}),
    ("cohesion 10 MPa", {"cohesion": 10e6}),
    ("cohesion 40 MPa", {"cohesion": 40e6}),
    ("cohesion 80 MPa", {"cohesion": 80e6}),
    ("friction angle of bonds 0", {"friction_angle": "0 deg"}),
    ("friction angle of bonds 40°", {"friction_angle": "40 deg"}),
    ("radius 0.5", {"radius": 0.5}),
    ("radius 0.75", {"radius": 0.75}),
    ("Weibull modulus 3", {"weibull_modulus": 3}),
    ("Weibull modulus 15", {"weibull_modulus": 15}),
    ("moment factor 0", {"moment_factor": 0}),
    ("moment factor 0.5", {"moment_factor": 0.5}),
    ("bonds at contacts only", {"largest_gap": 0}),
    ("friction of grains 0.1", {"grains.material.friction": 0.1}),
    ("friction of grains 1", {"grains.material.friction": 1}),
    ("modulus of grains 20 GPa", {"grains.material.youngs_modulus": 20e9}),
]


def called(granum, *words):
    done = subprocess.run([granum, *map(str, words)], capture_output=True, text=True)
    if done.returncode:
        sys.exit(f"granum {' '.join(map(str, words))}\n{done.stderr}")
    return done


def cases(granum, work):
    """The ready case, and the same with an end after the peak, where the packing dilates."""
    ready = work / "rock-like.toml"
    called(granum, "init", "--case", "rock-like", ready, "--force")
    ended = work / "ended.toml"
    ended.write_text(ready.read_text() + "until = { volumetric_strain = -5e-4 }\n")
    return {"compression": ended, "tension": ready}


def measured(granum, given, case, name, keys, test, seed):
    """The measures of one run, which is made unless it is there."""
    folder = given.work / f"{name.replace(' ', '-')}-{test}-{seed}"
    common = ["--seed", seed, "--set", f"grains.count={given.grains}", "--set", f"preparation.mean_stress={MADE_AT}"]
    if not (folder / "run.json").exists():
        scale = keys.get("tensile_strength", GIVEN["tensile_strength"]) / GIVEN["tensile_strength"]
        scale *= GIVEN["modulus"] / keys.get("modulus", GIVEN["modulus"])
        lateral = CONFINED if test == "confined" else LATERAL
        settings = {
            "stage.1.lateral_stress": lateral, "stage.1.axial_strain": STRAINS.get(test, 0.01) * scale, "stage.1.states": 240 if test == "compression" else 100,
            "stage.1.inertial_number": CONFINED_SPEED if test == "confined" else SPEED, "recording.observations_per_state": 1,
        }
        settings |= {key if "." in key else BOND + key: value for key, value in keys.items()}
        words = [word for key, value in settings.items() for word in ("--set", f"{key}={value}")]
        called(granum, "run", case, "--out", folder, "--threads", 1, "--force", *common, *words)
    table = folder.parent / f"{folder.name}.csv"
    called(granum, "export", folder, "-o", table, "--force")
    with table.open() as lines:
        rows = [{key: float(value) for key, value in row.items() if value} for row in csv.DictReader(lines)]
    rows = [row for row in rows if row["stage"] == rows[-1]["stage"]]
    return of_curve(rows, -1 if test == "tension" else 1)


def of_curve(rows, sign):
    """Strength, modulus and Poisson's ratio of a test, and how its bonds ruptured up to the peak."""
    load = [sign * (row["stress_11"] - (row["stress_22"] + row["stress_33"]) / 2) for row in rows]
    peak = load.index(max(load))
    half = next(k for k in range(len(load)) if load[k] >= load[peak] / 2)
    strain = rows[half]["axial_strain"] - rows[0]["axial_strain"]
    lateral = sum(rows[half][name] - rows[0][name] for name in ("lateral_strain_2", "lateral_strain_3")) / 2
    broken = [rows[peak][f"bonds_broken_by_{how}"] for how in ("tension", "shear")]
    return {
        "strength": load[peak] / 1e6,
        "strain": 100 * sign * rows[peak]["axial_strain"],
        "modulus": sign * (load[half] - load[0]) / strain / 1e9,
        "poisson": -lateral / strain,
        "by_shear": broken[1] / max(sum(broken), 1),
        "is_over": peak < len(load) - 1,
    }


def mean_and_deviation(values):
    mean = sum(values) / len(values)
    return mean, math.sqrt(sum((value - mean) ** 2 for value in values) / max(len(values) - 1, 1))


def row(name, runs):
    """A line of the table; `runs` has the measures of both tests for each seed."""
    def cell(values, digits):
        mean, deviation = mean_and_deviation(values)
        return f"{mean:.{digits}f} ± {deviation:.{digits}f}"

    of = lambda test, what: [run[test][what] for run in runs]  # noqa: E731
    ratio = [run["tension"]["strength"] / run["compression"]["strength"] for run in runs]
    cells = [
        name, cell(of("compression", "strength"), 1), cell(of("tension", "strength"), 1), cell(ratio, 2), cell(of("compression", "modulus"), 1),
        cell(of("compression", "poisson"), 3), f"{mean_and_deviation(of('compression', 'strain'))[0]:.2f}",
        f"{100 * mean_and_deviation(of('compression', 'by_shear'))[0]:.0f}, {100 * mean_and_deviation(of('tension', 'by_shear'))[0]:.0f}",
    ]
    return "| " + " | ".join(cells) + " |"


def keys_of(modulus, ratio, strength):
    """Bonds that are so much stronger in shear that rock-like packings rupture by tension, as rock does."""
    return {"modulus": modulus, "stiffness_ratio": ratio, "tensile_strength": strength, "cohesion": 4 * strength}


def like(given, files, wanted):
    """Looks for the bonds of a rock, by the proportions of the table: moduli with moduli, strengths with strengths."""
    strength, modulus, poisson = wanted
    seeds = given.seeds.split(",")
    bonds = [20e9, 4.0, 20e6]

    def mean(test, keys, what, name):
        one = lambda seed: measured(given.granum, given, files.get(test, files["compression"]), name, keys, test, seed)  # noqa: E731
        with concurrent.futures.ThreadPoolExecutor(given.jobs) as workers:
            return mean_and_deviation([run[what] for run in workers.map(one, seeds)])

    for turn in range(ROUNDS):
        keys = keys_of(*bonds)
        name = "like-" + "-".join(f"{number:g}" for number in bonds)
        found = {what: mean("compression", keys, what, name) for what in ("strength", "modulus", "poisson")}
        print(f"modulus {bonds[0] / 1e9:.1f} GPa, stiffness ratio {bonds[1]:.2f}, strength {bonds[2] / 1e6:.1f} MPa: "
              + ", ".join(f"{what} {value:.3g} ± {deviation:.2g}" for what, (value, deviation) in found.items()), flush=True)
        if turn + 1 < ROUNDS:
            uniform = lambda nu: (1 + nu) / (1 - 4 * nu) if nu < 0.24 else 25.0  # noqa: E731
            bonds[0] *= modulus / found["modulus"][0]
            bonds[1] = min(25.0, max(1.0, bonds[1] * uniform(poisson) / uniform(found["poisson"][0])))
            bonds[2] *= strength / found["strength"][0]
    for test in ("tension", "confined"):
        print(f"{test}: strength {mean(test, keys, 'strength', name)[0]:.4g} MPa", flush=True)


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("--granum", default="target/release/granum")
    flags.add_argument("--work", type=pathlib.Path, default=pathlib.Path("rock"))
    flags.add_argument("--grains", type=int, default=500)
    flags.add_argument("--seeds", default="1,2,3")
    flags.add_argument("--jobs", type=int, default=1)
    flags.add_argument("--table", type=pathlib.Path)
    flags.add_argument("--like", help="STRENGTH,MODULUS,POISSON of a rock, MPa and GPa")
    given = flags.parse_args()
    given.work.mkdir(parents=True, exist_ok=True)
    files = cases(given.granum, given.work)
    if given.like:
        return like(given, files, [float(number) for number in given.like.split(",")])
    seeds = given.seeds.split(",")
    lines = [
        "| differs | compression (MPa) | tension (MPa) | tension over compression | Young's modulus (GPa) | Poisson's ratio | strain at the peak (%) "
        "| ruptures by shear up to the peak, compression and tension (%) |",
        "|---|---|---|---|---|---|---|---|",
    ]
    print("\n".join(lines), flush=True)
    with concurrent.futures.ThreadPoolExecutor(given.jobs) as workers:
        for name, keys in SETS:
            tests = [(seed, test) for seed in seeds for test in STRAINS]
            found = list(workers.map(lambda one: measured(given.granum, given, files[one[1]], name, keys, one[1], one[0]), tests))
            for (seed, test), one in zip(tests, found):
                if not one["is_over"]:
                    print(f"{name}, {test}, seed {seed}: the load is largest in the last state", file=sys.stderr)
            lines.append(row(name, [dict(zip(STRAINS, found[len(STRAINS) * k :])) for k in range(len(seeds))]))
            print(lines[-1], flush=True)
    if given.table:
        given.table.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
