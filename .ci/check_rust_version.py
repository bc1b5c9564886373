"""Fails if a package that granum needs requires a newer Rust than granum says it does (`rust-version` in Cargo.toml)."""

import json
import subprocess
import sys


def number(version):
    return tuple(int(part) for part in version.split("."))[:2]


metadata = json.loads(
    subprocess.run(
        ["cargo", "metadata", "--locked", "--format-version", "1"], check=True, capture_output=True, text=True
    ).stdout
)
packages = metadata["packages"]
oldest = next(p["rust_version"] for p in packages if p["name"] == "granum")
too_new = [
    f"{p['name']} {p['version']} requires Rust {p['rust_version']}"
    for p in packages
    if p["rust_version"] and number(p["rust_version"]) > number(oldest)
]
if too_new:
    sys.exit(f"Cargo.toml says that Rust {oldest} is enough, but\n" + "\n".join(too_new))
print(f"{len(packages)} packages, none requires more than Rust {oldest}")
