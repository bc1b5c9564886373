"""Calibration: which properties of the grains explain tests of a laboratory, and how surely.

`granum.calibrate` does what the command `granum calibrate` does, and gives the posterior that it writes into its folder.
"""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, SupportsIndex, cast

from ._granum import Case, Table
from ._script import script
from .errors import Error, FileError, RunError, RunWarning

if TYPE_CHECKING:
    import pathlib

    from .campaigns import Campaign

__all__ = ["Posterior", "calibrate"]

_MEASURES = {"axial_strain": "", "volumetric_strain": "", "deviator_stress": " (Pa)", "mean_stress": " (Pa)", "void_ratio": ""}
"""What a laboratory's file has, and how its heads give the unit."""


class Posterior:
    """What a calibration found, from its folder: `granum.calibrate` gives it, `granum.Posterior(folder)` opens it again."""

    def __init__(self, folder: str | os.PathLike[str]) -> None:
        import pathlib

        self.path: pathlib.Path = pathlib.Path(folder)
        """The folder, which has all that the command writes: `report.html`, pictures, `draws.toml`, the campaigns."""
        self.parameters: Table = self._table("posterior.parquet")
        """A row for each parameter: `mean`, `standard_deviation`, quantiles, those of the prior, `r_hat`, effective numbers of draws."""
        self.draws: Table = self._table("draws.parquet")
        """A row for each draw: the number of its chain and the value of each parameter, in SI units."""

    def _table(self, name: str) -> Table:
        if not (self.path / name).is_file():
            raise FileError(f"{self.path} has no {name}: it is no folder of a calibration, or there is no posterior yet")
        return Table.read(self.path / name)

    @property
    def mean_case(self) -> Case:
        """The case of the mean of the posterior, at the conditions of the first test."""
        return Case.read(self.path / "posterior-mean.toml", allow_outside=True)

    @property
    def predictions(self) -> Table:
        """Readings and predictions of all tests, also those that were not calibrated on, with intervals of 90 %."""
        return self._table("predictions.csv")

    @property
    def results(self) -> dict[str, Any]:
        """All that the calibration says of itself, as its file `calibration.json`."""
        import json

        try:
            found: dict[str, Any] = json.loads((self.path / "calibration.json").read_text(encoding="utf-8"))
        except OSError as error:
            raise FileError(f"{self.path} has no calibration.json yet: the calibration goes on with the same call") from error
        return found

    def to_arviz(self) -> Any:
        """The draws, their log-likelihoods and the measured curves for ArviZ."""
        import json

        import arviz

        content = json.loads((self.path / "inference_data.json").read_text(encoding="utf-8"))
        # From version 1 on ArviZ takes the groups as one dict.
        return arviz.from_dict(**content) if hasattr(arviz, "InferenceData") else arviz.from_dict(content)

    def _repr_html_(self) -> str:
        from ._plots import of_table

        picture = self.path / "posterior.svg"
        return of_table(self.parameters, most=100) + (picture.read_text(encoding="utf-8") if picture.is_file() else "")

    def __repr__(self) -> str:
        means = (f"{name} {mean:.4g}" for name, mean in zip(self.parameters["parameter"], self.parameters["mean"]))
        return f"<granum.Posterior {self.path}: {', '.join(means)}>"


def calibrate(
    file: str | os.PathLike[str],
    laboratory: str | os.PathLike[str] | Iterable[str | os.PathLike[str]] | Mapping[str, Table],
    *,
    out: str | os.PathLike[str],
    tests: str | Iterable[str] = (),
    predict: str | Iterable[str] = (),
    runs: Iterable[str | os.PathLike[str] | Campaign] = (),
    workers: SupportsIndex | None = None,
    on_note: Callable[[str], object] | None = None,
) -> Posterior:
    """Finds which properties of the grains explain tests of a laboratory, and how surely, as the command `granum calibrate`.

    `file` says what is free and what is compared. `laboratory` are the laboratory's files, or curves by the names of their tests, as
    `granum.laboratory` and `granum.compare` give them. Everything is written into the folder `out`; after an interruption the same call
    goes on. `tests` and `predict` take the place of those that the file names, `"others"` stands for all tests that are not calibrated on;
    `runs` are campaigns from which to learn in place of a design of simulations. `on_note` is called with each line that the command says.

    Raises `granum.RunError` with the message of the command, also if chains do not agree. Ctrl-C ends the simulations in good order.
    """
    import operator
    import subprocess
    import tempfile

    program = script()
    if program is None:
        raise Error("a calibration starts the script `granum`, and it was not installed with this package; install it with pip")
    words = [program, "calibrate", os.fspath(file)]
    with tempfile.TemporaryDirectory(prefix="granum-") as kept:
        if isinstance(laboratory, Mapping):
            words.append(_written(cast("Mapping[str, Table]", laboratory), os.path.join(kept, "laboratory.csv")))
        elif isinstance(laboratory, (str, os.PathLike)):
            words.append(os.fspath(laboratory))
        else:
            words += [os.fspath(path) for path in laboratory]
        words += ["--out", os.fspath(out)]
        for flag, names in (("--test", tests), ("--predict", predict)):
            for name in [names] if isinstance(names, str) else names:
                words += [flag, name]
        for run in runs:
            words += ["--runs", os.fspath(run if isinstance(run, (str, os.PathLike)) else run.path)]
        if workers is not None:
            words += ["--workers", str(operator.index(workers))]
        # In a group of its own: Ctrl-C is passed on once, from here.
        child = subprocess.Popen(
            words, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, encoding="utf-8", start_new_session=True
        )
        told, failure = _follow(child, on_note)
    for text in told:
        warnings.warn(text, RunWarning, stacklevel=2)
    if child.returncode != 0:
        raise RunError(failure or f"granum calibrate ended with the status {child.returncode}")
    return Posterior(out)


def _follow(child: Any, on_note: Callable[[str], object] | None) -> tuple[list[str], str]:
    """Passes on the notes of the command until its end; returns its warnings and its error."""
    import signal

    told: list[str] = []
    failure: list[str] = []
    try:
        for line in child.stderr:
            line = line.rstrip()
            if failure or line.startswith("error: "):
                failure.append(line.removeprefix("error: "))
            elif line.startswith("warning: "):
                told.append(line.removeprefix("warning: "))
            elif line and on_note is not None:
                on_note(line.removeprefix("note: "))
        child.wait()
    except BaseException:
        if child.poll() is None:
            child.send_signal(signal.SIGTERM if os.name == "nt" else signal.SIGINT)
        # It says how it ends, and must not wait for a reader of that.
        for line in child.stderr:
            pass
        child.wait()
        raise
    finally:
        child.stderr.close()
    return told, "\n".join(failure)


def _written(tests: Mapping[str, Table], path: str) -> str:
    """Writes curves as a laboratory's file."""
    import numpy as np

    names = [name for name in _MEASURES if all(name in table and np.isfinite(table[name]).all() for table in tests.values())]
    with open(path, "w", encoding="utf-8") as file:
        file.write(",".join(["test", *(name + _MEASURES[name] for name in names)]) + "\n")
        for test, table in tests.items():
            for row in zip(*(table[name].tolist() for name in names)):
                file.write(",".join([test, *map(repr, row)]) + "\n")
    return path
