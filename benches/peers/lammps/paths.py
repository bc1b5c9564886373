"""Tests of one packing along five paths in granum and in LAMMPS, by the decks of `granum export --to lammps`:

    python paths.py --granum ../../../target/release/granum ../../../data/packing-5000.csv ../../../data/validation/paths
    python paths.py --table ../../../data/validation/paths

Without rolling resistance, with the elastic-plastic law (`rolling`), and with the spring-dashpot-slider, which both programs have with the
same constants (`sds`). Four copies in each program are a measure of its own error: two more time steps, and the same packing with
its origin elsewhere, so that other contacts lie across the faces of the cell.
Writes PATH-[rolling-|sds-]PROGRAM-COPY.csv: means over equal intervals of the coordinate of the path but the first, of the polygon through
the rows, so that their places do not matter. `--table` prints the distances of these curves. Needs `lmp` with GRANULAR, granum, and nothing but Python. `--only drained` runs one path.
"""
import argparse
import csv
import math
import os
import subprocess
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
RATE = {"inertial_number": "3e-3"}
# Name in granum, parameters, coordinate and number of its intervals.
PATHS = {
    "drained": ("drained-triaxial", {"axial_strain": 0.02, "states": 80}, "axial_strain"),
    "undrained": ("undrained-triaxial", {"axial_strain": 0.02, "states": 80}, "axial_strain"),
    "constant-p": ("constant-p", {"deviator_strain": 0.03, "states": 80}, "deviator_strain"),
    "oedometer": (
        "oedometer",
        {"axial_stress": "200 kPa", "unloading_stress": "50 kPa", "interval": 1e-5, "inertial_number": "3e-4"},
        "axial_stress",
    ),
    "simple-shear": ("simple-shear-constant-volume", {"shear_strain": 0.03, "states": 80}, "shear_strain_xy"),
}
INTERVALS = 20
# Suffix of the files and settings. The stiffness of the last is about that of the elastic-plastic law at 20 kPa, its dashpot 0.3 of critical.
LAWS = {
    "": [],
    "-rolling": ["rolling=elastic-plastic", "rolling_friction=0.1"],
    "-sds": ["rolling=spring-dashpot-slider", "rolling_friction=0.1", "rolling_stiffness=800", "rolling_viscosity=1.05e-3"],
}
# Of each copy the factor on the time step of 0.2 sqrt(m/k_t), and by what part of the cell the packing is shifted.
COPIES = [(1.0, None), (0.85, None), (1.0, (0.37, 0.51, 0.43)), (0.5, None)]
PROGRAMS = ["lammps", "granum"]
VALUES = ["mean_stress", "void_ratio", "coordination_number", "mechanical_coordination_number"]


def ratio_of(path):
    """The ratio of stresses that is compared: of a triaxial test q/p with q = axial less mean lateral stress, of simple shear q_vM/p."""
    return "von_mises_ratio" if path == "simple-shear" else "stress_ratio"


def call(command, **more):
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": "1"}, **more)


def words(path, rolling):
    name, parameters, _ = PATHS[path]
    out = ["--path", name]
    for key, value in {**RATE, **parameters}.items():
        out += ["--with", f"{key}={value}"]
    for setting in LAWS[rolling]:
        out += ["--set", f"contact.{setting}"]
    return out


def rows_of(file):
    with open(file) as lines:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(lines)]


def reduced(rows, path):
    """Means of the curve over equal intervals of the coordinate: of each stage, where there are several."""
    rows = [row for row in rows if row.get("stage", 1) >= 1]
    coordinate = PATHS[path][2]
    if coordinate == "axial_stress":
        for row in rows:
            row["axial_stress"] = row["stress_11"]
    stages = sorted({row.get("stage", 1) for row in rows})
    out = []
    for stage in stages:
        mine = [row for row in rows if row.get("stage", 1) == stage]
        low, high = interval(path, stage)
        for k in range(1, INTERVALS):
            at = [low + (high - low) * j / INTERVALS for j in (k, k + 1)]
            mean = mean_between(mine, coordinate, [ratio_of(path)] + VALUES, at)
            if mean:
                out.append({"stage": int(stage), coordinate: 0.5 * sum(at), **mean})
    return out


def mean_between(rows, coordinate, values, at):
    """Means over an interval of the polygon through the rows; none if it does not reach from one end to the other."""
    low, high = min(at), max(at)
    width, sums = 0.0, dict.fromkeys(values, 0.0)
    for one, two in zip(rows, rows[1:]):
        begin, end = one[coordinate], two[coordinate]
        first, last = (min(max(x, low), high) for x in (begin, end))
        # A part that turns back cancels out.
        width += last - first
        if last != first:
            share = (0.5 * (first + last) - begin) / (end - begin)
            for key in values:
                sums[key] += (last - first) * (one[key] + share * (two[key] - one[key]))
    if abs(width) < 0.98 * (high - low):
        return None
    return {key: total / width for key, total in sums.items()}


def interval(path, stage):
    _, parameters, _ = PATHS[path]
    if path == "oedometer":
        return (20e3, 200e3) if stage == 1 else (200e3, 50e3)
    return 0.0, parameters.get("axial_strain") or parameters.get("deviator_strain") or parameters["shear_strain"]


def write(file, rows):
    with open(file, "w") as target:
        target.write(",".join(rows[0]) + "\n")
        for row in rows:
            target.write(",".join(f"{value:.6g}" for value in row.values()) + "\n")


def shifted(packing, parts, target):
    """Writes a packing in granum's CSV with all centres shifted by parts of the periodic cell."""
    with open(packing) as lines:
        box, names = next(lines), next(lines)
        rows = [line.split(",") for line in lines]
    faces = {word[:3]: float(word[4:]) for word in box.split() if "=" in word}
    for axis, part in enumerate(parts):
        low, high = (faces["xyz"[axis] + end] for end in ("lo", "hi"))
        for row in rows:
            place = float(row[1 + axis]) - low + part * (high - low)
            row[1 + axis] = repr(low + place % (high - low))
    with open(target, "w") as out:
        out.write(box + names + "".join(",".join(row) for row in rows))


def run(arguments, path, rolling, copy):
    """One copy of one path in both programs."""
    name = path + rolling
    granum, case = os.path.abspath(arguments.granum), os.path.join(HERE, "sand.toml")
    factor, parts = COPIES[copy - 1]
    with tempfile.TemporaryDirectory() as scratch:
        deck, folder = os.path.join(scratch, "deck"), os.path.join(scratch, "run")
        packing = os.path.abspath(arguments.packing)
        if parts:
            packing = os.path.join(scratch, "shifted.csv")
            shifted(arguments.packing, parts, packing)
        more = ["--packing", packing] + words(path, rolling)
        call([granum, "export", case, "--to", "lammps", "--out", deck] + more)
        call(["lmp", "-in", "in.granum", "-screen", "none", "-var", "time_step_factor", str(factor)], cwd=deck)
        theirs = rows_of(os.path.join(deck, "curve.csv"))
        settings = ["--set", f"numerics.time_step_factor={0.2 * factor:g}", "--threads", "1"]
        call([granum, "run", case, "--out", folder, "--force"] + settings + more)
        series = os.path.join(scratch, "series.csv")
        call([granum, "export", folder, "-o", series, "--force"])
        for program, rows in zip(PROGRAMS, (theirs, rows_of(series))):
            write(os.path.join(arguments.folder, f"{name}-{program}-{copy}.csv"), reduced(rows, path))
    print(name, copy, flush=True)


def aligned(curves):
    """The rows that all curves have, in the same order."""
    coordinate = list(curves[0][0])[1]
    by_place = [{(row["stage"], round(row[coordinate], 9)): row for row in rows} for rows in curves]
    places = [place for place in by_place[0] if all(place in rows for rows in by_place)]
    return [[rows[place] for place in places] for rows in by_place]


def distance(one, other, key):
    """Root mean square of the differences."""
    return math.sqrt(sum((a[key] - b[key]) ** 2 for a, b in zip(one, other)) / len(one))


def table(folder):
    """Of each curve the means in LAMMPS and in granum, their distance, and the largest distances of a copy from the first. Of the laws
    that both programs have it also counts the distances that are larger than those of all copies of LAMMPS."""
    ratios = []
    copies = range(1, len(COPIES) + 1)
    others = {"mean_stress": "p, kPa", "void_ratio": "void ratio", "coordination_number": "coordination number"}
    print("| path | q/p (simple shear: q_vM/p) | " + " | ".join(others.values()) + " |")
    print("|---" * (2 + len(others)) + "|")
    for path in PATHS:
        for name in (path + rolling for rolling in LAWS):
            files = [os.path.join(folder, f"{name}-{program}-{copy}.csv") for program in PROGRAMS for copy in copies]
            if not all(os.path.exists(file) for file in files):
                continue
            curves = aligned([rows_of(file) for file in files])
            theirs, ours = curves[: len(COPIES)], curves[len(COPIES) :]
            cells = []
            for key in [ratio_of(path), *others]:
                unit = 1e3 if key == "mean_stress" else 1.0
                means = [sum(row[key] for row in rows[0]) / len(rows[0]) / unit for rows in (theirs, ours)]
                found = distance(theirs[0], ours[0], key) / unit
                own = [max(distance(rows[0], row, key) for row in rows[1:]) / unit for rows in (theirs, ours)]
                digits = {"mean_stress": 2, "void_ratio": 5, "coordination_number": 3}.get(key, 4)
                first = ", ".join(f"{mean:.{digits}f}" for mean in means)
                constant = key == "void_ratio" and found == 0.0 == max(own)
                if not constant and not name.endswith("-rolling"):
                    ratios.append(found / own[0])
                cells.append("constant" if constant else f"{first}; {found:.2g} (" + ", ".join(f"{x:.2g}" for x in own) + ")")
            print(f"| {name.replace('-rolling', ', rolling').replace('-sds', ', sds').replace('-', ' ')} | " + " | ".join(cells) + " |")

    larger = [ratio for ratio in ratios if ratio > 1.0]
    if ratios:
        print(f"\nSame laws: {len(larger)} of {len(ratios)} distances are larger than that of each copy of LAMMPS, by {max(ratios):.2f} at most;")
        print(f"if the programs were one, {len(ratios) / len(COPIES):.0f} would be expected.")

def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packing", nargs="?", help="packing in granum's CSV")
    parser.add_argument("folder", help="folder of the curves")
    parser.add_argument("--granum", default="granum", help="the program")
    parser.add_argument("--only", choices=PATHS, action="append", help="this path; can be repeated")
    choices = {"none": "", "elastic-plastic": "-rolling", "spring-dashpot-slider": "-sds"}
    parser.add_argument("--rolling", choices=choices, action="append", help="only with this law of rolling; can be repeated")
    copies = range(1, len(COPIES) + 1)
    parser.add_argument("--copy", type=int, choices=copies, action="append", help="only this copy; can be repeated")
    parser.add_argument("--table", action="store_true")
    arguments = parser.parse_args()
    if not arguments.table:
        os.makedirs(arguments.folder, exist_ok=True)
        for path in arguments.only or PATHS:
            for law in arguments.rolling or choices:
                for copy in arguments.copy or copies:
                    run(arguments, path, choices[law], copy)
    table(arguments.folder)


if __name__ == "__main__":
    main()
