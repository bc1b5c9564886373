"""ONNX files answer as granum does."""

import hashlib
import json
import pathlib
from typing import Any

import granum
import numpy as np
import pytest

onnx = pytest.importorskip("onnx", reason="onnx is not installed: its files are not checked")
onnxruntime = pytest.importorskip("onnxruntime", reason="onnxruntime is not installed: ONNX files are not evaluated")

INPUTS = ["deviator_strain", "deviator_fabric", "friction"]
OUTPUTS = ["stress", "sliding_fraction"]
# The relative difference that is allowed; of a value near zero, of a thousandth of the largest.
TOLERANCE = 1e-6


def curve(run: int) -> granum.Table:
    """A made-up test."""
    strain = np.linspace(0.0, 0.3, 40 + run % 3)
    sample = np.sin(2.3 * run)
    fabric = 0.1 * (1 + 0.2 * sample) * (1 - np.exp(-strain / 0.03)) + 0.002 * np.sin(77 * strain + run)
    stress = 1e5 * ((0.7 + 0.1 * sample) * (1 - np.exp(-strain / 0.012)) + 0.5 * fabric + 0.01 * np.cos(91 * strain + run))
    sliding = 0.02 * (1 + sample) + 0.01 * np.abs(np.sin(50 * strain))
    columns = {
        "deviator_strain": strain,
        "deviator_fabric": fabric,
        "friction": np.full(len(strain), 0.3 + 0.1 * sample),
        "stress": stress,
        "sliding_fraction": sliding,
    }
    return granum.Table(columns, units={"stress": "Pa"})


@pytest.fixture(scope="module")
def dataset() -> granum.Dataset:
    """Made-up tests."""
    return granum.Dataset({f"run {k}": curve(k) for k in range(6)})


# Methods of whole curves take what is constant in a run, beside the coordinate.
OF_CURVES = ["gaussian-process", "cascade", "mean-curve", "nearest-run"]


def fitted(dataset: granum.Dataset, method: str) -> granum.surrogates.Surrogate:
    """A small surrogate."""
    inputs = [name for name in INPUTS if name != "deviator_fabric"] if method in OF_CURVES else INPUTS
    outputs = OUTPUTS[:1] if method in ("sub-models", "cascade") else OUTPUTS
    hidden = [7, 6] if method in ("feed-forward", "sub-models") else None
    return granum.surrogates.fit(dataset, inputs, outputs, method=method, coordinate="deviator_strain", hidden=hidden, threads=2)


def random_rows(surrogate: granum.surrogates.Surrogate, rows: int = 400) -> Any:
    """Rows within the range of the training, and some beyond."""
    ranges = {"deviator_strain": (0.0, 0.3), "deviator_fabric": (0.0, 0.12), "friction": (0.2, 0.4)}
    low, high = np.array([ranges[name] for name in surrogate.inputs]).T
    random = np.random.default_rng(5)
    return low + (high - low) * random.uniform(-0.05, 1.05, (rows, len(surrogate.inputs)))


def answered(path: pathlib.Path, surrogate: granum.surrogates.Surrogate, rows: Any, tests: int = 1) -> dict[str, Any]:
    """What onnxruntime says of rows; for a surrogate with memory these are so many tests of the same length, one after the other."""
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    names = [output.name for output in session.get_outputs()]
    given = {name: rows[:, [k]] for k, name in enumerate(surrogate.inputs)}
    if not surrogate.has_memory:
        return dict(zip(names, session.run(None, given)))
    width = next(own.shape[1] for own in session.get_inputs() if own.name == "memory")
    # The first memory has no meaning. All tests advance together, a row each.
    memory: Any = np.full((tests, width), 7.0)
    states = len(rows) // tests
    found: dict[str, list[Any]] = {name: [] for name in names}
    for state in range(states):
        step: dict[str, Any] = {name: values[state::states] for name, values in given.items()}
        values = session.run(None, step | {"memory": memory, "begins": np.full((tests, 1), float(state == 0))})
        memory = values[names.index("next_memory")]
        for name, value in zip(names, values):
            found[name].append(value)
    return {name: np.stack(values, axis=1).reshape(len(rows), -1) for name, values in found.items()}


def difference(ours: Any, theirs: Any) -> float:
    """The largest difference of values, relative to each of them, or to a thousandth of the largest if it is smaller."""
    scale = np.maximum(np.abs(ours), 1e-3 * np.abs(ours).max() + 1e-300)
    return float(np.max(np.abs(ours - theirs) / scale))


def worst(path: pathlib.Path, surrogate: granum.surrogates.Surrogate, rows: Any = None, tests: int = 1) -> float:
    """The largest relative difference between onnxruntime and granum over all that both say."""
    rows = random_rows(surrogate) if rows is None else rows
    runs = np.repeat(np.arange(tests), len(rows) // tests) if surrogate.has_memory else None
    exact, found = surrogate.predict(rows, runs=runs), answered(path, surrogate, rows, tests)
    largest = 0.0
    for output in surrogate.outputs:
        for kind, prefix in (("mean", "predicted"), ("lower", "lower"), ("upper", "upper"), ("standard_deviation", "standard_deviation")):
            ours = np.asarray(exact["outputs"][output][kind])
            if np.isnan(ours).all():
                assert f"{prefix}_{output}" not in found and kind != "mean"
                continue
            largest = max(largest, difference(ours, found[f"{prefix}_{output}"][:, 0]))
    outside = np.asarray(exact["outside"])
    assert np.array_equal(found["outside"][:, 0] == 1, outside) and 0 < outside.mean() < 1
    return largest


WRITTEN = ["boosted-trees", "cascade", "feed-forward", "gaussian-process", "mean-curve", "recurrent", "ridge", "sub-models"]


@pytest.mark.parametrize("method", WRITTEN)
def test_onnxruntime_answers_as_granum_does(method: str, dataset: granum.Dataset, tmp_path: pathlib.Path) -> None:
    surrogate = fitted(dataset, method)
    path = tmp_path / "model.onnx"
    surrogate.export_onnx(path)
    model = onnx.load(path)
    onnx.checker.check_model(model, full_check=True)
    assert model.opset_import[0].version == 17 and model.ir_version == 8 and model.producer_name == "granum"
    told = {entry.key: entry.value for entry in model.metadata_props}
    assert told["granum.method"] == surrogate.method and told["unit.output.stress"] == "Pa" and told["interval_level"] == "0.9"
    surrogate.write(tmp_path / "model.json")
    assert told["granum.sha256"] == hashlib.sha256((tmp_path / "model.json").read_bytes()).hexdigest()
    low, high = json.loads(told.get("trained_range.deviator_strain") or told["trained_range.sub_model_1.friction"])
    assert low < high
    assert worst(path, surrogate) < TOLERANCE
    with pytest.raises(granum.Error, match="exists already"):
        surrogate.export_onnx(path)
    with pytest.raises(granum.Error, match="between 0 and 1, not 2"):
        surrogate.export_onnx(path, level=2.0, force=True)


STRAINS = ["axial_strain", "lateral_strain_2", "lateral_strain_3", "shear_strain_yz", "shear_strain_zx", "shear_strain_xy"]
STRESSES = [f"stress_{axes}" for axes in ("11", "22", "33", "23", "13", "12")]
PATHS = ["path-gru", "path-lstm", "path-state-space", "path-window", "path-tensor"]


def path(run: int, states: int, is_pressed: bool = False) -> dict[str, Any]:
    """A made-up material along a path of strain that turns at random: its stress follows the direction, and its volume depends on the sample. It may be pressed
    by a stress that varies from state to state and from run to run.
    """
    random = np.random.default_rng(run)
    void_ratio, friction = random.uniform(0.5, 0.8), random.uniform(0.2, 0.6)
    steps = random.normal(size=(states // 7 + 1, 6)).repeat(7, axis=0)[:states] * random.uniform(0.5, 1.5, (states, 1)) * 1e-3
    steps[0] = 0
    # A state in which nothing is strained.
    steps[5] = 0
    strain = steps.cumsum(axis=0)
    stress, volume = np.zeros((states, 6)), np.zeros(states)
    isotropic = np.array([1, 1, 1, 0, 0, 0])
    for k in range(1, states):
        length = np.linalg.norm(steps[k])
        stress[k] = stress[k - 1] + 40 * (1e5 * friction * steps[k] - stress[k - 1] * length)
        volume[k] = volume[k - 1] + length * (void_ratio - 0.65)
    stress += 1e5 * (1 + 3 * volume)[:, None] * isotropic
    if is_pressed:
        stress *= np.exp(np.sin(0.3 * np.arange(states) + run))[:, None]
    columns: dict[str, Any] = dict(zip(STRAINS, strain.T)) | dict(zip(STRESSES, stress.T)) | {"volumetric_strain": volume}
    before = {f"sample.{name}": np.full(states, values[0]) for name, values in zip(STRESSES, stress.T)}
    return columns | before | {"sample.void_ratio": np.full(states, void_ratio), "friction": np.full(states, friction)}


@pytest.fixture(scope="module")
def dataset_of_paths() -> granum.Dataset:
    """Made-up paths, of which there are enough for intervals that depend on the sample."""
    units = {name: "Pa" for name in STRESSES} | {f"sample.{name}": "Pa" for name in STRESSES}
    return granum.Dataset({f"run {k}": granum.Table(path(k, 12 + k % 3), units=units) for k in range(26)})


# The columns of strain and tensors; a prescribed volume, which is an increment as well; and strains without any tensor.
COLUMNS = [
    ([*STRAINS, *(f"sample.{name}" for name in STRESSES), "sample.void_ratio", "friction"], [*STRESSES, "volumetric_strain"]),
    ([*STRAINS, "friction"], STRESSES),
    ([*STRAINS, "sample.void_ratio"], ["stress_11", "stress_33"]),
]


def test_a_stress_whose_pressure_varies_is_that_of_granum(tmp_path: pathlib.Path) -> None:
    inputs, outputs = COLUMNS[0][0], STRESSES
    dataset = granum.Dataset({f"run {k}": granum.Table(path(k, 12 + k % 3, is_pressed=True)) for k in range(26)})
    surrogate = granum.surrogates.fit(dataset, inputs, outputs, method="path-tensor", threads=2)
    # Networks see its ratio and its logarithm.
    surrogate.write(tmp_path / "model.json")
    assert '"offset":' in (tmp_path / "model.json").read_text().replace(" ", "")
    file = tmp_path / "model.onnx"
    surrogate.export_onnx(file)
    onnx.checker.check_model(onnx.load(file), full_check=True)
    paths = [path(100 + k, 40, is_pressed=True) for k in range(3)]
    rows = np.concatenate([np.column_stack([own[name] for name in inputs]) for own in paths])
    assert worst(file, surrogate, rows, 3) < TOLERANCE


@pytest.mark.parametrize("columns", range(len(COLUMNS)))
@pytest.mark.parametrize("method", PATHS)
def test_whole_paths_are_those_of_granum(
    method: str, columns: int, dataset_of_paths: granum.Dataset, tmp_path: pathlib.Path
) -> None:
    inputs, outputs = COLUMNS[columns]
    surrogate = granum.surrogates.fit(dataset_of_paths, inputs, outputs, method=method, threads=2)
    file = tmp_path / "model.onnx"
    surrogate.export_onnx(file)
    onnx.checker.check_model(onnx.load(file), full_check=True)
    # New paths, which are longer than those of the training.
    tests = 3
    paths = [path(100 + k, 40) for k in range(tests)]
    rows = np.concatenate([np.column_stack([own[name] for name in inputs]) for own in paths])
    assert worst(file, surrogate, rows, tests) < TOLERANCE


@pytest.mark.parametrize("method", ["feed-forward", "gaussian-process", "boosted-trees", "path-tensor"])
def test_another_number_is_found(method: str, dataset: granum.Dataset, tmp_path: pathlib.Path) -> None:
    if method in PATHS:
        surrogate = granum.surrogates.fit(dataset, INPUTS, OUTPUTS, method=method, threads=2)
    else:
        surrogate = fitted(dataset, method)
    path = tmp_path / "model.onnx"
    surrogate.export_onnx(path)
    assert worst(path, surrogate) < TOLERANCE
    model = onnx.load(path)
    # The largest tables of numbers: the weights, the factors of covariances, the values of leaves.
    numbers = [own for own in model.graph.initializer if own.data_type == onnx.TensorProto.DOUBLE]
    largest = max(np.prod(own.dims) for own in numbers)
    for own in numbers:
        if np.prod(own.dims) == largest:
            own.raw_data = (1.001 * np.frombuffer(own.raw_data)).tobytes()
    onnx.save(model, path)
    assert worst(path, surrogate) > TOLERANCE


@pytest.mark.parametrize("name, along", granum.surrogates.families())
def test_families_that_come_with_granum_are_those_of_granum(name: str, along: str, tmp_path: pathlib.Path) -> None:
    family = granum.surrogates.load(name, along)
    file = tmp_path / "family.onnx"
    family.export_onnx(file)
    # The largest is of a hundred megabytes, most of them the factors of covariances.
    assert file.stat().st_size < 120e6
    session = onnxruntime.InferenceSession(str(file), providers=["CPUExecutionProvider"])
    told = session.get_modelmeta().custom_metadata_map
    assert (told["granum.family"], told["granum.path"], told["granum.method"]) == (name, along, "gaussian-process")
    random = np.random.default_rng(2)
    low, high = np.array([about["range"] for about in family.inputs.values()]).T
    places = random.uniform(0, 1, (6, len(low)))
    # At the ends of the ranges many runs have the same value; and beyond them.
    places[1] = np.round(places[1])
    places[2, 0] = 1.2
    for place in places:
        given = dict(zip(family.inputs, low + (high - low) * place))
        ours = family.predict(given)
        points = np.asarray(ours["points"])[:, None]
        asked = {family.predict(given)["coordinate"]: points} | {key: np.full_like(points, value) for key, value in given.items()}
        theirs = dict(zip([output.name for output in session.get_outputs()], session.run(None, asked)))
        for column, curve in ours["curves"].items():
            for kind, prefix in (("mean", "predicted"), ("lower", "lower"), ("upper", "upper")):
                assert difference(np.asarray(curve[kind]), theirs[f"{prefix}_{column}"][:, 0]) < TOLERANCE, (column, kind, place)
        assert (theirs["outside"] == float(bool(ours["outside"]) or ours["unseen_combination"] is not None)).all()


def test_every_method_is_written_or_refused_by_name(dataset: granum.Dataset, tmp_path: pathlib.Path) -> None:
    written = []
    for method in granum.surrogates.methods():
        if method == "antony2006":
            # It needs columns that these tests do not have, and trains the networks of sub-models.
            continue
        if method.startswith("path-"):
            surrogate = granum.surrogates.fit(dataset, ["deviator_strain", "friction"], ["stress"], method=method, threads=2)
        else:
            surrogate = fitted(dataset, method)
        path = tmp_path / f"{method}.onnx"
        try:
            surrogate.export_onnx(path)
            written.append(method)
        except granum.Error as refusal:
            assert str(refusal).startswith(f"{method}: it has no ONNX form: it looks up whole runs"), refusal
            assert not path.exists()
    assert sorted(written) == sorted(WRITTEN + PATHS)
