"""A Gaussian process of scikit-learn on the principal components of whole curves, judged as `judge_curves` judges granum's.

    python3 benches/peers/surrogates/curves.py data/families/sand/drained,data/families/sand/drained-further,data/families/sand/drained-rest \\
      data/families/sand/unseen 24 48 96 191 340 all
    cargo run --release -p granum --example judge_curves -- \\
      data/families/sand/drained,data/families/sand/drained-further,data/families/sand/drained-rest data/families/sand/unseen 24 48 96 191 340 all

For each number of runs the first so many are learned from, for `24x20` twenty sets of 24 runs, one after another. The error is that of the prediction for the mean sample of a material against the mean of
its samples, less what this mean scatters itself, over the scatter of single runs. Needs numpy, pandas, pyarrow and scikit-learn.
"""

import sys

import numpy as np
import pyarrow.parquet as pq
from sklearn.exceptions import ConvergenceWarning
from sklearn.gaussian_process import GaussianProcessRegressor
from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
from sklearn.preprocessing import StandardScaler
import warnings

warnings.simplefilter("ignore", ConvergenceWarning)
STATES, END, COMPONENTS = 126, 0.249, 8
OUTPUTS = ["stress_ratio", "volumetric_strain", "deviator_fabric", "mechanical_coordination_number", "sliding_fraction"]
POINT = ["grains.material.friction", "contact.rolling_friction", "preparation.mean_stress", "grains.spread", "preparation.friction"]
STRAINS = np.linspace(0, END, STATES)


def read(folders):
    """Of each run that reaches the last strain: its material, its inputs, and its curves on equal strains."""
    found = []
    for folder in folders.split(","):
        runs = pq.read_table(f"{folder}/runs.parquet").to_pandas()
        states = pq.read_table(f"{folder}/states.parquet", columns=["run", "stage", "axial_strain", "solid_fraction", *OUTPUTS]).to_pandas()
        of_run = dict(list(states.groupby("run", sort=False)))
        for _, run in runs.iterrows():
            own = of_run[run["run"]]
            own = own[own["stage"] == own["stage"].iloc[-1]]
            if own["axial_strain"].max() <= END:
                continue
            first = own.iloc[0]
            inputs = [float(run[key]) for key in POINT]
            sample = [1 / first["solid_fraction"] - 1, first["mechanical_coordination_number"]]
            curves = [np.interp(STRAINS, own["axial_strain"], own[output]) for output in OUTPUTS]
            found.append((tuple(inputs), np.array(inputs + sample), np.array(curves)))
    return found


def columns(inputs):
    """The stress by its logarithm."""
    inputs = np.array(inputs)
    inputs[:, 2] = np.log(inputs[:, 2])
    return inputs


class Curves:
    def __init__(self, inputs, curves):
        self.scaler = StandardScaler().fit(columns(inputs))
        self.mean = curves.mean(axis=0)
        _, _, directions = np.linalg.svd(curves - self.mean, full_matrices=False)
        self.directions = directions[:COMPONENTS]
        weights = (curves - self.mean) @ self.directions.T
        rows = self.scaler.transform(columns(inputs))
        kernel = ConstantKernel(1.0) * RBF(np.ones(rows.shape[1])) + WhiteKernel(0.1)
        fit = lambda w: GaussianProcessRegressor(kernel, normalize_y=True, n_restarts_optimizer=1, random_state=1).fit(rows, w)
        self.processes = [fit(w) for w in weights.T]

    def predict(self, inputs):
        rows = self.scaler.transform(columns(inputs))
        return self.mean + np.array([p.predict(rows) for p in self.processes]).T @ self.directions


def judge(training, unseen, model_of=Curves):
    inputs = [run[1] for run in training]
    materials = {}
    for point, sample, curves in unseen:
        materials.setdefault(point, []).append((sample, curves))
    for number, output in enumerate(OUTPUTS):
        model = model_of(inputs, np.array([run[2][number] for run in training]))
        within, net = [], []
        for samples in materials.values():
            if len(samples) <= 2:
                continue
            curves = np.array([curves[number] for _, curves in samples])
            centre = curves.mean(axis=0)
            variance = ((curves - centre) ** 2).mean(axis=1).sum() / (len(samples) - 1)
            predicted = model.predict([np.mean([sample for sample, _ in samples], axis=0)])[0]
            within.append(variance)
            net.append(((predicted - centre) ** 2).mean() - variance / len(samples))
        yield output, np.array(net), np.sqrt(np.mean(within)), model


def root(square):
    return np.sign(square) * np.sqrt(abs(square))


def show(training, unseen, model_of):
    for output, net, scatter, _ in judge(training, unseen, model_of):
        square = np.mean(net)
        error = 0.5 * np.std(net) / np.sqrt(len(net) - 1) / np.sqrt(abs(square)) / scatter
        print(f"  {output:32} {root(square) / scatter:.2f} +- {error:.2f}", flush=True)


def show_sets(training, unseen, model_of, count, sets):
    """The root of the mean of the squared errors of the sets, with its standard error over them, and the error of each; on the materials of
    `unseen`, and on the single runs of all others of the training data."""
    squares = {(output, on): [] for output in OUTPUTS for on in ("mean", "others")}
    for k in range(min(sets, len(training) // count)):
        own = training[k * count : (k + 1) * count]
        others = training[: k * count] + training[(k + 1) * count :]
        for number, (output, net, scatter, model) in enumerate(judge(own, unseen, model_of)):
            squares[output, "mean"].append(np.mean(net) / scatter**2)
            apart = model.predict([run[1] for run in others]) - np.array([run[2][number] for run in others])
            squares[output, "others"].append((apart**2).mean() / scatter**2)
    for (output, on), own in squares.items():
        error = 0.5 * np.std(own) / np.sqrt(len(own) - 1) / np.sqrt(abs(np.mean(own)))
        print(f"  {output:32} {on:6} {root(np.mean(own)):.3f} +- {error:.3f}  " + " ".join(f"{root(square):.2f}" for square in own), flush=True)


def main(model_of=Curves):
    training, unseen = read(sys.argv[1]), read(sys.argv[2])
    print(f"{len(training)} training runs, {len(unseen)} unseen ones")
    for count in sys.argv[3:]:
        if "x" in count:
            number, sets = map(int, count.split("x"))
            print(f"{sets} sets of {number} runs: output, error, and of each set", flush=True)
            show_sets(training, unseen, model_of, number, sets)
            continue
        number = len(training) if count == "all" else int(count)
        print(f"{number} runs: output, error over the scatter of a run", flush=True)
        show(training[:number], unseen, model_of)


if __name__ == "__main__":
    main()
