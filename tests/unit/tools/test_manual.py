"""docs/commands.md is what `--help` says."""

from __future__ import annotations

import re
from pathlib import Path

from rosproto.cli.entry import COMMANDS as ROSPROTO
from tools import manual
from woosh_pure.cli.commands import COMMANDS as WOOSH

PAGE = Path(__file__).resolve().parents[3] / "docs" / "commands.md"


def test_the_page_is_current() -> None:
    """After a change of a command: python -m tools.manual."""
    assert manual.page == PAGE
    assert PAGE.read_text(encoding="utf-8") == manual.manual(), "run: python -m tools.manual"


def test_every_command_has_its_section() -> None:
    text = manual.manual()
    for prog, names in (("woosh", WOOSH), ("rosproto", ROSPROTO)):
        for name in names:
            assert f"\n### {prog} {name}\n" in text
            assert f"(#{prog}-{name})" in text


def test_the_table_of_all_commands_is_current() -> None:
    """Made from the same help lines; the Chinese page names the same commands in its own words."""
    text = manual.glance.read_text(encoding="utf-8")
    assert text == manual.with_table(text), "run: python -m tools.manual"
    chinese = PAGE.with_name("all-commands.zh-CN.md").read_text(encoding="utf-8")
    missing = [
        name for name in (*WOOSH, *ROSPROTO) if not re.search(rf"`((woosh|rosproto) )?{name}[` ]", chinese)
    ]
    assert missing == []


def test_check_tells_an_old_page(tmp_path, monkeypatch, capsys) -> None:
    monkeypatch.setattr(manual, "page", tmp_path / "docs" / "commands.md")
    (tmp_path / "all-commands.md").write_text(manual.glance.read_text(encoding="utf-8"), encoding="utf-8")
    monkeypatch.setattr(manual, "glance", tmp_path / "all-commands.md")
    assert manual.main(["--check"]) == 1
    assert manual.main([]) == 0
    assert manual.main(["--check"]) == 0
    assert "current" in capsys.readouterr().out
