#!/usr/bin/env python3
"""For grains with a shape, the rolling friction of spheres that comes nearest to them: in strength, volume, fabric and distribution of forces.

    python3 scripts/shape_or_rolling.py DATA_SET... --granum target/release/granum --table table.md --figure figure.svg

DATA_SET is that of a campaign of the plan `shaped-sand` or of its plans of unseen sands (`granum table` makes it when the campaign ends). Spheres of the same
friction, stress over stiffness, spread and preparation are those of the family `sand` (`granum predict --family sand`), with rolling
frictions from 0 to 0.5. Values are late ones, means from an axial strain of 0.2 to the end of 0.25; the distance of two distributions of contact
forces is half the integral of their difference. Samples of one sand are averaged. Needs Python with pyarrow.
"""
import argparse
import csv
import math
import pathlib
import subprocess
import sys
import tempfile

import pyarrow.parquet as pq

GRID = [round(0.02 * k, 2) for k in range(26)]
LATE = 0.2
WIDTH, HEIGHT, LEFT, TOP, RIGHT, BOTTOM = 640, 430, 70, 20, 20, 90


def mean(values):
    values = list(values)
    return sum(values) / len(values)


def samples(folder):
    """The late values of each run of a data set, with what it is made of."""
    runs = {row["run"]: row for row in pq.read_table(folder / "runs.parquet").to_pylist()}
    names = ["run", "axial_strain", "stress_ratio", "volumetric_strain", "deviator_fabric", "mechanical_coordination_number", "probability_density"]
    states = {}
    for state in pq.read_table(folder / "states.parquet", columns=names).to_pylist():
        states.setdefault(state["run"], []).append(state)
    for name, run in runs.items():
        late = [state for state in states[name] if state["axial_strain"] >= LATE]
        if not late or max(state["axial_strain"] for state in late) < 0.245:
            print(f"{folder}: run {name} ends early and is left out", file=sys.stderr)
            continue
        density = [mean(state["probability_density"][k] for state in late) for k in range(len(late[0]["probability_density"]))]
        volume = mean(state["volumetric_strain"] for state in late)
        void_ratio = run["sample.void_ratio"]
        yield {
            "aspect_ratio": run["grains.shape.aspect_ratio"],
            "friction": run["grains.material.friction"],
            "pressure": run["preparation.mean_stress"],
            "youngs_modulus": run["grains.material.youngs_modulus"],
            "spread": run["grains.spread"],
            "preparation_friction": run["preparation.friction"],
            "sphericity": run["grains.sphericity"],
            "void_ratio": void_ratio,
            "late_void_ratio": (1 + void_ratio) * math.exp(-volume) - 1,
            "strength": mean(state["stress_ratio"] for state in late),
            "peak": max(state["stress_ratio"] for state in states[name]),
            "volume": volume,
            "fabric": mean(state["deviator_fabric"] for state in late),
            "contacts": mean(state["mechanical_coordination_number"] for state in late),
            "forces": density,
        }


def sands(folders):
    """The means over the samples of each sand, and the number of samples."""
    groups = {}
    for folder in folders:
        for sample in samples(folder):
            key = tuple(sample[name] for name in ("aspect_ratio", "friction", "pressure", "preparation_friction"))
            groups.setdefault(key, []).append(sample)
    for group in groups.values():
        one = {"samples": len(group)}
        for name in group[0]:
            if name == "forces":
                one[name] = [mean(sample[name][k] for sample in group) for k in range(len(group[0][name]))]
            else:
                one[name] = mean(sample[name] for sample in group)
        yield one


def spheres(granum, sand):
    """The same of spheres with each rolling friction of the grid."""
    with tempfile.TemporaryDirectory() as name:
        out = pathlib.Path(name) / "curves.csv"
        flags = {"friction": sand["friction"], "rolling-friction": ",".join(map(str, GRID)), "pressure": f"{sand['pressure']} Pa",
                 "youngs-modulus": f"{sand['youngs_modulus']} Pa", "spread": sand["spread"], "preparation-friction": sand["preparation_friction"]}
        command = [granum, "predict", "--family", "sand", "-o", out]
        for flag, value in flags.items():
            command += [f"--{flag}", str(value)]
        done = subprocess.run(command, capture_output=True, text=True)
        if done.returncode != 0:
            raise SystemExit(done.stderr)
        rows = list(csv.DictReader(open(out)))
    bins = [name for name in rows[0] if name.startswith("probability_density_") and not name.endswith(("_lower", "_upper"))]
    found = []
    for rolling in GRID:
        own = [{key: float(value) for key, value in row.items() if value} for row in rows if float(row["rolling_friction"]) == rolling]
        late = [row for row in own if row["axial_strain"] >= LATE]
        volume, void_ratio = mean(row["volumetric_strain"] for row in late), own[0]["sample.void_ratio"]
        found.append({
            "void_ratio": void_ratio,
            "late_void_ratio": (1 + void_ratio) * math.exp(-volume) - 1,
            "strength": mean(row["stress_ratio"] for row in late),
            "peak": max(row["stress_ratio"] for row in own),
            "volume": volume,
            "fabric": mean(row["deviator_fabric"] for row in late),
            "contacts": mean(row["mechanical_coordination_number"] for row in late),
            "forces": [mean(row[name] for row in late) for name in bins],
        })
    return found


def distance(one, other):
    """Half the integral of the difference of two distributions over bins of equal width; the sums of both are their inverse."""
    return 0.5 * sum(abs(a / sum(one) - b / sum(other)) for a, b in zip(one, other))


def nearest(values, wanted):
    """The rolling friction at which a quantity is the wanted one, by linear interpolation; beyond the grid an end of it and a sign; where
    none gives it, the nearest with `~`."""
    for k in range(len(GRID) - 1):
        a, b = values[k] - wanted, values[k + 1] - wanted
        if a == 0 or a * b < 0:
            return GRID[k] + (GRID[k + 1] - GRID[k]) * a / (a - b), ""
    k = min(range(len(GRID)), key=lambda k: abs(values[k] - wanted))
    return GRID[k], {0: "<", len(GRID) - 1: ">"}.get(k, "~")


def at(values, rolling):
    """A value at a rolling friction, by linear interpolation."""
    k = min(int(rolling / GRID[1]), len(GRID) - 2)
    t = (rolling - GRID[k]) / GRID[1]
    return values[k] + t * (values[k + 1] - values[k])


def compared(granum, sand):
    found = spheres(granum, sand)
    column = lambda name: [one[name] for one in found]  # noqa: E731
    sand["nearest"] = {name: nearest(column(name), sand[name]) for name in ("strength", "peak", "volume", "fabric")}
    gaps = [distance(sand["forces"], one["forces"]) for one in found]
    sand["nearest"]["forces"] = (GRID[gaps.index(min(gaps))], "")
    sand["least_gap"] = min(gaps)
    rolling = sand["nearest"]["strength"][0]
    sand["at"] = {name: at(column(name), rolling) for name in ("strength", "void_ratio", "late_void_ratio", "volume", "fabric", "contacts", "peak")}
    sand["at"]["forces"] = at(gaps, rolling)
    return sand


def friction_angle(ratio):
    return math.degrees(math.asin(3 * ratio / (6 + ratio)))


def table(found):
    def near(sand, name):
        value, sign = sand["nearest"][name]
        return f"{sign}{value:.2f}"

    lines = [
        "| aspect ratio | friction | stress over modulus | of it while made | late friction angle | late strength | peak | late volume | fabric | P(f) "
        "| void ratio, made | late | fabric | contacts a grain | P(f) apart |",
        "|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|",
    ]
    for sand in sorted(found, key=lambda sand: sand["aspect_ratio"]):
        with_ = sand["at"]
        cells = [f"{sand['aspect_ratio']:.2f}", f"{sand['friction']:.2f}", f"{sand['pressure'] / sand['youngs_modulus']:.1e}",
                 f"{sand['preparation_friction'] / sand['friction']:.2f}", f"{friction_angle(sand['strength']):.1f}°"]
        cells += [near(sand, name) for name in ("strength", "peak", "volume", "fabric", "forces")]
        cells += [f"{sand[name]:.3f} ({with_[name]:.3f})" for name in ("void_ratio", "late_void_ratio", "fabric")]
        cells += [f"{sand['contacts']:.1f} ({with_['contacts']:.1f})", f"{100 * with_['forces']:.1f} %"]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines) + "\n"


def figure(found):
    """The nearest rolling frictions over the aspect ratio, as SVG."""
    top = 0.55
    x = lambda value: LEFT + (value - 1) / 1.6 * (WIDTH - LEFT - RIGHT)  # noqa: E731
    y = lambda value: TOP + (1 - value / top) * (HEIGHT - TOP - BOTTOM)  # noqa: E731
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {HEIGHT}" font-family="sans-serif" font-size="13" fill="#222">',
        f'<rect width="{WIDTH}" height="{HEIGHT}" fill="white"/>',
    ]
    for tick in (1, 1.25, 1.5, 1.75, 2, 2.25, 2.5):
        parts.append(f'<path d="M{x(tick):.1f} {y(0):.1f}v5" stroke="#222"/><text x="{x(tick):.1f}" y="{y(0) + 20:.1f}" text-anchor="middle">{tick:g}</text>')
    for tick in (0, 0.1, 0.2, 0.3, 0.4, 0.5):
        parts.append(f'<path d="M{x(1):.1f} {y(tick):.1f}H{WIDTH - RIGHT}" stroke="#ddd"/>'
                     f'<text x="{LEFT - 8}" y="{y(tick) + 4:.1f}" text-anchor="end">{tick:g}</text>')
    parts.append(f'<path d="M{LEFT} {TOP}V{y(0):.1f}H{WIDTH - RIGHT}" fill="none" stroke="#222"/>')
    parts.append(f'<text x="{(LEFT + WIDTH - RIGHT) / 2}" y="{y(0) + 46:.0f}" text-anchor="middle">aspect ratio of the capsules</text>')
    parts.append(f'<text transform="translate(18 {(TOP + y(0)) / 2:.1f}) rotate(-90)" text-anchor="middle">nearest rolling friction of spheres</text>')
    # Rorato's relation over the sphericities of the grains, as far as the range goes.
    line = sorted((sand["aspect_ratio"], 0.196 * sand["sphericity"] ** -8.98) for sand in found)
    points = " ".join(f"{x(a):.1f},{y(b):.1f}" for a, b in line if b <= top)
    parts.append(f'<polyline points="{points}" fill="none" stroke="#888" stroke-dasharray="5 4"/>')
    styles = [("strength", "late strength", "#1f5fbf", "circle"), ("volume", "late volume", "#c0392b", "square"), ("fabric", "late fabric", "#2e8b57", "cross")]
    for name, _, colour, mark in styles:
        for sand in found:
            big = 1.0 if sand["samples"] > 1 else 0.55
            value, sign = sand["nearest"][name]
            parts.append(marked(mark, x(sand["aspect_ratio"]), y(value), 5 * big, colour, sign == ""))
    for k, (_, words, colour, mark) in enumerate(styles):
        parts.append(marked(mark, LEFT + 6 + 105 * k, HEIGHT - 18, 5, colour, True))
        parts.append(f'<text x="{LEFT + 18 + 105 * k}" y="{HEIGHT - 14}">{words}</text>')
    parts.append(f'<path d="M{LEFT + 312} {HEIGHT - 18}h20" stroke="#888" stroke-dasharray="5 4"/>'
                 f'<text x="{LEFT + 338}" y="{HEIGHT - 14}">after Rorato et al. 2021</text>')
    return "\n".join(parts) + "\n</svg>\n"


def marked(mark, x, y, size, colour, is_within):
    """A mark; one that is not filled is beyond the range of rolling frictions."""
    style = f'fill="{colour if is_within else "white"}" stroke="{colour}"'
    if mark == "circle":
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{size:.1f}" {style}/>'
    if mark == "square":
        return f'<rect x="{x - size:.1f}" y="{y - size:.1f}" width="{2 * size:.1f}" height="{2 * size:.1f}" {style}/>'
    return f'<path d="M{x:.1f} {y - 1.3 * size:.1f}l{1.3 * size:.1f} {2.4 * size:.1f}h{-2.6 * size:.1f}z" {style}/>'


def main():
    flags = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    flags.add_argument("data", nargs="+", type=pathlib.Path)
    flags.add_argument("--granum", default="target/release/granum")
    flags.add_argument("--table", type=pathlib.Path)
    flags.add_argument("--figure", type=pathlib.Path)
    given = flags.parse_args()
    found = [compared(given.granum, sand) for sand in sands(given.data)]
    several = [sand for sand in found if sand["samples"] > 1] or found
    text = table(several)
    print(text)
    if given.table:
        given.table.write_text(text)
    if given.figure:
        given.figure.write_text(figure(found))
    # Means over all sands whose strength is within the range of rolling frictions.
    inside = [sand for sand in found if sand["nearest"]["strength"][1] == ""]
    print(f"{len(found)} sands, {len(inside)} of them with a strength that some rolling friction gives; at that:")
    print(f"  void ratio as made less by {mean(s['at']['void_ratio'] - s['void_ratio'] for s in inside):.3f}, "
          f"late by {mean(s['at']['late_void_ratio'] - s['late_void_ratio'] for s in inside):.3f}")
    print(f"  fabric {mean(s['fabric'] / s['at']['fabric'] for s in inside):.2f} times, contacts a grain {mean(s['contacts'] / s['at']['contacts'] for s in inside):.2f} times")
    print(f"  late volume differs by {math.sqrt(mean((s['volume'] - s['at']['volume']) ** 2 for s in inside)):.4f} rms; "
          f"P(f) by {100 * mean(s['at']['forces'] for s in inside):.1f} %, at the nearest {100 * mean(s['least_gap'] for s in inside):.1f} %")


if __name__ == "__main__":
    main()
