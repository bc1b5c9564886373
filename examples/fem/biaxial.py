"""Biaxial compression in plane strain with live cells of granum: one element, or a field.

    python biaxial.py LIBRARY --out FOLDER [--columns 8] [--rows 16] [--grains 300] [--strain 0.05] [--steps 100] [--ends rough|smooth]

The lateral pressure is constant and the axial displacement of the upper end is prescribed. Rough ends, which cannot widen, are what breaks
the symmetry of the field; with smooth ends only the differences of the samples do. With one element the script gives strength, dilatancy and modulus for a
Mohr-Coulomb law. Written are curve.csv, points.csv, states.granum and, with one element, law.json.
"""
import argparse
import csv
import json
import math
import os
import sys

from footing import write_points
from granum_points import Library, configuration_with
from plane_strain import G, K, Grid, Stage, set_grains, variable


def fix(grid, ends):
    for node in grid.row(0) + grid.row(-1):
        node.Fix(K.DISPLACEMENT_Y)
        if ends == "rough":
            node.Fix(K.DISPLACEMENT_X)
    if ends == "smooth":
        grid.node(0, 0).Fix(K.DISPLACEMENT_X)


def law_of(rows, pressure):
    """Strength, dilatancy and modulus from a test of one element: compression positive, angles in degrees. The angle of dilatancy is that
    of the strains from half of the strain at the peak to twice the strain at the peak."""
    peak = max(rows, key=lambda row: row["axial_stress"])
    sine = lambda row: (row["axial_stress"] - pressure) / (row["axial_stress"] + pressure)
    degrees = lambda x: math.degrees(math.asin(x))
    late = rows[3 * len(rows) // 4 :]
    about = [row for row in rows if 0.5 * peak["axial_strain"] <= row["axial_strain"] <= 2.0 * peak["axial_strain"]]
    axial, volume = (about[-1][k] - about[0][k] for k in ("axial_strain", "volumetric_strain"))
    half = next(row for row in rows if row["axial_stress"] - pressure >= 0.5 * (peak["axial_stress"] - pressure))
    # Of plane strain the slope is E / (1 - nu^2); nu = 0.2.
    modulus = (1.0 - 0.2**2) * (half["axial_stress"] - pressure) / half["axial_strain"]
    return {
        "friction": degrees(sine(peak)), "strain_at_peak": peak["axial_strain"],
        "late_friction": sum(degrees(sine(row)) for row in late) / len(late),
        # sin(psi) = -(volume) / (2 axial - volume), compression positive.
        "dilatancy": degrees(-volume / (2.0 * axial - volume)), "youngs_modulus": modulus, "poissons_ratio": 0.2,
    }


def axial_force(grid):
    """Force on the upper end, N per m; its width is 1 m."""
    return -sum(node.GetSolutionStepValue(variable("REACTION_Y")) for node in grid.row(-1))


def write(grid, stage, rows, folder):
    """Curve, points and costs so far."""
    with open(os.path.join(folder, "curve.csv"), "w", newline="") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)
    write_points(grid, os.path.join(folder, "points.csv"), True)
    with open(os.path.join(folder, "costs.txt"), "w") as file:
        file.write(stage.costs() + "\n")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("shared_object", metavar="library")
    arguments.add_argument("--configuration", default=os.path.join(os.path.dirname(__file__), "soil-materials.toml"))
    arguments.add_argument("--grains", type=int, default=300)
    arguments.add_argument("--columns", type=int, default=8)
    arguments.add_argument("--rows", type=int, default=16)
    arguments.add_argument("--pressure", type=float, default=100e3)
    arguments.add_argument("--ends", choices=["rough", "smooth"], default="rough")
    arguments.add_argument("--strain", type=float, default=0.03)
    arguments.add_argument("--steps", type=int, default=30)
    arguments.add_argument("--tolerance", type=float, default=5e-3)
    arguments.add_argument("--iterations", type=int, default=20, help="how often the cells are asked before a step is halved")
    arguments.add_argument("--damping", type=float, default=0.02, help="of the iteration, as a part of the first stiffness")
    arguments.add_argument("--accepted", type=float, default=0.0, help="residual up to which a smallest step is taken all the same, as a part of the force")
    arguments.add_argument("--least", type=float, default=0.25, help="size of a smallest step, as a part of a step")
    arguments.add_argument("--threads", type=int, default=1)
    arguments.add_argument("--out", default=".")
    options = arguments.parse_args()
    os.makedirs(options.out, exist_ok=True)
    K.ParallelUtilities.SetNumThreads(options.threads)
    library = Library(options.shared_object, configuration_with(options.configuration, options.out, options.grains))

    # 1 m wide; elements are squares.
    height = options.rows / options.columns
    grid = Grid([i / options.columns for i in range(options.columns + 1)], [height * j / options.rows for j in range(options.rows + 1)])
    fix(grid, options.ends)
    G.ApplyInitialUniformStressField(grid.part, K.Parameters('{"value": [%f, %f, %f, 0.0]}' % ((-options.pressure,) * 3))).ExecuteInitialize()
    set_grains(grid.part, 1, library)

    def load(share):
        for column, sign in ((0, 1.0), (-1, -1.0)):
            for node, length in zip(grid.column(column), Grid.lengths(grid.ys)):
                node.SetSolutionStepValue(variable("POINT_LOAD"), 0, [sign * options.pressure * length, 0.0, 0.0])
        for node in grid.row(-1):
            node.SetSolutionStepValue(K.DISPLACEMENT_Y, 0, -options.strain * height * share)

    # One element is no field: with it Kratos's own iteration goes further, since it may take a correction that makes the residual larger.
    is_field = options.columns * options.rows > 1
    stage = Stage(grid, load, lambda: max(axial_force(grid), options.pressure), tolerance=options.tolerance, most_iterations=options.iterations, damping=options.damping if is_field else None, accepted=options.accepted)
    grid.name_points()
    if not stage.settle():
        sys.exit(f"the cells do not balance the initial stress; granum: {library.message}")
    stage.begin_to_count()
    rows, ended = [], None
    for step in range(options.steps + 1):
        if step > 0 and not stage.advance(step / options.steps, least=options.least / options.steps):
            ended = f"ends before a strain of {options.strain * step / options.steps:.4f}: smaller steps do not converge either"
            break
        force = axial_force(grid)
        strains = [s for e in grid.at_points(variable("ENGINEERING_STRAIN_VECTOR")) for s in e]
        volume = -sum(s[0] + s[1] for s in strains) / len(strains)
        rows.append({"axial_strain": options.strain * step / options.steps, "axial_stress": force, "volumetric_strain": volume,
                     "iterations": stage.iterations, "processor_seconds": round(stage.processor_seconds, 2)})
        if step % max(1, options.steps // 10) == 0 or step == options.steps:
            print(f"strain {rows[-1]['axial_strain']:.4f}, axial stress {1e-3 * force:.2f} kPa, volume {volume:.5f}; {stage.costs()}", flush=True)
            write(grid, stage, rows, options.out)
    write(grid, stage, rows, options.out)
    library.save(os.path.join(options.out, "states.granum"))
    if ended:
        sys.exit(ended)
    if options.columns == options.rows == 1:
        law = law_of(rows, options.pressure)
        with open(os.path.join(options.out, "law.json"), "w") as file:
            json.dump(law, file)
        print(json.dumps(law))


if __name__ == "__main__":
    main()
