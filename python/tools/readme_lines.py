"""Runs the lines of Python in README.md as a reader would who has installed the package alone: with NumPy, and without pandas."""

import importlib.util
import os
import pathlib
import re
import sys
import tempfile
import warnings

import granum

README = pathlib.Path(__file__).resolve().parent.parent.parent / "README.md"

if importlib.util.find_spec("pandas"):
    sys.exit("pandas is installed here, so that nothing would be shown; use a fresh environment")
blocks = re.findall(r"```python\n(.*?)```", README.read_text(encoding="utf-8"), flags=re.S)
if not blocks:
    sys.exit(f"{README} has no lines of Python")
with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
    warnings.simplefilter("ignore", granum.RunWarning)
    os.chdir(folder)
    names: dict[str, object] = {}
    for block in blocks:
        exec(compile(block, str(README), "exec"), names)
    os.chdir(README.parent)
print(f"README: {len(blocks)} blocks of Python ran")
