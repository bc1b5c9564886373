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


def fitted(dataset: granum.Dataset, method: str) -> granum.surrogates.Surrogate:
    """A small surrogate."""
    outputs = OUTPUTS[:1] if method == "sub-models" else OUTPUTS
    hidden = [7, 6] if method in ("feed-forward", "sub-models") else None
    return granum.surrogates.fit(dataset, INPUTS, outputs, method=method, coordinate="deviator_strain", hidden=hidden, threads=1)


def random_rows(surrogate: granum.surrogates.Surrogate, rows: int = 400) -> Any:
    """Rows within the range of the training, and some beyond."""
    low, high = np.array([0.0, 0.0, 0.2]), np.array([0.3, 0.12, 0.4])
    random = np.random.default_rng(5)
    return low + (high - low) * random.uniform(-0.05, 1.05, (rows, len(surrogate.inputs)))


def answered(path: pathlib.Path, surrogate: granum.surrogates.Surrogate, rows: Any) -> dict[str, Any]:
    """What onnxruntime says of rows, which are one run for a surrogate with memory."""
    session = onnxruntime.InferenceSession(str(path), providers=["CPUExecutionProvider"])
    names = [output.name for output in session.get_outputs()]
    given = {name: rows[:, [k]] for k, name in enumerate(surrogate.inputs)}
    if not surrogate.has_memory:
        return dict(zip(names, session.run(None, given)))
    width = next(own.shape[1] for own in session.get_inputs() if own.name == "memory")
    # The first memory has no meaning.
    memory: Any = np.full((1, width), 7.0)
    found: dict[str, list[Any]] = {name: [] for name in names}
    for row in range(len(rows)):
        step: dict[str, Any] = {name: values[[row]] for name, values in given.items()}
        values = session.run(None, step | {"memory": memory, "begins": np.array([[float(row == 0)]])})
        memory = values[names.index("next_memory")]
        for name, value in zip(names, values):
            found[name].append(value)
    return {name: np.concatenate(values) for name, values in found.items()}


def worst(path: pathlib.Path, surrogate: granum.surrogates.Surrogate) -> float:
    """The largest relative difference between onnxruntime and granum over all that both say."""
    rows = random_rows(surrogate)
    runs = np.zeros(len(rows)) if surrogate.has_memory else None
    exact, found = surrogate.predict(rows, runs=runs), answered(path, surrogate, rows)
    largest = 0.0
    compared = 0
    for output in surrogate.outputs:
        for kind, prefix in (("mean", "predicted"), ("lower", "lower"), ("upper", "upper"), ("standard_deviation", "standard_deviation")):
            ours = np.asarray(exact["outputs"][output][kind])
            if np.isnan(ours).all():
                assert f"{prefix}_{output}" not in found
                continue
            theirs = found[f"{prefix}_{output}"][:, 0]
            scale = np.maximum(np.abs(ours), 1e-3 * np.abs(ours).max() + 1e-300)
            largest = max(largest, float(np.max(np.abs(ours - theirs) / scale)))
            compared += 1
    assert compared >= len(surrogate.outputs)
    outside = np.asarray(exact["outside"])
    assert np.array_equal(found["outside"][:, 0] == 1, outside) and 0 < outside.mean() < 1
    return largest


@pytest.mark.parametrize("method", ["feed-forward", "sub-models", "ridge", "recurrent"])
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
    low, high = json.loads(told.get("trained_range.friction") or told["trained_range.sub_model_1.friction"])
    assert low < high
    assert worst(path, surrogate) < TOLERANCE
    with pytest.raises(granum.Error, match="exists already"):
        surrogate.export_onnx(path)


def test_another_weight_is_found(dataset: granum.Dataset, tmp_path: pathlib.Path) -> None:
    surrogate = fitted(dataset, "feed-forward")
    path = tmp_path / "model.onnx"
    surrogate.export_onnx(path)
    model = onnx.load(path)
    weights = next(own for own in model.graph.initializer if list(own.dims) == [len(INPUTS), 7])
    values = np.frombuffer(weights.raw_data).copy()
    values[0] *= 1.001
    weights.raw_data = values.tobytes()
    onnx.save(model, path)
    assert worst(path, surrogate) > TOLERANCE


def test_every_method_is_written_or_refused_by_name(dataset: granum.Dataset, tmp_path: pathlib.Path) -> None:
    written = []
    for method in granum.surrogates.methods():
        if method.startswith("path-"):
            outputs = ["stress"]
        elif method == "sub-models":
            outputs = OUTPUTS[:1]
        else:
            outputs = OUTPUTS
        try:
            # Methods of whole curves take what is constant in a run, beside the coordinate.
            surrogate = granum.surrogates.fit(
                dataset, ["deviator_strain", "friction"], outputs, method=method, coordinate="deviator_strain", threads=2
            )
        except granum.Error:
            # The cascade needs soft sensors, and the study of the paper columns, that these tests do not have.
            assert method in ("cascade", "antony2006")
            continue
        path = tmp_path / f"{method}.onnx"
        try:
            surrogate.export_onnx(path)
            written.append(method)
        except granum.Error as refusal:
            assert str(refusal).startswith(f"{method}: it has no ONNX form: "), refusal
            assert not path.exists()
    assert sorted(written) == ["feed-forward", "recurrent", "ridge", "sub-models"]
