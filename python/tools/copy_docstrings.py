"""Copies the docstrings of `python/granum/_granum.pyi` to what they belong to in `python/src`: python python/tools/copy_docstrings.py

Editors read the stubs, and `help` and notebooks what is compiled. A test compares the two.
"""

from __future__ import annotations

import ast
import inspect
import pathlib
import re
from collections.abc import Iterator

HERE = pathlib.Path(__file__).parent.parent


def docstrings() -> Iterator[tuple[str | None, str, str]]:
    """Each docstring of the stubs: the class or none, the name, and the text. Of overloads the first one, of a class the name is empty."""
    tree = ast.parse((HERE / "granum" / "_granum.pyi").read_text(encoding="utf-8"))
    seen = set()
    for node in tree.body:
        if isinstance(node, ast.ClassDef):
            text = ast.get_docstring(node)
            if text:
                yield node.name, "", text
            for inner in node.body:
                if isinstance(inner, ast.FunctionDef) and (text := ast.get_docstring(inner)) and not inner.name.startswith("_"):
                    yield node.name, inner.name, text
        elif isinstance(node, ast.FunctionDef) and (text := ast.get_docstring(node)) and node.name not in seen:
            seen.add(node.name)
            yield None, node.name, text


def place(source: list[str], owner: str | None, name: str) -> int | None:
    """The line of a class, a method or a function in a file of Rust."""
    if owner is not None and not name:
        return next((k for k, line in enumerate(source) if re.match(rf"pub struct {owner}\b", line) and "#[pyclass" in "".join(source[max(0, k - 4) : k])), None)
    start = 0
    if owner is not None:
        block = [k for k, line in enumerate(source) if line.startswith(f"impl {owner} {{") and source[k - 1].startswith("#[pymethods]")]
        if not block:
            return None
        start = block[0]
    indent = "    " if owner is not None else ""
    for k in range(start, len(source)):
        if owner is not None and source[k].startswith("}"):
            return None
        own = re.match(rf"{indent}(pub )?fn (\w+)[<(]", source[k])
        head = "".join(source[max(0, k - 7) : k])
        renamed = re.search(rf'\(name = "{name}"', head) is not None
        if own and (own[2] == name or renamed) and (owner is not None or "#[pyfunction]" in head):
            return k
    return None


def written(source: list[str], at: int, text: str) -> list[str]:
    """The lines of a file with another comment of documentation before the item of a line."""
    indent = re.match(r" *", source[at])[0]  # type: ignore[index]
    first = at
    while source[first - 1].startswith((f"{indent}#[", f"{indent}///")) or source[first - 1].startswith(f"{indent}    ") or source[first - 1] in (f"{indent})]", f"{indent}))]"):
        first -= 1
    kept = [line for line in source[first:at] if not line.startswith(f"{indent}///")]
    lines = [f"{indent}/// {line}".rstrip() for line in inspect.cleandoc(text).splitlines()]
    return source[:first] + lines + kept + source[at:]


def main() -> None:
    """Copies."""
    files = {path: path.read_text(encoding="utf-8").splitlines() for path in sorted((HERE / "src").glob("*.rs"))}
    missing = []
    for owner, name, text in docstrings():
        for path, source in files.items():
            at = place(source, owner, name)
            if at is not None:
                files[path] = written(source, at, text)
                break
        else:
            missing.append(f"{owner}.{name}" if owner else name)
    for path, source in files.items():
        path.write_text("\n".join(source) + "\n", encoding="utf-8")
    if missing:
        raise SystemExit(f"not found in python/src: {', '.join(missing)}")


if __name__ == "__main__":
    main()
