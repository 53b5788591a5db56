"""Services that several tests provide."""

from __future__ import annotations

from typing import Any

from rosproto.codec import service_class

SetBool = service_class("std_srvs/SetBool")
Trigger = service_class("std_srvs/Trigger")


def tell(request: Any) -> Any:
    """Answers std_srvs/SetBool."""
    return SetBool.Response(success=request.data, message=f"data={request.data}")
