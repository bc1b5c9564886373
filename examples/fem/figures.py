"""The figures of the book from the files of footing.py and biaxial.py; needs matplotlib.

    python figures.py curves FIGURE.svg LABEL=FOLDER ...       load against settlement
    python figures.py strain FIGURE.svg FOLDER [NAME ...]      shear strain of a footing or of a biaxial test; points of these names are marked
    python figures.py chains FIGURE.svg CONTACTS.csv    force chains of points, as point_contacts of crates/granum-c/examples writes their contacts
    python figures.py biaxial FIGURE.svg FOLDER                curve and shear strain of a biaxial test
"""
import csv
import os
import sys

import matplotlib

matplotlib.use("svg")
from matplotlib import pyplot  # noqa: E402
from matplotlib.patches import Polygon  # noqa: E402

pyplot.rcParams.update({"font.size": 9, "font.family": "sans-serif", "svg.hashsalt": "granum", "svg.fonttype": "none", "axes.spines.top": False, "axes.spines.right": False})
COLOURS = ["#1f5a7a", "#c2571a", "#5b8c3e", "#8a8375", "#4a4a4a", "#9a4f96"]


def rows_of(folder, name):
    with open(os.path.join(folder, name), newline="") as file:
        return [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]


def curves(axes, named):
    for (label, folder), colour in zip(named, COLOURS):
        rows = rows_of(folder, "curve.csv")
        # The cells have solid lines.
        is_law = not os.path.exists(os.path.join(folder, "states.granum"))
        axes.plot([1e3 * row["settlement"] for row in rows], [1e-3 * row["pressure"] for row in rows], "--" if is_law else "-",
                  color=colour, label=label, linewidth=1.3 if is_law else 1.8)
    axes.set_xlabel("Settlement, mm")
    axes.set_ylabel("Mean pressure below the footing, kPa")
    axes.set_xlim(left=0)
    axes.set_ylim(bottom=0)
    axes.legend(frameon=False)


def shear_strain(row):
    return ((row["exx"] - row["eyy"]) ** 2 + row["gxy"] ** 2) ** 0.5


def field(figure, axes, rows, label):
    """A quarter of an element around each of its four points, coloured by the shear strain."""
    elements = {}
    for row in rows:
        elements.setdefault(row["element"], []).append(row)
    values = sorted(map(shear_strain, rows))
    # The largest hundredth has the last colour.
    most = values[int(0.99 * (len(values) - 1))]
    colours = pyplot.get_cmap("magma_r")
    for points in elements.values():
        xs, ys = [p["x"] for p in points], [p["y"] for p in points]
        # Gauss points are at 1 / sqrt(3) of half an edge from the middle.
        middle = [0.5 * (min(xs) + max(xs)), 0.5 * (min(ys) + max(ys))]
        half = [0.5 * 3**0.5 * (max(xs) - min(xs)), 0.5 * 3**0.5 * (max(ys) - min(ys))]
        for p in points:
            x = sorted([middle[0], middle[0] + half[0] * (1 if p["x"] > middle[0] else -1)])
            y = sorted([middle[1], middle[1] + half[1] * (1 if p["y"] > middle[1] else -1)])
            corners = [(x[0], y[0]), (x[1], y[0]), (x[1], y[1]), (x[0], y[1])]
            colour = colours(min(1.0, shear_strain(p) / most))
            axes.add_patch(Polygon(corners, facecolor=colour, edgecolor=colour, linewidth=0.3))
        corners = [(middle[0] + a * half[0], middle[1] + b * half[1]) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
        axes.add_patch(Polygon(corners, facecolor="none", edgecolor="#b9b2a4", linewidth=0.4))
    axes.autoscale()
    axes.set_aspect("equal")
    for side in axes.spines.values():
        side.set_visible(False)
    axes.set_xlabel("x, m")
    axes.set_ylabel("y, m")
    scale = pyplot.cm.ScalarMappable(pyplot.Normalize(0, 100 * most), colours)
    figure.colorbar(scale, ax=axes, label=label, shrink=0.7, extend="max")


def chains(axes, contacts):
    """The contacts of a cell in a slice through its middle, 2.5 diameters thick: lines from centre to centre, as wide as the normal force."""
    wide, high, deep = (contacts[0]["width_" + axis] for axis in "xyz")
    mean = sum(c["normal_force"] for c in contacts) / len(contacts)
    thickness = 2.5 * sum(c["diameter"] for c in contacts) / len(contacts)
    diameter = thickness / 2.5
    frame = pyplot.Rectangle((0, 0), wide / diameter, high / diameter, facecolor="none", edgecolor="#8a8375", linewidth=0.8)
    axes.add_patch(frame)
    for contact in sorted(contacts, key=lambda c: c["normal_force"]):
        share = contact["normal_force"] / mean
        if abs(contact["z"] + 0.5 * contact["branch_z"] - 0.5 * deep) > 0.5 * thickness or share <= 0:
            continue
        # A contact across the boundary is drawn at its images and cut off at the frame.
        for i in (-1, 0, 1):
            for j in (-1, 0, 1):
                x, y = contact["x"] + i * wide, contact["y"] + j * high
                ends = (x, x + contact["branch_x"]), (y, y + contact["branch_y"])
                if any(max(end) < 0 or min(end) > width for end, width in zip(ends, (wide, high))):
                    continue
                (line,) = axes.plot(*([place / diameter for place in end] for end in ends),
                                    color=pyplot.get_cmap("YlOrRd")(min(1.0, 0.25 + 0.2 * share)), linewidth=min(7.0, 1.5 * share), solid_capstyle="round")
                line.set_clip_path(frame)
    axes.set_xlim(-0.1, wide / diameter + 0.1)
    axes.set_ylim(-0.1, high / diameter + 0.1)
    axes.set_aspect("equal")
    axes.axis("off")
    first = contacts[0]
    stress = "  ".join(f"{symbol} {1e-3 * first['stress_' + key]:.0f}" for symbol, key in (("$\\sigma_x$", "xx"), ("$\\sigma_y$", "yy"), ("$\\tau$", "xy")))
    axes.set_title(f"{first['name']:.0f}\n{stress} kPa", fontsize=9)


def main():
    kind, path, *rest = sys.argv[1:]
    if kind == "curves":
        figure, axes = pyplot.subplots(figsize=(5.6, 3.6), layout="constrained")
        curves(axes, [pair.split("=", 1) for pair in rest])
    elif kind == "strain":
        figure, axes = pyplot.subplots(figsize=(6.6, 3.6), layout="constrained")
        rows = rows_of(rest[0], "points.csv")
        field(figure, axes, rows, "Shear strain, %")
        for name in rest[1:]:
            (row,) = [row for row in rows if row["name"] == float(name)]
            axes.plot(row["x"], row["y"], "o", markersize=5, markerfacecolor="none", markeredgecolor="#1f9bd1", markeredgewidth=1.4)
            axes.annotate(name, (row["x"], row["y"]), textcoords="offset points", xytext=(6, 4), color="#12698f", fontsize=8, fontweight="bold",
                          bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 1.0})
    elif kind == "chains":
        with open(rest[0], newline="") as file:
            contacts = [{key: float(value) for key, value in row.items()} for row in csv.DictReader(file)]
        names = sorted({c["name"] for c in contacts})
        figure, places = pyplot.subplots(1, len(names), figsize=(2.6 * len(names), 3.0), layout="constrained")
        for axes, name in zip(places, names):
            chains(axes, [c for c in contacts if c["name"] == name])
    else:
        figure, (left, right) = pyplot.subplots(1, 2, figsize=(7.4, 4.0), width_ratios=[1.2, 1], layout="constrained")
        rows = rows_of(rest[0], "curve.csv")
        strains = [100 * row["axial_strain"] for row in rows]
        left.plot(strains, [1e-3 * row["axial_stress"] for row in rows], color=COLOURS[0], linewidth=1.8)
        left.set_xlabel("Axial strain, %")
        left.set_ylabel("Axial stress, kPa", color=COLOURS[0])
        left.set_ylim(bottom=0)
        other = left.twinx()
        other.plot(strains, [-100 * row["volumetric_strain"] for row in rows], color=COLOURS[1], linewidth=1.3)
        other.set_ylabel("Increase of volume, %", color=COLOURS[1])
        other.spines["right"].set_visible(True)
        field(figure, right, rows_of(rest[0], "points.csv"), "Shear strain, %")
    figure.savefig(path, metadata={"Date": None}, bbox_inches="tight")


if __name__ == "__main__":
    main()
