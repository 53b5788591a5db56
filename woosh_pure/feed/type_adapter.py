"""Decodes a topic with our definition when the program has already subscribed to it with another definition.

A node has one definition per topic. If the program subscribed first, with a type from its own folders, it
receives messages of that type, and ours are decoded from the same bytes.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from rosproto.errors import Md5sumMismatch, RosError
from rosproto.logs import get_logger
from rosproto.node import Node, TopicType, UnconvertibleMessage, revised_type

_log = get_logger("woosh_pure")


class TypeAdapter:
    """A callback for raw messages that passes them on as messages of our class.

    Args:
        ours: The class.
        node: Its revisions are used when the publisher's definition is another one.
        receive: Called with each message that can be decoded; the others are skipped, with one warning.
    """

    def __init__(self, ours: Any, node: Node, receive: Callable[[Any], object]) -> None:
        self._ours = TopicType(ours)
        self._node = node
        self._receive = receive
        self._md5sum = ""
        self._decode: Callable[..., Any] | None = None
        self._told = False

    def __call__(self, raw: Any) -> None:
        header = raw._connection_header
        if header.get("md5sum") != self._md5sum:
            self._md5sum = header.get("md5sum", "")
            self._decode = self._decoder(header)
        if self._decode is None:
            return
        message = self._decode(raw._buff, 0, len(raw._buff))
        if isinstance(message, UnconvertibleMessage):
            self._tell(message.error)
            return
        message._connection_header = header
        self._receive(message)

    def _decoder(self, header: dict[str, str]) -> Callable[..., Any] | None:
        ours = self._ours
        if self._md5sum == ours.md5sum:
            return ours.decode
        mismatch = Md5sumMismatch(
            f"{header.get('callerid')} sends md5sum {self._md5sum}, expected {ours.md5sum}",
            name=ours.name,
            type_name=ours.name,
            md5sum=ours.md5sum,
            remote_type=header.get("type", ""),
            remote_md5sum=self._md5sum,
        )
        try:
            definition = header.get("message_definition", "")
            return revised_type(self._node.definitions, ours, self._md5sum, definition, mismatch).decode
        except RosError as error:
            self._tell(error)
            return None

    def _tell(self, error: RosError) -> None:
        if not self._told:
            self._told = True
            _log.warning("! %s: messages are left out that do not fit: %s", self._ours.name, error)
