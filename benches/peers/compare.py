#!/usr/bin/env python3
"""granum against the DEM programs and JAX of this machine, by turns on one core; prints ratios.

    cargo build --release
    python benches/peers/compare.py            # what is there of lmp, yade and JAX
    python benches/peers/compare.py --dirt ../dirt/target/release/examples/bench_lebc_shear
    python benches/peers/compare.py --rounds 5 --core 1

Both sides are measured over the same stretch: the same number of steps after the same number of steps from the packing, all of
them in one mean (LAMMPS's loop time, YADE's wall time, `granum bench --skip-steps ... --steps ...`). The processor stands beside
every ratio, for ratios differ from one kind to the next.

Installs nothing. `lmp` and `yade` are looked for on the PATH; JAX in this Python or the one given by --jax. The same packing
(data/packing-5000.csv), strain rate (27.5 /s at constant volume) and time step (3e-8 s) on both sides.
"""

import argparse
import json
import os
import platform
import re
import shutil
import statistics
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
PACKING = os.path.join(ROOT, "data", "packing-5000.csv")
# Steps from the packing to the first that counts, and steps that count.
SKIPPED, STEPS = 500, 3000
YADE_STEPS = 1000


def processor():
    """Name, family and model of the processor: names of virtual machines often leave out which one it is."""
    try:
        with open("/proc/cpuinfo") as file:
            lines = file.read().split("\n\n")[0].splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    about = dict((part.strip() for part in line.split(":", 1)) for line in lines if ":" in line)
    name = about.get("model name", platform.machine())
    numbers = [f"{word} {about[key]}" for word, key in (("family", "cpu family"), ("model", "model")) if key in about]
    zen = {"25": {"1": "Zen 3", "17": "Zen 4", "160": "Zen 4"}, "26": {"2": "Zen 5", "17": "Zen 5"}}
    if about.get("vendor_id") == "AuthenticAMD":
        numbers += [zen.get(about.get("cpu family"), {}).get(about.get("model"))]
    return ", ".join([name] + [number for number in numbers if number])


def run(command, core, **more):
    environment = dict(os.environ, OMP_NUM_THREADS="1", **more.pop("environment", {}))
    if shutil.which("taskset"):
        command = ["taskset", "-c", str(core)] + command
    done = subprocess.run(command, capture_output=True, text=True, env=environment, **more)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)} failed:\n{done.stdout[-2000:]}{done.stderr[-2000:]}")
    return done.stdout


def granum(binary, law, core, steps, rate="27.5"):
    """The mean over the same steps as the other side's."""
    text = run(
        [binary, "bench", "--json", "--only", "dem", "--law", law, "--grains", "5000", "--threads", "1"]
        + ["--time-step", "3e-8", "--strain-rate", rate, "--skip-steps", str(SKIPPED), "--steps", str(steps)],
        core,
    )
    figure = json.loads(text)["dem"][0]
    assert figure["steps"] == steps and figure["grains"] == 5000, figure
    return figure["mean_grain_steps_per_second"]


def lammps(model, core, data, folder):
    text = run(
        ["lmp", "-in", os.path.join(HERE, "lammps", "bench.in"), "-log", "none"]
        + ["-var", "model", model, "-var", "data", data, "-var", "warm", str(SKIPPED), "-var", "steps", str(STEPS)],
        core,
        cwd=folder,
    )
    grains = int(re.findall(r"with (\d+) atoms", text)[-1])
    loops = re.findall(r"Loop time of ([0-9.eE+-]+) on \d+ procs for (\d+) steps", text)
    seconds, steps = loops[-1]
    assert int(steps) == STEPS and grains == 5000, (grains, steps)
    return grains * int(steps) / float(seconds)


def yade(core):
    text = run(
        ["yade", "-j1", "-n", "-x", os.path.join(HERE, "yade", "bench.py")],
        core,
        environment={"PACKING": PACKING, "WARM": str(SKIPPED), "STEPS": str(YADE_STEPS)},
    )
    return float(re.findall(r"([0-9.eE+]+) grain-steps per second", text)[-1])


def dirt(binary, core, folder):
    """DIRT with the packing held in its cell; its thermo lines give the steps per second since the line before."""
    with open(PACKING) as file:
        lines = file.read().splitlines()
    rows = os.path.join(folder, "dirt.csv")
    with open(rows, "w") as file:
        file.write("\n".join(line for line in lines if line[:1].isdigit()) + "\n")
    words = {part.split("=")[0].upper(): part.split("=")[1] for part in lines[0].split() if "=" in part}
    words.update(PACKING=rows, OUTPUT=folder, SKIPPED=str(SKIPPED))
    # It prints no line at its last step.
    words.update(STEPS=str(STEPS + SKIPPED))
    with open(os.path.join(HERE, "dirt", "config.toml")) as file:
        text = re.sub(r"\b(%s)\b" % "|".join(words), lambda word: words[word[0]], file.read())
    config = os.path.join(folder, "dirt.toml")
    with open(config, "w") as file:
        file.write(text)
    printed = run([binary, config], core, cwd=folder)
    heads, last, seconds, steps = None, 0, 0.0, 0
    for fields in (line.split() for line in printed.splitlines()):
        if "Step" in fields and "Stepps" in fields:
            heads = fields
        elif heads and len(fields) == len(heads) and fields[0].isdigit():
            step = int(fields[heads.index("Step")])
            if SKIPPED < step <= SKIPPED + STEPS and step > last:
                seconds += (step - last) / float(fields[heads.index("Stepps")])
                steps += step - last
            last = max(step, last)
            grains = int(fields[heads.index("Atoms")])
    assert steps == STEPS and grains == 5000, printed[-2000:]
    return grains * steps / seconds


def by_turns(name, rounds, theirs, ours):
    pairs = [(theirs(), ours()) for _ in range(rounds)]
    ratios = sorted(b / a for a, b in pairs)
    a, b = statistics.median(p[0] for p in pairs), statistics.median(p[1] for p in pairs)
    print(
        f"{name:<66} {a / 1e6:8.3f} {b / 1e6:8.2f} M grain-steps/s, ratio {statistics.median(ratios):.2f}"
        f" ({ratios[0]:.2f} to {ratios[-1]:.2f}) on {processor()}",
        flush=True,
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--granum", default=os.path.join(ROOT, "target", "release", "granum"))
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--core", type=int, default=0)
    parser.add_argument("--dirt", help="the example bench_lebc_shear of DIRT, built (see README.md)")
    parser.add_argument("--jax", default=sys.executable, help="a Python that has JAX")
    flags = parser.parse_args()
    if not os.path.exists(flags.granum):
        sys.exit(f"{flags.granum} is not there: cargo build --release")

    def ours(law, steps=STEPS):
        return lambda: granum(flags.granum, law, flags.core, steps)

    if shutil.which("lmp"):
        with tempfile.TemporaryDirectory() as folder:
            data = os.path.join(folder, "packing.data")
            run([sys.executable, os.path.join(HERE, "lammps", "make_data.py"), PACKING, data], flags.core)
            for model, law, name in [
                ("jkr", "jkr,mindlin-deresiewicz", "LAMMPS granular jkr + mindlin; granum jkr, mindlin-deresiewicz"),
                ("hh", "hertz,no-slip", "LAMMPS gran/hertz/history; granum hertz, no-slip"),
                ("hm", "hertz,no-slip", "LAMMPS granular hertz + mindlin; granum hertz, no-slip"),
            ]:
                by_turns(name, flags.rounds, lambda m=model: lammps(m, flags.core, data, folder), ours(law))
    else:
        print("lmp is not on the PATH: LAMMPS was not compared")
    if shutil.which("yade"):
        by_turns("YADE Hertz-Mindlin; granum hertz, no-slip", flags.rounds, lambda: yade(flags.core), ours("hertz,no-slip", YADE_STEPS))
    else:
        print("yade is not on the PATH: YADE was not compared")
    if flags.dirt:
        with tempfile.TemporaryDirectory() as folder:
            by_turns(
                "DIRT Hertz-Mindlin, cell held; granum hertz, no-slip, cell held",
                flags.rounds,
                lambda: dirt(flags.dirt, flags.core, folder),
                # A rate of strain that moves no grain by the width of an atom.
                lambda: granum(flags.granum, "hertz,no-slip", flags.core, STEPS, "1e-9"),
            )
    else:
        print("--dirt was not given: DIRT was not compared")
    has_jax = subprocess.run([flags.jax, "-c", "import jax"], capture_output=True).returncode == 0
    if has_jax:
        print(run([flags.jax, os.path.join(HERE, "traingdx_jax.py"), "--granum", flags.granum], flags.core).strip() + f" on {processor()}")
    else:
        print("this Python has no JAX: traingdx was not compared (--jax PYTHON)")


if __name__ == "__main__":
    main()
