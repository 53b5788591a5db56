"""Names of files for topics: every topic its own, on every system.

Windows and macOS do not tell `Scan` from `scan`, Windows has names that are devices, and what a file name
cannot hold becomes a dash: `/a/b` and `/a-b` would be one file. A topic that is not alone with its name gets
its own check sum behind it, so that the same topic has the same file whenever its bag is exported.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from zlib import crc32

from .failure import CommandError

__all__ = ["file_name", "file_names"]

LONGEST = 150
_DEVICES = re.compile(r"(?:con|prn|aux|nul|conin\$|conout\$|(?:com|lpt)[0-9])", re.IGNORECASE)


def file_name(topic: str) -> str:
    """A topic as a file name on every system: "/camera/image_raw" -> "camera-image_raw"."""
    name = re.sub(r"[^A-Za-z0-9_]+", "-", topic).strip("-") or "topic"
    if len(name) > LONGEST:
        name = name[:LONGEST]
    return f"topic-{name}" if _DEVICES.fullmatch(name) else name


def file_names(topics: Iterable[str]) -> dict[str, str]:
    """A name for each topic, no two of them alike on any system.

    Args:
        topics: All topics of a bag, also those that are not exported: names do not depend on the choice.

    Raises:
        CommandError: Two topics would have one name all the same.
    """
    names: dict[str, str] = {}
    owners: dict[str, list[str]] = {}
    # A legal name keeps the plain form; among several, the first.
    for topic in sorted(topics, key=lambda topic: (not _is_plain(topic), topic)):
        owners.setdefault(file_name(topic).lower(), []).append(topic)
    for group in owners.values():
        for number, topic in enumerate(group):
            names[topic] = file_name(topic) + (f"-{_sum(topic)}" if number else "")
    taken: dict[str, str] = {}
    for topic, name in names.items():
        other = taken.setdefault(name.lower(), topic)
        if other != topic:
            raise CommandError(
                f"{other!r} and {topic!r} would be one file, {name}; export them one by one: --topics"
            )
    return names


def _is_plain(topic: str) -> bool:
    return re.fullmatch(r"(?:/[A-Za-z0-9_]+)+", topic) is not None and len(topic) <= LONGEST


def _sum(topic: str) -> str:
    return f"{crc32(topic.encode('utf-8', 'surrogatepass')):08x}"
