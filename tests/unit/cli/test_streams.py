"""A command prints on any encoding."""

from __future__ import annotations

import io
import sys

import pytest

from rosproto.cli.console import as_typed, escape_what_cannot_be_printed


def test_a_character_that_the_encoding_lacks_is_put_in_ascii_or_escaped(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """cp1252, the encoding of pipes on Windows, has a degree sign and no box characters."""
    raw = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(raw, encoding="cp1252", write_through=True))
    monkeypatch.setattr(sys, "stderr", None)  # as under pythonw.exe
    escape_what_cannot_be_printed()
    print("90\u00b0 \u2514\u2500 \u8d27", end="")
    assert raw.getvalue() == b"90\xb0 `- \\u8d27"


def test_what_is_typed_in_utf_8_is_understood_in_any_locale() -> None:
    """LC_ALL=C hands bytes over as lone surrogates, which neither YAML nor a robot takes."""
    typed = "标记 é".encode().decode("ascii", "surrogateescape")
    assert as_typed([typed, "标记", "A1", "\udcff"]) == ["标记 é", "标记", "A1", "\udcff"]
