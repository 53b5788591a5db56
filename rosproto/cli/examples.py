"""Commands to copy: shown by `--help`, printed in docs/commands.md, and parsed by a test."""

from __future__ import annotations

__all__ = ["EXAMPLES"]

EXAMPLES: dict[str, tuple[str, ...]] = {
    "topic list": ("rosproto topic list -v", "rosproto topic list '/camera*'"),
    "topic echo": (
        "rosproto topic echo /odom -n 1",
        "rosproto topic echo /odom/pose/pose/position/x --plot",
        "rosproto topic echo /odom/twist/twist/linear/x /odom/twist/twist/angular/z --plot",
        "rosproto topic echo /scan --noarr --filter 'm.range_max > 10'",
    ),
    "topic hz": ("rosproto topic hz /odom /scan",),
    "topic pub": (
        "rosproto topic pub -1 /greeting std_msgs/String 'data: hello'",
        "rosproto topic pub -r 10 /cmd_vel geometry_msgs/Twist '{linear: {x: 0.1}}'",
    ),
    "service call": ("rosproto service call /lamp '{data: true}'",),
    "param set": ("rosproto param set /lamp '{watts: 60, name: desk}'",),
    "msg show": ("rosproto msg show nav_msgs/Odometry", "rosproto msg show Odometry --raw"),
    "bag record": (
        "rosproto bag record /odom /scan -O drive.bag --lz4",
        "rosproto bag record -a --split --duration 5m --max-splits 12",
    ),
    "bag play": (
        "rosproto bag play drive.bag -r 2 --clock",
        "rosproto bag play drive.bag /odom:=/before",
    ),
    "bag filter": (
        "rosproto bag filter drive.bag slow.bag \"topic == '/odom' and m.twist.twist.linear.x < 0.1\"",
    ),
    "graph": ("rosproto graph -o graph.svg", "rosproto graph --node /move_base"),
    "tf echo": ("rosproto tf echo map base_link -n 1",),
    "tf frames": ("rosproto tf frames -o frames.svg",),
    "tf monitor": ("rosproto tf monitor -n 1", "rosproto tf monitor map base_link -n 1"),
    "log echo": ("rosproto log echo --level warn --node '/move_base*'",),
    "log set": ("rosproto log set /move_base root debug",),
    "dynparam set": ("rosproto dynparam set /camera '{size: 20, enabled: false}'",),
    "bridge": (
        "rosproto bridge",
        "rosproto bridge --bind 0.0.0.0 --token SECRET --allow-write 'topic:/chatter' --deny 'param:*'",
    ),
    "run": ("rosproto run --sim program.py _speed:=0.2",),
    "master": ("rosproto master --host 0.0.0.0 --advertise 169.254.128.20",),
}
"""By command and verb."""
