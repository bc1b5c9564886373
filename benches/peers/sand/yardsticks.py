#!/usr/bin/env python3
"""Two yardsticks for calibrations on drained triaxial tests of a laboratory: the mean of the known tests at a density, and hypoplasticity.

    python3 benches/peers/sand/yardsticks.py data/lab/karlsruhe-fine-sand-drained.csv --train TMD2 TMD4 TMD22 TMD24
    python3 benches/peers/sand/yardsticks.py data/lab/karlsruhe-fine-sand-drained.csv --leave-one-out

The first yardstick knows nothing of mechanics: q over the mean stress at the start and the volumetric strain of the known tests, as means over
groups of equal density, interpolated linearly in the void ratio between the groups and constant beyond.

The second is the hypoplastic model of von Wolffersdorff (1996), A hypoplastic relation for granular materials with a predefined limit state
surface, Mechanics of Cohesive-Frictional Materials 1, 251-271, with the pressure dependence of limiting void ratios of Bauer (1996), Soils and
Foundations 36(1), 13-26, integrated along drained triaxial compression at constant lateral stress. In triaxial compression, with compression
positive here, principal stresses s1 (axial) and s3, rates of strain d1 and d3:

    ds = fb fe / tr(s^2) (F^2 d + a^2 s tr(s d) - fd a F (s + s*) |d|),    s = stress / trace, s* its deviator, F = 1,
    a  = sqrt(3) (3 - sin phi_c) / (2 sqrt(2) sin phi_c),
    fd = ((e - ed) / (ec - ed))^alpha,  fe = (ec / e)^beta,
    fb = hs / n ((1 + ei) / ei) (ei0 / ec0)^beta (3 p / hs)^(1 - n) / (3 + a^2 - sqrt(3) a ((ei0 - ed0) / (ec0 - ed0))^alpha),
    ei / ei0 = ec / ec0 = ed / ed0 = exp(-(3 p / hs)^n).

It is taken twice: with the parameters of Karlsruhe fine sand
of Wichtmann and Triantafyllidis (2016), Acta Geotechnica 11, 739-761; and with phi_c, hs, n, alpha and beta fitted to the known tests
(Nelder and Mead, the squares of the relative errors below).

Errors are root mean squares over 8 axial strains from 0.5 to 14.5 %, over the largest reading of the test: those of `granum calibrate`
with the file of data/validation/karlsruhe-sand.
Needs numpy and scipy.
"""

import argparse
import csv
import json
import math
from collections import OrderedDict

import numpy
from scipy.optimize import minimize

STRAINS = numpy.linspace(0.005, 0.145, 8)
PUBLISHED = dict(phi_c=33.1, hs=4e9, n=0.27, alpha=0.14, beta=2.5, ed0=0.677, ec0=1.054, ei0=1.212)
FITTED = ["phi_c", "hs", "n", "alpha", "beta"]
# Densities further apart than this are groups of their own.
GAP = 0.04


class Test:
    """A drained test: void ratio and stresses at the start, readings at STRAINS."""

    def __init__(self, name, rows):
        strain, volume, lateral, axial, void = (numpy.array(column) for column in zip(*rows))
        self.name, self.void_ratio = name, void[0]
        self.axial_stress, self.lateral_stress = axial[0] * 1e3, lateral[0] * 1e3
        self.mean_stress = (self.axial_stress + 2 * self.lateral_stress) / 3
        self.q = numpy.interp(STRAINS, strain / 100, (axial - lateral) * 1e3)
        self.volume = numpy.interp(STRAINS, strain / 100, volume / 100)


def read(path):
    tests = OrderedDict()
    with open(path) as file:
        for row in csv.DictReader(line for line in file if not line.startswith("#")):
            columns = ["axial_strain_percent", "volumetric_strain_percent", "lateral_stress_kPa", "axial_stress_kPa", "initial_void_ratio"]
            tests.setdefault(row["test"], []).append([float(row[column]) for column in columns])
    return [Test(name, rows) for name, rows in tests.items()]


def errors(test, q, volume):
    """Root mean squares over the largest reading, of q and of the volumetric strain."""

    def error(predicted, measured):
        return float(numpy.sqrt(numpy.mean((predicted - measured) ** 2)) / numpy.max(numpy.abs(measured)))

    return error(q, test.q), error(volume, test.volume)


def groups(tests):
    found = []
    for test in sorted(tests, key=lambda test: test.void_ratio):
        if found and test.void_ratio - found[-1][-1].void_ratio < GAP:
            found[-1].append(test)
        else:
            found.append([test])
    return found


def mean_of_known(known, test):
    """q and volumetric strain of a test: means of the known tests at densities around it."""
    own = groups(known)
    void = [numpy.mean([one.void_ratio for one in group]) for group in own]
    ratio = numpy.array([numpy.mean([one.q / one.mean_stress for one in group], axis=0) for group in own])
    volume = numpy.array([numpy.mean([one.volume for one in group], axis=0) for group in own])
    at = [numpy.array([numpy.interp(test.void_ratio, void, curves[:, k]) for k in range(len(STRAINS))]) for curves in (ratio, volume)]
    return at[0] * test.mean_stress, at[1]


def rates(s1, s3, e, d1, parameters):
    """Rates of s1 and of strain d3 at constant lateral stress; None beyond the limits of the model."""
    phi, hs, n, alpha, beta, ed0, ec0, ei0 = (parameters[key] for key in ["phi_c", "hs", "n", "alpha", "beta", "ed0", "ec0", "ei0"])
    trace = s1 + 2 * s3
    shrink = math.exp(-((trace / hs) ** n))
    ed, ec, ei = ed0 * shrink, ec0 * shrink, ei0 * shrink
    sine = math.sin(math.radians(phi))
    a = math.sqrt(3) * (3 - sine) / (2 * math.sqrt(2) * sine)
    fd = max((e - ed) / (ec - ed), 0.0) ** alpha
    fe = (ec / e) ** beta
    bracket = 3 + a * a - math.sqrt(3) * a * ((ei0 - ed0) / (ec0 - ed0)) ** alpha
    fb = hs / n * (1 + ei) / ei * (ei0 / ec0) ** beta * (trace / hs) ** (1 - n) / bracket
    t1, t3 = s1 / trace, s3 / trace
    c = fb * fe / (t1 * t1 + 2 * t3 * t3)
    u1, u3 = 2 * t1 - 1 / 3, 2 * t3 - 1 / 3  # s + s*
    # Constant s3: (1 + 2 a^2 t3^2) d3 + a^2 t3 t1 d1 - fd a u3 |d| = 0, with |d|^2 = d1^2 + 2 d3^2.
    b, g, k = 1 + 2 * a * a * t3 * t3, a * a * t3 * t1 * d1, fd * a * u3
    # Squared: (b^2 - 2 k^2) d3^2 + 2 b g d3 + g^2 - k^2 d1^2 = 0; of its roots that which fulfils the equation before squaring.
    A, B, C = b * b - 2 * k * k, 2 * b * g, g * g - k * k * d1 * d1
    root = B * B - 4 * A * C
    if root < 0 or A == 0 or bracket <= 0:
        return None
    for sign in (1, -1):
        d3 = (-B + sign * math.sqrt(root)) / (2 * A)
        size = math.sqrt(d1 * d1 + 2 * d3 * d3)
        if abs(b * d3 + g - k * size) < 1e-9 * (abs(g) + abs(k) * size + 1e-30):
            return c * (d1 + a * a * t1 * (t1 * d1 + 2 * t3 * d3) - fd * a * u1 * size), d3
    return None


def hypoplastic(test, parameters, steps=400):
    """q and volumetric strain at STRAINS, by the midpoint rule in equal steps of logarithmic axial strain."""
    last = -math.log(1 - STRAINS[-1])
    s1, s3, e = max(test.axial_stress, test.lateral_stress), test.lateral_stress, test.void_ratio
    strain, q, volume = [0.0], [s1 - s3], [0.0]
    for k in range(steps):
        # Smaller steps at the start, where the stiffness falls fast.
        step = last * (((k + 1) / steps) ** 2 - (k / steps) ** 2)
        first = rates(s1, s3, e, 1.0, parameters)
        if first is None:
            return None
        half = rates(s1 + step / 2 * first[0], s3, e - step / 2 * (1 + e) * (1 + 2 * first[1]), 1.0, parameters)
        if half is None:
            return None
        s1 += step * half[0]
        e -= step * (1 + e) * (1 + 2 * half[1])
        strain.append(1 - math.exp(-last * ((k + 1) / steps) ** 2))
        q.append(s1 - s3)
        volume.append((test.void_ratio - e) / (1 + test.void_ratio))
    return numpy.interp(STRAINS, strain, q), numpy.interp(STRAINS, strain, volume)


def fitted(known):
    """The parameters of hypoplasticity that fit the known tests best."""

    def parameters(x):
        values = dict(PUBLISHED)
        for key, value in zip(FITTED, x):
            values[key] = PUBLISHED[key] * math.exp(value)
        return values

    def cost(x):
        values, sum_of_squares = parameters(x), 0.0
        for test in known:
            found = hypoplastic(test, values, steps=120)
            if found is None or not numpy.all(numpy.isfinite(found)):
                return 1e3
            sum_of_squares += sum(error**2 for error in errors(test, *found))
        return sum_of_squares

    best = minimize(cost, numpy.zeros(len(FITTED)), method="Nelder-Mead", options=dict(maxiter=400, xatol=1e-3, fatol=1e-6))
    return parameters(best.x)


def scatter(tests):
    """How far a test lies from what its group says of its density and pressure: the root mean square of residuals of a plane in void ratio and
    logarithm of pressure through the curves of each group, with the freedom of the plane taken into account, over the largest reading."""
    found = {"q": [], "volume": []}
    for group in groups(tests):
        if len(group) < 4:
            continue
        plane = numpy.array([[1, one.void_ratio, math.log(one.mean_stress)] for one in group])
        for name, curves in [("q", [one.q / one.mean_stress for one in group]), ("volume", [one.volume for one in group])]:
            curves = numpy.array(curves)
            rest = curves - plane @ numpy.linalg.lstsq(plane, curves, rcond=None)[0]
            size = numpy.mean(numpy.max(numpy.abs(curves), axis=1))
            found[name].append(numpy.sum(rest**2) / len(STRAINS) / (len(group) - 3) / size**2)
    return {name: float(numpy.sqrt(numpy.mean(values))) for name, values in found.items()}


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("laboratory")
    options.add_argument("--train", nargs="+", default=[])
    options.add_argument("--leave-one-out", action="store_true")
    options.add_argument("--json")
    given = options.parse_args()
    tests = read(given.laboratory)
    unknown = set(given.train) - {test.name for test in tests}
    if unknown or not (given.train or given.leave_one_out):
        options.error(f"--train takes names of tests of {given.laboratory}: {', '.join(test.name for test in tests)}" + (f"; not {', '.join(sorted(unknown))}" if unknown else ""))
    rows = []

    def predict(known, others):
        own = fitted(known)
        for test in others:
            published = hypoplastic(test, PUBLISHED)
            rows.append(
                dict(
                    test=test.name,
                    mean_of_known=errors(test, *mean_of_known(known, test)),
                    hypoplastic_published=errors(test, *published),
                    hypoplastic_fitted=errors(test, *hypoplastic(test, own)),
                )
            )
            row = rows[-1]
            print(test.name, *(f"{name} {100 * row[name][0]:.1f} % {100 * row[name][1]:.1f} %" for name in list(row)[1:]), sep="; ")
        return own

    print("errors of q and of volumetric strain, over the largest reading of the test")
    if given.leave_one_out:
        for test in tests:
            predict([other for other in tests if other is not test], [test])
    else:
        known = [test for test in tests if test.name in given.train]
        print("fitted:", {key: float(f"{value:.4g}") for key, value in predict(known, [test for test in tests if test not in known]).items()})
    for name in ["mean_of_known", "hypoplastic_published", "hypoplastic_fitted"]:
        q, volume = (100 * numpy.mean([row[name][k] for row in rows]) for k in (0, 1))
        print(f"mean of {len(rows)} tests, {name}: q {q:.1f} %, volumetric strain {volume:.1f} %")
    around = scatter(tests)
    print(f"scatter of tests about a plane in void ratio and log pressure of their group: q {100 * around['q']:.1f} %, volumetric strain {100 * around['volume']:.1f} %")
    if given.json:
        with open(given.json, "w") as file:
            json.dump(dict(rows=rows, scatter=around), file, indent=1)


if __name__ == "__main__":
    main()
