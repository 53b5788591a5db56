"""The topics that the chassis publishes: a `Feed` for each, and the readings of `Chassis`."""

from __future__ import annotations

from woosh_pure.feed.feed import Feed, Feeds, Reading

__all__ = ["Feed", "Feeds", "Reading"]
