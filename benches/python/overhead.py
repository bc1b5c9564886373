"""What Python costs: python benches/python/overhead.py --granum target/release/granum [--rounds N]

Runs the same test alternately by the program and from Python, and from Python with a function that is called at each of 300 states and with a
sensor of Python at each of their observations, all on one thread. Prints medians of the ratios of each round, in processor time of the whole
process and in wall time, and what `import granum` takes. The package must be built as the program is (a wheel of the profile release).
"""

import argparse
import os
import pathlib
import statistics
import subprocess
import sys
import tempfile
import time

CASE = """[grains]
count = 1000
[preparation]
solid_fraction = 'none'
unbalanced_force = 0.02
mean_stress = '50 kPa'
[[stage]]
path = 'constant-p'
deviator_strain = 0.2
inertial_number = 2e-3
states = 300
[recording]
observations_per_state = 1
"""
RUN = "import granum; granum.run('case.toml', 'sample', threads=1, out={out!r}, force=True{more})"
SENSOR = (
    "import numpy as np, granum\n"
    "def measure(assembly): return float(np.sqrt((assembly.velocities**2).sum(axis=1)).max())\n"
    "granum.run('case.toml', 'sample', threads=1, out={out!r}, force=True, sensors=[granum.Sensor('speeds', measure, {{'largest_speed': 'm/s'}})])"
)


def measured(line: list[str], folder: pathlib.Path) -> tuple[float, float]:
    """Processor time and wall time of a process, s."""
    begin = time.perf_counter()
    child = subprocess.Popen(line, cwd=folder, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    assert child.stderr is not None
    errors = child.stderr.read()
    _, status, used = os.wait4(child.pid, 0)
    if status != 0:
        sys.exit(f"{' '.join(line)}\n{errors}")
    return used.ru_utime + used.ru_stime, time.perf_counter() - begin


def main() -> None:
    """Measures and prints."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--granum", type=pathlib.Path, default=pathlib.Path("target/release/granum"))
    options.add_argument("--rounds", type=int, default=5)
    given = options.parse_args()
    program, python = str(given.granum.resolve()), sys.executable
    with tempfile.TemporaryDirectory() as kept:
        folder = pathlib.Path(kept)
        (folder / "case.toml").write_text(CASE)
        measured([program, "prepare", "case.toml", "--out", "sample"], folder)
        lines = {
            "program": [program, "run", "case.toml", "--sample", "sample", "--threads", "1", "--out", "program", "--force"],
            "Python": [python, "-c", RUN.format(out="python", more="")],
            "Python, a function at each state": [python, "-c", RUN.format(out="states", more=", on_state=[].append")],
            "Python, a sensor at each observation": [python, "-c", SENSOR.format(out="sensor")],
            "import granum": [python, "-c", "import granum"],
            "nothing": [python, "-c", "pass"],
        }
        times: dict[str, list[tuple[float, float]]] = {name: [] for name in lines}
        for _ in range(given.rounds):
            for name, line in lines.items():
                times[name].append(measured(line, folder))
        digest = subprocess.run([program, "digest", "program", "python"], cwd=folder, check=True, capture_output=True, text=True).stdout
    print(digest)
    for name in list(lines)[1:4]:
        against = "program" if name == "Python" else "Python"
        ratios = [[one[k] / other[k] for one, other in zip(times[name], times[against])] for k in (0, 1)]
        low, high = min(ratios[0]), max(ratios[0])
        print(
            f"{name} over {against}: processor time {statistics.median(ratios[0]):.4f} ({low:.4f} to {high:.4f}), wall time "
            f"{statistics.median(ratios[1]):.4f}; {statistics.median(t[0] for t in times[name]):.2f} s of processor time"
        )
    best = {name: min(t[0] for t in times[name]) for name in ("import granum", "nothing")}
    print(f"import granum: {1e3 * (best['import granum'] - best['nothing']):.0f} ms of processor time beside an empty program")


if __name__ == "__main__":
    main()
