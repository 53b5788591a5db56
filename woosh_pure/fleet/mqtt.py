"""The line to the broker: paho-mqtt with what the standard asks of a connection (6.2, 6.14).

The last will says CONNECTIONBROKEN, then ONLINE comes, before an orderly end OFFLINE: retained, quality 1.
All else is sent with quality 0 and is not kept while there is no broker: a state of before is no news
afterwards, and a new one goes out with the connection. paho's own thread connects, tries again with growing
waits, and calls back.

Messages that the broker has retained are not obeyed: an order of yesterday would move the robot whenever it
connects. They are counted and logged.
"""

from __future__ import annotations

import json
import ssl
import threading
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from urllib.parse import urlsplit

from rosproto.logs import get_logger

__all__ = ["Broker", "Line", "paho"]

_log = get_logger("woosh_pure.fleet.mqtt")
_KEEP_ALIVE = 15  # s, as 6.14 has it
_WAITS = (1, 30)  # s between two attempts to connect: the first, and at most
_QUEUED = 200  # messages that paho holds while they go out


def paho() -> Any:
    """paho.mqtt.client.

    Raises:
        ImportError: It is not installed; the text names the extra.
    """
    try:
        import paho.mqtt.client as client
    except ImportError as error:
        raise ImportError(
            'VDA 5050 needs paho-mqtt 2: pip install "woosh-pure[fleet]"', name="paho"
        ) from error
    return client


@dataclass(frozen=True, slots=True, repr=False)
class Broker:
    """Where the broker is and how it lets us in.

    Attributes:
        url: mqtt://host:port, or mqtts:// for TLS; never with a password in it.
        user, password: None where it asks for none.
        ca_file, cert_file, key_file: For TLS; None takes the system's authorities and no certificate of ours.
    """

    url: str
    user: str | None = None
    password: str | None = None
    ca_file: str | None = None
    cert_file: str | None = None
    key_file: str | None = None

    def __post_init__(self) -> None:
        parts = urlsplit(self.url)
        if parts.scheme not in ("mqtt", "mqtts") or not parts.hostname:
            raise ValueError(
                f"broker {_without_secrets(self.url)}: expected mqtt://HOST:PORT or mqtts://HOST:PORT"
            )
        if parts.username or parts.password:
            raise ValueError(
                "the broker's address must not hold a user or password: others on this computer see it; "
                "use $WOOSH_MQTT_USER and $WOOSH_MQTT_PASSWORD, or a file"
            )
        if not self.tls and (self.ca_file or self.cert_file or self.key_file):
            raise ValueError("certificates are for TLS: write mqtts://HOST:PORT")

    def __repr__(self) -> str:
        return f"<Broker {self.url}>"

    @property
    def tls(self) -> bool:
        """Whether the line is encrypted."""
        return urlsplit(self.url).scheme == "mqtts"

    @property
    def host(self) -> str:
        """Its name or address."""
        return urlsplit(self.url).hostname or ""

    @property
    def port(self) -> int:
        """Its port."""
        return urlsplit(self.url).port or (8883 if self.tls else 1883)


def _without_secrets(url: str) -> str:
    return url.rpartition("@")[2]


class Line:
    """One vehicle's connection with the broker.

    Args:
        broker: Where.
        prefix: Levels of the topics, "uagv/v2/Woosh/A-17".
        connection: Makes a connection message for a state: `connection("ONLINE")`.
        received: Called with topic and payload, in paho's thread; must not wait.
        changed: Called with whether the line stands, in paho's thread; must not wait.
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
        self.broker, self.prefix = broker, prefix
        self._connection, self._received, self._changed = connection, received, changed
        self._told = ""  # the last thing that went wrong: said once
        self.retained = 0
        self.connected = threading.Event()
        self._closing = False
        self._client = client = self._module.Client(
            self._module.CallbackAPIVersion.VERSION2, client_id="", protocol=self._module.MQTTv311
        )
        client.max_queued_messages_set(_QUEUED)
        client.reconnect_delay_set(*_WAITS)
        if broker.user is not None:
            client.username_pw_set(broker.user, broker.password)
        if broker.tls:
            client.tls_set(
                ca_certs=broker.ca_file, certfile=broker.cert_file, keyfile=broker.key_file,
                cert_reqs=ssl.CERT_REQUIRED,
            )  # fmt: skip
        client.on_connect = self._on_connect
        client.on_disconnect = self._on_disconnect
        client.on_connect_fail = self._on_connect_fail
        client.on_message = self._on_message
        client.on_pre_connect = self._on_pre_connect

    def open(self) -> None:
        """Begin to connect; tries until `close`."""
        self._client.connect_async(self.broker.host, self.broker.port, _KEEP_ALIVE)
        self._client.loop_start()

    def send(self, topic: str, message: dict[str, Any], *, retain: bool = False, quality: int = 0) -> bool:
        """Send a message, or drop it where there is no broker; whether it was sent."""
        if not self.connected.is_set():
            return False
        text = json.dumps(message, separators=(",", ":"))
        info = self._client.publish(f"{self.prefix}/{topic}", text, qos=quality, retain=retain)
        return bool(info.rc == self._module.MQTT_ERR_SUCCESS)

    def close(self, timeout: float = 2.0) -> None:
        """Say OFFLINE, wait for the broker to have it, leave. Bounded."""
        if self._closing:
            return
        self._closing = True
        if self.connected.is_set():
            text = json.dumps(self._connection("OFFLINE"))
            try:
                self._client.publish(f"{self.prefix}/connection", text, qos=1, retain=True).wait_for_publish(
                    timeout
                )
            except (RuntimeError, ValueError) as error:
                _log.warning("! %s: OFFLINE was not sent: %s", self.prefix, error)
        self._client.disconnect()
        self._client.loop_stop()
        self.connected.clear()

    # -- in paho's thread ------------------------------------------------------------------------------------

    def _on_pre_connect(self, client: Any, data: Any) -> None:
        will = json.dumps(self._connection("CONNECTIONBROKEN"))
        client.will_set(f"{self.prefix}/connection", will, qos=1, retain=True)

    def _on_connect(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        if reason.is_failure:
            self._tell(f"the broker {self.broker.url} refused us: {reason}")
            return
        self._told = ""
        _log.info("= %s: connected with %s", self.prefix, self.broker.url)
        client.subscribe([(f"{self.prefix}/order", 0), (f"{self.prefix}/instantActions", 0)])
        self.connected.set()
        self.send("connection", self._connection("ONLINE"), retain=True, quality=1)
        self._changed(True)

    def _on_disconnect(self, client: Any, data: Any, flags: Any, reason: Any, properties: Any) -> None:
        self.connected.clear()
        if not self._closing:
            self._tell(f"the line to the broker {self.broker.url} is lost: {reason}")
        self._changed(False)

    def _on_connect_fail(self, client: Any, data: Any) -> None:
        self._tell(f"the broker {self.broker.url} cannot be reached; it is tried again, with growing waits")

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
