"""The layout in which GrainLearning keeps the triaxial tests that its recurrent networks learn from (HDF5), written and read.

Groups `PRESSURE/KIND`, where PRESSURE is the mean stress with which the tests begin, Pa, and KIND `drained` or `undrained`, have the arrays
`contact_params` (runs, parameters), `inputs` (runs, states, strains) and `outputs` (runs, states, quantities). Writing needs no other package,
reading needs h5py.
"""

from __future__ import annotations

import os
import warnings
from typing import TYPE_CHECKING, Any, SupportsIndex

from ._granum import Dataset, Table, _write_grainlearning
from .errors import FileError, RunWarning

if TYPE_CHECKING:
    from .campaigns import Campaign

__all__ = ["read", "write"]

_IN_MEGAPASCAL = ("p", "q", "mean_stress", "deviator_stress")
"""The stresses, by GrainLearning's names and by those of granum: they are kept in MPa."""
_PRESSURE = "preparation.mean_stress"
"""The column with the mean stress with which a test begins, as the key of a case is called."""


def write(
    path: str | os.PathLike[str], campaign: Campaign | str | os.PathLike[str], *, states: SupportsIndex | None = None, force: bool = False
) -> None:
    """Writes the data set of a campaign of triaxial tests, or of its folder, as `granum export --to grainlearning` does.

    Each run has `states` states, by default as many as the shortest run has: longer runs are cut, and shorter ones left out with a warning.
    With `force` an existing file is replaced. Raises `granum.FileError` if a run is no drained or undrained triaxial test.
    """
    folder = campaign if isinstance(campaign, (str, os.PathLike)) else campaign.path
    left_out = _write_grainlearning(path, folder, states, force)
    if left_out:
        warnings.warn(f"{len(left_out)} runs have fewer than {states} states and are left out: {', '.join(left_out)}", RunWarning, stacklevel=2)


def read(path: str | os.PathLike[str]) -> Dataset:
    """The tests of such a file as a data set, from which surrogates learn. Needs h5py.

    A run is called `PRESSURE/KIND/NUMBER`. Its columns have the names of the file; stresses (`p`, `q`, `mean_stress`, `deviator_stress`), which
    such a file has in MPa, are in Pa, and `preparation.mean_stress` is the pressure of its group, Pa. Parameters of contacts are columns as
    well, but for those that a run does not have (NaN). Raises `granum.FileError` if the file has another layout.
    """
    try:
        import h5py  # type: ignore[import-untyped]
    except ImportError as error:
        raise ImportError("such a file is read by h5py: pip install h5py") from error

    tables: dict[str, Table] = {}
    try:
        with h5py.File(path, "r") as opened:
            file: Any = opened
            for pressure, kinds in file.items():
                for kind, group in kinds.items():
                    names = {what: [str(name) for name in file.attrs[what]] for what in ("outputs", "contact_params", f"inputs_{kind}")}
                    arrays = (group["contact_params"][:], group["inputs"][:], group["outputs"][:])
                    for number, (parameters, inputs, outputs) in enumerate(zip(*arrays), start=1):
                        columns = dict(zip(names[f"inputs_{kind}"], inputs.T)) | dict(zip(names["outputs"], outputs.T))
                        constant = {name: value for name, value in zip(names["contact_params"], parameters) if value == value}
                        tables[f"{pressure}/{kind}/{number}"] = _table(columns, constant | {_PRESSURE: float(pressure)})
    except (OSError, KeyError, ValueError, AttributeError) as error:
        raise FileError(f"{os.fspath(path)}: no tests in the layout of GrainLearning can be read: {error}") from error
    if not tables:
        raise FileError(f"{os.fspath(path)}: there are no tests in the layout of GrainLearning")
    return Dataset(tables)


def _table(columns: dict[str, Any], constant: dict[str, float]) -> Table:
    """The table of a run, in SI units, with what does not change as columns of one value."""
    import numpy as np

    stresses = [name for name in columns if name in _IN_MEGAPASCAL]
    found = {name: np.asarray(values) * (1e6 if name in stresses else 1.0) for name, values in columns.items()}
    rows = len(next(iter(found.values())))
    found |= {name: np.full(rows, value) for name, value in constant.items()}
    return Table(found, {name: "Pa" for name in [*stresses, _PRESSURE]})
