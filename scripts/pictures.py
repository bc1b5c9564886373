#!/usr/bin/env python3
"""Makes the pictures of README.md, of the gallery and of the families with the present version, and checks that they are still true.

  scripts/pictures.py make --granum target/release/granum --work FOLDER [report] [gallery | CASE...] [families] [packings]
  scripts/pictures.py --check [--granum target/release/granum] [--quick FOLDER]

`make report` needs the finished folder `FOLDER/reproduction` of `granum reproduce` and the finished folder `FOLDER/quick` of
`granum reproduce --quick` (it makes those that are missing, which takes minutes), and headless Chromium for the photograph of
the report. `make gallery` runs the ready cases, `make families` asks the families of the program and draws the map of their states and the gallery of shapes.
`make packings` makes the packings of the page packings.md by the lines of cases that it shows, and writes their numbers into it. What the pictures state is written to docs/pictures/stated.json.

`--check` verifies without a browser that no picture was changed without its statements, and that README.md and the gallery
say what the pictures say. With `--quick`, the folder of a quick reproduction by the present version, it verifies that this
version states what the version that made the pictures stated; with `--granum` it runs one ready case and compares its
digest, and draws the pictures of families and shapes and the packings again. Exit code 1 if a picture has to be made again.
"""
import argparse
import hashlib
import html
import json
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
PICTURES = ROOT / "docs" / "pictures"
FIGURES = ROOT / "docs" / "src" / "figures"
STATED = PICTURES / "stated.json"
MAP = FIGURES / "state-map.svg"
SHAPES = FIGURES / "shapes.svg"
PACKINGS = ROOT / "docs" / "src" / "packings.md"
# The case of the packings, in which the line of the shape is another for each.
PACKING_CASE = ROOT / "examples" / "packing-of-shapes.toml"
# A reader loads one at a time.
LARGEST_PACKING = 300_000
# A row of the page: its packing, its line, its numbers.
PACKING_ROW = re.compile(r'^(\| <a href="figures/packing-([\w-]+)\.html" .*?</a> \| `(shape = .*?)` \|)(.*)$', re.MULTILINE)
# The ready case that `--check --granum` runs: it takes seconds.
CHECKED_CASE = "strain-history"
# The figure of a ready case's report that the gallery shows.
FIGURE = {
    "paper": "stress", "drained-dense": "stress", "drained-loose": "stress", "undrained-loose": "stress-path",
    "undrained-dense": "stress-path", "cyclic-undrained": "loops", "cyclic-drained": "loops", "simple-shear": "shear",
    "true-triaxial": "deviatoric-plane", "powder-oedometer": "compression", "powder-flow": "stress-path", "wet-grains": "stress",
    "rolling-resistance": "stress", "long-grains": "stress", "bedded-grains": "stress", "cemented-sand": "stress",
    "cemented-sand-undrained": "stress-path", "rock-like": "bonds",
    "crushable-grains": "fragments", "strain-history": "stress-path",
}
# What the picture of a family shows: the command of its chapter.
FAMILIES = {"sand": ["--friction", "0.4", "--rolling-friction", "0.2", "--pressure", "100 kPa", "--youngs-modulus", "2 GPa",
                     "--void-ratio", "0.7", "--path", "drained-triaxial"]}
# Ready cases that are drawn over a laboratory test.
LABORATORY = {"karlsruhe-dense": "TMD22", "karlsruhe-loose": "TMD2"}
# The paper's own number of grains takes some minutes.
EXTRA = {"paper": ["--set", "grains.count=1000"]}


def percent(value):
    return f"{100 * value:.1f} %"


def sha256(path):
    return hashlib.sha256(path.read_bytes()).hexdigest()


def tiles(report):
    """The numbers at the top of a report; the one that depends on the speed of the machine is left out."""
    page = report.read_text()
    found = re.findall(r'<li class="tile"><b>(.*?)</b><span>(.*?)</span>', page)
    if not found:
        sys.exit(f"{report} has no tile that this script can read")
    found = [[html.unescape(re.sub(r"<[^>]*>", "", text)) for text in tile] for tile in found]
    return [tile for tile in found if "faster" not in tile[1]]


def statements(folder):
    """What the report of a reproduction states."""
    summary = json.loads((folder / "summary.json").read_text())
    mappings = {}
    for name, mapping in summary["mappings"].items():
        error = mapping["relative_rmse"]
        numbers = [error["held_out"], error["unseen"], error["strain_only"], mapping["ridge"], mapping["seed_scatter"]]
        mappings[name] = {"formula": mapping["formula"], "errors": [percent(number) for number in numbers]}
    curve = {}
    for point in summary["learning_curve"]["points"]:
        numbers = {key: percent(point[key]["mean"]) for key in ("network", "strain_only", "other_sensors")}
        curve.setdefault(point["mapping"], {})[str(point["training_runs"])] = numbers
    return {"tiles": tiles(folder / "report.html"), "mappings": mappings, "more_runs": curve}


def photograph(page, picture, width, height):
    """A photograph of the upper part of a page."""
    browser = next((name for name in ("chromium", "chromium-browser", "google-chrome") if shutil.which(name)), None)
    if browser is None:
        sys.exit("the photograph of the report needs headless Chromium (Debian: apt-get install chromium)")
    with tempfile.TemporaryDirectory() as profile:
        subprocess.run(
            [browser, "--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-sync",
             "--disable-background-networking", "--disable-component-update", f"--user-data-dir={profile}",
             "--hide-scrollbars", f"--window-size={width},{height}", f"--screenshot={picture}", page.resolve().as_uri()],
            check=True, stderr=subprocess.DEVNULL)


def run(granum, *arguments, quiet=False):
    subprocess.run([granum, *map(str, arguments)], check=True, stdout=subprocess.DEVNULL if quiet else None)


def make_report(granum, work, stated):
    for name, extra in (("reproduction", []), ("quick", ["--quick"])):
        run(granum, "reproduce", *extra, "--out", work / name)
        stated[name] = statements(work / name)
    full = work / "reproduction"
    photograph(full / "report.html", PICTURES / "report.png", 800, 1060)
    shutil.copy(next((full / "figures").glob("*-more-runs.svg")), PICTURES / "more-runs.svg")


def gallery_case(granum, work, name):
    """Runs a ready case and returns what its picture states."""
    folder = work / name
    run(granum, "--force", "init", "--case", name, work / f"{name}.toml")
    run(granum, "--force", "run", work / f"{name}.toml", "--out", folder, *EXTRA.get(name, []))
    digest = json.loads(subprocess.run(
        [granum, "--json", "digest", str(folder)], check=True, capture_output=True, text=True).stdout)
    return {"digest": digest["digests"][0]["sha256"], "measures": json.loads((folder / "run.json").read_text()).get("measures", {})}


def make_gallery(granum, work, names, stated):
    for name in names:
        stated.setdefault("gallery", {})[name] = gallery_case(granum, work, name)
        picture = FIGURES / f"gallery-{name}.svg"
        if name in LABORATORY:
            laboratory = ROOT / "data" / "lab" / "karlsruhe-fine-sand-drained.csv"
            run(granum, "--force", "compare", work / name, laboratory, "--test", LABORATORY[name], "-o", picture)
        else:
            run(granum, "--force", "report", work / name)
            shutil.copy(sorted((work / name / "figures").glob(f"*-{FIGURE[name]}.svg"))[0], picture)


def make_family(granum, name, picture):
    run(granum, "--force", "predict", "--family", name, *FAMILIES[name], "-o", picture, quiet=True)


def make_map(granum, picture):
    """The map of the states of the drained sands."""
    run(granum, "--force", "examine", "map", ROOT / "data" / "families" / "sand" / "drained", "-o", picture, quiet=True)


def make_shapes(granum, picture):
    """One grain of each kind."""
    run(granum, "--force", "shape", ROOT / "examples" / "shapes.toml", "-o", picture, quiet=True)


def packing_rows():
    """The packings that the page shows: name, line of the case, numbers."""
    rows = [(name, line, numbers.strip()) for _, name, line, numbers in PACKING_ROW.findall(PACKINGS.read_text())]
    if not rows:
        sys.exit(f"{PACKINGS} has no row of a packing")
    return rows


def make_packing(granum, work, line, page):
    """Makes the page of a packing by the line of its shape, and returns its numbers as the table has them."""
    for file in PACKING_CASE.parent.glob("*.obj"):
        shutil.copy(file, work)
    case, count = re.subn(r"^shape = .*$", lambda _: line, PACKING_CASE.read_text(), flags=re.MULTILINE)
    if count != 1:
        sys.exit(f"{PACKING_CASE} has {count} lines of a shape")
    (work / "packing.toml").write_text(case)
    # The name of the folder is the title of the page.
    folder = work / page.stem.removeprefix("packing-")
    run(granum, "--force", "prepare", work / "packing.toml", "--out", folder, quiet=True)
    run(granum, "--force", "view", folder, "--opacity", "1", "-o", page, quiet=True)
    if (size := page.stat().st_size) > LARGEST_PACKING:
        sys.exit(f"{page} has {size} bytes, more than {LARGEST_PACKING}")
    about = json.loads((folder / "run.json").read_text())
    spheres = re.search(r"with (\d+) spheres a grain", " ".join(about["notes"]))
    measures = about["measures"]
    return f"{spheres[1] if spheres else 1} | {measures['solid_fraction']:.3f} | {measures['coordination_number']:.1f} |"


def make_packings(granum, work):
    numbers = {name: make_packing(granum, work, line, FIGURES / f"packing-{name}.html") for name, line, _ in packing_rows()}
    PACKINGS.write_text(PACKING_ROW.sub(lambda row: f"{row[1]} {numbers[row[2]]}", PACKINGS.read_text()))


def make(arguments):
    work = arguments.work.resolve()
    work.mkdir(parents=True, exist_ok=True)
    granum = str(arguments.granum.resolve())
    stated = json.loads(STATED.read_text()) if STATED.exists() else {}
    cases = [name for name in arguments.what if name not in ("report", "gallery", "families", "packings")]
    if unknown := [name for name in cases if name not in FIGURE and name not in LABORATORY]:
        sys.exit(f"unknown: {', '.join(unknown)}; there are report, gallery, families, packings, {', '.join([*FIGURE, *LABORATORY])}")
    if "report" in arguments.what or not arguments.what:
        make_report(granum, work, stated)
    if "gallery" in arguments.what or not arguments.what:
        cases = [*FIGURE, *LABORATORY]
    make_gallery(granum, work, cases, stated)
    if "families" in arguments.what or not arguments.what:
        for name in FAMILIES:
            make_family(granum, name, FIGURES / f"family-{name}.svg")
        make_map(granum, MAP)
        make_shapes(granum, SHAPES)
    if "packings" in arguments.what or not arguments.what:
        make_packings(granum, work)
    files = [*PICTURES.glob("*.png"), *PICTURES.glob("*.svg"), *FIGURES.glob("gallery-*.svg"),
             *FIGURES.glob("family-*.svg"), MAP, SHAPES,
             *FIGURES.glob("packing-*.html")]
    stated["pictures"] = {str(path.relative_to(ROOT / "docs")): sha256(path) for path in sorted(files)}
    STATED.write_text(json.dumps(stated, indent=1, ensure_ascii=False, sort_keys=True) + "\n")


def check_readme(stated, problem):
    readme = (ROOT / "README.md").read_text()
    for name, mapping in stated["reproduction"]["mappings"].items():
        row = f"| {mapping['formula']} | " + " | ".join(mapping["errors"]) + " |"
        if row not in readme:
            problem(f"README.md does not have the row of {name} that the report states: {row}")
    most = stated["reproduction"]["more_runs"]["F3"]["8"]
    sentence = " ".join(readme.split())
    for text in (f"is {most['network']}, theirs {most['strain_only']}", f"rises to {most['other_sensors']}"):
        if text not in sentence:
            problem(f"README.md does not say of F3 with eight training runs what the report states: ... {text}")
    gains = next(value for value, name in stated["reproduction"]["tiles"] if "gain" in name)
    if f"{gains} mappings" not in sentence:
        problem(f"README.md does not say that {gains} mappings gain by their sensors, which its picture shows")


def differences(made, present, where=""):
    """Where two statements differ."""
    if isinstance(made, dict) and isinstance(present, dict):
        for key in sorted({*made, *present}):
            yield from differences(made.get(key), present.get(key), f"{where}.{key}")
    elif made != present:
        yield f"{where[1:]}: the pictures have {made}, the present version {present}"


def check(arguments):
    problems = []
    stated = json.loads(STATED.read_text())
    present = {str(path.relative_to(ROOT / "docs")) for folder in (PICTURES, FIGURES) for path in folder.iterdir()
               if path.suffix in (".png", ".svg", ".html") and not path.name.startswith(("campaign-", "calibration-", "fem-", "shape-or-rolling"))}
    for name in sorted(present | set(stated["pictures"])):
        path = ROOT / "docs" / name
        if not path.exists() or stated["pictures"].get(name) != sha256(path):
            problems.append(f"docs/{name} was changed without scripts/pictures.py, or is missing")
    check_readme(stated, problems.append)
    if arguments.quick:
        problems += [f"quick reproduction: {found}"
                     for found in differences(stated["quick"], statements(arguments.quick))]
    if arguments.granum:
        with tempfile.TemporaryDirectory() as work:
            granum, work = str(arguments.granum.resolve()), pathlib.Path(work)
            found = gallery_case(granum, work, CHECKED_CASE)
            for name in FAMILIES:
                make_family(granum, name, work / f"{name}.svg")
                if (work / f"{name}.svg").read_bytes() != (FIGURES / f"family-{name}.svg").read_bytes():
                    problems.append(f"the family {name} answers otherwise than docs/src/figures/family-{name}.svg shows")
            for name, remake, picture in (("the map of states", make_map, MAP), ("the gallery of shapes", make_shapes, SHAPES)):
                remake(granum, work / picture.name)
                if (work / picture.name).read_bytes() != picture.read_bytes():
                    problems.append(f"{name} differs from docs/src/figures/{picture.name}")
            for name, line, numbers in packing_rows():
                page = work / f"packing-{name}.html"
                if (made := make_packing(granum, work, line, page)) != numbers:
                    problems.append(f"the packing {name} has {made}, docs/src/packings.md says {numbers}")
                if page.read_bytes() != (FIGURES / page.name).read_bytes():
                    problems.append(f"the packing {name} differs from docs/src/figures/{page.name}")
        problems += [f"{CHECKED_CASE}: {found}" for found in differences(stated["gallery"][CHECKED_CASE], found)]
    for problem in problems:
        print("FAILED:", problem)
    if problems:
        print("make the pictures again, and correct the pages: scripts/pictures.py make --help")
    print(f"{len(stated['pictures'])} pictures: {'ok' if not problems else 'not ok'}")
    sys.exit(bool(problems))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("command", nargs="?", choices=["make"])
    parser.add_argument("what", nargs="*", help="report, gallery, families, packings, or names of ready cases; everything if nothing is named")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--granum", type=pathlib.Path)
    parser.add_argument("--work", type=pathlib.Path)
    parser.add_argument("--quick", type=pathlib.Path)
    arguments = parser.parse_intermixed_args()
    if arguments.check == (arguments.command == "make"):
        parser.error("either make or --check")
    if arguments.check:
        check(arguments)
    elif not arguments.granum or not arguments.work:
        parser.error("make needs --granum PROGRAM and --work FOLDER")
    else:
        make(arguments)


main()
