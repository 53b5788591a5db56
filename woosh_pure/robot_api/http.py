"""`ApiRequests`: asks a robot by plain HTTP, one POST for a question, on one kept connection.

A robot may have no Robot API, or one that is slow or lies. So the first question is a short one, of
`RobotState` within `FIRST_SECONDS`; if it fails, nothing is asked for `PAUSE_SECONDS`. Each question has one
deadline over all its steps, and its answer a limit of bytes, values and depth. Nothing is asked before
somebody wants to know.
"""

from __future__ import annotations

import base64
import json
import threading
import time
from collections.abc import Mapping
from typing import Any, NamedTuple
from urllib.parse import urlsplit

from rosproto import Limits
from rosproto.errors import CodecError, ConnectionLost, RemoteProtocolError, RosError, RosTimeout, TooLarge
from rosproto.json_text import JsonError, JsonReader
from rosproto.logs import get_logger
from rosproto.sentence import led, say, sentence_of
from rosproto.text import printable
from rosproto.transport import Deadline, HostNames, HttpClient, make_uri
from woosh_pure.errors import ApiRefused
from woosh_pure.robot_api import wire

FIRST_SECONDS, PAUSE_SECONDS = 1.5, 60.0
MAX_BYTES, MAX_VALUES, MAX_NESTING = 32 << 20, 100_000, 24
_FIRST, _WEBSOCKET = "woosh.robot.RobotState", "ws://"
WANTS_PASSWORD = say("it wants a name and a password; give robot_api='user:password@host:port'")
read_json = JsonReader(MAX_VALUES, MAX_NESTING).one
_log = get_logger("woosh_pure.robot_api")


class ApiAddress(NamedTuple):
    """Where the Robot API of a robot is, and the name and password that it wants; "" if none."""

    host: str
    port: int
    user: str = ""
    password: str = ""


def api_address(given: str, host: str = "") -> ApiAddress:
    """Parse "host:port" or "user:password@host:port"; "" is the usual port of `host`.

    Raises:
        ValueError: It is not such an address.
    """
    credentials, at, place = given.strip().rpartition("@")
    user, colon, password = credentials.partition(":")
    try:
        parts = urlsplit(f"//{place}")
        found = ApiAddress(parts.hostname or host, parts.port or wire.PORT, user, password)
    except ValueError:
        found = ApiAddress("", 0)
    if not found.host or "/" in place or any(c.isspace() for c in place) or (at and not (user and colon)):
        raise ValueError("not an address of a Robot API: expected host:port, or user:password@host:port")
    return found


def only_robot_api(uri: str, given: str | bool | None = None) -> ApiAddress | None:
    """The address of a robot that has only the Robot API; None of one with a master.

    Args:
        uri: Of the robot, "ws://host:port" if it has only the Robot API.
        given: Another address, with name and password, as for `Chassis(robot_api=...)`.

    Raises:
        ValueError: One is not an address, or name and password are in `uri`, which is printed.
    """
    if not uri.startswith(_WEBSOCKET):
        return None
    found = api_address(uri.removeprefix(_WEBSOCKET).removesuffix("/"))
    if found.user:
        raise ValueError("give name and password as robot_api='user:password@host:port'")
    return api_address(given, found.host) if isinstance(given, str) else found


def authorization(address: ApiAddress) -> dict[str, str]:
    """The header with the name and password of an address; empty if it has none."""
    if not address.user:
        return {}
    secret = base64.b64encode(f"{address.user}:{address.password}".encode())
    return {"Authorization": f"Basic {secret.decode('ascii')}"}


def body_of(request: str, answer: object) -> Any:
    """The body of an answer as it came: whether a field is there may matter.

    Raises:
        ApiRefused: The robot refused.
        CodecError: It is not an answer to this request.
    """
    if not isinstance(answer, dict) or not isinstance(answer.get("ok"), bool):
        raise CodecError(say("does not say whether the robot accepts it"))
    if not answer["ok"]:
        said = answer.get("msg")
        raise ApiRefused(request, said if isinstance(said, str) else "")
    _, expected, empty = wire.requests()[request]
    if empty:
        return {}
    if answer.get("type", expected) != expected:
        raise CodecError(say("has the type {type}", type=printable(str(answer["type"])[:80])))
    return answer.get("body") or {}


class ApiRequests:
    """The questions to one robot. From any thread; they take turns."""

    def __init__(self, address: ApiAddress, hosts: HostNames | None = None) -> None:
        self._uri = make_uri(address.host, address.port)
        headers = {"Content-Type": "application/json", **authorization(address)}
        limits = Limits(xml_body_bytes=MAX_BYTES)
        self._client = HttpClient(self._uri, limits=limits, hosts=hosts, headers=headers)
        self._turn = threading.Lock()
        self._answers = False
        self._failed = -PAUSE_SECONDS, ""
        self._warned = False

    def __repr__(self) -> str:
        return f"<ApiRequests {self._uri}>"  # without the password

    def ask(
        self, request: str, body: Mapping[str, Any] | None = None, *, timeout: float = 5.0
    ) -> wire.Values:
        """Ask, and return the values of the answer's body, as `wire.load` makes them.

        Raises:
            ApiRefused: The robot refused, or wants a name and a password.
            ConnectionLost, RosTimeout: It cannot be reached or does not answer, now or in the last minute.
            RemoteProtocolError: The answer is not one of this interface.
            CodecError: The request or one of its fields does not exist.
        """
        return self.loaded(request, self.ask_raw(request, body, timeout=timeout))

    def loaded(self, request: str, answer: object) -> wire.Values:
        """The values of the answer to a request; RemoteProtocolError if it does not fit."""
        try:
            return wire.load(wire.requests()[request].answer, answer)
        except CodecError as error:
            raise self._wrong(request, sentence_of(error)) from error

    def ask_raw(self, request: str, body: Mapping[str, Any] | None = None, *, timeout: float = 5.0) -> Any:
        """As `ask`, but return the body as it came; see `body_of`."""
        if request not in wire.requests():
            raise CodecError(say("{request} is not a request of the Robot API", request=request))
        text = json.dumps(wire.dump(request, body or {}, zeros=False)).encode()
        deadline = Deadline(timeout)
        if not self._turn.acquire(timeout=timeout):
            raise deadline.error(say("{request} at {uri}", request=request, uri=self._uri))
        try:
            if not self._answers:
                self._begin(deadline)
            try:
                return self._exchange(request, text, deadline)
            except (ConnectionLost, RosTimeout):
                self._answers = False  # the next question begins with a short one again
                raise
        finally:
            self._turn.release()

    def close(self) -> None:
        """Close the connection; a question under way ends with ConnectionLost."""
        self._client.close()

    def _begin(self, deadline: Deadline) -> None:
        """Ask the first question, if the last failure was not just now."""
        at, why = self._failed
        left = at + PAUSE_SECONDS - time.monotonic()
        if why and left > 0.0:
            text = say("{error}; not asked again for {left:.0f} s", error=say(why), left=left)
            raise ConnectionLost(text, peer=self._uri, why=why)
        try:
            wire.load(_FIRST, self._exchange(_FIRST, b"{}", deadline.at_most(FIRST_SECONDS)))
        except RosError as error:
            self._failed = time.monotonic(), sentence_of(error)
            raise
        self._failed, self._answers = (at, ""), True

    def _exchange(self, request: str, text: bytes, deadline: Deadline) -> Any:
        path, once = wire.path_of(request), wire.requests()[request].kind != "read"
        try:
            response = self._client.post(request, text, deadline, path=path, retry=not once)
        except TooLarge as error:
            raise self._wrong(request, say("it has more than {limit} bytes", limit=error.limit)) from error
        except RemoteProtocolError as error:
            raise self._wrong(request, str(error)) from error
        if response.status == 401:
            raise self._locked(request)
        try:
            return body_of(request, read_json(response.body))
        except (JsonError, CodecError) as error:
            why = say("HTTP {status}, it {error}", status=response.status, error=sentence_of(error))
            raise self._wrong(request, why) from error

    def _wrong(self, request: str, why: str) -> RemoteProtocolError:
        doing = say("{request} at {uri}", request=request, uri=self._uri)
        return RemoteProtocolError(
            led(doing, say("the answer is not one of the Robot API: {why}", why=say(why)))
        )

    def _locked(self, request: str) -> ApiRefused:
        error = ApiRefused(request, "", WANTS_PASSWORD, status=401)
        if not self._warned:
            self._warned = True
            _log.warning("! %s: %s", self._uri, error)
        return error
