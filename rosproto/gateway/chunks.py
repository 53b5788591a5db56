"""Long messages in parts, as they are sent: a map is nowhere in one piece, so that nobody waits for it.

While Python copies a long text nothing else of the program runs: fifty megabytes are a tenth of a second, for
the robot's other topics, too. So a long message is made, kept and sent in parts of half a megabyte. A client
does not see the parts: they are the frames of one fragmented WebSocket message.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

__all__ = ["PIECE", "Pieces", "pieces_of"]

PIECE = 512 << 10
"""Bytes, or characters, that are handled at once; between them others have their turn."""


class Pieces:
    """One message, text or binary, in parts.

    Attributes:
        parts: All `str`, or all bytes.
    """

    __slots__ = ("_length", "parts")

    def __init__(self, parts: Iterable[str] | Iterable[bytes | memoryview]) -> None:
        self.parts: tuple[str | bytes | memoryview, ...] = tuple(parts)
        self._length = sum(map(len, self.parts))

    def __len__(self) -> int:
        """Characters, or bytes, in all."""
        return self._length

    def text(self) -> str:
        """The text in one piece, for what cannot do without."""
        return "".join(part for part in self.parts if isinstance(part, str))

    def __repr__(self) -> str:
        return f"<Pieces: {len(self)} in {len(self.parts)}>"


def pieces_of(texts: Iterable[str]) -> Pieces:
    """Texts behind one another, in parts of `PIECE` characters: long ones are cut, short ones joined."""
    return Pieces(_sized(texts))


def _sized(texts: Iterable[str]) -> Iterator[str]:
    short: list[str] = []
    length = 0
    for text in texts:
        if length + len(text) > PIECE and short:
            yield "".join(short)
            short, length = [], 0
        if len(text) > PIECE:
            yield from (text[at : at + PIECE] for at in range(0, len(text), PIECE))
        else:
            short.append(text)
            length += len(text)
    if short:
        yield "".join(short)
