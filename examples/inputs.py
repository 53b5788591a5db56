"""Digital inputs: the keys of the chassis, as messages."""

from _robot import robot

with robot() as chassis:
    message = chassis.feed("inputs").wait(timeout=5)
    for line in message.IOs:
        print(
            f"module {line.module}.{line.submodule}, line {line.id}:",
            ("default", "triggered", "stopped")[line.status],
        )
