"""Tables, assemblies, and sensors on anyone's arrays."""

import pathlib
import pickle

from typing import Any

import granum
import numpy as np
import pytest


def test_columns_are_read_only_arrays_without_a_copy(tested: granum.Run) -> None:
    series = tested.series
    ratio = series["stress_ratio"]
    assert ratio.dtype == np.float64 and not ratio.flags.writeable and len(ratio) == len(series) == 5
    assert np.shares_memory(ratio, series["stress_ratio"])
    kept = ratio.copy()
    del series
    assert np.array_equal(ratio, kept)
    with pytest.raises(ValueError, match="read-only"):
        ratio[0] = 1.0
    with pytest.raises(KeyError, match="did you mean stress_ratio"):
        tested.series["stress_rato"]


def test_tables_are_like_dicts_and_go_to_pandas_and_polars(tested: granum.Run) -> None:
    series = tested.series
    assert "stress_ratio" in series and "nothing" not in series and 3 not in series
    assert list(series) == series.columns == list(series.to_dict()) == series.keys()
    assert series.units["mean_stress"] == "Pa"
    pandas = pytest.importorskip("pandas")
    frame = series.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame.attrs["units"]["mean_stress"] == "Pa"
    assert np.array_equal(frame["stress_ratio"], series["stress_ratio"])
    polars = pytest.importorskip("polars")
    assert isinstance(series.to_polars(), polars.DataFrame)
    assert series.to_polars()["stress_ratio"].to_list() == list(series["stress_ratio"])


def test_a_table_goes_to_whatever_reads_arrow_without_a_copy(tested: granum.Run) -> None:
    pyarrow = pytest.importorskip("pyarrow")
    polars = pytest.importorskip("polars")
    series = tested.series
    arrow = pyarrow.table(series)
    assert arrow.column_names == series.columns and arrow.schema.field("mean_stress").metadata == {b"unit": b"Pa"}
    column = arrow.column("stress_ratio").chunk(0)
    assert column.buffers()[1].address == series["stress_ratio"].__array_interface__["data"][0]
    assert np.array_equal(column.to_numpy(), series["stress_ratio"])
    assert pyarrow.schema(series) == arrow.schema
    assert polars.DataFrame(series).equals(series.to_polars())
    table = granum.Table({"count": [1, 2], "law": ["hertz", "linear"], "good": [True, False], "x": [0.5, float("inf")]})
    assert pyarrow.table(table).to_pydict() == {"count": [1, 2], "law": ["hertz", "linear"], "good": [True, False], "x": [0.5, float("inf")]}
    assert pyarrow.table(granum.Table({})).num_columns == 0
    kept = pyarrow.table(granum.Table({"x": np.arange(1000.0)}))
    assert kept.column("x").to_pylist()[-1] == 999.0
    for frame in [table.to_pandas(), table.to_polars()]:
        assert granum.Table(frame) == table


def test_tables_go_to_xarray_with_units_and_meanings(tested: granum.Run) -> None:
    pytest.importorskip("xarray")
    series = tested.series.to_xarray()
    assert series["mean_stress"].attrs["units"] == "Pa" and "sigma_1" in series["mean_stress"].attrs["description"]
    assert series.sizes["row"] == 5 and "state" in series.coords
    forces = tested.table("forces")
    histogram = forces.to_xarray()
    assert histogram["count"].dims == ("row", "force") and histogram.sizes["row"] == 5
    assert histogram["count"].sum() == forces["count"].sum()
    row = histogram.isel(row=3)
    of_state = forces["state"] == row["state"].item()
    filled = row["count"].where(row["count"] > 0, drop=True)
    assert np.array_equal(filled, forces["count"][of_state & (forces["count"] > 0)])
    assert np.array_equal(filled["force"], forces["force"][of_state & (forces["count"] > 0)])


def test_own_tables_are_written_read_and_pickled(tmp_path: pathlib.Path) -> None:
    table = granum.Table(
        {"count": [1, 2], "ratio": np.array([0.5, np.inf]), "law": ["hertz", "linear"], "good": [True, False]},
        units={"ratio": "Pa"},
    )
    assert pickle.loads(pickle.dumps(table)) == table
    assert list(table["law"]) == ["hertz", "linear"] and table["count"].dtype == np.int64 and table["good"].dtype == bool
    table.write(tmp_path / "table.parquet")
    assert granum.Table.read(tmp_path / "table.parquet") == table
    with pytest.raises(granum.FileError, match="force=True"):
        table.write(tmp_path / "table.parquet")
    table.write(tmp_path / "table.parquet", force=True)
    with pytest.raises(granum.Error, match="rows"):
        granum.Table({"a": [1.0], "b": [1.0, 2.0]})
    with pytest.raises(granum.Error, match="one dimension"):
        granum.Table({"a": [[1.0]]})
    assert len(granum.Table({})) == 0
    for wrong, word in [([2**53 + 1], "not below 2"), ([1, None], "row 0 is int"), ([1j], "complex"), ([b"a"], "real numbers")]:
        with pytest.raises(granum.CaseError, match=word) as caught:
            granum.Table({"a": wrong})
        assert caught.value.key == "a"
    assert granum.Table({"a": [2**53 - 1]})["a"][0] == 2**53 - 1
    with pytest.raises(granum.CaseError, match="no column b"):
        granum.Table({"a": [1.0]}, units={"b": "Pa"})


def test_an_assembly_has_its_arrays_and_its_tables(tested: granum.Run) -> None:
    assembly = tested.snapshot()
    count, contacts = len(assembly.radii), len(assembly.contacts)
    assert assembly.positions.shape == (count, 3) == (60, 3)
    assert assembly.forces.shape == assembly.normals.shape == (contacts, 3)
    assert np.allclose(np.linalg.norm(assembly.normals, axis=1), 1.0)
    pulled = -np.sum(assembly.forces * assembly.normals, axis=1)
    assert np.allclose(pulled, assembly.normal_forces)
    assert np.isclose(np.linalg.det(assembly.cell), assembly.volume)
    grains = assembly.grains_table()
    assert np.array_equal(grains["position_x"], assembly.positions[:, 0]) and grains.units["radius"] == "m"
    assert len(assembly.contacts_table()) == contacts
    # Stress from the arrays, as a reader would compute it: the forces with the branches over the volume.
    stress = -np.einsum("ca,cb->ab", assembly.branches, assembly.forces) / assembly.volume
    measured = assembly.measure()
    assert np.isclose(np.trace(stress) / 3, measured["mean_stress"], rtol=1e-9)


def test_sensors_on_arrays_of_anyone_give_what_they_give_on_an_assembly(tested: granum.Run) -> None:
    assembly = tested.snapshot()
    own = assembly.measure()
    found = granum.measure(assembly.positions, assembly.radii, assembly.contacts, assembly.forces, assembly.cell)
    assert len(found) > 80
    for name in ["solid_fraction", "coordination_number", "mean_stress", "stress_ratio"]:
        assert np.isclose(found[name], own[name], rtol=1e-9), name
    geometric = granum.measure(assembly.positions.tolist(), list(assembly.radii), cell=assembly.cell)
    assert "solid_fraction" in geometric and "mean_stress" not in geometric
    strided = np.zeros((120, 6))
    strided[::2, ::2] = assembly.positions
    assert granum.measure(strided[::2, ::2], assembly.radii.astype("f4").astype("f8"), cell=assembly.cell)


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        ({"positions": [[0.0, 0.0]]}, "rows of three"),
        ({"radii": [1.0]}, "there are 2 positions"),
        ({"radii": [1.0, np.nan]}, r"radii\[1\] is NaN"),
        ({"positions": [[0.0, 0.0, 0.0], [1.5, np.inf, 0.0]]}, r"positions\[1, 1\] is inf"),
        ({"contacts": [[0, 1]], "forces": [[0.0, 1.0, np.nan]]}, r"forces\[0, 2\] is NaN"),
        ({"cell": [1.0, np.nan, 1.0]}, r"cell\[1\] is NaN"),
        ({"radii": ["1", "1"]}, "of the type <U1"),
        ({"radii": [1.0, None]}, "of the type object"),
        ({"radii": [1.0, 1j]}, "of the type complex128"),
        ({"contacts": [[0, 2**60]]}, "not below 2"),
        ({"contacts": [[0, 2]]}, "no index"),
        ({"contacts": [[0, -1]]}, "no index"),
        ({"contacts": [[0, 0.5]]}, "no index"),
        ({"contacts": [[0, 0]]}, r"contacts\[0\]: has both grains at one place"),
        ({"contacts": [[0, 1], [1, 1]], "forces": [[1.0, 0.0, 0.0]] * 2}, r"contacts\[1\]: has both grains at one place"),
        ({"radii": [1.0, -1.0]}, r"radii\[1\]: radius = -1 must be positive"),
        ({"radii": [1.0, 1e-9]}, r"radii\[1\]: radius = 1e-9 m does not belong to the others"),
        ({"cell": [4.0, 4.0, 1.5]}, r"radii\[0\]: radius = 1e0 m does not fit in the cell"),
        ({"cell": [1.0, 1.0, 0.0]}, "the cell has the volume 0e0 m3"),
        ({"positions": [[0.0, 0.0, 0.0], [1e9, 0.0, 0.0]], "cell": [9.0, 9.0, 9.0]}, r"positions\[1\]: .*cells away along edge a"),
        ({"forces": [[1.0, 0.0, 0.0]]}, "1 forces for 0 contacts"),
        ({"cell": [1.0]}, "three lengths"),
    ],
)
def test_impossible_arrays_are_refused(arguments: dict[str, Any], word: str) -> None:
    usual: dict[str, Any] = {"positions": [[0.0, 0.0, 0.0], [1.5, 0.0, 0.0]], "radii": [1.0, 1.0]}
    with pytest.raises(granum.CaseError, match=word) as caught:
        granum.measure(**{**usual, **arguments})
    named = {key for key in ["positions", "radii", "contacts", "forces", "cell"] if key in arguments or key in word}
    assert caught.value.key in named


def test_a_family_predicts_with_intervals() -> None:
    sand = granum.surrogates.load("sand")
    assert ("sand", sand.path) in granum.surrogates.families() and sand.runs > 100
    given = {name: sum(about["range"]) / 2 for name, about in sand.inputs.items() if about["required"]}
    answer = sand.predict(given, level=0.8)
    assert answer["inputs"] == given and answer["level"] == 0.8
    curve = answer["curves"]["stress_ratio"]
    assert len(curve["mean"]) == len(answer["points"]) and np.all(curve["lower"] <= curve["mean"])
    assert np.all(curve["mean"] <= curve["upper"])
    assert pickle.loads(pickle.dumps(sand)).predict(given)["points"][0] == answer["points"][0]
    with pytest.raises(granum.Error, match="needs"):
        sand.predict({})
    with pytest.raises(granum.CaseError):
        sand.predict({"nonsense": 1.0})
    with pytest.raises(granum.CaseError, match="friction"):
        sand.predict({**given, "friction": "3 mm"})
    with pytest.raises(granum.CaseError, match="friction: NaN is not finite"):
        sand.predict({**given, "friction": float("nan")})
    with pytest.raises(granum.Error, match="snow"):
        granum.surrogates.load("snow")


def test_every_family_and_path_predicts() -> None:
    found = granum.surrogates.families()
    assert ("sand", "undrained-triaxial") in found and ("powder", "oedometer") in found
    for name, path in found:
        family = granum.surrogates.load(name, path)
        given = {key: sum(about["range"]) / 2 for key, about in family.inputs.items() if about["required"]}
        curve = family.predict(given)["curves"]["stress_ratio"]
        assert np.all(curve["lower"] <= curve["upper"]) and abs(curve["mean"][0]) < 0.1, (name, path)
