"""The examples of `python/examples` run, with the packages that they show."""

import importlib.util
import pathlib
import subprocess
import sys

import granum
import numpy as np
import pytest

EXAMPLES = pathlib.Path(__file__).parent.parent / "examples"


def output(name: str, folder: pathlib.Path) -> str:
    """What an example prints."""
    done = subprocess.run([sys.executable, str(EXAMPLES / name)], cwd=folder, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    # Runs of an example pass their checks.
    assert "RunWarning" not in done.stderr, done.stderr
    return done.stdout


def test_many_processes_find_the_same_bits(tmp_path: pathlib.Path) -> None:
    found = output("many_processes.py", tmp_path)
    assert found.count("q/p at most") == 3 and "the same bits here: True" in found


@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_runs_survive_the_loss_of_a_worker_of_dask(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("distributed", reason="Dask is not installed: its example is left out")
    found = output("dask_cluster.py", tmp_path)
    assert "a worker was killed; 4 runs are finished" in found and " 0 of them went on" not in found
    assert "the bits of the campaign: True" in found


def test_ray_finds_the_numbers_of_the_campaign(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("ray", reason="Ray is not installed: its example is left out")
    assert "3 runs; the numbers of the campaign: True" in output("ray_cluster.py", tmp_path)


@pytest.mark.parametrize(
    "package, told",
    [
        ("freud", "freud: 4.4200 contacts of a grain, granum counts 4.4200"),
        ("ovito", "OVITO: 300 grains, the same radii True, the same volume True"),
        ("pyvista", "PyVista: 300 grains and 825 lines of contacts; 28800 triangles"),
    ],
)
def test_grains_are_handed_over(package: str, told: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    if importlib.util.find_spec(package) is None:
        pytest.skip(f"{package} is not installed: its part of the example is left out")
    if not handed_over:
        handed_over.append(output("hand_over.py", tmp_path_factory.mktemp("hand-over")))
    assert told in handed_over[0]


handed_over: list[str] = []


def test_optuna_finds_a_friction(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("optuna")
    found = output("optuna_search.py", tmp_path)
    missed = float(found.split()[-1])
    assert found.startswith("friction 0.") and missed < 0.05


def test_scikit_fem_compresses_grains() -> None:
    pytest.importorskip("skfem")
    *_, last = output("biaxial_scikit_fem.py", EXAMPLES).splitlines()
    # Equilibrium: the mean lateral stress is the lateral pressure.
    assert "8 steps" in last and "32 points" in last
    assert abs(float(last.split()[-2]) - 100) < 0.5, last


def test_grainlearning_calibrates_with_granum(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("grainlearning", reason="GrainLearning needs NumPy 1 and has an environment of its own in scripts/python")
    found = output("grainlearning_calibration.py", tmp_path).splitlines()[-1]
    assert abs(float(found.split()[1].rstrip(";")) - 0.1) < 0.05


def test_onnxruntime_evaluates_surrogates(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("onnxruntime", reason="onnxruntime is not installed: its example is left out")
    found = output("onnx_predictions.py", tmp_path)
    assert "0 states outside" in found and "the predictions of granum: True" in found


def test_a_surrogate_stands_behind_a_point(tmp_path: pathlib.Path) -> None:
    found = output("surrogate_point.py", tmp_path).splitlines()[-1].split()
    assert abs(float(found[2]) / float(found[8]) - 1) < 0.2 and found[-2:] == ["1000", "points"], found


def test_a_control_loop_is_answered(tmp_path: pathlib.Path) -> None:
    strain = np.linspace(0.0, 0.1, 30)
    runs = {f"run {k}": granum.Table({"x": strain, "k": np.full(30, float(k)), "y": k * strain}) for k in range(4)}
    surrogate = granum.surrogates.fit(granum.Dataset(runs), ["x", "k"], "y", coordinate="x", method="feed-forward", hidden=[3])
    surrogate.write(tmp_path / "model.json")
    program = pathlib.Path(sys.executable).parent / "granum"
    arguments = ["model.json", "--granum", str(program), "--rate", "200", "--seconds", "0.5"]
    done = subprocess.run([sys.executable, str(EXAMPLES / "control_loop.py"), *arguments], cwd=tmp_path, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("100 lines at 200 Hz, round trip in microseconds: median "), done.stdout
    assert done.stderr.startswith("101 lines, microseconds from a line read"), done.stderr
