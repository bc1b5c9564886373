"""Surrogates as estimators of scikit-learn, for pipelines, searches and cross-validation.

A cross-validation must leave out whole runs, since the states of a run are alike:

    from sklearn.model_selection import GroupKFold, cross_val_score
    from granum.sklearn import SurrogateRegressor

    inputs = ["arc_length", "grains.material.friction"]
    data = granum.Dataset.read("study")
    scores = cross_val_score(
        SurrogateRegressor(), data.values(inputs), data["stress_ratio"], groups=data.groups, cv=GroupKFold(5)
    )
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from sklearn.base import BaseEstimator, RegressorMixin  # type: ignore[import-untyped]
from sklearn.utils.validation import check_is_fitted, validate_data  # type: ignore[import-untyped]

from ._granum import Dataset, Surrogate, Table, fit
from .errors import Error

__all__ = ["SurrogateRegressor"]

_RESERVED = ("run", "stage", "state")


class SurrogateRegressor(RegressorMixin, BaseEstimator):  # type: ignore[misc]
    """A surrogate of granum as a regressor; `granum.surrogates.methods()` lists the methods.

    `coordinate` is the feature along which a test runs: its name, or its number. `hidden` are the numbers of neurons of the hidden layers of
    networks. The fitted surrogate is `surrogate_`, which can be written to a file that the program reads.
    """

    surrogate_: Surrogate

    def __init__(
        self, method: str = "ridge", *, coordinate: str | int | None = None, hidden: tuple[int, ...] | None = None, seed: int = 1
    ) -> None:
        self.method = method
        self.coordinate = coordinate
        self.hidden = hidden
        self.seed = seed

    def __sklearn_tags__(self) -> Any:
        tags = super().__sklearn_tags__()
        tags.target_tags.multi_output = True
        return tags

    def fit(self, X: Any, y: Any, groups: npt.ArrayLike | None = None) -> SurrogateRegressor:
        """Fits a surrogate to rows, of which those with the same value of `groups` are a run; without it all rows are one."""
        X, y = validate_data(self, X, y, dtype=np.float64, multi_output=True, y_numeric=True)
        self._one_output = y.ndim == 1
        outputs = np.asarray(y, dtype=np.float64).reshape(len(X), -1)
        names = [str(name) for name in getattr(self, "feature_names_in_", [f"x{k}" for k in range(X.shape[1])])]
        reserved = [name for name in names if name in _RESERVED]
        if reserved:
            raise ValueError(f"a feature cannot be called {reserved[0]}, which tells the states of a run; give it another name")
        self._outputs = [self._free(f"y{k}", names) for k in range(outputs.shape[1])]
        coordinate = names[self.coordinate] if isinstance(self.coordinate, int) else self.coordinate
        runs = np.zeros(len(X)) if groups is None else np.asarray(groups)
        if runs.shape != (len(X),):
            raise ValueError(f"there are {len(X)} rows, and groups has the shape {runs.shape}")
        tables = {}
        for number, run in enumerate(np.unique(runs)):
            rows = runs == run
            columns = dict(zip(names, X[rows].T)) | dict(zip(self._outputs, outputs[rows].T))
            tables[f"run {number + 1}"] = Table(columns)
        try:
            self.surrogate_ = fit(
                Dataset(tables), names, self._outputs, method=self.method, coordinate=coordinate, hidden=self.hidden, seed=self.seed
            )
        except Error as error:
            raise ValueError(f"{len(X)} rows of {X.shape[1]} features cannot be fitted: {error}") from error
        return self

    @staticmethod
    def _free(name: str, taken: list[str]) -> str:
        while name in taken:
            name += "_"
        return name

    def _rows(self, X: Any) -> tuple[Surrogate, npt.NDArray[np.float64]]:
        check_is_fitted(self)
        return self.surrogate_, np.asarray(validate_data(self, X, dtype=np.float64, reset=False), dtype=np.float64)

    def _shaped(self, values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
        return values[:, 0] if self._one_output else values

    def predict(self, X: Any, return_std: bool = False) -> Any:
        """The means; with `return_std` also the standard deviations (NaN for a method without intervals)."""
        surrogate, rows = self._rows(X)
        if not return_std:
            return self._shaped(np.array(surrogate.means(rows)))
        found = surrogate.predict(rows)["outputs"].values()
        return tuple(self._shaped(np.column_stack([output[name] for output in found])) for name in ("mean", "standard_deviation"))

    def predict_interval(self, X: Any, level: float = 0.9) -> tuple[npt.NDArray[np.float64], npt.NDArray[np.float64]]:
        """The ends of the intervals that should contain the share `level` of the observations of new runs."""
        surrogate, rows = self._rows(X)
        found = surrogate.predict(rows, level=level)["outputs"].values()
        lower, upper = (self._shaped(np.column_stack([output[name] for output in found])) for name in ("lower", "upper"))
        return lower, upper
