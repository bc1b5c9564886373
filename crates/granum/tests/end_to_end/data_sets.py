"""Reads a data set with the programs that people learn from: run in the folder of the campaign `study` by data_sets.rs."""
import json
import tomllib

import duckdb
import h5py
import jsonschema
import mlcroissant
import pandas
import polars

# pandas, as the card says.
runs = pandas.read_parquet("study/dataset/runs.parquet").set_index("run")
states = pandas.read_parquet("study/dataset/states.parquet")
assert len(runs) == 4 and len(states) == 20
assert sorted(runs["variable.friction"]) == [0.2, 0.2, 0.4, 0.4]
assert runs["passed"].dtype == bool and str(states["state"].dtype) == "int64"
beside = states.join(runs.filter(like="variable."), on="run")
assert beside["variable.strain"].notna().all()
# A histogram is a list in each row; its densities over its bins, and what lies outside, are all values.
width = beside["run"].map(runs["forces.bin_width"])
inside = states["probability_density"].map(sum) * width
outside = (states["forces_below"] + states["forces_above"]) / states["forces_counted"]
assert ((inside + outside - 1).abs() < 1e-12).all()

# polars
frame = polars.read_parquet("study/dataset/states.parquet")
assert frame["probability_density"].dtype == polars.List(polars.Float64) and frame.height == 20
assert frame["probability_density"].list.len().unique().to_list() == [int(runs["forces.bins"].iloc[0])]

# DuckDB
peaks = duckdb.sql(
    "SELECT run, max(stress_ratio) AS peak, len(any_value(probability_density)) AS bins "
    "FROM 'study/dataset/states.parquet' JOIN 'study/dataset/runs.parquet' USING (run) GROUP BY run"
).df().set_index("run")
assert (peaks["peak"].sort_index() == states.groupby("run")["stress_ratio"].max()).all()

# Croissant: no errors, and the records are those of the files.
described = mlcroissant.Dataset(jsonld="study/dataset/metadata.json")
assert not described.metadata.ctx.issues.errors, described.metadata.ctx.issues.report()
assert [record["runs/run"].decode() for record in described.records("runs")] == list(runs.index)
first = next(iter(described.records("states")))
assert list(first["states/probability_density"]) == list(states["probability_density"].iloc[0])

# The layout of GrainLearning: what its Preprocessor_Triaxial_Compression takes.
with h5py.File("study.hdf5") as file:
    assert list(file.attrs["contact_params"]) == ["grains.material.friction"]
    assert list(file.attrs["outputs"])[0] == "void_ratio"
    assert list(file.attrs["inputs_drained"]) == ["axial_strain", "lateral_strain_2", "lateral_strain_3"]
    assert list(file.attrs["unused_keys_sequence"]) == []
    data = file["100000"]["drained"]
    assert data["inputs"].shape == (4, 5, 3) and data["contact_params"].shape == (4, 1)
    assert data["outputs"].shape == (4, 5, len(file.attrs["outputs"]))
    mean_stress = states[states["run"] == runs.index[0]]["mean_stress"].to_numpy()
    assert (data["outputs"][0, :, 1] == mean_stress / 1e6).all()

# The schema of plans accepts the plan and refuses a mistake.
schema = json.load(open("schema.json"))
plan = tomllib.load(open("keep.toml", "rb"))
jsonschema.Draft202012Validator.check_schema(schema)
jsonschema.validate(plan, schema)
plan["keeps"] = "dataset"
try:
    jsonschema.validate(plan, schema)
    raise SystemExit("the schema takes an unknown key")
except jsonschema.ValidationError:
    pass
print("all read")
