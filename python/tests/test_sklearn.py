"""Surrogates as estimators of scikit-learn."""

import collections
from typing import Any

import granum
import numpy as np
import pytest

sklearn = pytest.importorskip("sklearn")

from granum.sklearn import SurrogateRegressor  # noqa: E402
from test_learning import curve  # noqa: E402


@pytest.mark.filterwarnings("ignore::sklearn.exceptions.SkipTestWarning")
@pytest.mark.parametrize("estimator", [SurrogateRegressor(), SurrogateRegressor("feed-forward", hidden=(4,)), SurrogateRegressor("boosted-trees")])
def test_the_checks_of_scikit_learn_pass(estimator: Any) -> None:
    from sklearn.utils.estimator_checks import check_estimator  # type: ignore[import-untyped]

    results = check_estimator(estimator, on_skip=None)
    counted = collections.Counter(result["status"] for result in results)
    skipped = [result["check_name"] for result in results if result["status"] == "skipped"]
    # A check that is skipped looks like one that passes.
    assert counted["passed"] >= 50 and set(counted) <= {"passed", "skipped"} and skipped in ([], ["check_array_api_input"])


def test_whole_runs_are_left_out_in_a_pipeline() -> None:
    from sklearn.model_selection import GroupKFold, cross_val_score  # type: ignore[import-untyped]
    from sklearn.pipeline import make_pipeline  # type: ignore[import-untyped]
    from sklearn.preprocessing import StandardScaler  # type: ignore[import-untyped]

    data = granum.Dataset({f"run {k}": curve(0.2 + 0.1 * k) for k in range(6)})
    inputs, output = data.values(["arc_length", "friction"]), data["stress_ratio"]
    estimator = SurrogateRegressor(coordinate=0)
    scores = cross_val_score(estimator, inputs, output, groups=data.groups, cv=GroupKFold(3))
    assert scores.shape == (3,) and scores.min() > 0.8
    piped = cross_val_score(make_pipeline(StandardScaler(), SurrogateRegressor("feed-forward", hidden=(6,))), inputs, output, groups=data.groups, cv=GroupKFold(3))
    assert piped.min() > 0.9
    estimator.fit(inputs, output, groups=data.groups)
    own = granum.surrogates.fit(
        granum.Dataset({f"run {k + 1}": granum.Table({"x0": inputs[data.groups == k, 0], "x1": inputs[data.groups == k, 1], "y": output[data.groups == k]}) for k in range(6)}),
        ["x0", "x1"], "y", coordinate="x0", method="ridge",
    )  # fmt: skip
    assert np.array_equal(estimator.predict(inputs), own.means(inputs)[:, 0])
    mean, deviation = estimator.predict(inputs, return_std=True)
    lower, upper = estimator.predict_interval(inputs, level=0.5)
    assert np.array_equal(mean, estimator.predict(inputs)) and np.all(deviation > 0) and np.all((lower < mean) & (mean < upper))
    with pytest.raises(ValueError, match="did you mean ridge"):
        SurrogateRegressor("rigde").fit(inputs, output)
    with pytest.raises(ValueError, match="groups has the shape"):
        estimator.fit(inputs, output, groups=[1, 2])
