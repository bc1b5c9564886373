"""Checks how the code is divided: check_structure.py [--show]

- No file of Rust has more than LONGEST lines.
- Crates depend downwards only, in the order of the table of crates in ARCHITECTURE.md.
- Within a crate no files import each other in a circle, but for those in CIRCLES. Tests may import what they test.
- Neither do the folders and files in the `src` of a crate, each folder taken as a whole, but for the crates in FOLDER_CIRCLES.
- Every file and folder that ARCHITECTURE.md names exists.
- The file of a folder `thing/` is `thing/mod.rs`, not a file `thing.rs` beside it.
- No function is called `of`: its name says what it gives (CONTRIBUTING.md).
- Files that a user names are opened by `granum_core::input`, which refuses pipes and devices, but for the places in OPENED_OTHERWISE.
- No code of a library or of the program panics where it could return an error, but for the places in PANICS.

With --show, every import between two files of a crate is printed. Exit code 1 if anything does not hold.
"""
import pathlib
import re
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
LONGEST = 600
# Folders in which a circle is meant, with its reason in ARCHITECTURE.md.
CIRCLES = ["granum-dem/src/sizes/", "granum-shape/src/"]
# Crates whose folders are not in layers, with the reason.
FOLDER_CIRCLES = {
    "granum-dem": "laws, kernel and simulation are one engine: a law names the kernel that evaluates it, and the kernel its laws",
    "granum-io": "run folders hold snapshots and cases, formats read and write all of them",
    "granum-shape": "each family makes an entry of the list that names it",
    "granum-simd": "each instruction set has the fused product of its own and falls back to that of another",
}
# Where code may panic, with the reason why no user can cause it.
PANICS = {
    "granum-simd/src/lanes.rs": "an index out of bounds, as of a slice: the engine makes the indices",
    "granum-dem/src/kernel/laws.rs": "a method of a trait that the kernel of these laws does not call",
    "granum-dem/src/team.rs": "blocks of grains, which the engine counts",
    "granum-dem/src/contact/law/energy_channel.rs": "evaluated by the compiler: a law with too many channels is no program",
    "granum-nets/src/gaussian_process/process.rs": "a row of another length, as the documentation of the function says",
    "python/src/mistake.rs": "a mistake on purpose, which the tests of the package ask for",
}
# Where files are opened that granum or the system made, or that are only made safe on the disk.
OPENED_OTHERWISE = {
    "granum-core/src/input/mod.rs": "the place where files are opened",
    "granum-campaign/src/claim/owner.rs": "files of the system about a process, and a name of the machine",
    "granum-campaign/src/execution/one_run.rs": "a file of the system about the process",
    "granum-campaign/src/rows/row_files.rs": "files of rows, which the campaign looks at before it opens them",
    "granum-campaign/src/rows/row_writer.rs": "a folder that is made safe on the disk",
    "granum-io/src/atomic.rs": "a folder that is made safe on the disk",
    "granum-io/src/formats/gsd/mod.rs": "a file of this format, whose opening is that of granum-core",
    "granum-io/src/folder/lock.rs": "a lock, which is looked at before it is opened",
    "granum-io/src/folder/mod.rs": "a lock",
    "granum-io/src/folder/process.rs": "a file of the system about a process",
    "granum-run/src/engine/lammps/place.rs": "files that a running LAMMPS writes in the folder of the run",
    "granum-run/src/engine/lammps/program.rs": "files that a running LAMMPS writes in the folder of the run",
    "granum-run/src/engine/lammps/progress.rs": "files that a running LAMMPS writes in the folder of the run",
    "granum-run/src/engine/lammps/run.rs": "files that a running LAMMPS writes in the folder of the run",
    "granum/src/interrupt.rs": "a file of the system about the process",
}
problems = []


def without_comments_and_strings(text):
    pattern = r'//[^\n]*|/\*.*?\*/|b?r(#*)".*?"\1|b?"(?:\\.|[^"\\])*"|\'(?:\\.|[^\'\\])\''
    return re.sub(pattern, lambda match: '""' if '"' in match[0] else " ", text, flags=re.S)


def without_tests(text):
    """The text without `#[cfg(test)] mod tests { ... }` and other items that exist in tests only."""
    while match := re.search(r"#\[cfg\((?:all\()?test\b[^\]]*\]\s*", text):
        at, depth = match.end(), 0
        while at < len(text):
            if text[at] == "{":
                depth += 1
            if text[at] == "}":
                depth -= 1
                if depth == 0:
                    break
            if text[at] == ";" and depth == 0:
                break
            at += 1
        text = text[: match.start()] + text[at + 1 :]
    return text


def leaves(tree, prefix=()):
    """The paths of a `use` tree, as (segments, name under which the last one is known)."""
    tree = tree.strip()
    brace = tree.find("{")
    if brace < 0:
        path, _, name = tree.partition(" as ")
        segments = prefix + tuple(part.strip() for part in path.split("::") if part.strip())
        if segments[-1] == "self":
            segments = segments[:-1]
        yield segments, name.strip() or segments[-1]
        return
    head = prefix + tuple(part.strip() for part in tree[:brace].split("::") if part.strip())
    part, depth = "", 0
    for character in tree[brace + 1 : tree.rindex("}")] + ",":
        depth += (character == "{") - (character == "}")
        if character == "," and depth == 0:
            if part.strip():
                yield from leaves(part, head)
            part = ""
        else:
            part += character


class Crate:
    def __init__(self, folder):
        self.source = folder / "src"
        self.modules, self.names, self.paths = {}, {}, {}
        for file in sorted(self.source.rglob("*.rs")):
            segments = file.relative_to(self.source).with_suffix("").parts
            if segments[-1] in ("mod", "lib"):
                segments = segments[:-1]
            if segments != ("main",):
                self.modules[segments] = file
        for module, file in self.modules.items():
            text = without_tests(without_comments_and_strings(file.read_text()))
            uses = re.findall(r"\b(pub(?:\([^)]*\))?\s+)?use\s+([^;]+);", text)
            self.names[module], self.paths[module] = {}, []
            for public, tree in uses:
                for segments, name in leaves(tree):
                    self.names[module][name] = segments
                    # A name that is only passed on is no import: who uses it is followed to the file that defines it.
                    if not public:
                        self.paths[module].append(segments)
            text = re.sub(r"\buse\s+[^;]+;", "", text)
            for path in re.findall(r"\b(?:crate|super|self)(?:::\w+)+", text):
                self.paths[module].append(tuple(path.split("::")))
            for path in re.findall(r"(?<![\w:])[a-z]\w*(?:::\w+)+", text):
                first = path.split("::")[0]
                if first in self.names[module]:
                    self.paths[module].append(self.names[module][first] + tuple(path.split("::")[1:]))
                elif module + (first,) in self.modules:
                    self.paths[module].append(tuple(path.split("::")))

    def resolve(self, module, path, depth=0):
        """The module that defines what a path names; `None` if it is of another crate."""
        at = list(path)
        if at[0] == "crate":
            here, at = (), at[1:]
        elif at[0] in ("super", "self"):
            here = module
            while at and at[0] in ("super", "self"):
                here, at = (here[:-1] if at[0] == "super" else here), at[1:]
        elif module + (at[0],) in self.modules:
            here = module
        elif at[0] in self.names[module] and self.names[module][at[0]] != path and depth < 9:
            return self.resolve(module, self.names[module][at[0]] + tuple(at[1:]), depth + 1)
        else:
            return None
        while at and here + (at[0],) in self.modules:
            here, at = here + (at[0],), at[1:]
        if here not in self.modules:
            return None
        if at and at[0] in self.names[here] and depth < 9:
            inner = self.resolve(here, self.names[here][at[0]] + tuple(at[1:]), depth + 1)
            return inner if inner is not None else here
        return here

    def imports(self):
        graph = {}
        for module in self.modules:
            if self.is_test(module):
                continue
            found = {self.resolve(module, path) for path in self.paths[module]} - {None, module}
            graph[module] = {other for other in found if not self.is_test(other)}
        return graph

    @staticmethod
    def is_test(module):
        return any(part == "tests" or part.endswith("_tests") for part in module)


def circles(graph):
    """The groups of modules that import each other in a circle (Tarjan 1972)."""
    index, low, stack, groups = {}, {}, [], []

    def visit(module):
        index[module] = low[module] = len(index)
        stack.append(module)
        for other in sorted(graph[module]):
            if other not in index:
                visit(other)
                low[module] = min(low[module], low[other])
            elif other in stack:
                low[module] = min(low[module], index[other])
        if low[module] == index[module]:
            group = []
            while not group or group[-1] != module:
                group.append(stack.pop())
            if len(group) > 1:
                groups.append(sorted(group))

    for module in sorted(graph):
        if module not in index:
            visit(module)
    return groups


def by_folder(graph):
    """The same graph between the folders and files that lie in `src` itself."""
    folders = {module[0]: set() for module in graph if module}
    for module, others in graph.items():
        for other in others:
            if module and other and module[0] != other[0]:
                folders[module[0]].add(other[0])
    return folders


def check_lengths():
    folders = [ROOT / name for name in ("crates", "examples", "fuzz", "python")]
    for file in sorted(file for folder in folders for file in folder.rglob("*.rs")):
        if "target" in file.relative_to(ROOT).parts:
            continue
        text = file.read_text()
        lines = text.count("\n")
        if lines > LONGEST:
            problems.append(f"{file.relative_to(ROOT)} has {lines} lines, more than {LONGEST}: divide it by its ideas")
        if re.search(r"\bfn of\b", text):
            problems.append(f"{file.relative_to(ROOT)} has a function `of`: name it by what it gives, `new` or `from_x`")
        if "src" in file.parts and file.with_suffix("").is_dir() and file.name not in ("main.rs", "lib.rs"):
            problems.append(f"{file.relative_to(ROOT)} lies beside its folder: make it {file.stem}/mod.rs")


def check_panics():
    """Unwrapping, expecting, panicking and asserting outside tests; what the compiler asserts (`const`) cannot happen."""
    called = r"\.unwrap\(\)|\.expect\(|\b(?:panic|unreachable|todo|unimplemented|assert(?:_eq|_ne)?)!"
    for source in [*sorted((ROOT / "crates").glob("*/src")), ROOT / "python" / "src"]:
        texts = {file: without_comments_and_strings(file.read_text()) for file in sorted(source.rglob("*.rs"))}
        tests = set()
        for file, text in texts.items():
            folder = file.parent if file.name in ("mod.rs", "lib.rs", "main.rs") else file.with_suffix("")
            for name in re.findall(r"#\[cfg\(test\)\]\s*(?:pub(?:\([^)]*\))?\s+)?mod (\w+);", text):
                tests |= {folder / f"{name}.rs", folder / name / "mod.rs"}
        for file, text in texts.items():
            parts = file.relative_to(source).with_suffix("").parts
            name = str(file.relative_to(source.parent.parent))
            if file in tests or Crate.is_test(parts) or name in PANICS:
                continue
            text = re.sub(r"\bconst\s*(?:\{\s*assert!|_: \(\) = assert!)", "", without_tests(text))
            for found in sorted(set(re.findall(called, text))):
                problems.append(f"{name} calls {found}: return an error, or add it to PANICS with the reason why no user can cause it")


def check_crates():
    table = re.findall(r"(?m)^\| `(granum[\w-]*)` \|", (ROOT / "ARCHITECTURE.md").read_text())
    folders = sorted(folder.name for folder in (ROOT / "crates").iterdir() if (folder / "Cargo.toml").exists())
    for name in sorted(set(folders) - set(table)):
        problems.append(f"crates/{name} is not in the table of crates in ARCHITECTURE.md")
    for name in sorted(set(table) - set(folders)):
        problems.append(f"ARCHITECTURE.md has a crate {name}, which does not exist")
    for name in folders:
        manifest = tomllib.loads((ROOT / "crates" / name / "Cargo.toml").read_text())
        for other in manifest.get("dependencies", {}):
            if {name, other} <= set(table) and table.index(other) <= table.index(name):
                problems.append(f"{name} depends on {other}, which is above it in the table of ARCHITECTURE.md")
    return folders


def check_paths():
    """Every file and folder that ARCHITECTURE.md names exists."""
    bases = [ROOT, ROOT / "crates", *ROOT.glob("crates/*"), *ROOT.glob("crates/*/src"), *ROOT.glob("crates/*/src/contact")]
    for path in sorted(set(re.findall(r"`([\w./-]+(?:\.rs|\.py|/))`", (ROOT / "ARCHITECTURE.md").read_text()))):
        if not any((base / path).exists() for base in bases):
            problems.append(f"ARCHITECTURE.md names {path}, which does not exist")


def check_opening():
    """Files that a user names are opened in one place."""
    for file in sorted(ROOT.glob("crates/*/src/**/*.rs")):
        name = str(file.relative_to(ROOT / "crates"))
        if name in OPENED_OTHERWISE or any(part == "tests" or part.endswith("tests") for part in pathlib.Path(name).with_suffix("").parts):
            continue
        text = without_tests(without_comments_and_strings(file.read_text()))
        for call in re.findall(r"\bfs::read(?:_to_string)?\(|\bFile::open\(", text):
            problems.append(f"{name} opens a file by {call}...): granum_core::input refuses pipes and devices")


check_lengths()
check_paths()
check_opening()
check_panics()
for folder in [*(ROOT / "crates" / name for name in check_crates()), ROOT / "python"]:
    name, crate = folder.name, Crate(folder)
    graph = crate.imports()
    shown = {module: f"{name}/{file.relative_to(crate.source.parent)}" for module, file in crate.modules.items()}
    if "--show" in sys.argv:
        for module, others in graph.items():
            for other in sorted(others):
                print(shown[module], "->", shown[other])
    for group in circles(graph):
        files = {shown[module].removesuffix(".rs").removesuffix("/mod") for module in group}
        meant = any(all(f"{file}/".startswith(circle) for file in files) for circle in CIRCLES)
        if not meant:
            problems.append("these files import each other in a circle: " + ", ".join(sorted(files)))
    for group in circles(by_folder(graph)):
        if name not in FOLDER_CIRCLES:
            problems.append(f"these folders of {name} import each other in a circle: " + ", ".join(group))

for problem in problems:
    print("FAILED:", problem)
print("structure: " + ("not ok" if problems else "ok"))
sys.exit(bool(problems))
