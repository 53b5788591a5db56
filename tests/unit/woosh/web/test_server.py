"""Where the web server listens."""

from __future__ import annotations

import pytest

from rosproto.admission import ConnectionSlots
from woosh_pure.web.server import listen_at


def test_an_address_of_another_computer_is_told_from_a_port_in_use() -> None:
    with (
        listen_at("127.0.0.1", 0, ConnectionSlots(256)) as listener,
        pytest.raises(OSError, match="give another --port"),
    ):
        listen_at("127.0.0.1", listener.getsockname()[1], ConnectionSlots(256))
    with pytest.raises(OSError, match="--bind takes an address of this computer"):
        listen_at("192.0.2.1", 0, ConnectionSlots(256))  # RFC 5737: nobody has it
    with pytest.raises(OSError, match="--bind takes an address of this computer"):
        listen_at("no-such-name.invalid", 0, ConnectionSlots(256))
