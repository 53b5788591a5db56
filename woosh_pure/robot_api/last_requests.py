"""What a watchdog sends by the Robot API when a program has ended."""

from __future__ import annotations

import json
from typing import Any

from rosproto.transport import make_uri
from rosproto.watchdog import LastRequest
from woosh_pure.robot_api.commands import cancel_of, to_api
from woosh_pure.robot_api.http import ApiAddress, authorization
from woosh_pure.robot_api.translate import ROBOT
from woosh_pure.robot_api.wire import dump, path_of


def last_request(api: ApiAddress, name: str, message: Any, seconds: float) -> LastRequest:
    """The zero of a velocity topic, the cancel of a task or, without a message, that of an action.

    It is sent for so many seconds.
    """
    type_name, values = cancel_of(name) if message is None else to_api(name, message)
    task = getattr(message, "task_id", 0)  # the order names no task: another one is spared, unless it is 0
    return LastRequest(
        make_uri(api.host, api.port),
        path_of(type_name),
        json.dumps(dump(type_name, values)),
        path_of(ROBOT + "TaskProc"),
        () if not task else ("robotTaskId", str(task)),
        authorization(api),
        seconds,
    )
