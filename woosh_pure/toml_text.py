"""Read TOML: by the standard library, or by tomli where Python has none (3.10)."""

from __future__ import annotations

import sys
from typing import Any

from rosproto.extras import optional_module
from rosproto.sentence import say


def toml_values(text: str, extra: str) -> dict[str, Any]:
    """Read a text.

    Args:
        extra: Of this project, which brings tomli on Python 3.10.

    Raises:
        ValueError: It is not TOML.
        ImportError: Python 3.10 without the extra.
    """
    wanted = 'a TOML file needs tomli before Python 3.11: pip install ".[{extra}]"'
    module = "tomllib" if sys.version_info >= (3, 11) else "tomli"
    library = optional_module(module, ImportError(say(wanted, extra=extra), name=module))
    values: dict[str, Any] = library.loads(text)
    return values
