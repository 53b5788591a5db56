"""The REST door: one module for each noun, each with a `router`. See `woosh_pure.web.build`."""

from __future__ import annotations

__all__: list[str] = []
