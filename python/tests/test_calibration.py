"""Calibration: the parameters of a simulation are found again, and the posterior goes to tables and to ArviZ."""

import os
import pathlib
import pickle
import signal
import subprocess
import sys
import time
import warnings
from typing import Any

import granum
import numpy as np
import pytest

CHECKS = [
    "servo_error_rms < 1", "servo_error_largest < 1", "inertial_number < 1", "unbalanced_force < 1", "largest_overlap < 0.5",
    "mean_stress_lost < 1", "energy_gap < 1", "sample_unbalanced_force < 1", "sample_mean_stress_missed_by < 1", "stages_cut_short < 1.5",
]  # fmt: skip
MATERIAL = f"""case = 'sand.toml'
accept = {CHECKS}
[calibration]
runs = 16
confirm = 2
rounds = 1
draws = 3
[[calibration.quantity]]
name = 'deviator_stress'
to = '2.5 %'
points = 6
absolute = '5 kPa'
[[variable]]
name = 'friction'
key = 'grains.material.friction'
prior = 'uniform'
from = 0.1
to = 0.8
[[variable]]
name = 'lateral_stress'
keys = ['preparation.mean_stress', 'stage.1.lateral_stress']
test = 'lateral_stress'
"""
SAND = granum.Case(
    grains={"count": 80, "material": {"interface_energy": 0, "friction": 0.35, "youngs_modulus": "3 GPa"}},
    contact={"normal": "hertz", "tangential": "no-slip"},
    preparation={
        "mean_stress": "100 kPa", "friction": 0.1, "solid_fraction": "none", "inertial_number": 1e-2, "unbalanced_force": 5e-2,
    },
    stages=[{"path": "drained-triaxial", "lateral_stress": "100 kPa", "axial_strain": 0.03, "inertial_number": 1e-2, "states": 12}],
)  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> pathlib.Path:
    """A folder with the file of a calibration and its case."""
    here = tmp_path_factory.mktemp("calibration")
    (here / "sand.toml").write_text(SAND.to_toml())
    (here / "material.toml").write_text(MATERIAL)
    return here


@pytest.fixture(scope="module")
def curves() -> dict[str, granum.Table]:
    """The curves of a simulation whose parameters are known, as a laboratory would have measured them."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", granum.RunWarning)
        truth = granum.run(SAND.with_values({"preparation.seed": 77}))
    return {"T1": granum.compare(truth).runs["run 1"]}


@pytest.fixture(scope="module")
def posterior(folder: pathlib.Path, curves: dict[str, granum.Table]) -> granum.Posterior:
    """What a calibration on these curves finds."""
    notes.clear()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", granum.RunWarning)
        return granum.calibrate(folder / "material.toml", curves, out=folder / "out", workers=2, on_note=notes.append)


notes: list[str] = []


def test_the_parameters_of_a_simulation_are_found_again(posterior: granum.Posterior, folder: pathlib.Path, curves: Any) -> None:
    parameters = posterior.parameters
    assert list(parameters["parameter"])[0] == "friction"
    low, high = parameters["quantile_5"][0], parameters["quantile_95"][0]
    assert 0.1 < low < 0.35 < high < 0.8 and parameters["r_hat"][0] < 1.01
    draws = posterior.draws
    assert len(draws) >= 400 and np.isclose(draws["friction"].mean(), parameters["mean"][0])
    assert posterior.mean_case["grains.material.friction"] == pytest.approx(parameters["mean"][0])
    assert any(note.startswith("inference: ") for note in notes) and any(note.startswith("design: 16 simulations") for note in notes)
    assert posterior.results["what_tests_tell"]["curves"][0][0] == "T1" and "friction" in repr(posterior)
    predictions = posterior.predictions
    assert len(predictions) == 6 and np.all(predictions["low"] < predictions["predicted"])
    assert np.isclose(predictions["measured"].max(), curves["T1"]["deviator_stress"].max(), rtol=0.1)
    page = posterior._repr_html_()
    assert "<svg" in page and "friction" in page
    again = pickle.loads(pickle.dumps(granum.Posterior(folder / "out")))
    assert again.parameters == parameters


def test_a_calibration_goes_on_and_shares_its_simulations(posterior: granum.Posterior, folder: pathlib.Path, curves: Any) -> None:
    begin = time.perf_counter()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", granum.RunWarning)
        again = granum.calibrate(folder / "material.toml", curves, out=folder / "out")
        shared = granum.calibrate(folder / "material.toml", curves, out=folder / "shared", runs=[folder / "out" / "runs" / "design"])
    assert again.parameters == posterior.parameters and time.perf_counter() - begin < 60
    assert not (folder / "shared" / "runs" / "design").exists() and len(shared.draws) >= 400


def test_the_draws_go_to_arviz(posterior: granum.Posterior) -> None:
    pytest.importorskip("arviz")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        data = posterior.to_arviz()
    draws = data.posterior["friction"]
    assert draws.dims[:2] == ("chain", "draw")
    assert np.array_equal(draws.values.ravel(), posterior.draws["friction"])
    assert data.sample_stats["lp"].shape == draws.shape


def test_what_cannot_be_calibrated_is_told_as_by_the_program(folder: pathlib.Path, curves: Any, tmp_path: pathlib.Path) -> None:
    with pytest.raises(granum.RunError, match='T9.*T1|"T9"'):
        granum.calibrate(folder / "material.toml", curves, out=tmp_path / "out", tests="T9")
    with pytest.raises(granum.RunError, match="missing.toml"):
        granum.calibrate(tmp_path / "missing.toml", curves, out=tmp_path / "out")
    with pytest.raises(granum.FileError, match="no folder of a calibration"):
        granum.Posterior(tmp_path)


def test_what_a_function_raises_ends_a_calibration_in_good_order(folder: pathlib.Path, curves: Any, posterior: granum.Posterior) -> None:
    def fails(note: str) -> None:
        raise ZeroDivisionError(note)

    with pytest.raises(ZeroDivisionError, match="T1"):
        granum.calibrate(folder / "material.toml", curves, out=folder / "ended", on_note=fails)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", granum.RunWarning)
        assert granum.calibrate(folder / "material.toml", curves, out=folder / "ended").parameters == posterior.parameters


@pytest.mark.skipif(os.name == "nt", reason="signals of Unix")
def test_ctrl_c_ends_a_calibration(folder: pathlib.Path, curves: dict[str, granum.Table], tmp_path: pathlib.Path) -> None:
    lab = tmp_path / "lab.csv"
    granum.calibration._written(curves, str(lab))
    assert granum.laboratory(lab)["T1"]["deviator_stress"][-1] == curves["T1"]["deviator_stress"][-1]
    text = MATERIAL.replace("runs = 16", "runs = 400")
    (folder / "long.toml").write_text(text)
    program = (
        "import signal, granum\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        f"granum.calibrate({str(folder / 'long.toml')!r}, {str(lab)!r}, out={str(tmp_path / 'out')!r}, on_note=lambda note: print(note, flush=True))\n"
    )
    child = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert child.stdout is not None
    for line in child.stdout:
        if line.startswith("design:"):
            break
    time.sleep(1.0)
    child.send_signal(signal.SIGINT)
    _, errors = child.communicate(timeout=60)
    assert "KeyboardInterrupt" in errors and child.returncode != 0
