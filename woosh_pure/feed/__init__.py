"""The topics that the chassis publishes: a `Feed` for each, and the readings of `Chassis`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rosproto.late import late_names

if TYPE_CHECKING:
    from woosh_pure.feed.feed import Feed, Reading
    from woosh_pure.feed.feeds import Feeds

__all__ = ["Feed", "Feeds", "Reading"]

__getattr__ = late_names(__name__, {"Feed": "feed", "Feeds": "feeds", "Reading": "feed"})
