"""Rows of the interface table as a chassis serves them: a simulated one, or one behind another door."""

from __future__ import annotations

from woosh_pure.served_graph.graph import ServedGraph

__all__ = ["ServedGraph"]
