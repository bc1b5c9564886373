"""Material points: states are values, threads change nothing, and mistakes have names."""

import pathlib

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


STRAINS = ["axial_strain", "lateral_strain_2", "lateral_strain_3", "shear_strain_yz", "shear_strain_zx", "shear_strain_xy"]
STRESSES = [f"stress_{axes}" for axes in ("11", "22", "33", "23", "13", "12")]


def strained(run: int) -> granum.Table:
    """A made-up elastic body along a straight line of strain, of which the stiffness depends on the sample."""
    random = np.random.default_rng(run)
    strain = np.linspace(0, 1, 15)[:, None] * random.normal(size=6) * 1e-2
    void_ratio = random.uniform(0.6, 0.8)
    stress = 1e5 * np.array([1, 1, 1, 0, 0, 0]) + 1e7 / void_ratio * strain
    columns = dict(zip(STRAINS, strain.T)) | dict(zip(STRESSES, stress.T))
    return granum.Table(columns | {"sample.void_ratio": np.full(15, void_ratio), "coordination_number": 5 + strain[:, 0]})


@pytest.fixture(scope="module")
def surrogate() -> granum.surrogates.Surrogate:
    data = granum.Dataset({f"run {k}": strained(k) for k in range(8)})
    outputs = [*STRESSES, "coordination_number"]
    return granum.surrogates.fit(data, [*STRAINS, "sample.void_ratio"], outputs, method="path-tensor", threads=2)


def test_a_surrogate_stands_in_place_of_grains(surrogate: granum.surrogates.Surrogate, tmp_path: pathlib.Path) -> None:
    point = granum.MaterialPoint.from_surrogate(surrogate, {"sample.void_ratio": 0.7})
    state, step = point.start, [5e-4, 0, 0, 0, 0, 2e-4]
    states = [state]
    for _ in range(4):
        point.advance(state, [0, 0, 1e-3, 0, 0, 0])
        state = point.advance(state, step)
        states.append(state)
    # The whole path at once has the same bits.
    rows = np.column_stack([np.outer(np.arange(5), step), np.full(5, 0.7)])
    # A sum of steps is not their product in the last bit.
    for k in range(1, 5):
        rows[k, :6] = rows[k - 1, :6] + step
    found = surrogate.predict(rows, runs=np.zeros(5))["outputs"]
    for k, name in enumerate(STRESSES):
        assert np.array_equal([state.stress[k] for state in states], found[name]["mean"])
        assert np.array_equal([state.noise[k] for state in states], found[name]["standard_deviation"])
    assert state.value("coordination_number") == found["coordination_number"]["mean"][-1] and state.value("fabric_11") is None
    assert state.void_ratio == pytest.approx(1.7 * np.exp(-4 * 5e-4) - 1) and state.outside == []
    assert point.tangent(state, "probes").shape == (6, 6)
    # Many points at once, and the surrogate of a file.
    surrogate.write(tmp_path / "body.json")
    read = granum.MaterialPoint.from_surrogate(tmp_path / "body.json", {"sample.void_ratio": 0.7})
    one, two = ([own.stress for own in which.advance_all([state] * 3, np.outer([1, 2, 3], step), threads=n)] for which, n in ((point, 1), (read, 2)))
    assert np.array_equal(one, two)
    far = state
    for _ in range(30):
        far = point.advance(far, [1e-2, 0, 0, 0, 0, 0])
    assert "axial_strain" in far.outside and "length of the path" in far.outside
    with pytest.raises(granum.RunError, match="no grains"):
        state.measure()
    with pytest.raises(granum.RunError, match="ask for probes"):
        point.tangent(state, "affine")


def test_grains_take_over_where_a_surrogate_does_not_know(surrogate: granum.surrogates.Surrogate) -> None:
    simulation = granum.prepare(SAND).simulation()
    both = granum.MaterialPoint.hybrid(surrogate, simulation, largest_trusted_deviation=10, inertial_number=5e-3)
    void_ratio = both.start.void_ratio
    assert void_ratio is not None
    alone = granum.MaterialPoint.from_surrogate(surrogate, {"sample.void_ratio": void_ratio})
    grains = granum.MaterialPoint(simulation, inertial_number=5e-3)
    step = [4e-4, -2e-4, 0, 0, 0, 2e-4]
    state, known, live = (point.advance(point.start, step) for point in (both, alone, grains))
    assert not state.is_live and np.allclose(state.stress, known.stress, rtol=1e-3)
    for _ in range(200):
        state, live = both.advance(state, step), grains.advance(live, step)
        if state.is_live:
            break
    # It left the training runs, and the grains followed all of its path.
    assert state.is_live and np.array_equal(state.stress, live.stress) and state.outside == []
    table = state.path(both.start)
    assert table is not None and np.array_equal(np.asarray(table["stress_11"])[-1:], live.stress[:1])
    assert known.path(alone.start) is None
    with pytest.raises(granum.CaseError, match="largest trusted deviation"):
        granum.MaterialPoint.hybrid(surrogate, simulation, largest_trusted_deviation=-1)


def test_surrogates_that_are_no_material_have_names(surrogate: granum.surrogates.Surrogate) -> None:
    refused = granum.MaterialPoint.from_surrogate
    with pytest.raises(granum.CaseError, match="sample.void_ratio needs a finite value"):
        refused(surrogate)
    with pytest.raises(granum.CaseError, match="friction is no input"):
        refused(surrogate, {"sample.void_ratio": 0.7, "friction": 0.5})
    data = granum.Dataset({f"run {k}": strained(k) for k in range(3)})
    with pytest.raises(granum.CaseError, match="no memory"):
        refused(granum.surrogates.fit(data, STRAINS, STRESSES, method="ridge"))
    with pytest.raises(granum.Error, match="missing.json"):
        refused("missing.json")
    limited = refused(surrogate, {"sample.void_ratio": 0.7}, largest_increment=1e-3, refuse_larger=True)
    with pytest.raises(granum.RunError, match="permits 1.000e-3 at once"):
        limited.advance(limited.start, [5e-3, 0, 0, 0, 0, 0])
