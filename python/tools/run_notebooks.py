"""Runs the notebooks: python python/tools/run_notebooks.py [--write] [NAME ...]

Each notebook of `python/notebooks` is executed from its folder. Without `--write` it fails if a cell fails or if a text differs from the one that is
kept in the file: results of granum are the same on every machine. With `--write` the outputs are kept in the files, without the times and the versions
that would differ from one execution to the next. Needs nbclient and ipykernel.
"""

from __future__ import annotations

import argparse
import pathlib
import sys
from typing import Any

NOTEBOOKS = pathlib.Path(__file__).parent.parent / "notebooks"
LARGEST = 400_000
"""Largest size of a file, bytes."""


def names() -> list[str]:
    """The names of the notebooks."""
    return sorted(path.stem for path in NOTEBOOKS.glob("*.ipynb"))


def executed(name: str) -> Any:
    """A notebook after its execution, without what depends on where and when it was executed."""
    import nbformat
    from nbclient import NotebookClient

    notebook = nbformat.read(NOTEBOOKS / f"{name}.ipynb", as_version=4)
    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": str(NOTEBOOKS)}}).execute()
    notebook.metadata = {"kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"}, "language_info": {"name": "python"}}
    for cell in notebook.cells:
        cell.metadata.pop("execution", None)
        if "outputs" in cell:
            cell.outputs = joined(cell.outputs)
    return notebook


def joined(outputs: list[Any]) -> list[Any]:
    """Outputs with what a cell prints in one piece: in how many it comes depends on how long the cell takes."""
    found: list[Any] = []
    for output in outputs:
        last = found[-1] if found else None
        if last is not None and output.output_type == last.output_type == "stream" and output.name == last.name:
            last.text += output.text
        else:
            found.append(output)
    return found


def texts(notebook: Any) -> list[str]:
    """What its cells print, and the texts of what they show but for those of figures."""
    found = []
    for cell in notebook.cells:
        for output in cell.get("outputs", []):
            if output.output_type == "stream":
                found.append(output.text)
            elif "data" in output and "image/png" not in output.data:
                found.append(output.data.get("text/plain", ""))
    return found


def check(name: str) -> list[str]:
    """What is wrong with a notebook, if anything."""
    import nbformat

    path = NOTEBOOKS / f"{name}.ipynb"
    kept = texts(nbformat.read(path, as_version=4))
    wrong = [f"{name}: its file has {path.stat().st_size} bytes, and at most {LARGEST} are wanted"] if path.stat().st_size > LARGEST else []
    if not kept:
        wrong.append(f"{name}: no outputs are kept in its file")
    found = texts(executed(name))
    for old, new in zip(kept, found):
        if old != new:
            wrong.append(f"{name}: its file has\n{old}\nand now it gives\n{new}")
    if len(kept) != len(found):
        wrong.append(f"{name}: its file has {len(kept)} texts, and now it gives {len(found)}")
    return wrong


def main() -> None:
    """Runs and checks or writes."""
    import nbformat

    options = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    options.add_argument("names", nargs="*", metavar="NAME")
    options.add_argument("--write", action="store_true")
    given = options.parse_args()
    wrong = []
    for name in given.names or names():
        if given.write:
            path = NOTEBOOKS / f"{name}.ipynb"
            path.write_text(nbformat.writes(executed(name), indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
            print(f"{name}: {path.stat().st_size} bytes")
        else:
            wrong += check(name)
    if wrong:
        sys.exit("\n".join(wrong) + "\nafter a change that is meant: python python/tools/run_notebooks.py --write")


if __name__ == "__main__":
    main()
