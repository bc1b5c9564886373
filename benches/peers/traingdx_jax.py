#!/usr/bin/env python3
"""traingdx in JAX (jitted, double precision, one thread) against granum's, by turns on one core.

Both train a 3-60-60-1 network (tanh, tanh, sigmoid) full batch on 280 rows with the same rule: momentum 0.9, a step that
raises the mean squared error by more than 4 % is rejected (rate * 0.7, momentum dropped), a step that lowers it raises the
rate (* 1.05). The JAX loop runs entirely inside one compiled `fori_loop`.

    python benches/peers/traingdx_jax.py                  # JAX alone
    python benches/peers/traingdx_jax.py --granum target/release/granum     # by turns with granum

Installs nothing: JAX must be there (`pip install jax` in an environment of your own).
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time

os.environ["XLA_FLAGS"] = "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1"
os.environ["JAX_PLATFORMS"] = "cpu"
if hasattr(os, "sched_setaffinity"):
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})

try:
    import jax
    import jax.numpy as jnp
except ImportError:
    sys.exit("JAX is not installed for this Python; see the head of this file")

jax.config.update("jax_enable_x64", True)

ROWS, HIDDEN = 280, 60


def data():
    row = jnp.arange(ROWS)
    strain, f = (row // 7) / (ROWS // 7), (row % 7) / 6.0
    inputs = jnp.stack([2 * strain - 1, 2 * f - 1, (1 - f) * jnp.cos(3 * strain)])
    noise = jax.random.normal(jax.random.PRNGKey(1), (ROWS,), dtype=jnp.float64)
    return inputs, 0.5 + 0.35 * jnp.sin(4 * strain) * (1 - f) + 0.008 * noise


def initial():
    keys = jax.random.split(jax.random.PRNGKey(0), 3)
    shapes = [(HIDDEN, 3), (HIDDEN, HIDDEN), (1, HIDDEN)]
    return [
        (jax.random.normal(key, shape, dtype=jnp.float64) / jnp.sqrt(shape[1]), jnp.zeros((shape[0], 1)))
        for key, shape in zip(keys, shapes)
    ]


INPUTS, TARGETS = data()


def error(weights):
    a = INPUTS
    for w, b in weights[:-1]:
        a = jnp.tanh(w @ a + b)
    w, b = weights[-1]
    return jnp.mean((jax.nn.sigmoid(w @ a + b)[0] - TARGETS) ** 2)


def epoch(_, state):
    weights, step, gradient, value, rate = state
    tree = jax.tree_util.tree_map
    step = tree(lambda s, g: 0.9 * s - 0.1 * rate * g, step, gradient)
    trial = tree(jnp.add, weights, step)
    trial_value, trial_gradient = jax.value_and_grad(error)(trial)
    rejected = trial_value > 1.04 * value
    lower = trial_value < value
    rate = jnp.where(rejected, 0.7 * rate, jnp.where(lower, 1.05 * rate, rate))
    pick = lambda old, new: tree(lambda o, n: jnp.where(rejected, o, n), old, new)
    step = tree(lambda s, g: jnp.where(rejected, -rate * g, s), step, gradient)
    return pick(weights, trial), step, pick(gradient, trial_gradient), jnp.where(rejected, value, trial_value), rate


def jax_rate(epochs):
    weights = initial()
    value, gradient = jax.value_and_grad(error)(weights)
    step = jax.tree_util.tree_map(jnp.zeros_like, weights)
    state = (weights, step, gradient, value, jnp.asarray(0.01))
    run = jax.jit(lambda s: jax.lax.fori_loop(0, epochs, epoch, s))
    jax.block_until_ready(run(state))  # compiles
    # Best of repeats over about three seconds, as on the other side.
    wall = cpu = float("inf")
    clock = time.perf_counter()
    while time.perf_counter() < clock + 3.0:
        start, start_cpu = time.perf_counter(), time.process_time()
        final = jax.block_until_ready(run(state))
        wall = min(wall, time.perf_counter() - start)
        cpu = min(cpu, time.process_time() - start_cpu)
    assert float(final[3]) < float(value), "training did not lower the error"
    return epochs / wall, epochs / cpu


def granum_rate(binary):
    command = [binary, "bench", "--json", "--only", "nets", "--seconds", "3"]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    return next(net["value"] for net in json.loads(output)["nets"] if net["name"].startswith("traingdx"))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--epochs", type=int, default=2000)
    arguments.add_argument("--turns", type=int, default=5)
    arguments.add_argument("--granum", metavar="PROGRAM", help="target/release/granum")
    arguments = arguments.parse_args()
    jax_rates, granum_rates = [], []
    for turn in range(arguments.turns):
        wall, cpu = jax_rate(arguments.epochs)
        jax_rates.append(wall)
        line = f"turn {turn + 1}: JAX {jax.__version__} {wall:.0f} epochs/s ({cpu:.0f} per CPU second)"
        if arguments.granum:
            granum_rates.append(granum_rate(arguments.granum))
            line += f", granum {granum_rates[-1]:.0f} epochs/s"
        print(line, flush=True)
    print(f"best: JAX {max(jax_rates):.0f} epochs/s")
    if granum_rates:
        print(f"best: granum {max(granum_rates):.0f} epochs/s")
        ratios = [g / j for g, j in zip(granum_rates, jax_rates)]
        print(f"granum over JAX: best over best {max(granum_rates) / max(jax_rates):.2f}, "
              f"median of turns {statistics.median(ratios):.2f}")


if __name__ == "__main__":
    main()
