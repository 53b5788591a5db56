"""Checks how the pages are built: paths, links, the menu, the API reference, translations.

`python -m tools.page_lint` prints what is wrong and ends with 1 when anything is. A hook of MkDocs runs it:
a strict build fails by it. What the pages *say* (commands, programs) is run by tests/test_documentation.py.
"""

from __future__ import annotations

import ast
import importlib
import logging
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parent.parent
FENCE = re.compile(r"^```(\w*)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def read(path: Path) -> str:
    return path.read_text("utf-8")


def pages(root: Path) -> list[Path]:
    return sorted([*root.glob("*.md"), *(root / "docs").rglob("*.md")])


def without_code(page: str) -> str:
    return FENCE.sub("", page)


# -- Links, the menu, the first screen -----------------------------------------------------------------------


def links(root: Path) -> Iterator[str]:
    """Every relative link names an existing file, and every anchor one of its headings."""
    for page in pages(root):
        for target in re.findall(r"\]\(([^)\s]+)\)", read(page)):
            if "://" in target:
                continue
            path, _, anchor = target.partition("#")
            file = (page.parent / path) if path else page
            if not file.exists():
                yield f"{page.name}: there is no {target}"
            elif anchor and anchor not in anchors(read(file)):
                yield f"{page.name}: {target} names no heading"


def anchors(page: str) -> set[str]:
    """Anchors of the headings (mostly as MkDocs and code hosts make them)."""
    headings = re.findall(r"^#+ (.+)$", page, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def menu(root: Path) -> Iterator[str]:
    """Each page of docs/ is in mkdocs.yml."""
    entries = read(root / "mkdocs.yml")
    for page in (root / "docs").rglob("*.md"):
        name = page.relative_to(root / "docs").as_posix()
        if f"{name}\n" not in entries:
            yield f"mkdocs.yml has no entry for {name}"


MAX_PAGE_LINES = 400  # lines of one page
OTHER_LENGTHS = {"architecture.md": 260}


def length(root: Path) -> Iterator[str]:
    """A page is not too long."""
    for page in (root / "docs").rglob("*.md"):
        lines, limit = len(read(page).splitlines()), OTHER_LENGTHS.get(page.name, MAX_PAGE_LINES)
        if lines > limit:
            yield f"{page.name} has {lines} lines, more than {limit}"


LEADS_TO = ("web", "safety", "tour", "comparison", "troubleshooting")
COMMANDS = ["pip install . && woosh demo", 'pip install -e ".[test]" && pytest']
"""Of README: one line sets up and shows it, one sets up and tests it. CI runs them, word by word."""


def readme(root: Path) -> Iterator[str]:
    """README is short, has the safety note, and links to docs/."""
    for name in ("README.md", "README.zh-CN.md"):
        text = read(root / name)
        if len(text.splitlines()) > 100:
            yield f"{name} is longer than 100 lines"
        yield from (f"{name} does not lead to {to}" for to in LEADS_TO if f"](docs/{to}" not in text)
        pictures = re.findall(r"docs/pictures/[\w.-]+", text)
        if pictures != ["docs/pictures/web.png", "docs/pictures/web-phone.png"]:
            yield f"{name} does not show the page on a computer and on a phone, but {pictures}"
        if re.findall(r"^    (pip install .*)$", text, re.MULTILINE) != COMMANDS:
            yield f"{name} has other commands than {COMMANDS}"
    for word in ("demo", "pytest"):
        if f"readme_command {word}" not in read(root / ".ci/run"):
            yield f".ci/run does not run README's command with {word}"


def installing(root: Path) -> Iterator[str]:
    """`woosh-pure` is not published, and single quotes break cmd.exe: `pip install ".[web]"` works."""
    wrong = re.compile(r"pip install (?:-\w+ )*'|woosh-pure\[(?!test)")
    extra = re.compile(r"pip install (?:-e )?\"\.\[([a-z0-9,]+)\]\"")
    extras = read(root / "pyproject.toml").partition("[project.optional-dependencies]")[2].partition("\n[")[0]
    known = set(re.findall(r"^(\w+) = \[", extras, re.MULTILINE))
    folders = ("rosproto", "woosh_pure", "examples", "tools")
    sources = [path for folder in folders for path in (root / folder).rglob("*.*")]
    told: set[str] = set()
    for path in [*pages(root), *(path for path in sources if path.suffix in {".md", ".py", ".txt", ".toml"})]:
        if path == Path(__file__):
            continue
        text = read(path)
        yield from (
            f"{path.relative_to(root)}: {found} does not work everywhere" for found in wrong.findall(text)
        )
        told |= {name for found in extra.findall(text) for name in found.split(",")}
    yield from (f"there is no extra {name}" for name in sorted(told - known))
    expected = {"web", "fleet", "missions", "bridge", "mcap", "arrow", "remote", "ros2", "test"}
    yield from (f"nothing says how to install the extra {name}" for name in sorted(expected - told))


# -- docs/architecture.md ------------------------------------------------------------------------------------

FLOORS = ("rosproto", "rosproto/node", "woosh_pure")
"""Packages that the page describes."""


def architecture(root: Path) -> Iterator[str]:
    """Every path on it exists, it describes every package, and each kind of change has a place and tests."""
    page = read(root / "docs/architecture.md")
    named = sorted(set(re.findall(r"`([^`\s]+)`", page)))
    for name in named:
        if "/" in name.strip("/") and not name.startswith("/"):
            found = root / name
            if not (found.is_dir() if name.endswith("/") else found.is_file()):
                yield f"architecture.md: there is no {name}"
        elif re.search(r"\.(py|json|md|txt)$", name):
            yield f"architecture.md: {name} may be in any folder; name it with its folder"
    rooms = [file.parent for floor in FLOORS for file in (root / floor).glob("*/__init__.py")]
    tests = [file.parent for file in (root / "tests").glob("*/*.py")]
    for room in sorted({folder.relative_to(root).as_posix() for folder in (*rooms, *tests)}):
        if f"`{room}/`" not in page:
            yield f"architecture.md does not say what {room}/ is"
    changes = re.findall(r"^\| (.+) \| .+ \| (.+) \|$", page.partition("| I want to change")[2], re.MULTILINE)
    if len(changes) < 25:
        yield f"architecture.md: {len(changes)} rows say where to go with a change"
    yield from (f"architecture.md names no tests for {name}" for name, by in changes if "`tests/" not in by)
    journey = page.partition("## Journey 2")[2].partition("\n## ")[0]
    files = set(re.findall(r"`([^`]+\.py)`", journey))
    if not 0 < len(files) <= 11:  # one object owns a motion, so nobody walks to and fro
        yield f"architecture.md: journey 2 goes through {len(files)} files, at most 11 were enough"


# -- The API reference ---------------------------------------------------------------------------------------

PACKAGES = [
    "rosproto", "rosproto.action", "rosproto.aio", "rosproto.bag", "rosproto.gateway",
    "rosproto.gateway.foxglove", "rosproto.gateway.rosbridge.rosapi", "rosproto.node", "rosproto.numeric",
    "rosproto.recording", "rosproto.tf", "woosh_pure", "woosh_pure.aio", "woosh_pure.api_server",
    "woosh_pure.fleet", "woosh_pure.mcp", "woosh_pure.missions", "woosh_pure.sim", "woosh_pure.web",
]  # fmt: skip
BUILDING_BLOCKS = {"BagSeries", "MessageBuffer", "Pacer", "bag_name"}
"""What Recorder and Player are made of; rosproto.master likewise, of which Master is a name of rosproto's."""


def reference(root: Path) -> Iterator[str]:
    """It has every public name, directly or with the defining module, and no removed one."""
    shown = {
        name
        for page in (root / "docs/api").glob("*.md")
        for name in re.findall(r"^::: (\S+)$", read(page), re.MULTILINE)
    }
    for directive in sorted(shown):
        if not is_there(directive):
            yield f"docs/api shows {directive}, which is not there"
    for package in PACKAGES:
        for name in importlib.import_module(package).__all__:
            found = getattr(importlib.import_module(package), name)
            home = getattr(found, "__module__", package)
            module = type(found).__name__ == "module"  # its names are asked for one by one
            if not (module or name in BUILDING_BLOCKS or {home, f"{home}.{name}"} & shown):
                yield f"docs/api does not show {package}.{name} of {home}"


def is_there(directive: str) -> bool:
    """Whether it is a module, or a name of one."""
    module, _, name = directive.rpartition(".")
    try:
        importlib.import_module(directive)
    except ModuleNotFoundError:
        return bool(module) and hasattr(importlib.import_module(module), name)
    return True


# -- Chinese pages -------------------------------------------------------------------------------------------

IN_ENGLISH_ONLY = {
    "interface", "commands",  # made from docstrings and help texts, which are English
    "architecture", "wire", "performance", "portability",  # for those who change the code, which is English
}  # fmt: skip
NAME = re.compile(r"[/~]\w+(/\w+)*|\w+/\w+|[A-Z]\d|[\d.:]+")  # of topics, types, marks, chassis
LINK = re.compile(r"\[(?!English\]|中文|教程\])[^]]*\]\(([^)#\s]+)")


def chinese_pages(root: Path) -> list[Path]:
    return [*root.glob("*.zh-CN.md"), *(root / "docs").rglob("*.zh-CN.md")]


def chinese(root: Path) -> Iterator[str]:
    """Every Chinese page has the headings, points, programs, commands, tables and links of its twin."""
    twins = chinese_pages(root)
    there = {page.name.removesuffix(".zh-CN.md") for page in twins}
    guides = [page for folder in ("docs", "docs/lesson") for page in (root / folder).glob("*.md")]
    needed = {"README", *(page.stem for page in guides if ".zh-CN" not in page.name)}
    yield from (f"there is no {name}.zh-CN.md" for name in sorted(needed - there - IN_ENGLISH_ONLY))
    for twin in sorted(twins):
        english, translated = read(in_english(twin)), read(twin)
        for what, of_page in SAME.items():
            one, other = of_page(english), of_page(translated)
            if one != other:
                yield f"{twin.name}: other {what} than in English: {difference(one, other)}"
        odd = {name for name in names_in(english) ^ names_in(translated) if name.isascii()}
        if odd - {"Ethernet"}:  # the name of a network card is Chinese there
            yield f"{twin.name}: names on one of the two pages only: {sorted(odd)}"
        found, expected = Counter(LINK.findall(translated)), translated_links(english, twin.parent)
        if found != expected:
            yield f"{twin.name}: other links than in English: {found - expected}, {expected - found}"
        if "zh-CN.md)" not in english[:1000] or "[English](" not in translated[:1000]:
            yield f"{twin.name}: the two pages do not name each other at their beginnings"


def in_english(twin: Path) -> Path:
    return twin.with_name(twin.name.replace(".zh-CN.md", ".md"))


def difference(one: list[Any], other: list[Any]) -> str:
    """The first place where two lists differ."""
    different = [pair for pair in zip(one, other, strict=False) if pair[0] != pair[1]]
    return "{} became {}".format(*(different or [(len(one), len(other))])[0])


def headings(page: str) -> list[str]:
    """Their levels."""
    return re.findall(r"^(#+) ", without_code(page), re.MULTILINE)


def points(page: str) -> list[str]:
    """Beginnings of list items and bold paragraphs, with numbers replaced."""
    return re.findall(r"^(- |(?=\d+\. )|\*\*)", without_code(page), re.MULTILINE)


def programs(page: str) -> list[tuple[str, str, str]]:
    """Language, flags and code of each block, without comments and texts for users."""
    return [
        (kind, flags, re.sub(r" *#.*", "", code) if kind == "toml" else bare(code))
        for kind, flags, code in FENCE.findall(page)
    ]


def bare(code: str) -> str:
    tree = ast.parse(code)
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and not NAME.fullmatch(node.value):
            node.value = "..."
    return ast.dump(tree)


def commands(page: str) -> list[str]:
    """Indented lines without quoted texts (the name of a network card)."""
    lines = re.findall(r"^ {4}(\S.*)$", without_code(page), re.MULTILINE)
    return [re.sub(r'"[^"]*"', '""', line) for line in lines]


def tables(page: str) -> list[list[tuple[list[str], str]]]:
    """Of each cell of each row: the names in it, and the Y, P, N or - that it begins with."""
    return [
        [
            (names(part), (re.match(r" (\*\*N\*\*|[YPN-])(?=[ （])", part) or [""])[0])
            for part in re.split(r"(?<!\\)\|", row)[1:-1]
        ]
        for row in re.findall(r"^\|.*\|$", without_code(page), re.MULTILINE)
    ]


def names(text: str) -> list[str]:
    """Texts in backquotes, sorted, because the order of words differs.

    A text of a program in Chinese is not a name: it has another one on the English page.
    """
    return sorted(name for name in re.findall(r"`([^`]+)`", text) if not re.search("[一-鿿]", name))


def names_in(page: str) -> set[str]:
    return set(names(re.sub(r"<!--.*?-->", "", without_code(page))))


def translated_links(english: str, folder: Path) -> Counter[str]:
    """Link targets of an English page on its twin: Chinese pages and pictures if they exist."""
    return Counter(
        twin if (folder / (twin := re.sub(r"\.(md|svg)$", r".zh-CN.\1", link))).exists() else link
        for link in LINK.findall(english)
    )


SAME: dict[str, Callable[[str], list[Any]]] = {
    "headings": headings, "points": points, "programs": programs, "commands": commands, "tables": tables,
}  # fmt: skip


def paragraphs(root: Path) -> Iterator[str]:
    """A paragraph or point of a Chinese page is one line: a line break inside it is shown as a blank."""
    for page in sorted(chinese_pages(root)):
        inside = False
        for line in FENCE.sub("\n", read(page)).splitlines():
            prose = bool(line.strip()) and not re.match(r" {4}|[#|<]", line)
            if inside and prose and not re.match(r" *(- |\d+\. )", line):
                yield f"{page.name}: a line break in front of {line.strip()[:40]!r}"
            inside = prose


def glossary(root: Path) -> Iterator[str]:
    """Chinese pages, tables and the words of the web page use the glossary in CONTRIBUTING.md."""
    part = read(root / "CONTRIBUTING.md").partition("## Chinese words")[2].partition("\n## ")[0]
    rows = re.findall(r"^\| .+ \| (.+) \| (`.+`) \|$", part, re.MULTILINE)
    if not rows:
        yield "CONTRIBUTING.md has no glossary of Chinese words"
    tables = (*root.glob("woosh_pure/language/zh/*.txt"), *root.glob("woosh_pure/web/page/js/words_zh*.js"))
    for path in sorted([*chinese_pages(root), *tables]):
        for good, bad in rows:
            for word in re.findall("|".join(re.findall("`([^`]+)`", bad)), read(path)):
                yield f"{path.name}: {word} is {good} here (CONTRIBUTING.md, Chinese words)"


# -- What the code refers to ---------------------------------------------------------------------------------


def references(root: Path) -> Iterator[str]:
    """Files and facts of docs/wire.md that docstrings and comments of the packages name are there."""
    facts = set(re.findall(r"^(\d+)\. ", read(root / "docs/wire.md"), re.MULTILINE))
    for path in sorted(path for top in ("rosproto", "woosh_pure") for path in (root / top).rglob("*.py")):
        text, where = read(path), path.relative_to(root).as_posix()
        for name in re.findall(
            r"(?<![\w/])(?:rosproto|woosh_pure|tests|tools|docs)/[\w/]+\.(?:py|md)\b", text
        ):
            if not (root / name).exists():
                yield f"{where}: there is no {name}"
        for word, number in re.findall(r"\b(wire\.md, fact|pitfall) (\d+)", text):
            if word == "pitfall" or number not in facts:
                yield f"{where}: docs/wire.md has no fact {number}; write (wire.md, fact N)"


# -- All of it -----------------------------------------------------------------------------------------------

CHECKS = (
    links,
    menu,
    length,
    readme,
    installing,
    architecture,
    reference,
    chinese,
    paragraphs,
    glossary,
    references,
)


def findings(root: Path = ROOT) -> list[str]:
    """The faults of the pages, a sentence each."""
    return [found for check in CHECKS for found in check(root)]


def on_pre_build(**_: Any) -> None:
    """A hook of MkDocs: each fault is a warning, which fails a strict build."""
    log = logging.getLogger("mkdocs.hooks.page_lint")
    for found in findings():
        log.warning(found)


def main() -> int:
    found = findings()
    print(*found, sep="\n", end="\n" * bool(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
