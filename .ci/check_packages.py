"""Packs the crates as they would be published, and checks what is in them: check_packages.py [--compile]

- Each has both licences, a README, a description and keywords, and is smaller than the 10 MB that crates.io takes.
- Each has every file that its code takes in when it is compiled (`include_str!`, `include_bytes!`), but for tests, which read the repository.

Nothing is published and nothing is fetched. With --compile each package is compiled from its own files as well, as `cargo publish` does: 16 crates,
which takes minutes. Exit code 1 if anything does not hold.
"""
import pathlib
import re
import subprocess
import sys
import tarfile
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
LARGEST = 10e6
NOT_PUBLISHED = ["granum-python", "granum-examples"]
INCLUDED = re.compile(r'include_(?:str|bytes)!\(\s*"([^"]+)"')
problems = []


def check(path):
    name = path.name.removesuffix(".crate")
    with tarfile.open(path) as packed:
        files = {member.name.removeprefix(f"{name}/"): member for member in packed.getmembers()}
        read = lambda file: packed.extractfile(files[file]).read().decode()
        for needed in ["LICENSE-APACHE", "LICENSE-MIT", "README.md"]:
            if needed not in files:
                problems.append(f"{name}: {needed} is not in the package")
        about = tomllib.loads(read("Cargo.toml"))["package"]
        for key in ["description", "license", "readme", "keywords", "categories", "rust-version"]:
            if not about.get(key):
                problems.append(f"{name}: Cargo.toml has no {key}")
        for file in (file for file in files if file.startswith("src/") and file.endswith(".rs")):
            if "tests" in pathlib.PurePath(file).stem or "/tests/" in file:
                continue
            for included in INCLUDED.findall(read(file).split("#[cfg(test)]\nmod tests")[0]):
                place = (pathlib.Path("/") / pathlib.PurePath(file).parent / included).resolve().relative_to("/")
                if str(place) not in files:
                    problems.append(f"{name}: {file} includes {included}, which is not in the package")
    if path.stat().st_size > LARGEST:
        problems.append(f"{name}: {path.stat().st_size} bytes, more than crates.io takes")


folder = ROOT / "target" / "package"
for old in folder.glob("*.crate"):
    old.unlink()
excluded = [part for name in NOT_PUBLISHED for part in ("--exclude", name)]
options = ["--locked", "--offline", "--allow-dirty", "--quiet"] + ([] if "--compile" in sys.argv[1:] else ["--no-verify"])
if subprocess.run(["cargo", "package", "--workspace", *excluded, *options], cwd=ROOT).returncode != 0:
    sys.exit("the crates cannot be packed")
packages = sorted(folder.glob("*.crate"))
crates = {path.parent.name for path in (ROOT / "crates").glob("*/Cargo.toml")}
for lost in crates - {path.name.rsplit("-", 1)[0] for path in packages}:
    problems.append(f"{lost} was not packed")
for path in packages:
    check(path)
for problem in problems:
    print(problem)
if not problems:
    print(f"{len(packages)} crates, {sum(path.stat().st_size for path in packages)} bytes")
sys.exit(bool(problems))
