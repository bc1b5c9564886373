#!/usr/bin/env python3
"""Yardsticks for the surrogate of a step of a finite element: recurrent networks of PyTorch and a hypoplastic law on the data of the plan sand-step, judged as
`granum examine paths` judges granum's surrogates.

    python3 benches/peers/surrogates/sand_step.py data/families/sand/step data/families/sand/step-unseen lstm
    python3 benches/peers/surrogates/sand_step.py data/families/sand/step data/families/sand/step-unseen gru
    python3 benches/peers/surrogates/sand_step.py data/families/sand/step data/families/sand/step-unseen hypoplastic
    python3 benches/peers/surrogates/sand_step.py data/families/sand/step data/families/sand/step-unseen check
    granum examine paths data/families/sand/step --unseen data/families/sand/step-unseen --volume-is-input --property grains.material.friction contact.rolling_friction

`lstm` and `gru` train one network on whole runs, from the state of the sample to the end of the path. Its inputs are those of granum's surrogate: the
increments of the six strains, and as a first memory a dense layer of the stress, fabric, coordination number and void ratio of the sample and of the two frictions. So are its outputs: the
deviator of stress over mean stress and the logarithm of the mean stress, both with 2 % of the average mean stress added to the mean stress, the
deviator of fabric, and the coordination number. Adam minimises the mean squared error of the standardised outputs with a rate that falls to zero along half a cosine. In each epoch each run is turned
at random. One run in eight is held out; the network of the epoch with the least error on these is kept.

`hypoplastic` calibrates the eight parameters of the law in hypoplasticity.py on some of the training runs, once for all sands and once for each
of four groups of sands by their frictions. It knows the void ratio and the stress of the sample and the strains, and no frictions.

`check` prints what needs no model, which granum prints as well. All print errors over all states of the unseen runs with their standard errors over runs, and the work in closed
cycles of strain. Needs numpy, pandas and pyarrow, for networks torch, for the hypoplastic law scipy.
"""

import argparse
import time

import numpy as np
import pyarrow.parquet as pq

STRAINS = ["axial_strain", "lateral_strain_2", "lateral_strain_3", "shear_strain_yz", "shear_strain_zx", "shear_strain_xy"]
TENSOR = ["11", "22", "33", "23", "13", "12"]
QUANTITIES = ["stress deviator", "logarithm of mean stress", "fabric deviator"]
# As in crates/granum-learn/src/examine/paths/quantities.rs.
LEAST_PRESSURE, LARGEST_RATIO = 1e3, 6**0.5
# The share of the average mean stress that is added before ratios and logarithms are learned, as in granum's surrogate.
OFFSET = 0.02


def parts(six, axis=-1):
    """Components of the deviator in an orthonormal basis, and a third of the trace."""
    xx, yy, zz, yz, zx, xy = np.moveaxis(six, axis, 0)
    deviator = [(2 * xx - yy - zz) / 6**0.5, (yy - zz) / 2**0.5, 2**0.5 * yz, 2**0.5 * zx, 2**0.5 * xy]
    return np.stack(deviator, axis), (xx + yy + zz) / 3


def judged(stress, axis=1):
    """The deviator of stress over mean stress, and the logarithm of the mean stress, as granum judges them."""
    deviator, mean = parts(stress, axis)
    mean = np.maximum(mean, LEAST_PRESSURE)
    norm = np.sqrt((deviator**2).sum(axis))
    factor = np.minimum(1 / mean, LARGEST_RATIO / np.maximum(norm, 1e-300))
    return deviator * np.expand_dims(factor, axis), np.log(mean)


class Run:
    """A run: its path and kinds, its sample, and its states."""

    def __init__(self, name, own, run):
        def tensor(name):
            return run[[f"sample.{name}_{k}" for k in TENSOR]].to_numpy(float)

        self.name = name
        self.kinds = ["all", run["stage.1.kind"], run["stage.1.drainage"]]
        self.path = tuple(run[[key for key in run.index if key.startswith("variable.")]])
        self.void_ratio, self.sample_coordination = run["sample.void_ratio"], run["sample.mechanical_coordination_number"]
        self.frictions = run[["grains.material.friction", "contact.rolling_friction"]].to_numpy(float)
        self.sample_stress, self.sample_fabric = tensor("stress"), tensor("fabric")
        # A shear strain of the tables is an angle, twice the component.
        self.strain = own[STRAINS].to_numpy() * [1, 1, 1, 0.5, 0.5, 0.5]
        self.stress, self.fabric = (own[[f"{name}_{k}" for k in TENSOR]].to_numpy() for name in ("stress", "fabric"))
        self.coordination = own["mechanical_coordination_number"].to_numpy()
        self.stage, self.state = own["stage"].to_numpy(), own["state"].to_numpy()
        self.judged = [*judged(self.stress), parts(self.fabric)[0]]


def read(folder):
    runs = pq.read_table(f"{folder}/runs.parquet").to_pandas().set_index("run")
    states = pq.read_table(f"{folder}/states.parquet").to_pandas()
    return [Run(name, own, runs.loc[name]) for name, own in states.groupby("run", sort=False)]


def squares(quantity, exact, rows, means):
    """Sums over states of the squared error and of the squared reference: of tensors the tensor itself, of scalars the difference from the mean of the training states."""
    reference = means[1] if quantity == 1 else 0.0
    return np.array([((exact - rows) ** 2).sum(), ((exact - reference) ** 2).sum()])


def pooled(sums):
    """The error with its standard error over runs, in percent."""
    errors, values = np.array(sums).T
    if values.sum() <= 0 or errors.sum() <= 0:
        return "0"
    ratio = errors.sum() / values.sum()
    spread = np.sqrt(((errors - ratio * values) ** 2).sum() * len(sums) / max(len(sums) - 1, 1)) / values.sum()
    return f"{100 * ratio**0.5:.1f} ± {50 * spread / ratio**0.5:.1f}"


def table(method, runs, sums):
    """Errors by quantity and kind; `sums` are those of each run and quantity, or nothing for a quantity that is not predicted."""
    kinds = list(dict.fromkeys(kind for of in range(3) for kind in sorted({run.kinds[of] for run in runs})))
    print(f"\n{method}: relative RMSE on {len(runs)} runs, in percent, with its standard error over them")
    print(f"{'':26}" + "".join(f"{kind:>14}" for kind in kinds))
    for quantity, name in enumerate(QUANTITIES):
        if quantity < len(sums[0]):
            cells = [pooled([own[quantity] for run, own in zip(runs, sums) if kind in run.kinds]) for kind in kinds]
            print(f"{name:26}" + "".join(f"{cell:>14}" for cell in cells))


def judge(method, runs, rows, means):
    """Errors of rows, for each run its quantities, and the work in closed cycles."""
    table(method, runs, [[squares(k, run.judged[k], own[k], means) for k in range(len(own))] for run, own in zip(runs, rows)])
    exact, found = (np.concatenate([[work(run, cycle, ratio) for cycle in cycles(run)] for run, ratio in zip(runs, ratios) if cycles(run)])
                    for ratios in ([run.judged[0] for run in runs], [own[0] for own in rows]))
    error = np.sqrt(((found - exact) ** 2).sum() / (exact**2).sum())
    print(f"work in {len(exact)} closed cycles: negative in {(found < -1e-9 * exact.mean()).sum()}, least over mean {100 * found.min() / exact.mean():.1f} %, error {100 * error:.1f} %")


def cycles(run):
    """First and last rows of cycles that lead over two turning points back to the same deviator of strain."""
    strain = parts(run.strain)[0]
    turns = np.flatnonzero(np.diff(run.stage)) + 1
    found = []
    for first, last in zip(turns, turns[2:]):
        length = np.sqrt((np.diff(strain[first : last + 1], axis=0) ** 2).sum(1)).sum()
        if length > 0 and np.sqrt(((strain[last] - strain[first]) ** 2).sum()) < 0.01 * length:
            found.append((first, last))
    return found


def work(run, cycle, ratio):
    """The work of the deviator of stress over mean stress, by the trapezoidal rule."""
    own = slice(cycle[0], cycle[1] + 1)
    strain, ratio = parts(run.strain)[0][own], ratio[own]
    return (0.5 * (ratio[1:] + ratio[:-1]) * np.diff(strain, axis=0)).sum()


def check(unseen, means):
    """What needs no model: the scatter between samples on the same path, and the state of the sample."""
    pairs, sums = [], []
    for k, run in enumerate(unseen):
        other = next((other for other in unseen[k + 1 :] if other.path == run.path), None)
        if other:
            places = {key: row for row, key in enumerate(zip(other.stage, other.state))}
            rows = [(row, places[key]) for row, key in enumerate(zip(run.stage, run.state)) if key in places]
            a, b = np.array(rows).T
            pairs.append(run)
            sums.append([squares(q, run.judged[q][a], other.judged[q][b], means) * [0.5, 1] for q in range(3)])
    table("another sample", pairs, sums)
    first = [[*judged(np.repeat(run.sample_stress[None], len(run.strain), 0)), np.repeat(parts(run.sample_fabric)[0][None], len(run.strain), 0)] for run in unseen]
    judge("state of the sample", unseen, first, means)


class Form:
    """Runs as networks see them, and back."""

    def __init__(self, runs):
        self.offset = OFFSET * np.concatenate([run.stress[:, :3].mean(1) for run in runs]).mean()
        self.length = np.sqrt(np.mean(np.concatenate([self.increments(run).ravel() for run in runs]) ** 2)) if runs else 1.0
        labels = np.concatenate([self.of(run.stress, run.fabric, run.coordination) for run in runs])
        starts = np.stack([self.start(run) for run in runs])
        # Components of a tensor have one scale and no mean, so that a turned run is one of the same kind.
        self.labels = self.scale(labels, [slice(0, 5), slice(5, 10)])
        self.starts = self.scale(starts, [slice(0, 5), slice(5, 10)])

    @staticmethod
    def scale(rows, tensors):
        mean, deviation = rows.mean(0), np.maximum(rows.std(0), 1e-12)
        for own in tensors:
            mean[own], deviation[own] = 0.0, np.sqrt((rows[:, own] ** 2).mean())
        return mean, deviation

    @staticmethod
    def increments(run):
        deviator, mean = parts(np.diff(run.strain, axis=0, prepend=np.zeros((1, 6))))
        return np.concatenate([deviator, 3**0.5 * mean[:, None]], 1)

    def of(self, stress, fabric, coordination):
        deviator, mean = parts(stress)
        unit = np.maximum(mean + self.offset, 0.05 * self.offset)
        return np.concatenate([deviator / unit[..., None], parts(fabric)[0], coordination[..., None], np.log(unit)[..., None]], -1)

    def start(self, run):
        return np.concatenate([self.of(run.sample_stress, run.sample_fabric, np.array(run.sample_coordination)), [run.void_ratio], run.frictions])

    def tensors(self, run):
        """Increments, standardised start and standardised labels."""
        labels = self.of(run.stress, run.fabric, run.coordination)
        return self.increments(run) / self.length, (self.start(run) - self.starts[0]) / self.starts[1], (labels - self.labels[0]) / self.labels[1]

    def back(self, values):
        """What is judged, from standardised labels."""
        own = values * self.labels[1] + self.labels[0]
        unit = np.exp(own[:, 11])
        mean = np.maximum(unit - self.offset, LEAST_PRESSURE)
        deviator = own[:, :5] * unit[:, None]
        norm = np.sqrt((deviator**2).sum(1))
        return [deviator * np.minimum(1 / mean, LARGEST_RATIO / np.maximum(norm, 1e-300))[:, None], np.log(mean), own[:, 5:10]]


def rotations(count, random):
    """Random rotations, as matrices for the five components of deviators."""
    w, x, y, z = (q := random.normal(size=(4, count))) / np.linalg.norm(q, axis=0)
    r = np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
        [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
        [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
    ])
    return of_axes(np.moveaxis(r, -1, 0))


def of_axes(r):
    basis = np.zeros((5, 3, 3))
    basis[0], basis[1] = np.diag([2, -1, -1]) / 6**0.5, np.diag([0, 1, -1]) / 2**0.5
    for k, (i, j) in enumerate([(1, 2), (2, 0), (0, 1)]):
        basis[2 + k, i, j] = basis[2 + k, j, i] = 0.5**0.5
    return np.einsum("kij,nia,lab,njb->nkl", basis, r, basis, r, optimize=True)


def permutations():
    """The 24 rotations that permute and mirror the axes."""
    found = []
    for order in [(0, 1, 2), (1, 2, 0), (2, 0, 1), (1, 0, 2), (0, 2, 1), (2, 1, 0)]:
        for signs in np.ndindex(2, 2, 2):
            r = np.zeros((3, 3))
            r[range(3), order] = 1 - 2 * np.array(signs)
            if np.linalg.det(r) > 0:
                found.append(r)
    return of_axes(np.stack(found))


def networks(training, unseen, means, options):
    import torch

    torch.set_num_threads(options.threads)
    torch.manual_seed(options.seed)
    random = np.random.default_rng(options.seed)
    held_out, learned = training[::8], [run for k, run in enumerate(training) if k % 8]
    form = Form(learned)

    class Network(torch.nn.Module):
        def __init__(self, starts, labels):
            super().__init__()
            self.is_lstm = options.what == "lstm"
            self.memory = torch.nn.Linear(starts, options.units)
            if self.is_lstm:
                self.cell = torch.nn.Linear(starts, options.units)
            self.layer = (torch.nn.LSTM if self.is_lstm else torch.nn.GRU)(6, options.units, batch_first=True)
            self.read_out = torch.nn.Linear(options.units, labels)

        def forward(self, increments, starts):
            first = torch.tanh(self.memory(starts)).unsqueeze(0)
            if self.is_lstm:
                first = (first, self.cell(starts).unsqueeze(0))
            return self.read_out(self.layer(increments, first)[0])

    def batch(runs):
        """Padded at the end, which what comes before does not see."""
        rows = max(len(run.strain) for run in runs)
        found = [form.tensors(run) for run in runs]
        pad = [np.stack([np.concatenate([own[k], np.zeros((rows - len(own[k]), own[k].shape[1]))]) for own in found]) for k in (0, 2)]
        is_row = np.stack([np.arange(rows) < len(run.strain) for run in runs])
        return [torch.tensor(part, dtype=torch.float32) for part in (pad[0], np.stack([own[1] for own in found]), pad[1], is_row)]

    def turned(increments, starts, labels, turns):
        turns = torch.tensor(turns, dtype=torch.float32)
        turn = lambda part: torch.einsum("n...l,nkl->n...k", part, turns)
        tensors = lambda part: torch.cat([turn(part[..., :5]), turn(part[..., 5:10]), part[..., 10:]], -1)
        return torch.cat([turn(increments[..., :5]), increments[..., 5:]], -1), tensors(starts), tensors(labels)

    def error(values, labels, is_row):
        return (((values - labels) ** 2).mean(-1) * is_row).sum() / is_row.sum()

    def predicted(runs, turns=None):
        x, start, labels, _ = batch(runs)
        with torch.no_grad():
            if turns is None:
                found = model(x, start)
            else:
                found = 0
                for turn in turns:
                    own = np.repeat(turn[None], len(runs), 0)
                    there, at, like = turned(x, start, labels, own)
                    found = found + turned(there, at, model(there, at), own.transpose(0, 2, 1))[2] / len(turns)
        return [form.back(values[: len(run.strain)].numpy().astype(float)) for run, values in zip(runs, found)]

    model = Network(13 + 2, 12)
    weights = sum(own.numel() for own in model.parameters())
    print(f"PyTorch {torch.__version__}, {options.what} with {options.units} units and {weights} weights; {len(learned)} runs learned, {len(held_out)} held out", flush=True)
    optimiser = torch.optim.Adam(model.parameters(), lr=options.rate)
    schedule = torch.optim.lr_scheduler.CosineAnnealingLR(optimiser, options.epochs * -(-len(learned) // options.batch))
    all_learned, judge_on = batch(learned), batch(held_out)
    longest = np.array([len(run.strain) for run in learned])
    best, begin, cpu = (np.inf, 0, None), time.perf_counter(), time.process_time()
    for epoch in range(options.epochs):
        sum_of_errors = 0.0
        # Runs of about the same length are in one batch, so that little is padded.
        by_length = np.argsort(longest + random.normal(scale=10, size=len(learned)))
        batches = np.array_split(by_length, -(-len(learned) // options.batch))
        for chosen in (batches[k] for k in random.permutation(len(batches))):
            x, start, labels, is_row = (part[chosen] for part in all_learned)
            rows = longest[chosen].max()
            x, start, labels = turned(x[:, :rows], start, labels[:, :rows], rotations(len(chosen), random))
            optimiser.zero_grad(set_to_none=True)
            loss = error(model(x, start), labels, is_row[:, :rows])
            loss.backward()
            torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
            optimiser.step()
            schedule.step()
            sum_of_errors += loss.item() * len(chosen)
        with torch.no_grad():
            found = error(model(*judge_on[:2]), judge_on[2], judge_on[3]).item()
        if found < best[0]:
            best = (found, epoch + 1, {key: value.clone() for key, value in model.state_dict().items()})
        if epoch % 10 == 9 or epoch == 0:
            print(f"epoch {epoch + 1}: error of training {sum_of_errors / len(learned):.4f}, held out {found:.4f}; {time.perf_counter() - begin:.0f} s", flush=True)
    model.load_state_dict(best[2])
    print(f"trained in {time.perf_counter() - begin:.0f} s ({time.process_time() - cpu:.0f} s of processor time); epoch {best[1]} of {options.epochs} kept")
    judge("held-out runs", held_out, predicted(held_out), means)
    if not options.no_unseen:
        judge(f"{options.what}, {weights} weights", unseen, predicted(unseen), means)
        judge(f"{options.what}, mean over 24 rotations of the axes", unseen, predicted(unseen, permutations()), means)


def hypoplastic(training, unseen, means, options):
    import hypoplasticity as law

    def chosen(runs):
        """Runs in equal distances along those of training, which a Sobol sequence has mixed."""
        return [runs[k * len(runs) // options.runs] for k in range(min(options.runs, len(runs)))]

    def said(x):
        return ", ".join(f"{name} {value:.4g}" for name, value in zip(law.NAMES, law.named(x) * [1, 1e-6, 1, 1, 1, 1, 1, 1]))

    def rows(x, runs, fine=law.FINE):
        return [judged(stress) for stress in law.predicted(runs, x, fine)]

    begin, cpu = time.perf_counter(), time.process_time()
    one = law.calibrated(chosen(training), judged, means, options)
    print(f"all sands: {said(one)}", flush=True)
    print(f"calibrated in {time.perf_counter() - begin:.0f} s ({time.process_time() - cpu:.0f} s of processor time)", flush=True)
    judge("hypoplastic law, training runs of the calibration", chosen(training), rows(one, chosen(training)), means)
    judge("hypoplastic law, once for all sands", unseen, rows(one, unseen), means)
    judge("the same with twice as many parts of an increment", unseen, rows(one, unseen, 2 * law.FINE), means)
    ends = np.median([run.frictions for run in training], axis=0)
    group = lambda run: tuple(run.frictions > ends)
    found = {}
    for key in sorted({group(run) for run in training}):
        print("group with", *(f"{name} {'above' if is_above else 'up to'} {end:.3g}," for name, is_above, end in zip(["friction", "rolling friction"], key, ends)))
        found[key] = law.calibrated(chosen([run for run in training if group(run) == key]), judged, means, options, one)
        print(f"  {said(found[key])}", flush=True)
    print(f"all calibrated in {time.perf_counter() - begin:.0f} s ({time.process_time() - cpu:.0f} s of processor time)")
    own = {key: iter(rows(x, [run for run in unseen if group(run) == key])) for key, x in found.items()}
    judge("hypoplastic law, by four groups of frictions", unseen, [next(own[group(run)]) for run in unseen], means)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("training")
    parser.add_argument("unseen")
    parser.add_argument("what", choices=["check", "lstm", "gru", "hypoplastic"])
    parser.add_argument("--units", type=int, help="units of a network (62 for lstm, 74 for gru: as many weights as granum's surrogate)")
    parser.add_argument("--epochs", type=int, default=80)
    parser.add_argument("--batch", type=int, default=32, help="runs in a batch")
    parser.add_argument("--rate", type=float, default=5e-3, help="first rate of learning")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--no-unseen", action="store_true", help="judge networks on held-out runs only, to choose settings")
    parser.add_argument("--runs", type=int, default=96, help="training runs of a calibration")
    parser.add_argument("--starts", type=int, default=3, help="first populations of the search over the whole range")
    parser.add_argument("--population", type=int, default=5, help="points of a population, over the number of parameters")
    parser.add_argument("--generations", type=int, default=30)
    options = parser.parse_args()
    options.units = options.units or {"lstm": 62}.get(options.what, 74)
    training, unseen = read(options.training), read(options.unseen)
    means = [None, np.concatenate([run.judged[1] for run in training]).mean()]
    if options.what == "check":
        check(unseen, means)
    elif options.what == "hypoplastic":
        hypoplastic(training, unseen, means, options)
    else:
        networks(training, unseen, means, options)


if __name__ == "__main__":
    main()
