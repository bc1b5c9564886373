#!/usr/bin/env python3
"""A long short-term memory of the shape of GrainLearning's tutorial, trained in PyTorch on the random paths that are shipped with granum, and judged as
`granum examine paths` judges granum's surrogates.

    python3 benches/peers/surrogates/paths_lstm.py data/families/sand/random-paths data/families/sand/random-paths-unseen
    granum examine paths data/families/sand/random-paths --unseen data/families/sand/random-paths-unseen

As there (`grainlearning.rnn.models.rnn_model`): a window of the last strains goes through an LSTM whose first memory and cell are dense layers of the
constants of a run, then through a dense layer (ReLU) and a linear one; the windows of the first states are padded at their beginning; inputs and labels are standardised; Adam with
batches of 256 minimises the mean squared error until that on held-out runs has not fallen for `--patience` epochs. The constants are what granum's surrogates
know of a sample: void ratio, coordination number, and the components of its stress and fabric. Its strains are the deviator alone, since the volume is predicted. `--rotations`
adds randomly rotated copies of each run, which the tutorial does not have. Needs torch, numpy, pandas and pyarrow.
"""

import argparse
import time

import numpy as np
import pyarrow.parquet as pq
import torch

STRAINS = ["axial_strain", "lateral_strain_2", "lateral_strain_3", "shear_strain_yz", "shear_strain_zx", "shear_strain_xy"]
TENSOR = ["11", "22", "33", "23", "13", "12"]
QUANTITIES = {"stress deviator": slice(0, 5), "fabric deviator": slice(5, 10), "volumetric strain": slice(10, 11), "coordination number": slice(11, 12)}
BATCH = 256


def parts(six):
    """Components of the deviator in an orthonormal basis, and a third of the trace."""
    xx, yy, zz, yz, zx, xy = six.T
    deviator = [(2 * xx - yy - zz) / 6**0.5, (yy - zz) / 2**0.5, 2**0.5 * yz, 2**0.5 * zx, 2**0.5 * xy]
    return np.stack(deviator, 1), (xx + yy + zz) / 3


def read(folder):
    """For each run its kind, its constants, strains and labels."""
    runs = pq.read_table(f"{folder}/runs.parquet").to_pandas().set_index("run")
    states = pq.read_table(f"{folder}/states.parquet").to_pandas()
    found = []
    for name, own in states.groupby("run", sort=False):
        strain, _ = parts(own[STRAINS].to_numpy() * [1, 1, 1, 0.5, 0.5, 0.5])
        stress, mean = parts(own[[f"stress_{k}" for k in TENSOR]].to_numpy())
        fabric, _ = parts(own[[f"fabric_{k}" for k in TENSOR]].to_numpy())
        scalars = own[["volumetric_strain", "mechanical_coordination_number"]].to_numpy()
        labels = np.concatenate([stress / mean[:, None], fabric, scalars], 1)
        run = runs.loc[name]
        constants = np.concatenate([labels[0, :10], [run["sample.void_ratio"], run["sample.mechanical_coordination_number"]]])
        found.append((run["stage.1.kind"], constants, strain, labels))
    return found


def turned(run, random):
    """A run in other axes."""
    q = random.normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    r = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])
    basis = np.zeros((5, 3, 3))
    basis[0], basis[1] = np.diag([2, -1, -1]) / 6**0.5, np.diag([0, 1, -1]) / 2**0.5
    for k, (i, j) in enumerate([(1, 2), (2, 0), (0, 1)]):
        basis[2 + k, i, j] = basis[2 + k, j, i] = 0.5**0.5
    turn = np.einsum("kij,ia,lab,jb->kl", basis, r, basis, r)
    kind, constants, strain, labels = run
    constants, labels = constants.copy(), labels.copy()
    for first in (0, 5):
        constants[first:first + 5] = turn @ constants[first:first + 5]
        labels[:, first:first + 5] = labels[:, first:first + 5] @ turn.T
    return kind, constants, strain @ turn.T, labels


class Windows(torch.nn.Module):
    def __init__(self, constants, units, dense, labels):
        super().__init__()
        self.memory, self.cell = torch.nn.Linear(constants, units), torch.nn.Linear(constants, units)
        self.layer = torch.nn.LSTM(5, units, batch_first=True)
        self.dense, self.read_out = torch.nn.Linear(units, dense), torch.nn.Linear(dense, labels)

    def forward(self, strains, constants):
        first = (torch.tanh(self.memory(constants)).unsqueeze(0), torch.tanh(self.cell(constants)).unsqueeze(0))
        return self.read_out(torch.relu(self.dense(self.layer(strains, first)[0][:, -1])))


class Scale:
    def __init__(self, rows):
        self.mean, self.deviation = rows.mean(0), np.maximum(rows.std(0), 1e-12)

    def __call__(self, rows):
        return (rows - self.mean) / self.deviation

    def back(self, rows):
        return rows * self.deviation + self.mean


def windows(runs, scales, size):
    """Strains, constants and labels of all states; the first windows begin with the first strain, again and again."""
    strains, constants, labels = [], [], []
    for _, own, strain, label in runs:
        strain = scales[0](strain)
        padded = np.concatenate([np.repeat(strain[:1], size - 1, 0), strain])
        strains.append(np.lib.stride_tricks.sliding_window_view(padded, size, 0).transpose(0, 2, 1))
        constants.append(np.repeat(scales[1](own)[None], len(strain), 0))
        labels.append(scales[2](label))
    return [torch.tensor(np.concatenate(part), dtype=torch.float32) for part in (strains, constants, labels)]


def trained(runs, judged, scales, options):
    torch.manual_seed(options.seed)
    model = Windows(len(scales[1].mean), options.units, options.units, 12)
    optimiser = torch.optim.Adam(model.parameters(), lr=options.rate)
    x, c, y = windows(runs, scales, options.window)
    judge = windows(judged, scales, options.window)
    best, since, kept = np.inf, 0, None
    for epoch in range(options.epochs):
        model.train()
        for chosen in torch.randperm(len(x)).split(BATCH):
            optimiser.zero_grad(set_to_none=True)
            torch.nn.functional.mse_loss(model(x[chosen], c[chosen]), y[chosen]).backward()
            optimiser.step()
        error = ((predicted(model, judge[0], judge[1]) - judge[2]) ** 2).mean().item()
        print(f"epoch {epoch + 1}: error on held-out runs {error:.4f}", flush=True)
        if error < best:
            best, since, kept = error, 0, {key: value.clone() for key, value in model.state_dict().items()}
        else:
            since += 1
            if since >= options.patience:
                break
    model.load_state_dict(kept)
    return model


def predicted(model, x, c):
    model.eval()
    with torch.no_grad():
        return torch.cat([model(a, b) for a, b in zip(x.split(4096), c.split(4096))])


def pooled(sums):
    """The error with its standard error over runs, in percent."""
    errors, values = np.array(sums).T
    ratio = errors.sum() / values.sum()
    spread = np.sqrt(((errors - ratio * values) ** 2).sum() * len(sums) / (len(sums) - 1)) / values.sum()
    return f"{100 * ratio**0.5:.1f} ± {50 * spread / ratio**0.5:.1f}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("training")
    parser.add_argument("unseen")
    parser.add_argument("--window", type=int, default=20, help="states of a window")
    parser.add_argument("--units", type=int, default=200, help="units of the LSTM, and of the dense layer")
    parser.add_argument("--rate", type=float, default=1e-3, help="rate of learning")
    parser.add_argument("--epochs", type=int, default=100)
    parser.add_argument("--patience", type=int, default=5)
    parser.add_argument("--rotations", type=int, default=0, help="rotated copies of each run")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    torch.set_num_threads(1)
    begin = time.perf_counter()
    all_runs, unseen = read(options.training), read(options.unseen)
    held_out, learned = all_runs[::4], [run for k, run in enumerate(all_runs) if k % 4]
    random = np.random.default_rng(options.seed)
    learned = learned + [turned(run, random) for _ in range(options.rotations) for run in learned]
    scales = [Scale(np.concatenate([run[2] for run in learned])), Scale(np.stack([run[1] for run in learned])), Scale(np.concatenate([run[3] for run in learned]))]
    model = trained(learned, held_out, scales, options)
    means = np.concatenate([run[3] for run in all_runs]).mean(0)
    means[:10] = 0
    kinds = ["all"] + sorted({run[0] for run in unseen})
    x, c, _ = windows(unseen, scales, options.window)
    rows = scales[2].back(predicted(model, x, c).numpy())
    print(f"PyTorch {torch.__version__}, {time.perf_counter() - begin:.0f} s; relative RMSE on {len(unseen)} unseen runs, in percent, with its standard error over these runs")
    print(f"{'':22}" + "".join(f"{kind:>14}" for kind in kinds))
    for name, columns in QUANTITIES.items():
        sums, first = [], 0
        for kind, _, strain, labels in unseen:
            own = rows[first:first + len(strain), columns]
            first += len(strain)
            sums.append((kind, ((own - labels[:, columns]) ** 2).sum(), ((labels[:, columns] - means[columns]) ** 2).sum()))
        cells = [pooled([values for of, *values in sums if kind in ("all", of)]) for kind in kinds]
        print(f"{name:22}" + "".join(f"{cell:>14}" for cell in cells))


if __name__ == "__main__":
    main()
