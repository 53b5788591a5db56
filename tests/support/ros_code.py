"""Code that real ROS 1 needs from our definitions: message packages, headers, compiled roscpp nodes.

Made by Debian's own generators. The fixtures that keep what was made are in tests/interop/conftest.py.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from pathlib import Path

from tests.support.ros_process import (
    PYTHON,
    TIMEOUT,
    clean_environment,
    exclusive,
    import_problem,
    require,
    require_ros,
)

__all__ = [
    "GENMSG_PY",
    "GENSRV_PY",
    "MSGDEFS",
    "build_cpp_node",
    "generate_cpp_headers",
    "generate_python_packages",
    "write_revision",
]

GENMSG_PY = Path("/usr/lib/genpy/genmsg_py.py")
GENSRV_PY = Path("/usr/lib/genpy/gensrv_py.py")
GEN_CPP = Path("/usr/lib/gencpp/gen_cpp.py")
GENACTION = Path("/usr/lib/actionlib_msgs/genaction.py")
CPP_TEMPLATES = Path("/usr/share/gencpp")
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


def _definitions(work: Path, root: Path = MSGDEFS) -> dict[str, dict[str, list[Path]]]:
    """package -> {"msg": files, "srv": files} of a folder, the messages of its actions included."""
    found: dict[str, dict[str, list[Path]]] = {}
    for package in sorted(path for path in root.iterdir() if path.is_dir()):
        files = {kind: sorted((package / kind).glob(f"*.{kind}")) for kind in ("msg", "srv")}
        for action in sorted((package / "action").glob("*.action")):
            target = work / "actions" / package.name
            target.mkdir(parents=True, exist_ok=True)
            _generate([PYTHON, str(GENACTION), str(action), "-o", str(target)])
        known = {path.name for path in files["msg"]}
        files["msg"] += [
            p for p in sorted((work / "actions" / package.name).glob("*.msg")) if p.name not in known
        ]
        if files["msg"] or files["srv"]:
            found[package.name] = files
    return found


def _include_path(work: Path, definitions: Mapping[str, object], root: Path = MSGDEFS) -> list[str]:
    places = [
        place
        for name in definitions
        for place in (root / name / "msg", work / "actions" / name)
        if place.is_dir()
    ]
    if root != MSGDEFS:  # what a revision uses of other packages
        others = (path / "msg" for path in sorted(MSGDEFS.iterdir()) if path.name not in definitions)
        places += [place for place in others if place.is_dir()]
    return [f"-I{place.parent.name if place.name == 'msg' else place.name}:{place}" for place in places]


def _generate(arguments: Sequence[str]) -> None:
    done = subprocess.run(
        list(arguments), capture_output=True, text=True, timeout=TIMEOUT, env=clean_environment()
    )
    assert done.returncode == 0, f"{list(arguments)[:4]}: {done.stdout}{done.stderr}"


def generate_python_packages(target: Path, root: Path = MSGDEFS) -> Path:
    """Message packages for rospy from definitions, by genpy's own scripts; a directory for PYTHONPATH.

    Packages that Debian's Python has already (std_msgs, actionlib and so on) are left out: one with messages
    only would hide the code of the same name.
    """
    require_ros("genpy", "genmsg")
    require(GENMSG_PY.exists() and GENSRV_PY.exists(), f"there is no {GENMSG_PY}")
    target.mkdir(parents=True, exist_ok=True)
    definitions = _definitions(target, root)
    include = _include_path(target, definitions, root)
    for name, kinds in definitions.items():
        if not import_problem(name):
            continue
        for kind, script in (("msg", GENMSG_PY), ("srv", GENSRV_PY)):
            if kinds[kind]:
                out = target / name / kind
                out.mkdir(parents=True, exist_ok=True)
                base = [PYTHON, str(script), "-p", name, "-o", str(out)]
                _generate([*base, *include, *map(str, kinds[kind])])
                _generate([*base, "--initpy"])
        (target / name / "__init__.py").touch()
    return target


# One process for all files: the interpreter's start would take most of the time.
_GEN_CPP_ALL = """
import json, sys, genmsg.template_tools as t
for package, kind, path, out, include, templates in json.load(open(sys.argv[1])):
    t.generate_from_command_line_options(
        ["gen_cpp.py", path, *include, "-p", package, "-o", out, "-e", templates],
        {"msg.h.template": "@NAME@.h"}, {"srv.h.template": "@NAME@.h"})
"""


def generate_cpp_headers(target: Path, root: Path = MSGDEFS) -> Path:
    """roscpp headers from definitions, by gencpp; a directory for -I.

    Packages whose headers are in /usr/include already are left out.
    """
    require(GEN_CPP.exists() and CPP_TEMPLATES.exists(), f"there is no {GEN_CPP}")
    target.mkdir(parents=True, exist_ok=True)
    definitions = _definitions(target, root)
    include = _include_path(target, definitions, root)
    work = []
    for name, kinds in definitions.items():
        if (Path("/usr/include") / name).is_dir():
            continue
        (target / name).mkdir(exist_ok=True)
        for kind in ("msg", "srv"):
            work += [
                (name, kind, str(path), str(target / name), include, str(CPP_TEMPLATES))
                for path in kinds[kind]
            ]
    plan = target / "plan.json"
    plan.write_text(json.dumps(work))
    _generate([PYTHON, "-c", _GEN_CPP_ALL, str(plan)])
    return target


def build_cpp_node(name: str, source: str, target: Path, headers: Path | None = None) -> Path:
    """Compile a roscpp program; the path of the executable. The same source is compiled once per directory."""
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
            text = target / f"{name}-{digest}.cpp"
            text.write_text(source)
            include = [f"-I{headers}"] if headers is not None else []
            built = program.with_suffix(".tmp")
            command = [str(compiler), "-O1", "-std=c++17", "-w", *include, str(text), "-o", str(built)]
            libraries = [*flags.stdout.split(), "-lpthread"]
            if "<actionlib/" in source:
                libraries.insert(0, "-lactionlib")
            done = subprocess.run([*command, *libraries], capture_output=True, text=True, timeout=300)
            assert done.returncode == 0, f"{name} does not compile:\n{done.stderr}"
            built.rename(program)
    return program
