"""Builds the reference of the package from its docstrings: python python/tools/api_reference.py FOLDER

The pages need neither a server nor the network. It fails if something public has no docstring. Needs pdoc and the package as it is installed.
"""

from __future__ import annotations

import ast
import pathlib
import sys
import warnings

import granum

MODULES = ["granum", "granum.calibration", "granum.campaigns", "granum.errors", "granum.grainlearning", "granum.keys", "granum.sensors",
           "granum.sklearn", "granum.surrogates"]  # fmt: skip


def undocumented(path: pathlib.Path) -> list[str]:
    """The public classes and functions of a file, and methods of public classes, that have no docstring. Overloads share one."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    found: list[str] = []

    def look(body: list[ast.stmt], before: str) -> None:
        documented = {node.name for node in body if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and ast.get_docstring(node)}
        for node in body:
            if isinstance(node, (ast.FunctionDef, ast.ClassDef)) and not node.name.startswith("_"):
                if node.name not in documented:
                    found.append(f"{path.name}: {before}{node.name}")
                if isinstance(node, ast.ClassDef):
                    look(node.body, f"{before}{node.name}.")

    look(tree.body, "")
    return found


def main() -> None:
    """Checks and builds."""
    import pdoc
    import pdoc.render

    folder = pathlib.Path(granum.__file__).parent
    files = sorted([*folder.glob("*.py"), *folder.glob("*.pyi")])
    missing = [name for path in files if not path.name.startswith("_") or path.suffix == ".pyi" for name in undocumented(path)]
    if missing:
        sys.exit("without a docstring:\n" + "\n".join(missing))
    pdoc.render.configure(docformat="markdown", show_source=False, footer_text=f"granum {granum.__version__}")
    # It does not resolve some annotations that only a type checker needs, shows them as they are written, and warns of each.
    warnings.simplefilter("ignore")
    pdoc.pdoc(*MODULES, output_directory=pathlib.Path(sys.argv[1]))
    pages = list(pathlib.Path(sys.argv[1]).rglob("*.html"))
    print(f"{len(pages)} pages in {sys.argv[1]}")


if __name__ == "__main__":
    main()
