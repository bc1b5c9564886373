"""Writes granum/keys.py, the keys of a case for editors and type checkers, from the declarations by which case files are read.

    python python/tools/generate_keys.py            # writes the file
    python python/tools/generate_keys.py --check    # fails if it is not current
"""

import pathlib
import sys
import textwrap
from typing import Any

import granum

FILE = pathlib.Path(__file__).parent.parent / "granum" / "keys.py"
HEAD = '''"""The keys of a case: what `granum.Case` takes, each with its meaning, bounds and unit.

Made by python/tools/generate_keys.py from the declarations by which case files are read; do not edit it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Literal, TypeAlias, TypedDict

Quantity: TypeAlias = Any
"""A number in SI units, a text with a unit such as `"0.2 mm"`, a number of NumPy, or a quantity of pint."""

Quantities: TypeAlias = Any
"""A sequence of quantities, or of such sequences; an array, a frame of pandas or a quantity of pint with an array."""
'''


def type_of(schema: dict[str, Any]) -> str:
    """The type of a value."""
    if "const" in schema:
        return f'Literal["{schema["const"]}"]'
    if "$ref" in schema:
        return '"Stage"'
    if "enum" in schema:
        return "Literal[" + ", ".join(f'"{word}"' for word in schema["enum"]) + "]"
    if "anyOf" in schema:
        return " | ".join(dict.fromkeys(type_of(part) for part in schema["anyOf"]))
    kind = schema.get("type")
    if kind == "array":
        item = type_of(schema.get("items", {}))
        return "Quantities" if item in ("Quantity", "Quantities") else f"Sequence[{item}]"
    return {"integer": "int", "boolean": "bool", "string": "str", "object": "dict[str, Any]"}.get(str(kind), "Quantity")


def documented(text: str, default: object, indent: str) -> str:
    """A docstring within the width of a line."""
    if default is not None:
        text = f"{text} Default: {default}."
    text = text.replace("\\", "\\\\").replace('"""', "'''")
    lines = textwrap.wrap(text, 110, break_on_hyphens=False) or [""]
    joined = ("\n" + indent).join(lines)
    return f'{indent}"""{joined}"""' if len(lines) == 1 else f'{indent}"""{joined}\n{indent}"""'


def class_name(key: str) -> str:
    """The name of the class of a table."""
    return "".join(part.capitalize() for part in key.replace("-", "_").split("_"))


def typed_dict(name: str, schema: dict[str, Any], classes: list[str], special: dict[str, str] | None = None) -> None:
    """Appends the class of a table, after those of the tables in it."""
    lines = [f"class {name}(TypedDict, total=False):", documented(schema["description"], None, "    "), ""]
    for key, value in schema["properties"].items():
        if special and key in special:
            kind = special[key]
        elif value.get("type") == ["object", "array"]:
            # A section, or tables with further keys.
            kind = name + class_name(key)
            both = value["properties"] | {key: part for key, part in value["items"]["properties"].items() if key not in value["properties"]}
            typed_dict(kind, {"description": value["description"], "properties": both}, classes)
            kind = f"{kind} | Sequence[{kind}]"
        elif value.get("type") == "object" and "properties" in value:
            kind = name + class_name(key)
            typed_dict(kind, value, classes, {"stage": 'Sequence["Stage"]'})
        else:
            kind = type_of(value)
        # A key that is a word of Python cannot be a field of a class; a case has none.
        lines += [f"    {key}: {kind}", documented(value.get("description", ""), value.get("default"), "    ")]
    classes.append("\n".join(lines))


def text() -> str:
    """The text of the file."""
    schema = granum.schema()
    classes: list[str] = []
    stages: list[str] = []
    for key, value in schema["properties"].items():
        if value["type"] == "array" and "properties" in value["items"]:
            typed_dict(class_name(key), value["items"], classes)
        elif value["type"] == "object":
            typed_dict(class_name(key), value, classes, {"stage": 'Sequence["Stage"]'})
    for number, stage in enumerate(schema["$defs"]["stage"]["anyOf"]):
        path = stage["properties"].get("path", {}).get("const")
        if path:
            name = class_name(path) + "Stage"
        elif "repeat" in stage["properties"]:
            name = "RepeatedStage"
        elif "incremental_driver" in stage["properties"]:
            name = "IncrementalDriverStage"
        else:
            name = "ControlledStage"
        typed_dict(name, stage, classes)
        stages.append(name)
    union = "Stage: TypeAlias = (\n    " + "\n    | ".join(stages) + '\n)\n"""A stage of a test or of a preparation."""'
    return "\n\n".join([HEAD.rstrip(), *(f"\n{one}" for one in classes), f"\n{union}"]) + "\n"


if __name__ == "__main__":
    made = text()
    if "--check" in sys.argv:
        if FILE.read_text(encoding="utf-8") != made:
            sys.exit("python/granum/keys.py is not current: run python python/tools/generate_keys.py")
    else:
        FILE.write_text(made, encoding="utf-8")
