"""Counts in sentences, and that no command says "1 problems" again."""

from __future__ import annotations

import re
from pathlib import Path

from rosproto.cli.console import counted

ROOT = Path(__file__).resolve().parents[3]
PLURAL = re.compile(
    r"\{[^{}]+\} (of \{[^{}]+\} )?(messages|problems|points|rays|bytes|nodes|publishers|topics|bags|"
    r"frames|marks|files|findings|levels)\b"
)


def test_one_is_singular() -> None:
    assert counted(1, "problem") == "1 problem"
    assert [counted(n, "problem") for n in (0, 2)] == ["0 problems", "2 problems"]
    assert counted(2, "try", "tries") == "2 tries"


def test_no_command_counts_by_itself() -> None:
    """What is printed goes through `counted`: a bare "{n} messages" says "1 messages" some day.

    A template for one stands in the same file as the template for several.
    """
    found = [
        f"{path.relative_to(ROOT)}: {match[0]}"
        for folder in ("rosproto/cli", "woosh_pure/cli")
        for path in sorted((ROOT / folder).rglob("*.py"))
        for text in [path.read_text("utf-8")]
        for line in text.splitlines()
        if '"""' not in line and (match := PLURAL.search(line)) and f'"{match[0][:-1]}"' not in text
    ]
    assert found == []
