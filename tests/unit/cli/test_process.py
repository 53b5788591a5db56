"""A command's end: its exit code, whatever interrupts it."""

from __future__ import annotations

import argparse
from collections.abc import Callable

import pytest

from rosproto.cli.exit_codes import INTERRUPTED, TERMINATED
from rosproto.cli.process import Task, run_command
from rosproto.cli.signals import Terminated
from rosproto.errors import RosError


def raises(error: BaseException) -> Callable[..., int]:
    def call(*arguments: object) -> int:
        raise error

    return call


def code_of(run: Callable[[], int], failed: Callable[[str, int], object]) -> int:
    parser = argparse.ArgumentParser()
    parser.add_argument("command")
    task = Task(run, lambda text, code: (failed(text, code), None)[1], debug=False)
    return run_command(["x"], lambda words: parser, lambda arguments: task, until_exit=False)


@pytest.mark.parametrize(
    ("interrupt", "code"), [(KeyboardInterrupt(), INTERRUPTED), (Terminated(), TERMINATED)]
)
def test_an_interrupt_while_an_error_is_told_ends_the_command_as_any_other(
    interrupt: BaseException, code: int
) -> None:
    told: list[tuple[str, int]] = []

    def failed(text: str, code: int) -> None:
        told.append((text, code))
        if len(told) == 1:
            raise interrupt

    assert code_of(raises(RosError("out of reach")), failed) == code
    assert told[1:] == [("interrupted" if code == INTERRUPTED else "terminated", code)]


def test_a_second_interrupt_while_the_first_is_told_changes_nothing() -> None:
    assert code_of(raises(KeyboardInterrupt()), raises(KeyboardInterrupt())) == INTERRUPTED
