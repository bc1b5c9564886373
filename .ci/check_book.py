"""Checks the book and the other pages: check_book.py [FOLDER OF THE BUILT BOOK]

Every link to a file, a heading or a picture must lead somewhere, every file of the repository that is named as code must exist, every page must be in the table of contents, every
included program must exist, and a line of a table of VALIDATION.md is at most a few sentences. With the folder that `mdbook build` wrote, its pages are checked in the same way.
"""
import html.parser
import pathlib
import re
import sys
import urllib.parse

root = pathlib.Path(__file__).resolve().parent.parent
source = root / "docs" / "src"
problems = []
# For each program the parts that pages quote; an empty name for the whole file.
quoted = {}
# Characters: a claim, its evidence, the test, a tolerance and a weakness, each in a sentence or two.
LONGEST_TABLE_LINE = 600


def without_code(text):
    """The text without code blocks and code in lines, in which brackets are not links."""
    text = re.sub(r"(?ms)^( *)(```|~~~).*?^\1\2 *$", "", text)
    return re.sub(r"`[^`\n]*`", "code", text)


def headings(text):
    """The names by which the headings of a page are linked."""
    names, seen = set(), {}
    for line in re.sub(r"(?ms)^( *)(```|~~~).*?^\1\2 *$", "", text).splitlines():
        if match := re.match(r"#{1,6} +(.*?)(?: *\{#([\w-]+)\})? *$", line):
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", match[1]).replace("`", "").replace("*", "").replace("\\", "")
            name = match[2] or re.sub(r"[^\w -]", "", title.lower()).replace(" ", "-")
            count = seen.get(name, 0)
            seen[name] = count + 1
            names.add(name if count == 0 else f"{name}-{count}")
    return names


def anchors(program):
    """The parts of a program that pages can quote: those that begin and end once."""
    text = program.read_text()
    begun, ended = (re.findall(rf"(?m)(?://|#) {word}: (\w+)$", text) for word in ("ANCHOR", "ANCHOR_END"))
    return {name for name in begun if begun.count(name) == 1 and ended.count(name) == 1}


def check_examples():
    """Every example is quoted; of one with anchors, every part, and never the whole file, in which anchors would be seen."""
    for program in sorted((root / "examples").glob("*.rs")):
        parts, seen = anchors(program), quoted.get(program.resolve(), set())
        name = program.relative_to(root)
        if program.name == "lib.rs":
            continue
        if not seen:
            problems.append(f"{name} is quoted by no page")
        if parts and "" in seen:
            problems.append(f"{name} has anchors and is quoted as a whole")
        for part in sorted(parts - seen):
            problems.append(f"{name}: the part {part} is quoted by no page")
        if len(parts) != len(re.findall(r"// ANCHOR(?:_END)?: ", program.read_text())) / 2:
            problems.append(f"{name}: an anchor does not begin and end once")


def check_page(page):
    text = page.read_text()
    for include in re.findall(r"(?<!\\)\{\{#include ([^}:]+)(?::(\w+))?\}\}", text):
        path, anchor = page.parent / include[0].strip(), include[1]
        if not path.is_file():
            problems.append(f"{page.relative_to(root)}: includes {include[0]}, which does not exist")
        elif anchor and anchor not in anchors(path):
            problems.append(f"{page.relative_to(root)}: {include[0]} has no anchor {anchor} that begins and ends")
        else:
            quoted.setdefault(path.resolve(), set()).add(anchor)
    for target in re.findall(r"\]\(([^)\s]+)(?: \"[^\"]*\")?\)", without_code(text)):
        if re.match(r"[a-z]+:", target):
            continue
        name, _, heading = urllib.parse.unquote(target).partition("#")
        path = (page.parent / name) if name else page
        if not path.exists():
            problems.append(f"{page.relative_to(root)}: links to {target}, which does not exist")
        elif heading and path.suffix == ".md" and heading not in headings(path.read_text()):
            problems.append(f"{page.relative_to(root)}: {name or 'the page itself'} has no heading #{heading}")


def check_named_files(page):
    """Files and folders that are named as code, such as `crates/granum-dem/src/engine.rs` or `granum-dem/src/engine.rs`, exist."""
    folders = "crates|scripts|benches|data|docs|examples|python|granum-[a-z0-9]+"
    for name in re.findall(rf"`((?:{folders})/[\w./-]+)(?:::\w+)?`", page.read_text()):
        path = root / "crates" / name if name.startswith("granum-") else root / name
        if not path.exists():
            problems.append(f"{page.relative_to(root)}: names {name}, which does not exist")


class Links(html.parser.HTMLParser):
    def __init__(self):
        super().__init__()
        self.links, self.names = [], set()

    def handle_starttag(self, tag, attributes):
        for key, value in attributes:
            if key in ("href", "src") and value and tag in ("a", "img"):
                self.links.append(value)
            if key == "id" and value:
                self.names.add(value)


def read(page):
    links = Links()
    links.feed(page.read_text())
    return links


def check_built(folder):
    pages = {page: read(page) for page in folder.rglob("*.html") if page.name not in ("print.html", "toc.html", "404.html")}
    for page, content in pages.items():
        if "{{#" in re.sub(r"(?s)<code.*?</code>", "", page.read_text()):
            problems.append(f"{page.name}: an include was not resolved")
        for link in content.links:
            if re.match(r"[a-z]+:", link):
                continue
            name, _, heading = urllib.parse.unquote(link).partition("#")
            target = (page.parent / name).resolve() if name else page
            if not target.exists():
                problems.append(f"the built {page.relative_to(folder)} links to {link}, which does not exist")
            elif heading and target in pages and heading not in pages[target].names:
                problems.append(f"the built {page.relative_to(folder)} links to {link}, a heading that does not exist")
    if len(pages) < 10:
        problems.append(f"the built book has {len(pages)} pages only")


contents = re.findall(r"\]\(([^)]+)\)", (source / "SUMMARY.md").read_text())
for page in sorted(source.rglob("*.md")):
    name = str(page.relative_to(source))
    if name != "SUMMARY.md" and name not in contents:
        problems.append(f"docs/src/{name} is not in SUMMARY.md")
pages = sorted(source.rglob("*.md")) + sorted(root.glob("*.md")) + sorted(root.glob("crates/*/README.md"))
pages += sorted(root.glob("benches/**/README.md")) + sorted(root.glob("data/**/README.md")) + [root / "fuzz" / "README.md"]
for page in pages:
    check_page(page)
    check_named_files(page)
check_examples()
for number, line in enumerate((root / "VALIDATION.md").read_text().splitlines(), 1):
    if line.startswith("|") and len(line) > LONGEST_TABLE_LINE:
        problems.append(f"VALIDATION.md, line {number}: {len(line)} characters; split it, or move details to the book")
if len(sys.argv) > 1:
    check_built(pathlib.Path(sys.argv[1]).resolve())

for problem in problems:
    print("FAILED:", problem)
print(f"{len(pages)} pages: {'ok' if not problems else 'not ok'}")
sys.exit(bool(problems))
