"""Imports go one way: each layer (tools/layers.py) may import only what stands below it."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from tools.layers import LAYERS, PURE

pytestmark = pytest.mark.structure

ROOT = Path(__file__).resolve().parent.parent

IMPURE_MODULES = {
    "socket",
    "threading",
    "selectors",
    "select",
    "asyncio",
    "subprocess",
    "time",
    "queue",
    "signal",
}
ALLOWED_IMPURE = {
    # A lock around the class cache and the paused collector; no waiting happens there.
    ("rosproto.codec", "threading"),
}


def layer_of(module: str) -> str | None:
    """The longest layer name that `module` belongs to; None for modules of other projects."""
    matches = [name for name in LAYERS if module == name or module.startswith(name + ".")]
    return max(matches, key=len) if matches else None


def sources() -> Iterator[tuple[str, Path]]:
    for package in ("rosproto", "woosh_pure", "msgdefs"):
        for path in sorted((ROOT / package).rglob("*.py")):
            parts = path.relative_to(ROOT).with_suffix("").parts
            yield ".".join(parts[:-1] if parts[-1] == "__init__" else parts), path


def type_checking_blocks(tree: ast.AST) -> set[ast.AST]:
    found: set[ast.AST] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            for statement in node.body:
                found.update(ast.walk(statement))
    return found


def imports_of(module: str, path: Path) -> Iterator[tuple[str, int]]:
    """Every module that a file imports at run time, with its line, relative imports resolved."""
    tree = ast.parse(path.read_text("utf-8"))
    skipped = type_checking_blocks(tree)
    package = module if path.name == "__init__.py" else module.rpartition(".")[0]
    for node in ast.walk(tree):
        if node in skipped:
            continue
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, node.lineno
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parents = package.split(".")[: len(package.split(".")) - node.level + 1]
                base = ".".join([*parents, base]) if base else ".".join(parents)
            for alias in node.names:
                joined = f"{base}.{alias.name}"
                yield (joined if layer_of(joined) != layer_of(base) else base), node.lineno


MODULES = list(sources())
PURE_MODULES = [(name, path) for name, path in MODULES if layer_of(name) in PURE]


@pytest.mark.parametrize(("module", "path"), MODULES, ids=[name for name, _ in MODULES])
def test_a_module_imports_only_what_is_below_it(module: str, path: Path) -> None:
    """No import points up, and none of the layers imports the public face."""
    own = layer_of(module)
    assert own is not None, f"{module} belongs to no layer: add it to LAYERS"
    if module in {"rosproto", "rosproto.__main__"}:
        return  # the face gathers everything
    wrong = []
    for imported, line in imports_of(module, path):
        target = layer_of(imported)
        if target is None:
            continue
        if own != "woosh_pure" and target == "woosh_pure" and module == "rosproto.rospy.sim":
            continue  # `rosproto run --sim` is the one door upwards, and it is imported late
        if LAYERS.index(target) > LAYERS.index(own) or (target == "rosproto" and own != "woosh_pure"):
            wrong.append(f"{path.name}:{line} imports {imported}")
    assert not wrong, wrong


@pytest.mark.parametrize(("module", "path"), PURE_MODULES, ids=[name for name, _ in PURE_MODULES])
def test_pure_layers_know_no_sockets_threads_or_clocks(module: str, path: Path) -> None:
    """The protocol, the codec and the definitions are values in, values out."""
    own = layer_of(module)
    wrong = [
        f"{path.name}:{line} imports {name}"
        for name, line in imports_of(module, path)
        if name.partition(".")[0] in IMPURE_MODULES and (own, name) not in ALLOWED_IMPURE
    ]
    assert not wrong, wrong


def test_the_watch_itself_sees_a_wrong_import(tmp_path: Path) -> None:
    """A check that cannot fail checks nothing."""
    bad = tmp_path / "bad.py"
    bad.write_text("from rosproto.node import Node\nfrom ..node import publisher\n")
    found = [name for name, _ in imports_of("rosproto.msg.bad", bad)]
    assert found[0].startswith("rosproto.node")
    assert LAYERS.index("rosproto.node") > LAYERS.index("rosproto.msg")
    assert layer_of(found[1]) == "rosproto.node"


NODE = {name: path for name, path in MODULES if name.startswith("rosproto.node")}
GROUND_ROOMS = {"graph", "revisions"}
"""Rooms of rosproto.node that know none of the others."""


def statements(tree: ast.AST) -> Iterator[ast.AST]:
    """Every statement, however deep; expressions, which are most of a tree, hold none."""
    todo = [tree]
    while todo:
        for child in ast.iter_child_nodes(todo.pop()):
            if isinstance(child, (ast.stmt, ast.excepthandler, ast.match_case)):
                yield child
                todo.append(child)


def test_a_statement_is_found_however_deep_it_stands() -> None:
    source = Path(__file__).read_text("utf-8") + (
        "\ntry:\n  with x:\n    pass\nexcept E:\n  match y:\n    case 1:\n      import deep\n"
    )
    tree = ast.parse(source)
    of_all = {node for node in ast.walk(tree) if isinstance(node, ast.stmt)}
    assert {node for node in statements(tree) if isinstance(node, ast.stmt)} == of_all


def imports_within(module: str, files: dict[str, Path]) -> set[str]:
    """Which of some files one of them imports: late, or for types only, or not."""
    found = set()
    for node in statements(ast.parse(files[module].read_text("utf-8"))):
        if isinstance(node, ast.ImportFrom) and node.module:
            names = [f"{node.module}.{alias.name}" for alias in node.names]
            found |= {name if name in files else node.module for name in names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
    return (found & set(files)) - {module}


NODE_IMPORTS = {module: imports_within(module, NODE) for module in NODE}


def room(module: str) -> str:
    """ "graph" of rosproto.node.graph.master_monitor; the module itself for what stands in no room."""
    parts = module.split(".")
    return parts[2] if len(parts) > 3 else module


def reachable(start: str, imports: dict[str, set[str]]) -> set[str]:
    """What a file imports, and what that imports, and so on."""
    found: set[str] = set()
    todo = [start]
    while todo:
        new = imports[todo.pop()] - found
        found |= new
        todo += new
    return found


@pytest.mark.parametrize("module", sorted(NODE))
def test_no_files_of_the_node_import_one_another(module: str) -> None:
    """Imports for types count, too: of two files one can be read, and tested, without the other."""
    cycle = {other for other in reachable(module, NODE_IMPORTS) if module in reachable(other, NODE_IMPORTS)}
    assert not cycle, sorted(cycle)


@pytest.mark.parametrize("module", sorted(NODE))
def test_nothing_below_the_node_names_it(module: str) -> None:
    """Parts are handed what they need (`context.py`), not the node."""
    if module != "rosproto.node":  # the package's face
        assert "rosproto.node.node" not in NODE_IMPORTS[module]


@pytest.mark.parametrize("module", sorted(name for name in NODE if room(name) in GROUND_ROOMS))
def test_the_ground_rooms_of_the_node_know_no_other(module: str) -> None:
    """The graph and definitions are what topics, services and parameters stand on."""
    above = {name for name in NODE_IMPORTS[module] if name != room(name)} - {module}
    assert {room(name) for name in above} <= GROUND_ROOMS


CHASSIS = {name: path for name, path in MODULES if name.startswith("woosh_pure")}
TWO_FACES = {"woosh_pure.chassis", "woosh_pure.aio", "woosh_pure.aio.chassis"}
"""`Chassis.aio` is an `aio.Chassis`, and that one's `chassis` a `Chassis`: as users see them, they name each other."""
CHASSIS_IMPORTS = {module: imports_within(module, CHASSIS) for module in CHASSIS}


@pytest.mark.parametrize("module", sorted(CHASSIS))
def test_no_two_files_of_the_chassis_need_each_other(module: str) -> None:
    """Imports for types count, too: what is used below is handed down, or described by a protocol."""
    cycle = {
        other for other in reachable(module, CHASSIS_IMPORTS) if module in reachable(other, CHASSIS_IMPORTS)
    }
    assert cycle <= TWO_FACES, sorted(cycle)


@pytest.mark.parametrize("module", sorted(CHASSIS))
def test_only_the_command_imports_the_command(module: str) -> None:
    """What the page, the fleet or the library shares with it sits lower."""
    if module == "woosh_pure.__main__" or module.startswith("woosh_pure.cli"):
        return
    commands = {name for name in CHASSIS_IMPORTS[module] if name.startswith("woosh_pure.cli")}
    assert not commands, sorted(commands)


CHASSIS_FLOORS = [
    "enums firmware geometry interface lease reasons",
    "faults",
    "language outcome values",
    "errors maps",
    "connection",
    "feed",
    "doctor readiness stopping",
    "core",
    "motion readings velocity",
    "peripherals sim",
    "chassis",
    "aio fleet foxglove selftest web woosh_pure",
    "cli pytest_plugin",
    "__main__",
]
"""The rooms of woosh_pure from the ground up: folders, and files that stand in none. `woosh_pure` is its face."""
FLOOR_OF = {room: floor for floor, rooms in enumerate(CHASSIS_FLOORS) for room in rooms.split()}


def chassis_room(module: str) -> str:
    """ "stopping" of woosh_pure.stopping.line; "woosh_pure" of the package's own face."""
    return module.split(".")[1] if "." in module else module


def test_the_floors_of_the_chassis_name_every_room_once() -> None:
    named = " ".join(CHASSIS_FLOORS).split()
    assert sorted(named) == sorted({chassis_room(module) for module in CHASSIS})


@pytest.mark.parametrize("module", sorted(CHASSIS))
def test_a_room_of_the_chassis_imports_lower_floors_only(module: str) -> None:
    """Late imports and those for types count, too: whoever reads a room has to know only what is below it."""
    if module in TWO_FACES:
        return
    own = chassis_room(module)
    wrong = {
        other
        for other in CHASSIS_IMPORTS[module]
        if chassis_room(other) != own and FLOOR_OF[chassis_room(other)] >= FLOOR_OF[own]
    }
    assert not wrong, sorted(wrong)


def test_what_is_covered_by_branches_is_there() -> None:
    """A file that was moved would not be measured any more, and nobody would notice."""
    table = (
        (ROOT / "pyproject.toml").read_text("utf-8").partition("[tool.coverage.run]")[2].partition("\n[")[0]
    )
    patterns = re.findall(r'"([^"]+)"', table)
    assert len(patterns) > 5
    assert [pattern for pattern in patterns if not list(ROOT.glob(pattern))] == []
