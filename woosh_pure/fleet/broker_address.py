"""`Broker`: address and credentials (user, password, certificates) of the MQTT broker."""

from __future__ import annotations

import os
import ssl
from dataclasses import dataclass
from urllib.parse import urlsplit

from rosproto.sentence import say


@dataclass(frozen=True, slots=True, repr=False)
class Broker:
    """Address and credentials of the broker.

    Attributes:
        url: mqtt://host:port, or mqtts:// for TLS; without user and password.
        user, password: None if the broker needs none.
        ca_file, cert_file, key_file: For TLS; None uses the system's authorities and no client certificate.
    """

    url: str
    user: str | None = None
    password: str | None = None
    ca_file: str | None = None
    cert_file: str | None = None
    key_file: str | None = None

    def __post_init__(self) -> None:
        expected = f"broker {_without_secrets(self.url)}: expected mqtt://HOST:PORT or mqtts://HOST:PORT"
        try:
            parts = urlsplit(self.url)
            port = parts.port
        except ValueError as error:
            raise ValueError(say("{expected} ({error})", expected=expected, error=error)) from None
        beside = parts.path.strip("/") or parts.query or parts.fragment
        if parts.scheme not in ("mqtt", "mqtts") or not parts.hostname or beside or port == 0:
            raise ValueError(expected)
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
        """Whether the connection is encrypted."""
        return urlsplit(self.url).scheme == "mqtts"

    @property
    def host(self) -> str:
        """Host name or address."""
        return urlsplit(self.url).hostname or ""

    @property
    def port(self) -> int:
        """The port; 1883, or 8883 for TLS, if the URL has none."""
        return urlsplit(self.url).port or (8883 if self.tls else 1883)


def _without_secrets(url: str) -> str:
    return url.rpartition("@")[2]


def load_certificates(context: ssl.SSLContext, broker: Broker) -> None:
    """Load the certificate files.

    Raises:
        OSError: A file cannot be read.
        ValueError: A file is not a certificate, or the key does not match.
    """
    for name in (broker.ca_file, broker.cert_file, broker.key_file):
        if name:
            os.stat(name)  # its error names the file; that of the context does not
    try:
        if broker.ca_file is not None:
            context.load_verify_locations(broker.ca_file)
        if broker.cert_file is not None:
            context.load_cert_chain(broker.cert_file, broker.key_file)
    except ssl.SSLError as error:
        files = ", ".join(name for name in (broker.ca_file, broker.cert_file, broker.key_file) if name)
        raise ValueError(
            say("the certificates in {files} cannot be used: {error}", files=files, error=error)
        ) from error


def tls_context(broker: Broker) -> ssl.SSLContext:
    """A TLS context with the certificates of the broker, or of the system; raises as `load_certificates`."""
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
    if broker.ca_file is None:
        context.load_default_certs()
    load_certificates(context, broker)
    return context
