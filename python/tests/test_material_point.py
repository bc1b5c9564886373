"""Material points: states are values, threads change nothing, and mistakes have names."""

import granum
import numpy as np
import pytest

SAND = granum.Case(
    grains={"count": 80, "material": {"interface_energy": 0}},
    preparation={"friction": 0.1, "solid_fraction": "none", "mean_stress": "100 kPa", "unbalanced_force": 0.05, "inertial_number": 0.01},
)


@pytest.fixture(scope="module")
def point() -> granum.MaterialPoint:
    return granum.MaterialPoint(granum.prepare(SAND).simulation(), inertial_number=5e-3)


def test_states_are_values(point: granum.MaterialPoint) -> None:
    start = point.start
    before = np.array(start.stress)
    strain = [0, 0, 1e-4, 0, 0, 2e-5]
    answer = point.advance(start, strain)
    assert answer.stress[2] > before[2]
    point.advance(start, [5e-3, 0, 0, 0, 0, 0])
    again = point.advance(start, strain)
    assert np.array_equal(again.stress, answer.stress) and again.ticket == answer.ticket != start.ticket
    assert np.array_equal(start.stress, before)
    assert point.advance(start, [0] * 6).ticket == start.ticket
    assert answer.measure()["void_ratio"] == pytest.approx(answer.void_ratio)
    assert answer.noise.shape == (6,) and answer.mean_stress > 0


def test_threads_change_no_bit(point: granum.MaterialPoint) -> None:
    strains = np.outer(np.arange(1, 5), [1e-5, 0, 0, 0, 2e-5, 0])
    one, two = ([state.stress for state in point.advance_all([point.start] * 4, strains, threads=n)] for n in (1, 2))
    assert np.array_equal(one, two) and not np.array_equal(one[0], one[1])


def test_a_rotation_turns_the_stress(point: granum.MaterialPoint) -> None:
    quarter = [[0, -1, 0], [1, 0, 0], [0, 0, 1]]
    state = point.advance(point.start, [3e-4, 0, 0, 0, 0, 0])
    turned = point.advance(state, [0] * 6, rotation=quarter)
    assert turned.stress[1] == pytest.approx(state.stress[0], rel=1e-12)


def test_stress_and_stiffness(point: granum.MaterialPoint) -> None:
    state = point.at_stress(point.start, [60e3, 60e3, 90e3, 0, 0, 0])
    assert np.allclose(state.stress, [60e3, 60e3, 90e3, 0, 0, 0], atol=90)
    affine, elastic = point.tangent(state, "affine"), point.tangent(state, "elastic")
    assert affine.shape == (6, 6) and affine[2, 2] > elastic[2, 2] > 0


def test_mistakes_have_names(point: granum.MaterialPoint) -> None:
    with pytest.raises(granum.CaseError, match="finite"):
        point.advance(point.start, [float("nan")] * 6)
    with pytest.raises(granum.CaseError, match="6 numbers"):
        point.advance(point.start, [0.0] * 5)
    with pytest.raises(granum.CaseError, match="no stiffness"):
        point.tangent(point.start, "stiff")
    with pytest.raises(granum.RunError, match="smaller step"):
        point.advance(point.start, [9.0, 0, 0, 0, 0, 0])
    with pytest.raises(granum.CaseError, match="inertial number"):
        granum.MaterialPoint(granum.prepare(SAND).simulation(), inertial_number=3.0)
