"""The hypoplastic law of von Wolffersdorff along any path of strain, for many runs and many sets of parameters at once.

P.-A. von Wolffersdorff (1996), A hypoplastic relation for granular materials with a predefined limit state surface, Mechanics of Cohesive-Frictional
Materials 1, 251-271, with the pressure dependence of the limiting void ratios of Bauer (1996), Soils and Foundations 36(1), 13-26. Compression is
positive. With the stress s over its trace, t = s / tr s, its deviator t*, and the rate of strain d:

    ds  = fb fe / (t : t) (F^2 d + a^2 t (t : d) - fd a F (t + t*) |d|)
    F   = sqrt(tan^2 psi / 8 + (2 - tan^2 psi) / (2 + sqrt(2) tan psi cos 3 theta)) - tan psi / (2 sqrt(2)),   tan psi = sqrt(3) |t*|,
    cos 3 theta = -sqrt(6) tr(t*^3) / |t*|^3,
    a   = sqrt(3) (3 - sin phi_c) / (2 sqrt(2) sin phi_c),
    fd  = ((e - ed) / (ec - ed))^alpha,  fe = (ec / e)^beta,
    fb  = hs / n ((1 + ei) / ei) (ei0 / ec0)^beta (3 p / hs)^(1 - n) / (3 + a^2 - sqrt(3) a ((ei0 - ed0) / (ec0 - ed0))^alpha),
    ei / ei0 = ec / ec0 = ed / ed0 = exp(-(3 p / hs)^n).

The void ratio e follows from that of the sample and the logarithmic volumetric strain. Each increment of strain is divided into equal parts, each of which is
taken by the midpoint rule. Where the law leaves its range it is held at the edge of it:

- The mean stress is not let below LEAST_PRESSURE, a tenth of the least whose logarithm is judged: at no stress the law has no stiffness, and a sample that has once lost
  its stress would never bear any again. The norm of the deviator is held below the largest that grains without
  cohesion can bear.
- A void ratio below ed counts as ed.

Needs numpy and scipy.
"""

import time

import numpy as np
from scipy.optimize import differential_evolution

LEAST_PRESSURE = 100.0
# A deviator over mean stress of this norm has two principal stresses of zero; a little less keeps the law away from its edge.
LARGEST_RATIO = 0.98 * 6**0.5
NAMES = ["phi_c, degrees", "hs, MPa", "n", "ed0", "ec0", "ei0", "alpha", "beta"]
# What a search varies, and between which ends: phi_c, log10 of hs over 1 Pa, n, ed0, ec0 / ed0, ei0 / ec0, alpha, beta.
BOUNDS = [(15, 50), (6, 12), (0.1, 0.9), (0.3, 0.7), (1.1, 2.5), (1.01, 1.4), (0.01, 1.0), (0.5, 8)]
# The deviation of the population of the last search, over the range.
AROUND = 0.08
# Equal parts of an increment, for the search and for the judgement.
COARSE, FINE = 4, 16


def named(x):
    """The parameters of points of the search, one point or one a row."""
    phi, hs, n, ed0, ec, ei, alpha, beta = np.asarray(x, float).T
    return np.stack([phi, 10**hs, n, ed0, ed0 * ec, ed0 * ec * ei, alpha, beta])


def rate(s, d, e, own):
    """The stress that an increment of strain adds; tensors are six rows xx, yy, zz, yz, zx, xy."""
    a, hs, n, ed0, ec0, ei0, alpha, beta, bracket = own
    trace = s[0] + s[1] + s[2]
    power = (trace / hs) ** n
    shrink = np.exp(-power)
    ed, ec, ei = ed0 * shrink, ec0 * shrink, ei0 * shrink
    fd = (np.maximum(e - ed, 1e-9) / (ec - ed)) ** alpha
    stiffness = hs / n * (1 + 1 / ei) * (ei0 / ec0 * ec / e) ** beta * (trace / hs) / power / bracket
    t = s / trace
    dev = t.copy()
    dev[:3] -= 1 / 3
    xx, yy, zz, yz, zx, xy = dev
    square = xx * xx + yy * yy + zz * zz + 2 * (yz * yz + zx * zx + xy * xy)
    # The trace of the cube of a deviator is three times its determinant.
    cube = 3 * (xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * zx) + zx * (xy * yz - yy * zx))
    norm = np.sqrt(square) + 1e-12
    lode = np.clip(-(6**0.5) * cube / norm**3, -1, 1)
    psi = 3**0.5 * norm
    f = np.sqrt(np.maximum(psi * psi / 8 + (2 - psi * psi) / (2 + 2**0.5 * psi * lode), 0)) - psi / 8**0.5
    f = np.maximum(f, 0)
    along = t[0] * d[0] + t[1] * d[1] + t[2] * d[2] + 2 * (t[3] * d[3] + t[4] * d[4] + t[5] * d[5])
    size = np.sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] + 2 * (d[3] * d[3] + d[4] * d[4] + d[5] * d[5]))
    by = stiffness / (square + 1 / 3)
    return by * (f * f * d + a * a * along * t - fd * a * f * size * (t + dev))


def bounded(s):
    """A stress whose mean is not below the least one, and whose deviator is not larger than grains without cohesion bear."""
    p = np.maximum((s[0] + s[1] + s[2]) / 3, LEAST_PRESSURE)
    dev = s.copy()
    dev[:3] -= (s[0] + s[1] + s[2]) / 3
    norm = np.sqrt(dev[0] ** 2 + dev[1] ** 2 + dev[2] ** 2 + 2 * (dev[3] ** 2 + dev[4] ** 2 + dev[5] ** 2)) + 1e-300
    dev *= np.minimum(1, LARGEST_RATIO * p / norm)
    dev[:3] += p
    return dev


def stresses(runs, parameters, parts):
    """The stress tensors at all rows of runs (rows, 6, sets, runs) for sets of parameters (8, sets). Shorter runs repeat their last strain."""
    rows = max(len(run.strain) for run in runs)
    strain = np.stack([np.concatenate([run.strain, np.repeat(run.strain[-1:], rows - len(run.strain), 0)]) for run in runs], -1)
    phi, *others = parameters[:, :, None]
    sine = np.sin(np.radians(phi))
    a = 3**0.5 * (3 - sine) / (8**0.5 * sine)
    hs, n, ed0, ec0, ei0, alpha, beta = others
    bracket = 3 + a * a - 3**0.5 * a * ((ei0 - ed0) / (ec0 - ed0)) ** alpha
    # Where it is not positive, the law has no positive stiffness along isotropic compression.
    own = (a, hs, n, ed0, ec0, ei0, alpha, beta, np.where(bracket > 0, bracket, np.nan))
    shape = (6, parameters.shape[1], len(runs))
    s = bounded(np.broadcast_to(np.stack([run.sample_stress for run in runs], -1)[:, None], shape).copy())
    e0 = np.array([run.void_ratio for run in runs])
    found = np.empty((rows, *shape))
    last = np.zeros((6, len(runs)))
    with np.errstate(all="ignore"):
        for row in range(rows):
            d = ((strain[row] - last) / parts)[:, None]
            volume, more = last[:3].sum(0), d[:3].sum(0)
            for part in range(parts if row and np.any(d) else 0):
                e = (1 + e0) * np.exp(-(volume + part * more)) - 1
                half = bounded(s + 0.5 * rate(s, d, e, own))
                e = (1 + e0) * np.exp(-(volume + (part + 0.5) * more)) - 1
                s = bounded(s + rate(half, d, e, own))
            found[row] = s
            last = strain[row]
    return found


def padded(values, rows):
    return np.stack([np.concatenate([own, np.zeros((rows - len(own), *own.shape[1:]))]) for own in values], -1)


class Cost:
    """The sum of the squared relative errors of both quantities over runs, for points of the search, one a column."""

    def __init__(self, runs, judged, means):
        self.runs, self.judged = runs, judged
        rows = max(len(run.strain) for run in runs)
        self.is_row = padded([np.ones(len(run.strain)) for run in runs], rows)
        self.ratio, self.pressure = (padded([run.judged[k] for run in runs], rows) for k in (0, 1))
        self.squares = [(self.ratio**2).sum(), (((self.pressure - means[1]) * self.is_row) ** 2).sum()]

    def __call__(self, points):
        ratio, pressure = self.judged(stresses(self.runs, named(points.T), COARSE))
        of_ratio = np.einsum("rcsk,rk->s", (ratio - self.ratio[:, :, None]) ** 2, self.is_row)
        of_pressure = np.einsum("rsk,rk->s", (pressure - self.pressure[:, None]) ** 2, self.is_row)
        found = of_ratio / self.squares[0] + of_pressure / self.squares[1]
        return np.where(np.isfinite(found), found, 1e3)


def calibrated(runs, judged, means, options, first=None):
    """The point of the search with the least cost: differential evolution from several first populations that fill the whole range, then once more from a population around the
    best point so far. With a first point the search is the last one alone, around that point."""
    cost, begin, evaluated = Cost(runs, judged, means), time.perf_counter(), 0
    low, high = np.array(BOUNDS).T

    def searched(name, seed, population):
        nonlocal evaluated
        settings = dict(vectorized=True, updating="deferred", popsize=options.population, maxiter=options.generations, polish=False)
        found = differential_evolution(cost, BOUNDS, rng=seed, init=population, **settings)
        # Scipy counts a whole population as one.
        evaluated += found.nfev * options.population * len(BOUNDS)
        print(f"  {name}: sum of squared errors {found.fun:.4f} after {evaluated} sets of parameters, {time.perf_counter() - begin:.0f} s", flush=True)
        return found

    if first is None:
        first = min((searched(f"start {seed}", seed, "latinhypercube") for seed in range(1, options.starts + 1)), key=lambda own: own.fun).x
    around = first + AROUND * (high - low) * np.random.default_rng(1).normal(size=(options.population * len(BOUNDS), len(BOUNDS)))
    around[0] = first
    return searched("around the best", 1, np.clip(around, low, high)).x


def predicted(runs, x, parts=FINE):
    """The stress tensors of each run (rows, 6) with one set of parameters."""
    found = stresses(runs, named(x)[:, None], parts)
    return [found[: len(run.strain), :, 0, k] for k, run in enumerate(runs)]
