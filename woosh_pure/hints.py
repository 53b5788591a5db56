"""What wrong guesses of names and arguments are answered with: the right call, in the exception's text.

Nothing is carried out for a guess. The names are those of turtle, rospy, spot-sdk, MiR and Thymio.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")

# Each line has the right call, and the guesses that mean it.
CHASSIS = """
forward(metres): drive drive_straight go_forward straight advance move_forward fd
forward(-metres): back backward backwards bk reverse move_backward
left(degrees): turn turn_left lt spin rotate_left rotate_by setheading
right(degrees): turn_right rt rotate_right
go_to_mark(name), or go_to(x, y, yaw): goto navigate navigate_to drive_to move_to go_to_pose goto_position
go_to(x, y, yaw): move_base send_goal set_goal goal setpos trajectory_command
go_to_mark(name), as on the robot's map; `woosh marks` keeps a list: marks list_marks positions waypoints
pose.latest (None before the first): position x y yaw theta heading location where pos xcor ycor odom get_pose
battery.latest.percent (None before the first): battery_level battery_percent battery_percentage get_battery
measured_velocity.latest, or under_way: is_moving moving speed get_speed get_velocity is_driving busy
stop(): halt brake emergency_stop estop freeze abort stop_all
stop(), or cancel() of the handle: cancel cancel_all cancel_goal
velocity(bypasses_protection=True): set_speed set_velocity cmd_vel motors set_motors publish motor_left_target
connected; `with Chassis(...) as chassis:` connects and closes: is_connected connect disconnect open shutdown
status.latest, or readiness(): state get_status get_state robot_state is_ready ready can_move
faults: errors error get_errors get_faults alarms
get_map(): map load_map
scan.latest: lidar laser ranges get_scan prox
camera.latest: image picture photo get_image
charge(mark), or park(mark): dock go_home home mission
light("red"): led leds set_led set_light lights color set_color leds_top pencolor
say(text): speak play_sound sound tts beep
wait_until_ready(), or wait() of the handle: wait sleep wait_for wait_for_result wait_for_server
set_pose(...): set_initial_pose localize relocalize reset_pose
plan(...): make_plan path get_path
"""
HANDLE = """
outcome (None while it runs), or wait(): result get_result state status error failed arrived cancelled
done: is_done finished is_finished completed is_active running is_running
cancel(): stop abort preempt cancel_goal
wait(timeout): join wait_for_result wait_until_done get
on_done(callback): add_done_callback then done_callback on_finish on_complete
progress: feedback get_progress eta remaining metres_left percent progress_line
"""
OUTCOME = """
arrived: success succeeded ok done
sentence(): message reason error why
kind: status state result cancelled failed
"""
FEED = """
latest.NAME, latest is None at first: percent charging x y yaw theta vx wz ranges robot_state
latest, or wait() for the next one: value get read last newest message
on(callback): subscribe callback listen add_callback
"""


class Hints:
    """Names the right call when an attribute is missing; a type checker sees nothing of it.

    A class gives its table as `_hints`. `dir`, `hasattr`, `copy` and `pickle` see no more than there is.
    """

    __slots__ = ()
    _hints = ""

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            try:
                return object.__getattribute__(self, name)  # raises again what a property raised
            except AttributeError as error:
                lines = (line.rpartition(": ") for line in self._hints.splitlines())
                right = next((right for right, _, guesses in lines if name in guesses.split()), "")
                if not right or hasattr(type(self), name):
                    raise
                raise AttributeError(f"{error}; use {right}", name=name, obj=self) from None


def usage(right: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a method: `right` is added to the TypeError of arguments that it does not take."""

    def decorate(method: Callable[P, T]) -> Callable[P, T]:
        signature = inspect.signature(method)

        @functools.wraps(method)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            try:
                signature.bind(*args, **kwargs)
            except TypeError as error:
                raise TypeError(f"{method.__name__}(): {error}; use {right}") from None
            return method(*args, **kwargs)

        return call

    return decorate
