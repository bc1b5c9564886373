#!/usr/bin/env python3
"""Measures the times that README and the book state: the processor time of each command, with the machine.

    scripts/times.py [--granum target/release/granum] [--only quick calibration python build]

Processor time (user and system, of all threads and child processes) is what a machine of one's own can be compared with: unlike the time on a clock it
hardly depends on the number of cores and on what else they do. Everything is written to a temporary folder. `python` and `build` compile from
nothing, without what is in `target/`; they take minutes each and need the packages to be there or to be fetched.
"""

import argparse
import os
import platform
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
KARLSRUHE = ROOT / "data/validation/karlsruhe-sand"


def commands(granum: Path, folder: Path) -> dict[str, tuple[str, list[list[str]], dict[str, str]]]:
    """For each name what is measured in words, the commands (only the last of them is measured), and variables of the environment."""
    run, environment = [str(granum)], folder / "environment"
    fresh = {"CARGO_TARGET_DIR": str(folder / "target")}
    calibrate = ["calibrate", str(KARLSRUHE / "calibration.toml"), str(ROOT / "data/lab/karlsruhe-fine-sand-drained.csv")]
    return {
        "quick": ("granum reproduce --quick", [run + ["reproduce", "--quick", "--out", str(folder / "quick")]], {}),
        "calibration": (
            "granum calibrate data/validation/karlsruhe-sand/calibration.toml ...",
            [run + calibrate + ["--runs", str(KARLSRUHE / "study"), "--out", str(folder / "karlsruhe")]],
            {},
        ),
        "python": (
            "pip install ./python",
            [
                [sys.executable, "-m", "venv", str(environment)],
                [str(environment / "bin/pip"), "install", "--no-cache-dir", "--disable-pip-version-check", str(ROOT / "python")],
            ],
            fresh,
        ),
        "build": (
            "cargo build --release",
            [["cargo", "build", "--release", "--manifest-path", str(ROOT / "Cargo.toml")]],
            fresh,
        ),
    }


def machine() -> str:
    """The processor and the number of its cores that this process may use."""
    model = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return f"{model}, {cores} cores, {platform.system()}"


def processor_time(command: list[str], variables: dict[str, str]) -> tuple[float, float]:
    """Processor time and time on the clock of a command, s; ends this program if the command fails."""
    before, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    result = subprocess.run(command, capture_output=True, text=True, env=os.environ | variables, check=False)
    after, clock = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic() - clock
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)} ended with {result.returncode}:\n{result.stderr[-2000:]}")
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime, clock


def words(seconds: float) -> str:
    """A time as it is read: 47 s, 5 min 40 s."""
    whole = round(seconds)
    return f"{whole} s" if whole < 100 else f"{whole // 60} min {whole % 60} s"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--granum", type=Path, default=ROOT / "target/release/granum", help="the program, built with --release")
    known = list(commands(Path(), Path()))
    parser.add_argument("--only", nargs="+", choices=known, default=known, metavar="NAME", help=f"of {', '.join(known)}")
    asked = parser.parse_args()
    granum = asked.granum.resolve()
    if {"quick", "calibration"} & set(asked.only) and not granum.is_file():
        sys.exit(f"{granum}: there is no such program; build it with `cargo build --release`, or name it with --granum")
    print(f"Processor time on {machine()}; in brackets the time on the clock.\n")
    print("| command | processor time |\n|---|---|", flush=True)
    for name in asked.only:
        with tempfile.TemporaryDirectory(prefix="granum-times-") as folder:
            label, steps, variables = commands(granum, Path(folder))[name]
            for step in steps[:-1]:
                processor_time(step, variables)
            seconds, clock = processor_time(steps[-1], variables)
            print(f"| `{label}` | {words(seconds)} ({words(clock)}) |", flush=True)


if __name__ == "__main__":
    main()
