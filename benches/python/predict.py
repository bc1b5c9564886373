"""Predictions of a million rows from Python and from Rust: python benches/python/predict.py [--rows N] [--rounds N]

Surrogates of each of some methods are fitted to a synthetic data set, and predict the same rows by turns in a program of Rust (the example `predict_rows`
of granum-learn, which must be built as the package is) and in a process of Python, on as many threads as granum takes. The time is that of the call, from
an array of rows to an array of means, or to means with intervals; both must give the same bits. Prints medians of the ratios of each round, and the
ratio of the best times, which other programs disturb least.

    cargo build --release -p granum-learn --example predict_rows
    scripts/python release && target/python/bin/python benches/python/predict.py
"""

import argparse
import pathlib
import statistics
import subprocess
import sys
import tempfile

METHODS = {"ridge": {}, "boosted-trees": {}, "feed-forward": {"hidden": [12, 12]}}
PYTHON = """
import sys, time, numpy as np, granum
surrogate = granum.surrogates.read(sys.argv[1])
table = granum.Table.read(sys.argv[2])
rows = np.column_stack([table[name] for name in surrogate.inputs])
def bits(values): return int(np.bitwise_xor.reduce(np.ascontiguousarray(values).view(np.uint64).ravel()))
begin = time.perf_counter()
means = surrogate.means(rows)
print("means", time.perf_counter() - begin, bits(means))
begin = time.perf_counter()
found = surrogate.predict(rows, level=0.9)
print("intervals", time.perf_counter() - begin, bits(found["outputs"]["stress_ratio"]["mean"]))
"""


def fitted(folder: pathlib.Path, rows: int) -> dict[str, pathlib.Path]:
    """Surrogates of a synthetic family of curves, and the rows that they are to predict."""
    import granum
    import numpy as np

    chance = np.random.default_rng(1)
    runs = {}
    for k in range(12):
        friction, strain = 0.1 + 0.05 * k, np.linspace(0, 0.2, 20)
        curve = friction * (1 - np.exp(-40 * strain)) + 0.01 * chance.standard_normal(20)
        runs[f"run {k}"] = granum.Table({"strain": strain, "friction": np.full(20, friction), "stress": np.full(20, 1e5 * (1 + k % 3)), "stress_ratio": curve})
    data = granum.Dataset(runs)
    asked = {"strain": chance.uniform(0, 0.2, rows), "friction": chance.uniform(0.1, 0.65, rows), "stress": chance.uniform(1e5, 3e5, rows)}
    granum.Table(asked).write(folder / "rows.parquet")
    for method, settings in METHODS.items():
        surrogate = granum.surrogates.fit(data, ["strain", "friction", "stress"], "stress_ratio", coordinate="strain", method=method, **settings)
        surrogate.write(folder / f"{method}.json")
    return {method: folder / f"{method}.json" for method in METHODS}


def answer(line: list[str]) -> dict[str, tuple[float, str]]:
    """What a process measured: seconds, and the bits of what it predicted."""
    done = subprocess.run(line, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(line)}\n{done.stderr}")
    return {name: (float(seconds), bits) for name, seconds, bits in (text.split() for text in done.stdout.splitlines())}


def main() -> None:
    """Measures and prints."""
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("--program", type=pathlib.Path, default=pathlib.Path("target/release/examples/predict_rows"))
    options.add_argument("--rows", type=int, default=1_000_000)
    options.add_argument("--rounds", type=int, default=7)
    given = options.parse_args()
    with tempfile.TemporaryDirectory() as kept:
        folder = pathlib.Path(kept)
        for method, path in fitted(folder, given.rows).items():
            asked = [str(path), str(folder / "rows.parquet")]
            found: dict[str, list[tuple[float, float]]] = {}
            for turn in range(given.rounds):
                lines = [[str(given.program), *asked], [sys.executable, "-c", PYTHON, *asked]]
                # Each begins every other round.
                answers = [answer(line) for line in (lines if turn % 2 == 0 else lines[::-1])]
                rust, python = answers if turn % 2 == 0 else answers[::-1]
                for name, (seconds, bits) in rust.items():
                    if python[name][1] != bits:
                        sys.exit(f"{method}, {name}: Python predicts other bits than Rust")
                    found.setdefault(name, []).append((python[name][0], seconds))
            for name, times in found.items():
                ratios = [python / rust for python, rust in times]
                best = [min(column) for column in zip(*times)]
                print(
                    f"{method}, {name}: Python over Rust, median {statistics.median(ratios):.3f} ({min(ratios):.3f} to {max(ratios):.3f}), best over best "
                    f"{best[0] / best[1]:.3f}; best {best[0]:.3f} s and {best[1]:.3f} s for {given.rows} rows; the same bits",
                    flush=True,
                )


if __name__ == "__main__":
    main()
