#!/usr/bin/env python3
"""A data set with some of the runs of another, chosen by what was varied: to see what a surrogate says where it has no runs.

    python3 scripts/cut_data.py data/families/sand/drained without-corner --without "friction > 0.5 and rolling_friction > 0.25"
    python3 scripts/cut_data.py data/families/sand/unseen corner --only "friction > 0.5 and rolling_friction > 0.25"

A condition compares variables of the plan (the columns `variable.NAME` of `runs.parquet`) with numbers. What comes out is a data set as any other.
Needs Python with pyarrow.
"""
import argparse
import pathlib
import shutil
import sys

import pyarrow as pa
import pyarrow.parquet as pq

import ship_data

FILES = ["README.md", "case.toml", "left_out.csv", "metadata.json", "plan.toml", "points.csv", "runs.parquet", "states.parquet"]


def chosen(runs, condition):
    """For each run whether the condition holds."""
    names = {name.removeprefix("variable."): runs[name].to_pylist() for name in runs.column_names if name.startswith("variable.")}
    try:
        code = compile(condition, "the condition", "eval")
        return [bool(eval(code, {"__builtins__": {}}, {name: values[k] for name, values in names.items()})) for k in range(runs.num_rows)]
    except (SyntaxError, NameError, TypeError) as error:
        sys.exit(f"error: {condition}: {error}; the variables are {', '.join(names)}")


def main():
    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("source", type=pathlib.Path)
    options.add_argument("target", type=pathlib.Path)
    which = options.add_mutually_exclusive_group(required=True)
    which.add_argument("--without", metavar="CONDITION")
    which.add_argument("--only", metavar="CONDITION")
    given = options.parse_args()
    if given.target.exists():
        sys.exit(f"error: {given.target} exists already")
    runs, states = (pq.read_table(given.source / f"{name}.parquet") for name in ("runs", "states"))
    keep = chosen(runs, given.only or given.without)
    if given.without:
        keep = [not own for own in keep]
    if not any(keep):
        sys.exit("error: no run is left")
    names = {name for name, own in zip(runs["run"].to_pylist(), keep) if own}
    given.target.mkdir(parents=True)
    for name in FILES:
        if (given.source / name).is_file():
            shutil.copy(given.source / name, given.target / name)
    ship_data.write(runs.filter(pa.array(keep)), given.target / "runs.parquet")
    ship_data.write(states.filter(pa.array([name in names for name in states["run"].to_pylist()])), given.target / "states.parquet")
    content = ship_data.digest([ship_data.FIRST_LINE, *(ship_data.sha256(given.target / name) for name in ("runs.parquet", "states.parquet"))])
    sums = [f"{ship_data.sha256(given.target / name)}  {name}" for name in FILES if (given.target / name).is_file()]
    (given.target / "SHA256SUMS").write_text("\n".join([ship_data.FIRST_LINE, f"# content {content}", *sums]) + "\n")
    print(f"{given.target}: {len(names)} of {runs.num_rows} runs")


if __name__ == "__main__":
    main()
