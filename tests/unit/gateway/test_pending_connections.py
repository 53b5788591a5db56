"""The listening socket of a gateway."""

from __future__ import annotations

import sys
from collections import Counter

import pytest

from rosproto.gateway.pending_connections import Listener


@pytest.mark.skipif(sys.platform == "darwin", reason="the BSDs let a wildcard listen beside one address")
def test_no_other_server_listens_on_all_addresses_of_the_port() -> None:
    """Windows would let it, if the socket did not ask to have the port alone."""
    with Listener("127.0.0.1", 0, 8, Counter()) as listener, pytest.raises(OSError):
        Listener("0.0.0.0", listener.getsockname()[1], 8, Counter())
