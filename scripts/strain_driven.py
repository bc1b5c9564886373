#!/usr/bin/env python3
"""How much the grains themselves leave open of the mean stress along a prescribed path of strain: strain_driven.py DATA FOLDER [--surrogate FILE] [--granum PROGRAM] [--runs N]

DATA is a data set in which each path was followed by two samples that differ in their seed, such as data/families/sand/step-unseen. Where a servo held or moved the mean stress,
both samples have the same mean stress, and each a volume of its own. A surrogate gets the volume of one of them; the sample beside it is therefore given the same strains here, the volume
among them: its own run of the path `history`, at the strain rate of the first, in FOLDER (half a minute each; what is there is not run again). The mean stresses of both, and of the
surrogate, are compared state by state: root mean square of the difference of their logarithms (from 1 kPa on) over the deviation of the logarithm of all states of DATA.

Needs Python with pandas and pyarrow.
"""
import argparse
import pathlib
import subprocess

import numpy
import pandas

STRAINS = {
    "axial_strain": "xx_strain", "lateral_strain_2": "yy_strain", "lateral_strain_3": "zz_strain",
    "shear_strain_yz": "yz_strain", "shear_strain_zx": "zx_strain", "shear_strain_xy": "xy_strain",
}
KEYS = ["grains.count", "grains.material.friction", "contact.rolling_friction", "preparation.seed", "preparation.mean_stress", "preparation.friction",
        "recording.observations_per_state"]
WHOLE = {"grains.count", "preparation.seed", "recording.observations_per_state"}
INERTIAL_NUMBER = 1e-3


def logarithm(stress):
    return numpy.log(numpy.maximum(stress, 1e3))


def followed(options, first, second, states):
    """The mean stresses of the second sample along the strains of the first."""
    folder = options.folder / second["run"]
    if not (folder / "run.json").exists():
        case = options.folder / f"{second['run']}.toml"
        states.rename(columns=STRAINS)[list(STRAINS.values())].to_csv(case.with_suffix(".csv"), index=False)
        # The rate belongs to the first mean stress: that of the state can vanish, and with it the rate that belongs to an inertial number.
        rate = INERTIAL_NUMBER * (second["preparation.mean_stress"] / second["grains.material.density"]) ** 0.5 / second["grains.diameter"]
        stage = f'[[stage]]\npath = "history"\nfile = "{case.stem}.csv"\nstrain_rate = "{rate:.6g} /s"\n'
        case.write_text((options.data / "case.toml").read_text().split("[[stage]]")[0] + stage)
        values = [f"{key}={int(second[key]) if key in WHOLE else second[key]}" for key in KEYS]
        sets = [word for value in values for word in ("--set", value)]
        subprocess.run([options.granum, "run", case, "--out", folder, "--threads", "1", *sets], check=True, capture_output=True)
    # The first row is the sample before the path.
    return pandas.read_parquet(folder / "series.parquet").mean_stress.to_numpy()[1:]


def predicted(options, first, states):
    """The mean stresses that a surrogate foresees for the first sample."""
    rows, answers = options.folder / "rows.csv", options.folder / "answers.csv"
    constant = {key: first[key] for key in first.index if key.startswith(("sample.", "grains.", "contact.")) and isinstance(first[key], float)}
    pandas.concat([states, pandas.DataFrame(constant, index=states.index)], axis=1).to_csv(rows, index=False)
    subprocess.run([options.granum, "predict", options.surrogate, "--input", rows, "--output", answers, "--force"], check=True, capture_output=True)
    table = pandas.read_csv(answers)
    return sum(table[f"predicted_stress_{k}{k}"] for k in (1, 2, 3)).to_numpy() / 3


def main():
    arguments = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    arguments.add_argument("data", type=pathlib.Path)
    arguments.add_argument("folder", type=pathlib.Path)
    arguments.add_argument("--surrogate", type=pathlib.Path)
    arguments.add_argument("--granum", type=pathlib.Path, default=pathlib.Path("target/release/granum"))
    arguments.add_argument("--runs", type=int, default=10**6, help="so many pairs at most")
    options = arguments.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    runs, states = (pandas.read_parquet(options.data / name) for name in ("runs.parquet", "states.parquet"))
    deviation = logarithm(states.mean_stress).std()
    rows = []
    for _, pair in runs.groupby("variable.path_seed", sort=False):
        first, second = pair.iloc[0], pair.iloc[1]
        if first["variable.drainage"] == "undrained" or len(rows) >= options.runs:
            continue
        own = states[states.run == first["run"]]
        others = {"another sample": followed(options, first, second, own)}
        if options.surrogate:
            others["surrogate"] = predicted(options, first, own)
        exact = logarithm(own.mean_stress.to_numpy())
        squares = {name: ((logarithm(values)[: len(exact)] - exact[: len(values)]) ** 2) for name, values in others.items()}
        rows += [(first["variable.drainage"], first["variable.kind"], name, value.sum(), len(value)) for name, value in squares.items()]
        said = ", ".join(f"{name} {100 * value.mean() ** 0.5 / deviation:.1f} %" for name, value in squares.items())
        print(f"{first['run']} {first['variable.drainage']} {first['variable.kind']}: {said}", flush=True)
    table = pandas.DataFrame(rows, columns=["drainage", "kind", "of", "square", "states"])
    table["error"] = 100 * (table.square / table.states) ** 0.5 / deviation
    for drainage, part in [*table.groupby("drainage"), ("all", table)]:
        for name, own in part.groupby("of"):
            whole = 100 * (own.square.sum() / own.states.sum()) ** 0.5 / deviation
            print(f"{drainage}, {name}: {whole:.1f} % over all states, median of {len(own)} paths {own.error.median():.1f} % (quarters {own.error.quantile(0.25):.1f} and {own.error.quantile(0.75):.1f} %)")


if __name__ == "__main__":
    main()
