"""`Publishing` without a network: what a robot that lies can have published."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, cast

from rosproto.node import Publisher
from woosh_pure.api_bridge.publishing import CODES, DEVICE, MAX_FAULTS, Publishing
from woosh_pure.robot_api.translate import COUNT
from woosh_pure.robot_api.wire import load

PRESSED = 110201000013


def test_a_robot_with_very_many_faults_hides_no_emergency_stop() -> None:
    sent: list[int] = []
    codes: Any = SimpleNamespace(closed=False, publish=lambda data: sent.append(data))
    known = Publishing(lambda row: cast(Publisher, codes) if row == CODES else None)
    known.take(DEVICE, load(DEVICE, {"hardware": 1024}))
    faults = [{"code": code} for code in range(10**15, 10**15 + 5000)]
    known.take(COUNT + "AbnormalCodes", load(COUNT + "AbnormalCodes", {"scs": faults}))
    sent.clear()
    known.repeat()
    assert (len(sent), PRESSED in sent) == (MAX_FAULTS + 1, True)
