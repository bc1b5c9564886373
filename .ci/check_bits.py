"""Checks what clippy cannot see of the rule that results have the same bits everywhere: check_bits.py

- `powi` of numbers has a literal exponent of 2 to 4 outside tests, which every compiler multiplies out in the same order; others
  take `granum_simd::integer_power`.
- Who allows elementary functions of the platform (clippy.toml) states a reason.

Exit code 1 if anything does not hold.
"""
import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
problems = []


def is_test(file):
    return any(part in ("tests", "examples", "benches") or re.search(r"(^|_)tests(\.rs)?$", part) for part in file.parts)


def before_tests(text):
    """The text up to the module of its tests, which ends a file (CONTRIBUTING.md)."""
    return re.split(r"(?m)^#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))? )?mod \w+ \{", text)[0]


for file in sorted([*(ROOT / "crates").glob("*/src/**/*.rs"), *(ROOT / "python" / "src").rglob("*.rs")]):
    name = file.relative_to(ROOT)
    if is_test(name):
        continue
    text = before_tests(re.sub(r"//[^\n]*", "", file.read_text()))
    for exponent in re.findall(r"\.powi\(((?:[^()]|\([^()]*\))*)\)", text):
        if exponent not in ("2", "3", "4"):
            problems.append(f"{name} calls powi({exponent}): use granum_simd::integer_power")
    for allowed in re.findall(r"(?:allow|expect)\(([^()]*disallowed_methods[^()]*)\)", text):
        if "reason" not in allowed:
            problems.append(f"{name} allows elementary functions of the platform and does not say why")

for problem in problems:
    print("FAILED:", problem)
print("bits: " + ("not ok" if problems else "ok"))
sys.exit(bool(problems))
