"""A folder of a message package, for tests."""

from __future__ import annotations

from pathlib import Path

__all__ = ["package"]


def package(folder: Path, **files: str) -> Path:
    """A package folder; `msg_Foo="int8 a"` is msg/Foo.msg."""
    for key, text in files.items():
        kind, _, base = key.partition("_")
        (folder / kind).mkdir(parents=True, exist_ok=True)
        (folder / kind / f"{base}.{kind}").write_text(text)
    return folder
