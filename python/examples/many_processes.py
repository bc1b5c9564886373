"""Runs over a range of frictions, each in a process of its own: concurrent.futures maps a function over cases.

The results do not depend on where and how many at once they were computed.
"""

import concurrent.futures
import multiprocessing

import granum

CASE = granum.Case(
    grains={"count": 300, "spread": 0.3},
    preparation={"solid_fraction": "none", "friction": 0.2, "unbalanced_force": 5e-3, "inertial_number": 2e-3},
    shear={"deviator_strain": 0.05, "inertial_number": 5e-4},
    recording={"states": 10},
)


def largest_stress_ratio(case: granum.Case) -> float:
    """The largest ratio q/p of the test of a case."""
    # One thread each: the processes share the processors.
    return float(granum.run(case, threads=1).series["stress_ratio"].max())


def main() -> None:
    """Runs the cases side by side, and one of them here for comparison."""
    frictions = [0.1, 0.3, 0.5]
    cases = [CASE.with_values({"grains.material.friction": friction}) for friction in frictions]
    # A process that is forked has none of the threads of granum; one that is spawned is safe in every case.
    context = multiprocessing.get_context("spawn")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        found = list(pool.map(largest_stress_ratio, cases))
    for friction, ratio in zip(frictions, found):
        print(f"friction {friction}: q/p at most {ratio:.4f}")
    print("the same bits here:", largest_stress_ratio(cases[1]) == found[1])


if __name__ == "__main__":
    main()
