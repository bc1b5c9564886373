"""Two grains on a path, with laws of granum and with functions of Python."""

import math
import pathlib
import subprocess
import sys
from typing import Any

import granum
import numpy as np
import pytest

CASE = granum.Case(contact={"normal": "hertz", "tangential": "no-slip"}, grains={"material": {"interface_energy": 0.0, "friction": 0.4}})
DIAMETER = float(CASE["grains.diameter"])  # type: ignore[arg-type]
YOUNG, POISSON = (float(CASE[f"grains.material.{name}"]) for name in ("youngs_modulus", "poissons_ratio"))  # type: ignore[arg-type]
RADIUS = DIAMETER / 4
MODULUS = YOUNG / (2 * (1 - POISSON**2))
SHEAR = YOUNG / (4 * (2 - POISSON) * (1 + POISSON))
PATH = {
    "normal_approach": [1e-8, 2e-8, 2e-8, 2e-8, 1e-8, -1e-9, 1e-8],
    "tangential_displacement": [0.0, 0.0, 2e-9, 3e-8, -1e-8, -1e-8, -9e-9],
}


def hertz(overlap: float, kept: list[float]) -> float:
    return 4 / 3 * MODULUS * math.sqrt(RADIUS) * math.pow(max(overlap, 0.0), 1.5)


def no_slip(force: Any, slip: Any, normal_force: float, radius: float, kept: list[float]) -> dict[str, Any]:
    """Mindlin's law without slip, which is rescaled on unloading and limited by friction."""
    before = kept[0]
    shrink = min(1.0, radius / before) if before > 0 else 1.0
    trial = [shrink * old + 8 * SHEAR * radius * step for old, step in zip(force, slip)]
    length, limit = math.hypot(*trial), 0.4 * normal_force
    factor = min(1.0, limit / length) if length > 0 else 1.0
    return {"force": [factor * part for part in trial], "kept": [radius]}


def test_a_pair_is_that_of_the_program(tmp_path: pathlib.Path) -> None:
    granum.Table(PATH).write(tmp_path / "path.csv")
    (tmp_path / "case.toml").write_text(CASE.to_toml())
    line = ["pair", "path.csv", "--case", "case.toml", "-o", "forces.parquet"]
    subprocess.run([sys.executable, "-m", "granum", *line], cwd=tmp_path, check=True, capture_output=True)
    program = granum.Table.read(tmp_path / "forces.parquet")
    assert granum.pair(tmp_path / "path.csv", CASE) == program
    table = granum.pair(granum.Table(PATH, units={"normal_approach": "m", "tangential_displacement": "m"}), CASE)
    assert all(np.array_equal(table[name], program[name]) for name in program.columns)
    assert table.units["normal_force"] == "N" and table["normal_force"][0] > 0 and table["tangential_force"][3] > 0


def test_a_law_of_python_gives_the_forces_of_the_same_law_of_granum() -> None:
    own = granum.pair(PATH, CASE)
    for given in [{"normal": hertz}, {"tangential": no_slip}, {"normal": hertz, "tangential": no_slip}]:
        table = granum.pair(PATH, CASE, **given)  # type: ignore[arg-type]
        for name in ["normal_force", "tangential_force", "contact_radius"]:
            assert np.allclose(table[name], own[name], rtol=1e-9, atol=1e-9 * np.abs(own[name]).max()), (given, name)
    # Friction limits the force, and apart there is none.
    assert np.isclose(own["tangential_force"][3], 0.4 * own["normal_force"][3]) and own["normal_force"][5] == 0


def test_a_law_keeps_numbers_while_the_pair_touches() -> None:
    def crushed(overlap: float, kept: list[float]) -> dict[str, Any]:
        largest = max(kept[0], overlap)
        force = 1e6 * overlap**3 / largest**2 if overlap > 0 else 0.0
        return {"force": force, "radius": overlap / 2, "kept": [largest]}

    table = granum.pair({"normal_approach": [2e-8, 1e-8, -1e-9, 1e-8], "tangential_displacement": [0.0] * 4}, CASE, normal=crushed)
    # Unloaded along another curve than it was loaded; the next contact is a new one.
    assert np.allclose(table["normal_force"], [1e6 * 2e-8, 1e6 * 1e-8 / 4, 0.0, 1e6 * 1e-8])
    assert np.allclose(table["contact_radius"], [1e-8, 5e-9, 0.0, 5e-9])


def test_a_law_with_tension_touches_where_it_pulls() -> None:
    def sticky(overlap: float, _: list[float]) -> float:
        return 100.0 * overlap if overlap > -1e-8 else 0.0

    table = granum.pair({"normal_approach": [1e-8, -5e-9, -2e-8], "tangential_displacement": [0.0] * 3}, CASE, normal=sticky)
    assert np.allclose(table["normal_force"], [1e-6, -5e-7, 0.0])


@pytest.mark.parametrize(
    ("answer", "error", "message"),
    [
        (None, TypeError, "the normal law returned NoneType, not a number"),
        (float("nan"), granum.CaseError, "NaN, which is not finite"),
        ({"radius": 1.0}, TypeError, "returned no force"),
        ({"force": 1.0, "stiffness": 1.0}, TypeError, "returned stiffness; a law returns force, radius and kept"),
        ({"force": 1.0, "kept": [1.0] * 5}, granum.CaseError, "keeps at most 4 numbers, not 5"),
    ],
)
def test_answers_that_cannot_be_are_refused(answer: Any, error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        granum.pair(PATH, CASE, normal=lambda overlap, kept: answer)
    # Nothing of it is left.
    assert granum.pair(PATH, CASE, normal=hertz) == granum.pair(PATH, CASE, normal=hertz)


def test_what_a_law_raises_is_raised_and_laws_may_move_pairs() -> None:
    def fails(overlap: float, kept: list[float]) -> float:
        raise ZeroDivisionError("of the law")

    with pytest.raises(ZeroDivisionError, match="of the law"):
        granum.pair(PATH, CASE, normal=fails)
    short = {"normal_approach": [1e-8], "tangential_displacement": [0.0]}

    def of_another(overlap: float, kept: list[float]) -> float:
        inner = granum.pair({"normal_approach": [overlap], "tangential_displacement": [0.0]}, CASE, normal=lambda x, kept: 2 * hertz(x, kept))
        return float(inner["normal_force"][0])

    assert np.isclose(granum.pair(short, CASE, normal=of_another)["normal_force"][0], 2 * hertz(1e-8, []))


def test_paths_and_cases_that_cannot_be_are_refused() -> None:
    with pytest.raises(granum.CaseError, match="below half the sum of the radii"):
        granum.pair({"normal_approach": [DIAMETER], "tangential_displacement": [0.0]}, CASE)
    with pytest.raises(granum.CaseError, match="tangential_displacement"):
        granum.pair({"normal_approach": [1e-8]}, CASE)
    with pytest.raises(TypeError, match="normal is a function, not str; the case names"):
        granum.pair(PATH, CASE, normal="hertz")  # type: ignore[arg-type]
    mixed = granum.Case(materials=[{"name": "a", "share": 0.5}, {"name": "b", "share": 0.5}])
    with pytest.raises(granum.CaseError, match="one material"):
        granum.pair(PATH, mixed)
