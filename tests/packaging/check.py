"""Build the wheel and the sdist, check their content, and use them as users do. `python tests/packaging/check.py [--keep FOLDER]`

Needs `build` and `hatchling` in the interpreter that runs it; pip brings the rest. Each
check prints one line; the first that fails ends it with an AssertionError. `--keep` copies the two that passed.
"""

from __future__ import annotations

import argparse
import email
import importlib.util
import os
import re
import shutil
import stat
import subprocess
import sys
import tarfile
import tempfile
import time
import venv
import zipfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
HERE = Path(__file__).resolve().parent
MAX_WHEEL_BYTES = 3_000_000
APPLICATIONS = {
    "application": ("moved 0.2 m", "action: 7", "lz4 /robot_status 5 dock"),
    "rospy_application": ("action: 7",),
}
"""The frozen programs, and their output on success."""
FROZEN = "import sys\nif sys.argv[1:] == ['application']:\n    import application\nelse:\n    import rospy_application\n"
"""One program of both: the hooks put all of rosproto and rosproto.rospy into any that uses either."""
PASSED_ON = ("PIP_", "UV_", "SSL_CERT_", "REQUESTS_", "CURL_")  # ways to a registry
EXTRAS = {"cli", "mcap", "test", "dev"}
NOBODY = 65534

USE = """
import sys, rosproto
from msgdefs.geometry_msgs.msg import Twist
from rosproto.rospy import host  # a layer of its own, with modules found at run time
message = Twist(); message.linear.x = 0.5
assert rosproto.decode(Twist, rosproto.encode(message)).linear.x == 0.5
assert rosproto.service_class("woosh_msgs/ExecTask")._md5sum
assert len(rosproto.message_class("sensor_msgs/LaserScan")(ranges=[1, 2]).ranges) == 2
"""
USE_ROSPY = """
import rosproto.rospy.install, rospy, actionlib, tf.transformations, sensor_msgs.point_cloud2
from woosh_msgs.msg import Battery
import inspect
assert Battery.__module__ == "woosh_msgs.msg._Battery" and rospy.Time(1).to_sec() == 1
assert inspect.getsource(rospy.Rate).startswith("class Rate")
"""


def run(*command: object, timeout: float = 900, **options: object) -> str:
    """Run it in an environment of its own; its output."""
    environment = {
        k: os.environ[k] for k in ("PATH", "HOME", "LANG", "SYSTEMROOT", "TMPDIR") if k in os.environ
    }
    environment |= {
        k: v for k, v in os.environ.items() if k.startswith(PASSED_ON) or k.lower().endswith("_proxy")
    }
    environment |= options.pop("extra", {})  # type: ignore[call-overload]
    done = subprocess.run(
        [str(word) for word in command],
        capture_output=True, text=True, timeout=timeout, env=environment, check=False, **options,  # type: ignore[call-overload]
    )  # fmt: skip
    assert done.returncode == 0, f"{command}: {done.returncode}\n{done.stdout}\n{done.stderr}"
    return str(done.stdout)


def build(target: Path) -> tuple[Path, Path]:
    """The wheel (made from the sdist, as `python -m build` does) and the sdist; from the tree it is the same."""
    builder = [sys.executable, "-m", "build", "--no-isolation", "--outdir"]
    run(*builder, target, ROOT)
    run(*builder, target / "direct", "--wheel", ROOT)
    (wheel,) = target.glob("*.whl")
    (sdist,) = target.glob("*.tar.gz")
    (direct,) = (target / "direct").glob("*.whl")
    assert parts(direct) == parts(wheel), "the wheel from the sdist and the wheel from the tree differ"
    return wheel, sdist


def parts(wheel: Path) -> dict[str, bytes]:
    """The files of a wheel."""
    with zipfile.ZipFile(wheel) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def check_wheel(wheel: Path) -> None:
    """Pure, small, complete, without tests; two requirements."""
    assert wheel.name.endswith("-py3-none-any.whl"), wheel.name
    assert wheel.stat().st_size < MAX_WHEEL_BYTES, f"{wheel.stat().st_size} bytes"
    with zipfile.ZipFile(wheel) as archive:
        names = set(archive.namelist())
        info = next(n for n in names if n.endswith(".dist-info/METADATA"))
        metadata = email.message_from_bytes(archive.read(info))
        entry_points = archive.read(info.replace("METADATA", "entry_points.txt")).decode()
    tops = {n.split("/")[0] for n in names if ".dist-info/" not in n}
    assert tops == {"rosproto", "woosh_pure", "msgdefs"}, tops  # not tools, not tests
    for package in tops:
        missing = {path.relative_to(ROOT).as_posix() for path in tracked(package)} - names
        assert not missing, f"not in the wheel: {sorted(missing)[:10]}"
        assert f"{package}/py.typed" in names
    assert any(n.startswith("msgdefs/") and n.endswith(".pyi") for n in names)
    strays = [n for n in names if "/tests/" in n or n.startswith("tests") or n.endswith((".pyc", ".so"))]
    assert not strays, strays
    required = [r for r in metadata.get_all("Requires-Dist", []) if "extra ==" not in r]
    assert sorted(re.split(r"[<>=~ ;]", r)[0] for r in required) == ["lz4", "numpy"], required
    assert set(metadata.get_all("Provides-Extra", [])) >= EXTRAS
    for entry in ("rosproto = rosproto.__main__:main", "woosh = woosh_pure.__main__:main", "hook-dirs = "):
        assert entry in entry_points, entry_points


def tracked(package: str) -> list[Path]:
    """Files of a package under version control; all but caches where there is no git."""
    done = subprocess.run(
        ["git", "ls-files", "-z", package], cwd=ROOT, capture_output=True, text=True, check=False
    )
    if done.returncode == 0 and done.stdout:
        return [ROOT / name for name in done.stdout.split("\0") if name and (ROOT / name).exists()]
    return [p for p in (ROOT / package).rglob("*") if p.is_file() and "__pycache__" not in p.parts]


def check_sdist(sdist: Path) -> None:
    """A packager can build, test and read it."""
    with tarfile.open(sdist) as archive:
        names = {n.partition("/")[2] for n in archive.getnames()}
    for name in (
        "pyproject.toml",
        "mkdocs.yml",
        "msgdefs/std_msgs/msg/Header.msg",
        "LICENSE",
        "README.md",
        "CHANGELOG.md",
        "SECURITY.md",
        "tests/test_layers.py",
    ):
        assert name in names, f"{name} is not in the sdist"


def check_installed(wheel: Path, work: Path) -> Path:
    """In a bare environment: what pip brings, the commands, and nothing written into the installation."""
    home = work / "bare"
    venv.create(home)
    bin_ = home / ("Scripts" if sys.platform == "win32" else "bin")
    python = bin_ / "python"
    run(*pip(python), "install", "-q", wheel)
    listed = run(*pip(python), "list", "--format", "freeze", "--disable-pip-version-check")
    brought = {line.split("==")[0].split(" @")[0].lower() for line in listed.splitlines()}
    assert brought == {"numpy", "lz4", "woosh-pure"}, brought
    make_read_only(home)
    user = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if is_root() else {}
    before = contents(home)
    options = {"cwd": work, "extra": {"HOME": "/nonexistent"}, **user}
    assert "graph" in run(bin_ / "rosproto", "--help", **options)
    assert "woosh" in run(bin_ / "woosh", "--help", **options)
    assert "done in" in run(bin_ / "woosh", "demo", **options)
    assert "this machine is fine" in run(bin_ / "woosh", "selftest", **options)
    run(python, "-c", USE, **options)
    run(python, "-c", USE_ROSPY, **options)
    assert contents(home) == before, "the installation was written to"
    return python


def pip(python: Path) -> list[object]:
    """Our own pip, working on that environment, which needs none."""
    return [sys.executable, "-m", "pip", "--python", python]


def check_zipped(wheel: Path, python: Path, work: Path) -> None:
    """Importing from the wheel itself, a zip: definitions are read as resources."""
    code = USE + "assert 'zipimporter' in type(rosproto.__loader__).__name__, rosproto.__loader__\n"
    code += "from woosh_pure import SimulatedChassis\nwith SimulatedChassis(full_graph=False): pass\n"
    code += "from woosh_pure.cli import main\nassert main(['selftest', '--no-ros']) == 0\n"
    run(python, "-c", code, cwd=work, extra={"PYTHONPATH": str(wheel)})
    run(python, "-c", USE_ROSPY, cwd=work, extra={"PYTHONPATH": str(wheel)})


def check_runners(wheel: Path, work: Path) -> None:
    """`pipx run` and `uv run` of the wheel, with the requirements from a folder, as without a network.

    Skipped, and said so, where they are not in the environment that runs this.
    """
    house = work / "house"
    run(sys.executable, "-m", "pip", "download", "-q", "-d", house, wheel)
    extra = {"PIPX_HOME": str(work / "pipx"), "UV_CACHE_DIR": str(work / "uv"), "HOME": str(work / "home")}
    extra["PIP_CACHE_DIR"] = str(work / "pip")  # no matter who owns the usual one
    Path(extra["HOME"]).mkdir()
    if importlib.util.find_spec("pipx") is None or importlib.util.find_spec("uv") is None:
        print("  skipped: pipx, uv are not here (pip install pipx uv)")
        return
    pipx = [sys.executable, "-m", "pipx", "run", "--spec", wheel]
    uv = [sys.executable, "-m", "uv", "--offline"]
    where = ["--no-index", "--find-links", house, "--python", sys.executable]
    script = work / "script.py"
    script.write_text(USE)
    for command in (
        [*pipx, "--pip-args", f"--no-index --find-links {house}", "woosh", "demo"],
        [*uv, "tool", "run", *where, "--from", wheel, "woosh", "demo"],
    ):
        assert "done in" in run(*command, cwd=work, extra=extra)
    run(*uv, "run", "--no-project", *where, "--with", wheel, script, cwd=work, extra=extra)


def check_frozen(python: Path, work: Path) -> None:
    """PyInstaller --onefile of small applications, by the hooks in the wheel that is installed there."""
    run(*pip(python), "install", "-q", "--no-compile", "pyinstaller")
    empty = work / "empty"
    empty.mkdir()
    main = work / "frozen.py"
    main.write_text(FROZEN)
    run(
        python, "-m", "PyInstaller", "--onefile", "--noconfirm", "--log-level", "ERROR", "--paths", HERE,
        "--distpath", work / "app", "--workpath", work / "build", "--specpath", work, main,
        cwd=work, timeout=900,
    )  # fmt: skip
    (program,) = (work / "app").glob("frozen*")
    for application, shows in APPLICATIONS.items():
        shown = run(program, application, cwd=empty, extra={"PATH": "", "LC_ALL": "C.UTF-8"})
        assert all(words in shown for words in shows), shown
    print(f"  {program.name}: {program.stat().st_size / 1e6:.0f} MB")


def is_root() -> bool:
    return sys.platform != "win32" and os.geteuid() == 0


def make_read_only(folder: Path) -> None:
    for path in [folder, *folder.rglob("*")]:
        if not path.is_symlink():
            path.chmod(path.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))


def make_writable(folder: Path) -> None:
    """Make the directory removable by users other than root."""
    for path in [folder, *folder.rglob("*")]:
        if not path.is_symlink():
            path.chmod(path.stat().st_mode | stat.S_IWUSR)


def contents(folder: Path) -> set[tuple[str, int]]:
    return {(str(p), p.stat().st_mtime_ns) for p in folder.rglob("*") if p.is_file()}


def main() -> None:
    """All checks, in a temporary directory."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--keep", type=Path, metavar="FOLDER")
    keep = parser.parse_args().keep
    with tempfile.TemporaryDirectory(prefix="woosh-packaging-") as name:
        work = Path(name)
        work.chmod(0o755)  # nobody must get in
        began = time.monotonic()

        def done(what: str) -> None:
            used = os.times()
            computed = used.children_user + used.children_system
            print(f"{time.monotonic() - began:6.1f} s, {computed:5.1f} s computed  {what}", flush=True)

        wheel, sdist = build(work / "dist")
        done(f"built {wheel.name} ({wheel.stat().st_size / 1e3:.0f} kB) and {sdist.name}")
        check_wheel(wheel)
        check_sdist(sdist)
        done("contents and requirements")
        python = check_installed(wheel, work)
        done("bare environment, commands, read-only installation")
        check_zipped(wheel, python, work)
        done("imported from a zip")
        check_runners(wheel, work)
        done("pipx run, uv tool run, uv run")
        make_writable(work / "bare")
        check_frozen(python, work)
        done("PyInstaller --onefile")
        if keep is not None:
            for file in (wheel, sdist):
                shutil.copy(file, keep)


if __name__ == "__main__":
    main()
