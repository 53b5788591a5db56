"""The table of contents of a bag, however it was found."""

from __future__ import annotations

from dataclasses import dataclass, field

from rosproto.bag.records import MAGIC, ChunkInfo, Connection

__all__ = ["BagIndex"]


@dataclass(slots=True)
class BagIndex:
    """Table of contents.

    Attributes:
        connections: By id.
        chunks: In file order.
        end: Position behind the last record of the chunks, where the index section begins if there is one.
        damage: What was wrong, in words with positions; empty for a sound bag.
        closed: True when the bag's own index was used.
        resumed: True when a scan met damage and continued after it, or had to leave messages out.
        lost: True when messages before the end of the file are missing, as far as a scan can tell.
        version: Of the format, "2.0" as a rule; nothing else is known to differ in another 2.x.
        head: Position of the file header, behind the version line.
    """

    connections: dict[int, Connection] = field(default_factory=dict)
    chunks: list[ChunkInfo] = field(default_factory=list)
    end: int = 0
    damage: list[str] = field(default_factory=list)
    closed: bool = False
    resumed: bool = False
    lost: bool = False
    version: str = "2.0"
    head: int = len(MAGIC)

    def spans(self) -> dict[int, int]:
        """Bytes from each chunk's position to the next chunk (or the end of the chunks)."""
        positions = sorted(chunk.pos for chunk in self.chunks)
        return {a: b - a for a, b in zip(positions, [*positions[1:], self.end], strict=False)}
