"""Checks the folder that `granum reproduce --quick` leaves: check_summary.py FOLDER"""
import json
import pathlib
import sys

folder = pathlib.Path(sys.argv[1])
summary = json.loads((folder / "summary.json").read_text())
times = json.loads((folder / "seconds.json").read_text())
problems = []


def check(good, what):
    if not good:
        problems.append(what)


dem = summary["dem"]
check(dem["grains"] == 1000, f"grains: {dem['grains']}")
check(abs(dem["solid_fraction"] - 0.61) < 0.01, f"solid fraction: {dem['solid_fraction']}")
check(4 < dem["coordination_number"] < 6, f"coordination number: {dem['coordination_number']}")
check(4 < dem["mechanical_coordination_number"] < 6.5, "mechanical coordination number")
check([r["role"] for r in dem["runs"]] == ["training", "unseen", "unseen"], "roles of the runs")
check(len({r["seed"] for r in dem["runs"]}) == 3, "seeds differ")
check(all(r["grain_steps"] > 1e8 for r in dem["runs"]), "work of the runs")
check(all(r["wall_seconds"] > 0 for r in times["dem"]["runs"]), "times of the runs")

tables = {  # neurons of Tables 1-6
    "F1": [60, 55, 50], "F2": [25, 40, 65], "F3": [50, 50, 50],
    "F4": [25, 40, 55], "F5": [25, 40, 55], "F6": [50, 60, 65],
}
check(sorted(summary["mappings"]) == sorted(tables), "mappings F1..F6")
for name, neurons in tables.items():
    mapping = summary["mappings"][name]
    check([s["hidden"] for s in mapping["sub_models"]] == [[n, n] for n in neurons], f"{name}: neurons")
    for part in ("held_out", "unseen", "strain_only"):
        error = mapping["relative_rmse"][part]
        check(0 < error < 1, f"{name}: {part} relative RMSE {error}")
    check(0 < mapping["seed_scatter"] < 0.5, f"{name}: seed scatter {mapping['seed_scatter']}")
check(times["speed"]["factor"] > 10, f"speed factor {times['speed']['factor']}")

curve = summary["learning_curve"]["points"]
check([p["training_runs"] for p in curve if p["mapping"] == "F3"] == [1, 2, 4], "numbers of training runs")
last = [p for p in curve if p["mapping"] == "F3"][-1]
check(last["network"]["mean"] < last["strain_only"]["mean"], "the sensors of F3 help from four runs on")
check(last["network"]["mean"] < last["other_sensors"]["mean"], "the sensors of F3 are used")

report = (folder / "report.html").read_text()
check(all(f"Figure {k}" in report for k in range(3, 9)), "Figures 3-8 in the report")
check(all(f"Table {k}" in report for k in range(1, 7)), "Tables 1-6 in the report")
check("http://" not in report.replace("http://www.w3.org", "") and "https://" not in report, "report is offline")
check(len(list((folder / "figures").glob("*.svg"))) >= 6, "figures as SVG")
check(len(list((folder / "models").glob("F*.json"))) >= 18, "eighteen models")

for problem in problems:
    print("FAILED:", problem)
print(f"summary: {'ok' if not problems else 'not ok'}")
sys.exit(bool(problems))
