"""The optional library, imported with its first use."""

from __future__ import annotations

from typing import Any

from rosproto.errors import BagError

__all__ = ["pyarrow"]


def pyarrow() -> Any:
    """The module.

    Raises:
        BagError: It is not installed; names the extra.
    """
    try:
        import pyarrow as module
    except ImportError as problem:
        raise BagError('tables need the package pyarrow: pip install ".[arrow]"') from problem
    return module
