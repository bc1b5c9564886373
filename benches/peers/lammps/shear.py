"""Shears a packing in LAMMPS as granum does and writes its curves:

    python shear.py ../../../data/packing-5000.csv curves.csv [--time-step 3e-8] [--scratch DIR] [--keep]

Axisymmetric compression at constant mean stress (20 kPa, inertial number 1e-3) to a deviator strain of 0.1; Hertz,
no-slip, friction 0.3. One row a state, averaged over an interval of strain around it as granum's recorder does. Needs
`lmp` with GRANULAR and nothing but Python. Takes some minutes on one core.
"""
import argparse
import math
import os
import subprocess
import sys
import tempfile

STATES = 20
STRAIN = 0.1
DAMPING = 0.1


def tsuji(restitution):
    """Tsuji's damping coefficient as LAMMPS has it."""
    c = (1.2728, -4.2783, 11.087, -22.348, 27.467, -18.022, 4.8218)
    return sum(a * restitution**k for k, a in enumerate(c))


def restitution(damping):
    """The restitution for which LAMMPS's dashpot is this fraction of critical damping on the tangent stiffness."""
    low, high = 0.5, 0.99
    for _ in range(100):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if tsuji(middle) > math.sqrt(6) * damping else (low, middle)
    return 0.5 * (low + high)


def states_of(strains):
    """Strain of each state and its rows: the first alone at the start, then those within half an interval, to the end."""
    interval = STRAIN / STATES
    yield 0.0, [0]
    for k in range(1, STATES + 1):
        centre = k * interval
        yield centre, [n for n, e in enumerate(strains) if abs(e - centre) <= 0.5 * interval and e <= STRAIN]


def mean(values):
    return sum(values) / len(values)


def read_curve(path, grains_volume):
    with open(path) as lines:
        rows = [[float(x) for x in line.split()] for line in lines if not line.startswith("#")]
    curve = []
    for step, strain, volume, s1, s2, s3 in rows:
        p = (s1 + s2 + s3) / 3
        curve.append((step, strain, p, (s1 - 0.5 * (s2 + s3)) / p, grains_volume / volume))
    return curve


def tables(path):
    """Step, edges of the box and rows of every table of a dump."""
    with open(path) as lines:
        for line in lines:
            if line.startswith("ITEM: TIMESTEP"):
                step = int(next(lines))
            elif line.startswith("ITEM: NUMBER"):
                count = int(next(lines))
            elif line.startswith("ITEM: BOX"):
                ends = [[float(x) for x in next(lines).split()] for _ in range(3)]
                box = [high - low for low, high in ends]
            else:
                yield step, box, [next(lines).split() for _ in range(count)]


def read_looks(out, radii):
    """Step, coordination number, mechanical coordination number and deviator fabric of every look."""
    looks = []
    for (step, box, grains), (_, _, pairs) in zip(tables(out + ".grains"), tables(out + ".contacts")):
        place = {row[0]: [float(x) for x in row[1:]] for row in grains}
        degree = dict.fromkeys(place, 0)
        fabric, count = [0.0] * 3, 0
        # A pair across the boundary is listed from both sides.
        for i, j in {(min(row), max(row)) for row in pairs}:
            branch = [a - b - edge * round((a - b) / edge) for a, b, edge in zip(place[i], place[j], box)]
            square = sum(x * x for x in branch)
            if square >= (radii[i] + radii[j]) ** 2:
                continue
            count += 1
            degree[i] += 1
            degree[j] += 1
            for k in range(3):
                fabric[k] += branch[k] ** 2 / square
        degrees = list(degree.values())
        none, one = degrees.count(0), degrees.count(1)
        looks.append((
            step,
            2 * count / len(place),
            (2 * count - one) / (len(place) - none - one),
            (fabric[0] - 0.5 * (fabric[1] + fabric[2])) / count,
        ))
    return looks


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("packing")
    parser.add_argument("curves")
    parser.add_argument("--time-step", type=float, default=3e-8)
    parser.add_argument("--scratch", help="folder for what LAMMPS leaves")
    parser.add_argument("--keep", action="store_true", help="read what an earlier call left in the scratch folder")
    arguments = parser.parse_args()
    here = os.path.dirname(os.path.abspath(__file__))
    scratch = arguments.scratch or tempfile.mkdtemp()
    data, out = os.path.join(scratch, "packing.data"), os.path.join(scratch, "lammps")
    subprocess.run([sys.executable, os.path.join(here, "make_data.py"), arguments.packing, data], check=True)
    if not arguments.keep:
        variables = {"data": data, "out": out, "dt": arguments.time_step, "strain": STRAIN,
                     "restitution": f"{restitution(DAMPING):.10f}"}
        command = ["lmp", "-in", os.path.join(here, "shear.in"), "-log", out + ".log", "-screen", "none"]
        for name, value in variables.items():
            command += ["-var", name, str(value)]
        subprocess.run(command, check=True, env={**os.environ, "OMP_NUM_THREADS": "1"})
    with open(arguments.packing) as lines:
        rows = [line.split(",") for line in lines if line[0].isdigit()]
    radii = {row[0]: float(row[4]) for row in rows}
    curve = read_curve(out + ".curve", sum(4 / 3 * math.pi * r**3 for r in radii.values()))
    looks = read_looks(out, radii)
    strain_of = {int(row[0]): row[1] for row in curve}
    at = sorted(strain_of)
    # Looks fall between two printed lines: the strain is linear in the step.
    rate = (curve[-1][1] - curve[0][1]) / (at[-1] - at[0])
    where = [curve[0][1] + rate * (look[0] - at[0]) for look in looks]
    names = "deviator_strain,stress_ratio,solid_fraction,coordination_number,mechanical_coordination_number,deviator_fabric"
    with open(arguments.curves, "w") as target:
        target.write(names + ",mean_stress\n")
        stress_rows = list(states_of([row[1] for row in curve]))
        look_rows = list(states_of(where))
        for (strain, lines), (_, seen) in zip(stress_rows, look_rows):
            values = [mean([curve[n][3] for n in lines]), mean([curve[n][4] for n in lines])]
            values += [mean([looks[n][k] for n in seen]) for k in (1, 2, 3)]
            values.append(mean([curve[n][2] for n in lines]))
            target.write(f"{strain:.4g}," + ",".join(f"{v:.6g}" for v in values) + "\n")
    print(f"{arguments.curves}: {len(stress_rows)} states from {len(looks)} looks")


if __name__ == "__main__":
    main()
