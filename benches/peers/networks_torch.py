#!/usr/bin/env python3
"""PyTorch against `granum bench --only nets`, by turns on one core: training by gradients, and predictions with intervals.

    python benches/peers/networks_torch.py                                   # PyTorch alone
    python benches/peers/networks_torch.py --granum target/release/granum    # by turns with granum

The data follow from formulas and are the same in both programs: 12,000 rows of 8 waves for a network 8-32-32-1 (tanh, tanh, sigmoid), and 64
runs of 100 states of 5 waves for recurrent cells with 32 hidden neurons and a linear read-out of 3. Both take mini-batches in a new random order in
every epoch, limit the norm of the gradient to 1, and step by Adam. PyTorch runs in double precision, as granum does, and in single precision;
of its Adam implementations the fastest here (fused) is used, and its recurrent layers are `torch.nn.GRU` and `LSTM`. Intervals: a granum
network has Laplace's over its training rows; for PyTorch the same formula is written with `torch.func`, batched, with the covariance matrix
of the weights computed once before.

Installs nothing: PyTorch must be there (`pip install torch numpy` in an environment of your own).
"""

import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import time

os.environ["OMP_NUM_THREADS"] = "1"
os.environ["MKL_NUM_THREADS"] = "1"
if hasattr(os, "sched_setaffinity"):
    CORE = max(os.sched_getaffinity(0))
    os.sched_setaffinity(0, {CORE})

try:
    import torch
except ImportError:
    sys.exit("PyTorch is not installed for this Python; see the head of this file")

torch.set_num_threads(1)
ROWS, INPUTS, HIDDEN, BATCH = 12_000, 8, 32, 256
RUNS, STATES, FEATURES, CELLS, OUTPUTS, GROUP = 64, 100, 5, 32, 3, 16
EPOCHS, ASKED, LEARNED = 5, 20_000, 240


def waves(count, step, kind):
    return torch.sin(step * torch.arange(count, dtype=torch.float64)).to(kind)


def table(kind):
    x = waves(ROWS * INPUTS, 0.37, kind).reshape(ROWS, INPUTS)
    return x, (0.5 + 0.3 * torch.sin(x[:, 0] * x[:, 1] + 0.5 * x[:, 2])).unsqueeze(1)


def runs(kind):
    x = waves(RUNS * STATES * FEATURES, 0.37, kind).reshape(RUNS, STATES, FEATURES)
    mean, targets = torch.zeros(RUNS, OUTPUTS, dtype=kind), []
    for k in range(STATES):
        mean = 0.9 * mean + 0.1 * x[:, k, :OUTPUTS]
        targets.append(mean)
    return x, torch.stack(targets, 1)


def network(kind, inputs=INPUTS, hidden=HIDDEN):
    layers = [torch.nn.Linear(inputs, hidden), torch.nn.Tanh(), torch.nn.Linear(hidden, hidden), torch.nn.Tanh()]
    return torch.nn.Sequential(*layers, torch.nn.Linear(hidden, 1), torch.nn.Sigmoid()).to(kind)


class Cell(torch.nn.Module):
    """A recurrent layer with a linear read-out; the first state is learned."""

    def __init__(self, layer, kind):
        super().__init__()
        self.layer = layer(FEATURES, CELLS, batch_first=True)
        self.read_out = torch.nn.Linear(CELLS, OUTPUTS)
        self.to(kind)

    def forward(self, x):
        return self.read_out(self.layer(x)[0])


def best(seconds, call):
    """The shortest time of a call, s."""
    begin, least = time.perf_counter(), math.inf
    while least == math.inf or time.perf_counter() - begin < seconds:
        start = time.perf_counter()
        call()
        least = min(least, time.perf_counter() - start)
    return least


def adam(model, x, y, batch, seconds):
    """Epochs a second."""
    optimiser = torch.optim.Adam(model.parameters(), lr=0.003, fused=True)

    def epochs():
        for _ in range(EPOCHS):
            for chosen in torch.randperm(len(x)).split(batch):
                optimiser.zero_grad(set_to_none=True)
                torch.nn.functional.mse_loss(model(x[chosen]), y[chosen]).backward()
                torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
                optimiser.step()

    return EPOCHS / best(seconds, epochs)


def gradient(model, x, y, seconds):
    """Errors with their gradients a second, over all rows."""

    def call():
        model.zero_grad(set_to_none=True)
        torch.nn.functional.mse_loss(model(x), y).backward()

    return 1 / best(seconds, call)


def lbfgs(x, y, kind, seconds):
    """Steps a second."""
    steps = []

    def call():
        torch.manual_seed(1)
        model = network(kind)
        rule = torch.optim.LBFGS(model.parameters(), max_iter=20, history_size=10, line_search_fn="strong_wolfe", tolerance_change=0)

        def closure():
            rule.zero_grad()
            error = torch.nn.functional.mse_loss(model(x), y)
            error.backward()
            return error

        rule.step(closure)
        steps.append(rule.state[rule._params[0]]["n_iter"])

    least = best(seconds, call)
    return steps[-1] / least


def intervals(hidden, kind, seconds):
    """Predictions with Laplace's standard deviation a second."""
    torch.manual_seed(1)
    model = network(kind, 3, hidden)
    weights = {name: value.detach() for name, value in model.named_parameters()}

    def value(weights, row):
        return torch.func.functional_call(model, weights, (row,))[0]

    both = torch.func.vmap(torch.func.grad_and_value(value), (None, 0))

    def gradients(rows):
        found, values = both(weights, rows)
        return torch.cat([part.reshape(len(rows), -1) for part in found.values()], 1), values

    learned = gradients(waves(3 * LEARNED, 0.37, kind).reshape(-1, 3))[0]
    alpha, beta = 0.1, 1e4
    inverse = torch.linalg.inv(beta * learned.T @ learned + alpha * torch.eye(learned.shape[1], dtype=kind))
    # The covariance of the large network has 16 million numbers: a few rows are enough.
    count = ASKED if hidden < 30 else ASKED // 40
    asked = waves(3 * count, 0.11, kind).reshape(-1, 3)

    def call():
        for rows in asked.split(500):
            g, values = gradients(rows)
            _ = values, (1 / beta + ((g @ inverse) * g).sum(1)).sqrt()

    return 1e-6 * count / best(seconds, call)


def measured(kind, seconds):
    torch.manual_seed(1)
    x, y = table(kind)
    found = {
        "Adam, 12,000 rows in batches of 256, 8-32-32-1": adam(network(kind), x, y, BATCH, seconds),
        "error and gradient, 12,000 rows, 8-32-32-1": gradient(network(kind), x, y, seconds),
        "L-BFGS, 12,000 rows, 8-32-32-1": lbfgs(x, y, kind, seconds),
    }
    x, y = runs(kind)
    for name, layer in (("GRU", torch.nn.GRU), ("LSTM", torch.nn.LSTM)):
        of = Cell(layer, kind)
        found[f"Adam, 64 runs of 100 states in batches of 16, {name} 5-32-3"] = adam(of, x, y, GROUP, seconds)
        found[f"error and gradient, 64 runs, {name} 5-32-3"] = gradient(of, x, y, seconds)
    for hidden in (12, 60):
        found[f"predictions with intervals, 3-{hidden}-{hidden}-1, 240 training rows"] = intervals(hidden, kind, seconds)
    return found


def of_granum(program, seconds):
    command = [program, "--json", "bench", "--only", "nets", "--threads", "1", "--seconds", str(seconds)]
    if hasattr(os, "sched_setaffinity"):
        command = ["taskset", "-c", str(CORE), *command]
    figures = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
    all_figures = figures["nets"] if "nets" in figures else figures["figures"]
    return {figure["name"]: figure["value"] for figure in all_figures}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--granum", help="the program; without it PyTorch alone")
    parser.add_argument("--seconds", type=float, default=1.0, help="time for each figure")
    parser.add_argument("--rounds", type=int, default=3)
    options = parser.parse_args()
    rounds = []
    for _ in range(options.rounds):
        one = {"double": measured(torch.float64, options.seconds), "single": measured(torch.float32, options.seconds)}
        if options.granum:
            one["granum"] = of_granum(options.granum, options.seconds)
        rounds.append(one)
    median = lambda kind, name: statistics.median(one[kind][name] for one in rounds)
    print(f"PyTorch {torch.__version__}, one core, medians of {options.rounds} rounds")
    print(f"{'':62} {'double':>10} {'single':>10} {'granum':>10} {'/ double':>9} {'/ single':>9}")
    for name in rounds[0]["double"]:
        line = f"{name:62} {median('double', name):10.4g} {median('single', name):10.4g}"
        if options.granum:
            own = median("granum", name)
            line += f" {own:10.4g} {own / median('double', name):9.2f} {own / median('single', name):9.2f}"
        print(line)


if __name__ == "__main__":
    main()
