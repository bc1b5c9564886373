"""Cases as objects: the rules of the case file, and its errors."""

import copy
import inspect
import pathlib
import pickle
from typing import Any

import granum
import numpy as np
import pytest


def test_a_case_is_the_case_of_its_file(case: granum.Case) -> None:
    text = "grains.count = 60\npreparation.solid_fraction = 'none'\npreparation.unbalanced_force = 0.05\n"
    text += "shear.deviator_strain = 0.01\nshear.inertial_number = 0.01\nrecording.states = 4\n"
    assert granum.Case.from_toml(text) == case
    assert granum.Case.from_toml(text).digest == case.digest
    assert case != granum.Case()
    assert case != 3


def test_toml_dict_repr_pickle_and_copy_give_the_same_case(case: granum.Case) -> None:
    staged = granum.Case(
        stages=[
            {"path": "isotropic", "mean_stress": "50 kPa"},
            {"path": "undrained-triaxial", "axial_strain": 0.1},
        ],
        materials=[{"name": "glass", "share": 0.5}, {"name": "rubber", "share": 0.5, "youngs_modulus": "1 GPa"}],
        grains={"count": 200},
    )
    for one in [case, granum.Case(), staged]:
        assert granum.Case.from_toml(one.to_toml()) == one
        assert granum.Case.from_dict(one.to_dict()) == one
        assert eval(repr(one), {"granum": granum, "inf": float("inf"), "nan": float("nan")}) == one
        assert pickle.loads(pickle.dumps(one)) == one
        assert copy.copy(one) is one and copy.deepcopy(one) is one
        assert hash(pickle.loads(pickle.dumps(one))) == hash(one)


def test_values_of_numpy_and_texts_with_units_are_read() -> None:
    same = [
        granum.Case(grains={"count": 500, "diameter": 2e-4}),
        granum.Case(grains={"count": np.int64(500), "diameter": "0.2 mm"}),
        granum.Case(grains={"count": np.array(500), "diameter": np.float64(2e-4), "spread": None}),
        granum.Case.from_dict({"grains.count": 500, "grains": {"diameter": "200 um"}}),
        granum.Case().with_values({"grains.count": 500, "grains.diameter": "0.2 mm"}),
    ]
    assert all(one == same[0] for one in same)
    assert same[0]["grains.diameter"] == 2e-4
    assert "grains.diameter" in same[0].keys()


def test_quantities_of_pint_are_read() -> None:
    pint = pytest.importorskip("pint")
    units = pint.UnitRegistry()
    assert granum.Case(preparation={"mean_stress": 50 * units.kPa}) == granum.Case(preparation={"mean_stress": "50 kPa"})


@pytest.mark.parametrize(
    ("sections", "key", "word"),
    [
        ({"contact": {"dampling": 0.1}}, "contact.dampling", "did you mean damping?"),
        ({"grains": {"count": -1}}, "grains.count", "from 50"),
        ({"grains": {"count": "many"}}, "grains.count", "whole number"),
        ({"grains": {"diameter": "3 kPa"}}, "grains.diameter", "is a stress"),
        ({"preparation": {"mean_stress": 200}}, "preparation.mean_stress", "200 kPa"),
        ({"grains": {"count": object()}}, "grains.count", "not object"),
        ({"grains": 3}, "grains", "is not a section"),
        ({"wheat": {"count": 3}}, "wheat.count", "unknown section"),
        ({"grains": {3: 4}}, "grains", "a key of a case is a text"),
        ({"stages": [{"path": "oedometr"}]}, "stage", "did you mean oedometer?"),
    ],
)
def test_mistakes_are_exceptions_with_key_value_and_remedy(sections: dict[str, Any], key: str, word: str) -> None:
    with pytest.raises(granum.CaseError, match="(?s).") as caught:
        granum.Case(**sections)
    assert caught.value.key == key
    assert word in str(caught.value)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, granum.Error)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.mistakes == caught.value.mistakes


def test_all_mistakes_are_told_at_once_and_those_of_a_file_with_their_places(tmp_path: pathlib.Path) -> None:
    with pytest.raises(granum.CaseError) as caught:
        granum.Case(grains={"count": 1, "spread": -1})
    assert [mistake.key for mistake in caught.value.mistakes] == ["grains.count", "grains.spread"]
    assert caught.value.mistakes[0].file is None
    file = tmp_path / "case.toml"
    file.write_text("[contact]\ndampling = 0.1\n")
    with pytest.raises(granum.CaseError) as caught:
        granum.Case.read(file)
    first = caught.value.mistakes[0]
    assert (first.key, first.value, first.line, first.column) == ("contact.dampling", "0.1", 2, 1)
    assert first.file is not None and first.file.endswith("case.toml")
    with pytest.raises(granum.FileError, match="cannot read"):
        granum.Case.read(tmp_path / "missing.toml")


def test_values_nested_without_end_are_refused() -> None:
    nested: dict[str, Any] = {}
    nested["a"] = nested
    with pytest.raises(granum.CaseError, match="nested deeper"):
        granum.Case.from_dict(nested)
    class Endless:
        def tolist(self) -> "Endless":
            return self

    with pytest.raises(granum.CaseError, match="not Endless"):
        granum.Case.from_dict({"grains": {"count": Endless()}})
    rows: list[Any] = []
    rows.append(rows)
    with pytest.raises(granum.CaseError, match="nested deeper"):
        granum.Case.from_dict({"grains": {"count": rows}})


def test_a_named_path_takes_its_parameters(case: granum.Case) -> None:
    drained = case.with_path("drained-triaxial", axial_strain="5 %")
    assert drained == case.with_path("drained-triaxial", axial_strain=0.05)
    assert "drained-triaxial" in granum.paths()
    with pytest.raises(granum.CaseError, match="did you mean axial_strain"):
        case.with_path("drained-triaxial", axial_stran=0.1)
    with pytest.raises(granum.CaseError, match="is not a path"):
        case.with_path("nowhere")
    with pytest.raises(KeyError, match="grains.cout"):
        case["grains.cout"]


def test_the_keys_for_editors_are_those_of_the_case() -> None:
    import generate_keys

    assert generate_keys.FILE.read_text(encoding="utf-8") == generate_keys.text(), "run python python/tools/generate_keys.py"
    stub = pathlib.Path(inspect.getfile(granum)).with_name("_granum.pyi").read_text(encoding="utf-8")
    signature = stub.split("def __new__(")[1].split(") -> Case")[0]
    named = {line.split(":")[0].strip() for line in signature.splitlines() if ": keys." in line or "Sequence[keys" in line}
    plurals = {"stage": "stages", "material": "materials", "pair": "pairs"}
    assert named == {plurals.get(key, key) for key in granum.schema()["properties"]}
