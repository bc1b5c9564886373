"""Regressors of scikit-learn on the table of `granum worth`.

    granum export study -o states.csv
    granum export study --table runs -o runs.csv
    granum worth study --unseen-share 0.2 -o worth.json
    python3 benches/peers/surrogates/scikit.py states.csv runs.csv worth.json

The same runs are unseen (those that worth.json names), the first of the others are learned from, as many as granum had, with the same inputs and
outputs, and the error is the same: the root mean square error over the root mean square of the values. Of boosted trees (HistGradientBoostingRegressor), random forests, and ridge regression on
products of two inputs, the one with the least error on every fifth training run is fitted to all; where all inputs beside the
coordinate are constant in a run, a Gaussian process of eight principal components of the curve is tried as well.
"""

import csv
import json
import sys

import numpy as np
from sklearn.ensemble import HistGradientBoostingRegressor, RandomForestRegressor
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.linear_model import RidgeCV
from sklearn.pipeline import make_pipeline
from sklearn.preprocessing import PolynomialFeatures, StandardScaler

POINTS, COMPONENTS = 65, 8


class Curves:
    """A Gaussian process of each of the first principal components of curves."""

    def __init__(self, coordinate):
        self.coordinate = coordinate

    def split(self, rows):
        others = np.delete(rows, self.coordinate, axis=1)
        starts = np.flatnonzero(np.r_[True, np.any(np.diff(others, axis=0) != 0, axis=1)])
        return others[starts], np.split(np.arange(len(rows)), starts[1:])

    def fit(self, rows, values):
        others, runs = self.split(rows)
        xs = [rows[run, self.coordinate] for run in runs]
        self.points = np.linspace(max(x[0] for x in xs), min(x[-1] for x in xs), POINTS)
        curves = np.array([np.interp(self.points, x, values[run]) for x, run in zip(xs, runs)])
        self.mean = curves.mean(axis=0)
        _, _, directions = np.linalg.svd(curves - self.mean, full_matrices=False)
        self.directions = directions[:COMPONENTS]
        weights = (curves - self.mean) @ self.directions.T
        self.scaler = StandardScaler().fit(others)
        kernel = ConstantKernel(1.0) * RBF(np.ones(others.shape[1])) + WhiteKernel(0.1)
        inputs = self.scaler.transform(others)
        self.processes = [
            GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=1, random_state=1).fit(inputs, w)
            for w in weights.T
        ]
        return self

    def predict(self, rows):
        others, runs = self.split(rows)
        weights = np.array([p.predict(self.scaler.transform(others)) for p in self.processes]).T
        curves = self.mean + weights @ self.directions
        found = np.empty(len(rows))
        for run, curve in zip(runs, curves):
            found[run] = np.interp(rows[run, self.coordinate], self.points, curve)
        return found


def candidates(coordinate, constant):
    yield "boosted trees", lambda: HistGradientBoostingRegressor(max_iter=300, random_state=1)
    yield "random forest", lambda: RandomForestRegressor(100, min_samples_leaf=3, n_jobs=-1, random_state=1)
    ridge = lambda: make_pipeline(  # noqa: E731
        StandardScaler(), PolynomialFeatures(2), StandardScaler(), RidgeCV(np.logspace(-3, 4, 15))
    )
    yield "quadratic ridge", ridge
    if constant:
        yield "Gaussian process", lambda: Curves(coordinate)


def read(file):
    with open(file) as lines:
        reader = csv.reader(lines)
        return next(reader), list(reader)


def error(predicted, values):
    return np.sqrt(np.sum((predicted - values) ** 2) / np.sum(values**2))


def main(states, runs, answers):
    with open(answers) as file:
        worth = json.load(file)
    names, lines = read(states)
    place = {name: k for k, name in enumerate(names)}
    columns_of_runs, each = read(runs)
    of_run = {line[columns_of_runs.index("run")]: line for line in each}

    def columns(wanted):
        """The columns that a name stands for: itself, or all bins of a histogram."""
        own = wanted in place or wanted in columns_of_runs
        return [wanted] if own else [name for name in names if name.startswith(wanted + "_")]

    def values(name):
        if name in place:
            return np.array([float(line[place[name]] or "nan") for line in lines])
        return np.array([float(of_run[name_of_run][columns_of_runs.index(name)]) for name_of_run in run])

    run = np.array([line[place["run"]] for line in lines])
    unseen = np.isin(run, worth["unseen"])
    count, most = max(worth["plan"]["counts"]), worth["plan"]["most_states"]
    first = list(dict.fromkeys(run[~unseen]))[:count]
    training = np.flatnonzero(np.isin(run, first))
    training = training[:: -(-len(training) // most)]
    order = {name: k for k, name in enumerate(first)}
    fifth = np.array([order[name] % 5 == 2 for name in run[training]])
    others, judged = training[~fifth], training[fifth]
    coordinate = worth["plan"]["coordinate"]
    for answer in worth["answers"]:
        knowledge = answer["knowledge"]
        if knowledge["source"] != "measured" or answer["training_runs"] != count:
            continue
        inputs = [coordinate] + (worth["plan"]["properties"] if knowledge["properties"] else [])
        inputs += [name for wanted in knowledge["measured"] for name in columns(wanted)]
        targets = columns(answer["output"])
        if len(targets) > 1:
            continue
        rows, exact = np.array([values(name) for name in inputs]).T, values(targets[0])
        best = None
        for name, make in candidates(0, not knowledge["measured"] and len(inputs) > 1):
            found = error(make().fit(rows[others], exact[others]).predict(rows[judged]), exact[judged])
            if best is None or found < best[0]:
                best = (found, name, make)
        _, name, make = best
        theirs = error(make().fit(rows[training], exact[training]).predict(rows[unseen]), exact[unseen])
        ours = answer["error"]
        print(
            f"{answer['output']:32} {knowledge['name']:58} scikit-learn {100 * theirs:6.2f} % ({name}), "
            f"granum {100 * ours['relative']:6.2f} +- {100 * ours['standard_error']:.2f} % ({answer['method']})",
            flush=True,
        )


if __name__ == "__main__":
    main(*sys.argv[1:])
