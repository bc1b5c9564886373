"""Rigid rough strip footing on sand with live cells of granum at all points, or with a Mohr-Coulomb law.

    python footing.py LIBRARY --out FOLDER [--grains 300] [--mesh coarse|full] [--settlement 0.01] [--steps 20] [--threads 1]
    python footing.py LIBRARY --law '{"friction": 31, "dilatancy": 14, "youngs_modulus": 37e6}' --out FOLDER [...]

Half of the problem, plane strain: the footing is 2 m wide and is pushed down without turning. First Kratos's K0 procedure gives the sand the stress
of its weight and of a surcharge, 20 kPa unless asked otherwise, beside and below the footing; the live cells are brought to this stress; then the footing settles. Written are
curve.csv, points.csv (the last state of each point), states.granum and costs.txt. With --restart the states of
granum are written and read again in the middle.
"""
import argparse
import csv
import json
import os
import sys

from granum_points import Library, configuration_with
from plane_strain import MOHR_COULOMB, K, Grid, Stage, k0_stress, set_grains, set_material, variable, weigh

WIDTH, K0 = 2.0, 0.5
# Lines of the meshes, m; the half footing ends at x = 1.
MESHES = {
    "coarse": ([0, 0.5, 1, 1.75, 3], [0, 1.2, 2.0, 2.5, 3]),
    "full": ([0, 0.25, 0.5, 0.75, 1, 1.25, 1.5, 2, 2.75, 3.75, 5], [0, 1.2, 2.0, 2.4, 2.7, 2.85, 3]),
}


def on_grains(grid, options):
    configuration = configuration_with(options.configuration, options.out, options.grains)
    library = Library(options.shared_object, configuration)
    set_grains(grid.part, 1, library, options.material)
    return library


def on_mohr_coulomb(grid, options):
    if os.path.exists(options.law):
        with open(options.law) as file:
            law = json.load(file)
    else:
        law = json.loads(options.law)
    if options.late:
        law["friction"], law["dilatancy"] = law["late_friction"], 0.0
    set_material(
        grid.part, 1, MOHR_COULOMB, YOUNG_MODULUS=law["youngs_modulus"], POISSON_RATIO=law.get("poissons_ratio", 0.2),
        GEO_COHESION=law.get("cohesion", 1e2), GEO_FRICTION_ANGLE=law["friction"], GEO_DILATANCY_ANGLE=law["dilatancy"], GEO_TENSILE_STRENGTH=0.0,
    )


def fix(grid):
    for node in grid.part.Nodes:
        if node.X0 in (grid.xs[0], grid.xs[-1]) or node.Y0 == 0:
            node.Fix(K.DISPLACEMENT_X)
        if node.Y0 == 0:
            node.Fix(K.DISPLACEMENT_Y)


def pressure(footing):
    """Mean pressure below the footing, Pa, from the reactions of its nodes, which Kratos gives with the other sign."""
    return -sum(node.GetSolutionStepValue(variable("REACTION_Y")) for node in footing) / (0.5 * WIDTH)


def live(grid, has_cells):
    """At how many points grains have answered."""
    return int(sum(map(sum, grid.state_variable(7)))) if has_cells else 0


def write_points(grid, path, has_cells):
    quantities = [grid.coordinates_of_points(), grid.at_points(K.CAUCHY_STRESS_VECTOR), grid.at_points(variable("ENGINEERING_STRAIN_VECTOR"))]
    states = [grid.state_variable(k) for k in range(1, 8)] if has_cells else []
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow("element,point,x,y,sxx,syy,szz,sxy,exx,eyy,gxy,name,ticket,void_ratio,coordination_number,noise,outside,live".split(",")[: 18 if states else 11])
        for e in range(len(quantities[0])):
            for k in range(len(quantities[0][e])):
                at, stress, strain = (q[e][k] for q in quantities)
                writer.writerow([e + 1, k + 1, *at, *stress, strain[0], strain[1], strain[3], *(s[e][k] for s in states)])


def write(grid, stage, rows, initial, library, folder):
    """Curve, points and costs so far."""
    with open(os.path.join(folder, "curve.csv"), "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["settlement", "pressure", "iterations", "processor_seconds", "live"])
        writer.writerows([[repr(x) for x in row[:2]] + row[2:] for row in rows])
    write_points(grid, os.path.join(folder, "points.csv"), library is not None)
    with open(os.path.join(folder, "costs.txt"), "w") as file:
        file.write(f"{stage.costs()}; {initial}; pressure {1e-3 * rows[-1][1]:.2f} kPa at {1e3 * rows[-1][0]:.2f} mm; grains at {rows[-1][4]} points\n")


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("shared_object", metavar="library")
    arguments.add_argument("--configuration", default=os.path.join(os.path.dirname(__file__), "soil-materials.toml"))
    arguments.add_argument("--material", type=int, default=1, help="which one of the configuration")
    arguments.add_argument("--grains", type=int, default=300)
    arguments.add_argument("--mesh", choices=sorted(MESHES), default="full")
    arguments.add_argument("--law", help="a Mohr-Coulomb law instead of cells, as biaxial.py writes it: friction and dilatancy in degrees, youngs_modulus in Pa")
    arguments.add_argument("--late", action="store_true", help="the late strength of the law and no dilatancy")
    arguments.add_argument("--surcharge", type=float, default=20e3, help="beside the footing, and at first below it, Pa")
    arguments.add_argument("--settlement", type=float, default=0.1)
    arguments.add_argument("--steps", type=int, default=50)
    arguments.add_argument("--tolerance", type=float, default=5e-3)
    arguments.add_argument("--iterations", type=int, default=16, help="how often the cells are asked before a step is halved")
    arguments.add_argument("--restart", action="store_true")
    arguments.add_argument("--damping", type=float, default=0.02, help="of the iteration, as a part of the first stiffness")
    arguments.add_argument("--accepted", type=float, default=0.0, help="residual up to which a smallest step is taken all the same, as a part of the force")
    arguments.add_argument("--least", type=float, default=0.25, help="size of a smallest step, as a part of a step")
    arguments.add_argument("--threads", type=int, default=1)
    arguments.add_argument("--out", default=".")
    options = arguments.parse_args()
    os.makedirs(options.out, exist_ok=True)
    K.ParallelUtilities.SetNumThreads(options.threads)

    grid = Grid(*MESHES[options.mesh])
    fix(grid)
    k0_stress(grid, K0, options.surcharge)
    footing = [node for node in grid.row(-1) if node.X0 <= 0.5 * WIDTH]
    for node in footing:
        node.Fix(K.DISPLACEMENT_X)
        node.Fix(K.DISPLACEMENT_Y)
    has_cells = options.law is None
    library = on_grains(grid, options) if has_cells else on_mohr_coulomb(grid, options)

    beside = 0.5 * (grid.xs[len(footing)] - footing[-1].X0)

    def load(share):
        weigh(grid, options.surcharge)
        for node in footing:
            # The footing carries its part of the surcharge; what lies beside it loads the node of its edge.
            node.SetSolutionStepValue(variable("POINT_LOAD"), 0, [0.0, -options.surcharge * beside if node is footing[-1] else 0.0, 0.0])
            node.SetSolutionStepValue(K.DISPLACEMENT_Y, 0, -options.settlement * share)

    stage = Stage(grid, load, lambda: max(pressure(footing), options.surcharge) * 0.5 * WIDTH, tolerance=options.tolerance, most_iterations=options.iterations, damping=options.damping, accepted=options.accepted)
    if has_cells:
        grid.name_points()
    if not stage.settle():
        sys.exit(f"the cells do not balance the initial stress; granum: {library.message if library else ''}")
    initial = f"{stage.processor_seconds:.1f} s of processor time to the initial stress, {stage.iterations} iterations"
    print(initial, flush=True)
    stage.begin_to_count()
    rows, ended = [[0.0, pressure(footing), 0, 0.0, live(grid, has_cells)]], None
    for step in range(1, options.steps + 1):
        if options.restart and step == options.steps // 2 + 1:
            library.save(os.path.join(options.out, "middle.granum"))
            library.load(os.path.join(options.out, "middle.granum"))
        if not stage.advance(step / options.steps, least=options.least / options.steps):
            ended = f"ends before {1e3 * options.settlement * step / options.steps:.2f} mm: smaller steps do not converge either"
            break
        rows.append([options.settlement * step / options.steps, pressure(footing), stage.iterations, round(stage.processor_seconds, 2), live(grid, has_cells)])
        print(f"settlement {1e3 * rows[-1][0]:.3f} mm, pressure {1e-3 * rows[-1][1]:.2f} kPa, grains at {rows[-1][4]} points; {stage.costs()}", flush=True)
        if step % max(1, options.steps // 10) == 0:
            write(grid, stage, rows, initial, library, options.out)
    write(grid, stage, rows, initial, library, options.out)
    if library:
        library.save(os.path.join(options.out, "states.granum"))
    if ended:
        sys.exit(ended)



if __name__ == "__main__":
    main()
