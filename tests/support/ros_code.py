"""Code for real ROS 1 from our definitions: message packages, headers, compiled roscpp nodes.

Debian's generators make it. The fixtures that cache it are in tests/interop/conftest.py.
"""

from __future__ import annotations

import hashlib
import re
import shutil
import subprocess
from pathlib import Path

from tests.support.ros_process import (
    PYTHON,
    TIMEOUT,
    clean_environment,
    exclusive,
    require,
    require_ros,
)

__all__ = [
    "GENMSG_PY",
    "GENSRV_PY",
    "MSGDEFS",
    "build_cpp_node",
    "generate_python_packages",
    "write_revision",
]

GENMSG_PY = Path("/usr/lib/genpy/genmsg_py.py")
GENSRV_PY = Path("/usr/lib/genpy/gensrv_py.py")
CPP_TEMPLATES = Path("/usr/share/gencpp")
GENERATORS = Path(__file__).with_name("ros_generators.py")
MSGDEFS = Path(__file__).resolve().parents[2] / "msgdefs"
MADE_OF_ACTIONS = ("Action", "ActionGoal", "ActionResult", "ActionFeedback", "Goal", "Result", "Feedback")


def write_revision(target: Path, package: str, label: str) -> Path:
    """The definitions of one revision of a package as files, all of them; a folder like msgdefs."""
    from rosproto.msg import bundled

    library = bundled().package_revisions(package)[label]
    names = {"msg": set(), "srv": set(library.services(package)), "action": set(library.actions(package))}
    made = {name + suffix for name in names["action"] for suffix in MADE_OF_ACTIONS}
    names["msg"] = set(library.messages(package)) - made
    looks = {"msg": library.message, "srv": library.service, "action": library.action}
    for kind, found in names.items():
        place = target / package / kind
        place.mkdir(parents=True, exist_ok=True)
        for name in found:
            text = looks[kind](name).text
            (place / f"{name.partition('/')[2]}.{kind}").write_text(text, "utf-8", errors="surrogateescape")
    return target


def _generate(what: str, *paths: Path) -> None:
    """Run ros_generators.py; as long as it takes: the test around it has a time limit."""
    command = [PYTHON, str(GENERATORS), what, *map(str, paths)]
    done = subprocess.run(command, capture_output=True, text=True, env=clean_environment())
    assert done.returncode == 0, f"{what}: {done.stdout}{done.stderr}"


def generate_python_packages(target: Path, root: Path = MSGDEFS) -> Path:
    """Message packages for rospy from definitions, by genpy; a directory for PYTHONPATH.

    Packages that Debian's Python has already (std_msgs, actionlib and so on) are left out: one with messages
    only would hide the code of the same name.
    """
    require_ros("genpy", "genmsg")
    target.mkdir(parents=True, exist_ok=True)
    _generate("python", target, root, MSGDEFS)
    return target


def _includes_generated(source: str) -> bool:
    """Whether a source needs headers of messages that Debian has not."""
    packages = re.findall(r"#include <(\w+)/\w+\.h>", source)
    return any((MSGDEFS / p).is_dir() and not (Path("/usr/include") / p).is_dir() for p in packages)


def build_cpp_node(name: str, source: str, target: Path, root: Path = MSGDEFS, optimise: str = "-O1") -> Path:
    """Compile a roscpp program; the path of the executable. The same source is compiled once per directory.

    The headers of messages that Debian has not are made by gencpp from the definitions in `root`.
    """
    compiler, config = shutil.which("g++"), shutil.which("pkg-config")
    require(compiler and config, "there is no g++ or pkg-config")
    flags = subprocess.run(
        [str(config), "--cflags", "--libs", "roscpp"], capture_output=True, text=True, timeout=TIMEOUT
    )
    require(flags.returncode == 0, "roscpp's development files are not installed")
    digest = hashlib.sha256(source.encode()).hexdigest()[:12]
    program = target / f"{name}-{digest}"
    with exclusive(target / f"{name}-{digest}.lock"):
        if not program.exists():
            text, headers = target / f"{name}-{digest}.cpp", target / f"{name}-{digest}.headers"
            text.write_text(source)
            include = []
            if _includes_generated(source):
                require(CPP_TEMPLATES.exists(), f"there is no {CPP_TEMPLATES}")
                headers.mkdir(exist_ok=True)
                _generate("headers", headers, text, root, MSGDEFS)
                include = [f"-I{headers}"]
            built = program.with_suffix(".tmp")
            command = [str(compiler), optimise, "-std=c++17", "-w", *include, str(text), "-o", str(built)]
            libraries = [*flags.stdout.split(), "-lpthread"]
            if "<actionlib/" in source:
                libraries.insert(0, "-lactionlib")
            done = subprocess.run([*command, *libraries], capture_output=True, text=True)
            assert done.returncode == 0, f"{name} does not compile:\n{done.stderr}"
            built.rename(program)
    return program
