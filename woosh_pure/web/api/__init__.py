"""The REST API: the routes of each noun, which `woosh_pure.web.application` puts together."""

from __future__ import annotations

__all__: list[str] = []
