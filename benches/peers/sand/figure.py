#!/usr/bin/env python3
"""Draws predicted drained tests over their readings, from `predictions.csv` of a calibration.

    python3 benches/peers/sand/figure.py calibrated/predictions.csv figure.svg --calibrated TMD2 TMD4 TMD22 TMD24 --tests TMD2 TMD3 TMD12 TMD14 TMD22 TMD25

Marks are readings of the laboratory, lines predictions, and areas their intervals of 90 %. Needs matplotlib.
"""

import argparse
import csv
from collections import OrderedDict

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt

matplotlib.rcParams["svg.hashsalt"] = "granum"
PANELS = [("deviator_stress", 1e-3, "deviator stress q (kPa)"), ("volumetric_strain", 100, "volumetric strain (%)")]


def main():
    options = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    options.add_argument("predictions")
    options.add_argument("figure")
    options.add_argument("--tests", nargs="+", required=True)
    options.add_argument("--calibrated", nargs="*", default=[])
    given = options.parse_args()
    curves = OrderedDict()
    with open(given.predictions) as file:
        for row in csv.DictReader(file):
            values = [float(row[key]) for key in ["axial_strain", "measured", "predicted", "low", "high"]]
            curves.setdefault((row["test"], row["quantity"]), []).append(values)
    figure, axes = plt.subplots(2, len(given.tests), figsize=(2.4 * len(given.tests), 5), sharex=True)
    for column, test in enumerate(given.tests):
        for row, (quantity, scale, label) in enumerate(PANELS):
            strain, measured, predicted, low, high = ([scale * y for y in column_] for column_ in zip(*curves[test, quantity]))
            strain = [100 * x / scale for x in strain]
            axis = axes[row][column]
            axis.fill_between(strain, low, high, color="#4477aa", alpha=0.25, linewidth=0)
            axis.plot(strain, predicted, color="#4477aa")
            axis.plot(strain, measured, "o", color="black", markersize=3, fillstyle="none")
            if column == 0:
                axis.set_ylabel(label)
            if row == 0:
                axis.set_title(f"{test}\n{'calibrated on' if test in given.calibrated else 'predicted'}", fontsize=9)
            else:
                axis.set_xlabel("axial strain (%)")
    figure.tight_layout()
    figure.savefig(given.figure, metadata={"Date": None} if given.figure.endswith("svg") else None)


if __name__ == "__main__":
    main()
