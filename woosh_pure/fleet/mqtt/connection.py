"""A vehicle's connection with the broker: paho-mqtt, with what the standard asks for (6.2, 6.14).

The last will says CONNECTIONBROKEN; ONLINE follows the connection, and OFFLINE comes before an orderly end:
all three retained, with quality of service 1. Everything else is sent with quality 0 and is not kept while
there is no broker: an old state is no news afterwards, and a new one goes out with the connection. So each
connection gets a paho client of its own, which inherits nothing from the one before. One thread drives the
clients of all vehicles (`loop.py`).

The client id is derived from the vehicle's topics and never changes: a broker that still holds a broken
connection closes it when the next one arrives, and publishes its CONNECTIONBROKEN before our ONLINE.

When a broker accepts connections but does not read, a bounded number of messages waits (`outbox.py`); the
rest is dropped and counted, and a new state follows once it reads again. A broker that does not answer a
ping is given up.

Messages that the broker has retained are not obeyed: yesterday's order would move the robot whenever it
connects. They are counted and logged.
"""

from __future__ import annotations

import functools
import hashlib
import json
import math
import selectors
import socket
import ssl
import threading
import time
from collections.abc import Callable, Hashable
from typing import Any

from rosproto.logs import get_logger
from rosproto.transport import Backoff
from woosh_pure.fleet.messages.schema import MOST_BYTES
from woosh_pure.fleet.mqtt.broker import Broker, tls_context
from woosh_pure.fleet.mqtt.client import client_class, paho
from woosh_pure.fleet.mqtt.loop import Loop, shared_loop
from woosh_pure.fleet.mqtt.outbox import MOST_WAITING, Outbox

__all__ = ["BrokerConnection"]

_log = get_logger("woosh_pure.fleet.mqtt.connection")
_KEEP_ALIVE = 15  # s, as 6.14 has it
_PING_MARGIN = 0.05  # s after which paho is sure to find that the time of a ping is here
_SENT_AWAY = (1.0, 2.0, 30.0, 0.5)  # the waits of a connection that a broker accepts and does not keep
_STOOD = 2.0  # s after which a connection that breaks begins anew with short waits
_MOST_PENDING = 100  # packets of one connection that are read before the next has its turn
_MOST_PACKET = MOST_BYTES + 65_600  # a message and its topic
_END_SECONDS = 1.0  # for the broker to have our farewell


class BrokerConnection:
    """One vehicle's connection with the broker.

    Args:
        broker: Where.
        prefix: Levels of the topics, "uagv/v2/Woosh/A-17".
        connection: Makes a connection message for a state: `connection("ONLINE")`.
        received: Called with topic and payload, in the loop's thread; must not wait.
        changed: Called with whether it is connected, in the loop's thread, and with True once more when
            what was sent meanwhile was dropped; must not wait.

    Raises:
        ImportError: paho-mqtt is not installed; the text names the extra.
        ValueError: What is in the files is no certificate, or the key of another.
        OSError: A certificate cannot be read.
    """

    def __init__(
        self,
        broker: Broker,
        prefix: str,
        connection: Callable[[str], dict[str, Any]],
        received: Callable[[str, bytes], object],
        changed: Callable[[bool], object],
    ) -> None:
        self._module = paho()
        if broker.tls:
            try:
                tls_context(broker)  # what is wrong with the files is said now, and not in a thread later
            except ssl.SSLError as error:
                files = ", ".join(
                    name for name in (broker.ca_file, broker.cert_file, broker.key_file) if name
                )
                raise ValueError(f"the certificates in {files} cannot be used: {error}") from error
        self.broker, self.prefix = broker, prefix
        self._connection, self._received, self._changed = connection, received, changed
        self._told = ""  # the last thing that went wrong: said once
        self.retained = 0
        self.dropped = 0
        self.connected = threading.Event()
        self._gone = threading.Event()
        self._closing = False
        self._loop: Loop | None = None
        self._client: Any = None
        self._lock = threading.Lock()
        self._io = threading.RLock()  # held by who reads or writes: TLS allows one at a time
        self._outbox = Outbox()
        self._behind = False
        self._refused = ""
        self._since = math.inf  # when it was connected
        self._heard = self._wrote = 0.0
        self._sent_away = Backoff(*_SENT_AWAY)

    def __repr__(self) -> str:
        return f"<BrokerConnection {self.prefix} to {self.broker.url}>"

    def open(self) -> None:
        """Begin to connect, and keep trying until `close`."""
        if self._loop is None and not self._closing:
            self._loop = shared_loop(self)

    def send(self, topic: str, message: dict[str, Any], *, retain: bool = False, quality: int = 0) -> bool:
        """Send a message, or drop it where there is no broker, or one that does not read; whether it was
        sent."""
        client, loop = self._client, self._loop
        if client is None or loop is None or not self.connected.is_set():
            return False
        payload = json.dumps(message, separators=(",", ":")).encode()
        with self._lock:
            if not self._outbox.has_room(len(payload)):
                self.dropped += 1
                first, self._behind = not self._behind, True
                sent = False
            else:
                info = client.publish(f"{self.prefix}/{topic}", payload, qos=quality, retain=retain)
                sent, first = info.rc == self._module.MQTT_ERR_SUCCESS, False
                if sent and quality == 0:
                    self._outbox.add(info, len(payload))
        if first:
            self._tell(f"the broker {self.broker.url} does not read: what is sent is dropped until it does")
        if not (loop.inside or self._written(client)):
            loop.call(functools.partial(self._flush, client))
        return bool(sent)

    def _written(self, client: Any) -> bool:
        """Write in the caller's thread if that is possible at once: the loop's thread may be busy."""
        if self._behind or not self._io.acquire(blocking=False):
            return False
        try:
            client.loop_write()
            self._wrote = time.monotonic()
            return not client.want_write() and client.socket() is not None
        finally:
            self._io.release()

    def close(self, timeout: float = 2.0) -> None:
        """Say OFFLINE, wait for the broker to have it, leave. Bounded."""
        if self._closing:
            return
        self._closing = True
        loop, client = self._loop, self._client
        if loop is None:
            return
        if client is not None and self.connected.is_set():
            text = json.dumps(self._connection("OFFLINE"))
            try:
                info = client.publish(f"{self.prefix}/connection", text, qos=1, retain=True)
                loop.call(functools.partial(self._flush, client))
                info.wait_for_publish(timeout)
            except (RuntimeError, ValueError) as error:
                _log.warning("! %s: OFFLINE was not sent: %s", self.prefix, error)
        loop.call(self._say_farewell)
        self._gone.wait(_END_SECONDS)
        loop.call(self._leave)
        self.connected.clear()

    # -- what the loop asks ----------------------------------------------------------------------------------

    @property
    def broker_address(self) -> Hashable:
        """Connections to one broker take turns."""
        return (self.broker.host, self.broker.port)

    @property
    def due(self) -> float:
        """When paho has to check whether a ping is due, or was not answered."""
        if self._client is None:
            return math.inf
        return min(self._heard, self._wrote) + _KEEP_ALIVE + _PING_MARGIN

    def connect(self) -> Any:
        """Return a client with an open socket that has sent its CONNECT; runs in a thread of its own."""
        broker = self.broker
        client = client_class()(
            self._module.CallbackAPIVersion.VERSION2, client_id=self._name(),
            protocol=self._module.MQTTv311, reconnect_on_failure=False,
        )  # fmt: skip
        client.max_queued_messages_set(MOST_WAITING)
        if broker.user is not None:
            client.username_pw_set(broker.user, broker.password)
        if broker.tls:
            client.tls_set_context(tls_context(broker))
        will = json.dumps(self._connection("CONNECTIONBROKEN"))
        client.will_set(f"{self.prefix}/connection", will, qos=1, retain=True)
        client.on_connect = self._on_connect
        client.on_disconnect = self._on_disconnect
        client.on_message = self._on_message
        client.on_socket_close = self._on_socket_close
        client.on_socket_register_write = _ignore  # else paho writes in the thread of whoever publishes
        client.connect(broker.host, broker.port, _KEEP_ALIVE)
        # A state that follows another one at once would wait 40 ms for the broker's acknowledgement.
        client.socket().setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        return client

    def _name(self) -> str:
        """The client id: at most 23 letters and digits, which every broker accepts."""
        return "woosh" + hashlib.sha256(self.prefix.encode()).hexdigest()[:16]

    def opened(self, client: Any) -> None:
        """A connection is open; the broker has not answered yet."""
        if self._closing:
            client.socket().close()
            return
        self._client = client
        self._heard = self._wrote = time.monotonic()
        self._refused, self._since = "", math.inf
        with self._lock:
            self._outbox.clear()
            self._behind = False
        self._flush(client)

    def failed(self, error: Exception) -> None:
        """No connection could be opened."""
        if self._closing or self._loop is None:
            return
        text = str(error) or type(error).__name__
        self._tell(f"the broker {self.broker.url} cannot be reached: {text}; it is tried again and again")
        self._again(there=isinstance(error, ssl.SSLError))

    def serve(self, events: int) -> None:
        """Its socket can be read or written."""
        client = self._client
        if client is None:
            return
        with self._io:
            if events & selectors.EVENT_READ:
                self._read(client)
            if client is self._client:
                self._flush(client)

    def on_due(self) -> None:
        """Let paho send a ping, or give up a broker that has not answered the last one."""
        client = self._client
        if client is not None:
            with self._io:
                client.loop_misc()
                self._heard = self._wrote = time.monotonic()
                if client is self._client:
                    self._flush(client)

    def broken(self) -> None:
        """Our own code has failed: drop the connection and make a new one."""
        self._drop()
        self._lost("", ours="the connection is made anew after a failure of our own")

    # -- in the loop's thread --------------------------------------------------------------------------------

    def _read(self, client: Any) -> None:
        client.loop_read()
        sock = client.socket()
        pending = getattr(sock, "pending", None)  # TLS has read more from the socket than it has given out
        for _ in range(_MOST_PENDING):
            if pending is None or client.socket() is not sock or not pending():
                break
            client.loop_read()
        self._heard = time.monotonic()
        size = client.incoming  # looked at before the rest has come
        if size > _MOST_PACKET and client is self._client:
            self._drop()
            self._lost(
                "",
                ours=f"a message of {size} bytes came, longer than {MOST_BYTES}: the connection is made anew",
            )

    def _flush(self, client: Any) -> None:
        """Write what waits, and wait for the socket where it does not take all."""
        if client is not self._client or self._loop is None:
            return
        if client.want_write():
            with self._io:
                client.loop_write()
            self._wrote = time.monotonic()
        sock = client.socket()
        if client is not self._client or sock is None:
            return
        waits = client.want_write()
        events = selectors.EVENT_READ | (selectors.EVENT_WRITE if waits else 0)
        self._loop.watch(self, sock, events)
        if self._behind and not waits:
            with self._lock:
                self._behind = False
            self._told = ""
            _log.info("= %s: the broker %s reads again", self.prefix, self.broker.url)
            self._changed(True)

    def _say_farewell(self) -> None:
        client = self._client
        if client is None or not self.connected.is_set():
            self._gone.set()
            return
        client.disconnect()
        self._flush(client)

    def _leave(self) -> None:
        self._drop()
        if self._loop is not None:
            self._loop.leave(self)

    def _drop(self) -> None:
        """Close the socket without a DISCONNECT."""
        client, self._client = self._client, None
        if client is not None and (sock := client.socket()) is not None:
            self._on_socket_close(client, None, sock)
            sock.close()

    def _on_socket_close(self, client: Any, data: Any, sock: Any) -> None:
        if self._loop is not None:
            self._loop.unwatch(sock)

    def _on_connect(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        if reason.is_failure:
            self._refused = str(reason)
            return
        assert self._loop is not None
        self._told = ""
        _log.info("= %s: connected with %s", self.prefix, self.broker.url)
        self._since = time.monotonic()
        self._loop.attempts(self).succeeded(self)
        client.subscribe([(f"{self.prefix}/order", 0), (f"{self.prefix}/instantActions", 0)])
        self.connected.set()
        self.send("connection", self._connection("ONLINE"), retain=True, quality=1)
        self._changed(True)

    def _on_disconnect(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        if self._loop is None or self._loop.inside:
            self._ended(client, str(reason))
        else:
            self._loop.call(lambda: self._ended(client, str(reason)))

    def _ended(self, client: Any, reason: str) -> None:
        if client is self._client:
            self._lost(reason)

    def _lost(self, reason: str, *, ours: str = "") -> None:
        """The connection has ended, for the broker's reason or ours; another try is asked for."""
        stood, stands = time.monotonic() - self._since, self.connected.is_set()
        self._client = None
        self.connected.clear()
        if self._closing:
            self._gone.set()
        elif ours:
            self._tell(ours)
            self._again(there=True)
        elif self._refused:
            self._tell(f"the broker {self.broker.url} refused us: {self._refused}")
            self._again(there=True)
        elif not stands:
            self._tell(f"the broker {self.broker.url} took the connection and did not answer: {reason}")
            self._again(there=False, wait=self._sent_away.next())
        elif stood < _STOOD:
            self._tell(
                f"the broker {self.broker.url} ended the connection as soon as it stood: {reason}; does "
                f"another process say that it is {self.prefix}?"
            )
            self._again(there=True)
        else:
            self._tell(f"the connection with the broker {self.broker.url} is lost: {reason}")
            self._sent_away.reset()
            self._again(there=True, wait=0.0)
        if stands:
            self._changed(False)

    def _again(self, *, there: bool, wait: float | None = None) -> None:
        """Ask for another try: at once, or after a wait of its own where the broker sends it away."""
        assert self._loop is not None
        now = time.monotonic()
        if wait is None:
            wait = self._sent_away.next() if there else 0.0
        attempts = self._loop.attempts(self)
        attempts.failed(self, now, there=there)
        attempts.request(self, now + wait)

    def _on_message(self, client: Any, data: Any, message: Any) -> None:
        topic = message.topic.rpartition("/")[2]
        if message.retain:
            self.retained += 1
            _log.warning("! %s: a retained message on %s is not obeyed; clear it", self.prefix, topic)
            return
        self._received(topic, message.payload)

    def _tell(self, text: str) -> None:
        if text != self._told:
            self._told = text
            _log.warning("! %s: %s", self.prefix, text)


def _ignore(*given: object) -> None:
    """A connection tells the loop itself when it has something to write."""
