"""What wrong guesses of names, arguments and commands are answered with: the right one, in the error's text.

Nothing is carried out for a guess. The names are those of turtle, rospy, spot-sdk, MiR and Thymio.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NoReturn, ParamSpec, TypeVar

from rosproto.sentence import both, say

P = ParamSpec("P")
T = TypeVar("T")

# Each line has the right call, and the guesses that mean it; upper case and underscores do not matter. The
# guess itself is put in place of GUESS.
CHASSIS = """
forward(metres): go drive drive_straight go_forward straight advance move_forward fd
forward(-metres): back backward backwards bk reverse move_backward
left(degrees): turn turn_left lt spin rotate_left rotate_by setheading
right(degrees): turn_right rt rotate_right
go_to_mark(name), or go_to(x, y, yaw): goto navigate navigate_to drive_to move_to go_to_pose goto_position
go_to(x, y, yaw): move_base send_goal set_goal goal setpos trajectory_command
go_to_mark(name), as on the robot's map; `woosh marks` keeps a list: marks get_marks list_marks positions
go_to_mark(name), as on the robot's map; `woosh marks` keeps a list: waypoints
pose.wait(timeout=5), or pose.latest: position x y yaw theta heading location where pos xcor ycor
pose.wait(timeout=5), or pose.latest: odom get_pose get_position coordinates
battery.wait(timeout=5).percent: battery_level battery_percent battery_percentage get_battery
measured_velocity.wait(timeout=5), or under_way: is_moving moving speed get_speed get_velocity is_driving busy
stop(): halt brake emergency_stop estop freeze abort stop_all
stop(); a simulation is reset by sim.reset() or on its page: reset restart
stop(), or cancel() of the handle: cancel cancel_all cancel_goal
stop(), or pause() and resume() of the handle: pause resume
Chassis(address, timeout=seconds): timeout
forward(metres, speed=0.2): set_speed set_velocity motors set_motors motor_left_target
velocity(bypasses_protection=True): cmd_vel publish
connected; `with Chassis(...) as chassis:` connects and closes: is_connected connect disconnect open shutdown
status.wait(timeout=5), or readiness(): state get_status get_state robot_state is_ready ready can_move
faults: errors error get_errors get_faults alarms
get_map(): map load_map
scan.wait(timeout=5): lidar laser ranges get_scan prox sensor sensors ultrasonic
scan.wait(timeout=5): distance get_distance obstacle obstacles
pose.wait(timeout=5).distance_to(other): distance_to distance_from
on_connection(callback): on_disconnect on_disconnected on_lost on_connected on_connect on_connection_lost
pose.on(callback), as of each feed: on subscribe subscriber listen callback on_message add_callback
pose.on(callback), as of each feed: on_battery on_pose on_status on_scan
camera.wait(timeout=5): image picture photo get_image
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
on_done(callback): add_done_callback then done_callback on_finish on_complete on_failed on_arrived
progress: feedback get_progress eta remaining metres_left percent progress_line
"""
OUTCOME = """
arrived: success succeeded ok done
sentence(): message reason error why
kind: status state result cancelled failed
"""
PROGRESS = """
percent: percentage done complete fraction
metres_left: remaining distance distance_left left
"""
STOP = """
standing: stopped ok success is_stopped stands done still
problems: errors error
"""
MAP = """
save_png(path), or to_grey() for numpy: image to_image png show plot data array
"""
FAULTS = """
present, or each of them in a loop: latest active codes list
"""
FEED = """
wait(timeout=5).NAME, or latest.NAME: percent percentage level charging x y yaw theta vx wz ranges robot_state
wait(timeout=5), or latest (None at first): value get read last newest message
on(callback): subscribe callback listen add_callback
"""
POSE = """
yaw (rad), or yaw_degrees: angle heading theta orientation rotation direction degrees
x, y and yaw: position pos coordinates
distance_to(other): distance
"""
SIMULATED = """
master_uri; Chassis(sim.master_uri) drives it: move forward back left right turn rotate goto go_to_mark drive
master_uri; Chassis(sim.master_uri) has it: wait battery scan status
press_emergency_stop(): estop emergency_stop stop halt
add_obstacle(x, y): obstacle obstacles put_obstacle set_obstacle place_obstacle
remove_obstacles(): clear clear_obstacles remove_obstacle
teleport(x, y, yaw): set_pose set_position move_to place carry jump
set_battery(percent): battery_level set_charge discharge
lose_localization(): lost lose_position
speed: set_speed time_factor
reset(): restart
master_uri: uri url address
"""
NAMES = """
Chassis: Robot Chasis Chassi Chasiss Woosh WooshRobot WooshChassis Client connect
SimulatedChassis: Simulator Simulation Sim SimChassis SimulatedRobot SimRobot
"""
MODULES = """
from woosh_pure import Chassis: woosh wooshpure pywoosh wooshrobot chassis robot
"""
COMMANDS = """
woosh goto MARK: go drive-to navigate 去 前往 导航
woosh move METRES: forward ahead straight 前进 直行 移动
woosh move -METRES: back backward backwards 后退
woosh rotate DEGREES: turn left 旋转 左转
woosh rotate -DEGREES: right 右转
woosh stop: halt estop brake exit quit 停 停止 急停
woosh status: state where pose position info 状态 位置
woosh faults: error errors fault code 故障 错误
woosh camera -o FILE: picture photo image 拍照 相机
woosh led red: light lights color colour 灯 灯带
woosh charge MARK: dock 充电
woosh scan: lidar distance sensor obstacle 激光
woosh marks: mark list places 标记点
woosh battery: 电池 电量
woosh doctor: check diagnose 诊断
woosh demo: start example 演示
woosh sim: simulate simulator simulation 仿真
woosh --sim web: browser show gui view open page website reset restart 网页
woosh run --sim PROGRAM: python script program file
woosh --help: help 帮助
woosh --version: version
woosh task GUESS: pick park carry pause resume cancel
rosproto GUESS: topic node service param msg srv bag graph tf log bridge
"""
COLOUR_WORDS = """
red: 红 红色
orange: 橙 橙色
yellow: 黄 黄色
green: 绿 绿色
cyan: 青 青色
blue: 蓝 蓝色
purple: 紫 紫色
white: 白 白色
"""


def meant(table: str, word: str) -> str:
    """The right one for a guess; "" where the table has none."""
    lines = (line.rpartition(": ") for line in table.splitlines())
    found = next((right for right, _, guesses in lines if _bare(word) in map(_bare, guesses.split())), "")
    return found.replace("GUESS", _bare(word))


def _bare(word: str) -> str:
    return word.lower().replace("_", "").replace("-", "")


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
                right = meant(self._hints, name)
                if not right or hasattr(type(self), name):
                    raise
                text = both(str(error), say("use {right}", right=say(right) if " " in right else right))
                raise AttributeError(text, name=name, obj=self) from None


class SettingHints(Hints):
    """Also where a guess is set: `chassis.speed = 0.5` would change nothing."""

    if not TYPE_CHECKING:

        def __setattr__(self, name: str, value: object) -> None:
            if not hasattr(type(self), name) and meant(self._hints, name):
                text = f"{type(self).__name__!r} object has no attribute {name!r} to set"
                text = both(text, "a call does it, such as forward(metres, speed=number)")
                raise AttributeError(text, name=name, obj=self)
            object.__setattr__(self, name, value)


def refusing(template: str) -> Callable[..., NoReturn]:
    """Return a special method that answers a guess: `chassis.battery()`, `pose[0]`."""

    def refuse(thing: object, *_: object) -> NoReturn:
        raise TypeError(say(template, kind=type(thing).__name__))

    return refuse


def usage(right: str) -> Callable[[Callable[P, T]], Callable[P, T]]:
    """Decorate a method: `right` is added to the TypeError of arguments that it does not take."""

    def decorate(method: Callable[P, T]) -> Callable[P, T]:
        signature = inspect.signature(method)

        @functools.wraps(method)
        def call(*args: P.args, **kwargs: P.kwargs) -> T:
            try:
                signature.bind(*args, **kwargs)
            except TypeError as error:
                hint = say("use {right}", right=say(right))
                raise TypeError(both(f"{call.__qualname__}(): {error}", hint)) from None
            return method(*args, **kwargs)

        return call

    return decorate
