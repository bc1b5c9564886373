#!/usr/bin/env python3
"""Makes the data set of a family that is shipped with granum from the data set of a campaign: fewer states and columns, numbers of
16 bits, compressed. What comes out is a data set as any other: `granum train`, `granum export` and `granum evaluate` read it.

    python3 scripts/ship_data.py CAMPAIGN/dataset data/families/sand/drained --plan sand-drained.toml

Needs Python with pyarrow (python3 -m venv env; env/bin/pip install pyarrow). States are kept where curves change most: of each stage every
one of the first 24, every second of the next 24, every fifth of the others, and the last. Columns are
those of COLUMNS and the distribution of contact forces. With --path all states are kept, since increments between them are learned from, with the columns of
PATH: strains, stresses and fabric with all components. Numbers are rounded to 16 significant bits,
by less than 8e-6 of their value. Parquet is compressed by gzip over
byte streams (BYTE_STREAM_SPLIT), which every reader knows; zstd would need a C compiler where granum is built.
"""
import argparse
import hashlib
import json
import math
import pathlib
import re
import shutil
import struct

import pyarrow as pa
import pyarrow.parquet as pq

COLUMNS = """run stage state observations deviator_strain axial_strain lateral_strain_2 lateral_strain_3 volumetric_strain stress_11
stress_22 stress_33 mean_stress deviator_stress stress_ratio fabric_11
fabric_22 fabric_33 deviator_fabric strong_deviator_fabric weak_deviator_fabric strong_fraction mean_normal_force mean_square_force
coordination_number mechanical_coordination_number rattler_fraction contacts solid_fraction sliding_fraction inertial_number
largest_overlap arc_length
forces_below forces_above forces_counted probability_density""".split()
PATH = """run stage state axial_strain lateral_strain_2 lateral_strain_3 shear_strain_yz shear_strain_zx shear_strain_xy volumetric_strain stress_11
stress_22 stress_33 stress_12 stress_13 stress_23 mean_stress fabric_11 fabric_22 fabric_33 fabric_12 fabric_13 fabric_23
mechanical_coordination_number solid_fraction sliding_fraction arc_length""".split()
ALL_OF, HALF_OF, EVERY = 24, 24, 5
BITS = 16
LICENCE = "https://creativecommons.org/licenses/by/4.0/"
FIRST_LINE = "# granum data set 1"


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def digest(texts):
    """The SHA-256 of texts, each with its length, as granum computes it."""
    sum_ = hashlib.sha256()
    for text in texts:
        sum_.update(struct.pack("<Q", len(text.encode())))
        sum_.update(text.encode())
    return sum_.hexdigest()


def kept_states(runs, stages):
    """The rows that are kept, stage by stage."""
    kept, start = [], 0
    while start < len(runs):
        end = start
        while end < len(runs) and (runs[end], stages[end]) == (runs[start], stages[start]):
            end += 1
        for row in range(start, end):
            number = row - start
            fine = number < ALL_OF
            half = ALL_OF <= number < ALL_OF + HALF_OF and number % 2 == 0
            rest = number >= ALL_OF + HALF_OF and number % EVERY == 0
            if row == end - 1 or fine or half or rest:
                kept.append(row)
        start = end
    return kept


def rounded(values):
    def one(value):
        if value is None or not math.isfinite(value):
            return value
        part, exponent = math.frexp(value)
        return math.ldexp(round(part * 2**BITS), exponent - BITS)

    return [one(value) for value in values]


def rounded_column(column, field):
    """A column with rounded numbers; lists keep their lengths."""
    if pa.types.is_floating(field.type):
        return pa.array(rounded(column.to_pylist()), type=field.type)
    if pa.types.is_list(field.type):
        return pa.array([rounded(values) for values in column.to_pylist()], type=field.type)
    return column.combine_chunks()


def states(source, is_path):
    table = pq.read_table(source / "states.parquet")
    table = table.select([name for name in table.column_names if name in (PATH if is_path else COLUMNS)])
    if not is_path:
        table = table.take(kept_states(table["run"].to_pylist(), table["stage"].to_pylist()))
    columns = [rounded_column(table[field.name], field) for field in table.schema]
    return pa.Table.from_arrays(columns, schema=table.schema)


def with_counts(runs, states_):
    """The runs with the number of states that are kept of each."""
    counts = {}
    for run in states_["run"].to_pylist():
        counts[run] = counts.get(run, 0) + 1
    at = runs.schema.get_field_index("states")
    field = runs.schema.field(at)
    return runs.set_column(at, field, pa.array([counts[run] for run in runs["run"].to_pylist()], type=field.type))


def write(table, path):
    floats = [field.name for field in table.schema if pa.types.is_floating(field.type)]
    lists = [f"{field.name}.list.element" for field in table.schema if pa.types.is_list(field.type)]
    # One group of rows, and no statistics: the files are small.
    pq.write_table(
        table, path, compression="gzip", compression_level=9, use_dictionary=False, write_statistics=False, row_group_size=1 << 30,
        column_encoding={name: "BYTE_STREAM_SPLIT" for name in floats + lists},
    )


def card(text, count, dropped, content, before, is_path):
    """The card of the campaign's data set with what was left out of it."""
    lines = [line for line in text.splitlines() if not any(line.startswith(f"| `{name}` |") for name in dropped)]
    about = [
        "", "## What is left out", "",
        f"This is a smaller form of the data set that the plan gives ({before} states): {count} states are kept, "
        f"{'all of them' if is_path else f'every one where curves change most and every {EVERY}th elsewhere'}, numbers have {BITS} significant bits (they differ by less than 8e-6 of their value), and of the columns of states these are left out: "
        f"{', '.join(dropped)}. `granum campaign plan.toml` gives everything again, and `scripts/ship_data.py` of granum this form of it.",
        "", f"Licence: CC-BY-4.0 ({LICENCE}).", "",
    ]
    at = next(k for k, line in enumerate(lines) if line.startswith("## How to read it"))
    text = "\n".join(lines[:at] + about[1:] + lines[at:]) + "\n"
    old = [word for line in text.splitlines() if "SHA-256 over the content" in line for word in line.split("`") if len(word) == 64]
    text = text.replace("the same plan gives these files again, bit by bit.", "the same plan gives the same results again, bit by bit.")
    return text.replace(old[0], content) if old else text


def metadata(text, sums, dropped, content, is_path):
    described = json.loads(text)
    described["license"] = LICENCE
    for file in described["distribution"]:
        file["sha256"] = sums[file["name"]]
    for records in described["recordSet"]:
        if records["name"] == "states":
            records["field"] = [field for field in records["field"] if field["source"]["extract"]["column"] not in dropped]
    described["name"] = f"granum-{content[:12]}"
    described["description"] = (
        described["description"].split(" SHA-256")[0] + f" {'Numbers are rounded' if is_path else 'States are thinned and rounded'}. SHA-256 over the content: {content}"
    )
    # Without the spaces at the beginnings of lines, which would be a third of the file.
    return json.dumps(described, indent=0) + "\n"


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("source", type=pathlib.Path, help="the data set of a campaign")
    arguments.add_argument("target", type=pathlib.Path, help="the folder to write")
    arguments.add_argument("--plan", type=pathlib.Path, required=True, help="the plan of the campaign, which is copied beside the data")
    arguments.add_argument("--path", action="store_true", help="keep all states, with the columns of paths of strain")
    given = arguments.parse_args()
    source, target = given.source, given.target
    target.mkdir(parents=True, exist_ok=True)
    kept = states(source, given.path)
    runs = with_counts(pq.read_table(source / "runs.parquet"), kept)
    whole = pq.read_schema(source / "states.parquet")
    dropped = [name for name in whole.names if name not in kept.column_names]
    write(kept, target / "states.parquet")
    write(runs, target / "runs.parquet")
    for name in ["case.toml", "left_out.csv"]:
        if (source / name).is_file():
            shutil.copy(source / name, target / name)
    # The base case lies beside the plan under another name.
    plan = re.sub(r'^case = ".*"$', 'case = "case.toml"', given.plan.read_text(), flags=re.MULTILINE)
    (target / "plan.toml").write_text(plan)
    sums = {name: sha256(target / name) for name in ["runs.parquet", "states.parquet"]}
    content = digest([FIRST_LINE, *sums.values()])
    before = pq.read_metadata(source / "states.parquet").num_rows
    (target / "README.md").write_text(card((source / "README.md").read_text(), kept.num_rows, dropped, content, before, given.path))
    (target / "metadata.json").write_text(metadata((source / "metadata.json").read_text(), sums, dropped, content, given.path))
    names = ["README.md", "case.toml", "left_out.csv", "metadata.json", "plan.toml", "runs.parquet", "states.parquet"]
    lines = [FIRST_LINE, f"# content {content}"]
    lines += [f"{sha256(target / name)}  {name}" for name in names if (target / name).is_file()]
    (target / "SHA256SUMS").write_text("\n".join(lines) + "\n")
    size = sum((target / name).stat().st_size for name in names if (target / name).is_file())
    print(f"{target}: {runs.num_rows} runs, {kept.num_rows} of {before} states, {size / 1e6:.2f} MB")


if __name__ == "__main__":
    main()
