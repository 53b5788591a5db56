"""Two simulated computers with a bad network between them: network namespaces, joined by the wire of air.py.

    with two_hosts() as (robot, laptop, air):
        robot.python.do("from rosproto import Master; master = Master(host='10.77.0.1', port=11311)")
        air.silence()

Needs Linux and the right to make network namespaces and devices (root, or CAP_NET_ADMIN and CAP_SYS_ADMIN); tests
are skipped without it. All namespaces and devices end with the processes.
"""

from __future__ import annotations

import functools
import os
import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager

import pytest

from tests.support.air import Air, open_tun
from tests.support.remote import Remote
from tests.support.ros_process import RosProcess

__all__ = ["LAPTOP", "LAPTOP6", "ROBOT", "ROBOT6", "Host", "two_hosts", "why_not"]

ROBOT, LAPTOP = "10.77.0.1", "10.77.0.2"
ROBOT6, LAPTOP6 = "fd77::1", "fd77::2"


class Host:
    """One computer.

    Attributes:
        python: A Python process on it (`Remote`); the computer is there as long as this process.
        device: Name of its network device.
    """

    def __init__(self, name: str, stack: ExitStack) -> None:
        self.name = name
        self.device = "air0"
        self._stack = stack
        self.python = stack.enter_context(Remote(["unshare", "--net"]))
        self.python.ask("1")  # it has entered its namespace
        self.run("ip", "link", "set", "lo", "up")

    @property
    def prefix(self) -> list[str]:
        """Put before a command to run it on this computer."""
        return ["nsenter", f"--net=/proc/{self.python.process.pid}/ns/net"]

    def run(self, *command: str) -> str:
        """Run a command until it ends; its output."""
        done = subprocess.run([*self.prefix, *command], capture_output=True, text=True, timeout=20)
        assert done.returncode == 0, f"{command} on {self.name}: {done.stderr}"
        return done.stdout

    def another(self) -> Remote:
        """One more Python process on this computer, which may be killed."""
        return self._stack.enter_context(Remote(self.prefix))

    def start(self, *command: str, env: Mapping[str, str]) -> RosProcess:
        """Start a program on this computer; it ends with the computer."""
        return self._stack.enter_context(RosProcess([*self.prefix, *command], env))

    def attach(self, number: str) -> int:
        """Give it a network device; the end of the wire."""
        temporary = f"air{number}{os.getpid()}"[:15]
        fd = open_tun(temporary)
        try:
            _ip("link", "set", temporary, "netns", str(self.python.process.pid))
            self.run("ip", "link", "set", temporary, "name", self.device)
        except BaseException:
            os.close(fd)
            raise
        return fd

    def set_addresses(self, *addresses: str) -> None:
        """Have these addresses and no others, as after DHCP; everything is reached through the wire."""
        self.run("ip", "address", "flush", "dev", self.device)
        for address in addresses:
            family = ["nodad"] if ":" in address else []
            self.run("ip", "address", "add", address, "dev", self.device, *family)
        self.up()

    def up(self) -> None:
        """The cable is in."""
        self.run("ip", "link", "set", self.device, "up")
        for family in ("-4", "-6"):
            if self.run("ip", family, "address", "show", "dev", self.device, "scope", "global").strip():
                self.run("ip", family, "route", "replace", "default", "dev", self.device)

    def down(self) -> None:
        """The device is switched off."""
        self.run("ip", "link", "set", self.device, "down")


def _ip(*arguments: str) -> None:
    done = subprocess.run(["ip", *arguments], capture_output=True, text=True, timeout=20)
    assert done.returncode == 0, f"ip {arguments}: {done.stderr}"


@functools.cache
def why_not() -> str:
    """Return why a second computer cannot be simulated; "" if it can."""
    if sys.platform != "linux":
        return "network namespaces are Linux's"
    missing: Sequence[str] = [name for name in ("ip", "unshare", "nsenter") if shutil.which(name) is None]
    if missing:
        return f"there is no {missing[0]}"
    done = subprocess.run(["unshare", "--net", "true"], capture_output=True, text=True, timeout=20)
    if done.returncode:
        return f"no right to make a network namespace: {done.stderr.strip()}"
    try:
        os.close(open_tun(f"try{os.getpid()}"))
    except OSError as error:
        return f"no TUN device: {error}"
    return ""


@contextmanager
def two_hosts(
    robot: Sequence[str] = (f"{ROBOT}/24",), laptop: Sequence[str] = (f"{LAPTOP}/24",)
) -> Iterator[tuple[Host, Host, Air]]:
    """A robot and a laptop with these addresses; `air.there` leads to the laptop, `air.back` to the robot."""
    problem = why_not()
    if problem:
        pytest.skip(f"no network of two computers: {problem}")
    with ExitStack() as stack:
        hosts = [Host(name, stack) for name in ("robot", "laptop")]
        air = Air(hosts[0].attach("a"), hosts[1].attach("b"))
        stack.callback(air.close)
        for host, addresses in zip(hosts, (robot, laptop), strict=True):
            host.set_addresses(*addresses)
        yield hosts[0], hosts[1], air
