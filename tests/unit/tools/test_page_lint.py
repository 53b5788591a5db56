"""The lint of the pages sees what it is for."""

from __future__ import annotations

from pathlib import Path

import pytest

from tools import built_pages, page_lint


def tree(folder: Path, **files: str) -> Path:
    """A root with pages: "README" and "docs__a__b" are README.md and docs/a/b.md."""
    for name, text in files.items():
        path = folder / f"{name.replace('__', '/')}.md"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, "utf-8")
    return folder


def test_a_link_leads_to_a_file_and_to_a_heading(tmp_path: Path) -> None:
    page = "[a](docs/a.md) [b](docs/a.md#a-part) [x](docs/b.md) [y](docs/a.md#gone) [z](https://elsewhere)"
    found = list(page_lint.links(tree(tmp_path, README=page, docs__a="# A `part`\n")))
    assert found == ["README.md: there is no docs/b.md", "README.md: docs/a.md#gone names no heading"]


def test_every_page_is_in_the_menu(tmp_path: Path) -> None:
    tree(tmp_path, docs__a="", docs__api__b="")
    (tmp_path / "mkdocs.yml").write_text("nav:\n  - a.md\n")
    assert list(page_lint.menu(tmp_path)) == ["mkdocs.yml has no entry for api/b.md"]


def test_a_page_has_a_limit_of_lines(tmp_path: Path) -> None:
    tree(tmp_path, docs__a="a\n" * 400, docs__commands__b="b\n" * 401, docs__architecture="c\n" * 261)
    assert sorted(page_lint.length(tmp_path)) == [
        "architecture.md has 261 lines, more than 260",
        "b.md has 401 lines, more than 400",
    ]


def test_the_reference_shows_what_is_there(tmp_path: Path) -> None:
    tree(tmp_path, docs__api__a="::: rosproto.gone\n\n::: rosproto.tf\n\n::: rosproto.node.Node\n")
    found = list(page_lint.reference(tmp_path))
    assert found[0] == "docs/api shows rosproto.gone, which is not there"
    assert any("does not show woosh_pure.Chassis of" in line for line in found)


def test_docstrings_name_files_and_facts_that_are_there(tmp_path: Path) -> None:
    tree(tmp_path, docs__wire="1. A fact.\n")
    (tmp_path / "rosproto").mkdir()
    (tmp_path / "rosproto/a.py").write_text(
        "# rosproto/a.py, rosproto/gone.py (wire.md, fact 1), (wire.md, fact 2)"
    )
    assert list(page_lint.references(tmp_path)) == [
        "rosproto/a.py: there is no rosproto/gone.py",
        "rosproto/a.py: docs/wire.md has no fact 2; write (wire.md, fact N)",
    ]


def test_how_architecture_md_may_be_wrong(tmp_path: Path) -> None:
    page = "`rosproto/gone.py` `somewhere.py` `tests/` \n| I want to change | where | tests |\n|---|---|---|\n| a | b | c |\n"
    (tmp_path / "rosproto/room").mkdir(parents=True)
    (tmp_path / "rosproto/room/__init__.py").touch()
    found = list(page_lint.architecture(tree(tmp_path, docs__architecture=page)))
    assert found == [
        "architecture.md: there is no rosproto/gone.py",
        "architecture.md: somewhere.py may be in any folder; name it with its folder",
        "architecture.md does not say what rosproto/room/ is",
        "architecture.md: 1 rows say where to go with a change",
        "architecture.md names no tests for a",
        "architecture.md: journey 2 goes through 0 files, at most 11 were enough",
    ]


ENGLISH = """# A
[中文](a.zh-CN.md) [safety](docs/safety.md)

- one `name`

    woosh demo "eth0"

```python
x = 1  # one
say("hello")
```

| a | b |
|---|---|
| `c` | Y (yes) |
"""
CHINESE = """# 甲
[English](a.md) [安全](docs/safety.md)

- 一 `name`

    woosh demo "以太网"

```python
x = 1  # 一
say("你好")
```

| 甲 | 乙 |
|---|---|
| `c` | Y （是） |
"""


def about(folder: Path, english: str, chinese: str) -> list[str]:
    found = page_lint.chinese(tree(folder, **{"a": english, "a.zh-CN": chinese}))
    return [line for line in found if not line.startswith("there is no")]


def test_a_page_and_its_translation(tmp_path: Path) -> None:
    """Words differ; and a page that is missing is named, but for those that stay English."""
    assert about(tmp_path, ENGLISH, CHINESE) == []
    tree(tmp_path, docs__safety="", docs__wire="")
    missing = [line for line in page_lint.chinese(tmp_path) if line.startswith("there is no")]
    assert missing == ["there is no README.zh-CN.md", "there is no safety.zh-CN.md"]


def test_a_chinese_text_of_a_program_is_no_name(tmp_path: Path) -> None:
    """The English page has another text there."""
    assert about(tmp_path, ENGLISH, CHINESE.replace("一 `name`", "一 `name`（`名称错误`）")) == []


def test_a_picture_has_a_twin(tmp_path: Path) -> None:
    """Where words are in it."""
    tree(tmp_path, docs__a="![a](b.svg)", **{"docs__a.zh-CN": "![甲](b.svg)"})
    assert not any("links" in line for line in page_lint.chinese(tmp_path))
    (tmp_path / "docs/b.zh-CN.svg").touch()
    assert any("other links" in line for line in page_lint.chinese(tmp_path))


@pytest.mark.parametrize(
    ("page", "broken"),
    [
        ("一段文字，\n另一行。\n", True),
        ("- 一点\n  另一行\n", True),
        ("1. 一点\n另一行\n", True),
        ("一段文字。\n\n另一段。\n- 一点\n- 另一点\n\n| 甲 |\n|---|\n| 乙 |\n", False),
        ("一段文字：\n\n    woosh demo\n    woosh sim\n\n```python\nx = 1\ny = 2\n```\n另一段\n", False),
        ("# 甲\n一段文字\n", False),
    ],
)
def test_a_line_break_inside_a_chinese_sentence(tmp_path: Path, page: str, broken: bool) -> None:
    found = list(page_lint.paragraphs(tree(tmp_path, **{"docs__a.zh-CN": page})))
    assert [line[:14] for line in found] == (["a.zh-CN.md: a "] if broken else [])


def test_a_word_that_the_glossary_rules_out(tmp_path: Path) -> None:
    """On pages, in the tables, and in the words of the web page."""
    glossary = "# A\n\n## Chinese words\n\n| a | 甲 | not |\n|---|---|---|\n| you | 您 | `你(?!好)` |\n"
    tree(tmp_path, CONTRIBUTING=glossary, **{"docs__a.zh-CN": "你好，你的。您"})
    assert list(page_lint.glossary(tmp_path)) == [
        "a.zh-CN.md: 你 is 您 here (CONTRIBUTING.md, Chinese words)"
    ]
    table = tmp_path / "woosh_pure/language/zh/b.txt"
    table.parent.mkdir(parents=True)
    table.write_text("you\n你\n", "utf-8")
    words = tmp_path / "woosh_pure/web/page/js/words_zh_c.js"
    words.parent.mkdir(parents=True)
    words.write_text('  "ask": "你",\n', "utf-8")
    assert [line[:6] for line in page_lint.glossary(tmp_path)] == ["a.zh-C", "b.txt:", "words_"]
    (tmp_path / "CONTRIBUTING.md").write_text("")
    assert list(page_lint.glossary(tmp_path)) == ["CONTRIBUTING.md has no glossary of Chinese words"]


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("# 甲", "## 甲", "headings"),
        ("- 一", "一", "points"),
        ("x = 1", "x = 2", "programs"),
        ("woosh demo", "woosh sim", "commands"),
        ("| Y （是）", "| N （不）", "tables"),
        ("一 `name`", "一 `other`", "names"),
        ("docs/safety.md", "docs/tour.md", "links"),
        ("[English](a.md)", "", "do not name each other"),
    ],
)
def test_what_a_translation_may_lack(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert old in CHINESE
    assert told in " ".join(about(tmp_path, ENGLISH, CHINESE.replace(old, new)))


def test_a_build_that_loses_code_is_noticed(tmp_path: Path) -> None:
    """Code that became text."""
    text = "# A\n\n```python robot\nx = 1\n```\n\n    woosh demo\n\nend\n"
    _, blocks = built_pages.source(text)
    assert blocks == ["x = 1\n", "woosh demo\n"]
    (tmp_path / "a.md").write_text(text)
    (tmp_path / "a.html").write_text("<article><h1>A</h1><p>```python robot x = 1</p></article>")
    assert list(built_pages.lost(tmp_path, tmp_path)) == ["a.md has other blocks of code when it is built"]
