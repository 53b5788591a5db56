"""Who may connect to a server, by the same rules at each: `AdmissionPolicy` (token, Host, Origin, rate of
wrong tokens), and `ConnectionSlots`, which bounds the connections that have not been admitted yet.

Which names an admitted client may read and write is decided by `rosproto.gateway.Access`.
"""

from __future__ import annotations

from rosproto.admission.policy import (
    MAX_CLIENTS,
    MIN_TOKEN,
    AdmissionPolicy,
    AdmissionRefusal,
    Header,
    basic_password,
    bearer_token,
    host_of,
    port_of,
    require_page_origin,
)
from rosproto.admission.token_bucket import MAX_ADDRESSES, AddressBuckets, TokenBucket
from rosproto.transport.connection_slots import ConnectionSlots, Key

__all__ = [
    "MAX_ADDRESSES",
    "MAX_CLIENTS",
    "MIN_TOKEN",
    "AddressBuckets",
    "AdmissionPolicy",
    "AdmissionRefusal",
    "ConnectionSlots",
    "Header",
    "Key",
    "TokenBucket",
    "basic_password",
    "bearer_token",
    "host_of",
    "port_of",
    "require_page_origin",
]
