"""K0 stress in Kratos, and live cells that are brought to it.

    python k0.py LIBRARY [--out FOLDER]

A column of four quadrilaterals gets the stress of its weight and of a surcharge with an elastic law; Kratos's K0 procedure corrects the
horizontal stresses; the next stage has live cells, which learn of their stress only by the argument STRESS of their first call, and are
brought to it. The script ends with an error unless every cell has the stress of Kratos to a thousandth, the column does not settle by
more than the strain of this thousandth, and a further load is carried.
"""
import argparse
import os
import sys

from granum_points import Library
from plane_strain import K, Grid, Stage, k0_stress, set_grains, variable, weigh

K0, SURCHARGE, HEIGHT = 0.5, 20e3, 3.0


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("shared_object", metavar="library")
    arguments.add_argument("--configuration", default=os.path.join(os.path.dirname(__file__), "soil-materials.toml"))
    arguments.add_argument("--threads", type=int, default=1)
    arguments.add_argument("--out", default=".")
    options = arguments.parse_args()
    os.makedirs(options.out, exist_ok=True)
    K.ParallelUtilities.SetNumThreads(options.threads)
    library = Library(options.shared_object, options.configuration)

    grid = Grid([0.0, 1.0], [HEIGHT * k / 4 for k in range(5)])
    for node in grid.part.Nodes:
        node.Fix(K.DISPLACEMENT_X)
        if node.Y0 == 0:
            node.Fix(K.DISPLACEMENT_Y)
    k0_stress(grid, K0, SURCHARGE)
    corrected = grid.at_points(K.CAUCHY_STRESS_VECTOR)

    set_grains(grid.part, 1, library)
    load = lambda share: weigh(grid, SURCHARGE * (1.0 + 0.05 * share))
    stage = Stage(grid, load, lambda: SURCHARGE, tolerance=1e-3)
    grid.name_points()
    # The first step has no further load: cells are brought to the stress, and its error of up to a thousandth is balanced.
    if not stage.settle():
        sys.exit(f"the cells do not balance the load; granum: {library.message or 'no refusal'}")
    reached = grid.at_points(K.CAUCHY_STRESS_VECTOR)
    missed = max(
        max(abs(a - b) for a, b in zip(s, t)) / max(abs(x) for x in t) for e, f in zip(reached, corrected) for s, t in zip(e, f))
    settled = -grid.node(0, -1).GetSolutionStepValue(K.DISPLACEMENT_Y)
    top, bottom = corrected[-1][0], corrected[0][0]
    print(f"K0 stress: sxx / syy {top[0] / top[1]:.6f} and szz / syy {bottom[2] / bottom[1]:.6f}, syy {bottom[1]:.1f} to {top[1]:.1f} Pa; "
          f"cells differ by {missed:.1e} of it, settlement {settled:.2e} m")
    if not stage.advance(1.0):
        sys.exit(f"the further load does not converge; granum: {library.message or 'no refusal'}")
    further = -grid.node(0, -1).GetSolutionStepValue(K.DISPLACEMENT_Y) - settled
    # In the oedometer the vertical stress is the load, whatever the law is.
    gained = [s[1] - t[1] for e, f in zip(grid.at_points(K.CAUCHY_STRESS_VECTOR), corrected) for s, t in zip(e, f)]
    mean = sum(gained) / len(gained)
    print(f"5 % more surcharge: vertical stress {mean:.1f} Pa, settlement {further:.2e} m, modulus {-mean * HEIGHT / further / 1e6:.0f} MPa; {stage.costs()}")
    library.save(os.path.join(options.out, "states.granum"))
    with open(os.path.join(options.out, "curve.csv"), "w") as file:
        for element in grid.at_points(K.CAUCHY_STRESS_VECTOR):
            for stress in element:
                file.write(",".join(map(repr, stress)) + "\n")
    ratios = [abs(s[k] / s[1] - K0) for e in corrected for s in e for k in (0, 2)]
    checks = {
        "K0 of Kratos": max(ratios) < 1e-6,
        "stress of the cells": missed < 2e-3,
        "settlement": abs(settled) < 1e-3 * HEIGHT * 1e-3,
        "further load": abs(mean + 0.05 * SURCHARGE) < 0.05 * 0.05 * SURCHARGE and further > 0,
    }
    failed = [name for name, holds in checks.items() if not holds]
    if failed:
        sys.exit("FAILED: " + ", ".join(failed))


if __name__ == "__main__":
    main()
