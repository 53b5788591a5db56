"""docs/commands.md and the pages in docs/commands/ are what `--help` says."""

from __future__ import annotations

from pathlib import Path

import pytest

from rosproto.cli.entry import COMMANDS as ROSPROTO
from tools import manual
from woosh_pure.cli.commands import COMMANDS as WOOSH

DOCS = Path(__file__).resolve().parents[3] / "docs"


def test_the_pages_are_current() -> None:
    """After a change of a command: python -m tools.manual. A page of a group that has gone is removed by hand."""
    assert manual.DOCS == DOCS
    pages = manual.manual()
    found = [DOCS / "commands.md", *(DOCS / "commands").iterdir()]
    written = {path.relative_to(DOCS).as_posix(): path.read_text(encoding="utf-8") for path in found}
    assert written == pages, "run: python -m tools.manual"


def test_every_command_has_one_section_which_the_index_links() -> None:
    pages = manual.manual()
    for prog, names in (("woosh", WOOSH), ("rosproto", ROSPROTO)):
        for name in names:
            [page] = [page for page, text in pages.items() if f"\n## {prog} {name}\n" in text]
            assert f"({page}#{prog}-{name})" in pages["commands.md"]
        assert len(names) == sum(len(group.commands) for group in manual.GROUPS if group.prog == prog)


@pytest.mark.parametrize(("name", "language"), manual.ALL_COMMANDS.items())
def test_the_table_of_all_commands_is_current(name: str, language: str) -> None:
    """Made from the lines that `woosh --help` prints in this language."""
    text = (DOCS / name).read_text(encoding="utf-8")
    assert text == manual.with_table(text, language), "run: python -m tools.manual"


def test_check_reports_an_old_page(tmp_path, monkeypatch, capsys) -> None:
    for name in manual.ALL_COMMANDS:
        (tmp_path / name).write_text((DOCS / name).read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(manual, "DOCS", tmp_path)
    assert manual.main(["--check"]) == 1
    assert manual.main([]) == 0
    assert manual.main(["--check"]) == 0
    assert "current" in capsys.readouterr().out
