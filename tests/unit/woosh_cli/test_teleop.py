"""What keys mean for a drive."""

from __future__ import annotations

import pytest

from woosh_pure.cli.commands.drive import VALID_FOR, Press, Teleop


def test_directions() -> None:
    teleop = Teleop(0.2, 0.4)
    assert teleop.press([]) is None
    assert teleop.press(["up"]) == teleop.press(["w"]) == Press(0.1, 0.0)
    assert teleop.press(["s"]) == Press(-0.1, 0.0)
    assert teleop.press(["left"]) == Press(0.0, 0.2)
    assert teleop.press(["d"]) == Press(0.0, -0.2)
    assert teleop.press(["up", "up", "left"]) == Press(0.0, 0.2)


@pytest.mark.parametrize("other", [" ", "x", "other", "5", "é", "+", "-"])
def test_every_other_key_stops_in_whatever_order_it_comes(other) -> None:
    teleop = Teleop(0.2, 0.4)
    for keys in ([other], ["up", other], [other, "up"], ["up", other, "up", "up"]):
        command = teleop.press(keys)
        assert command is not None
        assert not command.moves
        assert not command.quit


@pytest.mark.parametrize("key", ["q", "escape"])
def test_leaving_wins(key) -> None:
    assert Teleop(0.2, 0.4).press(["up", key, "up"]) == Press(quit=True)


def test_speed_in_steps_and_never_beyond_the_full_speed() -> None:
    teleop = Teleop(0.2, 0.4)
    for _ in range(9):
        teleop.press(["+"])
    assert teleop.press(["up"]) == Press(0.2, 0.0)
    for _ in range(9):
        teleop.press(["-"])
    assert teleop.press(["up"]) == Press(0.05, 0.0)


def test_a_key_is_good_for_less_than_four_tenths_of_a_second() -> None:
    assert VALID_FOR + 2 / 20.0 <= 0.4  # and two rounds of the 20 Hz at which velocities are sent
