"""The libraries of the extra `web`, imported when they are first used. If one is missing, the error names the
extra.
"""

from __future__ import annotations

from typing import Any

from rosproto.extras import optional_module
from rosproto.sentence import say


def require() -> None:
    """Check that all of them are installed.

    Raises:
        ImportError: One is missing; the message says what to install.
    """
    for module in ("fastapi", "uvicorn", "websockets"):
        _load(module)


def pillow() -> Any:
    """`PIL.Image`.

    Raises:
        ImportError: It is missing; the message says what to install.
    """
    return _load("PIL.Image")


def segno() -> Any:
    """`segno`, which draws QR codes.

    Raises:
        ImportError: It is missing; the message says what to install.
    """
    return _load("segno")


def _load(module: str) -> Any:
    name = module.partition(".")[0]
    missing = say('the page and the REST API need {name}: pip install ".[web]"', name=name)
    return optional_module(module, ImportError(missing, name=name))
