"""Cases as objects: the rules of the case file, and its errors."""

import array
import collections
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


def test_quantities_of_pint_are_converted_to_the_same_bits_as_texts() -> None:
    pint = pytest.importorskip("pint")
    units = pint.UnitRegistry()

    def stress(value: Any) -> Any:
        return granum.Case(preparation={"mean_stress": value})["preparation.mean_stress"]

    for text in ["50 kPa", "0.05 MPa", "0.7 bar", "3 N/mm^2", "7 kN/m^2", "50000 kg/m/s^2", "50 mbar"]:
        number, unit = text.split(" ", 1)
        for magnitude in [float(number), np.float64(number), np.array(float(number))]:
            assert stress(magnitude * units(unit)) == stress(text), text
    # Units that granum does not know are converted by pint.
    assert stress(10 * units.psi) == pytest.approx(68947.57, rel=1e-6)
    assert stress(0.5 * units.atm) == pytest.approx(50662.5)
    diameters = [granum.Case(grains={"diameter": value})["grains.diameter"] for value in ["0.7 mm", 0.7 * units.mm, 700 * units.um]]
    assert diameters == [7e-4] * 3
    assert granum.Case(grains={"spread": 20 * units.percent}) == granum.Case(grains={"spread": 0.2})
    other = pint.UnitRegistry(system="cgs")
    assert stress(7e5 * other.dyne / other.cm**2) == pytest.approx(7e4)
    curve = [0.1, 0.2] * units.mm
    assert granum.Case().with_values({"grains.diameter": curve[1]})["grains.diameter"] == 2e-4


def test_quantities_of_pint_of_another_dimension_are_refused(tested: granum.Run) -> None:
    pint = pytest.importorskip("pint")
    units = pint.UnitRegistry()
    for wrong, word in [(3 * units.mm, "is a length"), (3 * units.psi * units.inch, "is an energy per area"), (3 * units.kelvin, "unknown unit")]:
        with pytest.raises(granum.CaseError, match=word) as caught:
            granum.Case(preparation={"mean_stress": wrong})
        assert caught.value.key == "preparation.mean_stress"
    simulation = tested.simulation()
    simulation.control(mean_stress=20 * units.kPa, strain_rate={"zz": 1 / units.minute})
    with pytest.raises(granum.CaseError, match="is a length"):
        simulation.control(mean_stress=20 * units.mm)
    with pytest.raises(granum.CaseError, match="nan|finite"):
        granum.Case(preparation={"mean_stress": float("nan") * units.kPa})


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
        ({"wheat": {"count": 3}}, "wheat", "unknown section"),
        ({"grains": {3: 4}}, "grains", "a key of a case is a text"),
        ({"stages": [{"path": "oedometr"}]}, "stage.1.path", "did you mean oedometer?"),
        ({"stages": [{"path": "oedometer"}, {"path": "drained-triaxial", "axial_stran": 1}]}, "stage.2.axial_stran", "axial_strain"),
        ({"stages": [{"path": "drained-triaxial", "axial_strain": 7}]}, "stage.1.axial_strain", "out of bounds"),
        ({"stages": [{"repeat": 2, "stage": [{"path": "drained-triaxial", "axial_strain": "1 kPa"}]}]}, "stage.1.1.axial_strain", "is a stress"),
        ({"stages": [{"zz": {"rate": -1}, "until": {"zz_strain": "x"}}]}, "stage.1.until.zz_strain", "number"),
        ({"preparation": {"stage": [{"path": "nowhere"}]}}, "preparation.stage.1.path", "nowhere"),
        ({"materials": [{"name": "glass", "share": 0.5}, {"name": "lead", "share": 0.5, "friction": -1}]}, "material.lead.friction", "from 0"),
        (
            {"materials": [{"name": "a", "share": 0.5}, {"name": "b", "share": 0.5}], "pairs": [{"between": ["a", "b"], "friction": -1}]},
            "pair.a.b.friction",
            "from 0",
        ),
        ({"grains": {"count": 2**70}}, "grains.count", "1180591620717411303424"),
        ({"grains": {"count": 60.5}}, "grains.count", "whole number"),
        ({"grains": {"count": float("nan")}}, "grains.count", "nan"),
        ({"grains": {"diameter": float("nan")}}, "grains.diameter", "nan"),
        ({"grains": {"count": {60}}}, "grains.count", "not set"),
        ({"grains": {"count": b"60"}}, "grains.count", "not bytes"),
    ],
)
def test_mistakes_are_exceptions_with_key_value_and_remedy(sections: dict[str, Any], key: str, word: str) -> None:
    with pytest.raises(granum.CaseError) as caught:
        granum.Case(**sections)
    assert caught.value.key == key, str(caught.value)
    assert word in str(caught.value)
    assert isinstance(caught.value, ValueError) and isinstance(caught.value, granum.Error)
    again = pickle.loads(pickle.dumps(caught.value))
    assert str(again) == str(caught.value) and again.mistakes == caught.value.mistakes


def test_values_that_are_given_by_key_have_the_same_mistakes() -> None:
    case = granum.Case(stages=[{"path": "oedometer"}, {"path": "drained-triaxial"}])
    for key, value, remedy in [
        ("stage.2.axial_strain", 7, "it must be"),
        ("stage.2.axial_stran", 0.1, "did you mean"),
        ("grains.cout", 100, "did you mean"),
        ("preparation.mean_stress", "3 mm", "it must be a stress"),
    ]:
        with pytest.raises(granum.CaseError) as caught:
            case.with_values({key: value})
        assert (caught.value.key, caught.value.value) == (key, str(value)), str(caught.value)
        assert caught.value.remedy is not None and remedy in caught.value.remedy, caught.value.remedy


def test_a_table_with_a_hole_is_refused_with_row_and_column() -> None:
    pandas = pytest.importorskip("pandas")
    rows = pandas.DataFrame({"xx_strain": [0.0, 0.01, 0.02], "yy_stress": [1e5, np.nan, 1e5]})
    history: Any = {"path": "history", "columns": list(rows.columns), "rows": rows}
    with pytest.raises(granum.CaseError, match=r"\(row 2, column 2\)") as caught:
        granum.Case(stages=[history])
    assert (caught.value.key, caught.value.value) == ("stage.1.rows", "nan")
    curve = np.array([[1e-4, 0.3], [2e-4, np.nan]])
    with pytest.raises(granum.CaseError, match=r"value 2 = \[0.0002, nan\] is not finite.*\(row 2\)") as caught:
        granum.Case(grains={"distribution": "sieve-curve", "sieve_curve": curve})
    assert caught.value.key == "grains.sieve_curve"


def test_any_sequence_is_a_list() -> None:
    pandas = pytest.importorskip("pandas")
    curve = [[1e-4, 0.3], [2e-4, 1.0]]
    first = granum.Case(grains={"distribution": "sieve-curve", "sieve_curve": curve})
    frame = pandas.DataFrame(curve, columns=["diameter", "finer"])
    for same in [tuple(map(tuple, curve)), np.array(curve), frame, collections.deque(curve), [array.array("d", row) for row in curve]]:
        case = granum.Case(grains={"distribution": "sieve-curve", "sieve_curve": same})
        assert case == first
        assert first.with_values({"grains.sieve_curve": [[1e-4, 0.5], [2e-4, 1.0]]}).with_values({"grains.sieve_curve": same}) == first
    stages = [{"path": "oedometer"}, {"path": "drained-triaxial"}]
    assert granum.Case(stages=tuple(stages)) == granum.Case(stages=collections.deque(stages)) == granum.Case(stages=stages)  # type: ignore[arg-type]


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
    with pytest.raises(granum.CaseError, match="nested deeper"):
        granum.Case().with_values({"grains.sieve_curve": rows})


def test_files_of_keywords_may_lie_anywhere(tmp_path: pathlib.Path) -> None:
    a, b, c, d = "0 0 0", "1 0 0", "0 1 0", "0 0 1"
    facets = [f"facet normal 0 0 0\nouter loop\nvertex {x}\nvertex {y}\nvertex {z}\nendloop\nendfacet" for x, y, z in
              ((a, c, b), (a, b, d), (a, d, c), (b, c, d))]
    mesh = tmp_path / "grain.stl"
    mesh.write_text("solid grain\n" + "\n".join(facets) + "\nendsolid grain\n")
    grains: Any = {"count": 60, "shape": {"kind": "mesh", "file": str(mesh), "pieces": 4}}
    assert "mesh" not in granum.Case(grains=grains).to_toml()
    with pytest.raises(granum.CaseError, match="leads out of the folder"):
        granum.Case.from_dict({"grains": grains})


def test_a_named_path_takes_its_parameters(case: granum.Case) -> None:
    drained = case.with_path("drained-triaxial", axial_strain="5 %")
    assert drained == case.with_path("drained-triaxial", axial_strain=0.05)
    assert "drained-triaxial" in granum.paths()
    with pytest.raises(granum.CaseError, match="did you mean axial_strain"):
        case.with_path("drained-triaxial", axial_stran=0.1)
    with pytest.raises(granum.CaseError, match="is not a path"):
        case.with_path("nowhere")
    with pytest.raises(KeyError, match="grains.cout; did you mean grains.count"):
        case["grains.cout"]


def test_the_keys_for_editors_are_those_of_the_case() -> None:
    import generate_keys

    assert generate_keys.FILE.read_text(encoding="utf-8") == generate_keys.text(), "run python python/tools/generate_keys.py"
    stub = pathlib.Path(inspect.getfile(granum)).with_name("_granum.pyi").read_text(encoding="utf-8")
    signature = stub.split("def __new__(")[1].split(") -> Case")[0]
    named = {line.split(":")[0].strip() for line in signature.splitlines() if ": keys." in line or "Sequence[keys" in line}
    plurals = {"stage": "stages", "material": "materials", "pair": "pairs", "bond": "bonds"}
    assert named == {plurals.get(key, key) for key in granum.schema()["properties"]}
