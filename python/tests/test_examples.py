"""The examples of `python/examples` run, with the packages that they show."""

import pathlib
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).parent.parent / "examples"


def output(name: str, folder: pathlib.Path) -> str:
    """What an example prints."""
    done = subprocess.run([sys.executable, str(EXAMPLES / name)], cwd=folder, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_many_processes_find_the_same_bits(tmp_path: pathlib.Path) -> None:
    found = output("many_processes.py", tmp_path)
    assert found.count("q/p at most") == 3 and "the same bits here: True" in found


def test_optuna_finds_a_friction(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("optuna")
    found = output("optuna_search.py", tmp_path)
    missed = float(found.split()[-1])
    assert found.startswith("friction 0.") and missed < 0.05


def test_grainlearning_calibrates_with_granum(tmp_path: pathlib.Path) -> None:
    pytest.importorskip("grainlearning", reason="GrainLearning needs NumPy 1 and has an environment of its own in scripts/python")
    found = output("grainlearning_calibration.py", tmp_path).splitlines()[-1]
    assert abs(float(found.split()[1].rstrip(";")) - 0.1) < 0.05
