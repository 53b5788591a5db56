"""`ChunkedMessage`: a long message as a list of chunks, so that sending a map does not delay other topics.

Copying a long text blocks all other threads: fifty megabytes take a tenth of a second. A long message is
therefore made, kept and sent in chunks of half a megabyte, as the frames of one fragmented WebSocket message.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TypeVar

Whole = TypeVar("Whole", str, memoryview)

CHUNK_SIZE = 512 << 10
"""Bytes or characters handled at a time; other work runs in between."""


class ChunkedMessage:
    """One message, text or binary, that is never joined.

    Attributes:
        chunks: All `str`, or all bytes.
    """

    __slots__ = ("_length", "chunks")

    def __init__(self, chunks: Iterable[str] | Iterable[bytes | memoryview]) -> None:
        self.chunks: tuple[str | bytes | memoryview, ...] = tuple(chunks)
        self._length = sum(map(len, self.chunks))

    def __len__(self) -> int:
        """Characters or bytes in total."""
        return self._length

    def text(self) -> str:
        """The whole text, joined."""
        return "".join(chunk for chunk in self.chunks if isinstance(chunk, str))

    def __repr__(self) -> str:
        return f"<ChunkedMessage: {len(self)} in {len(self.chunks)}>"


def pieces(whole: Whole) -> Iterator[Whole]:
    """Cut a text or bytes into pieces of `CHUNK_SIZE`."""
    return (whole[at : at + CHUNK_SIZE] for at in range(0, len(whole), CHUNK_SIZE))


def framed(head: bytes, data: bytes | memoryview) -> bytes | ChunkedMessage:
    """A head followed by data: joined if short, else chunks that refer to the data without a copy."""
    if len(data) <= CHUNK_SIZE // 8:
        return head + data
    parts: list[bytes | memoryview] = [head, *pieces(memoryview(data))]
    return ChunkedMessage(parts)


def chunked(texts: Iterable[str]) -> ChunkedMessage:
    """Join texts into chunks of at most `CHUNK_SIZE` characters: long texts are cut, short ones joined."""
    return ChunkedMessage(_sized(texts))


def _sized(texts: Iterable[str]) -> Iterator[str]:
    short: list[str] = []
    length = 0
    for text in texts:
        if length + len(text) > CHUNK_SIZE and short:
            yield "".join(short)
            short, length = [], 0
        if len(text) > CHUNK_SIZE:
            yield from pieces(text)
        else:
            short.append(text)
            length += len(text)
    if short:
        yield "".join(short)
