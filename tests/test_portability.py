"""Nothing that only one operating system has is on any path; CI also lets mypy look at each platform's view.

The list is of what Windows or macOS lack. A use is fine below a test of the platform (`sys.platform`, `os.name`,
`hasattr`), in a `try` that expects its absence, or as `getattr(module, name, default)`; anything else needs a
reason in ALLOWED.
"""

from __future__ import annotations

import ast
import itertools
import os
import re
import subprocess
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

import pytest

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parents[1]
FILES = sorted(p for package in ("rosproto", "woosh_pure", "msgdefs") for p in (ROOT / package).rglob("*.py"))

MODULES = set(
    "fcntl termios tty pty pwd grp resource syslog crypt spwd nis posix curses readline ossaudiodev"  # POSIX
    " msvcrt winreg winsound _winapi nt"  # Windows
    .split()
)  # fmt: skip
NAMES = {
    "os": "fork forkpty wait waitpid wait3 wait4 kill killpg getuid geteuid getgid getegid setsid setpgid getpgid"
    " setuid setgid chown lchown chroot mkfifo mknod nice uname sysconf statvfs getloadavg sched_getaffinity"
    " sched_setaffinity pread pwrite preadv pwritev writev readv sendfile posix_spawn memfd_create eventfd"
    " pidfd_open splice copy_file_range posix_fadvise fdatasync O_NONBLOCK O_CLOEXEC O_DIRECTORY startfile"
    " fpathconf pathconf getrandom pipe2 openpty ttyname tcgetpgrp register_at_fork getgroups initgroups fchmod fchown"
    " posix_fallocate sync ctermid getresuid O_DIRECT O_NOFOLLOW O_ASYNC set_blocking",
    "socket": "AF_UNIX AF_PACKET AF_NETLINK AF_BLUETOOTH SO_REUSEPORT SO_BINDTODEVICE SO_PEERCRED MSG_DONTWAIT MSG_WAITALL"
    " MSG_NOSIGNAL MSG_MORE MSG_ERRQUEUE TCP_CORK TCP_QUICKACK TCP_USER_TIMEOUT TCP_KEEPIDLE TCP_KEEPINTVL"
    " TCP_KEEPCNT TCP_INFO TCP_DEFER_ACCEPT TCP_FASTOPEN SCM_RIGHTS SO_EXCLUSIVEADDRUSE SIO_KEEPALIVE_VALS"
    " CMSG_SPACE if_nameindex send_fds recv_fds",
    "signal": "SIGKILL SIGHUP SIGQUIT SIGUSR1 SIGUSR2 SIGPIPE SIGCHLD SIGALRM SIGCONT SIGSTOP SIGTSTP SIGWINCH"
    " alarm setitimer pause sigwait sigwaitinfo sigtimedwait pthread_kill pthread_sigmask siginterrupt"
    " SIGBREAK CTRL_C_EVENT CTRL_BREAK_EVENT",
    "select": "poll epoll kqueue devpoll POLLIN POLLOUT POLLERR POLLHUP EPOLLIN EPOLLOUT",
    "selectors": "PollSelector EpollSelector KqueueSelector DevpollSelector",
    "time": "clock_gettime clock_getres CLOCK_MONOTONIC CLOCK_MONOTONIC_RAW CLOCK_BOOTTIME CLOCK_REALTIME tzset"
    " pthread_getcpuclockid",
    "asyncio": "add_signal_handler open_unix_connection start_unix_server",
    "subprocess": "STARTUPINFO CREATE_NEW_PROCESS_GROUP CREATE_NO_WINDOW",
}
METHODS = set("sendmsg recvmsg sendmsg_afalg add_signal_handler add_reader add_writer".split())
PATHS = ("/tmp", "/dev/", "/proc/", "/etc/", "/usr/", "/var/", "/home/")

ALLOWED: dict[tuple[str, str], str] = {}


def guarded(path: list[ast.AST]) -> bool:
    """Whether one of the nodes around the last one asks for the platform, or expects the absence."""
    for outer, inner in itertools.pairwise(path):
        if isinstance(outer, (ast.If, ast.IfExp, ast.While)) and asks(outer.test):
            return True
        if isinstance(outer, ast.Try) and inner in outer.body and any(map(expects_absence, outer.handlers)):
            return True
        body = getattr(outer, "body", None)
        if isinstance(body, list) and inner in body:
            before = body[: body.index(inner)]
            if any(isinstance(s, ast.If) and asks(s.test) and leaves(s.body) for s in before):
                return True
    return False


def asks(test: ast.expr) -> bool:
    text = ast.unparse(test)
    return any(mark in text for mark in ("sys.platform", "os.name", "hasattr(", "platform.system"))


def leaves(body: list[ast.stmt]) -> bool:
    return isinstance(body[-1], (ast.Return, ast.Raise, ast.Continue))


def expects_absence(handler: ast.ExceptHandler) -> bool:
    return handler.type is not None and any(
        name in ast.unparse(handler.type) for name in ("ImportError", "ModuleNotFoundError", "AttributeError")
    )


def walk(node: ast.AST, above: tuple[ast.AST, ...] = ()) -> Iterator[list[ast.AST]]:
    """Every node with all that is around it, outermost first."""
    here = (*above, node)
    yield list(here)
    for child in ast.iter_child_nodes(node):
        yield from walk(child, here)


def uses(source: str) -> list[tuple[int, str]]:
    """(line, what) of every unguarded use."""
    found = []
    tree = ast.parse(source)
    other_names = {
        alias.asname: alias.name
        for node in ast.walk(tree) if isinstance(node, ast.Import)
        for alias in node.names if alias.asname
    }  # fmt: skip
    for path in walk(tree):
        what = used_by(path[-1], other_names)
        if what and not guarded(path):
            found.append((path[-1].lineno, what))  # type: ignore[attr-defined]
    return found


def used_by(node: ast.AST, other_names: Mapping[str, str]) -> str:
    if isinstance(node, ast.Import):
        return next((a.name for a in node.names if a.name.split(".")[0] in MODULES), "")
    if isinstance(node, ast.ImportFrom) and node.module and not node.level:
        if node.module.split(".")[0] in MODULES:
            return node.module
        names = NAMES.get(node.module, "").split()
        return next((f"{node.module}.{a.name}" for a in node.names if a.name in names), "")
    if isinstance(node, ast.Attribute):
        module = other_names.get(node.value.id, node.value.id) if isinstance(node.value, ast.Name) else ""
        if node.attr in NAMES.get(module, "").split():
            return f"{module}.{node.attr}"
        return f".{node.attr}" if node.attr in METHODS else ""
    if isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
        name = node.args[0].value if node.args and isinstance(node.args[0], ast.Constant) else ""
        return str(name) if name in MODULES else ""
    if isinstance(node, ast.Constant) and isinstance(node.value, str) and node.value.startswith(PATHS):
        return repr(node.value)
    return ""


def test_the_places_on_the_page_about_portability_exist() -> None:
    """Each is a file, or a name that a file defines."""
    page = (ROOT / "docs/portability.md").read_text("utf-8")
    places = re.findall(r"`([\w./-]+/[\w.-]+|\.gitattributes)(?:::(\w+))?`", page)
    assert len(places) > 40
    missing = [
        place for place in places if not (ROOT / place[0]).exists() or place[1] not in defined(place[0])
    ]
    assert missing == []


def defined(file: str) -> set[str]:
    """What a Python file defines at its top level, also below a test of the platform; and nothing at all."""
    if not file.endswith(".py"):
        return {""}
    names = {""}
    for node in ast.walk(ast.parse((ROOT / file).read_text("utf-8"))):
        if isinstance(node, (ast.FunctionDef, ast.ClassDef)):
            names.add(node.name)
        elif isinstance(node, ast.Assign):
            for target in node.targets:
                names |= {name.id for name in ast.walk(target) if isinstance(name, ast.Name)}
    return names


@pytest.mark.slow  # reads all sources
def test_nothing_of_one_platform_only() -> None:
    """Each use is guarded, or has its reason above; a reason whose use has gone is gone, too."""
    assert len(FILES) > 300
    names = {path.relative_to(ROOT).as_posix(): path for path in FILES}
    found = [(name, *use) for name, path in names.items() for use in uses(path.read_text("utf-8"))]
    wrong = [(name, line, what) for name, line, what in found if (name, what) not in ALLOWED]
    assert not wrong, f"{wrong}; guard it by sys.platform or hasattr, or give the reason in ALLOWED"
    assert set(ALLOWED) <= {(name, what) for name, _, what in found}


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ("import fcntl", ["fcntl"]),
        ("from signal import SIGKILL", ["signal.SIGKILL"]),
        ("import os\nos.fork()", ["os.fork"]),
        ("import os as system\nsystem.fork()", ["os.fork"]),
        ("open(f'/proc/{pid}/stat')", ["'/proc/'"]),
        ("sock.sendmsg([b''])", [".sendmsg"]),
        ("import importlib\nimportlib.import_module('termios')", ["termios"]),
        ("open('/tmp/x')", ["'/tmp/x'"]),
        ("import sys\nif sys.platform == 'linux':\n    import fcntl", []),
        ("try:\n    import fcntl\nexcept ImportError:\n    fcntl = None", []),
        ("try:\n    pass\nexcept ImportError:\n    import fcntl", ["fcntl"]),
        ("def f():\n    if sys.platform == 'win32':\n        return 1\n    return os.fork()", []),
        ("def f():\n    if sys.platform == 'win32':\n        log()\n    return os.fork()", ["os.fork"]),
        ("getattr(socket, 'MSG_WAITALL', 0)", []),
    ],
)
def test_the_watcher_sees(source: str, expected: list[str]) -> None:
    """What it finds, and what it takes for a guard."""
    assert [what for _, what in uses(source)] == expected


def test_no_two_files_differ_in_case_only() -> None:
    """Windows and macOS would keep one of them."""
    done = subprocess.run(["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True, check=False) \
        if (ROOT / ".git").exists() and os.name == "posix" else None  # fmt: skip
    if done is None or done.returncode:
        names = [p.relative_to(ROOT).as_posix() for p in ROOT.rglob("*") if "__pycache__" not in p.parts]
    else:
        names = done.stdout.split("\0")
    count = Counter(name.casefold() for name in names if name)
    assert len(count) > 100
    assert not [name for name, n in count.items() if n > 1]


def test_names_of_files_are_legal_everywhere() -> None:
    """No reserved names of Windows, none of its forbidden characters, no trailing dot, short enough paths."""
    reserved = {"con", "prn", "aux", "nul", *(f"{d}{n}" for d in ("com", "lpt") for n in range(1, 10))}
    for package in ("rosproto", "woosh_pure", "msgdefs", "tests", "examples", "docs"):
        for path in (ROOT / package).rglob("*"):
            name = path.relative_to(ROOT).as_posix()
            assert not set(path.name) & set('<>:"\\|?*'), name
            assert path.name.split(".")[0].lower() not in reserved, name
            assert not path.name.endswith((".", " ")), name
            assert len(name) < 150, name


def test_localhost_is_127_0_0_1() -> None:
    """Windows tries ::1 first and waits two seconds for it."""
    from rosproto.transport.name_lookup import resolve

    for spelling in ("localhost", "LOCALHOST"):
        assert resolve(spelling)[0] == "127.0.0.1"
