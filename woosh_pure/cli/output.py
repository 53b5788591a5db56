"""Printing: plain lines for people, one JSON document for machines."""

from __future__ import annotations

import json
import sys
from typing import Any, TextIO

__all__ = ["Output"]


class Output:
    """Where a command prints.

    Attributes:
        as_json: True when only `result` may print on stdout.
    """

    def __init__(self, *, as_json: bool = False, stream: TextIO | None = None) -> None:
        self.as_json = as_json
        self._stream = stream or sys.stdout

    def line(self, text: str = "") -> None:
        """A line for people, at once visible; silent with --json."""
        if not self.as_json:
            self._write(text)

    def result(self, value: Any) -> None:
        """The document for machines; silent without --json."""
        if self.as_json:
            self._write(json.dumps(value, ensure_ascii=False, indent=2, default=_plain))

    def _write(self, text: str) -> None:
        try:
            print(text, file=self._stream, flush=True)
        except UnicodeEncodeError:  # a Windows console with an old code page
            encoding = self._stream.encoding or "ascii"
            print(text.encode(encoding, "replace").decode(encoding), file=self._stream, flush=True)


def _plain(value: Any) -> Any:
    return getattr(value, "tolist", value.__repr__)()
